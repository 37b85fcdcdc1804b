"""Signals and regressors of a parallel-cascade model (`tepsipe.identification.cascade.parallel_cascade`)."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.identification.cascade.fit import ParallelCascadeOptions, SlowModel, Structure
from tepsipe.identification.cascade.pathways import (
    delayed,
    knot_responses,
    lagged,
    laguerre_responses,
    rectified,
    relaxing_deflection,
    stop_deflection,
)
from tepsipe.signals.differentiation import derivative

# part of the angle's range within which an element must be able to yield both ways
REACHED = 0.6
# time constants of a Laguerre response after which it is cut, and ridge relative to lambda
LASTS, RIDGE = 14.0, 0.1
# least effective number of spectral lines of the velocity: one sinusoid has 2, a triangle 3
FEWEST_LINES = 2.5


@dataclass(frozen=True)
class CascadeRecord:
    """Filtered signals over the whole record, and the part in use."""

    torque: np.ndarray
    angle: np.ndarray
    """Low-pass filtered torque (N·m), and angle about its mean in the fitted part (rad)."""
    turned: Annotated[np.ndarray, "(n,)", "rad"]
    """The angle about its mean, not filtered."""
    rate_hz: float
    kept: slice
    """Samples that are used."""
    training: int
    """Number of them, from the first on, that are fitted (samples)."""
    lowpass: Callable[[np.ndarray], np.ndarray]
    """Filter of signals and regressors, along axis 0."""
    options: ParallelCascadeOptions
    """Options of the analysis."""
    radii: tuple[float, ...]
    """Radii of the stop elements within the recorded movement (rad)."""
    slow: SlowModel
    """Spectrum of the slow torque against which the regression is weighted (Hz)."""
    made: dict = field(default_factory=dict, repr=False)
    """Cache of computed regressors, by name and choice."""

    @property
    def used(self) -> np.ndarray:
        """Torque of the part in use (N·m)."""
        return self.torque[self.kept]

    @property
    def white_torque(self) -> np.ndarray:
        """Innovation of the torque of the part in use (N·m)."""
        key = ("torque", self.slow)
        if key not in self.made:
            self.made[key] = self.whiten(self.torque)[self.kept]
        return self.made[key]

    @property
    def fitted(self) -> slice:
        """Part of the whole record that is fitted (samples)."""
        return slice(self.kept.start, self.kept.start + self.training)

    def weighted(self, slow: SlowModel) -> "CascadeRecord":
        """The same record, weighted against another slow torque (Hz)."""
        return replace(self, slow=slow)

    def whiten(self, x: np.ndarray) -> np.ndarray:
        """Innovation of signals (their unit) along axis 0."""
        return self.slow.whiten(x, self.rate_hz)

    def group(self, name: str, structure: Structure) -> tuple[np.ndarray, np.ndarray]:
        """Regressors of one group of a structure over the part that is used, and their innovations.

        Each of shape (n, columns), computed once per group and choice; units of angle, velocity, and
        products of them.
        """
        key = (name,)
        if name in ("reflex", "gain_slope", "unloading"):
            shape = (structure.direction, structure.threshold_rad_per_s, structure.pole_per_s)
            key = (name, *shape)
        if key not in self.made:
            self.made[key] = self._compute(name, structure)
        white = (*key, self.slow)
        if white not in self.made:
            self.made[white] = self.whiten(self.made[key])
        pair = self.made[key], self.made[white]
        return tuple(self._late(x, structure.delay_s if len(key) > 1 else 0.0) for x in pair)

    def _late(self, x: np.ndarray, delay_s: float) -> np.ndarray:
        """Part in use of a delayed signal; a view where the delay is a whole number of samples."""
        samples = round(delay_s * self.rate_hz, 6)
        if samples == int(samples) and int(samples) <= self.kept.start:
            return x[self.kept.start - int(samples) : self.kept.stop - int(samples)]
        return delayed(x, delay_s, self.rate_hz)[self.kept]

    def reflex_input(self, name: str, structure: Structure) -> np.ndarray:
        """Filtered input of a reflex pathway without its delay over the whole record, shape (n,).

        ``reflex`` and ``unloading``, which has no threshold, in rad/s, ``gain_slope`` in rad²/s.
        """
        direction = -structure.direction if name == "unloading" else structure.direction
        threshold = 0.0 if name == "unloading" else structure.threshold_rad_per_s
        if "velocity" not in self.made:
            time = np.arange(self.angle.size) / self.rate_hz
            self.made["velocity"] = derivative(time, self.angle)
        velocity = rectified(self.made["velocity"], direction, threshold)
        return self.lowpass(velocity * self.angle if name == "gain_slope" else velocity)

    def _compute(self, name: str, structure: Structure) -> np.ndarray:
        if name == "intrinsic":
            reach = max(1, round(self.options.intrinsic_lag_s * self.rate_hz))
            return lagged(self.angle, np.arange(-reach, reach + 1))
        if name == "stops":
            springs = [stop_deflection(self.turned, radius) for radius in self.radii]
            return self.lowpass(np.column_stack(springs))
        if name == "relaxing":
            times = self.options.relaxation_times_s
            return np.column_stack([relaxing_deflection(self.angle, t, self.rate_hz) for t in times])
        if name == "stiffening":
            return self.lowpass(self.turned**2)[:, None]
        if name == "offset":
            return np.ones((self.angle.size, 1))
        responses = kernel_responses(structure.pole_per_s, self.options, self.rate_hz)
        u = self.reflex_input(name, structure)
        return scipy.signal.oaconvolve(u[:, None], responses, axes=0)[: u.size] / self.rate_hz


def kernel_responses(
    pole_per_s: float, options: ParallelCascadeOptions, rate_hz: float
) -> Annotated[np.ndarray, "(samples, functions)"]:
    """Basis of the reflex response at 0, 1 / rate, ...: Laguerre functions of a pole, or knots for pole 0.

    pole_per_s: pole (rad/s), or 0.
    options: length, knots, and number of functions.
    """
    if pole_per_s == 0.0:
        return knot_responses(options.reflex_length_s, options.reflex_knot_s, rate_hz)
    length = (LASTS + options.reflex_order) / pole_per_s
    return laguerre_responses(length, pole_per_s, options.reflex_order, rate_hz)


def make_record(angle, torque, rate_hz, kept, training, lowpass, options) -> CascadeRecord:
    """Filtered record of which the first part is fitted.

    angle, torque: whole record, unfiltered (rad, N·m). Shape (n,).
    rate_hz: sampling rate (Hz).
    kept: samples that are used; the angle before them determines the reflex at their start.
    lowpass: zero-lag low-pass for signals and regressors, along axis 0.
    options: options of the analysis.
    """
    turned = angle - angle[kept][:training].mean()
    filtered = lowpass(turned)
    swing = np.ptp(filtered[kept][:training])
    if not swing > 0.0:
        raise InputError(
            "expected a moving joint, found an angle that stands still: check that the perturbation was "
            "applied"
        )
    _refuse_one_frequency(filtered[kept][:training], rate_hz)
    return CascadeRecord(
        torque=lowpass(torque),
        angle=filtered,
        turned=turned,
        rate_hz=rate_hz,
        kept=kept,
        training=training,
        lowpass=lowpass,
        options=options,
        radii=tuple(r for r in options.stop_radii_rad if 2.0 * r <= REACHED * swing),
        slow=SlowModel(1.0, 0.0),
    )


def _refuse_one_frequency(angle: np.ndarray, rate_hz: float) -> None:
    """Refuse a movement at one frequency only, at which inertia and stiffness exchange."""
    power = np.abs(np.fft.rfft(np.hanning(angle.size) * (angle - angle.mean()))) ** 2
    frequency = np.fft.rfftfreq(angle.size, 1.0 / rate_hz)
    power = power * frequency**2
    # how many lines of the spectrum share the power of the velocity; the window makes two of one
    if power.sum() ** 2 < FEWEST_LINES * np.sum(power**2):
        raise InputError(
            "expected a perturbation of several frequencies, found movement at one, "
            f"{frequency[power.argmax()]:.2g} Hz, which does not separate inertia from stiffness: perturb at "
            "random, by steps or by a sum of sinusoids"
        )


@dataclass(frozen=True)
class Design:
    """Regressors of a structure over the part that is used."""

    columns: Annotated[np.ndarray, "(n, p)"]
    """Scaled regressors."""
    white: Annotated[np.ndarray, "(n, p)"]
    """Their innovations, which are fitted."""
    scale: Annotated[np.ndarray, "(p,)"]
    """Divisor of each regressor."""
    groups: dict[str, slice]
    """Columns of each group."""
    penalty: Annotated[np.ndarray, "(p, p)"]
    """Penalty without lambda."""

    @property
    def bounded(self) -> np.ndarray:
        """True for a coefficient that must not be negative: stop and relaxing elements."""
        held = np.zeros(self.scale.size, dtype=bool)
        for name in ("stops", "relaxing"):
            held[self.groups[name]] = True
        return held

    def of(self, structure: Structure) -> np.ndarray:
        """Indices of the columns of a structure with fewer terms."""
        names = column_groups(structure)
        return np.concatenate([np.arange(self.scale.size)[self.groups[name]] for name in names])


def column_groups(structure: Structure) -> list[str]:
    """Groups of regressors of a structure, in their order."""
    return [
        "intrinsic",
        *["stops"] * structure.stops,
        *["relaxing"] * structure.relaxing,
        *["stiffening"] * structure.stiffening,
        *["reflex"] * (structure.direction != 0),
        *["gain_slope"] * structure.gain_slope,
        *["unloading"] * structure.unloading,
        "offset",
    ]


def make_design(
    record: CascadeRecord,
    structure: Structure,
    given: dict[str, np.ndarray] | None = None,
    fitted_only: bool = False,
) -> Design:
    """Regressors of a structure.

    given: groups that replace groups of the record (units of the torque's regressors).
    fitted_only: whether only the innovations of the fitted part are wanted, which is quicker.
    """
    given = given or {}
    names = column_groups(structure)
    pairs = [
        (given[name], record.whiten(given[name])) if name in given else record.group(name, structure)
        for name in names
    ]
    rows = slice(0, record.training if fitted_only else None)
    fitted = [white[: record.training] for _, white in pairs]
    # one scale for all columns of a group, so that the penalty does not distort a response
    sizes = [np.sqrt(np.vdot(part, part) / part.size) or 1.0 for part in fitted]
    ends = np.cumsum([part.shape[1] for part in fitted])
    groups = {
        name: slice(int(end) - part.shape[1], int(end))
        for name, part, end in zip(names, fitted, ends, strict=True)
    }
    groups |= {name: slice(0, 0) for name in GROUPS if name not in groups}
    white = np.concatenate([x[rows] / size for (_, x), size in zip(pairs, sizes, strict=True)], axis=1)
    columns = white[:0]
    if not fitted_only:
        columns = np.concatenate([x / size for (x, _), size in zip(pairs, sizes, strict=True)], axis=1)
    scale = np.repeat(sizes, [part.shape[1] for part in fitted])
    return Design(columns, white, scale, groups, _penalty(groups, structure, given))


def _penalty(groups: dict[str, slice], structure: Structure, given: dict) -> np.ndarray:
    """Penalty of all columns without lambda."""
    size = max(columns.stop for columns in groups.values())
    penalty = np.zeros((size, size))
    lags = groups["intrinsic"].stop
    penalty[:lags, :lags] = np.diag((np.abs(np.arange(lags) - lags // 2) > 1).astype(float))
    for name in REFLEX_GROUPS:
        columns = groups[name]
        count = columns.stop - columns.start
        if name in given or not count:
            continue
        if structure.pole_per_s:
            penalty[columns, columns] = RIDGE * np.eye(count)
        else:
            bends = np.diff(np.eye(count + 2), 2, axis=0)[:, 1:-1]
            penalty[columns, columns] = bends.T @ bends
    return penalty


REFLEX_GROUPS = ("reflex", "gain_slope", "unloading")
GROUPS = ("intrinsic", "stops", "relaxing", "stiffening", *REFLEX_GROUPS, "offset")
