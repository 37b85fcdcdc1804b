"""Calibrate a treadmill from two recordings of its unloaded, accelerated belt, and compensate a third.

    python examples/calibrate_treadmill.py

The treadmill is simulated here: the belt's acceleration adds a pitch moment through a resonant frame.
"""

from typing import TYPE_CHECKING

import numpy as np

from tepsipe import belt_recording, calibrate_treadmill, load_treadmill_models, lowpass

if TYPE_CHECKING:
    from tepsipe.treadmill.recording import BeltRecording

RATE_HZ = 100.0


def recorded(seed: int, name: str, duration_s: float = 120.0) -> "BeltRecording":
    """An unloaded treadmill at 1.2 m/s under random accelerations: moment (Nm) and belt velocity (m/s)."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, duration_s, 1.0 / RATE_HZ)
    velocity = 1.2 + 0.1 * lowpass(rng.standard_normal(time.size), RATE_HZ, cutoff_hz=8.0)
    acceleration = np.gradient(velocity, time)
    moment, rate = np.zeros_like(time), 0.0
    for k in range(1, time.size):  # a frame of 12 Hz, damped by 20 %
        w = 2.0 * np.pi * 12.0
        rate += (w**2 * (5.0 * acceleration[k - 1] - moment[k - 1]) - 0.4 * w * rate) / RATE_HZ
        moment[k] = moment[k - 1] + rate / RATE_HZ
    return belt_recording(time, moment + 0.3 * rng.standard_normal(time.size), velocity, unit="Nm", name=name)


calibration = calibrate_treadmill(recorded(1, "first"), recorded(2, "second"), models=["hnat2014", "fir"])
print(calibration.summary())
calibration.plot().savefig("calibrate_treadmill.png")

calibration.save("treadmill_models.json")
models = load_treadmill_models("treadmill_models.json")
third = recorded(3, "third").filtered(models["fir"].lowpass)
rest = models["fir"].compensate(third)
print(f"third recording: {third.load.std():.2f} Nm as measured, {rest.std():.2f} Nm compensated")
