"""The muscle model: a second-order low-pass of three parameters in place of a free reflex response.

    tau_R(s) = G w^2 / (s^2 + 2 zeta w s + w^2) u(s) exp(-s delay),   w = 2 pi frequency

Frequency and damping minimise the weighted error, the rest is linear; the pathways of the selected structure
share frequency and damping.
"""

import numpy as np
import scipy

from tepsipe.identification.cascade_fit import MuscleFit, Structure
from tepsipe.identification.cascade_normal import block_sums, solve_bounded, solve_drawn
from tepsipe.identification.cascade_pathways import delayed, muscle_response
from tepsipe.identification.cascade_record import CascadeRecord, groups_of, make_design
from tepsipe.identification.cascade_selection import fit_once
from tepsipe.statistics.goodness_of_fit import evaluate_held_out

# frequency (Hz) and damping ratio (-) of the muscle: starting values, bounds, and step of the logarithms for
# numerical derivatives
MUSCLE_START = (2.0, 1.0)
MUSCLE_BOUNDS = ((0.2, 20.0), (0.2, 5.0))
SLOPE = 1e-3


def fit_muscle(
    record: CascadeRecord, structure: Structure, blocks: list[slice], times: np.ndarray, samples: int
) -> MuscleFit:
    """Frequency and damping by optimisation, the rest by regression, structure as selected.

    Parameters
    ----------
    record : CascadeRecord
        Weighted record (units there).
    structure : Structure
        Structure with a reflex (units there).
    blocks : list of slice
        Samples of the bootstrapped blocks.
    times : ndarray, shape (draws, blocks)
        How often each of them counts (-).
    samples : int
        Length of the response (samples).

    Returns
    -------
    MuscleFit
        The muscle (units there).
    """
    names = [name for name in groups_of(structure) if name in ("reflex", "gain_slope", "unloading")]
    inputs = {
        name: delayed(record.reflex_input(name, structure), structure.delay_s, record.rate_hz)
        for name in names
    }
    rest = make_design(record, structure, {name: inputs[name][record.kept, None] for name in names})
    training = slice(0, record.training)
    target = record.white_torque[training]
    fixed = np.setdiff1d(np.arange(rest.scale.size), [rest.groups[name].start for name in names])
    x = rest.white[training][:, fixed]
    normal, right = x.T @ x, x.T @ target
    penalty = structure.penalty * record.training * rest.penalty[np.ix_(fixed, fixed)]
    bounded = np.concatenate([rest.bounded[fixed], np.zeros(len(names), dtype=bool)])

    def responses(constants: np.ndarray) -> np.ndarray:
        through = [muscle_response(inputs[name], record.rate_hz, *np.exp(constants)) for name in names]
        return np.column_stack(through)[record.kept]

    def error(constants: np.ndarray) -> float:
        through = record.whiten(responses(constants))[training]
        cross = x.T @ through
        own = through.T @ through
        whole = np.block(
            [[normal + penalty, cross], [cross.T, own + 1e-9 * np.trace(own) * np.eye(len(names))]]
        )
        sides = np.concatenate([right, through.T @ target])
        p = solve_bounded(whole[None], sides[None], bounded)[0]
        return float(p @ whole @ p - 2.0 * p @ sides)

    found = scipy.optimize.minimize(
        error,
        np.log(MUSCLE_START),
        method="Nelder-Mead",
        bounds=np.log(MUSCLE_BOUNDS),
        options={"xatol": 1e-3, "fatol": 1e-6 * float(target @ target), "maxfev": 120},
    )
    made = responses(found.x)
    design = make_design(record, structure, {name: made[:, [k]] for k, name in enumerate(names)})
    solution = fit_once(record, design, structure)
    predicted = design.columns @ solution
    frequency, damping = np.exp(found.x)
    gains = np.array([(solution / design.scale)[design.groups[name].start] for name in names])
    # one Gauss-Newton step per draw: derivatives of the torque by both logarithms are regressors
    steps = [(responses(found.x + s) - responses(found.x - s)) @ gains for s in SLOPE * np.eye(2)]
    slopes = record.whiten(np.column_stack(steps) / (2.0 * SLOPE))
    drawn = solve_drawn(
        block_sums(np.hstack([design.white, slopes]), record.white_torque, blocks),
        times,
        np.pad(structure.penalty * design.penalty, (0, 2)),
        np.concatenate([design.bounded, [False, False]]),
    )
    at = design.groups["reflex"].start
    w = 2.0 * np.pi * frequency
    time = np.arange(samples) / record.rate_hz
    muscle = ([w**2], [1.0, 2.0 * damping * w, w**2])
    return MuscleFit(
        constants=np.array([gains[0], frequency, damping]),
        bootstrap=np.column_stack(
            [
                drawn[:, at] / design.scale[at],
                frequency * np.exp(drawn[:, -2]),
                damping * np.exp(drawn[:, -1]),
            ]
        ),
        response=gains[0] * scipy.signal.impulse(muscle, T=time)[1],
        predicted=predicted,
        vaf=evaluate_held_out(record.used, predicted, record.training),
    )
