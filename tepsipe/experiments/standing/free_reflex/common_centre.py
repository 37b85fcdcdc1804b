"""The centre of the ankle of all trials of a task: it is that of one person.

Quiet sway shows the centre of the joint with a standard error s_j in trial j. Over J trials, and with what
was felt at the malleoli, whose standard uncertainty is u_p,

    c = w m,     w = (1 / s^2) / (1 / s^2 + 1 / u_p^2),     u(c) = (1 / s^2 + 1 / u_p^2)^-1/2

counts from the centre that was felt, with the mean m of the trials and s^2 = mean of s_j^2 / J. Much noise of
the cameras leaves the centre where it was felt, little noise where sway shows it, without a limit between
both. Trials whose foot turns show no centre. Responses and their slopes follow to first order.
"""

from dataclasses import replace

import numpy as np

from tepsipe.experiments.standing.free_reflex.broadband import FAR_M, BroadbandEpochs, is_steady
from tepsipe.statistics.uncertainty import Source

PALPATED = "palpated_centre_m"
CENTRE = ("joint_centre_anterior_m", "joint_centre_height_m")
# smallest share of the trials that must show a centre (-)
SHOWN = 0.5


def with_common_centre(
    trials: list[BroadbandEpochs], sources: dict[str, Source]
) -> tuple[list[BroadbandEpochs], list[Source]]:
    """The trials about their common centre, and the sources with its uncertainty.

    Parameters
    ----------
    trials : list of BroadbandEpochs
        Of one person (rad, N·m).
    sources : dict of str to Source
        With `PALPATED`, the centre that is felt, and `CENTRE`, what remains of the one that sway shows (m).

    Returns
    -------
    trials : list of BroadbandEpochs
        With responses about the common centre (rad, N·m).
    sources : list of Source
        `CENTRE` with the uncertainty of the common centre (m), and all others but `PALPATED`.
    """
    felt = sources.get(PALPATED)
    others = [source for name, source in sources.items() if name not in (PALPATED, *CENTRE)]
    shown = [t.centre for t in trials if t.centre is not None and is_steady(t.centre)]
    offset, error = np.zeros(2), np.full(2, np.inf)
    if trials and len(shown) >= max(1.0, SHOWN * len(trials)):
        squares = np.array([centre.standard_error_m**2 for centre in shown]).mean(axis=0) / len(shown)
        mean = np.mean([centre.offset_m for centre in shown], axis=0)
        if np.hypot(*mean) < FAR_M + 2.0 * np.sqrt(squares.sum()):
            offset, error = mean, np.sqrt(squares)
    if felt is not None:
        precision = error**-2.0 + felt.standard_uncertainty**-2.0
        offset, error = offset * error**-2.0 / precision, precision**-0.5
    known = []
    for name, u in zip(CENTRE, error.tolist(), strict=True):
        if name in sources and np.isfinite(u):
            both = float(np.hypot(sources[name].standard_uncertainty, u))
            known.append(replace(sources[name], standard_uncertainty=both))
        elif name in sources:
            known.append(sources[name])
    return [_about(trial, offset) for trial in trials], others + known


def _about(trial: BroadbandEpochs, offset_m: np.ndarray) -> BroadbandEpochs:
    """Responses of a trial about another centre of the joint (m from the one that was felt)."""
    used = trial.centre.offset_m if trial.centre is not None and trial.centre_used else np.zeros(2)
    moved = sum(step * trial.slopes[name] for name, step in zip(CENTRE, offset_m - used, strict=True))
    return replace(trial, perturbed=trial.perturbed + moved)
