"""Conversion of the treadmill's log and the markers, if there are any, to one trial on one clock.

Time 0 is the trigger. All signals are repaired, calibrated and aligned here, and the attributes of the
trial record what was done.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.ingest.plausibility import refuse_dead_channels
from tepsipe.ingest.treadmill_options import TreadmillOptions
from tepsipe.io.formats import read_markers
from tepsipe.io.readers.recording import Markers
from tepsipe.io.readers.treadmill_log import (
    CalibrationMatrix,
    TreadmillLog,
    read_calibration_matrix,
    read_treadmill_log,
)
from tepsipe.io.trial import Signal, Trial, calibration_key, faults_attribute
from tepsipe.signals.resampling import (
    BAND_PER_RATE,
    align_sequential_samples,
    bridge_gaps,
    fill_gaps,
    refuse_short,
    regular_time,
    resample,
    rising_edge,
)
from tepsipe.signals.sample_faults import sample_flags

BELTS = ("left", "right")


@dataclass(frozen=True)
class TreadmillSignals:
    """Signals measured by a treadmill, on the clock of its trial."""

    belts: tuple[str, ...]
    """Belts with forces."""
    force: Annotated[np.ndarray, "(n, belts, 3)"]
    moment: Annotated[np.ndarray, "(n, belts, 3)"]
    """Ground reaction forces (N) and moments (N·m)."""
    velocity: Annotated[np.ndarray, "(n,)", "m/s"]
    """Velocity of the perturbed belt."""
    command: np.ndarray | None
    """Its commanded velocity (m/s), if it was recorded."""
    calibrated: tuple[str, ...]
    moved: tuple[str, ...]
    derived: tuple[str, ...]
    """Processing of forces and moments, of all signals but the velocity, and of the velocity."""


@dataclass(frozen=True)
class MarkerSignals:
    """Markers of a trial with its clock."""

    grid: Annotated[np.ndarray, "(n,)", "s"]
    """Instants of the trial."""
    labels: tuple[str, ...]
    signals: dict[str, Signal]
    """``marker_position``, ``marker_position_as_sampled`` (m), ``marker_hidden``."""
    hidden_samples: int
    """Number of samples that were filled."""


def ingest_treadmill_files(
    files: dict[str, str],
    marker_labels: list[str] | None,
    options: TreadmillOptions,
    duration_s: float,
    bridge_long_gaps: bool = False,
) -> Trial:
    """Read a treadmill's files and make one trial of them; see `ingest_treadmill`.

    files: paths of ``log`` and ``calibration``, and of ``markers`` where there are any.
    marker_labels: markers in the order of sequential sampling; None if there are none.
    options: rates, longest gap, trigger.
    duration_s: length of the trial by the protocol.
    bridge_long_gaps: as `ingest_treadmill`.
    Returns: forces, moments, belt and, if there are any, markers.
    """
    log, calibration = read_treadmill_log(files["log"]), read_calibration_matrix(files["calibration"])
    if calibration.channels == log.channels:
        refuse_dead_channels(log.voltages, log.channels, calibration.matrix, files["log"])
    markers = None if marker_labels is None else read_markers(files["markers"], marker_labels)
    return ingest_treadmill(log, calibration, markers, options, duration_s, files, bridge_long_gaps)


def ingest_treadmill(
    log: TreadmillLog,
    calibration: CalibrationMatrix,
    markers: Markers | None,
    options: TreadmillOptions,
    duration_s: float,
    names: dict[str, str],
    bridge_long_gaps: bool = False,
) -> Trial:
    """Trial on the instrumented treadmill: forces, belt and markers on the motion capture's clock.

    Without markers the clock is the trigger's own: 0, 1 / rate, 2 / rate, ... up to the trial's end.

    log: voltages, belt velocity and trigger.
    calibration: forces and moments per voltage.
    markers: positions, NaN while hidden, in the order of sequential sampling; None if nothing on the belt
    carries markers.
    options: rates, longest gap, trigger.
    duration_s: length of the trial by the protocol.
    names: names of the sources in messages: ``log``, ``calibration`` and, with markers, ``markers``.
    bridge_long_gaps: bridge gaps longer than ``options.max_gap_s`` by straight lines instead of raising:
    for an analysis that omits the samples marked in ``marker_hidden``.
    Returns: ``force``, ``moment``, ``belt_velocity`` and ``belt_command``, and with markers
    ``marker_position`` (m, at common instants), ``marker_position_as_sampled`` (m, as sampled),
    ``marker_hidden``.
    """
    log_name, calibration_name = names["log"], names["calibration"]
    if calibration.channels != log.channels:
        different = next(
            ((a, b) for a, b in zip(calibration.channels, log.channels, strict=False) if a != b),
            (len(calibration.channels), len(log.channels)),
        )
        raise InputError(
            f"{calibration_name}: expected the channels of {log_name} in their order, found "
            f"{different[0]!r} where the log has {different[1]!r}: use the matrix of this treadmill"
        )
    for name, values in (
        ("transducers_V", log.voltages),
        ("belt_velocity_m_per_s", log.belt_velocity),
        ("command_m_per_s", log.command),
        ("trigger_V", log.trigger),
    ):
        if not np.isfinite(values).all():
            raise InputError(f"{log_name}: expected numbers in {name!r}, found NaN: export the log again")
    if log.rate_hz < options.resample_rate_hz:
        raise InputError(
            f"{log_name}: expected a log at {options.resample_rate_hz:g} Hz or faster, found {log.rate_hz:g} "
            "Hz: correct the variable 'sample_rate_hz'"
        )
    edge = rising_edge(log.trigger, options.trigger_threshold_V, log_name)
    high_s = float((log.trigger >= options.trigger_threshold_V).sum()) / log.rate_hz
    if markers is None:
        refuse_short(high_s, duration_s, log_name)
        grid = regular_time(0.0, min(high_s, duration_s), options.resample_rate_hz)
        marked = None
    else:
        markers_name = names["markers"]
        _refuse_other_recording(markers, options, high_s, log_name, markers_name)
        refuse_short(high_s, duration_s, log_name)
        refuse_short(markers.positions.shape[0] / markers.rate_hz, duration_s, markers_name)
        marked = marker_signals(markers, options, markers_name, bridge_long_gaps)
        grid = marked.grid
    # the trigger rose between the sample before the edge and the edge: half a sample on average
    log_time = (np.arange(log.trigger.size) - edge + 0.5) / log.rate_hz
    band = BAND_PER_RATE * options.resample_rate_hz
    moved = (
        "time zero set to the trigger",
        f"low-pass filtered at {band:g} Hz",
        f"resampled at {options.resample_rate_hz:g} Hz",
    )

    def wrench(kind: str) -> np.ndarray:
        """Forces F (N) or moments M (N·m) of both belts, shape (n, belts, 3)."""
        rows = [calibration.row(f"{kind}{axis}_{belt}") for belt in BELTS for axis in "xyz"]
        calibrated = log.voltages @ np.array(rows).T
        return resample(log_time, calibrated, grid, band).reshape(grid.size, len(BELTS), 3)

    treadmill = TreadmillSignals(
        belts=BELTS,
        force=wrench("F"),
        moment=wrench("M"),
        velocity=resample(log_time, log.belt_velocity, grid, band),
        command=resample(log_time, log.command, grid, band),
        calibrated=("calibration matrix applied",),
        moved=moved,
        derived=moved,
    )
    used = log.voltages[edge:, (calibration.matrix != 0.0).any(axis=0)].T
    facts = {
        "trigger_sample": edge,
        **faults_attribute(*sample_flags(*used.astype(float), log.belt_velocity[edge:])),
    }
    for belt in BELTS:
        rows = [calibration.row(f"{kind}{axis}_{belt}") for kind in "FM" for axis in "xyz"]
        facts[calibration_key(belt)] = np.array(rows).tolist()
    return treadmill_trial(grid, options.resample_rate_hz, treadmill, marked, facts)


def treadmill_trial(
    grid: Annotated[np.ndarray, "(n,)", "s"],
    rate_hz: float,
    treadmill: TreadmillSignals,
    markers: MarkerSignals | None,
    attributes: dict,
) -> Trial:
    """One trial from the signals of treadmill and markers.

    grid: instants of all signals.
    treadmill: forces, moments and belt.
    markers: markers, if there are any.
    attributes: further facts.
    Returns: with the signals of `ingest_treadmill`.
    """
    done, moved, of_belts = treadmill.calibrated, treadmill.moved, ("time", "belt", "axis")
    signals = {
        "force": Signal(
            treadmill.force.astype(np.float32), "N", of_belts, "ground reaction forces", (*done, *moved)
        ),
        "moment": Signal(
            treadmill.moment.astype(np.float32),
            "Nm",
            of_belts,
            "ground reaction moments about the plate's origin",
            (*done, *moved),
        ),
        "belt_velocity": Signal(
            treadmill.velocity, "m/s", ("time",), "measured velocity of the belt", treadmill.derived
        ),
    }
    if treadmill.command is not None:
        signals["belt_command"] = Signal(
            treadmill.command, "m/s", ("time",), "commanded velocity of the belt", moved
        )
    return Trial(
        rate_hz=rate_hz,
        axes={
            "time": grid,
            "belt": np.array(treadmill.belts),
            **({} if markers is None else {"marker": np.array(markers.labels)}),
            "axis": np.array(["x", "y", "z"]),
        },
        signals={**signals, **({} if markers is None else markers.signals)},
        attributes={**({} if markers is None else {"hidden_samples": markers.hidden_samples}), **attributes},
    )


def _refuse_other_recording(
    markers: Markers, options: TreadmillOptions, high_s: float, log_name: str, markers_name: str | None
) -> None:
    """Compare the markers' rate and length with the options and with the time that the trigger was high."""
    if abs(markers.rate_hz - options.resample_rate_hz) > 1e-6:
        raise InputError(
            f"{markers_name}: expected markers at {options.resample_rate_hz:g} Hz, found "
            f"{markers.rate_hz:g} Hz: correct the resampling rate in the configuration"
        )
    frames_s = markers.positions.shape[0] / markers.rate_hz
    if abs(high_s - frames_s) > 0.1:
        raise InputError(
            f"{markers_name}: expected markers for the {high_s:.2f} s that the trigger was high in "
            f"{log_name}, found {frames_s:.2f} s: one of the two files is truncated or of another trial"
        )


def marker_signals(
    markers: Markers, options: TreadmillOptions, markers_name: str | None, bridge_long_gaps: bool
) -> MarkerSignals:
    """Markers (m) on a clock (s) that starts with the first frame; that frame is left out."""
    filled = np.empty_like(markers.positions)
    hidden = np.empty(markers.positions.shape[:2], dtype=bool)
    for k, label in enumerate(markers.labels):
        what = f"{markers_name}, marker {label!r}"
        positions = markers.positions[:, k]
        long = np.zeros(positions.shape[0], dtype=bool)
        if bridge_long_gaps:
            positions, long = bridge_gaps(positions, markers.rate_hz, options.max_gap_s, what)
        filled[:, k], short = fill_gaps(positions, markers.rate_hz, options.max_gap_s, what)
        hidden[:, k] = long | short
    if options.marker_sampling_hz is None:
        grid, aligned = np.arange(1, filled.shape[0]) / markers.rate_hz, filled[1:]
        instants = "all markers sampled at the frame's instant"
    else:
        grid, aligned = align_sequential_samples(filled, markers.rate_hz, options.marker_sampling_hz)
        instants = f"interpolated at common instants (sequential sampling, {options.marker_sampling_hz:g} Hz)"
    gaps = (f"gaps up to {options.max_gap_s:g} s filled by a cubic spline",)
    if bridge_long_gaps:
        gaps += ("longer gaps bridged by straight lines",)
    signals = {
        "marker_position": Signal(
            aligned.astype(np.float32), "m", ("time", "marker", "axis"), "marker positions", (*gaps, instants)
        ),
        "marker_position_as_sampled": Signal(
            filled[1:].astype(np.float32),
            "m",
            ("time", "marker", "axis"),
            "marker positions, each at the instant its marker was sampled",
            gaps,
        ),
        "marker_hidden": Signal(
            hidden[1:], "1", ("time", "marker"), "true where a hidden position was filled in"
        ),
    }
    return MarkerSignals(grid, markers.labels, signals, int(hidden.sum()))
