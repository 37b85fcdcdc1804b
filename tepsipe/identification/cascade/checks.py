"""Checks of a parallel-cascade fit (`tepsipe.identification.cascade.parallel_cascade`).

What the torque leaves beside reflex, stops, relaxation and stiffening is that of a linear joint,

    W (tau - tau_R - tau_S - c (theta - theta_0)^2) = W (I theta'' + B theta' + K theta + offset)

with the filter W, which whitens the slow torque. The reflex begins at least 30 ms after the movement, and the
delay of the torque is searched up to this time, so it is found on the left side
(`tepsipe.identification.consistency.delay_of_record`). A torque that went through a zero-lag low-pass F
follows the same equation with F theta in place of theta. The stiffness is compared between segments of the
record, K + dK with the residual e of the model,

    W e = W (dI theta'' + dB theta' + dK theta + level)
"""

from itertools import pairwise
from typing import Annotated

import numpy as np

from tepsipe.identification.cascade.fit import ParallelCascadeFit
from tepsipe.identification.cascade.record import CascadeRecord
from tepsipe.identification.consistency import CHANCE, DelayProfile, delay_of_record, explains_less
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import WIDEST, butterworth_lowpass
from tepsipe.statistics.residuals import equal_means_p, solution_with_errors

# length of the segments whose stiffness is compared, and of the blocks within which whitened residuals may
# still be correlated (s); smallest standard deviation of the stiffness over them that matters, relative to it
SEGMENT_S, BLOCK_S, LEAST_VARIATION = 5.0, 0.5, 0.1
# smallest delay of the torque that counts (s), and confidence that there is one
LEAST_DELAY_S, SURE = 1e-3, 0.999
# cutoffs and order of the low-pass that the torque may have passed, and the largest part of the squares that
# it then leaves
CUTOFFS_HZ, FILTER_ORDER, LEAST_GAIN = np.geomspace(3.0, 30.0, 10), 4, 0.5


def failed_checks(record: CascadeRecord, fit: ParallelCascadeFit) -> tuple[str, ...]:
    """Names of the checks that a fit fails, in `tepsipe.flags.FLAGS`."""
    varies = varying_stiffness(record, fit) > LEAST_VARIATION
    found = {
        "torque-delay": late(torque_delay(record, fit)),
        "filtered-signal": filtered_torque(record, fit),
        "time-varying": varies,
        "halves-differ": explains_less(fit.vaf.training, fit.vaf.held_out),
    }
    return tuple(name for name, fails in found.items() if fails)


def torque_delay(record: CascadeRecord, fit: ParallelCascadeFit) -> DelayProfile:
    """Delay of the torque beside the reflex that was fitted."""
    time, *signals = _linear(record, fit)
    regressors, torque = (fit.slow.model.whiten(x, record.rate_hz) for x in signals)
    return delay_of_record(time, regressors, torque, round(record.rate_hz), SURE)


def filtered_torque(record: CascadeRecord, fit: ParallelCascadeFit) -> bool:
    """True if a low-pass of the motion leaves at most `LEAST_GAIN` of the squares, for some cutoff."""
    _, motion, linear = _linear(record, fit)
    torque = fit.slow.model.whiten(linear, record.rate_hz)

    def unexplained(regressors: np.ndarray) -> float:
        whitened = fit.slow.model.whiten(regressors, record.rate_hz)
        return float(np.sum((torque - whitened @ np.linalg.lstsq(whitened, torque, rcond=None)[0]) ** 2))

    cutoffs_hz = [hz for hz in CUTOFFS_HZ.tolist() if hz < WIDEST * record.rate_hz]
    filtered = (butterworth_lowpass(motion, record.rate_hz, hz, FILTER_ORDER) for hz in cutoffs_hz)
    return min(map(unexplained, filtered), default=np.inf) < LEAST_GAIN * unexplained(motion)


def late(profile: DelayProfile) -> bool:
    """True if a delay is longer than its uncertainty and `LEAST_DELAY_S`, or if some delay fits better."""
    certain = abs(profile.value_s) > max(LEAST_DELAY_S, profile.half_width_s(SURE))
    return certain or (profile.excludes_zero and not profile.determined)


def varying_stiffness(record: CascadeRecord, fit: ParallelCascadeFit) -> float:
    """Standard deviation of the stiffness over the record beyond its errors, relative to K; 0 for chance."""
    time, motion = _motion(record)
    residual = record.used - fit.predicted
    regressors, residual = (fit.slow.model.whiten(x, record.rate_hz) for x in (motion, residual))
    count = int(time.size / (SEGMENT_S * record.rate_hz))
    if count < 3:
        return 0.0
    change, error, freedom = np.array(
        [_change(regressors[part], residual[part], record.rate_hz) for part in _segments(time.size, count)]
    ).T
    if not equal_means_p(change, error, freedom) < CHANCE:
        return 0.0
    beyond = np.var(change, ddof=1) - np.mean(error**2)
    return float(np.sqrt(max(beyond, 0.0)) / max(abs(fit.working_stiffness), 1e-300))


def _segments(size: int, count: int) -> list[slice]:
    ends = np.linspace(0, size, count + 1).astype(int)
    return [slice(*pair) for pair in pairwise(ends)]


def _change(regressors: np.ndarray, residual: np.ndarray, rate_hz: float) -> tuple[float, float, int]:
    """Change of K (N·m/rad), its standard error and degrees of freedom."""
    solution, error, freedom = solution_with_errors(regressors, residual, round(BLOCK_S * rate_hz))
    return solution[2], error[2], freedom


def _linear(record: CascadeRecord, fit: ParallelCascadeFit) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time (s), motion as `_motion`, and the torque that a linear joint makes of it (N·m)."""
    time, motion = _motion(record)
    linear = record.used - fit.reflex_torque - fit.stop_torque - 0.5 * fit.stiffening * motion[:, 2] ** 2
    return time, motion, linear


def _motion(record: CascadeRecord) -> tuple[np.ndarray, Annotated[np.ndarray, "(n, 4)"]]:
    """Time (s); theta'' (rad/s²), theta' (rad/s), theta (rad) and 1, of the part in use."""
    time = np.arange(record.angle.size) / record.rate_hz
    velocity = derivative(time, record.angle)
    columns = (derivative(time, velocity), velocity, record.angle, np.ones_like(velocity))
    return time[record.kept], np.column_stack(columns)[record.kept]
