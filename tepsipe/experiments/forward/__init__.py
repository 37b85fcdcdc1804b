"""The ankle dummy in a forward simulation, beside its recordings."""
