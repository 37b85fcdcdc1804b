"""Agreement between simulations and recordings: the rows of ``results/tables/forward.csv``."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tepsipe.io.tables import Table, Undefinable

EQUATIONS = "equations"
# sets of parameters that the thesis compares: an engine moves them that shares no equation with the analysis
COMPARED_BY_THESIS = ("wristalyzer", "tep", "thesis-wristalyzer", "thesis-tep")


def engine_of(parameter_set: str, engine: str) -> str:
    """Engine that moves the dummy with a set of parameters; ``engine`` is the study's."""
    return engine if parameter_set in COMPARED_BY_THESIS else EQUATIONS


@dataclass(frozen=True)
class ForwardScore:
    """Agreement between a simulation and a recording."""

    condition: str
    parameter_set: str
    engine: str
    """Engine that moved the leg."""
    quantity: str
    """{"theta", "tau", "tau_consistent", "f_y"}: The angle, a torque by inverse dynamics, or the measured
    fore-aft force with the belt-induced force in it."""
    vaf_perturbation: Annotated[float, "%"]
    vaf_trial: Annotated[float, "%"]
    """Mean VAF of the perturbations and VAF of the trial, thesis eq (3-1)."""
    state: str
    """Whether the simulated leg settles, grows or falls."""
    growth: Undefinable
    """Largest swing after a perturbation relative to the swing after the first one; undefined if the leg
    falls."""


FORWARD_SCORES = Table(ForwardScore, "scores of simulations")


def swing_sizes(theta: np.ndarray, windows: Sequence[tuple[int, int]]) -> list[float]:
    """Size of the swing (rad) after every perturbation of a trial, at least two.

    It is the largest abs(theta) from the end of the perturbation to the onset of the next one; after the last
    perturbation it is sought for as long as after the one before.

    theta: angle from rest (rad), NaN after a fall.
    windows: first sample of every perturbation and the sample after its last.
    Returns: infinite after a fall.
    """
    starts, stops = zip(*windows, strict=True)
    ends = [*starts[1:], stops[-1] + starts[-1] - stops[-2]]
    between = [np.abs(theta[stop:end]) for stop, end in zip(stops, ends, strict=True)]
    sizes = [float(angle.max()) for angle in between if angle.size]
    return [size if np.isfinite(size) else np.inf for size in sizes]
