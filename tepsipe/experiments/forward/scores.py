"""Agreement between simulations and recordings: the rows of ``results/tables/forward.csv``."""

from dataclasses import dataclass
from typing import Annotated

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
    """{"theta", "tau", "tau_consistent"}: The angle, or a torque by inverse dynamics."""
    vaf_perturbation: Annotated[float, "%"]
    vaf_trial: Annotated[float, "%"]
    """Mean VAF of the perturbations and VAF of the trial, thesis eq (3-1)."""
    state: str
    """Whether the simulated leg settles, grows or falls."""
    growth: Undefinable
    """Largest swing after a perturbation relative to the swing after the first one; undefined if the leg
    falls."""


FORWARD_SCORES = Table(ForwardScore, "scores of simulations")
