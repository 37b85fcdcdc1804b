"""Agreement between simulations and recordings: the rows of ``results/tables/forward.csv``."""

from dataclasses import dataclass

from tepsipe.io.tables import Table, Undefinable


@dataclass(frozen=True)
class ForwardScore:
    """Agreement between a simulation and a recording.

    Attributes
    ----------
    condition, parameter_set : str
        The trial and the set of parameters.
    quantity : {"theta", "tau", "tau_consistent"}
        The angle, or a torque by inverse dynamics.
    vaf_perturbation, vaf_trial : float
        Mean VAF of the perturbations and VAF of the trial, thesis eq (3-1) (%).
    state : str
        Whether the simulated leg settles, grows or falls.
    growth : float
        Largest swing after a perturbation relative to the swing after the first one; undefined if the leg
        falls.
    """

    condition: str
    parameter_set: str
    quantity: str
    vaf_perturbation: float
    vaf_trial: float
    state: str
    growth: Undefinable


FORWARD_SCORES = Table(ForwardScore, "scores of simulations")
