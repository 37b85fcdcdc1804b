"""Noise of a given signal-to-noise ratio, drawn and filtered only around the windows."""

import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError, listed, quoted
from tepsipe.experiments.noise.trial import TORQUES, SimulatedTrial
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import butterworth_lowpass

NOISE_ON = {"none": (), "tau": ("tau",), "theta": ("theta",), "both": ("tau", "theta")}
# rows of a trial's signals: theta'', theta'; theta; y_f'', y_f', y_f; tau by every equation
ROWS = {"rates": slice(0, 2), "angle": slice(2, 3), "belt": slice(3, 6)}
CHUNK_DRAWS = 50  # some 10 MB, which fit into the cache of a processor
MEMORY_PERIODS = 6.0  # of the cutoff frequency, after which the filter's response is below 1e-11


@dataclass(frozen=True)
class Processing:
    """One interpretation of the processing of noisy signals."""

    torque: str
    """{"foot-thesis", "foot", "leg", "leg-thesis", "joint"}: Equation of the torque, or its sensor in the
    simulated joint."""
    estimator: str
    """{"windowed-least-squares", "instrumental-variables"}: Windowed least squares, or
    instrumental-variable estimate over all perturbations."""
    filtered: str
    """{"all", "noisy", "torque-and-angle"}: Low-pass filtered signals: all, only those with noise (theta
    with its rates), or torque and angle but not the rates."""
    noisy_rates: bool = True
    """Whether noise on theta propagates to the rates, as by differentiation, or not, as with separate
    sensors."""
    power: str = "trial"
    """{"trial", "unit"}: Power that the SNR refers to: the signal's mean square over the trial, mean not
    removed, or 1 in the signal's unit squared, the default of a noise function that does not measure the
    signal."""


# as-printed: the text of sections 2-1-3 and 3-1-3; as-tabulated: the interpretation that yields Table 4-4;
# recommended-regression: consistent torque, one filter for all, least squares; recommended: IV estimate;
# joint-sensor: as-printed with the torque of the joint itself, which section 3-1-3 avoids
PROCESSINGS = {
    "as-printed": Processing("foot-thesis", "windowed-least-squares", "noisy"),
    "as-tabulated": Processing("foot-thesis", "windowed-least-squares", "torque-and-angle", False, "unit"),
    "recommended-regression": Processing("leg", "windowed-least-squares", "all"),
    "recommended": Processing("leg", "instrumental-variables", "all"),
    "joint-sensor": Processing("joint", "windowed-least-squares", "noisy"),
}


# ---- signals -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class FilteredTrial:
    """A simulated trial, its signals with and without the low-pass, and its windows, shared by all cells.

    All windows have the length of the longest; samples beyond the end of a shorter one are masked.
    """

    simulated: SimulatedTrial
    raw: Annotated[np.ndarray, "(10, n)"]
    lowpassed: Annotated[np.ndarray, "(10, n)"]
    """Signals by `ROWS` (rad/s², rad/s, rad, m/s², m/s, m, N·m)."""
    within: Annotated[np.ndarray, "(w, s)"]
    """Samples of every window."""
    inside: Annotated[np.ndarray, "(w, s)"]
    """Whether they belong to the window."""
    operators: Annotated[np.ndarray, "(3, s + 2 memory, s)"]
    """D D F, D F, F from the samples around a window to those in it."""
    noise_samples: Annotated[np.ndarray, "(k,)"]
    """Samples of the trial whose noise affects a window."""
    noise_index: Annotated[np.ndarray, "(w, s + 2 memory)"]
    """Position in ``noise_samples`` of the samples around every window."""

    @cached_property
    def _made(self) -> dict[tuple, np.ndarray]:
        return {}

    def _once(self, name: str, chosen: tuple, make: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """What ``make`` returns for the chosen signals, made once for all cells; do not modify it."""
        if (name, chosen) not in self._made:
            self._made[name, chosen] = make(self.signals(*chosen))
        return self._made[name, chosen]

    def signals(self, *chosen: tuple[str, bool]) -> np.ndarray:
        """Signals by their names in `ROWS`, each raw or low-passed, shape (k, n)."""
        return np.concatenate([(self.lowpassed if low else self.raw)[ROWS[name]] for name, low in chosen])

    def windows(self, *chosen: tuple[str, bool]) -> np.ndarray:
        """The same in the windows, shape (w, k, s)."""

        def windows(x: np.ndarray) -> np.ndarray:
            return np.ascontiguousarray((x[:, self.within] * self.inside).transpose(1, 0, 2))

        return self._once("windows", chosen, windows)

    def gram(self, *chosen: tuple[str, bool]) -> np.ndarray:
        """Sums of their products over the whole trial, shape (k, k)."""
        return self._once("gram", chosen, lambda x: x @ x.T)

    def rms(self, name: str) -> np.ndarray:
        """Root of the mean square of a raw signal, a number."""
        return self._once("rms", ((name, False),), lambda x: np.sqrt(np.mean(x**2)))

    def filtered_noise(self, unit_noise: np.ndarray) -> np.ndarray:
        """F n in the windows, shape (draws, w, s), of noise n of unit variance, shape (draws, k)."""
        return unit_noise[:, self.noise_index] @ self.operators[2]

    def differentiated_noise(self, unit_noise: np.ndarray) -> np.ndarray:
        """D D F n (1/s²), D F n (1/s), F n in the windows, shape (draws, w, 3, s), of n as above."""
        around = unit_noise[:, self.noise_index]
        noise = np.empty((*around.shape[:2], 3, self.within.shape[1]))
        for row, operator in enumerate(self.operators):
            np.matmul(around, operator, out=noise[:, :, row])
        return noise


def filtered_trial(trial: SimulatedTrial, cutoff_hz: float = 20.0, order: int = 4) -> FilteredTrial:
    """Filter the noise-free signals, and prepare the filter of the noise around the windows.

    cutoff_hz: cutoff of the low-pass filter.
    order: order of the filter, both passes together.
    Returns: signals shared by all processings, noise targets and SNRs.
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


@cache
def _operators(length: int, rate_hz: float, cutoff_hz: float, order: int) -> np.ndarray:
    """D D F, D F, F from the samples around a window to those in it, shape (3, length + 2 memory, length).

    Trials with windows of the same length share them.
    """
    memory = filter_memory(rate_hz, cutoff_hz)
    span = length + 2 * memory
    time = np.arange(span) / rate_hz
    filtered = butterworth_lowpass(np.eye(span), rate_hz, cutoff_hz, order)
    first = derivative(time, filtered)
    operators = np.stack([derivative(time, first), first, filtered])[:, memory : memory + length]
    return np.ascontiguousarray(operators.transpose(0, 2, 1))


def filter_memory(rate_hz: float, cutoff_hz: float) -> int:
    """Length of the low-pass filter's response in either direction (samples), for a cutoff in Hz."""
    return int(np.ceil(MEMORY_PERIODS * rate_hz / cutoff_hz - 1e-6))


# ---- noise -------------------------------------------------------------------------------------


def cell_generators(seed: int, *names: object) -> tuple[np.random.Generator, np.random.Generator]:
    """Generators of the noise on tau and on theta of one cell.

    Parameters
    ----------
    seed : int
        Seed of the study.
    names : object
        Name of the cell: the noise depends on the seed and the name only.

    Returns: for tau and for theta (unit variance).
    """
    generator = np.random.default_rng([seed, zlib.crc32("/".join(map(str, names)).encode())])
    tau, theta = generator.spawn(2)
    return tau, theta


def noise_deviation(trial: FilteredTrial, processing: Processing, noise_on: str, snr_db: float) -> dict:
    """Standard deviation of the noise before it is filtered.

    processing: torque and power that the SNR refers to.
    noise_on: {"none", "tau", "theta", "both"}: Signals with noise.
    snr_db: signal power over noise power (dB); ignored for the target "none".
    Returns: standard deviation of tau (N·m) and theta (rad); 0 without noise.
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
    deviation = {"tau": 0.0, "theta": 0.0}
    for name, signal in (("tau", processing.torque), ("theta", "angle")):
        if name in NOISE_ON[noise_on]:
            rms = trial.rms(signal) if processing.power == "trial" else 1.0
            deviation[name] = float(10.0 ** (-snr_db / 20.0) * rms)
    return deviation


def noise_chunks(
    trial: FilteredTrial, noise_on: str, draws: int, generators: tuple[np.random.Generator, ...]
) -> Iterator[dict[str, np.ndarray]]:
    """Draw noise of unit variance and filter it, in chunks of draws.

    noise_on: {"none", "tau", "theta", "both"}: Signals with noise.
    draws: number of draws; one is sufficient without noise.
    generators: for the noise on tau and on theta.

    Yields
    ------
    dict of str to ndarray
        For the signals with noise: ``tau``, `FilteredTrial.filtered_noise`; ``theta``, its
        ``differentiated_noise``.
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
    """Processed noise-free signals in the windows, and the noise to be added.

    Samples beyond the end of a window that is shorter than the longest are 0 in every signal.
    """

    trial: FilteredTrial
    """The trial, its windows and filter."""
    estimator: str
    """{"windowed-least-squares", "instrumental-variables"}: See `Processing`."""
    torque: Annotated[np.ndarray, "(w, s)", "N·m"]
    """tau."""
    regressors: Annotated[np.ndarray, "(w, 3, s)"]
    instruments: Annotated[np.ndarray, "(w, 3, s)"]
    """theta'', theta', theta (rad/s², rad/s, rad); y_f'', y_f', y_f (m/s², m/s, m)."""
    gram: Annotated[np.ndarray, "(4, 4)"]
    """Sums of products of theta'', theta', theta, tau over the whole trial."""
    deviation: dict[str, float]
    """Standard deviation of the noise on tau (N·m) and theta (rad)."""
    noise_rows: Annotated[np.ndarray, "(3,)"]
    """1 where noise on theta propagates to theta'', theta', theta, else 0."""

    def torque_noise(self, filtered: np.ndarray) -> np.ndarray:
        """Noise on tau in the windows (N·m), shape (draws, w, s), from `FilteredTrial.filtered_noise`."""
        return self.deviation["tau"] * self.trial.inside * filtered

    def regressor_noise(self, differentiated: np.ndarray) -> np.ndarray:
        """Noise on theta'', theta', theta in the windows (rad/s², rad/s, rad), shape (draws, w, 3, s).

        From `FilteredTrial.differentiated_noise` (1/s², 1/s, -).
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
    """Select the signals of a processing, cut the windows and scale the noise.

    processing: filtered signals, and power that the SNR refers to.
    noise_on: {"none", "tau", "theta", "both"}: Signals with noise.
    snr_db: signal power over noise power (dB); ignored for the target "none".
    """
    for what, value, known in (
        ("torque", processing.torque, TORQUES),
        ("estimator", processing.estimator, ("windowed-least-squares", "instrumental-variables")),
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
    motion = ("rates", every or (filter_theta and not both)), ("angle", filter_theta)
    torque = processing.torque, filter_tau
    return WindowedTrial(
        trial=trial,
        estimator=processing.estimator,
        torque=trial.windows(torque)[:, 0],
        regressors=trial.windows(*motion),
        instruments=trial.windows(("belt", every)),
        gram=trial.gram(*motion, torque),
        deviation=deviation,
        noise_rows=np.array([processing.noisy_rates, processing.noisy_rates, True], dtype=float),
    )
