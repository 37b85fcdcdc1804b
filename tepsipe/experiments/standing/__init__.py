"""A person standing on the treadmill."""
