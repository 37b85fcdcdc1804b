"""One trial with the weight, or with the empty belt, from protocol and truth to raw files."""

from pathlib import Path

from tepsipe.virtual_lab.belt import DriveTruth
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_trial import (
    INTEGRATION_RATE_HZ,
    Protocol,
    record_capture,
    record_log,
    schedule_trial,
)
from tepsipe.virtual_lab.weight import MARKERS, WeightTruth, move_weight, weight_marker_paths


def make_weight_trial(
    truth: dict, condition: str, protocol: Protocol, files: dict[str, Path], belt: str = "right"
) -> None:
    """Make one trial with the weight on the belt, or with the empty belt.

    truth: the laboratory's constants, as its configuration file holds them, with the section ``weight`` or
    ``heavy_weight``.
    condition: name of the condition: it seeds the trial's noise.
    files: files to write: ``log`` and ``calibration``, and ``markers`` of the weight, without which the
    belt is empty.
    belt: {"left", "right"}: The belt that moves.
    """
    seed, rig = truth["seed"], truth["treadmill"]
    weight = None
    if "markers" in files:
        weight = WeightTruth(**truth.get("weight", truth.get("heavy_weight")))
    rng = generator(seed, "empty" if weight is None else "weight", condition)
    rest_after_s = rig["protocol"]["rest_after_weight_s"]
    schedule = schedule_trial(rig, protocol, rest_after_s, rng)
    drive = DriveTruth(**rig["drive"])
    motion = move_weight(weight, drive, schedule.command, schedule.ends_s, INTEGRATION_RATE_HZ)
    load_kg = 0.0 if weight is None else weight.mass_kg
    record_log(rig, seed, schedule, {belt: (motion, load_kg)}, rng, files)
    if weight is not None:
        record_capture(rig, schedule, MARKERS, weight_marker_paths(weight, motion), rng, files["markers"])
