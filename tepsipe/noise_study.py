"""TEP-SIPE on simulated data with measurement noise (thesis sections 2-1-3, 3-1-3 and 4-1-3).

Symbols: theta leg angle from its rest, positive towards +y (rad); tau torque of the joint (Nm); y_f belt
motion (m); F the low-pass filter, D the derivative. m, r, I_l, g as in `inverse_dynamics`; p = m r,
J = I_l + m r^2 + I, k_g = m g r.

    J theta'' + B theta' + (K - k_g) theta = -p y_f''                             linearised motion
    tau = a y_f'' + b theta'' + c theta' + d theta                                any torque equation
    I* = b - a J / p,  B* = c - a B / p,  K* = d - a (K - k_g) / p                what a fit to it returns

Noise n is white and Gaussian; its variance is the signal's power over the SNR. The filter and the
derivative are linear, F(theta + n) = F theta + F n, so the signal is filtered once and only the noise of
each draw passes F, D F and D D F, and only around the windows. The signal's own rates are those that were
simulated: what differentiating *it* would cost is left out. Signals are filtered once per trial, and noise
is drawn once per trial, target and SNR: all processings share both.

Noise in theta'', theta', theta biases least squares (errors in variables). Belt motion Z = (y_f'', y_f',
y_f) drives the leg, but knows nothing of the noise, so E Z'n = 0 and the instrumental variables

    (I, B, K) = (sum Z'X)^-1 sum Z'tau,     X = (theta'', theta', theta), summed over all perturbations

are consistent for noise on tau, on theta and on both. They cost one 3 x 3 system per draw and use what
the treadmill records anyway.
"""

import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, product

import numpy as np
from scipy import linalg, signal

from tepsipe.errors import InputError, listed, quoted
from tepsipe.filters import butterworth_lowpass
from tepsipe.inverse_dynamics import TORQUE_PATHWAYS, Foot, Leg, foot_torque, foot_torque_as_printed
from tepsipe.rigid_segments import derivative
from tepsipe.second_order import PARAMETERS, UNITS

NOISE_ON = {"none": (), "tau": ("tau",), "theta": ("theta",), "both": ("tau", "theta")}
TORQUES = ("foot-printed", "foot", *TORQUE_PATHWAYS)
# rows of a trial's signals: theta'', theta'; theta; y_f'', y_f', y_f; tau by every equation
ROWS = {"rates": slice(0, 2), "angle": slice(2, 3), "belt": slice(3, 6)}
ROWS |= {name: slice(6 + k, 7 + k) for k, name in enumerate(TORQUES)}
CHUNK_DRAWS = 50  # some 10 MB, which processors keep in their cache
MEMORY_PERIODS = 6.0  # of the cutoff frequency, after which the filter has forgotten to 1e-11


@dataclass(frozen=True)
class SimulatedTrial:
    """Signals of a simulated trial of the ankle dummy, without noise, on a regular clock.

    Attributes
    ----------
    name : str
        Condition.
    time : ndarray, shape (n,)
        Instants (s).
    theta, theta_d, theta_dd : ndarray, shape (n,)
        Leg angle from its rest (rad), rate (rad/s) and acceleration (rad/s2) of the joint's sensor.
    y_leg_dd, z_leg_dd : ndarray, shape (n,)
        Acceleration of the leg's centre of mass (m/s2).
    y_foot, y_foot_d, y_foot_dd : ndarray, shape (n,)
        Motion of the belt, the foot and the ankle from rest (m, m/s, m/s2).
    f_y, f_z : ndarray, shape (n,)
        Forces of the belt on the foot (N).
    m_x : ndarray, shape (n,)
        Moment of the belt on the foot about the ankle's place at rest, in the belt's surface (Nm).
    windows : ndarray, shape (w, 2)
        First sample of every perturbation and the first after it (samples).
    leg, foot : Leg, Foot
        Masses (kg), lengths (m), inertia (kg m2).
    truth : ndarray, shape (3,)
        I (Nms2/rad), B (Nms/rad), K (Nm/rad) of the simulated joint; estimators do not read it.
    """

    name: str
    time: np.ndarray
    theta: np.ndarray
    theta_d: np.ndarray
    theta_dd: np.ndarray
    y_leg_dd: np.ndarray
    z_leg_dd: np.ndarray
    y_foot: np.ndarray
    y_foot_d: np.ndarray
    y_foot_dd: np.ndarray
    f_y: np.ndarray
    f_z: np.ndarray
    m_x: np.ndarray
    windows: np.ndarray
    leg: Leg
    foot: Foot
    truth: np.ndarray

    @property
    def rate_hz(self) -> float:
        """Sampling rate (Hz)."""
        return float((self.time.size - 1) / (self.time[-1] - self.time[0]))

    @property
    def regressors(self) -> np.ndarray:
        """Angular acceleration (rad/s2), rate (rad/s), angle (rad), shape (3, n)."""
        return np.stack([self.theta_dd, self.theta_d, self.theta])

    @property
    def instruments(self) -> np.ndarray:
        """Acceleration (m/s2), velocity (m/s), position (m) of the belt, shape (3, n)."""
        return np.stack([self.y_foot_dd, self.y_foot_d, self.y_foot])

    def torque(self, pathway: str) -> np.ndarray:
        """Torque by one of the equations of `inverse_dynamics` (Nm), shape (n,)."""
        if pathway == "foot-printed":
            return foot_torque_as_printed(self.foot, self.leg, self.f_y, self.y_leg_dd)
        if pathway == "foot":
            return foot_torque(self.foot, self.f_y, self.f_z, self.m_x, self.y_foot, self.y_foot_dd)
        motion = (self.theta, self.theta_dd, self.y_leg_dd, self.z_leg_dd)
        return TORQUE_PATHWAYS[pathway](self.leg, *motion)


@dataclass(frozen=True)
class Processing:
    """One reading of how noisy signals become parameters.

    Attributes
    ----------
    torque : {"foot-printed", "foot", "leg", "leg-printed"}
        Equation of the torque.
    estimator : {"segment-regression", "instrumental-variables"}
        Least squares per perturbation, or instrumental variables over all of them.
    filtered : {"all", "noisy", "torque-and-angle"}
        What passes the low-pass: every signal, only those that have noise (theta with its rates), or
        torque and angle but not the rates.
    noisy_rates : bool
        Whether noise on theta reaches the rates, as it does by differentiating, or not, as from sensors of
        their own (-).
    power : {"trial", "unit"}
        Power that the SNR refers to: the signal's mean square over the trial, its mean not removed, or 1 in
        the signal's own unit squared, as where a noise function is not told to measure the signal.
    """

    torque: str
    estimator: str
    filtered: str
    noisy_rates: bool = True
    power: str = "trial"


# as-printed: the text of sections 2-1-3 and 3-1-3; as-tabulated: the reading that leads to Table 4-4;
# recommended-regression: right torque, one filter for all, least squares; recommended: the belt as instrument
PROCESSINGS = {
    "as-printed": Processing("foot-printed", "segment-regression", "noisy"),
    "as-tabulated": Processing("foot-printed", "segment-regression", "torque-and-angle", False, "unit"),
    "recommended-regression": Processing("leg", "segment-regression", "all"),
    "recommended": Processing("leg", "instrumental-variables", "all"),
}


def apparent_impedance(leg: Leg, foot: Foot, parameters: np.ndarray) -> np.ndarray:
    """What a fit to the printed equation of the foot returns for a joint, without any noise.

    tau* = -F_y l_f / 2 + F_Ay l_f / 2 has a = -(m_f l_f / 2 + m l_f), b = -l_f m r, c = d = 0.

    Parameters
    ----------
    leg, foot : Leg, Foot
        m, r, I_l, g and m_f, l_f (kg, m, kg m2, m/s2).
    parameters : ndarray, shape (3,)
        I (Nms2/rad), B (Nms/rad), K (Nm/rad) of the joint.

    Returns
    -------
    ndarray, shape (3,)
        I*, B*, K* (units as ``parameters``).
    """
    inertia, damping, stiffness = parameters
    p = leg.mass_kg * leg.com_m
    about_ankle = leg.inertia_kgm2 + p * leg.com_m + inertia
    k_g = p * leg.gravity_m_per_s2
    a = -foot.height_m * (0.5 * foot.mass_kg + leg.mass_kg)
    b = -foot.height_m * p
    return np.array([b, 0.0, 0.0]) - a / p * np.array([about_ankle, damping, stiffness - k_g])


# ---- signals -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class FilteredTrial:
    """A simulated trial, its signals with and without the low-pass, and its windows: what all cells share.

    Windows are as long as the longest; what lies beyond a shorter one's end is not inside.

    Attributes
    ----------
    simulated : SimulatedTrial
        The trial.
    raw, lowpassed : ndarray, shape (10, n)
        Signals by `ROWS` (rad/s2, rad/s, rad, m/s2, m/s, m, Nm).
    within : ndarray, shape (w, s)
        Samples of every window.
    inside : ndarray of bool, shape (w, s)
        Whether they belong to it (-).
    operators : ndarray, shape (3, s + 2 memory, s)
        D D F, D F, F from the samples around a window to those in it.
    noise_samples : ndarray, shape (k,)
        Samples of the trial whose noise reaches a window.
    noise_index : ndarray, shape (w, s + 2 memory)
        Position in ``noise_samples`` of the samples around every window.
    """

    simulated: SimulatedTrial
    raw: np.ndarray
    lowpassed: np.ndarray
    within: np.ndarray
    inside: np.ndarray
    operators: np.ndarray
    noise_samples: np.ndarray
    noise_index: np.ndarray

    def signals(self, name: str, lowpassed: bool) -> np.ndarray:
        """Raw or low-passed signals by their name in `ROWS` (units there), shape (k, n)."""
        return (self.lowpassed if lowpassed else self.raw)[ROWS[name]]

    def filtered_noise(self, unit_noise: np.ndarray) -> np.ndarray:
        """F n (-) in the windows, shape (draws, w, s), of noise n of unit variance, shape (draws, k)."""
        return unit_noise[:, self.noise_index] @ self.operators[2]

    def differentiated_noise(self, unit_noise: np.ndarray) -> np.ndarray:
        """D D F n (1/s2), D F n (1/s), F n (-) in the windows, shape (draws, w, 3, s), of n as above."""
        around = unit_noise[:, self.noise_index]
        noise = np.empty((*around.shape[:2], 3, self.within.shape[1]))
        for row, operator in enumerate(self.operators):
            np.matmul(around, operator, out=noise[:, :, row])
        return noise


def filtered_trial(trial: SimulatedTrial, cutoff_hz: float = 20.0, order: int = 4) -> FilteredTrial:
    """Filter the signals without noise, and prepare the filter of the noise around the windows.

    Parameters
    ----------
    trial : SimulatedTrial
        Signals without noise (s, rad, m, N, Nm).
    cutoff_hz : float
        Of the low-pass filter (Hz).
    order : int
        Of the filter, both passes together (-).

    Returns
    -------
    FilteredTrial
        What all processings, noise targets and SNRs share (units there).

    Raises
    ------
    InputError
        If there is no window, or one lies too near the trial's ends.
    """
    rate, samples = trial.rate_hz, trial.time.size
    windows = np.asarray(trial.windows, dtype=int).reshape(-1, 2)
    if windows.shape[0] == 0:
        raise InputError(
            f"{trial.name}: expected windows of perturbations, found none: "
            "say where the trial's perturbations start and stop"
        )
    lengths = windows[:, 1] - windows[:, 0]
    memory = filter_memory(rate, cutoff_hz)
    longest = int(lengths.max())
    if lengths.min() < 4 or windows[:, 0].min() < memory or windows[:, 0].max() + longest + memory > samples:
        raise InputError(
            f"{trial.name}: expected windows of 4 samples or more, {memory} samples or more from the trial's "
            f"ends, found samples {windows[:, 0].min()} to {windows[:, 1].max()} of {samples} and "
            f"{lengths.min()} samples in the shortest: leave more rest around the perturbations"
        )
    raw = np.concatenate([trial.regressors, trial.instruments, [trial.torque(name) for name in TORQUES]])
    around = windows[:, :1] - memory + np.arange(longest + 2 * memory)
    noise_samples, noise_index = np.unique(around, return_inverse=True)
    return FilteredTrial(
        simulated=trial,
        raw=raw,
        lowpassed=butterworth_lowpass(raw, rate, cutoff_hz, order, axis=-1),
        within=windows[:, :1] + np.arange(longest),
        inside=np.arange(longest) < lengths[:, None],
        operators=_operators(longest, rate, cutoff_hz, order),
        noise_samples=noise_samples,
        noise_index=noise_index.reshape(around.shape),
    )


def _operators(length: int, rate_hz: float, cutoff_hz: float, order: int) -> np.ndarray:
    """D D F, D F, F from the samples around a window to those in it, shape (3, length + 2 memory, length)."""
    memory = filter_memory(rate_hz, cutoff_hz)
    span = length + 2 * memory
    time = np.arange(span) / rate_hz
    filtered = butterworth_lowpass(np.eye(span), rate_hz, cutoff_hz, order)
    first = derivative(time, filtered)
    operators = np.stack([derivative(time, first), first, filtered])[:, memory : memory + length]
    return np.ascontiguousarray(operators.transpose(0, 2, 1))


def filter_memory(rate_hz: float, cutoff_hz: float) -> int:
    """How far the low-pass filter (Hz) reaches to either side (samples)."""
    return int(np.ceil(MEMORY_PERIODS * rate_hz / cutoff_hz - 1e-6))


# ---- noise -------------------------------------------------------------------------------------


def cell_generators(seed: int, *names: object) -> tuple[np.random.Generator, np.random.Generator]:
    """Generators of the noise on tau and on theta of one cell.

    Parameters
    ----------
    seed : int
        Of the study (-).
    names : object
        What the cell is called (-): another name gives other noise, and nothing else does.

    Returns
    -------
    tuple of numpy.random.Generator
        For tau and for theta (unit variance).
    """
    generator = np.random.default_rng([seed, zlib.crc32("/".join(map(str, names)).encode())])
    tau, theta = generator.spawn(2)
    return tau, theta


def noise_deviation(trial: FilteredTrial, processing: Processing, noise_on: str, snr_db: float) -> dict:
    """Standard deviation of the noise before it is filtered.

    Parameters
    ----------
    trial : FilteredTrial
        Signals without noise (Nm, rad).
    processing : Processing
        Torque and power that the SNR refers to.
    noise_on : {"none", "tau", "theta", "both"}
        What has noise.
    snr_db : float
        Signal power over noise power (dB); with the target "none" it does not matter.

    Returns
    -------
    dict of str to float
        Of tau (Nm) and theta (rad); 0 where there is none.

    Raises
    ------
    InputError
        If the target of the noise is unknown or the SNR is not a finite number.
    """
    if noise_on not in NOISE_ON:
        raise InputError(
            f"noise: expected a target of {listed(NOISE_ON)}, found {quoted(noise_on)}: correct it"
        )
    number = isinstance(snr_db, int | float | np.number) and not isinstance(snr_db, bool)
    if NOISE_ON[noise_on] and not (number and np.isfinite(snr_db)):
        raise InputError(
            f"signal-to-noise ratio: expected a finite number of decibels, found {quoted(snr_db)}: "
            "choose the noise target 'none' for signals without noise"
        )
    signals = {"tau": trial.signals(processing.torque, False), "theta": trial.signals("angle", False)}
    rms = {
        name: np.sqrt(np.mean(x**2)) if processing.power == "trial" else 1.0 for name, x in signals.items()
    }
    if not NOISE_ON[noise_on]:
        return dict.fromkeys(signals, 0.0)
    ratio = 10.0 ** (-snr_db / 20.0)
    return {name: float(ratio * rms[name]) if name in NOISE_ON[noise_on] else 0.0 for name in signals}


def noise_chunks(
    trial: FilteredTrial, noise_on: str, draws: int, generators: tuple[np.random.Generator, ...]
) -> Iterator[dict[str, np.ndarray]]:
    """Draw noise of unit variance and filter it, some draws at a time.

    Parameters
    ----------
    trial : FilteredTrial
        Its windows and filter.
    noise_on : {"none", "tau", "theta", "both"}
        What has noise.
    draws : int
        Number of draws (-); one is enough without noise.
    generators : tuple of numpy.random.Generator
        For the noise on tau and on theta.

    Yields
    ------
    dict of str to ndarray
        Of what has noise: ``tau``, `FilteredTrial.filtered_noise`; ``theta``, its ``differentiated_noise``.
    """
    filters = {"tau": trial.filtered_noise, "theta": trial.differentiated_noise}
    count = draws if NOISE_ON[noise_on] else 1
    for start in range(0, count, CHUNK_DRAWS):
        shape = (min(CHUNK_DRAWS, count - start), trial.noise_samples.size)
        yield {
            name: filters[name](generator.standard_normal(shape))
            for name, generator in zip(filters, generators, strict=True)
            if name in NOISE_ON[noise_on]
        }


# ---- signals and noise of one processing -------------------------------------------------------


@dataclass(frozen=True)
class WindowedTrial:
    """Processed signals without noise in the windows, and where noise enters.

    What lies beyond the end of a window that is shorter than others is 0 in every signal.

    Attributes
    ----------
    trial : FilteredTrial
        The trial, its windows and filter.
    estimator : {"segment-regression", "instrumental-variables"}
        See `Processing`.
    torque : ndarray, shape (w, s)
        tau (Nm).
    regressors, instruments : ndarray, shape (w, 3, s)
        theta'', theta', theta (rad/s2, rad/s, rad); y_f'', y_f', y_f (m/s2, m/s, m).
    gram : ndarray, shape (4, 4)
        Sums of products of theta'', theta', theta, tau over the whole trial.
    deviation : dict of str to float
        Standard deviation of the noise on tau (Nm) and theta (rad).
    noise_rows : ndarray, shape (3,)
        1 where noise on theta reaches theta'', theta', theta, else 0 (-).
    """

    trial: FilteredTrial
    estimator: str
    torque: np.ndarray
    regressors: np.ndarray
    instruments: np.ndarray
    gram: np.ndarray
    deviation: dict[str, float]
    noise_rows: np.ndarray

    def torque_noise(self, filtered: np.ndarray) -> np.ndarray:
        """Noise on tau in the windows (Nm), shape (draws, w, s), from `FilteredTrial.filtered_noise` (-)."""
        return self.deviation["tau"] * self.trial.inside * filtered

    def regressor_noise(self, differentiated: np.ndarray) -> np.ndarray:
        """Noise on theta'', theta', theta in the windows (rad/s2, rad/s, rad), shape (draws, w, 3, s).

        From `FilteredTrial.differentiated_noise` (1/s2, 1/s, -).
        """
        inside = self.trial.inside[:, None] * self.noise_rows[:, None]
        return self.deviation["theta"] * inside * differentiated

    @property
    def noise_gram(self) -> np.ndarray:
        """Expected sums of products of the noise over the whole trial, shape (4, 4), units as ``gram``."""
        middle = self.trial.operators[:, :, self.trial.operators.shape[2] // 2]
        gram = np.zeros((4, 4))
        gram[:3, :3] = self.deviation["theta"] ** 2 * (middle @ middle.T) * np.outer(*2 * [self.noise_rows])
        gram[3, 3] = self.deviation["tau"] ** 2 * middle[2] @ middle[2]
        return self.trial.simulated.time.size * gram


def windowed_trial(
    trial: FilteredTrial, processing: Processing, noise_on: str, snr_db: float
) -> WindowedTrial:
    """Choose the signals of a processing, cut the windows out and scale the noise.

    Parameters
    ----------
    trial : FilteredTrial
        Signals without noise (s, rad, m, N, Nm).
    processing : Processing
        What is filtered, and what the SNR refers to.
    noise_on : {"none", "tau", "theta", "both"}
        What has noise.
    snr_db : float
        Signal power over noise power (dB); with the target "none" it does not matter.

    Returns
    -------
    WindowedTrial
        Signals (Nm, rad, m, s) in the windows.

    Raises
    ------
    InputError
        If noise or processing are unknown.
    """
    for what, value, known in (
        ("torque", processing.torque, TORQUES),
        ("estimator", processing.estimator, ("segment-regression", "instrumental-variables")),
        ("filtered", processing.filtered, ("all", "noisy", "torque-and-angle")),
        ("power", processing.power, ("trial", "unit")),
    ):
        if value not in known:
            raise InputError(f"{what}: expected one of {listed(known)}, found {quoted(value)}: correct it")
    deviation = noise_deviation(trial, processing, noise_on, snr_db)

    targets = NOISE_ON[noise_on]
    every, both = processing.filtered == "all", processing.filtered == "torque-and-angle"
    filter_tau = every or both or "tau" in targets
    filter_theta = every or both or "theta" in targets
    signals = np.concatenate(
        [
            trial.signals("rates", every or (filter_theta and not both)),
            trial.signals("angle", filter_theta),
            trial.signals(processing.torque, filter_tau),
        ]
    )

    def windows(x: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray((x[:, trial.within] * trial.inside).transpose(1, 0, 2))

    return WindowedTrial(
        trial=trial,
        estimator=processing.estimator,
        torque=windows(signals[3:])[:, 0],
        regressors=windows(signals[:3]),
        instruments=windows(trial.signals("belt", every)),
        gram=signals @ signals.T,
        deviation=deviation,
        noise_rows=np.array([processing.noisy_rates, processing.noisy_rates, True], dtype=float),
    )


# ---- estimators --------------------------------------------------------------------------------


@dataclass(frozen=True)
class BatchedFits:
    """Fits to all perturbations of all draws.

    Attributes
    ----------
    parameters : ndarray, shape (..., 3)
        I (Nms2/rad), B (Nms/rad), K (Nm/rad), per perturbation or over all of them.
    residuals : ndarray, shape (..., w, s)
        tau - X p (Nm).
    sem_as_printed : ndarray, shape (..., 3)
        Thesis eq (3-2) of every fit; its unit is that of the parameter over the square root of Nm.
    """

    parameters: np.ndarray
    residuals: np.ndarray
    sem_as_printed: np.ndarray


def window_parameters(regressors: np.ndarray, torque: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least squares over every window of every draw, by scaled normal equations solved in one batch.

        G = S X'X S,   p = S G^-1 S X'tau,   S = diag(X'X)^(-1/2)

    With columns of unit length the three regressors are far from dependent, so that normal equations
    lose next to nothing against an orthogonal factorisation.

    Parameters
    ----------
    regressors : ndarray, shape (..., w, 3, s)
        X' of every window (rad/s2, rad/s, rad); without the axis of the draws if all draws share it.
    torque : ndarray, shape (..., w, s)
        tau (Nm).

    Returns
    -------
    parameters : ndarray, shape (..., w, 3)
        I (Nms2/rad), B (Nms/rad), K (Nm/rad).
    gram : ndarray, shape (..., w, 3, 3)
        X'X (products of rad/s2, rad/s and rad).

    Raises
    ------
    InputError
        If a window does not determine the parameters.
    """
    # vecdot, because matmul takes a slow path for the product of a small matrix with its transpose
    gram = np.vecdot(regressors[..., :, None, :], regressors[..., None, :, :])
    moment = np.vecdot(regressors, torque[..., None, :])
    length = np.sqrt(np.diagonal(gram, axis1=-2, axis2=-1))
    if not (length > 0.0).all():
        raise InputError(
            "perturbations: expected motion in every window, found none in one: check the windows"
        )
    scaled = gram / (length[..., :, None] * length[..., None, :])
    try:
        return np.linalg.solve(scaled, (moment / length)[..., None])[..., 0] / length, gram
    except np.linalg.LinAlgError as error:
        raise InputError(
            f"perturbations: expected windows that determine {', '.join(PARAMETERS)}, found regressors that "
            "depend on each other: check the windows"
        ) from error


def regress_windows(regressors: np.ndarray, torque: np.ndarray) -> BatchedFits:
    """`window_parameters` with residuals and SEM.

    Parameters
    ----------
    regressors : ndarray, shape (..., w, 3, s)
        X' of every window (rad/s2, rad/s, rad); without the axis of the draws if all draws share it.
    torque : ndarray, shape (..., w, s)
        tau (Nm).

    Returns
    -------
    BatchedFits
        One fit per window (units there).
    """
    parameters, gram = window_parameters(regressors, torque)
    residuals = torque - (parameters[..., None, :] @ regressors)[..., 0, :]
    norm = np.linalg.norm(residuals, axis=-1)[..., None]
    inverse = np.diagonal(np.linalg.inv(gram), axis1=-2, axis2=-1)
    return BatchedFits(parameters, residuals, np.sqrt(norm * inverse))


def instrumental_variables(
    instruments: np.ndarray, regressors: np.ndarray, torque: np.ndarray
) -> BatchedFits:
    """One estimate per draw from all windows, with the belt's motion as instruments.

        p = (sum Z'X)^-1 sum Z'tau

    The SEM has (Z'X)^-1 Z'Z (X'Z)^-1 for (J'J)^-1.

    Parameters
    ----------
    instruments : ndarray, shape (w, 3, s)
        Z' of every window (m/s2, m/s, m).
    regressors : ndarray, shape (..., w, 3, s)
        X' of every window (rad/s2, rad/s, rad).
    torque : ndarray, shape (..., w, s)
        tau (Nm).

    Returns
    -------
    BatchedFits
        One fit per draw (units there), residuals of every window.

    Raises
    ------
    InputError
        If the belt did not move.
    """
    scale = np.sqrt(np.sum(instruments**2, axis=(0, 2)))
    if not (scale > 0.0).all():
        raise InputError("belt: expected motion in the windows, found none: check the windows")
    z = instruments / scale[:, None]
    length = np.sqrt(np.sum(regressors**2, axis=(-3, -1)))
    cross = np.sum(z @ np.swapaxes(regressors, -1, -2), axis=-3) / length[..., None, :]
    moment = np.sum(z @ torque[..., None], axis=-3)
    inverse = np.linalg.inv(cross)
    parameters = (inverse @ moment)[..., 0] / length
    residuals = torque - (parameters[..., None, None, :] @ regressors)[..., 0, :]
    spread = inverse @ np.sum(z @ np.swapaxes(z, -1, -2), axis=0) @ np.swapaxes(inverse, -1, -2)
    norm = np.sqrt(np.sum(residuals**2, axis=(-2, -1)))[..., None]
    sem = np.sqrt(norm * np.diagonal(spread, axis1=-2, axis2=-1)) / length
    return BatchedFits(parameters, residuals, sem)


# ---- predictions -------------------------------------------------------------------------------


def is_stable(leg: Leg, parameters: np.ndarray) -> np.ndarray:
    """Whether the leg on such a joint comes to rest: J, B and K - k_g are all positive.

    Parameters
    ----------
    leg : Leg
        m, r, I_l, g (kg, m, kg m2, m/s2).
    parameters : ndarray, shape (..., 3)
        I (Nms2/rad), B (Nms/rad), K (Nm/rad).

    Returns
    -------
    ndarray of bool, shape (...)
        True where stable (-).
    """
    p = leg.mass_kg * leg.com_m
    own = np.array([leg.inertia_kgm2 + p * leg.com_m, 0.0, -p * leg.gravity_m_per_s2])
    return (parameters + own > 0.0).all(axis=-1)


def predict_angle(leg: Leg, parameters: np.ndarray, belt_velocity: np.ndarray, rate_hz: float) -> np.ndarray:
    """Angle of a leg at rest at first, from the linearised motion driven by the belt.

    With w = J theta' + B theta + p y_f' the belt's acceleration is not needed:

        theta' = (w - B theta - p y_f') / J,   w' = -(K - k_g) theta

    solved exactly for a belt velocity that runs straight between its samples.

    Parameters
    ----------
    leg : Leg
        m, r, I_l, g (kg, m, kg m2, m/s2).
    parameters : ndarray, shape (d, 3)
        I (Nms2/rad), B (Nms/rad), K (Nm/rad).
    belt_velocity : ndarray, shape (n,)
        y_f' (m/s).
    rate_hz : float
        Sampling rate (Hz).

    Returns
    -------
    ndarray, shape (d, n)
        theta (rad); NaN where the leg is not stable.
    """
    p = leg.mass_kg * leg.com_m
    inertia, damping, stiffness = np.asarray(parameters, dtype=float).T
    about_ankle = leg.inertia_kgm2 + p * leg.com_m + inertia
    stable = is_stable(leg, np.asarray(parameters))
    # states theta, w, input u and its change du over a sample: theta_k+1, w_k+1 = A x + b u + c du
    block = np.zeros((stable.size, 4, 4))
    with np.errstate(divide="ignore", invalid="ignore"):
        block[:, 0, :3] = np.stack([-damping, np.ones_like(damping), np.full_like(damping, -p)], axis=1)
        block[:, 0, :3] /= about_ankle[:, None]
    block[:, 1, 0] = p * leg.gravity_m_per_s2 - stiffness
    block[:, 2, 3] = rate_hz
    block[~stable] = 0.0
    step = linalg.expm(block / rate_hz)
    a, b, c = step[:, :2, :2], step[:, :2, 2], step[:, :2, 3]
    trace, determinant = a[:, 0, 0] + a[:, 1, 1], np.linalg.det(a)
    # the same as a recursion in theta alone: theta_k depends on u_k by c, on u_k-1 by b - c, through A
    shifted = (a @ c[..., None])[..., 0] + b - c
    numerator = np.stack(
        [c[:, 0], shifted[:, 0] - trace * c[:, 0], (a @ shifted[..., None])[:, 0, 0] - trace * shifted[:, 0]],
        axis=1,
    )
    numerator[:, 2] += determinant * c[:, 0]
    theta = np.full((stable.size, belt_velocity.size), np.nan)
    for k in np.flatnonzero(stable):
        theta[k] = signal.lfilter(numerator[k], [1.0, -trace[k], determinant[k]], belt_velocity)
    return theta


def torque_vaf(
    parameters: np.ndarray, gram: np.ndarray, noise_gram: np.ndarray, torque_noise: bool
) -> np.ndarray:
    """VAF of the torque over a whole trial, expected over the noise, from sums of products alone.

    Parameters
    ----------
    parameters : ndarray, shape (..., 3)
        I (Nms2/rad), B (Nms/rad), K (Nm/rad).
    gram, noise_gram : ndarray, shape (4, 4)
        Of signals and noise (`WindowedTrial`), products of rad/s2, rad/s, rad and Nm.
    torque_noise : bool
        Whether the torque that is to be predicted has its noise (-).

    Returns
    -------
    ndarray, shape (...)
        VAF (%), means not removed.
    """
    weights = np.concatenate([-parameters, np.ones((*parameters.shape[:-1], 1))], axis=-1)
    total = gram + noise_gram
    if not torque_noise:
        total = total - np.diag([0.0, 0.0, 0.0, noise_gram[3, 3]])
    residual = np.einsum("...i,ij,...j->...", weights, total, weights)
    return 100.0 * (1.0 - residual / total[3, 3])


def cross_validated_vaf(parameters: np.ndarray, others: Iterable[WindowedTrial]) -> np.ndarray:
    """VAF of the noisy torque of other trials, predicted by given parameters from their noisy motion.

    Parameters
    ----------
    parameters : ndarray, shape (..., 3)
        I (Nms2/rad), B (Nms/rad), K (Nm/rad), for example of every draw.
    others : iterable of WindowedTrial
        Trials to predict, processed and with noise as that of the parameters (Nm, rad, s).

    Returns
    -------
    ndarray, shape (...)
        Mean over the trials of the VAF over the whole trial (%), expected over their noise.

    Raises
    ------
    InputError
        If there is no other trial.
    """
    vafs = [torque_vaf(parameters, other.gram, other.noise_gram, True) for other in others]
    if not vafs:
        raise InputError("cross-validation: expected other trials, found none: simulate a second one")
    return np.mean(vafs, axis=0)


# ---- one cell ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class NoiseCell:
    """What one condition, noise target, SNR and processing give, draw by draw.

    Attributes
    ----------
    condition, noise_on, estimator : str
        Trial, noise target, name of the processing.
    snr_db : float
        Signal power over noise power (dB).
    parameters : ndarray, shape (d, 3)
        Mean over the perturbations of I (Nms2/rad), B (Nms/rad), K (Nm/rad).
    sem_as_printed : ndarray, shape (d, 3)
        Thesis eq (3-2), mean over the perturbations (parameter's unit over the square root of Nm).
    vaf_perturbation : ndarray, shape (d,)
        VAF of the torque without noise, by the parameters and noisy motion of every perturbation, mean (%).
    vaf_trial : ndarray, shape (d,)
        The same over the whole trial by the mean parameters, expected over the noise (%).
    vaf_cross_validated : ndarray, shape (d,) or None
        `cross_validated_vaf` of the other trials (%).
    vaf_theta_perturbation, vaf_theta_trial : ndarray, shape (e,)
        VAF of the angle predicted from the belt by the first e draws, in the windows and over the trial (%);
        NaN where the leg falls.
    unstable_fraction : float
        Part of all draws whose leg falls (-).
    truth, without_noise, apparent : ndarray, shape (3,)
        I, B, K (units as ``parameters``) of the joint; by the same processing without noise; by the printed
        equation of the foot, processed in no way (`apparent_impedance`).
    """

    condition: str
    noise_on: str
    estimator: str
    snr_db: float
    parameters: np.ndarray
    sem_as_printed: np.ndarray
    vaf_perturbation: np.ndarray
    vaf_trial: np.ndarray
    vaf_cross_validated: np.ndarray | None
    vaf_theta_perturbation: np.ndarray
    vaf_theta_trial: np.ndarray
    unstable_fraction: float
    truth: np.ndarray
    without_noise: np.ndarray
    apparent: np.ndarray

    @property
    def mean(self) -> np.ndarray:
        """Mean over draws of I (Nms2/rad), B (Nms/rad), K (Nm/rad), shape (3,)."""
        return self.parameters.mean(axis=0)

    @property
    def sd(self) -> np.ndarray:
        """Standard deviation over draws (units of I, B, K), shape (3,); 0 for a single draw."""
        return self.parameters.std(axis=0, ddof=1) if self.n_draws > 1 else np.zeros(3)

    @property
    def bias(self) -> np.ndarray:
        """Mean minus truth (units of I, B, K), shape (3,)."""
        return self.mean - self.truth

    @property
    def n_draws(self) -> int:
        """Number of draws (-)."""
        return self.parameters.shape[0]

    def rows(self) -> list[dict]:
        """Tidy rows: condition, noise_on, snr_db, estimator, quantity, unit, mean, sd, bias, n_draws.

        VAFs of the angle count as 0 % where they are negative or the leg falls, as the thesis prints them.
        """
        head = {
            "condition": self.condition,
            "noise_on": self.noise_on,
            "snr_db": self.snr_db,
            "estimator": self.estimator,
        }
        found = [(q, UNITS[q], self.parameters[:, k], float(self.bias[k])) for k, q in enumerate(PARAMETERS)]
        found += [(f"SEM_{q}", "-", self.sem_as_printed[:, k], None) for k, q in enumerate(PARAMETERS)]
        found += [
            ("VAF_perturbation", "%", self.vaf_perturbation, None),
            ("VAF_trial", "%", self.vaf_trial, None),
            ("VAF_theta_perturbation", "%", clipped(self.vaf_theta_perturbation), None),
            ("VAF_theta_trial", "%", clipped(self.vaf_theta_trial), None),
            ("unstable_fraction", "-", np.array([self.unstable_fraction]), None),
        ]
        if self.vaf_cross_validated is not None:
            found.append(("VAF_cross_validated", "%", self.vaf_cross_validated, None))
        return [
            head
            | {
                "quantity": quantity,
                "unit": unit,
                "mean": float(values.mean()),
                "sd": float(values.std(ddof=1)) if values.size > 1 else 0.0,
                "bias": bias,
                "n_draws": self.n_draws,
            }
            for quantity, unit, values, bias in found
        ]


def clipped(vaf_percent: np.ndarray) -> np.ndarray:
    """VAF (%) with 0 for what is negative or NaN, shape of ``vaf_percent``."""
    return np.maximum(np.nan_to_num(vaf_percent, nan=0.0), 0.0)


def estimate_draws(
    windowed: Sequence[WindowedTrial], chunks: Iterable[dict[str, np.ndarray]]
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Estimate the parameters of every draw of the noise, by every processing of a trial.

    Parameters
    ----------
    windowed : sequence of WindowedTrial
        One trial without noise (Nm, rad), by every processing.
    chunks : iterable of dict
        Draws of the noise, as from `noise_chunks`; [{}] is a single one without noise.

    Returns
    -------
    list of tuple
        For every processing: I (Nms2/rad), B (Nms/rad), K (Nm/rad) and thesis eq (3-2), means over the
        perturbations, shape (draws, 3), and the VAF of the torque without noise, mean over the perturbations
        (%), shape (draws,).
    """
    by_chunk = [[_estimate_chunk(one, chunk) for one in windowed] for chunk in chunks]
    return [tuple(map(np.concatenate, zip(*fits, strict=True))) for fits in zip(*by_chunk, strict=True)]


def _estimate_chunk(
    windowed: WindowedTrial, chunk: dict[str, np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    noise, regressors = np.zeros((1, 1, 1)), windowed.regressors
    if "tau" in chunk:
        noise = windowed.torque_noise(chunk["tau"])
    if "theta" in chunk:
        regressors = regressors + windowed.regressor_noise(chunk["theta"])
    if windowed.estimator == "instrumental-variables":
        fits = instrumental_variables(windowed.instruments, regressors, windowed.torque + noise)
        parameters, sem = fits.parameters, fits.sem_as_printed
    else:
        fits = regress_windows(regressors, windowed.torque + noise)
        parameters, sem = fits.parameters.mean(axis=1), fits.sem_as_printed.mean(axis=1)
    missed = fits.residuals - noise  # of the torque without noise
    unexplained = np.sum(missed**2, axis=-1) / np.sum(windowed.torque**2, axis=-1)
    return parameters, sem, 100.0 * (1.0 - unexplained).mean(axis=1)


def angle_vafs(trial: SimulatedTrial, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """VAF of the simulated angle without noise, predicted from the belt by given parameters.

    Parameters
    ----------
    trial : SimulatedTrial
        Angle (rad) and belt velocity (m/s).
    parameters : ndarray, shape (d, 3)
        I (Nms2/rad), B (Nms/rad), K (Nm/rad).

    Returns
    -------
    in_windows, in_trial : ndarray, shape (d,)
        Mean over the perturbations, and over the whole trial (%); NaN where the leg falls.
    """
    missed = predict_angle(trial.leg, parameters, trial.y_foot_d, trial.rate_hz)
    missed -= trial.theta  # in place, as there are many samples
    missed **= 2
    power = trial.theta**2
    in_windows = [1.0 - missed[:, a:b].sum(axis=1) / power[a:b].sum() for a, b in trial.windows]
    return 100.0 * np.mean(in_windows, axis=0), 100.0 * (1.0 - missed.sum(axis=1) / power.sum())


def sweep(
    trial: FilteredTrial,
    noise_on: str,
    snr_db: float,
    draws: int,
    seed: int,
    estimators: Sequence[str],
    others: Sequence[FilteredTrial] = (),
    predicted_draws: int = 25,
) -> list[NoiseCell]:
    """Many draws of one noise, estimated from in several ways: all perturbations of all draws in batches.

    The noise depends on the seed, the trial's name, the noise target and the SNR alone: cells may be made in
    any order, and all processings see the same noise.

    Parameters
    ----------
    trial : FilteredTrial
        Signals without noise (s, rad, m, N, Nm).
    noise_on : {"none", "tau", "theta", "both"}
        What has noise; "none" takes a single draw.
    snr_db : float
        Signal power over noise power (dB); with the target "none" it does not matter.
    draws : int
        Number of draws (-).
    seed : int
        Of the study (-).
    estimators : sequence of str
        Names of `PROCESSINGS`.
    others : sequence of FilteredTrial
        Trials for the cross-validation.
    predicted_draws : int
        Draws whose angle is predicted over the trial (-).

    Returns
    -------
    list of NoiseCell
        One for every estimator, draw by draw (Nms2/rad, Nms/rad, Nm/rad, %).

    Raises
    ------
    InputError
        If noise, SNR, processings or the number of draws cannot be used.
    """
    for name in estimators:
        if name not in PROCESSINGS:
            raise InputError(
                f"estimator: expected one of {listed(PROCESSINGS)}, found {quoted(name)}: correct it"
            )
    if draws < 1:
        raise InputError(f"noise: expected one draw or more, found {draws}: ask for more")
    simulated = trial.simulated
    windowed = [windowed_trial(trial, PROCESSINGS[name], noise_on, snr_db) for name in estimators]
    generators = cell_generators(seed, simulated.name, noise_on, f"{snr_db:g}")
    drawn = estimate_draws(windowed, noise_chunks(trial, noise_on, draws, generators))
    silent = estimate_draws(windowed, [{}])
    cells = []
    for k, name in enumerate(estimators):
        parameters, sem, vaf_perturbation = drawn[k]
        in_windows, in_trial = angle_vafs(simulated, parameters[:predicted_draws])
        validated = None
        if others:
            unseen = (windowed_trial(other, PROCESSINGS[name], noise_on, snr_db) for other in others)
            validated = cross_validated_vaf(parameters, unseen)
        cells.append(
            NoiseCell(
                condition=simulated.name,
                noise_on=noise_on,
                estimator=name,
                snr_db=float(snr_db),
                parameters=parameters,
                sem_as_printed=sem,
                vaf_perturbation=vaf_perturbation,
                vaf_trial=torque_vaf(parameters, windowed[k].gram, windowed[k].noise_gram, False),
                vaf_cross_validated=validated,
                vaf_theta_perturbation=in_windows,
                vaf_theta_trial=in_trial,
                unstable_fraction=float(np.mean(~is_stable(simulated.leg, parameters))),
                truth=np.asarray(simulated.truth, dtype=float),
                without_noise=silent[k][0][0],
                apparent=apparent_impedance(simulated.leg, simulated.foot, simulated.truth),
            )
        )
    return cells


def sweep_trial(
    trial: SimulatedTrial,
    levels_db: dict[str, list[float]],
    draws: int,
    seed: int,
    others: Iterable[SimulatedTrial],
    predicted_draws: int = 25,
    cutoff_hz: float = 20.0,
    order: int = 4,
) -> list[NoiseCell]:
    """All cells of one trial: by every processing without noise, and with every noise target and level.

    Parameters
    ----------
    trial : SimulatedTrial
        Signals without noise (s, rad, m, N, Nm).
    levels_db : dict of str to list of float
        Name of one of `PROCESSINGS` -> signal power over noise power (dB).
    draws, seed : int
        As for `sweep` (-).
    others : iterable of SimulatedTrial
        Trials for the cross-validation.
    predicted_draws : int
        As for `sweep` (-).
    cutoff_hz : float
        Of the low-pass filter (Hz).
    order : int
        Of the filter, both passes together (-).

    Returns
    -------
    list of NoiseCell
        As `sweep` gives them, processing by processing (Nms2/rad, Nms/rad, Nm/rad, %).

    Raises
    ------
    InputError
        As `filtered_trial` and `sweep`.
    """
    wanted = {
        name: [("none", levels[0]), *product(("tau", "theta", "both"), levels)]
        for name, levels in levels_db.items()
    }
    filtered = filtered_trial(trial, cutoff_hz, order)
    filtered_others = [filtered_trial(other, cutoff_hz, order) for other in others]
    made = {}
    for noise in dict.fromkeys(chain(*wanted.values())):
        names = [name for name, noises in wanted.items() if noise in noises]
        for cell in sweep(filtered, *noise, draws, seed, names, filtered_others, predicted_draws):
            made[cell.estimator, noise] = cell
    return [made[name, noise] for name, noises in wanted.items() for noise in noises]
