"""Faults of the force plates in a recording of a person: the plate doctor.

The centre of pressure lies under the foot, so it lies within the markers of the foot on the plate, or at
least on the plate, and follows a person who walks. Where it does not, one change after another is tried
(unit, sign, axes, plates, origin), and the one that brings it there names the fault. With F and M the load in
the plate's axes, M about its origin, and o from there to the centre of the surface:

    p = z x (M - o x F) / F_z

A quiet plate without load shows its offset and its drift; the load of the whole person, its gain. A person
who walks is braked first and then driven.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tepsipe.errors import InputError
from tepsipe.ingest.agreement import GRAVITY_M_PER_S2
from tepsipe.ingest.limits import frozen_stretch
from tepsipe.ingest.whole_trial import BESIDE_M, LEAST_N, LEVEL
from tepsipe.io.formats import read_recording
from tepsipe.io.readers.c3d import NO_POSITIONS, channels_of, open_c3d
from tepsipe.io.readers.force_plates import plate_axes
from tepsipe.io.readers.recording import DIRECTIONS, Channel, ForcePlate, Recording, centre_of_pressure
from tepsipe.signals.resampling import runs_of
from tepsipe.signals.sample_faults import FAULTS, noise_floors

# name of a finding -> what it means
FINDINGS = {
    "parameters": "the file does not describe the plate, or describes it wrongly",
    "missing-samples": "samples are no numbers",
    "unit": "a force, moment or length is in another unit than the file states",
    "rate": "the rates contradict the number of analog samples in a frame",
    "sign": "a force or a moment has the opposite sign",
    "axes": "two axes of the plate are exchanged, or the plate is turned",
    "origin": "the origin of the plate, or its place in the laboratory, is wrong",
    "plates-exchanged": "the channels of two plates are exchanged",
    "sides-exchanged": "the labels of left and right markers are exchanged",
    "pressure": "the centre of pressure is not under the foot, for another reason",
    "offset": "the plate without load does not measure 0",
    "drift": "the zero of the plate drifts",
    "gain": "two plates measure different weights of one person",
    "weight": "the weight of the person is not that of the stated mass",
    "filtered-signal": "the plate was filtered before it was recorded",
    "clipped": "peaks are cut off at one value",
    "spikes": "single samples are far from their neighbours",
    "held-samples": "values are held and then jump",
}
# vertical force from which a plate is loaded (N), also relative to its largest
LOADED_N, LOADED_PART = 50.0, 0.1
# largest unloaded level of a component, and largest change of it (N)
OFFSET_N, DRIFT_N = 5.0, 5.0
# drift of the weight of a person who stands, relative to it
DRIFT_PART = 0.03
# windows in which the level is taken (s), largest level relative to the peak, and windows that are needed
QUIET_S, QUIET_PART, LEAST_WINDOWS = 0.1, 0.25, 5
# markers of a foot on the plate are lower than this above it, and at most this far beside it (m)
LOW_M, NEAR_M = 0.15, 0.15
# and slower than this (m/s)
STILL_M_PER_S = 0.5
# the centre of pressure lies beyond the markers of the foot by at most this (m) in so many of the samples
BEYOND_M, SHARE = 0.03, 0.8
# a centre of pressure that stays this close to the plate's origin has moments of another unit (m)
STAYS_M = 0.003
# a fault is named if its removal reduces this distance by more than this factor
CLEARER = 0.5
# and a constant shift explains it as well only if it brings it closer by this (m)
CLEAR_M = 0.01
# relative error of the mass of a person who stands, and of one who moves
STANDS, MASS_STANDING, MASS_MOVING = 0.03, 0.05, 0.3
# medians of the load of two plates
GAIN_PART = 0.25
# largest plausible force (N), distance, least extent of all markers, and size of a plate (m)
LARGEST_N, LARGEST_M, LEAST_EXTENT_M, PLATE_M = 10_000.0, 20.0, 0.02, (0.05, 10.0)
# a smaller force (N) that exceeds its noise by this factor is probably in another unit
SMALL_N, TO_NOISE = 5.0, 30.0
# walking speed (m/s), shortest stance (s), and how clearly driving precedes braking
WALKS_M_PER_S, STANCE_S, AGAINST = 0.4, 0.3, -0.3
# least time for which a person is on a plate alone (s)
ALONE_S = 0.1
FEWEST_FRAMES, FEWEST_MARKERS = 10, 2
# samples beside those that software has set to 0, which are not examined
EDGE_SAMPLES = 20
FEWEST_SPIKES = 3
# RMS at high frequencies relative to the largest sample that no instrument undercuts, but rounding does
QUIETEST = 1e-7
HIGH_PART = (0.35, 0.45)
# longest stretch of one value under load, and at a peak, and shortest recording that is examined for them (s)
FROZEN_S, CLIPPED_S, LEAST_S = 0.1, 0.01, 0.5
# a path of the centre of pressure (m) shows the direction of walking, up to this cosine
PATH_M, ALONG = 0.05, 0.5
# seed of the white noise to which the spectra of the channels are compared
SEED = 20261129
SIDES = re.compile(r"(?:^|:)(L|R)(?=[A-Z_0-9])|(?:^|:)(Left|Right)", re.IGNORECASE)
HEEL, TOE = re.compile(r"HEE|CAL|FCC", re.IGNORECASE), re.compile(r"TOE|MT[P\d]|FM\d|HLX$", re.IGNORECASE)
ANKLE = re.compile(r"ANK|MAL|MMA|LMA|FAL|TAM|[DP][15]M$", re.IGNORECASE)


@dataclass(frozen=True)
class Finding:
    """One fault of a recording."""

    fault: str
    """Name in `FINDINGS`."""
    place: str
    """Plate, channel or file."""
    text: str
    """What was found, and what to do."""


@dataclass(frozen=True)
class _Feet:
    """Low markers at the frames, in the laboratory's axes."""

    positions: np.ndarray
    """Markers (m), shape (frames, markers, 3)."""
    rate_hz: float
    up: np.ndarray
    """Upward direction."""
    way: np.ndarray | None
    """Direction in which the person walks; None for one who stands."""


def examine_plates(path: Path, mass_kg: float | None = None) -> tuple[Finding, ...]:
    """Faults of the force plates of a recording, and of what they are compared with.

    path: C3D file.
    mass_kg: mass of the person on the plates, if known.
    Returns: findings in the order of the plates; empty if there are none.
    """
    file = open_c3d(path)
    try:
        channels_of(file, path)
    except InputError as error:
        return (Finding("rate", "file", _told(error, path)),)
    try:
        recording = read_recording(path)
    except InputError as error:
        return (Finding("unit" if "unit" in str(error) else "parameters", "file", _told(error, path)),)
    recording = _positions_only(recording, file)
    found, used = [], []
    for number, plate in enumerate(recording.plates, start=1):
        place = f"force plate {number}"
        if plate.fault is not None:
            name = "unit" if "found the unit" in plate.fault else "parameters"
            found.append(Finding(name, place, _told(plate.fault, path).removeprefix(f"{place}: ")))
        elif missing := _missing(plate, recording):
            text = f"samples that are no numbers, by channel: {missing}: export the file again"
            found.append(Finding("missing-samples", place, text))
        elif plate.force.any():
            used.append((place, plate))
    if not recording.plates:
        found.append(Finding("parameters", "file", "it describes no force plate: export FORCE_PLATFORM"))
    up = DIRECTIONS[recording.up]
    found += _lengths(recording)
    for place, plate in used:
        found += _samples(place, plate, recording)
    upright = []
    for place, plate in used:
        level, levelled = _level(place, plate, up)
        direction, turned = _upward(place, levelled, up)
        found += [*level, *direction]
        upright.append((place, turned))
    sized = [
        (place, plate)
        for place, plate in upright
        if not any(f.place == place and f.fault == "unit" for f in found)
    ]
    found += _places(sized, recording, up)
    found += _braking(sized, recording, up)
    found += _sides(recording, up)
    found += _weights(sized, up, mass_kg)
    return tuple(found)


def _missing(plate: ForcePlate, recording: Recording) -> str:
    """Channels of a plate with samples that are no numbers, with how many; empty without any."""
    counts = {x: int(np.count_nonzero(~np.isfinite(recording.channels[x].values))) for x in plate.channels}
    return ", ".join(f"{label} ({count})" for label, count in counts.items() if count)


def _told(error: InputError | str, path: Path) -> str:
    return str(error).removeprefix(f"{path}: ").removeprefix(f"{path}, ")


def _positions_only(recording: Recording, file: dict) -> Recording:
    """The recording without points that are angles, forces, moments or powers."""
    if recording.markers is None:
        return recording
    others = {
        str(label).strip()
        for name in NO_POSITIONS
        for label in np.ravel(file["parameters"]["POINT"].get(name, {}).get("value", []))
    }
    markers = recording.markers
    kept = [k for k, label in enumerate(markers.labels) if label not in others]
    labels = tuple(markers.labels[k] for k in kept)
    return replace(recording, markers=replace(markers, labels=labels, positions=markers.positions[:, kept]))


def _lengths(recording: Recording) -> Iterator[Finding]:
    """Positions in another unit of length."""
    if recording.markers is None or not np.isfinite(recording.markers.positions).any():
        return
    positions = recording.markers.positions
    seen = positions[np.isfinite(positions).all(axis=2)]
    largest, extent = float(np.abs(seen).max()), float(np.ptp(seen, axis=0).max())
    corners = [np.ptp(p.corners, axis=0).max() for p in recording.plates if p.corners is not None]
    size = float(np.median(corners)) if corners else 1.0
    plates = not corners or any(PLATE_M[0] < x < PLATE_M[1] for x in corners)
    if largest > LARGEST_M or extent < LEAST_EXTENT_M or not plates:
        yield Finding(
            "unit",
            "file",
            f"markers up to {largest:.3g} m from the origin, in a space of {extent:.2g} m, and plates of "
            f"{size:.2g} m: correct POINT:UNITS",
        )


# ---- samples of the channels ----------------------------------------------------------------------


def _samples(place: str, plate: ForcePlate, recording: Recording) -> Iterator[Finding]:
    """Spikes, held and clipped samples, and filters of the channels of a plate that was loaded."""
    if plate.force.shape[0] < LEAST_S * plate.rate_hz or np.linalg.norm(plate.force, axis=1).max() < LOADED_N:
        return
    named = {label: recording.channels[label] for label in plate.channels}
    stretches = _not_zeroed(np.column_stack([c.values for c in named.values()]))
    for name, (count, what, advice) in FAULTS.items():
        counts = {label: sum(count(c.values[a:b]) for a, b in stretches) for label, c in named.items()}
        faulty = {label: n for label, n in counts.items() if n}
        if name == "held-samples":
            faulty |= {label: 1 for label, c in named.items() if label not in faulty and _frozen(c, plate)}
        if name == "spikes" and sum(faulty.values()) < FEWEST_SPIKES:
            faulty = {}  # the blow of a heel
        if name == "clipped":
            # a peak of samples that were interpolated may be level, too, but not for long
            faulty = {label: n for label, n in faulty.items() if _level_s(named[label]) > CLIPPED_S}
            faulty |= {label: n for label, c in named.items() if (n := _at_limit(c.values, c.limits))}
        if faulty:
            text = ", ".join(f"{label} ({n})" for label, n in faulty.items())
            yield Finding(name, place, f"{what}, number by channel: {text}. {advice}")
    white = np.random.default_rng(SEED).standard_normal(plate.force.shape[0])
    moving = {label: c.values for label, c in named.items() if np.ptp(c.values) > 0.0}
    filtered = [
        label
        for label, values in moving.items()
        if noise_floors(_quiet(values, plate), plate.rate_hz, **{"signal": values, "white": white})
        or _high(values) < QUIETEST * np.abs(values).max()
    ]
    if filtered and len(filtered) >= 0.5 * len(moving):
        yield Finding(
            "filtered-signal",
            place,
            f"the noise of {', '.join(filtered)} vanishes at high frequencies: they were filtered. Export "
            "them without a filter, or filter the markers alike",
        )


def _level_s(channel: Channel) -> float:
    """Longest time for which a channel stays at its maximum or minimum (s)."""
    ends = (channel.values == end for end in (channel.values.max(), channel.values.min()))
    return max(stop - start for at in ends for start, stop in runs_of(at)) / channel.rate_hz


def _frozen(channel: Channel, plate: ForcePlate) -> bool:
    """Test for a channel that keeps one value while the plate is loaded."""
    force = np.linalg.norm(plate.force, axis=1)
    stretch = frozen_stretch(channel.values[:, None], channel.rate_hz, FROZEN_S, force < LOADED_N)
    return stretch is not None


def _high(values: np.ndarray) -> float:
    """RMS of a channel in a band of high frequencies (its unit)."""
    window = np.hanning(values.size)
    spectrum = np.fft.rfft((values - values.mean()) * window)
    part = np.fft.rfftfreq(values.size)
    inside = (part > HIGH_PART[0]) & (part < HIGH_PART[1])
    return float(np.sqrt(2.0 * np.sum(np.abs(spectrum[inside]) ** 2) / values.size / np.sum(window**2)))


def _not_zeroed(values: np.ndarray) -> list[tuple[int, int]]:
    """Stretches (samples) in which software has not set the whole plate to 0, as below a threshold."""
    zeroed = (values == 0.0).all(axis=1)
    if not zeroed.any():
        return [(0, len(values))]
    runs = [(start + EDGE_SAMPLES, stop - EDGE_SAMPLES) for start, stop in runs_of(~zeroed)]
    return [(start, stop) for start, stop in runs if stop - start > EDGE_SAMPLES]


def _at_limit(values: np.ndarray, limits: tuple[float, float] | None) -> int:
    """Times that a channel stays at an end of its converter's range for three samples or longer."""
    if limits is None:
        return 0
    step = 1e-6 * (limits[1] - limits[0])
    return sum(stop - start > 2 for end in limits for start, stop in runs_of(np.abs(values - end) < step))


def _quiet(values: np.ndarray, plate: ForcePlate) -> np.ndarray | None:
    """Samples without load, if there is more than a second of them in one piece; else None."""
    still = np.abs(plate.force).max(axis=1) < LOADED_PART * np.abs(plate.force).max()
    longest = max((stop - start for start, stop in runs_of(still)), default=0)
    return still if longest > plate.rate_hz else None


# ---- level and sign --------------------------------------------------------------------------------


def _level(place: str, plate: ForcePlate, up: np.ndarray) -> tuple[list[Finding], ForcePlate]:
    """Offset and drift of the forces without load, and the plate without both; drift of a person's weight."""
    loads = np.hstack([plate.force, plate.moment])
    vertical = plate.force @ up
    peak = float(np.abs(vertical).max())
    length = max(2, round(QUIET_S * plate.rate_hz))
    count = vertical.size // length
    if count < LEAST_WINDOWS or peak < LOADED_N:
        return [], plate
    windows = loads[: count * length].reshape(count, length, 6)
    means, spreads = windows.mean(axis=1), windows[..., :3].std(axis=1).max(axis=1)
    empty = (np.abs(means[:, :3] @ up) < QUIET_PART * peak) & (spreads < LOADED_PART * peak)
    if empty.sum() < LEAST_WINDOWS:
        change = _change(means[:, :3] @ up)
        if _stands(vertical) and abs(change) > max(DRIFT_N, DRIFT_PART * abs(vertical.mean())):
            text = (
                f"the vertical force under a person who stands changes by {change:.3g} N over the recording: "
                "let the amplifier warm up, and set it to zero before each trial"
            )
            return [Finding("drift", place, text)], plate
        return [], plate
    # windows in which nothing is set on the plate are the quietest
    quiet = np.flatnonzero(empty & (spreads <= 3.0 * np.median(spreads[empty]) + 1e-9))
    levels, found = means[quiet], []
    lines = [np.polyfit(quiet, x, 1) for x in levels.T]
    changes = np.array([slope * (quiet[-1] - quiet[0]) for slope, _ in lines])
    rest = levels - np.column_stack([np.polyval(line, quiet) for line in lines])
    axis = int(np.argmax(np.abs(changes[:3])))
    drifts = abs(changes[axis]) > max(DRIFT_N, 3.0 * rest[:, axis].std()) and quiet.size >= 2 * LEAST_WINDOWS
    middle = np.median(levels, axis=0)
    zero = np.tile(middle, (loads.shape[0], 1))
    if drifts:
        at = np.arange(loads.shape[0]) / length - 0.5
        zero = np.column_stack([np.polyval(line, at) for line in lines])
        found.append(
            Finding(
                "drift",
                place,
                f"F{'xyz'[axis]} without load changes by {changes[axis]:.3g} N over the recording: let the "
                "amplifier warm up, set it to zero before each trial, or subtract a line through the "
                "unloaded times",
            )
        )
    axis = int(np.argmax(np.abs(middle[:3])))
    if abs(middle[axis]) > OFFSET_N and not (drifts and abs(middle[axis]) < 1.5 * abs(changes[axis])):
        text = ", ".join(f"F{name} {x:.3g} N" for name, x in zip("xyz", middle, strict=False))
        found.append(
            Finding(
                "offset",
                place,
                f"without load it measures {text}: subtract the mean of the unloaded times "
                "(FORCE_PLATFORM:ZERO), and set the amplifier to zero before each trial",
            )
        )
    zeroed = (loads == 0.0).all(axis=1)
    if zeroed.mean() > 1.0 - SHARE:  # software has set the zero
        zero = np.zeros_like(loads)
    corrected = loads - zero
    return found, replace(plate, force=corrected[:, :3], moment=corrected[:, 3:])


def _stands(vertical: np.ndarray) -> bool:
    """Test for a load that stays on the plate throughout."""
    return bool(np.abs(vertical).min() > 0.5 * np.abs(vertical).max())


def _change(levels: np.ndarray) -> float:
    """Change of a line through levels from the first to the last."""
    k = np.arange(levels.size)
    return float(np.polyfit(k, levels, 1)[0] * (levels.size - 1))


def _upward(place: str, plate: ForcePlate, up: np.ndarray) -> tuple[list[Finding], ForcePlate]:
    """Faults of direction and size of the vertical force, and the plate with the force upward (N)."""
    found, vertical = [], plate.force @ up
    if plate.normal is not None and abs(plate.normal @ up) < LEVEL:
        found.append(
            Finding("axes", place, "its corners describe no level surface: correct FORCE_PLATFORM:CORNERS")
        )
    peak = float(np.abs(vertical).max())
    noise = float(np.median(np.abs(np.diff(vertical)))) + 1e-12
    if peak > LARGEST_N or (peak < SMALL_N and peak > TO_NOISE * noise):
        found.append(
            Finding(
                "unit",
                place,
                f"the vertical force reaches {peak:.3g} N: correct ANALOG:UNITS or SCALE of its channels",
            )
        )
    loaded = np.abs(vertical) > max(LOADED_N, 0.5 * peak)
    if loaded.any() and np.median(vertical[loaded]) < LEAST_N:
        found.append(
            Finding(
                "sign",
                place,
                f"the vertical force is {np.median(vertical[loaded]):.3g} N under load, so it points down: "
                "reverse the sign of its channels if they hold the force on the plate, or correct the order "
                "of its corners",
            )
        )
        plate = replace(plate, force=-plate.force, moment=-plate.moment)
    return found, plate


# ---- centre of pressure against the feet -------------------------------------------------------------


def _in_plate(plate: ForcePlate) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Axes as columns, centre (m), F (N), M about the own origin (N·m) and o (m) in the plate's axes."""
    axes = plate_axes(plate.corners, "force plate")
    centre = plate.corners.mean(axis=0)
    origin = np.zeros(3) if plate.origin is None else plate.origin
    moment = plate.moment - np.cross(centre - origin, plate.force)
    return axes, centre, plate.force @ axes, moment @ axes, origin @ axes


def _pressure(force: np.ndarray, moment: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Centre of pressure from the centre of the surface (m), shape (n, 2), in the plate's axes."""
    return centre_of_pressure(force, moment - np.cross(origin, force), np.array([0.0, 0.0, 1.0]))[:, :2]


def _alternatives(force, moment, origin, others) -> Iterator[tuple[str, str, tuple]]:
    """Fault, its description with what to do, and the load without it."""
    loaded = np.abs(force[:, 2]) > 0.5 * np.abs(force[:, 2]).max()
    if np.median(np.abs(moment[loaded, :2]).max(axis=1) / np.abs(force[loaded, 2])) > LARGEST_M:
        text = "its moments are 1000 times smaller: correct ANALOG:UNITS (Nm, Nmm) of its moments"
        yield "unit", text, (force, 1e-3 * moment, origin)
    for signs, name in (((-1, -1, -1), "Mx, My and Mz"), ((-1, 1, 1), "Mx"), ((1, -1, 1), "My")):
        text = f"{name} are reversed: reverse the sign of these channels, in ANALOG:SCALE"
        yield "sign", text, (force, moment * signs, origin)
    for name, rows, signs in (
        ("x and y are exchanged", [1, 0, 2], (1, 1, 1)),
        ("x and y are exchanged and reversed", [1, 0, 2], (-1, -1, 1)),
        ("it is turned by a quarter", [1, 0, 2], (1, -1, 1)),
        ("it is turned by a quarter", [1, 0, 2], (-1, 1, 1)),
        ("it is turned by half", [0, 1, 2], (-1, -1, 1)),
    ):
        text = f"{name}: correct the order of FORCE_PLATFORM:CHANNEL or CORNERS"
        yield "axes", text, (force[:, rows] * signs, moment[:, rows] * signs, origin)
    for place, other_force, other_moment, other_origin in others:
        text = f"its channels are those of {place}: exchange both in FORCE_PLATFORM:CHANNEL"
        yield "plates-exchanged", text, (other_force, other_moment, other_origin)
    if np.abs(origin).max() > BEYOND_M:
        text = "its ORIGIN points from the surface to the origin: reverse FORCE_PLATFORM:ORIGIN"
        yield "origin", text, (force, moment, -origin)


def _places(plates: list[tuple[str, ForcePlate]], recording: Recording, up: np.ndarray) -> Iterator[Finding]:
    """Centres of pressure that are not under the feet, with the fault that explains it."""
    loads = {}
    feet = _feet(recording, up)
    for place, plate in plates:
        if plate.corners is None:
            continue
        per_frame = 1 if feet is None else max(1, round(plate.rate_hz / feet.rate_hz))
        at = slice(0, None if feet is None else per_frame * feet.positions.shape[0], per_frame)
        axes, centre, force, moment, origin = _in_plate(plate)
        loads[place] = (plate, axes, centre, force[at], moment[at], origin)
    for place, (plate, axes, centre, force, moment, origin) in loads.items():
        half = 0.5 * np.ptp((plate.corners - centre) @ axes, axis=0)[:2]
        beyond = _beyond_feet(feet, axes, centre, half)
        before = beyond(force, moment, origin)
        if before is None:
            continue
        if beyond.stays(force, moment):
            yield Finding(
                "unit",
                place,
                f"its centre of pressure stays within {1e3 * STAYS_M:g} mm of the axis of its origin: its "
                "moments are about 1000 times too small, correct ANALOG:UNITS (Nm, Nmm) or SCALE",
            )
            continue
        if before <= BEYOND_M:
            continue
        others = [(p, *v[3:6]) for p, v in loads.items() if p != place and v[3].shape == force.shape]
        tried = []
        for name, text, load in _alternatives(force, moment, origin, others):
            after = beyond(*load)
            if after is not None:
                tried.append((after, name, text))
        best = min(
            (entry for entry in tried if entry[0] <= BEYOND_M), default=None, key=lambda entry: entry[0]
        )
        where = (
            f"its centre of pressure lies {1e3 * before:.0f} mm outside the markers of the foot, or the plate"
        )
        shift, rest = beyond.shift(force, moment, origin)
        if best is not None and best[0] < CLEARER * before and best[0] < rest + CLEAR_M:
            yield Finding(best[1], place, f"{where}; it lies within if {best[2]}")
            continue
        if rest <= BEYOND_M:
            x, y = 1e3 * shift
            yield Finding(
                "origin",
                place,
                f"{where}, shifted by {x:.0f} mm along its x and {y:.0f} mm along its y axis: measure the "
                "corners again, and correct FORCE_PLATFORM:ORIGIN or CORNERS",
            )
        elif not beyond.bare(force):
            yield Finding(
                "pressure",
                place,
                f"{where}, and no single change explains it: check corners, channels and calibration",
            )


def _feet(recording: Recording, up: np.ndarray) -> _Feet | None:
    markers = recording.markers
    if markers is None or not markers.labels or not np.isfinite(markers.positions).any():
        return None
    # files also hold joint centres and axes of segments, which lie beside the foot
    foot = [k for k, label in enumerate(markers.labels) if any(x.search(label) for x in (HEEL, TOE, ANKLE))]
    known = foot if len(foot) >= FEWEST_MARKERS else list(range(len(markers.labels)))
    return _Feet(markers.positions[:, known], markers.rate_hz, up, _way(recording, up))


def _beyond_feet(feet: _Feet | None, axes: np.ndarray, centre: np.ndarray, half: np.ndarray) -> "_Beyond":
    """Distance of centres of pressure from the feet (m), in the axes of a plate."""
    if feet is None:
        return _Beyond(np.zeros((0, 0, 2)), np.zeros((0, 0), dtype=bool), half, None)
    local = (feet.positions - centre) @ axes
    height = (feet.positions - centre) @ feet.up
    speed = feet.rate_hz * np.linalg.norm(np.gradient(local[..., :2], axis=0), axis=-1)
    with np.errstate(invalid="ignore"):  # a foot that swings past the plate is low, too
        low = (np.abs(height) < LOW_M) & (speed < STILL_M_PER_S)
    way = None if feet.way is None else (feet.way @ axes)[:2]
    return _Beyond(local[..., :2], low, half, way)


@dataclass(frozen=True)
class _Beyond:
    """Distance of a centre of pressure from the markers of the foot on the plate."""

    markers: np.ndarray
    """In the plate's axes (m), shape (frames, markers, 2)."""
    low: np.ndarray
    """True for a marker near the plate that hardly moves, shape (frames, markers)."""
    half: np.ndarray
    """Half the length of the plate along its axes (m)."""
    way: np.ndarray | None
    """Direction of walking in the plate's axes, shape (2,)."""

    def _loaded(self, force: np.ndarray) -> np.ndarray:
        vertical = np.abs(force[:, 2])
        return vertical > max(LOADED_N, LOADED_PART * vertical.max(initial=0.0))

    def _boxes(self, frames: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Lowest and highest coordinate of the foot's markers on the plate, and where there are some."""
        near = (np.abs(self.markers[frames]) < self.half + NEAR_M).all(axis=-1) & self.low[frames]
        points = np.where(near[..., None], self.markers[frames], np.nan)
        known = near.sum(axis=1) >= 2
        low, high = np.full((frames.size, 2), np.nan), np.full((frames.size, 2), np.nan)
        low[known], high[known] = np.nanmin(points[known], axis=1), np.nanmax(points[known], axis=1)
        return low, high, known

    def bare(self, force: np.ndarray) -> bool:
        """Test for a plate that is loaded by something without markers."""
        frames = np.flatnonzero(self._loaded(force))
        if not self.low.size:
            return False
        return self._boxes(frames[frames < len(self.low)])[2].mean() < 1.0 - SHARE

    def _distances(self, force, moment, origin) -> np.ndarray:
        """Vector by which each loaded centre of pressure lies outside, shape (n, 2)."""
        frames = np.flatnonzero(self._loaded(force))
        if self.low.size:
            frames = frames[frames < len(self.low)]
        places = _pressure(force[frames], moment[frames], origin)
        if self.low.any():
            low, high, known = self._boxes(frames)
            outside = np.maximum(places - high, 0.0) - np.maximum(low - places, 0.0)
            # a loaded plate without a foot above it
            outside[~known] = NEAR_M * np.sqrt(0.5)
            return outside
        return np.sign(places) * np.maximum(np.abs(places) - self.half - BESIDE_M + BEYOND_M, 0.0)

    def stays(self, force: np.ndarray, moment: np.ndarray) -> bool:
        """Test for moments about the own origin that are 0 but for noise, wherever the foot is."""
        frames = np.flatnonzero(self._loaded(force))
        return bool(frames.size) and float(np.abs(moment[frames, :2] / force[frames, 2:]).max()) < STAYS_M

    def against(self, force, moment, origin) -> float:
        """Length of the path of the centre of pressure (m) if it does not follow the person; else 0."""
        if self.way is None:
            return 0.0
        paths = []
        for start, stop in runs_of(self._loaded(force)):
            if stop - start >= FEWEST_FRAMES:
                places = _pressure(force[start:stop], moment[start:stop], origin)
                fifth = max(1, (stop - start) // 5)
                paths.append(np.median(places[-fifth:], axis=0) - np.median(places[:fifth], axis=0))
        if not paths:
            return 0.0
        path = np.mean(paths, axis=0)
        length = float(np.linalg.norm(path))
        return length if length > PATH_M and path @ self.way < ALONG * length else 0.0

    def __call__(self, force, moment, origin) -> float | None:
        """Distance within which most centres of pressure lie outside the foot (m), or length of a path that
        does not follow the person who walks; None without load.
        """
        outside = self._distances(force, moment, origin)
        if len(outside) < FEWEST_FRAMES:
            return None
        return max(float(np.quantile(np.hypot(*outside.T), SHARE)), self.against(force, moment, origin))

    def shift(self, force, moment, origin) -> tuple[np.ndarray, float]:
        """Constant shift (m) of the centres of pressure from the feet, and distance that remains then."""
        frames = np.flatnonzero(self._loaded(force))
        if not self.low.any():
            return np.zeros(2), np.inf
        frames = frames[frames < len(self.low)]
        low, high, known = self._boxes(frames)
        if known.mean() < SHARE or self.against(force, moment, origin):
            return np.zeros(2), np.inf
        places = _pressure(force[frames], moment[frames], origin)
        shift = np.median((places - 0.5 * (low + high))[known], axis=0)
        outside = np.maximum(places - shift - high, 0.0) - np.maximum(low - places + shift, 0.0)
        return shift, float(np.quantile(np.hypot(*outside[known].T), SHARE))


# ---- walking, sides, weight ---------------------------------------------------------------------------


def _way(recording: Recording, up: np.ndarray) -> np.ndarray | None:
    """Horizontal direction in which the markers travel, if they are as fast as a person who walks."""
    if recording.markers is None:
        return None
    positions = recording.markers.positions
    known = np.isfinite(positions).all(axis=2)
    seen = np.flatnonzero(known.any(axis=1))
    if seen.size < FEWEST_FRAMES:
        return None
    sums = np.where(known[..., None], positions, 0.0).sum(axis=1)
    middle = sums / np.maximum(known.sum(axis=1), 1)[:, None]
    way = middle[seen[-1]] - middle[seen[0]]
    way = way - up * (way @ up)
    lasts_s = (seen[-1] - seen[0]) / recording.markers.rate_hz
    length = float(np.linalg.norm(way))
    return way / length if length > WALKS_M_PER_S * lasts_s else None


def _braking(plates: list[tuple[str, ForcePlate]], recording: Recording, up: np.ndarray) -> Iterator[Finding]:
    """Fore-aft forces that drive a walking person first and then brake."""
    forward = _way(recording, up)
    if forward is None:
        return
    for place, plate in plates:
        vertical, along = plate.force @ up, plate.force @ forward
        late, size = 0.0, 0.0
        for start, stop in runs_of(vertical > max(LOADED_N, LOADED_PART * vertical.max())):
            if start > 0 and stop < vertical.size and stop - start > STANCE_S * plate.rate_hz:
                lever = np.arange(stop - start) - 0.5 * (stop - start)
                late += float(along[start:stop] @ lever)
                size += float(np.abs(along[start:stop]) @ np.abs(lever))
        if size > 0.0 and late < AGAINST * size:
            yield Finding(
                "sign",
                place,
                "its horizontal force drives the walking person first and brakes later: reverse the sign of "
                "its horizontal channels, or correct FORCE_PLATFORM:CORNERS",
            )


def _sides(recording: Recording, up: np.ndarray) -> Iterator[Finding]:
    """Labels of left and right markers that are exchanged, by the direction from heels to toes."""
    if recording.markers is None:
        return
    labels, positions = recording.markers.labels, recording.markers.positions
    with np.errstate(invalid="ignore"):
        sides = {"l": [], "r": []}
        for k, label in enumerate(labels):
            if match := SIDES.search(label):
                sides[(match[1] or match[2])[0].lower()].append(k)
        heels = [k for k, label in enumerate(labels) if HEEL.search(label)]
        toes = [k for k, label in enumerate(labels) if TOE.search(label)]
        pairs = [
            (left, right)
            for left in sides["l"]
            for right in sides["r"]
            if SIDES.sub("", labels[left]) == SIDES.sub("", labels[right])
        ]
        if not pairs or not heels or not toes:
            return
        frames = np.isfinite(positions[:, [*heels, *toes]]).all(axis=(1, 2))
        if frames.sum() < FEWEST_FRAMES:
            return
        facing = positions[frames][:, toes].mean(axis=1) - positions[frames][:, heels].mean(axis=1)
        apart = np.stack(
            [positions[frames, left] - positions[frames, right] for left, right in pairs], axis=1
        )
        side = np.einsum("fpk,fk->fp", apart, np.cross(up, facing))
    side = side[np.isfinite(side)]
    if side.size and np.mean(side < 0.0) > SHARE:
        yield Finding(
            "sides-exchanged",
            "markers",
            f"the left markers lie to the right of the right ones in {100.0 * np.mean(side < 0.0):.0f} % of "
            "the samples, seen from the heels to the toes: exchange their labels",
        )


def _weights(
    plates: list[tuple[str, ForcePlate]], up: np.ndarray, mass_kg: float | None
) -> Iterator[Finding]:
    """Weight of the person against a stated mass, and of single plates against each other."""
    vertical = [np.maximum(plate.force @ up, 0.0) for _, plate in plates]
    loads = {}
    for k, ((place, plate), own) in enumerate(zip(plates, vertical, strict=True)):
        others = sum((x for j, x in enumerate(vertical) if j != k and x.size == own.size), np.zeros(own.size))
        alone = (own > max(LOADED_N, 0.5 * np.quantile(own, 0.99))) & (others < LOADED_N)
        if alone.sum() > ALONE_S * plate.rate_hz:
            loads[place] = float(np.median(own[alone]))
    if loads and min(loads.values()) < (1.0 - GAIN_PART) * max(loads.values()):
        each = ", ".join(f"{load:.0f} N ({place})" for place, load in loads.items())
        yield Finding(
            "gain",
            "all plates",
            f"they carry {each} while the person is on each of them alone: check the gain of their "
            "amplifiers, and ANALOG:SCALE",
        )
    if mass_kg is None or not vertical or len({x.size for x in vertical}) > 1:
        return
    total = np.sum(vertical, axis=0)
    on = total > max(LOADED_N, 0.5 * np.quantile(total, 0.99))
    stands = on.mean() > SHARE and np.std(total[on]) < STANDS * total[on].mean()
    mass = float(total[on].mean() if stands else np.median(total[on])) / GRAVITY_M_PER_S2 if on.any() else 0.0
    if abs(mass / mass_kg - 1.0) > (MASS_STANDING if stands else MASS_MOVING):
        yield Finding(
            "weight",
            "all plates",
            f"they carry {mass:.1f} kg, and {mass_kg:g} kg are stated: check the mass, the gain and the "
            "units of the plates, and that the person stands on plates only",
        )
