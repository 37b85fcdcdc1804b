"""A human joint in a position-controlled manipulator."""
