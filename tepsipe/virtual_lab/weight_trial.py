"""One trial with the weight, or with the empty belt, from protocol and truth to raw files."""

from pathlib import Path

from tepsipe.virtual_lab.belt import DriveTruth
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_trial import (
    INTEGRATION_RATE_HZ,
    record_capture,
    record_log,
    schedule_trial,
)
from tepsipe.virtual_lab.weight import MARKERS, WeightTruth, move_weight, weight_marker_paths


def make_weight_trial(
    truth: dict,
    condition: str,
    profile: str,
    amplitude_m_per_s: float,
    interval_s: float,
    duration_s: float,
    log: Path,
    calibration: Path,
    markers: Path | None = None,
) -> None:
    """Make one trial with the weight on the belt, or with nothing on it.

    Parameters
    ----------
    truth : dict
        The laboratory's constants, as its configuration file holds them (units in the keys), with the section
        ``weight`` or ``heavy_weight``.
    condition : str
        Name of the condition: it seeds the trial's noise.
    profile : {"sine", "negative-sine", "minjerk"}
        Shape of the perturbations.
    amplitude_m_per_s, interval_s, duration_s : float
        Velocity amplitude (m/s), time between perturbations (s), length of the trial (s).
    log, calibration : Path
        Files to write: treadmill log and calibration matrix.
    markers : Path, optional
        C3D file of the weight's markers to write; None leaves the belt empty.
    """
    seed, rig = truth["seed"], truth["treadmill"]
    weight = None if markers is None else WeightTruth(**truth.get("weight", truth.get("heavy_weight")))
    rng = generator(seed, "empty" if weight is None else "weight", condition)
    rest_after_s = rig["protocol"]["rest_after_weight_s"]
    schedule = schedule_trial(rig, profile, amplitude_m_per_s, interval_s, duration_s, rest_after_s, rng)
    drive = DriveTruth(**rig["drive"])
    motion = move_weight(weight, drive, schedule.command, schedule.ends_s, INTEGRATION_RATE_HZ)
    load_kg = 0.0 if weight is None else weight.mass_kg
    record_log(rig, seed, schedule, motion, load_kg, rng, log, calibration)
    if weight is not None:
        record_capture(rig, schedule, MARKERS, weight_marker_paths(weight, motion), rng, markers)
