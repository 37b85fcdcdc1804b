"""Agreement between simulations and recordings: the rows of ``results/tables/forward.csv``."""

from dataclasses import dataclass
from typing import Annotated

from tepsipe.io.tables import Table, Undefinable


@dataclass(frozen=True)
class ForwardScore:
    """Agreement between a simulation and a recording."""

    condition: str
    parameter_set: str
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
