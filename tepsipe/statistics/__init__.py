"""Least squares, bootstrap and goodness of fit."""
