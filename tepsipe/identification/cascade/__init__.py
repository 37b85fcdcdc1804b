"""Parallel-cascade models of a human joint: intrinsic stiffness, stretch reflex, short-range stiffness."""
