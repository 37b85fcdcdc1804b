"""Conversion of a table of an instrumented treadmill's load and belt velocity to a trial on a regular clock.

Such a table is written sample by sample while the belt is accelerated, and its time stamps are often
less accurate than its samples: load and velocity were sampled by a regular clock, and the stamps are the
times at which a computer wrote them. If the stamps are consistent with a regular clock, the samples are
therefore kept and the stamps are replaced. The attributes of the trial record what was done.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.io.readers.clock import rounded_rate
from tepsipe.io.readers.text_table import refuse_other_unit
from tepsipe.io.trial import Signal, Trial
from tepsipe.signals.resampling import refuse_short, regular_time, repair_time_stamps

# A late stamp affects one sample, a missing sample shifts all subsequent stamps: the median over this
# many stamps separates the two. One missing sample shifts it by at least half a period.
SMOOTHED_STAMPS = 51
REGULAR_WITHIN_PERIODS = 0.4
# a larger fraction of repeated stamps means that the times in the file have too few decimals
REPEATED_STAMPS_AT_MOST = 0.1

KEPT, INTERPOLATED = "samples kept", "samples interpolated"


@dataclass(frozen=True)
class BeltTableOptions:
    """Options for a table of load and belt velocity."""

    load_unit: str
    """{"N", "Nm"}: Unit of the load: a force (N) or a moment (N·m)."""
    max_gap_s: float
    """Longest step between samples."""
    shortest_s: float
    """Shortest recording that is used."""


@dataclass(frozen=True)
class BeltClock:
    """Clock of a table as inferred from its time stamps; see `belt_clock`."""

    regular: bool
    """Whether the samples were taken by a regular clock and none is missing."""
    recorded_rate_hz: float
    """Rate at which the samples were taken."""
    rate_hz: float
    """The same, rounded by `rounded_rate`."""
    largest_deviation_s: float
    """Largest distance of a stamp from a straight line through all of them."""


def ingest_belt_table(
    table: dict[str, np.ndarray],
    columns: dict[str, str],
    options: BeltTableOptions,
    duration_s: float,
    name: str,
) -> Trial:
    """Trial of an instrumented treadmill whose belt was accelerated, empty or with a weight.

    If the stamps are consistent with a regular clock, the samples are kept and the stamps are replaced by
    that clock. If not, both signals are interpolated linearly between their stamps, because a spline
    overshoots between noisy samples at closely spaced stamps.

    table: ``time`` (s), ``load`` (in ``options.load_unit``), ``velocity`` of the belt (m/s); NaN in the
    latter two where a sample is missing.
    columns: ``time``, ``load``, ``velocity`` -> name in the file's header, which may end with a unit.
    options: unit, longest gap, shortest recording.
    duration_s: length of the trial by the protocol.
    name: names the source in messages.
    Returns: ``load`` (N or N·m) and ``belt_velocity``, from time 0 on.
    """
    for key, unit in (("time", "s"), ("load", options.load_unit), ("velocity", "m/s")):
        refuse_other_unit(columns[key], unit, name)
    for key in ("load", "velocity"):
        _refuse_unusable(table[key], columns[key], name)
    repaired = repair_time_stamps(table["time"], options.max_gap_s, name)
    rows = _complete_rows(table, columns, name)
    time, load, velocity = (table[key][rows] for key in ("time", "load", "velocity"))
    keep = repaired.keep[rows]
    keep[0] = True
    _refuse_short(float(time[-1] - time[0]), options, duration_s, name)
    time = time - time[0]
    repeats = np.diff(velocity[np.isfinite(velocity)]) == 0.0
    clock = belt_clock(time)
    if clock.regular:
        instants = np.arange(time.size) / clock.recorded_rate_hz
        grid = np.arange(time.size) / clock.rate_hz
        wanted = instants
        step = f"time stamps replaced by a regular clock at {clock.rate_hz:g} Hz"
    else:
        _refuse_repeated(keep, columns["time"], name)
        instants, load, velocity = time[keep], load[keep], velocity[keep]
        wanted = grid = regular_time(0.0, instants[-1], clock.rate_hz)
        step = f"interpolated linearly to a regular clock at {clock.rate_hz:g} Hz"
    missing = ~(np.isfinite(load) & np.isfinite(velocity))
    steps = (f"{int(missing.sum())} missing samples filled by straight lines", step)
    signals = {}
    for signal, values, key, unit in (
        ("load", load, "load", options.load_unit),
        ("belt_velocity", velocity, "velocity", "m/s"),
    ):
        finite = np.isfinite(values)
        repair_time_stamps(instants[finite], options.max_gap_s, f"{name}, samples with {columns[key]!r}")
        if not (clock.regular and finite.all()):
            values = np.interp(wanted, instants[finite], values[finite])
        signals[signal] = Signal(values, unit, ("time",), f"recorded as {columns[key]}", steps)
    return Trial(
        rate_hz=clock.rate_hz,
        axes={"time": grid},
        signals=signals,
        attributes={
            "clock": KEPT if clock.regular else INTERPOLATED,
            "recorded_rate_hz": clock.recorded_rate_hz,
            "largest_stamp_deviation_s": clock.largest_deviation_s,
            "longest_step_s": repaired.longest_step_s,
            "repeated_stamps": repaired.repeated,
            "repeated_velocity_fraction": float(repeats.mean()) if repeats.size else 0.0,
            "missing_samples": int(missing.sum()),
            "samples_cut_at_ends": int(table["time"].size - time.size),
        },
    )


def _complete_rows(table: dict[str, np.ndarray], columns: dict[str, str], name: str) -> slice:
    """Rows from the first to the last that has both load and velocity."""
    present = np.flatnonzero(np.isfinite(table["load"]) & np.isfinite(table["velocity"]))
    if not present.size:
        raise InputError(
            f"{name}: expected samples of {columns['load']!r} and {columns['velocity']!r} on the same lines, "
            "found none: export the recording again"
        )
    return slice(present[0], present[-1] + 1)


def _refuse_short(lasts_s: float, options: BeltTableOptions, duration_s: float, name: str) -> None:
    """Refuse a recording (s) that ends before its protocol, or is too short to be used."""
    refuse_short(lasts_s, duration_s, name)
    if lasts_s < options.shortest_s:
        raise InputError(
            f"{name}: expected at least {options.shortest_s:g} s of belt motion, found {lasts_s:.2f} s: "
            "record for longer, or allow shorter recordings (shortest_s)"
        )


def _refuse_repeated(keep: np.ndarray, column: str, name: str) -> None:
    """Refuse an irregular clock of which many stamps are equal to the preceding one."""
    repeated = float(np.mean(~keep))
    if repeated > REPEATED_STAMPS_AT_MOST:
        raise InputError(
            f"{name}: expected a different time stamp for every sample, found {100.0 * repeated:.0f} % "
            f"of {column!r} equal to the preceding one: export it with more decimals"
        )


def belt_clock(time: np.ndarray) -> BeltClock:
    """Regularity of the clock behind the time stamps, and its rate.

    The clock is regular if the stamps, smoothed by a running median over 51 of them, stay within 0.4
    periods of a straight line. Single stamps may be later, as when a zero step follows a double one. A
    missing sample shifts all subsequent stamps by one period, so that some of them exceed this distance from
    any line. The rate of an irregular clock is estimated from the steps within half of the median step, so
    that missing samples do not lower it.

    time: time stamps (s), not decreasing, at least two of them different.
    Returns: verdict, rate and largest deviation.
    """
    index = np.arange(time.size)
    slope, start = np.polyfit(index, time, 1)
    deviation = time - (start + slope * index)
    smoothed = scipy.ndimage.median_filter(deviation, size=min(SMOOTHED_STAMPS, time.size), mode="reflect")
    regular = bool(np.abs(smoothed).max() <= REGULAR_WITHIN_PERIODS * slope)
    period = slope
    if not regular:
        steps = np.diff(time)
        typical = np.median(steps[steps > 0.0])
        usual = np.abs(steps - typical) <= 0.5 * typical
        period = steps[usual].mean()
    rate = float(1.0 / period)
    return BeltClock(regular, rate, rounded_rate(rate), float(np.abs(deviation).max()))


def _refuse_unusable(values: np.ndarray, column: str, name: str) -> None:
    """Refuse a column that holds an infinite number, no number, or the same number throughout."""
    infinite = np.flatnonzero(np.isinf(values))
    if infinite.size:
        raise InputError(
            f"{name}: expected finite numbers in {column!r}, found {values[infinite[0]]:g} on line "
            f"{infinite[0] + 2}: repair the file or export it again"
        )
    finite = values[np.isfinite(values)]
    if not finite.size:
        raise InputError(f"{name}: expected numbers in {column!r}, found none: export the recording again")
    if np.ptp(finite) == 0.0:
        raise InputError(
            f"{name}: expected {column!r} to change with the belt's motion, found {finite[0]:g} throughout: "
            "check that its channel was connected and that the right column is named"
        )
