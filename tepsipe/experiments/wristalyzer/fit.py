"""Fit of one trial of the torque-controlled manipulator."""

import numpy as np

from tepsipe.arguments import options_of
from tepsipe.experiments.fitted import Fitted
from tepsipe.experiments.wristalyzer.analysis import (
    analyse_wristalyzer,
    wristalyzer_record,
    wristalyzer_result,
    wristalyzer_rows,
)
from tepsipe.experiments.wristalyzer.options import WristalyzerOptions
from tepsipe.experiments.wristalyzer.record import WristalyzerRecord
from tepsipe.io.trial import Trial
from tepsipe.statistics.uncertainty import sources_of


def _options(section: dict) -> WristalyzerOptions:
    known = WristalyzerOptions.__dataclass_fields__
    return options_of(WristalyzerOptions, {k: x for k, x in section["analysis"].items() if k in known})


def begin(trial: Trial, section: dict, name: str) -> WristalyzerRecord:
    """Record with its timing corrected, as `analyse_wristalyzer` takes it (N·m, rad)."""
    return wristalyzer_record(trial, _options(section))[0]


def fit(trial: Trial, section: dict, condition: str, seed: int, uncertainty: dict) -> Fitted:
    """Admittance, and I, B, K by every estimator.

    uncertainty: sources, as `sources_of` takes them.
    """
    rng = np.random.default_rng(seed)
    found = analyse_wristalyzer(trial, _options(section), rng, sources_of(uncertainty))
    return Fitted(wristalyzer_result(found), *wristalyzer_rows(condition, found))
