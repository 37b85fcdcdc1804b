"""Forward simulation of the ankle dummy, compared with its recordings."""
