"""Three tests of whether a record agrees with the linear joint that was fitted to it.

**Residual.** What the model leaves in the perturbations is compared with what the same model leaves at rest,
where only noise acts. With the mean squares s_w^2 and s_r^2 of the filtered residuals, and their degrees of
freedom n_w and n_r from the width of their spectrum P (Bayley & Hammersley 1946), s_w^2 / s_r^2 follows
F(n_w, n_r), with n = 2 (sum P)^2 / sum P^2.

**Delay.** A torque that is recorded d later than it acts is tau(t) = tau_true(t - d), so

    tau(t + d) = I theta'' + B theta' + K (theta - theta_rest)

The search starts at the d of a grid that leaves the least squares, and solves for I, B, K and the step of d:

    tau(t + d) = I theta'' + B theta' + K (theta - theta_rest) - step tau'(t + d)

with products of different perturbations only, so that noise of angle and torque biases no delay
(`tepsipe.identification.regression.windows`). Its standard error is that of the perturbations (jackknife)
and of what they share: the torque at rest, and what derivatives and a wrong model leave. Noise acts on the
delay and on I, B, K at once. What an unknown delay adds to their variance is therefore not the square of
sensitivity times standard error, but the variance with a free delay less that with a known one.

With I = 0, tau' = B theta'' + K theta' is a combination of the regressors, so to first order a delay is a
change of I and B: the record of a joint without inertia cannot determine it. What remains is of second order,
d^2 B theta'''/2. The perturbations then do not repeat what distinguishes the two, or the standard error is
large.

**Halves.** Estimates of early and late perturbations, and of those in either direction, are compared by
Welch's test of two means.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.identification.regression.windows import of_constant_torque, products_of_perturbations
from tepsipe.mechanics.impedance_model import PARAMETERS, smeared_admittance
from tepsipe.signals.differentiation import derivative, interpolant
from tepsipe.signals.perturbations import Perturbation
from tepsipe.signals.response import FrequencyResponse
from tepsipe.signals.spectra import CHANCE, LEAST_DIFFERENCE
from tepsipe.statistics.clusters import errors_over_blocks
from tepsipe.statistics.uncertainty import Source, coverage_factor, error_of_mean, in_quadrature, scatter

# a residual in the perturbations matters above this ratio to the one at rest, and this part of the torque
LEAST_RATIO, LEAST_PART = 1.6, 0.01
# delays are searched up to this one, from starts this far apart (s)
LONGEST_S, STEP_S = 0.03, 0.0025
# another delay is excluded if it raises the sum of squares by more than this many mean squares: chi2 of 1
# degree of freedom exceeds it with probability CHANCE
UNLIKELY = 15.1
# splines, which interpolate and differentiate, leave about the square of this over the sampling rate of the
# torque (Hz): 0.01 % at 250 Hz
SPLINE_HZ = 2.5
# part of the torque of a record that noise of the angle may leave unexplained
ANGLE_PART = 1e-3
# samples of a record that are compared on the grid of delays (s), and fewest of perturbations
THIN_S, FEWEST_COMPARED = 0.005, 1000
# half-width of a delay's interval, above which the record does not determine it (s): three of its standard
# errors then tell a delay of half a millisecond, which adds 10 % to the damping of a passive joint, from none
WIDEST_S = 3e-4
# time before a perturbation whose mean is its own zero, and pause until it begins, because filters spread it
# (s)
BASELINE_S, BASELINE_GAP_S = 0.2, 0.06
# smallest range of these means that matters, relative to the torque's spread in the perturbations
LEAST_WANDER = 0.05
# error of a response that is averaged over neighbouring frequencies, by leakage and smearing, relative to it
LEAKAGE = 2e-3
MEASURE = "Measure the delay of the rig, and state its standard uncertainty as torque_delay_s"
ADVICE = (
    f"The perturbations do not distinguish it from damping. {MEASURE}; faster perturbations, windows with "
    "the free decay, or more inertia help, too"
)
RESPONSE_ADVICE = (
    f"The frequencies do not distinguish it from inertia and damping. {MEASURE}; higher frequencies help, too"
)
# growth of the unexplained part from the fitted to the held-out part of a record: ratio and difference (%)
LARGEST_GROWTH, LEAST_GROWTH = 2.5, 5.0


@dataclass(frozen=True)
class ResidualTest:
    """Residual in the perturbations against the residual at rest."""

    ratio: float
    """Root mean square in the perturbations over the one at rest; infinite for a record without noise."""
    part: float
    """Root mean square in the perturbations over the fitted torque's."""
    p: float
    """Probability of such a ratio by chance."""

    @property
    def failed(self) -> bool:
        """True if the model leaves more than noise."""
        return self.p < CHANCE and self.ratio > LEAST_RATIO and self.part > LEAST_PART


@dataclass(frozen=True)
class DelayProfile:
    """Delay of the torque after its record, as the record itself shows it."""

    value_s: float = np.nan
    standard_error_s: float = np.inf
    """Delay, positive for a torque that is recorded too late, and its standard error; infinite where the
    perturbations do not distinguish a delay from damping."""
    freedom: float = 1.0
    added: Annotated[np.ndarray, "(3,)"] = None
    """What the delay adds in quadrature to the standard errors of I, B, K at a known delay (their units)."""
    excludes_zero: bool = False
    """Whether some delay explains the torque better than none, where the record does not determine which."""
    reason: str = ""
    """Why the record does not determine the delay; empty where it does."""

    @property
    def determined(self) -> bool:
        """True if the record tells the delay from damping."""
        return not self.reason

    def half_width_s(self, confidence: float) -> float:
        """Half-width of the delay's interval (s)."""
        return float(coverage_factor(np.array(self.freedom), confidence)) * self.standard_error_s

    def narrow(self, confidence: float, advice: str) -> "DelayProfile":
        """The same, but undetermined if its interval is wider than `WIDEST_S`; ``advice`` is the reason."""
        if not self.determined or self.half_width_s(confidence) <= WIDEST_S:
            return self
        return replace(self, reason=advice)


@dataclass(frozen=True)
class TorqueDelay:
    """Delay of the torque after its record that is removed before a fit, by record and statement."""

    profile: DelayProfile
    removed_s: float = 0.0
    uncertainty_s: float | None = None
    """Delay that is removed, and the standard uncertainty of what is left; None if nothing is known."""
    uncorrected: Annotated[np.ndarray, "(3,)"] | None = None
    """I, B, K without the correction (N·m·s²/rad, N·m·s/rad, N·m/rad)."""

    @property
    def added(self) -> Annotated[np.ndarray, "(3,)"]:
        """What is left of the delay adds to the standard errors of I, B, K, in quadrature (their units)."""
        return self.uncertainty_s / self.profile.standard_error_s * self.profile.added

    def among(self, sources: Mapping[str, Source]) -> dict[str, Source]:
        """Sources of uncertainty with that of what is left of the delay."""
        if self.uncertainty_s is None:
            return dict(sources)
        left = Source("torque_delay_s", self.uncertainty_s, freedom=self.profile.freedom)
        return {**sources, left.name: left}


def combined(
    profile: DelayProfile, stated: Mapping[str, Source], uncorrected: Annotated[np.ndarray, "(3,)"]
) -> TorqueDelay:
    """Delay by the record's profile and a stated uncertainty.

    With the delay d of the profile, its standard error u_d, and a stated delay of 0 with standard uncertainty
    u_s, the delay is w d, w = u_s^2 / (u_s^2 + u_d^2), and its variance w u_d^2. With A and J the standard
    errors of I, B, K at a known and with a free delay, their variance is A^2 + w (J^2 - A^2). Without a
    statement, w is 1 for a delay that the record determines, and 0 for another.

    stated: torque_delay_s, if it is known.
    uncorrected: I, B, K without a correction.
    """
    source, square = stated.get("torque_delay_s"), profile.standard_error_s**2
    if source is not None and np.isfinite(square):
        own = source.standard_uncertainty**2
        weight = own / (own + square) if own > 0.0 else 0.0
    else:
        weight = float(profile.determined)
    if weight == 0.0:
        return TorqueDelay(profile)
    return TorqueDelay(profile, weight * profile.value_s, float(np.sqrt(weight * square)), uncorrected)


def moved_by(time: np.ndarray, torque: np.ndarray, delay_s: float) -> np.ndarray:
    """Torque tau(t + d), shape (n,)."""
    return interpolant(time, torque)(np.clip(time + delay_s, time[0], time[-1]))


def delay_of_record(
    time: np.ndarray,
    regressors: Annotated[np.ndarray, "(n, p)"],
    torque: np.ndarray,
    block: int,
    confidence: float,
) -> DelayProfile:
    """Delay of a torque in a record of continuous movement, by regression on the whole record.

    The step of d is found with the derivative of the predicted torque, which contains no noise of the torque.
    Blocks of time are the clusters of its standard error.

    regressors: theta'' (rad/s²), theta' (rad/s), theta (rad), then others, filtered.
    torque: tau (N·m), filtered as the motion is.
    block: length of a block (samples).
    confidence: probability of the interval that `WIDEST_S` limits.
    """
    edge = int(np.ceil(LONGEST_S / (time[1] - time[0])))
    if time.size < 4 * (edge + block):
        return DelayProfile(reason=f"The record is too short. {MEASURE}")
    kept = slice(edge, -edge)
    thin = slice(edge, -edge, max(1, int(THIN_S / (time[1] - time[0]))))
    spline = interpolant(time, torque)
    instants, size = time[thin], np.linalg.norm(regressors[thin], axis=0)
    scaled = np.divide(regressors[thin], size, order="F")
    basis, triangle = scipy.linalg.qr(scaled, mode="economic", overwrite_a=True, check_finite=False)
    steps = round(LONGEST_S / STEP_S)
    grid = STEP_S * np.arange(1 - steps, steps)

    def unexplained(delay_s: float) -> float:
        y = spline(instants + delay_s)
        return float(y @ y - np.sum((y @ basis) ** 2))

    left = np.array([unexplained(d) for d in grid])
    delay = float(grid[np.argmin(left)])
    for _ in range(8):
        y = spline(instants + delay)
        predicted = np.linalg.lstsq(triangle, basis.T @ y)[0] / size
        slope = derivative(time, regressors @ predicted)
        later = slope[thin] - basis @ (basis.T @ slope[thin])
        step = -float(later @ y) / float(later @ later)
        if abs(step) < 1e-6 or not abs(delay + step) < LONGEST_S:
            break
        delay += step
    if not abs(delay + step) < LONGEST_S:
        return DelayProfile(reason=RESPONSE_ADVICE)
    y = spline(instants + delay)
    least, left_over = unexplained(delay), y - basis @ (y @ basis)
    noise = least / max(_freedom(left_over), 1.0)
    noise += (ANGLE_PART**2 + (SPLINE_HZ * (time[1] - time[0])) ** 4) * float(np.var(y)) * y.size
    # blocks do not repeat each other, so that their scatter may lack what a wrong model leaves
    among = _among_others(grid, left, delay, least, noise, noise, RESPONSE_ADVICE).narrow(
        confidence, RESPONSE_ADVICE
    )
    if not among.determined:
        return among
    moments, products = _moments_of_blocks(time, regressors, slope, spline, delay, kept, block)
    error = np.linalg.solve(products, moments.T)[-1]
    error = float(np.sqrt(np.sum(error**2) * len(moments) / (len(moments) - 1.0)))
    error = max(error, among.standard_error_s)
    return DelayProfile(delay, error, len(moments) - 1.0).narrow(confidence, RESPONSE_ADVICE)


def delay_of_response(
    estimate: FrequencyResponse, parameters: Annotated[np.ndarray, "(3,)"], confidence: float
) -> DelayProfile:
    """Delay of the torque in an admittance H, angle over torque, which it turns into H e^(j w d).

    What averaging over frequencies adds is the half-width of a rectangular distribution
    (`tepsipe.identification.admittance_fit.change_by_smearing`).

    estimate: the frequencies to fit.
    parameters: I, B, K that fit without a delay (N·m·s²/rad, N·m·s/rad, N·m/rad).
    confidence: probability of the interval that `WIDEST_S` limits.
    """
    weight = np.sqrt(estimate.coherence / estimate.frequency_hz)
    leakage = LEAKAGE if estimate.resolution_hz > 0.0 else 0.0
    profile = _fitted_delay(estimate.frequency_hz, estimate.response, weight, parameters, leakage)
    if profile.determined and estimate.resolution_hz > 0.0:
        smeared = smeared_admittance(parameters, estimate.frequency_hz, estimate.resolution_hz)
        added = _fitted_delay(estimate.frequency_hz, smeared, weight, parameters, 0.0).value_s
        added = 0.0 if np.isnan(added) else added / np.sqrt(3.0)
        profile = replace(profile, standard_error_s=float(np.hypot(profile.standard_error_s, added)))
    return profile.narrow(confidence, RESPONSE_ADVICE)


def _fitted_delay(
    frequency_hz: np.ndarray,
    response: np.ndarray,
    weight: np.ndarray,
    parameters: Annotated[np.ndarray, "(3,)"],
    leakage: float,
) -> DelayProfile:
    """Delay that fits best together with I, B and K.

    The residuals are those of the spectral fit, weight log(H e^(-j w d) / H_model), with the errors
    of `error_of_misfit`: every frequency has a variance of its own, estimated with its leverage.

    leakage: error of the response that frequencies may share, relative to it.
    """
    omega = 2.0 * np.pi * frequency_hz
    moved = np.stack([-(omega**2), 1j * omega, np.ones_like(omega)], axis=1)
    steps = round(LONGEST_S / 1e-3)
    grid = 1e-3 * np.arange(-steps, steps + 1)
    # by linear least squares of 1/H, relative to its size
    scaled = weight[:, None] * np.abs(response)[:, None] * moved
    basis = np.linalg.qr(np.vstack([scaled.real, scaled.imag]))[0]
    y = weight * np.abs(response) / response * np.exp(1j * np.outer(grid, omega))
    y = np.hstack([y.real, y.imag])
    unexplained = np.sum(y**2, axis=1) - np.sum((y @ basis) ** 2, axis=1)
    delay = float(grid[np.argmin(unexplained)])
    p = parameters
    if abs(delay) > 0.0:
        p = np.linalg.lstsq(np.vstack([scaled.real, scaled.imag]), y[np.argmin(unexplained)])[0]
    for _ in range(20):
        impedance = moved @ p
        if not np.abs(impedance).min() > 0.0:
            return DelayProfile(reason=RESPONSE_ADVICE)
        turned = response * np.exp(-1j * delay * omega)
        ratio = weight * np.log(turned * impedance)
        slope = weight[:, None] * np.column_stack([moved / impedance[:, None], -1j * omega])
        jacobian = np.vstack([slope.real, slope.imag])
        left = np.concatenate([ratio.real, ratio.imag])
        size = np.linalg.norm(jacobian, axis=0)
        inverse = np.linalg.pinv((jacobian / size).T @ (jacobian / size), hermitian=True)
        step = -(inverse @ ((jacobian / size).T @ left)) / size
        p, delay = p + step[:3], delay + float(step[3])
        if abs(delay) > LONGEST_S:
            return DelayProfile(reason=RESPONSE_ADVICE)
        if abs(step[3]) < 1e-8:
            break
    scaled = jacobian / size
    leverage = np.einsum("ni,ij,nj->n", scaled, inverse, scaled)
    squares = ((left / np.maximum(1.0 - leverage, 1e-6)) ** 2).reshape(2, -1).mean(axis=0)
    terms = squares * ((scaled @ inverse)[:, 3] ** 2).reshape(2, -1).sum(axis=0) / size[3] ** 2
    freedom = float(np.clip(4.0 * terms.sum() ** 2 / np.sum(terms**2) - 2.0, 1.0, left.size - 4.0))
    noise = unexplained.min() / max(left.size - 4.0, 1.0)
    limit = unexplained.min() + UNLIKELY * (noise + leakage**2 * float(np.sum(weight**2)))
    if unexplained[np.abs(grid - delay) > STEP_S].min() < limit:
        excluded = bool(unexplained[steps] > limit)
        return DelayProfile(delay, reason=RESPONSE_ADVICE, excludes_zero=excluded)
    leaked = leakage**2 * float(np.sum(weight**2)) * inverse[3, 3] / size[3] ** 2
    return DelayProfile(delay, float(np.sqrt(terms.sum() + leaked)), freedom)


def residual_test(
    residual: np.ndarray,
    fitted: np.ndarray,
    windows: list[Perturbation],
    at_rest: Annotated[np.ndarray, "(n,)"],
) -> ResidualTest:
    """Compare the residual in the perturbations with the residual at rest.

    residual: measured less predicted signal, filtered, shape (n,).
    fitted: the measured signal, relative to rest, shape (n,).
    """
    # a joint that moves at rest shifts what the model leaves there and in the perturbations alike
    residual = residual - residual[at_rest].mean()
    inside = np.concatenate([residual[w.start : w.stop] for w in windows])
    signal = np.concatenate([fitted[w.start : w.stop] for w in windows])
    rest = residual[at_rest]
    mean_square, of_rest = float(np.mean(inside**2)), float(np.mean(rest**2))
    part = np.sqrt(mean_square / max(float(np.mean(signal**2)), 1e-300))
    if of_rest <= 1e-24 * mean_square:
        return ResidualTest(np.inf, part, 0.0)
    freedom = _freedom(rest)
    inside_freedom = max(freedom * inside.size / rest.size - len(PARAMETERS), 1.0)
    ratio = mean_square / of_rest
    return ResidualTest(np.sqrt(ratio), part, float(scipy.stats.f.sf(ratio, inside_freedom, freedom)))


def _freedom(x: np.ndarray) -> float:
    """Degrees of freedom of the mean square of a stretch of noise, 2 (sum P)^2 / sum P^2."""
    power = np.abs(np.fft.rfft(x - x.mean())) ** 2
    # a periodogram scatters as its mean, which doubles the mean of its square
    return max(4.0 * float(power.sum()) ** 2 / max(float(np.sum(power**2)), 1e-300), 2.0)


def delay_profile(
    time: np.ndarray,
    regressors: Annotated[np.ndarray, "(n, 3)"],
    torque: np.ndarray,
    windows: list[Perturbation],
    at_rest: Annotated[np.ndarray, "(n,)"],
    confidence: float,
) -> DelayProfile:
    """Delay of a torque relative to the motion that causes it.

    regressors: theta'' (rad/s²), theta' (rad/s), theta - theta_rest (rad), filtered.
    torque: tau - tau_rest (N·m), filtered as the motion is.
    confidence: probability of the interval that `WIDEST_S` limits.
    """
    if len(windows) < 3:
        return DelayProfile(reason="fewer than 3 perturbations. Record more")
    inside = np.concatenate([np.arange(w.start, w.stop) for w in windows])
    ends = np.cumsum([w.stop - w.start for w in windows])[:-1]
    x, instants = regressors[inside], time[inside]
    spline = scipy.interpolate.CubicSpline(time, torque)
    slope = spline.derivative()

    def late(instants: np.ndarray, delay_s: float | np.ndarray) -> np.ndarray:
        return np.clip(instants + delay_s, time[0], time[-1])

    steps = round(LONGEST_S / STEP_S)
    thin = slice(None, None, max(1, min(int(THIN_S / (time[1] - time[0])), inside.size // FEWEST_COMPARED)))
    basis = np.linalg.qr(x[thin] / np.linalg.norm(x[thin], axis=0))[0]
    grid = STEP_S * np.arange(-steps, steps + 1)

    def unexplained(y: np.ndarray) -> float:
        return float(y @ y - np.sum((y @ basis) ** 2))

    left = np.array([unexplained(y) for y in spline(late(instants[thin], grid[:, None]))])
    delay = float(grid[np.argmin(left)])
    for _ in range(6):
        at = late(instants, delay)
        y, rate = spline(at), slope(at)
        rows = np.column_stack([x, -rate])
        pairs = list(zip(np.split(rows, ends), np.split(y, ends), strict=True))
        found = products_of_perturbations(pairs)
        if found is None:
            break
        step = float(found[:, 3].mean())
        if abs(step) < 1e-7 or not abs(delay + step) <= LONGEST_S:
            break
        delay += step
    if found is None:
        return DelayProfile(reason=ADVICE)
    if abs(delay + step) > LONGEST_S:
        return DelayProfile(reason=f"no delay up to {1e3 * LONGEST_S:g} ms explains the torque. {ADVICE}")
    known = products_of_perturbations([(r[:, :3], y) for r, y in pairs])
    if known is None:
        return DelayProfile(reason=ADVICE)
    # what noise and derivatives leave uncertain of the sum of squares, per degree of freedom
    least = unexplained(spline(late(instants[thin], delay)))
    power = float(np.sum(y[thin] ** 2))
    residual = spline(late(time, delay)) - regressors @ known.mean(axis=0)
    noise = least / max(_freedom(residual[at_rest]) * inside.size / at_rest.sum(), 1.0)
    floor = (SPLINE_HZ * (time[1] - time[0])) ** 4 * power
    test = residual_test(residual, torque, windows, at_rest)
    if test.p < CHANCE:  # what perturbations leave above the residual at rest is not noise
        floor += least * (1.0 - 1.0 / test.ratio**2)
    # where the sum of squares is larger by the floor, a rectangular distribution ends
    among = _among_others(grid, left, delay, least, noise + floor, floor / 3.0, ADVICE)
    if not among.determined:
        return among
    rest, rest_freedom = error_of_mean(residual[at_rest])

    def errors(pseudo_values: np.ndarray, of_floor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        regressors = [r[:, : pseudo_values.shape[1]] for r, _ in pairs]
        shared = rest * of_constant_torque(regressors, crossed=True), rest_freedom
        return in_quadrature(scatter(pseudo_values), shared, (of_floor, np.inf))

    per_delay = -products_of_perturbations([(r[:, :3], -r[:, 3]) for r, _ in pairs]).mean(axis=0)
    free, freedom = errors(found, among.standard_error_s * np.append(per_delay, 1.0))
    added = np.sqrt(np.maximum(free[:3] ** 2 - errors(known, np.zeros(3))[0] ** 2, 0.0))
    return DelayProfile(delay, float(free[3]), float(freedom[3]), added).narrow(confidence, ADVICE)


def parts_differ(
    parameters: Annotated[np.ndarray, "(n, 3)"],
    direction: Annotated[np.ndarray, "(n,)"],
    of_rest: Annotated[np.ndarray, "(n, 3)"] | None = None,
    rest_freedom: float = np.inf,
) -> tuple[tuple[str, str, float, float], ...]:
    """Parameters that differ between halves of the record, or between directions.

    parameters: I, B, K of each perturbation, in order of time.
    direction: sign of each perturbation.
    of_rest: their change by one standard error of the torque at rest, which acts on both directions in the
    opposite way.
    rest_freedom: degrees of freedom of this standard error.

    Returns: name, what differs, and the two means; the largest difference first.
    """
    shared = np.zeros_like(parameters) if of_rest is None else of_rest
    order = np.arange(len(parameters)) < len(parameters) // 2
    found = []
    for what, first in (("the first and the second half", order), ("the two directions", direction > 0.0)):
        one, other = parameters[first], parameters[~first]
        if min(len(one), len(other)) < 3:
            continue
        means = one.mean(axis=0), other.mean(axis=0)
        rest = np.abs(shared[first].mean(axis=0) - shared[~first].mean(axis=0))
        p, matters = welch(*means, scatter(one), scatter(other), (rest, rest_freedom))
        found += [
            (float(p[k]), PARAMETERS[k], what, float(means[0][k]), float(means[1][k]))
            for k in np.flatnonzero(matters)
        ]
    return tuple(tuple(each[1:]) for each in sorted(found))


def welch(
    one: np.ndarray, other: np.ndarray, *errors: tuple[np.ndarray, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Probability of a difference of two estimates by chance, and whether it is none and matters; shape (p,).

    errors: standard errors of either, and of what is common to both, with their degrees of freedom.
    """
    error, freedom = in_quadrature(*errors)
    difference = np.abs(one - other)
    p = 2.0 * scipy.special.stdtr(freedom, -difference / np.maximum(error, 1e-300))
    return p, (p < CHANCE) & (difference > LEAST_DIFFERENCE * np.abs(one + other) / 2.0)


def _among_others(
    grid: np.ndarray,
    left: np.ndarray,
    delay_s: float,
    least: float,
    noise: float,
    square: float,
    advice: str,
) -> DelayProfile:
    """Delay with the standard error that the sums of squares at the delays beside it leave.

    grid, left: delays from the longest early to the longest late one (s), and the sums of squares there.
    least, noise: sum of squares at the delay, and mean square.
    square: what the sum of squares is larger by, one standard error from the delay.
    advice: why it is undetermined where the sum of squares at another delay is hardly larger.
    """
    other = np.abs(grid - delay_s) > STEP_S / 2.0
    apart, rise = np.abs(grid - delay_s)[other], np.maximum(left[other] - least, 1e-300)
    if rise.min() < UNLIKELY * noise:
        excluded = bool(left[grid.size // 2] - least > UNLIKELY * noise)
        return DelayProfile(delay_s, reason=advice, excludes_zero=excluded)
    return DelayProfile(delay_s, float((apart * np.sqrt(square / rise))[apart < 2.0 * STEP_S].max()), np.inf)


def _moments_of_blocks(
    time: np.ndarray,
    regressors: Annotated[np.ndarray, "(n, p)"],
    slope: np.ndarray,
    torque: Callable[[np.ndarray], np.ndarray],
    delay_s: float,
    kept: slice,
    block: int,
) -> tuple[Annotated[np.ndarray, "(blocks, p + 1)"], Annotated[np.ndarray, "(p + 1, p + 1)"]]:
    """Rows of regressors and slope of the torque times their residual, summed by block, and their products.

    Blocks of time follow each other, so that a long record needs the memory of a few.
    """
    first, last, _ = kept.indices(time.size)
    spans = [slice(k, min(k + block, last)) for k in range(first, last, block)]

    def part(span: slice) -> tuple[np.ndarray, np.ndarray]:
        return np.column_stack([regressors[span], -slope[span]]), torque(time[span] + delay_s)

    size = regressors.shape[1] + 1
    products, targets = np.zeros((size, size)), np.zeros(size)
    for rows, y in map(part, spans):
        products += rows.T @ rows
        targets += rows.T @ y
    scale = 1.0 / np.sqrt(np.diag(products))
    solution = scale * np.linalg.solve(products * scale[:, None] * scale, scale * targets)
    moments = np.array([rows.T @ (y - rows @ solution) for rows, y in map(part, spans)])
    return moments, products


def halves_of_record(
    regressors: Annotated[np.ndarray, "(n, 4)"], torque: np.ndarray, block: int
) -> tuple[tuple[str, str, float, float], ...]:
    """I, B, K and offset that differ between the halves of a record of continuous movement.

    regressors: theta'' (rad/s²), theta' (rad/s), theta (rad) and 1, filtered.
    torque: tau (N·m), filtered.
    block: length of the blocks whose residuals may be correlated (samples).

    Returns: as `parts_differ`, with ``offset`` (N·m) beside I, B and K.
    """
    half = torque.size // 2
    if half < 4 * block:
        return ()
    parts, solutions = (slice(half), slice(half, None)), []
    for part in parts:
        size = np.maximum(np.linalg.norm(regressors[part], axis=0), 1e-300)
        solution, _, rank, _ = np.linalg.lstsq(regressors[part] / size, torque[part], rcond=1e-7)
        if rank < size.size:  # the joint rests in this half
            return ()
        solutions.append(solution / size)
    one, other = solutions
    difference = np.abs(one - other)
    least = LEAST_DIFFERENCE * np.append(np.abs(one + other)[:3] / 2.0, np.std(torque))
    if not (difference > least).any():
        return ()
    (error, freedom, _), (other_error, other_freedom, _) = (
        errors_over_blocks(regressors[part], torque[part] - regressors[part] @ solution, block)
        for part, solution in zip(parts, solutions, strict=True)
    )
    both, common = in_quadrature((error, freedom), (other_error, other_freedom))
    p = 2.0 * scipy.special.stdtr(common, -difference / np.maximum(both, 1e-300))
    found = [
        (float(p[k]), name, "the first and the second half", float(one[k]), float(other[k]))
        for k, name in enumerate((*PARAMETERS, "offset"))
        if p[k] < CHANCE and difference[k] > least[k]
    ]
    return tuple(tuple(each[1:]) for each in sorted(found))


def explains_less(training: float, held_out: float) -> bool:
    """True if a model explains much less of the held-out part than of the fitted one (VAFs in %)."""
    left = 100.0 - held_out, 100.0 - training
    return left[0] > LARGEST_GROWTH * left[1] and left[0] - left[1] > LEAST_GROWTH


def wandering(
    residual: np.ndarray, fitted: np.ndarray, windows: list[Perturbation], at_rest: np.ndarray, rate_hz: float
) -> float:
    """Range of the residual before the perturbations (N·m) if it differs by more than noise; otherwise 0.

    residual: measured less predicted torque, filtered, shape (n,).
    fitted: the measured torque, relative to rest, shape (n,).
    """
    length = round(BASELINE_S * rate_hz)
    means = [float(x.mean()) for x in (residual[before] for before in baselines(windows, rate_hz)) if x.size]
    rest = residual[at_rest]
    rest = rest[: rest.size // length * length].reshape(-1, length).mean(axis=1)
    if len(means) < 3 or len(rest) < 3:
        return 0.0
    ratio = np.var(means, ddof=1) / max(np.var(rest, ddof=1), 1e-300)
    signal = np.concatenate([fitted[w.start : w.stop] for w in windows])
    size = float(np.ptp(means))
    chance = float(scipy.stats.f.sf(ratio, len(means) - 1.0, len(rest) - 1.0))
    return size if chance < CHANCE and size > LEAST_WANDER * float(np.std(signal)) else 0.0


def baselines(windows: list[Perturbation], rate_hz: float) -> list[slice]:
    """Samples before each perturbation, from which its own zero is taken; empty where there are none."""
    length, gap = round(BASELINE_S * rate_hz), round(BASELINE_GAP_S * rate_hz)
    ends = [0, *(w.stop for w in windows[:-1])]
    return [
        slice(max(end, w.start - gap - length), max(end, w.start - gap))
        for w, end in zip(windows, ends, strict=True)
    ]


def from_own_zero(
    x: np.ndarray, windows: list[Perturbation], at_rest: np.ndarray, rate_hz: float
) -> np.ndarray:
    """Signal less its mean before each perturbation, and at rest less its mean there; shape (n,).

    A perturbation with less than half of `BASELINE_S` before it takes the zero of the one before.
    """
    zero, mean = np.empty_like(x), float(x[at_rest].mean())
    zero[:] = mean
    for before in baselines(windows, rate_hz):
        if before.stop - before.start >= 0.5 * BASELINE_S * rate_hz:
            mean = float(x[before].mean())
        zero[before.start :] = mean
    zero[at_rest] = x[at_rest].mean()
    return x - zero
