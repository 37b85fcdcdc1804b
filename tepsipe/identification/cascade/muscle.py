"""Muscle model of the reflex: a second-order low-pass of three parameters in place of a free response.

    tau_R(s) = G w^2 / (s^2 + 2 zeta w s + w^2) u(s) exp(-s delay),   w = 2 pi frequency

Frequency and damping minimise the weighted error, the rest is linear; the pathways of the selected structure
share frequency and damping.
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.identification.cascade.fit import MuscleFit, Structure
from tepsipe.identification.cascade.normal_equations import block_sums, solve_bounded, solve_drawn
from tepsipe.identification.cascade.pathways import delayed, muscle_response
from tepsipe.identification.cascade.record import (
    REFLEX_GROUPS,
    CascadeRecord,
    Design,
    column_groups,
    make_design,
)
from tepsipe.identification.cascade.selection import fit_once
from tepsipe.statistics.goodness_of_fit import evaluate_held_out

# frequency (Hz) and damping ratio of the muscle: starting values, bounds, and step of the logarithms for
# numerical derivatives
MUSCLE_START = (2.0, 1.0)
MUSCLE_BOUNDS = ((0.2, 20.0), (0.2, 5.0))
SLOPE = 1e-3


def fit_muscle(
    record: CascadeRecord,
    structure: Structure,
    blocks: list[slice],
    times: Annotated[np.ndarray, "(draws, blocks)"],
    samples: int,
) -> MuscleFit:
    """Frequency and damping by optimisation, the rest by regression, structure as selected.

    blocks: samples of the bootstrapped blocks.
    times: multiplicity of each block.
    samples: length of the response (samples).
    """
    drive = {
        name: delayed(record.reflex_input(name, structure), structure.delay_s, record.rate_hz)
        for name in column_groups(structure)
        if name in REFLEX_GROUPS
    }
    pathways = _Pathways(record, structure, drive)
    logarithms = _best_muscle(pathways)
    design = pathways.design(pathways.responses(logarithms))
    coefficients = fit_once(record, design, structure)
    predicted = design.torque(coefficients, record.used.size)
    gains = np.array([coefficients[design.groups[name].start] for name in drive])
    frequency, damping = np.exp(logarithms)
    w = 2.0 * np.pi * frequency
    muscle = ([w**2], [1.0, 2.0 * damping * w, w**2])
    time = np.arange(samples) / record.rate_hz
    return MuscleFit(
        constants=np.array([gains[0], frequency, damping]),
        bootstrap=_bootstrap(pathways, design, logarithms, gains, blocks, times),
        response=gains[0] * scipy.signal.impulse(muscle, T=time)[1],
        predicted=predicted,
        vaf=evaluate_held_out(record.used, predicted, record.training),
    )


@dataclass(frozen=True)
class _Pathways:
    """Pathways of the reflex that a muscle filters, and the drive of each."""

    record: CascadeRecord
    structure: Structure
    drive: dict[str, np.ndarray]

    def responses(self, logarithms: np.ndarray, fitted: bool = False) -> np.ndarray:
        """Output of a muscle for every drive, shape (n, pathways), by the logarithms of its constants.

        fitted: only of the fitted part.
        """
        part = self.record.fitted if fitted else self.record.kept
        constants = np.exp(logarithms)
        drives = [x[: part.stop] for x in self.drive.values()]
        through = [muscle_response(x, self.record.rate_hz, *constants) for x in drives]
        return np.column_stack(through)[part]

    def design(self, responses: np.ndarray) -> Design:
        """Regressors of the structure with these responses of the reflex."""
        columns = {name: responses[:, [k]] for k, name in enumerate(self.drive)}
        return make_design(self.record, self.structure, columns)


def _best_muscle(pathways: _Pathways) -> np.ndarray:
    """Logarithms of frequency and damping with the smallest weighted error of the fitted part, shape (2,)."""
    record, count = pathways.record, len(pathways.drive)
    joint = replace(pathways.structure, direction=0, gain_slope=False, unloading=False)
    rest = make_design(record, joint)
    training = slice(0, record.training)
    target, x = record.white_torque, rest.white(training)
    normal, right = x.T @ x, x.T @ target
    penalty = pathways.structure.penalty * record.training * rest.penalty
    bounded = np.concatenate([rest.bounded, np.zeros(count, dtype=bool)])

    def error(logarithms: np.ndarray) -> float:
        through = record.whiten(pathways.responses(logarithms, fitted=True))
        cross = x.T @ through
        among = through.T @ through
        ridge = 1e-9 * np.trace(among) * np.eye(count)
        whole = np.block([[normal + penalty, cross], [cross.T, among + ridge]])
        sides = np.concatenate([right, through.T @ target])
        p = solve_bounded(whole[None], sides[None], bounded)[0]
        return float(p @ whole @ p - 2.0 * p @ sides)

    return scipy.optimize.minimize(
        error,
        np.log(MUSCLE_START),
        method="Nelder-Mead",
        bounds=np.log(MUSCLE_BOUNDS),
        options={"xatol": 1e-3, "fatol": 1e-6 * float(target @ target), "maxfev": 120},
    ).x


def _bootstrap(
    pathways: _Pathways,
    design: Design,
    logarithms: np.ndarray,
    gains: np.ndarray,
    blocks: list[slice],
    times: np.ndarray,
) -> np.ndarray:
    """Gain, frequency and damping of every draw, shape (draws, 3), by one Gauss-Newton step."""
    record, structure = pathways.record, pathways.structure
    # derivatives of the torque by both logarithms are regressors
    steps = [
        (pathways.responses(logarithms + s) - pathways.responses(logarithms - s)) @ gains
        for s in SLOPE * np.eye(2)
    ]
    slopes = record.whiten(np.column_stack(steps) / (2.0 * SLOPE))
    drawn = solve_drawn(
        block_sums(lambda rows: np.hstack([design.white(rows), slopes[rows]]), record.white_torque, blocks),
        times,
        np.pad(structure.penalty * design.penalty, (0, 2)),
        np.concatenate([design.bounded, [False, False]]),
    )
    at = design.groups["reflex"].start
    frequency, damping = np.exp(logarithms)
    return np.column_stack(
        [drawn[:, at] / design.scale[at], frequency * np.exp(drawn[:, -2]), damping * np.exp(drawn[:, -1])]
    )
