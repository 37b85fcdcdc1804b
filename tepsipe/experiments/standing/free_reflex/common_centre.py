"""Common centre of the ankle of all trials of a task, from quiet sway and palpation.

Quiet sway gives the offset m_j of the centre from the palpated one, with a standard error s_j, in trial j. A
person has one centre, so the mean m over J trials has the standard error s = sqrt(mean s_j^2 / J). With the
standard uncertainty u_p of palpation, the weighted mean of both and its uncertainty are

    c = w m,     w = (1 / s^2) / (1 / s^2 + 1 / u_p^2),     u(c) = (1 / s^2 + 1 / u_p^2)^-1/2

for each coordinate. With much noise of the cameras c is the palpated centre, with little noise that of sway.
Trials whose foot turns in quiet sway do not count. Responses follow the centre to first order, by their
slopes.
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.experiments.standing.free_reflex.broadband import FAR_M, BroadbandEpochs, is_steady
from tepsipe.statistics.uncertainty import Source

PALPATED = "palpated_centre_m"
CENTRE = ("joint_centre_anterior_m", "joint_centre_height_m")
# smallest share of the trials that must determine a centre
SHOWN = 0.5


@dataclass(frozen=True)
class CommonCentre:
    """Centre of the ankle of a task."""

    offset_m: Annotated[np.ndarray, "(2,)"]
    error_m: Annotated[np.ndarray, "(2,)"]
    """Offset from the palpated centre, anterior and upward, and its standard uncertainty."""
    from_sway: bool
    """True if sway counts more than palpation in both coordinates."""


def common_centre(trials: list[BroadbandEpochs], sources: dict[str, Source]) -> CommonCentre:
    """Weighted mean of the centre from quiet sway and the palpated one.

    sources: uncertain constants; without `PALPATED` sway alone counts.
    Returns: with an infinite uncertainty if neither determines the centre.
    """
    centres = [t.centre for t in trials if t.centre is not None and is_steady(t.centre)]
    offset, error = np.zeros(2), np.full(2, np.inf)
    if trials and len(centres) >= max(1.0, SHOWN * len(trials)):
        # responses to opposite perturbations of one trial share its quiet standing, and so its centre
        centres = list({(*centre.offset_m, *centre.standard_error_m): centre for centre in centres}.values())
        squares = np.mean([centre.standard_error_m**2 for centre in centres], axis=0) / len(centres)
        mean = np.mean([centre.offset_m for centre in centres], axis=0)
        if np.hypot(*mean) < FAR_M + 2.0 * np.sqrt(squares.sum()):
            offset, error = mean, np.sqrt(squares)
    if PALPATED not in sources:
        return CommonCentre(offset, error, bool(np.isfinite(error).all()))
    palpated = sources[PALPATED].standard_uncertainty
    precision = error**-2.0 + palpated**-2.0
    return CommonCentre(offset * error**-2.0 / precision, precision**-0.5, bool((error < palpated).all()))


def with_common_centre(
    trials: list[BroadbandEpochs], sources: dict[str, Source]
) -> tuple[list[BroadbandEpochs], list[Source]]:
    """Trials about their common centre, and sources with the uncertainty of this centre.

    sources: uncertain constants, among them `PALPATED`, and `CENTRE` for errors that all centres from sway
    have in common.

    Returns:
        trials: with responses about the common centre (rad, N·m).
        sources: the sources without `PALPATED`; `CENTRE` includes the uncertainty of the common centre (m).
    """
    centre = common_centre(trials, sources)
    of_centre = dict(zip(CENTRE, centre.error_m.tolist(), strict=True))
    known = []
    for name, source in sources.items():
        u = of_centre.get(name, 0.0)
        if name != PALPATED:
            both = float(np.hypot(source.standard_uncertainty, u)) if np.isfinite(u) else None
            known.append(source if both is None else replace(source, standard_uncertainty=both))
    return [_about(trial, centre.offset_m) for trial in trials], known


def _about(trial: BroadbandEpochs, offset_m: np.ndarray) -> BroadbandEpochs:
    """Trial about a centre of the joint that is given relative to the palpated one (m)."""
    present = trial.centre.offset_m if trial.centre is not None and trial.centre_used else np.zeros(2)
    change = sum(d * trial.slopes[name] for name, d in zip(CENTRE, offset_m - present, strict=True))
    return replace(trial, perturbed=trial.perturbed + change)
