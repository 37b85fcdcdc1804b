"""TEP-SIPE on the ankle dummy."""
