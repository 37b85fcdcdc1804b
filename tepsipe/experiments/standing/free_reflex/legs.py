"""Each leg of a person who stands with one foot on each of two force plates.

The torque of both ankles is the sum over the plates, and is what the recommended estimate is fitted to.
Here the torque of each leg follows from its own plate, the treadmill model of that plate, and half of the
feet. The markers are on one leg: the angle of the other is taken to be the same, and both ankles to be at the
same place along the belts. B and K of a leg are its parts of B and K of both.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from tepsipe.experiments.budgets import contributions_of, rows_of
from tepsipe.experiments.standing.epochs import StandingEpochs
from tepsipe.experiments.standing.estimates import Fits
from tepsipe.experiments.standing.free_reflex.broadband import (
    GROUPS,
    BroadbandEpochs,
    broadband_of,
    broadband_result,
    cut_broadband,
    with_treadmill_error,
)
from tepsipe.experiments.standing.free_reflex.fit import QUANTITIES
from tepsipe.experiments.standing.joint_torque import StandingTrial, by_belt
from tepsipe.experiments.standing.options import BOTH, OTHER_BELT, EpochOptions, StandingOptions
from tepsipe.identification.result import Quantity
from tepsipe.io.estimates import Contribution, Estimate
from tepsipe.io.result import Result
from tepsipe.signals.filters import Lowpass
from tepsipe.treadmill.held_out import HeldOut
from tepsipe.treadmill.registry import FittedModel

LEGS = tuple(OTHER_BELT)


def cut_with_legs(
    standing: StandingTrial,
    epochs: StandingEpochs,
    options: StandingOptions,
    cutting: EpochOptions,
    lowpass: Lowpass,
    models: dict[str, FittedModel],
    held_out: Mapping[str, HeldOut | None],
    window_s: float,
) -> dict[str, BroadbandEpochs]:
    """Epochs of both legs together and of each leg on a plate of its own.

    standing, epochs, options, cutting, lowpass, models: as for `cut_broadband`.
    held_out: belt -> residuals of trials that the model of its plate has not seen.
    window_s: length of the fitted window.
    Returns: `BOTH` -> epochs of both legs; for a person with a foot on each belt also each belt -> epochs
    of its leg. Empty if no perturbation is usable.
    """
    whole = cut_broadband(standing, epochs, options, cutting, lowpass, models)
    if whole is None:
        return {}
    height = options.person.ankle_height_m

    def predicted(part: BroadbandEpochs, belt: str) -> BroadbandEpochs:
        known = held_out.get(belt)
        return part if known is None else with_treadmill_error(part, epochs, known, height, window_s)

    if options.belt != BOTH:
        return {BOTH: predicted(whole, options.belt)}
    of_plates, legs = by_belt(models, options), {}
    for belt in options.belts:
        own = options.of_leg(belt)
        leg = cut_broadband(standing, epochs, own, cutting, lowpass, of_plates.get(belt, {}))
        legs[belt] = predicted(leg, belt)
    return {BOTH: _with_errors_of(legs, whole), **legs}


def _with_errors_of(legs: dict[str, BroadbandEpochs], whole: BroadbandEpochs) -> BroadbandEpochs:
    """Epochs of both legs with the sums of what the models of the plates leave (N·m, N·m/rad)."""
    errors = [leg.treadmill_error for leg in legs.values()]
    if None in errors:
        return whole
    total = float(sum(error for error, _ in errors)), float(np.hypot(*(u for _, u in errors)))
    worse = max(legs.values(), key=lambda leg: abs(leg.treadmill_error[0]) + leg.treadmill_error[1])
    left = [leg.misfit for leg in legs.values()]
    misfit = np.concatenate([sum(x[:1] for x in left), *(x[1:] for x in left)])
    return replace(whole, treadmill_error=total, misfit=misfit, treadmill_flag=worse.treadmill_flag)


def legs_results(cut: list[dict[str, BroadbandEpochs]]) -> list[Result]:
    """Epochs of every direction of the belt, of both legs and of each, as parts of a result's file."""
    return [
        broadband_result(epochs, _group(group, belt))
        for group, of_direction in zip(GROUPS, cut, strict=False)
        for belt, epochs in of_direction.items()
    ]


def legs_of(results: list[Result]) -> tuple[list[BroadbandEpochs], dict[str, list[BroadbandEpochs]]]:
    """Epochs of both legs, and leg -> its own, from files of `legs_results`; none of legs on one plate."""
    found = {
        belt: [
            epochs
            for result in results
            for group in GROUPS
            if (epochs := broadband_of(result, _group(group, belt))) is not None
        ]
        for belt in (BOTH, *LEGS)
    }
    return found.pop(BOTH), {belt: epochs for belt, epochs in found.items() if epochs}


def leg_rows(
    condition: str,
    legs: Mapping[str, list[BroadbandEpochs]],
    fit: Callable[[list[BroadbandEpochs]], Fits],
) -> tuple[list[Estimate], list[Contribution]]:
    """B and K of each leg, and its part of the weight, as rows beside those of both legs.

    condition: trial or task.
    legs: leg -> its responses in every trial; may be empty.
    fit: `fit_free` with the choices of the fit to both legs together.

    Returns:
        rows: ``B_left`` (N·m·s/rad), ``K_left`` (N·m/rad), ``weight_share_left`` and the same of the right
        leg.
        contributions: their uncertainty.
    """
    rows, contributions = [], []
    mass_kg = {leg: float(np.mean([trial.carried_kg for trial in of_leg])) for leg, of_leg in legs.items()}
    for leg, of_leg in legs.items():
        for key, fitted in fit(of_leg).items():
            names = ("standing", condition, *key)
            quantities = {f"{quantity}_{leg}": fitted.quantities[quantity] for quantity in QUANTITIES}
            share = {f"weight_share_{leg}": Quantity(mass_kg[leg] / sum(mass_kg.values()), "1")}
            rows += rows_of(names, quantities | share, fitted.responses)
            contributions += contributions_of(names, quantities)
    return rows, contributions


def _group(group: str, belt: str) -> str:
    return f"{group}_{belt}" if belt in LEGS else group
