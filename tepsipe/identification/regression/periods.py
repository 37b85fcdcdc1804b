"""The linear joint nearest to a trial of periodic torque perturbation: regression over whole periods.

At the lines of the perturbation, with T_k and Y_k the spectra of torque and angle in period k,

    T_k = (K + j w B - w^2 I) Y_k + j w d T_k + E_k

where d is the delay of the torque after its record. It is linear in I, B, K and d. Noise of the angle and
torque ripple are unrelated between periods, so the sum of the other periods' regressors is the instrument of
a period; least squares would mistake the noise of the angle for softness. A
joint that is not linear distorts every period alike: its distortions are part of the nearest linear joint, as
in a linear fit of the true torque, and no noise.

The scatter of E_k between periods gives the variance of every line, and from these the variance of the
parameters follows. Each line has 2 (periods - 1) degrees of freedom; their combination follows Welch and
Satterthwaite.
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.identification.consistency import welch
from tepsipe.signals.spectra import period_spectra

# typical magnitude of I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad) and of the delay (s)
TYPICAL = np.array([0.01, 0.1, 10.0, 1e-3])
# the lower part of the band, for the sensitivity to the band
NARROW = 0.6
LEAST_LINES = 6
# delays that are searched: the longest and the step (s); and refinements of the best one
LONGEST_DELAY_S, DELAY_STEP_S, REFINEMENTS = 0.06, 2e-3, 3
# cutoffs of a filter that are tried (Hz), and part of the sum of squares that the right one leaves at most
CUTOFFS_HZ, LEAST_GAIN = np.geomspace(3.0, 40.0, 40), 0.5


@dataclass(frozen=True)
class PeriodicRecord:
    """A record without the transient at its start."""

    torque: Annotated[np.ndarray, "(n,)", "N·m"]
    angle: Annotated[np.ndarray, "(n,)", "rad"]
    rate_hz: float
    period_s: float
    """Sampling rate, and period, a whole number of samples."""
    band_hz: tuple[float, float]
    """Lowest and highest excited frequency."""

    def spectra(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Frequencies (Hz), and spectra of torque and angle in each period (N·m, rad)."""
        about = self.rate_hz, self.period_s, self.band_hz
        frequency, torques = period_spectra(self.torque, *about)
        return frequency, torques, period_spectra(self.angle, *about)[1]


@dataclass(frozen=True)
class PeriodFit:
    """Linear joint nearest to a trial."""

    parameters: Annotated[np.ndarray, "(3,)"]
    type_a: Annotated[np.ndarray, "(3,)"]
    """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad), and their standard uncertainties from the scatter of the
    periods."""
    freedom: float
    """Degrees of freedom of ``type_a``, the fewest of the three."""
    delay_s: float
    """Delay of the torque after its record."""
    of_band: Annotated[np.ndarray, "(3,)"]
    """Change with the lower part of the band (units of the parameters)."""


def fit_periods(record: PeriodicRecord) -> PeriodFit:
    """Fit I, B, K and a delay to the whole periods of a record."""
    low, high = record.band_hz
    frequency, torques, angles = record.spectra()
    below = frequency <= NARROW * high + 1e-9
    if below.sum() < LEAST_LINES:
        raise InputError(
            f"expected at least {LEAST_LINES} multiples of 1/{record.period_s:g} Hz between {low:g} and "
            f"{NARROW * high:g} Hz, found {below.sum()}: widen excited_band_hz, or set "
            "perturbation_period_s to null"
        )
    whole, type_a, freedom = _fit(frequency, torques, angles)
    narrow, _, _ = _fit(frequency[below], torques[:, below], angles[:, below])
    return PeriodFit(whole[:3], type_a[:3], float(freedom[:3].min()), float(whole[3]), (narrow - whole)[:3])


def torque_delay(record: PeriodicRecord) -> float:
    """Delay of the torque after its record, also where j w d is no small number.

    The delay on a grid that leaves the least residual of the linear joint, then refined by the regression.

    Returns: delay (s), negative for a torque that acts before its record.
    """
    frequency, torques, angles = record.spectra()
    turn, mean = -2j * np.pi * frequency, angles.mean(axis=0, keepdims=True)

    def residual(delay_s: float) -> float:
        # least squares, in which the delay may refine what the step leaves
        delayed = torques.mean(axis=0, keepdims=True) * np.exp(delay_s * turn)
        return _unexplained(*_columns(frequency, delayed, mean))

    steps = round(LONGEST_DELAY_S / DELAY_STEP_S)
    # the shortest of equal delays
    tried = sorted(DELAY_STEP_S * np.arange(-steps, steps + 1), key=abs)
    delay = float(min(tried, key=residual))
    for _ in range(REFINEMENTS):
        parameters, _, _ = _fit(frequency, torques * np.exp(delay * turn), angles)
        delay += float(np.clip(parameters[3], -DELAY_STEP_S, DELAY_STEP_S))
    return delay


def filtered_angle(record: PeriodicRecord) -> bool:
    """True if the angle probably went through a zero-lag low-pass before it was recorded.

    A Butterworth filter of second order, forwards and backwards, divides the angle by g = 1 + (f / cutoff)^4.
    The equation with g Y_k in place of Y_k, divided by g, leaves at most `LEAST_GAIN` of the squares that Y_k
    leaves with the same weights, for some cutoff.
    """
    frequency, torques, angles = record.spectra()
    torques, angles = (x.mean(axis=0, keepdims=True) for x in (torques, angles))

    def unexplained(gain: np.ndarray, weight: np.ndarray) -> float:
        return _unexplained(*_columns(frequency, torques, gain * angles), weight)

    gains = 1.0 + (frequency / CUTOFFS_HZ[:, None]) ** 4
    return any(unexplained(g, 1.0 / g) < LEAST_GAIN * unexplained(np.ones_like(g), 1.0 / g) for g in gains)


def periods_differ(record: PeriodicRecord) -> bool:
    """True if I, B or K of the first and the last periods differ by more than they scatter."""
    torque, angle, length = record.torque, record.angle, record.rate_hz * record.period_s
    half = int(torque.size / length) // 2 * round(length)
    if half < 2 * round(length):
        return False
    one, other = (
        fit_periods(replace(record, torque=torque[part], angle=angle[part]))
        for part in (slice(half), slice(torque.size - half, None))
    )
    errors = ((fit.type_a, fit.freedom) for fit in (one, other))
    return bool(welch(one.parameters, other.parameters, *errors)[1].any())


def without_transient(
    omega: Annotated[np.ndarray, "(lines,)", "rad/s"], spectra: Annotated[np.ndarray, "(periods, lines)"]
) -> np.ndarray:
    """Spectra of periods, orthogonal to every transient a + j w b with real a and b.

    omega: angular frequencies w.
    spectra: spectra of one or more signals.
    Returns: in its unit.
    """
    w = omega.reshape(-1, *[1] * (spectra.ndim - 2))
    real = spectra.real - spectra.real.mean(axis=1, keepdims=True)
    slope = (w * spectra.imag).sum(axis=1, keepdims=True) / np.sum(omega**2)
    return real + 1j * (spectra.imag - w * slope)


def _columns(frequency, torques, angles):
    """Columns of I, B, K and the delay over their typical magnitudes, and torques, without transients."""
    omega = 2.0 * np.pi * frequency
    columns = np.stack([-(omega**2) * angles, 1j * omega * angles, angles, 1j * omega * torques], axis=-1)
    return without_transient(omega, columns * TYPICAL), without_transient(omega, torques)


def _unexplained(columns, wanted, weight=1.0):
    """Sum of squares that least squares leave of the first period, with weights of its lines."""
    weighted = (np.multiply(weight, x[0].T).T for x in (columns, wanted))
    x, y = (np.concatenate([z.real, z.imag]) for z in weighted)
    return float(np.sum((y - x @ np.linalg.lstsq(x, y, rcond=None)[0]) ** 2))


def _fit(frequency, torques, angles):
    """Parameters with the delay, their standard uncertainties, and degrees of freedom."""
    periods = torques.shape[0]
    columns, torques = _columns(frequency, torques, angles)
    others = columns.sum(axis=0) - columns
    normal = np.einsum("kft,kfu->tu", others.conj(), columns).real
    parameters = np.linalg.solve(normal, np.einsum("kft,kf->t", others.conj(), torques).real)
    rest = torques - columns @ parameters
    # variance of the mean over the periods, of real and imaginary part alike
    scattered = np.abs(rest - rest.mean(axis=0)) ** 2
    variance = scattered.sum(axis=0) / (2.0 * (periods - 1) * periods)
    mean = columns.mean(axis=0)
    weights = np.linalg.inv(np.einsum("ft,fu->tu", mean.conj(), mean).real) @ mean.T
    parts = np.abs(weights) ** 2 * variance
    total = parts.sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        freedom = np.where(
            total > 0.0, 2.0 * (periods - 1) * total**2 / np.sum(parts**2, axis=1), 2.0 * (periods - 1)
        )
    return parameters * TYPICAL, np.sqrt(total) * TYPICAL, freedom
