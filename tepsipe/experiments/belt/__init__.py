"""A recorded treadmill without a rig: models of its belt-induced load."""
