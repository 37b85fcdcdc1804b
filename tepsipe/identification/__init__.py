"""Estimators of joint impedance: arrays in, parameters out."""
