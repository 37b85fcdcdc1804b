"""A person standing on a moving platform: impedance of ankle and hip."""
