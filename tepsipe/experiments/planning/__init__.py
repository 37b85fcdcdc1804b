"""Prediction of the precision of an experiment on the treadmill."""
