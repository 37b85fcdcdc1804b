"""A joint that is not linear in a torque-controlled manipulator: regression pooled over trials.

One set of constants explains the trials of all amplitudes:

    tau(t - d) = I th'' + B th' + K th + Fc tanh(th' / w0) + K3 th^3 + q (Bs th' - Ks th)
    q = th^2 / (th^2 + phi^2)

Fc is Coulomb friction, K3 a joint that hardens, Ks and Bs the stiffness that a softening joint loses at large
angles and the damping that it gains there. The softening terms are part of the model only if the data ask
for them.

Noise and torque ripple are unrelated between periods of the perturbation; the torque is not. With X_i the
regressors and e_i = y_i - X_i p the residuals of period i, the instruments of period i are the sum of the
other periods' regressors, and p solves

    sum over i and j != i of X_j' e_i = 0

It is the minimum of the sum of e_i' e_j over pairs of different periods, an unbiased estimate of what the
model leaves unexplained in every period alike; phi minimises the same sum.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.signals.filters import butterworth_lowpass

# rate at which the smooth sign of friction is nearly one (rad/s)
FRICTION_RATE = 0.01
# the angle is smoothed above the band of the regression, so that products of it stay inside
SMOOTHING_PER_CUTOFF = 2.0
# bending at which half of the softening has taken place, smallest and largest per RMS angle
SOFTENING_RANGE = (0.2, 8.0)
# standard errors from 0 of the lost stiffness above which the joint is taken to soften
SOFTENING_T = 4.0
TERMS = (*PARAMETERS, "friction", "K_cubic", "delay", "K_softened", "B_softened", "softening_angle")
LINEAR = 6  # terms without softening
# groups of terms: their contribution to the linear joint nearest to the whole (columns)
GROUPS = {"small": (0, 1, 2), "friction": (3,), "hardening": (4,), "softening": (6, 7)}


@dataclass(frozen=True)
class PerturbedRecord:
    """A trial of periodic torque perturbation."""

    torque: Annotated[np.ndarray, "(n,)", "N·m"]
    angle: Annotated[np.ndarray, "(n,)", "rad"]
    """Whole trial, not filtered."""
    kept: slice
    """Samples that remain after both ends are cut (samples)."""


@dataclass(frozen=True)
class PooledFit:
    """Constants of the joint."""

    values: dict[str, float]
    standard_error: dict[str, float]
    low: dict[str, float]
    high: dict[str, float]
    """Quantity -> estimate, standard error and ends of the 95 % interval, units in `UNITS` of joints; without
    softening if the data do not require it."""
    freedom: float
    """Degrees of freedom of the standard errors."""
    systematic_Nm: float
    """RMS of the torque that the model leaves unexplained in every period alike."""
    without_softening_Nm: float
    """The same without the terms of softening."""
    rms_angle: Annotated[np.ndarray, "(records,)", "rad"]
    """RMS angle in each record."""
    shares: dict[str, np.ndarray]
    """Group of terms -> what it adds to I, B, K of the linear joint nearest to the whole in each record
    (N·m·s²/rad, N·m·s/rad, N·m/rad), shape (records, 3)."""


class _Pool:
    """Records cut into periods, and the sums of products of their columns."""

    def __init__(self, records, rate_hz, period_s, lowpass_hz, order):
        self.records, self.rate_hz, self.filter = records, rate_hz, (lowpass_hz, order)
        self.length = round(period_s * rate_hz)
        self.smooth = [self._smooth(record) for record in records]
        self.fixed = [self._linear(*smooth) for smooth in self.smooth]

    def _lowpass(self, x, factor=1.0):
        cutoff = min(factor * self.filter[0], 0.45 * self.rate_hz)
        return butterworth_lowpass(x, self.rate_hz, cutoff, self.filter[1])

    def _smooth(self, record):
        """Angle, its derivatives, torque and its derivative, all filtered alike."""
        time = np.arange(record.angle.size) / self.rate_hz
        angle, torque = (self._lowpass(x, SMOOTHING_PER_CUTOFF) for x in (record.angle, record.torque))
        spline = scipy.interpolate.make_interp_spline(time, angle, k=5)
        change = scipy.interpolate.make_interp_spline(time, torque, k=5).derivative(1)(time)
        return angle, spline.derivative(1)(time), spline.derivative(2)(time), torque, change

    def _linear(self, angle, rate, acceleration, torque, change):
        terms = [acceleration, rate, angle, np.tanh(rate / FRICTION_RATE), angle**3, change, torque]
        return self._lowpass(np.column_stack(terms))

    def columns(self, phi, lost=None):
        """Regressors and the torque as last column, of each record; ``lost`` adds the derivative by phi."""
        for (angle, rate, *_), fixed in zip(self.smooth, self.fixed, strict=True):
            if phi is None:
                yield fixed
                continue
            square = angle**2
            part = square / (square + phi**2)
            terms = [-part * angle, part * rate]
            if lost is not None:
                change = -2.0 * phi * square / (square + phi**2) ** 2
                terms.append(change * (lost[1] * rate - lost[0] * angle))
            yield np.column_stack([fixed[:, :-1], self._lowpass(np.column_stack(terms)), fixed[:, -1]])

    def products(self, phi=None, lost=None):
        """X_i' X_j of all pairs of periods, of each record, shape (periods, periods, columns, columns)."""
        products = []
        for record, columns in zip(self.records, self.columns(phi, lost), strict=True):
            kept = columns[record.kept]
            periods = kept.shape[0] // self.length
            kept = kept[-periods * self.length :]
            blocks = (kept - kept.mean(axis=0)).reshape(periods, self.length, -1)
            products.append(np.einsum("int,jnu->ijtu", blocks, blocks, optimize=True))
        return products

    def pairs(self, products):
        """Number of products of samples of different periods."""
        return self.length * sum(p.shape[0] * (p.shape[0] - 1) for p in products)


def _solve(products):
    """Parameters, and the sum of products of residuals of different periods."""
    total = sum((p * (1.0 - np.eye(p.shape[0]))[:, :, None, None]).sum(axis=(0, 1)) for p in products)
    total = 0.5 * (total + total.T)
    scale = np.sqrt(np.abs(np.diag(total)))
    scale[scale == 0.0] = 1.0
    scaled = total / np.outer(scale, scale)
    parameters = np.linalg.solve(scaled[:-1, :-1], scaled[:-1, -1]) * scale[-1] / scale[:-1]
    residual = np.append(-parameters, 1.0)
    return parameters, float(residual @ total @ residual)


def _standard_error(products, parameters):
    """Standard errors from the scatter of the periods' contributions X_j' e_i to the estimating equations."""
    residual, normal, scores = np.append(-parameters, 1.0), 0.0, []
    for p in products:
        other = 1.0 - np.eye(p.shape[0])
        normal = normal + np.einsum("ij,ijtu->tu", other, p)[:-1, :-1]
        scores.append(np.einsum("ij,jitu,u->it", other, p, residual)[:, :-1])
    scores = np.concatenate(scores)
    freedom = scores.shape[0] - parameters.size
    scale = np.sqrt(np.abs(np.diag(normal)))
    inverse = np.linalg.inv(normal / np.outer(scale, scale)) / np.outer(scale, scale)
    covariance = inverse @ (scores.T @ scores) @ inverse.T * scores.shape[0] / freedom
    return np.sqrt(np.diag(covariance)), freedom


def fit_pooled(
    records: list[PerturbedRecord], rate_hz: float, period_s: float, lowpass_hz: float, order: int = 4
) -> PooledFit:
    """Estimate inertia, damping, friction and stiffness from trials of several amplitudes.

    records: trials of the same joint with the same perturbation at several amplitudes.
    period_s: period of the perturbation.
    lowpass_hz, order: zero-lag Butterworth filter of torque and regressors.
    Returns: constants with 95 % intervals (units in `UNITS` of joints).
    """
    _refuse(records, round(period_s * rate_hz))
    pool = _Pool(records, rate_hz, period_s, lowpass_hz, order)
    plain = pool.products()
    parameters, cost = _solve(plain)
    without = cost
    error, freedom = _standard_error(plain, parameters)
    names, phi = list(TERMS)[:LINEAR], None
    softened = _softening(pool)
    if softened is not None:
        phi, parameters, cost, error, freedom = softened
        names = list(TERMS)
    half = scipy.stats.t.ppf(0.975, freedom) * error
    pairs = pool.pairs(plain)
    return PooledFit(
        values=dict(zip(names, parameters.tolist(), strict=True)),
        standard_error=dict(zip(names, error.tolist(), strict=True)),
        low=dict(zip(names, (parameters - half).tolist(), strict=True)),
        high=dict(zip(names, (parameters + half).tolist(), strict=True)),
        freedom=float(freedom),
        systematic_Nm=float(np.sqrt(max(cost, 0.0) / pairs)),
        without_softening_Nm=float(np.sqrt(max(without, 0.0) / pairs)),
        rms_angle=np.array([record.angle[record.kept].std() for record in records]),
        shares=_shares(pool, parameters, phi),
    )


def _refuse(records, length):
    periods = [len(range(*r.kept.indices(r.angle.size))) // length for r in records]
    if min(periods, default=0) < 2:
        raise InputError(
            f"expected at least 2 whole periods of the perturbation in every trial, found {min(periods)}: "
            "cut less at both ends, or record longer"
        )
    if sum(periods) < len(TERMS) + 3:
        raise InputError(
            f"expected at least {len(TERMS) + 3} periods in all trials together, found {sum(periods)}: "
            "record more trials, or longer ones"
        )
    if not all(np.ptp(r.angle[r.kept]) > 0.0 and np.ptp(r.torque[r.kept]) > 0.0 for r in records):
        raise InputError(
            "expected a torque perturbation and a moving joint in every trial, found a constant signal: "
            "check that the perturbation was applied"
        )


def _softening(pool):
    """Best phi, parameters with phi as last, cost, standard errors and freedom; None if not asked for."""
    rms = np.sqrt(np.mean([np.var(record.angle[record.kept]) for record in pool.records]))
    low, high = np.log(rms * np.array(SOFTENING_RANGE))
    tried = np.linspace(low, high, 9)
    costs = [_solve(pool.products(np.exp(x)))[1] for x in tried]
    best = int(np.argmin(costs))
    if best in (0, tried.size - 1):
        return None
    minimum = scipy.optimize.minimize_scalar(
        lambda x: _solve(pool.products(np.exp(x)))[1],
        bounds=(tried[best - 1], tried[best + 1]),
        method="bounded",
        options={"xatol": 1e-3},
    )
    phi = float(np.exp(minimum.x))
    parameters, cost = _solve(pool.products(phi))
    # phi as a further parameter, linearised at its estimate
    products = pool.products(phi, parameters[LINEAR:])
    error, freedom = _standard_error(products, np.append(parameters, 0.0))
    if not parameters[LINEAR] > SOFTENING_T * error[LINEAR]:
        return None
    return phi, np.append(parameters, phi), cost, error, freedom


def _shares(pool, parameters, phi):
    """Contribution of groups of terms to the linear joint nearest to the whole, in each record."""
    shares = {name: [] for name, members in GROUPS.items() if phi is not None or max(members) < LINEAR}
    for record, columns in zip(pool.records, pool.columns(phi), strict=True):
        kept = columns[record.kept] - columns[record.kept].mean(axis=0)
        for name, rows in shares.items():
            members = list(GROUPS[name])
            torque = kept[:, members] @ parameters[members]
            rows.append(np.linalg.lstsq(kept[:, :3], torque, rcond=None)[0])
    return {name: np.array(rows) for name, rows in shares.items()}
