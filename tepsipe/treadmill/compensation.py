"""The load on the belt from the measured one: best estimate, and draws from the models' calibration.

The constants of a treadmill model are estimates from a few calibration trials. The attribute ``deviations``
of `tepsipe.treadmill.registry.FittedModel` holds draws of their errors, the same draw in the same row for
fore-aft force and pitch moment. Each draw gives different compensated loads, joint torques and parameters;
their spread is the contribution of the calibration to the uncertainty. It counts as Type B, because
repetition of the trial does not reduce it; this departs from the letter of JCGM 100, which calls every
statistical evaluation Type A.
"""

from dataclasses import replace

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.registry import FittedModel

# step of a constant for the derivative by it, as a fraction of its standard deviation
STEP = 0.1


def compensated_loads(
    models: dict[str, FittedModel], recordings: dict[str, BeltRecording]
) -> dict[str, np.ndarray]:
    """Measured loads of one trial less the belt-induced ones.

    models: component of the load, Fy or Mx -> its model.
    recordings: component -> recording of the trial, filtered as in the calibration.
    Returns: component -> load (N, N·m).
    """
    for component in recordings:
        if component not in models:
            raise InputError(
                f"{recordings[component].name}: expected a treadmill model of {component}, found models of "
                f"{listed(models)}: calibrate it"
            )
    compensated, friction = {}, None
    if {"Fy", "Mx"} <= models.keys():  # of one frame: the same friction
        friction = models["Fy"].model.shared_friction(models["Mx"].model, recordings["Fy"])
    for component in sorted(recordings):  # the force first: its cross-talk is part of the moment
        force = compensated["Fy"] + recordings["Fy"].carried if "Fy" in compensated else None
        compensated[component] = models[component].compensate(recordings[component], force, friction)
    return compensated


def added_per_kg(
    models: dict[str, FittedModel], recordings: dict[str, BeltRecording]
) -> dict[str, np.ndarray]:
    """Belt-induced loads added by another kilogram on the belt, before the response of the frame.

    A load that presses on the belt briefly adds friction like a mass.

    models, recordings: as for `compensated_loads`.
    Returns: component -> load per mass (N/kg, N·m/kg); 0 for models that do not depend on the mass.
    """
    return {
        component: models[component].model.added_per_kg(recording)
        for component, recording in recordings.items()
    }


def compensated_draws(
    models: dict[str, FittedModel], recordings: dict[str, BeltRecording]
) -> dict[str, np.ndarray]:
    """Compensated loads of one trial for every draw of the models' constants, to first order in their errors.

    models, recordings: as for `compensated_loads`.
    Returns: component -> loads (N, N·m), draw by draw the same constants for all components; without rows
    if the models hold no draws.
    """
    best = compensated_loads(models, recordings)
    groups, deviations = _groups(models)
    if not groups:
        return {component: np.empty((0, x.size)) for component, x in best.items()}
    slopes: list[tuple[np.ndarray, dict[str, np.ndarray]]] = []  # errors of a constant, derivatives by it
    for k, members in enumerate(groups):
        for constant in np.flatnonzero(deviations[k].std(axis=0) > 0.0):
            step = np.zeros(deviations[k].shape[1])
            step[constant] = STEP * deviations[k][:, constant].std()
            shifted = {
                component: replace(m, model=m.model.moved(step), deviations=None)
                if component in members
                else m
                for component, m in models.items()
            }
            changed = compensated_loads(shifted, recordings).items()
            by_constant = {component: (x - best[component]) / step[constant] for component, x in changed}
            slopes.append((deviations[k][:, constant], by_constant))
    draws = {component: np.tile(x, (deviations[0].shape[0], 1)) for component, x in best.items()}
    for component, rows in draws.items():
        change = np.empty_like(best[component])
        for draw, row in enumerate(rows):  # one draw after the other stays in the processor's cache
            for errors, by_constant in slopes:
                row += np.multiply(errors[draw], by_constant[component], out=change)
    return draws


def _groups(models: dict[str, FittedModel]) -> tuple[list[tuple[str, ...]], list[np.ndarray]]:
    """Components whose models share all constants, and draws of the errors, shape (draws, constants)."""
    groups: list[tuple[str, ...]] = []
    deviations: list[np.ndarray] = []
    for component, fitted in models.items():
        if fitted.deviations is None:
            return [], []
        for k, known in enumerate(deviations):
            if np.array_equal(known, fitted.deviations):
                groups[k] = (*groups[k], component)
                break
        else:
            groups.append((component,))
            deviations.append(fitted.deviations)
    return groups, deviations
