"""Rigid-body mechanics of joint, leg, foot and standing person: arrays in, arrays out."""
