"""TEP-SIPE on simulated data with measurement noise."""
