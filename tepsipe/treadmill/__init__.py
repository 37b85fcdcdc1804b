"""Models of the belt-induced load: what an accelerating treadmill adds to the measured load."""
