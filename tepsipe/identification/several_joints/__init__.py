"""Impedance of several joints at once: matrices of stiffness and damping."""
