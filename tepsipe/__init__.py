"""Joint impedance from transient endpoint perturbations (TEP-SIPE)."""

__version__ = "0.1.0"
