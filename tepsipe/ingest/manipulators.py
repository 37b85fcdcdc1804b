"""Conversion of the recordings of a manipulator to one trial on one regular clock.

Each function repairs and aligns the output of the readers, and records in the attributes of the trial
what it did.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.ingest.manipulator_options import ManipulatorOptions, TableOptions
from tepsipe.io.trial import Signal, Trial, faults_attribute
from tepsipe.signals.resampling import (
    BAND_PER_RATE,
    RepairedTime,
    fill_gaps,
    refuse_short,
    regular_time,
    repair_time_stamps,
    resample,
    rising_edges,
    runs_of,
)
from tepsipe.signals.sample_faults import flags_of, sample_flags
from tepsipe.signals.time_alignment import clock_error, stamp_jitter

# torque per angle (N·m/rad) below which columns count as exchanged, and smallest range of an angle (rad)
EXCHANGED_NM_PER_RAD, LEAST_SWING_RAD = 0.1, 1e-3
# a saturated torque stays at its extreme value for this time (s), in this number of stretches
SATURATED_S, SATURATED_STRETCHES = 0.02, 3
# distinct values that an angle takes at least, or its steps are too coarse
LEAST_VALUES = 16
# relative error of the log's clock from which it is corrected: 0.6 ms in a minute
CLOCK_TOLERANCE = 1e-5
RADIANS_PER_UNIT = {"rad": 1.0, "deg": np.pi / 180.0}
# zeros in a row that may stand for missing samples: at least this number, for at most this time (s)
FEWEST_ZEROS, LONGEST_ZEROS_S = 3, 1.0
# part of the samples of a command that repeat the one before, from which on it consists of steps
STEPWISE = 0.5


@dataclass(frozen=True)
class RecordedColumns:
    """Columns of a table at their own instants, with repeated stamps and gaps removed."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    """Instants from the first sample on."""
    columns: Annotated[np.ndarray, "(n, c)"]
    """Values (units of the table)."""
    missing: np.ndarray
    """Samples that were filled."""
    repaired: RepairedTime
    """Repairs of the time stamps (s)."""
    recorded_hz: float
    """Mean rate."""

    @property
    def attributes(self) -> dict[str, float]:
        """Attributes of a trial from its table: repaired samples and the mean rate (Hz)."""
        return {
            "repeated_stamps": self.repaired.repeated,
            "missing_samples": int(self.missing.sum()),
            "recorded_rate_hz": self.recorded_hz,
        }

    def steps(self, rate_hz: float) -> tuple[str, ...]:
        """Processing of a signal that is resampled to ``rate_hz`` (Hz), in words."""
        return (
            f"{self.repaired.repeated} repeated stamps dropped",
            f"{int(self.missing.sum())} missing samples filled",
            f"resampled from {self.recorded_hz:.4g} to {rate_hz:g} Hz",
        )

    def resampled(self, columns: np.ndarray, rate_hz: float) -> tuple[np.ndarray, np.ndarray]:
        """Regular instants (s) and ``columns``, shape (n, c), at these instants."""
        grid = regular_time(self.time[0], self.time[-1], rate_hz)
        band = BAND_PER_RATE * rate_hz if rate_hz < 0.99 * self.recorded_hz else None
        return grid, np.column_stack([resample(self.time, x, grid, band) for x in columns.T])


def recorded_columns(
    table: dict[str, np.ndarray], keys: list[str], max_gap_s: float, duration_s: float, name: str
) -> RecordedColumns:
    """Columns of a table with its time stamps repaired and its gaps filled.

    table: ``time`` (s) and the columns.
    keys: columns wanted.
    max_gap_s, duration_s: longest gap, and length of the trial by the protocol.
    name: names the source in messages.
    """
    usual_s = float(np.nanmedian(np.diff(table["time"]))) if table["time"].size > 1 else 0.0
    if usual_s > 0.999 * max_gap_s:
        raise InputError(
            f"{name}: expected samples closer than {max_gap_s:g} s, found one every {usual_s:.3g} s: convert "
            "the time to seconds if it is not, record faster, or increase max_gap_s in the configuration"
        )
    repaired = repair_time_stamps(table["time"], max_gap_s, name)
    time = table["time"][repaired.keep]
    time = time - time[0]
    refuse_short(time[-1], duration_s, name)
    recorded_hz = (time.size - 1) / (time[-1] - time[0])
    values = np.column_stack([table[key] for key in keys])[repaired.keep]
    for key, column in zip(keys, values.T, strict=True):
        _refuse_placeholders(time, column, key.replace("_", " "), name)
    columns, missing = fill_gaps(values, recorded_hz, max_gap_s, name)
    return RecordedColumns(time, columns, missing, repaired, recorded_hz)


def _refuse_placeholders(time: np.ndarray, values: np.ndarray, what: str, name: str) -> None:
    """Refuse runs of zeros that a signal enters or leaves by larger steps than it takes anywhere else."""
    steps = np.abs(np.diff(values))
    zero = values == 0.0
    runs = [(start, stop) for start, stop in runs_of(zero) if stop - start >= FEWEST_ZEROS]
    border = zero[1:] | zero[:-1]
    usual = float(np.nanmax(steps[~border], initial=0.0))
    for start, stop in runs:
        if time[stop - 1] - time[start] > LONGEST_ZEROS_S:  # a signal that stands still
            continue
        beside = steps[[k for k in (start - 1, stop - 1) if 0 <= k < steps.size]]
        if usual > 0.0 and np.nanmax(beside, initial=0.0) > usual:
            raise InputError(
                f"{name}: expected the {what} of every sample, found {stop - start} zeros in a row at "
                f"{time[start]:.3f} s, which it enters or leaves by a larger step than any other: leave the "
                "fields of missing samples empty"
            )


def refuse_slow(recorded_hz: float, rate_hz: float, setting: str, name: str) -> None:
    """Refuse a recording slower than the rate of the trial (Hz); ``setting`` names the key to lower."""
    if rate_hz > recorded_hz * 1.001:
        raise InputError(
            f"{name}: expected a recording at {rate_hz:g} Hz or faster, found {recorded_hz:.4g} Hz: lower "
            f"{setting} in the configuration"
        )


def ingest_torque_manipulator(
    log: dict[str, np.ndarray],
    command: dict[str, np.ndarray],
    options: ManipulatorOptions,
    duration_s: float,
    log_name: str,
    command_name: str,
) -> Trial:
    """Trial of a torque-controlled manipulator: irregular angle log and regular torque command.

    log: ``time`` (s), ``angle`` (in ``options.angle_unit``), ``trigger_time`` (s): 0 before the command
    starts, then the stamp at which it did.
    command: ``time`` from the trigger (s), ``torque`` (N·m).
    options: rate, longest gap, unit.
    duration_s: length of the perturbation by the protocol.
    log_name, command_name: name the two sources in messages.
    """
    repaired = repair_time_stamps(log["time"], options.max_gap_s, log_name)
    time, angle = log["time"][repaired.keep], log["angle"][repaired.keep]
    present = np.isfinite(angle)
    repair_time_stamps(time[present], options.max_gap_s, f"{log_name}, samples with an angle")
    time, angle = time[present], RADIANS_PER_UNIT[options.angle_unit] * angle[present]
    _refuse_degrees(angle, options.angle_unit, log_name)
    time = time - _trigger(log["trigger_time"], time, log_name)
    _refuse_broken_command(command, options, duration_s, command_name)
    refuse_short(time[-1], duration_s, log_name)
    _refuse_coarse(angle, log_name)
    _refuse_saturated("an angle", "rad", angle, (time.size - 1) / (time[-1] - time[0]), log_name)
    jitter = stamp_jitter(time, angle)
    error = _clock_error(time, angle, command, options.resample_rate_hz)
    time = time / (1.0 + error)
    before = angle[time < 0.0]
    if time[0] > 0.0 or before.size < 10:
        raise InputError(
            f"{log_name}: expected at least 10 samples before the trigger, found {before.size}: start "
            "the log earlier, because they define the angle at rest"
        )
    rate = options.resample_rate_hz
    grid = regular_time(max(0.0, command["time"][0]), min(time[-1], command["time"][-1]), rate)
    torque = resample(command["time"], command["torque"], grid, BAND_PER_RATE * rate)
    rest = float(before.mean())
    return Trial(
        rate_hz=rate,
        axes={"time": grid},
        signals={
            "torque": Signal(
                torque,
                "Nm",
                ("time",),
                "commanded torque",
                (f"low-pass filtered at {BAND_PER_RATE * rate:g} Hz", f"resampled at {rate:g} Hz"),
            ),
            "angle": Signal(
                resample(time, angle, grid) - rest,
                "rad",
                ("time",),
                "joint angle from rest",
                (
                    f"{repaired.repeated} repeated stamps dropped",
                    "time zero set to the trigger",
                    *[f"clock {'slowed' if error > 0.0 else 'quickened'} by {abs(error):.3g}"] * bool(error),
                    "mean before the trigger subtracted",
                    f"resampled at {rate:g} Hz by a cubic spline",
                ),
            ),
        },
        attributes={
            "repeated_stamps": repaired.repeated,
            "longest_step_s": repaired.longest_step_s,
            "rest_angle_rad": rest,
            "clock_error": error,
            "stamp_jitter_s": jitter,
            **faults_attribute(
                *flags_of((time.size - 1) / (time[-1] - time[0]), None, angle=angle),
                *_faults_of_command(command["torque"]),
            ),
        },
    )


def _clock_error(time, angle, command, rate_hz: float) -> float:
    """Relative error of the log's clock against the command's, 0 if it does not matter."""
    grid = regular_time(max(0.0, command["time"][0]), min(time[-1], command["time"][-1]), rate_hz)
    torque = resample(command["time"], command["torque"], grid, BAND_PER_RATE * rate_hz)
    error = clock_error(torque, resample(time, angle, grid), rate_hz)
    return error if abs(error) > CLOCK_TOLERANCE else 0.0


def _trigger(stamps: np.ndarray, time: np.ndarray, name: str) -> float:
    """Stamp of the trigger (s): the first that is not 0, within the log's time (s)."""
    triggered = stamps[stamps > 0.0]
    if not triggered.size:
        found = "only zeros" if not stamps.any() else f"none above 0, but {stamps[stamps != 0.0][0]:g}"
        raise InputError(
            f"{name}: expected the stamp of the trigger, found {found}: check that the command "
            "was started while the log ran"
        )
    if triggered[0] > time[-1]:
        raise InputError(
            f"{name}: expected the trigger between {time[0]:.10g} and {time[-1]:.10g} s, the stamps of the "
            f"log, found it at {triggered[0]:.10g} s: record both stamps by one clock"
        )
    return triggered[0]


def _refuse_broken_command(
    command: dict[str, np.ndarray], options: ManipulatorOptions, duration_s: float, name: str
) -> None:
    """Refuse a commanded torque that ends early, or has a gap."""
    lasts = command["time"][-1] + np.median(np.diff(command["time"]))
    refuse_short(lasts, duration_s, name)
    repair_time_stamps(command["time"], options.max_gap_s, name)
    if not np.isfinite(command["torque"]).all():
        raise InputError(f"{name}: expected a torque on every line, found a gap: export the command again")


def _faults_of_command(torque: np.ndarray) -> tuple[str, ...]:
    """Spikes, held and cut samples of a commanded torque (N·m); a command of steps has none of them."""
    return () if np.mean(np.diff(torque) == 0.0) > STEPWISE else sample_flags(torque)


def ingest_position_manipulator(
    table: dict[str, np.ndarray], options: TableOptions, duration_s: float, name: str
) -> Trial:
    """Trial of a position-controlled manipulator: angle imposed, torque measured.

    table: ``time`` (s), ``angle`` (in ``options.angle_unit``), ``torque`` (N·m); if recorded, ``schedule``,
    a scheduled quantity, and ``trigger``, which rises where a realisation begins.
    options: rate, longest gap, unit and sign.
    duration_s: length of the trial by the protocol.
    name: names the source in messages.
    Returns: ``angle`` and ``torque`` (N·m, positive when it resists a positive angle), ``schedule`` and
    ``trigger`` (1 at the first sample of a realisation) where the table has them.
    """
    recorded = recorded_columns(table, ["angle", "torque"], options.max_gap_s, duration_s, name)
    torque = recorded.columns[:, 1]
    angle = RADIANS_PER_UNIT[options.angle_unit] * recorded.columns[:, 0]
    refuse_exchanged(angle, torque, name)
    _refuse_degrees(angle, options.angle_unit, name)
    _refuse_saturated("a torque", "N·m", torque, recorded.recorded_hz, name)
    _refuse_coarse(angle, name)
    _refuse_little_motion(angle, options.angle_unit, name)
    rate = options.resample_rate_hz
    refuse_slow(recorded.recorded_hz, rate, "the resampling rate", name)
    grid, even = recorded.resampled(np.column_stack([angle, torque]), rate)
    steps, repaired = recorded.steps(rate), recorded.repaired
    return Trial(
        rate_hz=rate,
        axes={"time": grid},
        signals={
            "angle": Signal(even[:, 0], "rad", ("time",), "joint angle", steps),
            "torque": Signal(
                options.torque_sign * even[:, 1],
                "Nm",
                ("time",),
                "joint torque that resists the angle",
                steps,
            ),
            **_scheduled(table, repaired.keep, recorded.time, grid, options, name),
        },
        attributes=recorded.attributes
        | faults_attribute(*flags_of(recorded.recorded_hz, None, angle=angle, torque=torque)),
    )


def _scheduled(table, keep, time, grid, options, name) -> dict[str, Signal]:
    """Schedule and trigger of a table, if present, held between samples because both may jump."""
    rate, signals = options.resample_rate_hz, {}
    for key, what in (("schedule", "scheduled quantity"), ("trigger", "start of a realisation")):
        if key not in table:
            continue
        line = table[key][keep]
        finite = np.isfinite(line)
        repair_time_stamps(time[finite], options.max_gap_s, f"{name}, samples with a {key}")
        if key == "schedule":
            held = np.searchsorted(time[finite], grid + 1e-9, side="right") - 1
            values = line[finite][np.maximum(held, 0)]
        else:
            edges = time[finite][rising_edges(line[finite], f"{name}, column of the trigger")]
            values = np.zeros(grid.size)
            values[np.clip(np.ceil((edges - grid[0]) * rate - 1e-6).astype(int), 0, grid.size - 1)] = 1.0
        signals[key] = Signal(values, "1", ("time",), what, (f"held between samples, at {rate:g} Hz",))
    return signals


def _refuse_degrees(angle: np.ndarray, unit: str, name: str) -> None:
    """Refuse angles beyond half a revolution, which were logged in another unit."""
    swing = float(np.ptp(angle))
    if swing > np.pi:
        raise InputError(
            f"{name}: expected joint angles within half a revolution, found a swing of {swing:.3g} rad "
            f"when read as {unit}: "
            "correct angle_unit in the configuration or in the trial sheet"
        )


def refuse_exchanged(angle: np.ndarray, torque: np.ndarray, name: str, joint: str = "") -> None:
    """Refuse a torque so small for the angle that the columns must be exchanged.

    angle, torque: angle (rad) and torque (N·m) of a joint.
    name, joint: name the source and, if there are several, the joint in messages.
    """
    spread = float(angle.std())
    ratio = float(torque.std()) / spread if spread > 0.0 else np.inf
    if 0.0 < ratio < EXCHANGED_NM_PER_RAD and np.ptp(torque) < 0.5 * np.pi:
        raise InputError(
            f"{name}: expected a torque of at least {EXCHANGED_NM_PER_RAD:g} N·m per rad of the angle"
            f"{joint and ' of the ' + joint}, found {ratio:.2g} N·m/rad: exchange the columns of torque and "
            "angle in the configuration, or correct their units"
        )


def _refuse_coarse(angle: np.ndarray, name: str) -> None:
    """Refuse an angle that is recorded in steps too coarse for its swing."""
    values = np.unique(angle)
    if 1 < values.size < LEAST_VALUES:
        raise InputError(
            f"{name}: expected an angle of at least {LEAST_VALUES} distinct values, found {values.size} in "
            f"steps of {np.diff(values).min():.2g} rad: record with a finer resolution, or perturb more"
        )


def _refuse_saturated(what: str, unit: str, x: np.ndarray, rate_hz: float, name: str) -> None:
    """Refuse a signal that repeatedly stays at its largest or smallest value."""
    for word, value in (("largest", x.max()), ("smallest", x.min())):
        runs = [stop - start for start, stop in runs_of(x == value)]
        long = [run for run in runs if run >= max(3, round(SATURATED_S * rate_hz))]
        if len(long) >= SATURATED_STRETCHES and np.ptp(x) > 0.0:
            raise InputError(
                f"{name}: expected {what} within the range of its sensor, found its {word} value "
                f"{value:.4g} {unit} in {len(long)} stretches of up to {1e3 * max(long) / rate_hz:.3g} ms: "
                "record with a larger range"
            )


def _refuse_little_motion(angle: np.ndarray, unit: str, name: str) -> None:
    """Refuse an angle that hardly moves; the analysis refuses one that stands still."""
    swing = float(np.subtract(*np.percentile(angle, [99.0, 1.0])))
    if 0.0 < swing < LEAST_SWING_RAD:
        raise InputError(
            f"{name}: expected an angle that is moved by at least {LEAST_SWING_RAD:g} rad, found {swing:.2g} "
            f"rad when read as {unit}: correct angle_unit, or record with a larger perturbation"
        )
