"""From the instruments' own samples to one trial on one regular clock.

Each function takes what the readers return, repairs and aligns it, and says in the trial's attributes
what it did. Time 0 is the trigger.
"""

from dataclasses import dataclass

import numpy as np

from tepsipe.errors import InputError
from tepsipe.readers.markers import Markers
from tepsipe.readers.treadmill_log import CalibrationMatrix, TreadmillLog
from tepsipe.sampling import (
    align_strobed,
    fill_gaps,
    regular_time,
    repair_time_stamps,
    resample,
    rising_edge,
)
from tepsipe.trial_file import Signal, Trial

RADIANS_PER_UNIT = {"rad": 1.0, "deg": np.pi / 180.0}
# a passband of 0.4 times the new rate keeps what is analysed and removes what would fold onto it
BAND_PER_RATE = 0.4


@dataclass(frozen=True)
class ManipulatorOptions:
    """How to ingest a manipulator's recording.

    Attributes
    ----------
    resample_rate_hz : float
        Rate of the trial (Hz).
    max_gap_s : float
        Longest gap between samples of the log (s).
    angle_unit : {"rad", "deg"}
        Unit of the logged angle.
    """

    resample_rate_hz: float
    max_gap_s: float
    angle_unit: str


def ingest_torque_manipulator(
    log: dict[str, np.ndarray],
    command: dict[str, np.ndarray],
    options: ManipulatorOptions,
    duration_s: float,
    log_name: str,
    command_name: str,
) -> Trial:
    """Trial of a torque-controlled manipulator: irregular angle log and regular torque command.

    Parameters
    ----------
    log : dict of ndarray, shape (n,)
        ``time`` (s), ``angle`` (in ``options.angle_unit``), ``trigger_time`` (s): 0 before the command
        starts, then the stamp at which it did.
    command : dict of ndarray, shape (m,)
        ``time`` from the trigger (s), ``torque`` (Nm).
    options : ManipulatorOptions
        Rate (Hz), longest gap (s), unit.
    duration_s : float
        Length of the perturbation by the protocol (s).
    log_name, command_name : str
        Name the two sources in messages.

    Returns
    -------
    Trial
        ``torque`` (Nm) and ``angle`` (rad, from its mean before the trigger).

    Raises
    ------
    InputError
        If time stamps cannot be repaired, samples are missing, the trigger is, either file ends
        early, or the angle's unit is evidently another one.
    """
    repaired = repair_time_stamps(log["time"], options.max_gap_s, log_name)
    time, angle = log["time"][repaired.keep], log["angle"][repaired.keep]
    present = np.isfinite(angle)
    repair_time_stamps(time[present], options.max_gap_s, f"{log_name}, samples with an angle")
    time, angle = time[present], RADIANS_PER_UNIT[options.angle_unit] * angle[present]
    _refuse_degrees(angle, options.angle_unit, log_name)
    triggered = log["trigger_time"][log["trigger_time"] > 0.0]
    if not triggered.size:
        raise InputError(
            f"{log_name}: expected the stamp of the trigger, found only zeros: check that the command "
            "was started while the log ran"
        )
    time = time - triggered[0]
    lasts = command["time"][-1] + np.median(np.diff(command["time"]))
    _refuse_short(lasts, duration_s, command_name)
    _refuse_short(time[-1], duration_s, log_name)
    repair_time_stamps(command["time"], options.max_gap_s, command_name)
    if not np.isfinite(command["torque"]).all():
        raise InputError(
            f"{command_name}: expected a torque on every line, found a gap: export the command again"
        )
    before = angle[time < 0.0]
    if time[0] > 0.0 or before.size < 10:
        raise InputError(
            f"{log_name}: expected at least 10 samples before the trigger, found {before.size}: start "
            "the log earlier, they give the angle at rest"
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
                (f"band limited at {BAND_PER_RATE * rate:g} Hz", f"resampled at {rate:g} Hz"),
            ),
            "angle": Signal(
                resample(time, angle, grid) - rest,
                "rad",
                ("time",),
                "joint angle from rest",
                (
                    f"{repaired.repeated} repeated stamps dropped",
                    "clock moved to the trigger",
                    "mean before the trigger subtracted",
                    f"resampled at {rate:g} Hz by a cubic spline",
                ),
            ),
        },
        attributes={
            "repeated_stamps": repaired.repeated,
            "longest_step_s": repaired.longest_step_s,
            "rest_angle_rad": rest,
        },
    )


@dataclass(frozen=True)
class TreadmillOptions:
    """How to ingest a treadmill's recording.

    Attributes
    ----------
    resample_rate_hz : float
        Rate of the trial, that of the motion capture (Hz).
    max_gap_s : float
        Longest time for which a marker may be hidden (s).
    strober_frequency_hz : float or None
        Markers per second within a frame (Hz); None if all are sampled at once.
    trigger_threshold_V : float
        Voltage above which the trigger line is high (V).
    """

    resample_rate_hz: float
    max_gap_s: float
    strober_frequency_hz: float | None
    trigger_threshold_V: float


def ingest_treadmill(
    log: TreadmillLog,
    calibration: CalibrationMatrix,
    markers: Markers,
    options: TreadmillOptions,
    log_name: str,
    calibration_name: str,
    markers_name: str,
) -> Trial:
    """Trial on the instrumented treadmill: forces, belt and markers on the motion capture's clock.

    Parameters
    ----------
    log : TreadmillLog
        Voltages (V), belt velocity (m/s) and trigger (V).
    calibration : CalibrationMatrix
        Forces and moments per voltage (N/V, Nm/V).
    markers : Markers
        Positions (m), NaN while hidden, in the order in which the strober samples them.
    options : TreadmillOptions
        Rates (Hz), longest gap (s), trigger (V).
    log_name, calibration_name, markers_name : str
        Name the sources in messages.

    Returns
    -------
    Trial
        ``wrench`` (N and Nm), ``belt_velocity`` and ``belt_command`` (m/s), ``marker_position`` (m, at
        common instants), ``marker_position_as_strobed`` (m, as sampled), ``marker_hidden``.

    Raises
    ------
    InputError
        If channels do not match, the trigger does not rise, a marker is hidden too long, or one
        recording ends before the other.
    """
    if calibration.channels != log.channels:
        different = next(
            (
                (a, b)
                for a, b in zip(calibration.channels, log.channels, strict=False)
                if a != b
            ),
            (len(calibration.channels), len(log.channels)),
        )
        raise InputError(
            f"{calibration_name}: expected the channels of {log_name} in their order, found "
            f"{different[0]!r} where the log has {different[1]!r}: use the matrix of this treadmill"
        )
    for name, values in (
        ("transducers_V", log.voltages),
        ("belt_velocity_m_per_s", log.belt_velocity),
    ):
        if not np.isfinite(values).all():
            raise InputError(
                f"{log_name}: expected numbers in {name!r}, found NaN: export the log again"
            )
    if abs(markers.rate_hz - options.resample_rate_hz) > 1e-6:
        raise InputError(
            f"{markers_name}: expected markers at {options.resample_rate_hz:g} Hz, found "
            f"{markers.rate_hz:g} Hz: correct the resampling rate in the configuration"
        )
    edge = rising_edge(log.trigger, options.trigger_threshold_V, log_name)
    high_s = float((log.trigger >= options.trigger_threshold_V).sum()) / log.rate_hz
    frames_s = markers.positions.shape[0] / markers.rate_hz
    if abs(high_s - frames_s) > 0.1:
        raise InputError(
            f"{markers_name}: expected markers for the {high_s:.2f} s that the trigger was high in "
            f"{log_name}, found {frames_s:.2f} s: one of the two files is truncated or of another trial"
        )
    filled = np.empty_like(markers.positions)
    hidden = np.empty(markers.positions.shape[:2], dtype=bool)
    for k, label in enumerate(markers.labels):
        filled[:, k], hidden[:, k] = fill_gaps(
            markers.positions[:, k],
            markers.rate_hz,
            options.max_gap_s,
            f"{markers_name}, marker {label!r}",
        )
    if options.strober_frequency_hz is None:
        grid, aligned = np.arange(1, filled.shape[0]) / markers.rate_hz, filled[1:]
        instants = "all markers sampled at the frame's instant"
    else:
        grid, aligned = align_strobed(filled, markers.rate_hz, options.strober_frequency_hz)
        instants = f"brought to common instants (strober {options.strober_frequency_hz:g} Hz)"
    # the trigger rose between the sample before the edge and the edge: half a sample on average
    log_time = (np.arange(log.trigger.size) - edge + 0.5) / log.rate_hz
    band = BAND_PER_RATE * options.resample_rate_hz
    moved = (
        "clock moved to the trigger",
        f"band limited at {band:g} Hz",
        f"resampled at {options.resample_rate_hz:g} Hz",
    )
    wrench = log.voltages @ calibration.matrix.T
    gaps = (f"gaps up to {options.max_gap_s:g} s filled by a cubic spline",)
    return Trial(
        rate_hz=options.resample_rate_hz,
        axes={
            "time": grid,
            "component": np.array(calibration.components),
            "marker": np.array(markers.labels),
            "axis": np.array(["x", "y", "z"]),
        },
        signals={
            "wrench": Signal(
                resample(log_time, wrench, grid, band).astype(np.float32),
                "N, Nm",
                ("time", "component"),
                "ground reaction forces (N) and moments (Nm) of both belts",
                ("calibration matrix applied", *moved),
            ),
            "belt_velocity": Signal(
                resample(log_time, log.belt_velocity, grid, band),
                "m/s",
                ("time",),
                "measured velocity of the belt",
                moved,
            ),
            "belt_command": Signal(
                resample(log_time, log.command, grid, band),
                "m/s",
                ("time",),
                "commanded velocity of the belt",
                moved,
            ),
            "marker_position": Signal(
                aligned, "m", ("time", "marker", "axis"), "marker positions", (*gaps, instants)
            ),
            "marker_position_as_strobed": Signal(
                filled[1:],
                "m",
                ("time", "marker", "axis"),
                "marker positions, each at the instant its marker was sampled",
                gaps,
            ),
            "marker_hidden": Signal(
                hidden[1:], "1", ("time", "marker"), "true where a position was filled"
            ),
        },
        attributes={"hidden_samples": int(hidden.sum()), "trigger_sample": edge},
    )


@dataclass(frozen=True)
class TableOptions:
    """How to ingest a table of a position-controlled manipulator.

    Attributes
    ----------
    resample_rate_hz : float
        Rate of the trial (Hz).
    max_gap_s : float
        Longest gap between samples (s).
    angle_unit : {"rad", "deg"}
        Unit of the angle.
    torque_sign : {1, -1}
        +1 if the recorded torque resists a positive angle, -1 if resisting torque is negative.
    """

    resample_rate_hz: float
    max_gap_s: float
    angle_unit: str
    torque_sign: int


def ingest_position_manipulator(
    table: dict[str, np.ndarray], options: TableOptions, name: str
) -> Trial:
    """Trial of a position-controlled manipulator: angle imposed, torque measured.

    Parameters
    ----------
    table : dict of ndarray, shape (n,)
        ``time`` (s), ``angle`` (in ``options.angle_unit``), ``torque`` (Nm).
    options : TableOptions
        Rate (Hz), longest gap (s), unit and sign.
    name : str
        Names the source in messages.

    Returns
    -------
    Trial
        ``angle`` (rad) and ``torque`` (Nm, positive when it resists a positive angle).

    Raises
    ------
    InputError
        If time stamps cannot be repaired, a gap is too long, or the angle's unit is evidently
        another one.
    """
    repaired = repair_time_stamps(table["time"], options.max_gap_s, name)
    time = table["time"][repaired.keep]
    time = time - time[0]
    recorded_hz = (time.size - 1) / (time[-1] - time[0])
    columns = np.column_stack([table["angle"], table["torque"]])[repaired.keep]
    columns, missing = fill_gaps(columns, recorded_hz, options.max_gap_s, name)
    angle = RADIANS_PER_UNIT[options.angle_unit] * columns[:, 0]
    _refuse_degrees(angle, options.angle_unit, name)
    rate = options.resample_rate_hz
    if rate > recorded_hz * 1.001:
        raise InputError(
            f"{name}: expected a recording at {rate:g} Hz or faster, found {recorded_hz:.4g} Hz: lower "
            "the resampling rate in the configuration"
        )
    grid = regular_time(time[0], time[-1], rate)
    band = BAND_PER_RATE * rate if rate < 0.99 * recorded_hz else None
    steps = (
        f"{repaired.repeated} repeated stamps dropped",
        f"{int(missing.sum())} missing samples filled",
        f"resampled from {recorded_hz:.4g} to {rate:g} Hz",
    )
    return Trial(
        rate_hz=rate,
        axes={"time": grid},
        signals={
            "angle": Signal(
                resample(time, angle, grid, band), "rad", ("time",), "joint angle", steps
            ),
            "torque": Signal(
                options.torque_sign * resample(time, columns[:, 1], grid, band),
                "Nm",
                ("time",),
                "joint torque that resists the angle",
                steps,
            ),
        },
        attributes={
            "repeated_stamps": repaired.repeated,
            "missing_samples": int(missing.sum()),
            "recorded_rate_hz": recorded_hz,
        },
    )


def _refuse_degrees(angle: np.ndarray, unit: str, name: str) -> None:
    """A joint that seems to turn by more than half a revolution was logged in another unit."""
    swing = float(np.ptp(angle))
    if swing > np.pi:
        raise InputError(
            f"{name}: expected joint angles within half a revolution, found a swing of {swing:.3g} rad "
            f"when read as {unit}: correct the angle's unit in the configuration"
        )


def _refuse_short(lasts_s: float, duration_s: float, name: str) -> None:
    if lasts_s < duration_s - 0.1:
        raise InputError(
            f"{name}: expected {duration_s:g} s from the trigger on, as the trial sheet says, found "
            f"{lasts_s:.2f} s: the file is truncated, copy it again, or correct the trial sheet"
        )
