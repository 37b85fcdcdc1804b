"""The public functions of a treadmill: calibrated, compensated, kept in a file, refused in one sentence."""

import numpy as np
from builders import refused
from scipy.signal import butter, sosfiltfilt

from tepsipe import belt_recording, calibrate_treadmill, load_treadmill_models

RATE_HZ = 100.0


def belt(seed, name="", unit="Nm"):
    rng, low = np.random.default_rng(seed), butter(2, 5.0, fs=RATE_HZ, output="sos")
    time = np.arange(0.0, 60.0, 1.0 / RATE_HZ)
    velocity = 1.2 + 0.1 * sosfiltfilt(low, rng.standard_normal(time.size))
    load = 6.0 * np.gradient(velocity, time) + 0.05 * rng.standard_normal(time.size)
    return belt_recording(time, load, velocity, unit=unit, name=name or f"recording {seed}")


def test_calibrated_treadmill_is_compensated_and_kept(tmp_path):
    found = calibrate_treadmill(belt(1), belt(2), models=["mass-spring-damper", "fir"])
    assert all(score.r2 > 0.97 for score in found.scores)
    third = belt(3)
    rest = found.compensate(third, "fir")
    assert rest.std() < 0.1 * third.load.std()
    found.save(tmp_path / "models.json")
    kept = load_treadmill_models(tmp_path / "models.json")["fir"]
    assert kept.compensate(third.filtered(kept.lowpass)).tolist() == rest.tolist()
    assert f"Recommended: {found.recommended}" in found.summary()
    assert set(found.to_frame().model) == {"mass-spring-damper", "fir"}
    assert found.plot().axes
    refused(lambda: found.compensate(third.load, "fir"), "compensate", "belt_recording")
    refused(lambda: found.save(tmp_path), str(tmp_path), "found a folder")
    refused(lambda: found.save(tmp_path / "none" / "models.json"), "no such folder")


def test_recordings_that_cannot_calibrate_are_refused():
    refused(lambda: calibrate_treadmill(belt(1), belt(1)), "two separate recordings")
    refused(lambda: calibrate_treadmill(belt(1), belt(1, "a copy")), "the same load in both")
    refused(lambda: calibrate_treadmill(belt(1), belt(2), models=["firr"]), "'firr'")
    refused(lambda: calibrate_treadmill(belt(1), belt(2), fir_lags=1.0), "'fir_lags'")
    refused(lambda: calibrate_treadmill(belt(1).load, belt(2)), "belt_recording")
    refused(lambda: calibrate_treadmill(belt(1), belt(2, unit="N")), "Nm", "found N")
    refused(lambda: belt(1, unit="kg"), "Nm or N", "'kg'")
    refused(lambda: calibrate_treadmill(belt(1), belt(2)).compensate(belt(3), "frame"), "'frame'")
