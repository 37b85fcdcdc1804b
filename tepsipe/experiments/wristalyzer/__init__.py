"""Torque-controlled manipulator (thesis sections 3-1-1 and 4-1-1)."""
