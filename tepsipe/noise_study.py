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
simulated: what differentiating *it* would cost is left out.

Noise in theta'', theta', theta biases least squares (errors in variables). Belt motion Z = (y_f'', y_f',
y_f) drives the leg, but knows nothing of the noise, so E Z'n = 0 and the instrumental variables

    (I, B, K) = (sum Z'X)^-1 sum Z'tau,     X = (theta'', theta', theta), summed over all perturbations

are consistent for noise on tau, on theta and on both. They cost one 3 x 3 system per draw and use what
the treadmill records anyway.
"""

import zlib
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy import linalg, signal

from tepsipe.errors import InputError, listed, quoted
from tepsipe.filters import butterworth_lowpass
from tepsipe.inverse_dynamics import TORQUE_PATHWAYS, Foot, Leg, foot_torque, foot_torque_as_printed
from tepsipe.rigid_segments import derivative
from tepsipe.second_order import PARAMETERS, UNITS

NOISE_ON = {"none": (), "tau": ("tau",), "theta": ("theta",), "both": ("tau", "theta")}
TORQUES = ("foot-printed", "foot", *TORQUE_PATHWAYS)
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


# ---- noise -------------------------------------------------------------------------------------


@lru_cache(maxsize=32)
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


def noise_deviation(trial: SimulatedTrial, processing: Processing, noise_on: str, snr_db: float) -> dict:
    """Standard deviation of the noise before it is filtered.

    Parameters
    ----------
    trial : SimulatedTrial
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
    signals = {"tau": trial.torque(processing.torque), "theta": trial.theta}
    rms = {
        name: np.sqrt(np.mean(x**2)) if processing.power == "trial" else 1.0 for name, x in signals.items()
    }
    if not NOISE_ON[noise_on]:
        return dict.fromkeys(signals, 0.0)
    ratio = 10.0 ** (-snr_db / 20.0)
    return {name: float(ratio * rms[name]) if name in NOISE_ON[noise_on] else 0.0 for name in signals}


@dataclass(frozen=True)
class WindowedTrial:
    """Processed signals without noise in the windows, and where noise enters.

    Windows are as long as the longest; what lies beyond a shorter one's end is 0 in every signal.

    Attributes
    ----------
    torque : ndarray, shape (w, s)
        tau (Nm).
    regressors, instruments : ndarray, shape (w, 3, s)
        theta'', theta', theta (rad/s2, rad/s, rad); y_f'', y_f', y_f (m/s2, m/s, m).
    inside : ndarray of bool, shape (w, s)
        Samples that belong to the window (-).
    gram : ndarray, shape (4, 4)
        Sums of products of theta'', theta', theta, tau over the whole trial.
    samples : int
        Length of the trial (samples).
    deviation : dict of str to float
        Standard deviation of the noise on tau (Nm) and theta (rad).
    noise_rows : ndarray, shape (3,)
        1 where noise on theta reaches theta'', theta', theta, else 0 (-).
    operators : ndarray, shape (3, s + 2 memory, s)
        D D F, D F, F.
    noise_samples : ndarray, shape (k,)
        Samples of the trial whose noise reaches a window.
    noise_index : ndarray, shape (w, s + 2 memory)
        Position in ``noise_samples`` of the samples around every window.
    """

    torque: np.ndarray
    regressors: np.ndarray
    instruments: np.ndarray
    inside: np.ndarray
    gram: np.ndarray
    samples: int
    deviation: dict[str, float]
    noise_rows: np.ndarray
    operators: np.ndarray
    noise_samples: np.ndarray
    noise_index: np.ndarray

    def torque_noise(self, unit_noise: np.ndarray) -> np.ndarray:
        """Filtered noise on tau in the windows (Nm), shape (draws, w, s), from unit noise (draws, k)."""
        around = unit_noise[:, self.noise_index]
        return self.deviation["tau"] * self.inside * (around @ self.operators[2])

    def regressor_noise(self, unit_noise: np.ndarray) -> np.ndarray:
        """Noise on theta'', theta', theta (rad/s2, rad/s, rad), shape (draws, w, 3, s), as above."""
        around = unit_noise[:, self.noise_index]
        noise = np.zeros((*around.shape[:2], 3, self.inside.shape[1]))
        for row in np.flatnonzero(self.noise_rows):
            np.matmul(around, self.operators[row], out=noise[:, :, row])
        return np.multiply(noise, self.deviation["theta"] * self.inside[:, None], out=noise)

    @property
    def noise_gram(self) -> np.ndarray:
        """Expected sums of products of the noise over the whole trial, shape (4, 4), units as ``gram``."""
        middle = self.operators[:, :, self.operators.shape[2] // 2]
        gram = np.zeros((4, 4))
        gram[:3, :3] = self.deviation["theta"] ** 2 * (middle @ middle.T) * np.outer(*2 * [self.noise_rows])
        gram[3, 3] = self.deviation["tau"] ** 2 * middle[2] @ middle[2]
        return self.samples * gram


def windowed_trial(
    trial: SimulatedTrial,
    processing: Processing,
    noise_on: str,
    snr_db: float,
    cutoff_hz: float = 20.0,
    order: int = 4,
) -> WindowedTrial:
    """Filter the signals without noise, cut the windows out and prepare the noise.

    Parameters
    ----------
    trial : SimulatedTrial
        Signals without noise (s, rad, m, N, Nm).
    processing : Processing
        What is filtered, and what the SNR refers to.
    noise_on : {"none", "tau", "theta", "both"}
        What has noise.
    snr_db : float
        Signal power over noise power (dB); with the target "none" it does not matter.
    cutoff_hz : float
        Of the low-pass filter (Hz).
    order : int
        Of the filter, both passes together (-).

    Returns
    -------
    WindowedTrial
        Signals (Nm, rad, m, s) in the windows.

    Raises
    ------
    InputError
        If there is no window, one lies too near the trial's ends, or noise or processing are unknown.
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

    targets = NOISE_ON[noise_on]
    every, both = processing.filtered == "all", processing.filtered == "torque-and-angle"
    filter_tau = every or both or "tau" in targets
    filter_theta = every or both or "theta" in targets
    filter_rates = every or (filter_theta and not both)

    def lowpass(x: np.ndarray, wanted: bool = True) -> np.ndarray:
        return butterworth_lowpass(x, rate, cutoff_hz, order, axis=-1) if wanted else x

    rates, angle = trial.regressors[:2], trial.regressors[2:]
    signals = np.concatenate(
        [
            lowpass(rates, filter_rates),
            lowpass(angle, filter_theta),
            lowpass(trial.torque(processing.torque)[None], filter_tau),
        ]
    )
    inside = np.arange(longest) < lengths[:, None]
    within = windows[:, :1] + np.arange(longest)
    cut = (signals[:, within] * inside).transpose(1, 0, 2)
    instruments = (lowpass(trial.instruments, every)[:, within] * inside).transpose(1, 0, 2)
    around = windows[:, :1] - memory + np.arange(longest + 2 * memory)
    noise_samples, noise_index = np.unique(around, return_inverse=True)
    return WindowedTrial(
        torque=cut[:, 3],
        regressors=np.ascontiguousarray(cut[:, :3]),
        instruments=np.ascontiguousarray(instruments),
        inside=inside,
        gram=signals @ signals.T,
        samples=samples,
        deviation=deviation,
        noise_rows=np.array([processing.noisy_rates, processing.noisy_rates, True], dtype=float),
        operators=_operators(longest, rate, cutoff_hz, order),
        noise_samples=noise_samples,
        noise_index=noise_index.reshape(around.shape),
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


def cross_validated_vaf(
    parameters: np.ndarray,
    others: list[SimulatedTrial],
    processing: Processing,
    noise_on: str,
    snr_db: float,
    cutoff_hz: float = 20.0,
    order: int = 4,
) -> np.ndarray:
    """VAF of the noisy torque of other trials, predicted by given parameters from their noisy motion.

    Parameters
    ----------
    parameters : ndarray, shape (..., 3)
        I (Nms2/rad), B (Nms/rad), K (Nm/rad), for example of every draw.
    others : list of SimulatedTrial
        Trials to predict (Nm, rad, s).
    processing, noise_on, snr_db, cutoff_hz, order
        As for `windowed_trial`.

    Returns
    -------
    ndarray, shape (...)
        Mean over the trials of the VAF over the whole trial (%), expected over their noise.

    Raises
    ------
    InputError
        If there is no other trial.
    """
    if not others:
        raise InputError("cross-validation: expected other trials, found none: simulate a second one")
    cuts = [windowed_trial(other, processing, noise_on, snr_db, cutoff_hz, order) for other in others]
    return np.mean([torque_vaf(parameters, cut.gram, cut.noise_gram, True) for cut in cuts], axis=0)


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
    windowed: WindowedTrial, estimator: str, draws: int, generators: tuple[np.random.Generator, ...]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Draw noise and estimate the parameters of every draw.

    Parameters
    ----------
    windowed : WindowedTrial
        Signals without noise (Nm, rad).
    estimator : {"segment-regression", "instrumental-variables"}
        See `Processing`.
    draws : int
        Number of draws (-).
    generators : tuple of numpy.random.Generator
        For the noise on tau and on theta.

    Returns
    -------
    parameters, sem_as_printed : ndarray, shape (draws, 3)
        I (Nms2/rad), B (Nms/rad), K (Nm/rad) and thesis eq (3-2), means over the perturbations.
    vaf_perturbation : ndarray, shape (draws,)
        Of the torque without noise, mean over the perturbations (%).
    """
    parameters, sems, vafs = [], [], []
    power = np.sum(windowed.torque**2, axis=-1)
    for start in range(0, draws, CHUNK_DRAWS):
        shape = (min(CHUNK_DRAWS, draws - start), windowed.noise_samples.size)
        noise, regressors = np.zeros((shape[0], 1, 1)), windowed.regressors
        if windowed.deviation["tau"]:
            noise = windowed.torque_noise(generators[0].standard_normal(shape))
        if windowed.deviation["theta"]:
            regressors = regressors + windowed.regressor_noise(generators[1].standard_normal(shape))
        if estimator == "instrumental-variables":
            fits = instrumental_variables(windowed.instruments, regressors, windowed.torque + noise)
            mean, sem = fits.parameters, fits.sem_as_printed
        else:
            fits = regress_windows(regressors, windowed.torque + noise)
            mean, sem = fits.parameters.mean(axis=1), fits.sem_as_printed.mean(axis=1)
        missed = fits.residuals - noise  # of the torque without noise
        parameters.append(mean)
        sems.append(sem)
        vafs.append(100.0 * (1.0 - np.sum(missed**2, axis=-1) / power).mean(axis=1))
    return np.concatenate(parameters), np.concatenate(sems), np.concatenate(vafs)


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
    predicted = predict_angle(trial.leg, parameters, trial.y_foot_d, trial.rate_hz)
    missed, power = (trial.theta - predicted) ** 2, trial.theta**2
    in_windows = [1.0 - missed[:, a:b].sum(axis=1) / power[a:b].sum() for a, b in trial.windows]
    return 100.0 * np.mean(in_windows, axis=0), 100.0 * (1.0 - missed.sum(axis=1) / power.sum())


def sweep(
    trial: SimulatedTrial,
    noise_on: str,
    snr_db: float,
    draws: int,
    seed: int,
    estimator: str = "recommended",
    others: tuple[SimulatedTrial, ...] = (),
    predicted_draws: int = 25,
    cutoff_hz: float = 20.0,
    order: int = 4,
) -> NoiseCell:
    """One cell of the study: many draws of the noise, all perturbations of all draws in batches.

    The noise depends on the seed, the trial's name, the noise target and the SNR alone: cells may be made in
    any order, and the estimators of one cell see the same noise.

    Parameters
    ----------
    trial : SimulatedTrial
        Signals without noise (s, rad, m, N, Nm).
    noise_on : {"none", "tau", "theta", "both"}
        What has noise; "none" takes a single draw.
    snr_db : float
        Signal power over noise power (dB); with the target "none" it does not matter.
    draws : int
        Number of draws (-).
    seed : int
        Of the study (-).
    estimator : str
        One of `PROCESSINGS`.
    others : tuple of SimulatedTrial
        Trials for the cross-validation.
    predicted_draws : int
        Draws whose angle is predicted over the trial (-).
    cutoff_hz : float
        Of the low-pass filter (Hz).
    order : int
        Of the filter, both passes together (-).

    Returns
    -------
    NoiseCell
        Draw by draw (Nms2/rad, Nms/rad, Nm/rad, %).

    Raises
    ------
    InputError
        If noise, SNR, processing, windows or the number of draws cannot be used.
    """
    if estimator not in PROCESSINGS:
        raise InputError(
            f"estimator: expected one of {listed(PROCESSINGS)}, found {quoted(estimator)}: correct it"
        )
    if draws < 1:
        raise InputError(f"noise: expected one draw or more, found {draws}: ask for more")
    processing = PROCESSINGS[estimator]
    windowed = windowed_trial(trial, processing, noise_on, snr_db, cutoff_hz, order)
    silent = replace(windowed, deviation={"tau": 0.0, "theta": 0.0})
    generators = cell_generators(seed, trial.name, noise_on, f"{snr_db:g}")
    count = draws if NOISE_ON[noise_on] else 1
    parameters, sem, vaf_perturbation = estimate_draws(windowed, processing.estimator, count, generators)
    in_windows, in_trial = angle_vafs(trial, parameters[:predicted_draws])
    validated = None
    if others:
        validated = cross_validated_vaf(
            parameters, list(others), processing, noise_on, snr_db, cutoff_hz, order
        )
    return NoiseCell(
        condition=trial.name,
        noise_on=noise_on,
        estimator=estimator,
        snr_db=float(snr_db),
        parameters=parameters,
        sem_as_printed=sem,
        vaf_perturbation=vaf_perturbation,
        vaf_trial=torque_vaf(parameters, windowed.gram, windowed.noise_gram, False),
        vaf_cross_validated=validated,
        vaf_theta_perturbation=in_windows,
        vaf_theta_trial=in_trial,
        unstable_fraction=float(np.mean(~is_stable(trial.leg, parameters))),
        truth=np.asarray(trial.truth, dtype=float),
        without_noise=estimate_draws(silent, processing.estimator, 1, generators)[0][0],
        apparent=apparent_impedance(trial.leg, trial.foot, trial.truth),
    )


def sweep_trial(
    trial: SimulatedTrial,
    levels_db: list[float],
    draws: int,
    seed: int,
    estimators: list[str],
    others: tuple[SimulatedTrial, ...],
    predicted_draws: int = 25,
    cutoff_hz: float = 20.0,
    order: int = 4,
) -> list[NoiseCell]:
    """All cells of one trial: without noise, and every noise target and level, by every processing.

    Parameters
    ----------
    trial : SimulatedTrial
        Signals without noise (s, rad, m, N, Nm).
    levels_db : list of float
        Signal power over noise power (dB).
    draws, seed : int
        As for `sweep` (-).
    estimators : list of str
        Names of `PROCESSINGS`.
    others : tuple of SimulatedTrial
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
        As `sweep` gives them (Nms2/rad, Nms/rad, Nm/rad, %).

    Raises
    ------
    InputError
        As `sweep`.
    """
    cells = [("none", levels_db[0])] + [
        (noise_on, level) for noise_on in ("tau", "theta", "both") for level in levels_db
    ]
    return [
        sweep(trial, noise_on, level, draws, seed, estimator, others, predicted_draws, cutoff_hz, order)
        for estimator in estimators
        for noise_on, level in cells
    ]
