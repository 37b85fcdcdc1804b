"""Fit of one trial of the position-controlled manipulator."""

import numpy as np

from tepsipe.experiments.fitted import Fitted, checked
from tepsipe.experiments.position_manipulator.analysis import (
    analyse_position_manipulator,
    cascade_record,
    parallel_cascade_estimates,
    position_manipulator_estimates,
    position_manipulator_result,
)
from tepsipe.experiments.position_manipulator.diagnostics import diagnose
from tepsipe.experiments.position_manipulator.options import PositionManipulatorOptions
from tepsipe.identification.cascade.checks import failed_checks
from tepsipe.identification.cascade.options import ParallelCascadeOptions
from tepsipe.identification.cascade.parallel_cascade import identify_cascade
from tepsipe.identification.cascade.record import CascadeRecord
from tepsipe.io.result import joined
from tepsipe.io.trial import Trial


def _options(section: dict) -> tuple[PositionManipulatorOptions, ParallelCascadeOptions]:
    choices = dict(section["analysis"])
    reflex = ParallelCascadeOptions(**choices.pop("parallel_cascade"))
    return PositionManipulatorOptions(**choices), reflex


def begin(trial: Trial, section: dict, name: str) -> CascadeRecord:
    """Filtered record, with which `analyse_parallel_cascade` begins (rad, N·m)."""
    return cascade_record(trial, *_options(section))[0]


def fit(trial: Trial, section: dict, condition: str, seed: int) -> Fitted:
    """Impedance and I, B, K by regression; intrinsic and reflex pathway by the parallel cascade."""
    options, reflex = _options(section)
    rng = np.random.default_rng(seed)
    found = analyse_position_manipulator(trial, options, rng)
    record, block = cascade_record(trial, options, reflex)
    cascade = identify_cascade(record, block, options.bootstrap_draws, rng)
    names = ("position_manipulator", condition)
    rows = position_manipulator_estimates(*names, found) + parallel_cascade_estimates(*names, cascade)
    return Fitted(
        joined(position_manipulator_result(found, cascade), diagnose(trial, options, found, cascade)),
        checked(trial, rows, *failed_checks(record, cascade)),
    )
