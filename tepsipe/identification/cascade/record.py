"""Signals and regressors of a parallel-cascade model (`tepsipe.identification.cascade.parallel_cascade`)."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.identification.cascade.fit import SlowModel, Structure
from tepsipe.identification.cascade.normal_equations import row_spans
from tepsipe.identification.cascade.options import ParallelCascadeOptions
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
    """What was computed: by its name for the latest choice, and small results for every structure."""

    @property
    def used(self) -> np.ndarray:
        """Torque of the part in use (N·m)."""
        return self.torque[self.kept]

    @property
    def white_torque(self) -> np.ndarray:
        """Innovation of the torque of the fitted part (N·m)."""
        return self._latest("torque", self.slow, lambda: self.whiten(self.torque[: self.fitted.stop]))[
            self.kept.start :
        ]

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

    def regressors(self, name: str, structure: Structure, rows: slice) -> np.ndarray:
        """Regressors of one group of a structure for samples of the part in use.

        Shape (rows, columns); units of angle, velocity, and products of them.
        """
        delay_s = _delay_s(name, structure)
        late = round(delay_s * self.rate_hz, 6)
        first, last = self.kept.start + rows.start, self.kept.start + rows.stop
        start = max(0, first - int(np.ceil(late)))
        x = self._compute(name, structure, slice(start, max(start + 1, last - int(np.floor(late)))))
        return delayed(x, delay_s, self.rate_hz, slice(first - start, last - start))

    def innovations(self, name: str, structure: Structure, rows: slice) -> np.ndarray:
        """Innovations of the same regressors for samples of the fitted part, shape (rows, columns)."""
        choice = (_choice(name, structure), self.slow)
        white = self._latest(f"white {name}", choice, lambda: self._whitened(name, structure))
        first = self.kept.start
        rows = slice(first + rows.start, first + rows.stop)
        return delayed(white, _delay_s(name, structure), self.rate_hz, rows)

    def reflex_input(self, name: str, structure: Structure) -> np.ndarray:
        """Filtered input of a reflex pathway without its delay over the whole record, shape (n,).

        ``reflex`` and ``unloading``, which has no threshold, in rad/s, ``gain_slope`` in rad²/s.
        """
        direction = -structure.direction if name == "unloading" else structure.direction
        threshold = 0.0 if name == "unloading" else structure.threshold_rad_per_s
        signal = "turned" if structure.unfiltered else "angle"
        if f"rate of {signal}" not in self.made:
            time = np.arange(self.angle.size) / self.rate_hz
            self.made[f"rate of {signal}"] = derivative(time, getattr(self, signal))
        velocity = rectified(self.made[f"rate of {signal}"], direction, threshold)
        return self.lowpass(velocity * self.angle if name == "gain_slope" else velocity)

    def once(self, name: str, structure: Structure, make: Callable[[], object]) -> object:
        """What ``make`` returns for a structure and the present weights, made once: profiles ask again."""
        choice = name, structure, self.slow
        if choice not in self.made:
            self.made[choice] = make()
        return self.made[choice]

    def _latest(self, name: str, choice: object, make: Callable[[], np.ndarray]) -> np.ndarray:
        """What ``make`` returns for a choice, kept until the next: all choices would fill the memory."""
        if name not in self.made or self.made[name][0] != choice:
            self.made.pop(name, None)
            self.made[name] = choice, make()
        return self.made[name][1]

    def _whitened(self, name: str, structure: Structure) -> np.ndarray:
        """Innovations of one group without the delay of the reflex, up to the end of the fitted part."""
        stop, white, state = self.fitted.stop, None, None
        for part in row_spans(slice(0, self.angle.size)):
            if part.start < stop:
                x = self._compute(name, structure, part)[: stop - part.start]
                white = np.empty((stop, x.shape[1])) if white is None else white
                white[part], state = self.slow.whiten_part(x, self.rate_hz, state)
        return white

    def _compute(self, name: str, structure: Structure, rows: slice) -> np.ndarray:
        """Regressors of one group without the delay of the reflex for samples of the whole record."""
        if name == "intrinsic":
            longest = max(1, round(self.options.intrinsic_lag_s * self.rate_hz))
            return lagged(self.angle, np.arange(-longest, longest + 1), rows)
        if name == "offset":
            return np.ones((rows.stop - rows.start, 1))
        if name not in REFLEX_GROUPS:
            return self._latest(name, None, lambda: self._elements(name))[rows]
        responses = kernel_responses(structure.pole_per_s, self.options, self.rate_hz)
        # all poles share the input
        u = self._latest(name, _choice(name, structure)[:-1], lambda: self.reflex_input(name, structure))
        first = max(0, rows.start - len(responses) + 1)
        through = scipy.signal.oaconvolve(u[first : rows.stop, None], responses, axes=0)
        return through[rows.start - first : rows.stop - first] / self.rate_hz

    def _elements(self, name: str) -> np.ndarray:
        """Regressors of a group of elements over the whole record, shape (n, elements)."""
        if name == "stops":
            springs = [stop_deflection(self.turned, radius) for radius in self.radii]
            return self.lowpass(np.column_stack(springs))
        if name == "relaxing":
            times = self.options.relaxation_times_s
            return np.column_stack([relaxing_deflection(self.angle, t, self.rate_hz) for t in times])
        return self.lowpass(self.turned**2)[:, None]


def _choice(name: str, structure: Structure) -> tuple:
    """What the regressors of a group depend on, without their delay."""
    if name not in REFLEX_GROUPS:
        return ()
    threshold = 0.0 if name == "unloading" else structure.threshold_rad_per_s
    return structure.direction, threshold, structure.unfiltered, structure.pole_per_s


def _delay_s(name: str, structure: Structure) -> float:
    """Delay of a group (s): that of the reflex, 0 for the joint."""
    return structure.delay_s if name in REFLEX_GROUPS else 0.0


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


def fitted_part(
    count: int, rate_hz: float, cut_s: float, block_s: float, training_fraction: float, place: str = ""
) -> tuple[slice, int, int]:
    """Kept samples of a record, number of fitted ones, and length of a block (samples).

    cut_s: time that is cut at both ends.
    block_s: length of a bootstrapped block.
    training_fraction: first part of the kept samples that is fitted.
    place: begins the message of a refusal.
    """
    cut = round(cut_s * rate_hz)
    kept = slice(cut, count - cut)
    size, block = len(range(count)[kept]), round(block_s * rate_hz)
    training = int(training_fraction * size)
    if block < 4 or training < 4 * block or size - training < block:
        raise InputError(
            f"{place}expected at least 4 blocks of {block_s:g} s to fit and one to test, found "
            f"{size / rate_hz:.3g} s of record after cutting: record longer, cut less, or shorten block_s"
        )
    return kept, training, block


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
    """Regressors of a structure, made for a range of samples at a time."""

    record: CascadeRecord
    structure: Structure
    given: dict[str, tuple[np.ndarray, np.ndarray]]
    """Groups of one's own over the part in use, and their innovations, in place of those of the record."""
    scale: Annotated[np.ndarray, "(p,)"]
    """Divisor of each regressor."""
    groups: dict[str, slice]
    """Columns of each group."""
    penalty: Annotated[np.ndarray, "(p, p)"]
    """Penalty without lambda."""

    def columns(self, rows: slice) -> Annotated[np.ndarray, "(rows, p)"]:
        """Scaled regressors for samples of the part in use."""
        return self._scaled(self._group, rows)

    def white(self, rows: slice) -> Annotated[np.ndarray, "(rows, p)"]:
        """Their innovations, which are fitted, for samples of the fitted part."""
        return self._scaled(self._white_group, rows)

    def torque(self, coefficients: np.ndarray, size: int, *names: str) -> Annotated[np.ndarray, "(size,)"]:
        """Torque of the first samples of the part in use (N·m).

        coefficients: torque over the unit of the regressors, not scaled. Shape (p,).
        size: number of samples.
        names: groups that act; all if left out.
        """
        torque = np.zeros(size)
        for name in names or column_groups(self.structure):
            if self.groups[name].stop > self.groups[name].start:
                for part in row_spans(slice(0, size)):
                    torque[part] += self._group(name, part) @ coefficients[self.groups[name]]
        return torque

    def _scaled(self, group: Callable[[str, slice], np.ndarray], rows: slice) -> np.ndarray:
        columns = np.empty((rows.stop - rows.start, self.scale.size))
        for name in column_groups(self.structure):
            at = self.groups[name]
            np.divide(group(name, rows), self.scale[at.start], out=columns[:, at])
        return columns

    def _group(self, name: str, rows: slice) -> np.ndarray:
        if name in self.given:
            return self.given[name][0][rows]
        return self.record.regressors(name, self.structure, rows)

    def _white_group(self, name: str, rows: slice) -> np.ndarray:
        if name in self.given:
            return self.given[name][1][rows]
        return self.record.innovations(name, self.structure, rows)

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
    record: CascadeRecord, structure: Structure, given: dict[str, np.ndarray] | None = None
) -> Design:
    """Regressors of a structure.

    given: groups over the part in use that replace groups of the record (units of the torque's regressors).
    """
    pairs = {name: (x, record.whiten(x)) for name, x in (given or {}).items()}
    design = Design(record, structure, pairs, np.empty(0), {}, np.empty((0, 0)))
    sizes, counts = [], []
    for name in column_groups(structure):
        power = count = 0
        for part in row_spans(slice(0, record.training)):
            x = design._white_group(name, part)
            power, count = power + np.vdot(x, x), count + x.size
        # one scale for all columns of a group, so that the penalty does not distort a response
        sizes.append(np.sqrt(power / count) or 1.0)
        counts.append(x.shape[1])
    groups = dict.fromkeys(GROUPS, slice(0, 0))
    ends = np.cumsum(counts).tolist()
    for name, count, end in zip(column_groups(structure), counts, ends, strict=True):
        groups[name] = slice(end - count, end)
    scale = np.repeat(sizes, counts)
    return replace(design, scale=scale, groups=groups, penalty=_penalty(groups, structure, pairs))


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
