"""Fit of a dummy to the thesis's printed tables, and what it gives for each printed number."""

from collections.abc import Mapping

import numpy as np

from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.thesis_dummy.inverse import (
    JOINTS,
    CellRow,
    PrintedPath,
    belt_motion,
    cell_rows,
    copied_rms,
    fit_marker_noise,
    fit_result,
    fit_tables,
    printed_and_predicted,
    swings,
)
from tepsipe.experiments.thesis_dummy.timing import linear_joint, timing_facts
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.mechanics.impedance_model import PARAMETERS

# frames per step of the search while the belt rests: means change by at most 0.0013 of their scatter from
# those of steps of one frame
STEP_AT_REST = 8


def fit(
    trials: Mapping[str, Trial],
    section: dict,
    tables: list[list[str]],
    printed: dict[str, dict[str, float]],
    followed: dict[str, dict[str, float]],
    seed: int,
) -> tuple[Result, list[CellRow]]:
    """Constants of every law of the joint, and printed beside predicted numbers.

    trials: condition -> trial of the dummy, whose belt moves the fitted one.
    section: settings of the dummy.
    tables: conditions of each printed table.
    printed: quantity -> condition -> printed number.
    followed: name of a linear joint of the thesis -> its I, B, K.
    """
    path = _printed_path(section, next(iter(trials.values())).rate_hz)
    searched_s, draws = (section["thesis_dummy"][key] for key in ("searched_s", "draws"))
    belts = {name: belt_motion(trial, path) for name, trial in trials.items()}
    # the search needs not all pulses
    shorter = {name: belt_motion(trial, path, searched_s, STEP_AT_REST) for name, trial in trials.items()}
    fitted = [name for table in tables for name in table]
    fits = {law: fit_tables(path, shorter, printed, tables, fixed) for law, fixed in JOINTS.items()}
    full = list(fits.values())[-1]
    swung = swings(path, [full.joint], belts)
    angles = {name: swung[name](belt.time)[:, 0] for name, belt in belts.items()}
    noise = fit_marker_noise(path, belts, angles, printed["VAF_trial"], fitted, seed)
    cells = printed_and_predicted(path, belts, angles, printed, fitted, noise, draws, seed)
    joints = tuple(
        linear_joint(*(followed[name][quantity] for quantity in PARAMETERS))
        for name in ("thesis-wristalyzer", "thesis-without-handle")
    )
    timing = timing_facts(path, shorter, printed, full, joints)
    return fit_result(fits, noise, copied_rms(printed, tables), timing), cell_rows(cells)


def _printed_path(section: dict, rate_hz: float) -> PrintedPath:
    options = DummyOptions.from_settings(section["geometry"], section["analysis"])
    labels, sampling_hz = section["files"]["marker_labels"], section["ingest"]["marker_sampling_hz"]
    order = [labels.index(label) for label in options.leg_markers.labels]
    return PrintedPath(
        leg=options.leg,
        markers=options.leg_markers,
        sampled_after_s=np.array(order) / sampling_hz if sampling_hz else np.zeros(len(order)),
        rate_hz=rate_hz,
        cutoff_hz=options.lowpass_cutoff_hz,
        order=options.lowpass_order,
        window=options.window,
    )
