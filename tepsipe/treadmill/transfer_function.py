"""Discrete transfer functions from belt acceleration to load, fitted to their output error.

    L(k) + f_1 L(k-1) + ... + f_n L(k-n) = b_0 a(k) + b_1 a(k-1) + ... + b_n a(k-n)

hnat2014, the published model of a treadmill's pitch moment, has n = 2 (Hnat & van den Bogert 2014,
J. Biomech. 47, 3758-3761).
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.treadmill.belt_model import BeltModel
from tepsipe.treadmill.recording import BeltRecording

PUBLISHED_START = 0.001
PUBLISHED_BOUND = 10.0
# of the output-error model: rounds of its start, and evaluations after which the search ends
ROUNDS, MOST_EVALUATIONS = 8, 60


@dataclass(frozen=True)
class DiscreteTransfer(BeltModel):
    """Transfer function from a (m/s²) to L."""

    numerator: Annotated[np.ndarray, "(n + 1,)"]
    """b_0 ... b_n (unit of the load over m/s²)."""
    denominator: Annotated[np.ndarray, "(n + 1,)"]
    """1, f_1 ... f_n."""
    rate_hz: float
    """Sampling rate for which it holds."""
    converged: bool = True
    """Whether the optimisation converged."""

    @property
    def order(self) -> int:
        """Number of poles, n."""
        return self.denominator.size - 1

    def predict(self, recording: BeltRecording) -> np.ndarray:
        """L (unit of the load), shape (n,)."""
        return scipy.signal.lfilter(self.numerator, self.denominator, recording.acceleration)


def fit_hnat2014(recordings: list[BeltRecording], most_evaluations: int) -> DiscreteTransfer:
    """hnat2014, the published procedure: output error over five coefficients from 0.001 within +-10.

    most_evaluations: evaluations of the model after which the search ends.
    """

    def coefficients(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return x[2:], np.concatenate([[1.0], x[:2]])

    def error(x: np.ndarray) -> np.ndarray:
        b, f = coefficients(x)
        residual = [(scipy.signal.lfilter(b, f, r.acceleration) - r.load)[r.evaluated] for r in recordings]
        return np.clip(np.nan_to_num(np.concatenate(residual), nan=1e6), -1e6, 1e6)

    solution = scipy.optimize.least_squares(
        error,
        np.full(5, PUBLISHED_START),
        bounds=(-PUBLISHED_BOUND, PUBLISHED_BOUND),
        max_nfev=most_evaluations,
    )
    return DiscreteTransfer(*coefficients(solution.x), recordings[0].rate_hz, bool(solution.success))


def fit_discrete_output_error(recordings: list[BeltRecording], order: int) -> DiscreteTransfer:
    """Output-error model of any order, by Gauss-Newton from the Steiglitz-McBride solution."""
    start = _steiglitz_mcbride(recordings, order)
    scale = np.maximum(np.abs(start), 1e-3 * np.abs(start).max())

    def split(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return x[: order + 1], np.concatenate([[1.0], x[order + 1 :]])

    def error(z: np.ndarray) -> np.ndarray:
        b, f = split(z * scale)
        if np.abs(np.roots(f)).max(initial=0.0) >= 1.0:
            return np.concatenate([np.full(int(r.evaluated.sum()), 1e6) for r in recordings])
        return np.concatenate(
            [(scipy.signal.lfilter(b, f, r.acceleration) - r.load)[r.evaluated] for r in recordings]
        )

    def jacobian(z: np.ndarray) -> np.ndarray:
        b, f = split(z * scale)
        blocks = []
        for r in recordings:
            by_input = scipy.signal.lfilter([1.0], f, r.acceleration)
            by_output = -scipy.signal.lfilter([1.0], f, scipy.signal.lfilter(b, f, r.acceleration))
            columns = [_delayed(by_input, k) for k in range(order + 1)]
            columns += [_delayed(by_output, k) for k in range(1, order + 1)]
            blocks.append(np.column_stack(columns)[r.evaluated])
        return np.concatenate(blocks) * scale

    solution = scipy.optimize.least_squares(
        error, start / scale, jac=jacobian, ftol=1e-6, max_nfev=MOST_EVALUATIONS
    )
    b, f = split(solution.x * scale)
    if np.abs(np.roots(f)).max(initial=0.0) >= 1.0:
        raise InputError(
            f"{recordings[0].name}: expected a stable output-error model of order {order}, found none: "
            "decrease output_error_order"
        )
    return DiscreteTransfer(b, f, recordings[0].rate_hz, bool(solution.success))


def _steiglitz_mcbride(recordings: list[BeltRecording], order: int) -> np.ndarray:
    """b_0 ... b_n, f_1 ... f_n: least squares on signals filtered by the last denominator, repeated."""
    f = np.concatenate([[1.0], np.zeros(order)])
    best = None
    for _ in range(ROUNDS):
        rows, right = [], []
        for r in recordings:
            a, load = (scipy.signal.lfilter([1.0], f, x) for x in (r.acceleration, r.load))
            columns = [_delayed(a, k) for k in range(order + 1)]
            columns += [-_delayed(load, k) for k in range(1, order + 1)]
            rows.append(np.column_stack(columns)[r.evaluated])
            right.append(load[r.evaluated])
        x = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=1e-10)[0]
        f = _stabilised(np.concatenate([[1.0], x[order + 1 :]]))
        b = x[: order + 1]
        errors = [(scipy.signal.lfilter(b, f, r.acceleration) - r.load)[r.evaluated] for r in recordings]
        cost = sum(float(e @ e) for e in errors)
        if best is None or cost < best[0]:
            best = (cost, np.concatenate([b, f[1:]]))
    return best[1]


def _stabilised(f: np.ndarray) -> np.ndarray:
    """Denominator with its poles reflected into the unit circle."""
    poles = np.roots(f)
    size = np.abs(poles)
    poles = np.where(size > 1.0, poles / np.maximum(size, 1.0) ** 2, poles)
    return np.real(np.poly(np.where(np.abs(poles) > 0.995, 0.995 * poles / np.abs(poles), poles)))


def _delayed(x: np.ndarray, samples: int) -> np.ndarray:
    """``x`` delayed by a number of samples, with zeros before its start."""
    return x if samples == 0 else np.concatenate([np.zeros(samples), x[:-samples]])
