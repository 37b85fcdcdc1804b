"""Builders of what a force plate of the virtual laboratory is given."""

import numpy as np

from tepsipe.virtual_lab.belt import BeltMotion
from tepsipe.virtual_lab.force_plate import Loaded, voltages_of_belts


def pressed(reaction, rate_hz, velocity=None, acceleration=None):
    """Motion of a frame that stands still under a known wrench (N, N·m)."""
    still = np.zeros(len(reaction))
    velocity = still if velocity is None else velocity
    acceleration = still if acceleration is None else acceleration
    time = np.arange(len(reaction)) / rate_hz
    return BeltMotion(time, still, velocity, acceleration, still, still, still, reaction)


def plate_voltages(plate, volts_per_newton, motion, sample, rng):
    """Voltages (V) of the 14 channels with the load on the right belt."""
    return voltages_of_belts({"right": Loaded(plate, motion)}, volts_per_newton, sample, rng)
