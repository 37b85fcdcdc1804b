"""Models of the load that an accelerating treadmill adds to what its force sensors measure."""
