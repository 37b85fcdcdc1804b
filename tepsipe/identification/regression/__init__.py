"""Estimators that compare an equation of motion with one record of signals, sample by sample."""
