"""Conversion of one recording of a whole trial, in one file or a pair, to one trial on one clock.

Markers, force plates and analog channels share their clock, so no trigger is needed: time 0 is the first
frame, or the edge of a trigger channel where one is named. Positions, forces and moments are turned to the
axes of the study (x to the right, y forward along the belt, z up) and moved to the centre of the plates'
surface:

    p' = A p - c,    F' = A F,    M' = A M - c x A F

with the rows of A the three directions in the axes of the laboratory, and c the mean of the corners there
(zero where the file gives none).
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from tepsipe.arguments import options_of
from tepsipe.errors import InputError, listed, quoted
from tepsipe.ingest.dflow import read_dflow_files
from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.plate_treadmill import (
    MarkerSignals,
    TreadmillSignals,
    ingest_treadmill_files,
    marker_signals,
    treadmill_trial,
)
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.ingest.treadmill_options import RecordingOptions, ScaledChannel, TreadmillOptions
from tepsipe.io.formats import read_all_markers, read_recording, recognised
from tepsipe.io.readers import dflow
from tepsipe.io.readers.recording import DIRECTIONS, Channel, ForcePlate, Markers, Recording, select_markers
from tepsipe.io.trial import Trial, calibration_key, faults_attribute
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.resampling import BAND_PER_RATE, refuse_short, regular_time, resample, rising_edge
from tepsipe.signals.sample_faults import sample_flags

M_PER_S = {"m/s": 1.0, "m s-1": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "km/h": 1.0 / 3.6}
# markers whose centre is farther than this from the plates (m) are not on them
FARTHEST_M = 0.5
# a load of less than this (N) on all plates together, where something stands on them, has the wrong sign
LEAST_N = -10.0
# from this load on (N) the point of the mean force must not be farther than this from the plate (m)
LEAST_LOAD_N, BESIDE_M = 15.0, 0.1
# a plate that carries this part of the load of all carries what the markers are on, within this distance (m)
# across the belt; farther than the last, a unit is wrong, which the ranges of the signals tell
MOST_OF_LOAD, ELSEWHERE_M, OUT_OF_ROOM_M = 0.8, 0.3, 20.0
# the belt's velocity from markers is band limited here (Hz): pulses pass unchanged, most of the noise does
# not
MARKER_BAND_HZ = 50.0
# half the length of that filter in periods of its cutoff
FILTER_PERIODS = 4.0
# longest gap of markers on an empty belt (s)
MAX_GAP_S = 0.1
# plates of the left belt that lie farther to the right of those of the right belt are exchanged (m)
EXCHANGED_M = 0.05
LEVEL = 0.7  # least vertical component of the normal of a plate
# log and markers start together and last as long as each other within this (s)
LENGTHS_WITHIN_S = 0.1


def read_recording_files(files: dict[str, str], belt_fixed_labels: tuple[str, ...]) -> Recording:
    """Read the recording of a trial without calibration matrix.

    files: Paths: ``log`` alone, which holds everything; or ``log`` and ``markers``: D-Flow's record and
    mocap file, or a file of forces and belt velocity and one of markers that begin at the same instant.
    belt_fixed_labels: belt-fixed markers, which align D-Flow's two files.
    Returns: markers, force plates and channels, in the axes of the files.
    """
    log = files["log"]
    if "markers" not in files:
        return read_recording(log)
    formats = recognised(log), recognised(files["markers"])
    if dflow.FORMAT in formats:
        if formats != (dflow.FORMAT, dflow.FORMAT):
            other = files["markers"] if formats[0] is dflow.FORMAT else log
            raise InputError(
                f"{other}: expected a text file of D-Flow beside the other one, found another kind: name the "
                "record file as log and the mocap file as markers"
            )
        return read_dflow_files(files["markers"], log, belt_fixed_labels)
    recording = read_recording(log)
    markers = read_all_markers(files["markers"])
    frames_s = markers.positions.shape[0] / markers.rate_hz
    rates = [(p.force.shape[0], p.rate_hz) for p in recording.plates]
    rates += [(c.values.size, c.rate_hz) for c in recording.channels.values()]
    log_s = min((n / rate for n, rate in rates), default=np.inf)
    if abs(frames_s - log_s) > LENGTHS_WITHIN_S:
        raise InputError(
            f"{files['markers']}: expected markers for the {log_s:.2f} s of {Path(log).name}, found "
            f"{frames_s:.2f} s: the two must begin and end together, cut them, or correct the trial sheet"
        )
    return replace(recording, markers=markers)


def refuse_other_vertical(plates: dict[int, ForcePlate], up: str, name: str, key: str) -> None:
    """Compare the configured upward direction with the surfaces of the plates.

    plates: number -> plate.
    up: upward direction in the axes of the file: ``+x`` to ``-z``.
    name: names the file in messages.
    key: place of ``up`` in the configuration, for messages.
    """
    for number, plate in plates.items():
        if plate.normal is not None and abs(plate.normal @ DIRECTIONS[up]) < LEVEL:
            axis = "xyz"[int(np.argmax(np.abs(plate.normal)))]
            raise InputError(
                f"{name}, force plate {number}: expected a level surface, with {up} upward by {key}, found "
                f"corners whose surface faces along {axis}: correct {key} (tepsipe info names the upward "
                "direction), or FORCE_PLATFORM:CORNERS of the file"
            )


def named_channel(recording: Recording, label: str, key: str) -> Channel:
    """A channel of a recording, named by a key of the configuration."""
    if label not in recording.channels:
        raise InputError(
            f"{recording.name}: expected a channel named {label!r}, found {listed(recording.channels)}: "
            f"name the file's channel in {key} of the configuration"
        )
    channel = recording.channels[label]
    bad = int(np.count_nonzero(~np.isfinite(channel.values)))
    if bad:
        raise InputError(
            f"{recording.name}: expected a number in every sample of the channel {label!r}, found none in "
            f"{bad}: export the file again"
        )
    return channel


def ingest_recording_files(
    files: dict[str, str],
    marker_labels: list[str] | None,
    options: TreadmillOptions,
    use: RecordingOptions,
    duration_s: float,
) -> Trial:
    """Read the recording of a whole trial and make one trial of it; see `ingest_recording`.

    files: paths, as `read_recording_files` takes them.
    marker_labels: markers in the order of sequential sampling; None if nothing on the belt carries markers.
    options: rates, longest gap, trigger.
    duration_s: length of the trial by the protocol.
    Returns: forces, moments, belt and, if there are any, markers.
    """
    recording = read_recording_files(files, use.belt_velocity.markers)
    return ingest_recording(recording, marker_labels, options, use, duration_s)


def ingest_on_plate(
    files: dict[str, str],
    marker_labels: list[str] | None,
    rates: dict,
    recording: dict | None,
    duration_s: float,
    limits: Limits,
    rig: Rig,
) -> tuple[Trial, dict]:
    """A plausible trial on the plate treadmill, of several files or of one, and the options used.

    rates: fields of `TreadmillOptions`.
    recording: fields of `RecordingOptions` for a trial in one file; None for trials of several files.
    """
    options = TreadmillOptions(**rates)
    if "calibration" in files:
        trial = ingest_treadmill_files(files, marker_labels, options, duration_s)
    else:
        use = options_of(RecordingOptions, recording or {})
        trial = ingest_recording_files(files, marker_labels, options, use, duration_s)
    used = vars(options) | ({} if recording is None else {"recording": recording})
    return plausible_trial(trial, limits, rig, files), used


def ingest_recording(
    recording: Recording,
    marker_labels: list[str] | None,
    options: TreadmillOptions,
    use: RecordingOptions,
    duration_s: float,
    bridge_long_gaps: bool = False,
) -> Trial:
    """Trial on the instrumented treadmill from one recording.

    recording: markers, plates and channels.
    marker_labels: markers in the order of sequential sampling; None if nothing on the belt carries markers.
    options: rates, longest gap, trigger.
    duration_s: length of the trial by the protocol.
    bridge_long_gaps: as `ingest_treadmill`.
    Returns: as `ingest_treadmill`, without ``belt_command`` if it was not recorded. The attribute
    ``start_s`` is the instant of time 0 in the file, ``origin_m`` the origin of the trial in the study's
    axes.
    """
    name, rate = recording.name, options.resample_rate_hz
    plates = _belt_plates(recording, use)
    axes = _axes(use, name)
    _refuse_exchanged_plates(use, plates, axes, name)
    refuse_other_vertical(plates, use.axes.up, name, "plate_treadmill.recording.axes.up")
    origin = _origin(plates, axes)
    sources = _sources(recording, use, plates)
    start_s, first_s, last_s = _span(recording, sources, use, options, duration_s)
    refuse_short(min(n / r for n, r in sources) - start_s, duration_s, name)
    marked, velocity_of = None, None
    labels = marker_labels if marker_labels is not None else list(use.belt_velocity.markers)
    if marker_labels is not None or use.belt_velocity.channel is None:
        markers = _cut(_markers(recording, labels, options), first_s, last_s, axes, origin)
        if options.max_gap_s is None:
            options = replace(options, max_gap_s=MAX_GAP_S)
        marked = marker_signals(markers, options, name, bridge_long_gaps)
        marked = replace(marked, grid=marked.grid + (first_s - start_s))
        velocity_of = marked if use.belt_velocity.channel is None else None
        grid = marked.grid
    else:
        grid = regular_time(0.0, last_s - start_s, rate)

    def on_grid(values: np.ndarray, rate_hz: float) -> np.ndarray:
        """Samples at the trial's instants (unit of ``values``)."""
        time = np.arange(values.shape[0]) / rate_hz - start_s
        band = BAND_PER_RATE * rate if rate_hz > (1.0 + 1e-6) * rate else None
        return resample(time, values, grid, band, rate_hz)

    force, moment = _wrench(recording, use, plates, axes, origin, on_grid)
    if marker_labels is not None:
        _refuse_wrong_sign(force, name)
        _refuse_far_markers(marked, plates, axes, origin, name)
        _refuse_force_elsewhere(marked, plates, axes, origin, use, name)
    moved = (f"low-pass filtered at {BAND_PER_RATE * rate:g} Hz", f"resampled at {rate:g} Hz")
    if velocity_of is None:
        velocity, derived = on_grid(*_velocity(recording, use.belt_velocity)), moved
    else:
        velocity, derived = _velocity_of_markers(use.belt_velocity.markers, velocity_of, rate, name)
    command = use.belt_command
    treadmill = TreadmillSignals(
        belts=tuple(belt for belt in ("left", "right") if _has(use, belt)),
        force=force,
        moment=moment,
        velocity=velocity,
        command=None if command.channel is None else on_grid(*_velocity(recording, command)),
        calibrated=("calibrated by the recording", "turned to the study's axes"),
        moved=moved,
        derived=derived,
    )
    facts = {"start_s": start_s, "origin_m": origin, **faults_attribute(*_faults(recording, use, plates))}
    facts |= _calibrations(use, plates)
    if velocity_of is not None:
        facts["belt_velocity_from"] = (
            f"belt-fixed markers {', '.join(use.belt_velocity.markers)}, which therefore cannot show a delay "
            "between markers and analog channels"
        )
    return treadmill_trial(grid, rate, treadmill, marked if marker_labels is not None else None, facts)


# ---- parts of the recording ----------------------------------------------------------------------


def _faults(recording: Recording, use: RecordingOptions, plates: dict[int, ForcePlate]) -> tuple[str, ...]:
    """Spikes, held and clipped samples of the channels of force plates, load cells and belt velocity."""
    labels = [label for plate in plates.values() for label in plate.channels]
    labels += [cell.channel for cell in (*use.load_cells.left, *use.load_cells.right)]
    labels += [use.belt_velocity.channel] if use.belt_velocity.channel else []
    return sample_flags(*(recording.channels[label].values for label in labels))


def _calibrations(use: RecordingOptions, plates: dict[int, ForcePlate]) -> dict[str, list]:
    """Calibration of the force plates of each belt, by `calibration_key`."""
    found = {}
    for belt in ("left", "right"):
        known = [plates[number].calibration for number in getattr(use.plates, belt)]
        if known and all(matrix is not None for matrix in known):
            found[calibration_key(belt)] = np.hstack(known).tolist()
    return found


def _has(use: RecordingOptions, belt: str) -> bool:
    return bool(getattr(use.plates, belt) or getattr(use.load_cells, belt))


def _belt_plates(recording: Recording, use: RecordingOptions) -> dict[int, ForcePlate]:
    """Number -> force plate that carries a belt."""
    key = "plate_treadmill.recording.plates"
    if not any(_has(use, belt) for belt in ("left", "right")):
        raise InputError(
            f"{recording.name}: expected the number of a force plate for a belt, found none, and no load "
            f"cells: set {key} in the configuration (the file has {len(recording.plates)} force plates)"
        )
    plates = {}
    for number in dict.fromkeys((*use.plates.left, *use.plates.right)):
        if not 1 <= number <= len(recording.plates):
            raise InputError(
                f"{recording.name}: expected a force plate {number}, found {len(recording.plates)} force "
                f"plates: correct {key} in the configuration"
            )
        plate = recording.plates[number - 1]
        if plate.fault is not None:
            raise InputError(plate.fault)
        bad = int(np.count_nonzero(~np.isfinite(plate.force)) + np.count_nonzero(~np.isfinite(plate.moment)))
        if bad:
            raise InputError(
                f"{recording.name}, force plate {number}: expected a number in every sample, found none in "
                f"{bad}: export the file again"
            )
        if not plate.force.any():
            raise InputError(
                f"{recording.name}, force plate {number}: expected a load, found zeros only: it was not "
                f"recorded, or {key} in the configuration names another plate than that of the belt"
            )
        if use.reverse_origin and plate.origin is not None:
            plate = replace(plate, moment=plate.moment + 2.0 * np.cross(plate.origin, plate.force))
        plates[number] = plate
    return plates


def _axes(use: RecordingOptions, name: str) -> np.ndarray:
    """Rows: the study's x, y and z in the axes of the file."""
    forward, up = DIRECTIONS[use.axes.forward], DIRECTIONS[use.axes.up]
    if forward @ up:
        raise InputError(
            f"{name}: expected two different axes in plate_treadmill.recording.axes, found "
            f"{use.axes.forward!r} and {use.axes.up!r}: correct one of the two in the configuration"
        )
    return np.array([np.cross(forward, up), forward, up])


def _refuse_exchanged_plates(
    use: RecordingOptions, plates: dict[int, ForcePlate], axes: np.ndarray, name: str
) -> None:
    """Raise InputError if the plates of the left belt lie to the right of those of the right belt (m)."""
    places = []
    for belt in ("left", "right"):
        corners = [plates[number].corners for number in getattr(use.plates, belt)]
        if not corners or any(of_plate is None for of_plate in corners):
            return
        places.append(float((axes[0] @ np.concatenate(corners).T).mean()))
    if places[0] - places[1] > EXCHANGED_M:
        raise InputError(
            f"{name}: expected the force plates of the left belt left of those of the right belt, found them "
            f"{places[0] - places[1]:.2g} m to the right: exchange left and right in "
            "plate_treadmill.recording.plates, or correct axes.forward there"
        )


def _origin(plates: dict[int, ForcePlate], axes: np.ndarray) -> np.ndarray:
    """Centre of the corners of all plates in the study's directions (m)."""
    corners = [plate.corners for plate in plates.values() if plate.corners is not None]
    return axes @ np.mean(np.concatenate(corners), axis=0) if corners else np.zeros(3)


def _sources(
    recording: Recording, use: RecordingOptions, plates: dict[int, ForcePlate]
) -> list[tuple[int, float]]:
    """Number of samples and rate (Hz) of all signals of the trial, except markers."""
    labels = {cell.channel: "load_cells" for cell in (*use.load_cells.left, *use.load_cells.right)}
    named = {"belt_velocity": use.belt_velocity, "belt_command": use.belt_command}
    labels |= {channel.channel: f"{key}.channel" for key, channel in named.items() if channel.channel}
    if use.trigger is not None:
        labels[use.trigger] = "trigger"
    if use.belt_velocity.channel is None and not use.belt_velocity.markers:
        raise InputError(
            f"{recording.name}: expected a channel of the belt velocity, or belt-fixed markers, found none "
            f"of both among {listed(recording.channels)}: set plate_treadmill.recording.belt_velocity in "
            "the configuration"
        )
    channels = [
        named_channel(recording, label, f"plate_treadmill.recording.{key}") for label, key in labels.items()
    ]
    return [(plate.force.shape[0], plate.rate_hz) for plate in plates.values()] + [
        (channel.values.size, channel.rate_hz) for channel in channels
    ]


def _span(
    recording: Recording,
    sources: list[tuple[int, float]],
    use: RecordingOptions,
    options: TreadmillOptions,
    duration_s: float,
) -> tuple[float, float, float]:
    """Instants of time 0, of the first frame from there on, and of the last sample that is used (s)."""
    rate = options.resample_rate_hz
    slowest = min(rate_hz for _, rate_hz in sources)
    if slowest < (1.0 - 1e-6) * rate:
        raise InputError(
            f"{recording.name}: expected plates and channels at {rate:g} Hz or faster, found {slowest:g} Hz: "
            "correct plate_treadmill.resample_rate_hz in the configuration"
        )
    last_s = min((n - 1) / rate_hz for n, rate_hz in sources)
    if use.trigger is None:
        return 0.0, 0.0, last_s
    line = named_channel(recording, use.trigger, "plate_treadmill.recording.trigger")
    edge = rising_edge(line.values, options.trigger_threshold_V, f"{recording.name}, channel {use.trigger!r}")
    # the trigger rose between the sample before the edge and the edge: half a sample on average
    start_s = (edge - 0.5) / line.rate_hz
    return start_s, np.ceil(start_s * rate - 1e-6) / rate, min(last_s, start_s + duration_s)


# ---- markers -------------------------------------------------------------------------------------


def _markers(recording: Recording, labels: list[str], options: TreadmillOptions) -> Markers:
    """The wanted markers (m), at the rate of the trial."""
    name = recording.name
    if recording.markers is None:
        raise InputError(
            f"{name}: expected markers, found none: export the file with its points, or take the belt "
            "velocity from a channel"
        )
    markers = select_markers(recording.markers, labels, name)
    if abs(markers.rate_hz - options.resample_rate_hz) > 1e-6 * markers.rate_hz:
        raise InputError(
            f"{name}: expected markers at {options.resample_rate_hz:g} Hz, found {markers.rate_hz:g} Hz: "
            "correct plate_treadmill.resample_rate_hz in the configuration"
        )
    return markers


def _cut(markers: Markers, first_s: float, last_s: float, axes: np.ndarray, origin: np.ndarray) -> Markers:
    """Frames between two instants (s), in the axes of the study and from its origin (m)."""
    first = round(first_s * markers.rate_hz)
    stop = int(np.floor(last_s * markers.rate_hz + 1e-6)) + 1
    return replace(markers, positions=markers.positions[first:stop] @ axes.T - origin)


def _refuse_far_markers(
    marked: MarkerSignals, plates: dict[int, ForcePlate], axes: np.ndarray, origin: np.ndarray, name: str
) -> None:
    """Raise InputError if the markers' centre is not above the plates (m)."""
    corners = [plate.corners for plate in plates.values() if plate.corners is not None]
    if not corners:
        return
    places = (np.concatenate(corners) @ axes.T - origin)[:, :2]
    centre = np.median(marked.signals["marker_position"].values[:, :, :2], axis=(0, 1))
    beyond = np.maximum(places.min(axis=0) - centre, centre - places.max(axis=0)).max()
    if beyond > FARTHEST_M:
        raise InputError(
            f"{name}: expected the markers above the force plate {' or '.join(map(str, plates))}, found "
            f"their centre {beyond:.2g} m outside its corners: correct plate_treadmill.recording.plates in "
            "the configuration, or FORCE_PLATFORM:CORNERS of the file"
        )


def _refuse_force_elsewhere(
    marked: MarkerSignals,
    plates: dict[int, ForcePlate],
    axes: np.ndarray,
    origin: np.ndarray,
    use: RecordingOptions,
    name: str,
) -> None:
    """Raise InputError if the mean force acts beside the plate below the markers, or beside these (m)."""
    centre = np.median(marked.signals["marker_position"].values, axis=(0, 1)) + origin
    of_both: dict[int, tuple[float, float, bool]] = {}
    total = sum(float(use.force_sign * axes[2] @ plate.force.mean(axis=0)) for plate in plates.values())
    for number, plate in plates.items():
        if plate.corners is None:
            continue
        corners = plate.corners @ axes.T
        middle = corners.mean(axis=0)
        half = np.abs(corners - middle).max(axis=0)[:2]
        force = use.force_sign * axes @ plate.force.mean(axis=0)
        if force[2] < LEAST_LOAD_N:
            continue
        moment = use.force_sign * axes @ plate.moment.mean(axis=0) - np.cross(middle, force)
        beside = np.array([-moment[1], moment[0]]) / force[2]
        beyond = float((np.abs(beside) - half).max())
        below = (np.abs(centre - middle)[:2] <= half).all()
        if below and beyond > BESIDE_M:
            raise InputError(
                f"{name}, force plate {number}: expected the mean force within the plate's corners, found "
                f"its point {beyond:.2g} m outside: set plate_treadmill.recording.reverse_origin to true if "
                "FORCE_PLATFORM:ORIGIN was stored from the surface to the plate's origin, or correct the "
                "corners or the units of the moments in the file"
            )
        apart = float((middle[:2] + beside - centre[:2])[0])
        if force[2] > MOST_OF_LOAD * total and ELSEWHERE_M < abs(apart) < OUT_OF_ROOM_M:
            raise InputError(
                f"{name}, force plate {number}: expected the load below the markers, found {force[2]:.3g} N "
                f"that act {abs(apart):.2g} m to the {'right' if apart > 0.0 else 'left'} of their centre: "
                "exchange the channels of the plates (FORCE_PLATFORM:CHANNEL), or correct their corners, in "
                "the file, or the axes in plate_treadmill.recording"
            )
        of_both[number] = float(middle[0] - centre[0]), float(beside[0]), bool(below)
    if len(of_both) == 2:
        _refuse_exchanged_channels(of_both, name)


def _refuse_exchanged_channels(plates: dict[int, tuple[float, float, bool]], name: str) -> None:
    """Raise InputError if the load of the plate below the markers would be below them on the other plate's.

    plates: number -> place of its centre to the right of the markers, of its load to the right of its centre
    (m), and whether the markers are above it.
    """
    (first, one), (second, other) = plates.items()
    for number, (middle, own, below), others in ((first, one, other[1]), (second, other, one[1])):
        apart = middle + own
        if below and abs(apart) > BESIDE_M and abs(middle + others) < 0.5 * BESIDE_M:
            raise InputError(
                f"{name}, force plate {number}: expected the load below the markers, found it "
                f"{abs(apart):.2g} m to the {'right' if apart > 0.0 else 'left'} of their centre, and below "
                "them with the channels of the other plate: exchange those of both (FORCE_PLATFORM:CHANNEL)"
            )


# ---- forces and velocities -------------------------------------------------------------------------


def _wrench(recording, use, plates, axes, origin, on_grid) -> tuple[np.ndarray, np.ndarray]:
    """Forces (N) and moments about the trial's origin (N·m), each of shape (n, belts, 3)."""
    forces, moments = [], []
    for belt in ("left", "right"):
        if not _has(use, belt):
            continue
        parts = [
            use.force_sign * on_grid(np.hstack([plate.force, plate.moment]), plate.rate_hz)
            for plate in (plates[number] for number in getattr(use.plates, belt))
        ]
        for cell in getattr(use.load_cells, belt):
            channel = named_channel(recording, cell.channel, "plate_treadmill.recording.load_cells")
            along = DIRECTIONS[cell.direction]
            unit = np.concatenate([along, np.cross(cell.position_m, along)])
            parts.append(np.outer(cell.newton_per_unit * on_grid(channel.values, channel.rate_hz), unit))
        total = np.sum(parts, axis=0)
        force = total[:, :3] @ axes.T
        forces.append(force)
        moments.append(total[:, 3:] @ axes.T - np.cross(origin, force))
    return np.stack(forces, axis=1), np.stack(moments, axis=1)


def _refuse_wrong_sign(force: np.ndarray, name: str) -> None:
    """Raise InputError if the load (N) of something on the belt points down."""
    load = float(np.median(force[:, :, 2].sum(axis=1)))
    if load < LEAST_N:
        raise InputError(
            f"{name}: expected vertical forces that point up under load, found {load:.4g} N: set "
            "plate_treadmill.recording.force_sign to -1 if the plates give the force on the plate, or "
            "correct the axes there, or the order of the corners in the file (+x +y, -x +y, -x -y, +x -y)"
        )


def _velocity(recording: Recording, scaled: ScaledChannel) -> tuple[np.ndarray, float]:
    """Velocity (m/s) in a channel, and its rate (Hz)."""
    channel = named_channel(recording, scaled.channel, "plate_treadmill.recording.belt_velocity.channel")
    per_unit = scaled.m_per_s_per_unit
    if per_unit is None:
        per_unit = M_PER_S.get(channel.unit.strip())
    if per_unit is None:
        raise InputError(
            f"{recording.name}: expected the channel {scaled.channel!r} in {', '.join(M_PER_S)}, found the "
            f"unit {quoted(channel.unit)}: set m_per_s_per_unit beside its name in the configuration"
        )
    return per_unit * (channel.values - scaled.offset), channel.rate_hz


def _velocity_of_markers(
    labels: tuple[str, ...], markers: MarkerSignals, rate_hz: float, name: str
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Velocity of belt-fixed markers (m/s), shape (n,), and how it was found."""
    for label in labels:
        if label not in markers.labels:
            raise InputError(
                f"{name}: expected the belt-fixed marker {label!r} among the markers of the trial, found "
                f"{listed(markers.labels)}: add it to marker_labels in the configuration"
            )
    columns = [markers.labels.index(label) for label in labels]
    along = markers.signals["marker_position"].values[:, columns, 1].astype(float).mean(axis=1)
    velocity, band, held = velocity_of_position(markers.grid, along, rate_hz)
    done = (
        f"mean of the markers {', '.join(labels)}",
        f"low-pass filtered at {band:g} Hz",
        "derived",
        f"held for {held / rate_hz:g} s at both ends",
    )
    return velocity, done


def velocity_of_position(
    time: np.ndarray, position: np.ndarray, rate_hz: float
) -> tuple[np.ndarray, float, int]:
    """Velocity (m/s), shape (n,), of a measured position (m) at instants ``time`` (s).

    Returns: velocity, cutoff of the band (Hz), and number of samples that are held at both ends.
    """
    band = min(MARKER_BAND_HZ, BAND_PER_RATE * rate_hz)
    velocity = derivative(time, resample(time, position, time, band, rate_hz))
    # where the filter reaches an end of the trial, the noise of one sample would tilt the whole end
    held = min(int(np.ceil(FILTER_PERIODS * rate_hz / band)), velocity.size // 4)
    velocity[:held], velocity[-held:] = velocity[held], velocity[-held - 1]
    return velocity, band, held
