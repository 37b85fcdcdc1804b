"""C3D files: a whole trial with markers, force plates and analog channels, or its markers alone."""

from pathlib import Path

import numpy as np

from tepsipe.errors import InputError, quoted
from tepsipe.io.file_format import Channel as ListedChannel
from tepsipe.io.file_format import Contents, Format
from tepsipe.io.readers.force_plates import force_plates
from tepsipe.io.readers.guarded import guarded
from tepsipe.io.readers.plain_file import plain_file
from tepsipe.io.readers.recording import DIRECTIONS, METRES_PER_UNIT, Channel, ForcePlate, Markers, Recording

# processor type -> byte order of its words, and the byte of the scale factor that holds the sign
WORDS = {84: ("<u2", 15), 85: ("<u2", 13), 86: (">u2", 12)}
LEVEL = 0.9  # least vertical component of the normal of a level plate
LOADED_N = 20.0  # vertical force from which a plate is loaded
# lists of points that are no markers, and the parameters with their units
NO_POSITIONS = {
    "ANGLES": "ANGLE_UNITS",
    "FORCES": "FORCE_UNITS",
    "MOMENTS": "MOMENT_UNITS",
    "POWERS": "POWER_UNITS",
    "SCALARS": "SCALAR_UNITS",
}


def read_c3d_markers(path: str | Path) -> Markers:
    """Read all markers of a C3D file.

    path: C3D file.
    Returns: rate, labels and positions, NaN while a marker was hidden.
    """
    path = Path(path)
    return c3d_markers(open_c3d(path), path)


def c3d_markers(file, path: Path) -> Markers:
    """All markers of an opened C3D file (m), NaN where one was hidden."""
    labels = group_labels(file, "POINT")
    scale = metres_per_unit(file, path)
    points, residuals = file["data"]["points"][:3], file["data"]["meta_points"]["residuals"][0]
    labels += [f"unnamed {k + 1}" for k in range(len(labels), points.shape[1])]
    positions = scale * points.transpose(2, 1, 0)
    positions[residuals.T < 0.0] = np.nan
    return Markers(frame_rate(file, path), tuple(labels[: points.shape[1]]), positions)


def frame_rate(file, path: Path) -> float:
    """Frames per second of an opened C3D file (Hz)."""
    rate = float(file["parameters"]["POINT"]["RATE"]["value"][0])
    if not 0.0 < rate < np.inf:
        raise InputError(
            f"{path}: expected a positive number of frames per second in POINT:RATE, found {rate:g}: it is "
            "damaged, export it again"
        )
    return rate


def metres_per_unit(file, path: Path) -> float:
    """Factor from the positions of an opened C3D file to metres (m per unit)."""
    point = file["parameters"]["POINT"]
    unit = str(point["UNITS"]["value"][0]).strip() if point["UNITS"]["value"] else ""
    if unit not in METRES_PER_UNIT:
        raise InputError(
            f"{path}: expected marker positions in mm, cm or m, found the unit {quoted(unit)}: set "
            "POINT:UNITS when exporting"
        )
    return METRES_PER_UNIT[unit]


def group_labels(file, group: str) -> list[str]:
    """Labels of POINT or ANALOG, also beyond the 255 that one parameter can hold."""
    parameters = file["parameters"].get(group, {})
    names = ["LABELS", *(f"LABELS{k}" for k in range(2, 100))]
    groups = [parameters[name]["value"] for name in names if name in parameters]
    return [str(label).strip() for labels in groups for label in labels]


def open_c3d(path: Path):
    """Parameters and data of a C3D file, and numbers of its header, as ezc3d reads it (units of the file)."""
    import ezc3d

    def parsed(plain: Path) -> dict:
        file = ezc3d.c3d(str(plain))
        first = int(file["header"]["points"]["first_frame"])
        return {"parameters": dict(file["parameters"]), "data": dict(file["data"]), "first_frame": first}

    if not path.is_file():
        raise InputError(f"{path}: expected a C3D file, found no file: correct its path in the trial sheet")
    with plain_file(path, "a C3D file") as plain:
        content = plain.read_bytes()
        _refuse_truncated(path, content)
        word = WORDS[content[512 * (content[0] - 1) + 3]][0]
        in_frame = int(np.frombuffer(content[4:6], word)[0])
        try:
            return guarded(parsed, plain, what=path) | {"header_analog_samples": in_frame}
        except InputError:
            raise
        except Exception as error:  # ezc3d raises many kinds on damaged files
            raise InputError(
                f"{path}: expected a C3D file, found one that cannot be read ({type(error).__name__}): "
                "it is damaged, export it again"
            ) from error


def _refuse_truncated(path: Path, content: bytes) -> None:
    """Compare the size of the file with the size given by its header block."""
    if len(content) < 1024 or content[1] != 0x50:
        raise InputError(
            f"{path}: expected a C3D file, found {len(content)} bytes without its header: check which "
            "file the trial sheet names"
        )
    parameters = 512 * (content[0] - 1)
    if len(content) < parameters + 512:
        raise InputError(
            f"{path}: expected parameters from byte {parameters} on, found {len(content)} bytes: the file is "
            "truncated, copy it again from the instrument"
        )
    processor = content[parameters + 3]
    if processor not in WORDS:
        raise InputError(
            f"{path}: expected a C3D file of an Intel, DEC or MIPS processor (84 to 86), found "
            f"{processor}: it is damaged, export it again"
        )
    word, sign_byte = WORDS[processor]
    _, points, analog, first, last = np.frombuffer(content[:10], dtype=word).tolist()
    data_block = int(np.frombuffer(content[16:18], dtype=word)[0])
    if last == 65535:
        return  # more frames than the header block can hold: their number is a parameter
    bytes_per_value = 4 if content[sign_byte] & 0x80 else 2  # a negative scale means floating point
    frames = last - first + 1
    expected = 512 * (data_block - 1) + frames * bytes_per_value * (4 * points + analog)
    if len(content) < expected:
        raise InputError(
            f"{path}: expected {frames} frames ({expected} bytes), found {len(content)} bytes: the "
            "file is truncated, copy it again from the instrument"
        )


def read_c3d_recording(path: str | Path) -> Recording:
    """Read all signals of a trial from a C3D file.

    The first sample of every channel is taken at the instant of the first frame.

    path: C3D file.
    Returns: markers, force plates and analog channels in their units.
    """
    path = Path(path)
    return _recording(open_c3d(path), path)


def _recording(file, path: Path) -> Recording:
    """All signals of an opened C3D file (units of the channels)."""
    markers = c3d_markers(file, path)
    channels = channels_of(file, path)
    labels = [label for label, _ in channels]
    scale = metres_per_unit(file, path)
    plates = force_plates(file, [c for _, c in channels], labels, path, scale, markers.rate_hz)
    return Recording(
        name=str(path),
        markers=markers if markers.labels else None,
        plates=plates,
        channels=dict(channels),
        up=_up(file, markers.positions, plates),
    )


def _up(file, positions: np.ndarray, plates: tuple[ForcePlate, ...]) -> str:
    """Upward direction: normal of level plates, else the vertical of the screen (POINT:Y_SCREEN), else z.

    Markers are above the plates, or above the floor of the laboratory. Without them the order of the plates'
    corners decides which side is up.
    """
    level = [plate for plate in plates if plate.normal is not None and np.abs(plate.normal).max() > LEVEL]
    axes = {int(np.argmax(np.abs(plate.normal))) for plate in level}
    screen = file["parameters"]["POINT"].get("Y_SCREEN", {}).get("value", [])
    named = "".join(map(str, screen[:1])).strip().lower()
    named = named if named in DIRECTIONS else "+z"
    axis = axes.pop() if len(axes) == 1 else "xyz".index(named[1])
    heights = positions[..., axis][np.isfinite(positions[..., axis])]
    if heights.size:
        surface = np.mean([plate.corners[:, axis] for plate in level]) if level else 0.0
        downward = np.median(heights) < surface
    else:
        downward = sum(plate.normal[axis] for plate in level) < 0.0
    return f"{'-' if downward else '+'}{'xyz'[axis]}"


def channels_of(file, path: Path) -> list[tuple[str, Channel]]:
    """Label and channel in the order of the file; the number is added where a label is empty or repeated."""
    analog, samples = file["parameters"].get("ANALOG", {}), file["data"]["analogs"][0]
    if not samples.size:
        return []
    frames_hz = frame_rate(file, path)
    per_frame = samples.shape[1] // file["data"]["points"].shape[2]
    rate, named = per_frame * frames_hz, [float(r) for r in analog["RATE"]["value"][:1]]
    if not rate > 0.0 or (named and abs(named[0] - rate) > 1e-3 * rate):
        raise InputError(
            f"{path}: expected analog channels at {per_frame} times the {frames_hz:g} Hz of the frames, "
            f"found {named[0] if named else rate:g} Hz in ANALOG:RATE: export the file again"
        )
    header = file["header_analog_samples"]
    if header and header != per_frame * samples.shape[0]:  # the samples have been read in another order
        raise InputError(
            f"{path}: expected {header / samples.shape[0]:g} analog samples in a frame, as its header "
            f"states, found "
            f"{per_frame} by ANALOG:RATE and POINT:RATE: one of both rates is wrong, export the file again"
        )
    labels, units = group_labels(file, "ANALOG"), _units(analog)
    limits = _limits(analog, file, samples.shape[0])
    channels: list[tuple[str, Channel]] = []
    for k, values in enumerate(np.where(np.isfinite(samples), samples, np.nan)):
        label = labels[k] if k < len(labels) and labels[k] else f"channel {k + 1}"
        if label in labels[:k]:
            label = f"{label} (channel {k + 1})"
        channels.append((label, Channel(values, units[k] if k < len(units) else "", rate, limits[k])))
    return channels


def _units(analog: dict) -> list[str]:
    names = ["UNITS", *(f"UNITS{k}" for k in range(2, 100))]
    return [str(u).strip() for name in names if name in analog for u in analog[name]["value"]]


def _limits(analog: dict, file, count: int) -> list[tuple[float, float] | None]:
    """Lowest and highest value of each channel's converter (unit of the channel); None for floating point."""
    scales = np.asarray(analog["SCALE"]["value"], dtype=float).ravel() if "SCALE" in analog else np.empty(0)
    if float(file["parameters"]["POINT"]["SCALE"]["value"][0]) < 0.0 or scales.size < count:
        return [None] * count
    bits = int(analog["BITS"]["value"][0]) if "BITS" in analog and len(analog["BITS"]["value"]) else 16
    unsigned = [str(f).strip().upper() for f in analog.get("FORMAT", {}).get("value", [])] == ["UNSIGNED"]
    low, high = (0, 2**bits - 1) if unsigned else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    offsets = np.zeros(count)
    if "OFFSET" in analog and len(analog["OFFSET"]["value"]) >= count:
        offsets = np.asarray(analog["OFFSET"]["value"], dtype=float).ravel()
    general = float(analog["GEN_SCALE"]["value"][0]) if "GEN_SCALE" in analog else 1.0
    ends = [
        sorted(general * s * (end - o) for end in (low, high)) for s, o in zip(scales, offsets, strict=False)
    ]
    return [(first, last) for first, last in ends[:count]]


def c3d_contents(path: Path) -> Contents:
    """Contents of a C3D file (units as in the file)."""
    file = open_c3d(path)
    parameters, data = file["parameters"], file["data"]

    def values(group: str, name: str) -> list:
        return list(np.ravel(parameters.get(group, {}).get(name, {}).get("value", [])))

    point_unit = "".join(map(str, values("POINT", "UNITS")[:1])).strip()
    point_rate, analog_rate = (float((values(g, "RATE") or [0.0])[0]) or None for g in ("POINT", "ANALOG"))
    points = data["points"][:3].transpose(2, 1, 0).copy()
    points[data["meta_points"]["residuals"][0].T < 0.0] = np.nan
    labels = group_labels(file, "POINT")[: points.shape[1]]
    others = {
        str(label).strip(): "".join(map(str, values("POINT", unit)[:1])).strip()
        for name, unit in NO_POSITIONS.items()
        for label in values("POINT", name)
    }
    channels = [
        ListedChannel.of(label, others.get(label, point_unit), point_rate, points[:, k])
        for k, label in enumerate(labels)
    ]
    analogs, units = data["analogs"][0], values("ANALOG", "UNITS")
    for k, label in enumerate(group_labels(file, "ANALOG")[: analogs.shape[0]]):
        unit = str(units[k]).strip() if k < len(units) else ""
        channels.append(ListedChannel.of(label, unit, analog_rate, analogs[k]))
    facts = {"frames": str(points.shape[0])}
    maker = " ".join(str(v).strip() for name in ("COMPANY", "SOFTWARE") for v in values("MANUFACTURER", name))
    facts |= {"made by": maker} if maker.strip() else {}
    if point_rate:
        facts["duration"] = f"{points.shape[0] / point_rate:.6g} s"
    plates, up, refused = _vertical_forces(file, path)
    facts["upward"] = up
    facts |= _plate_facts([int(kind) for kind in values("FORCE_PLATFORM", "TYPE")], values, plates)
    usable = tuple(plate for plate in plates if isinstance(plate, ListedChannel))
    facts |= {"not usable as a whole trial": refused} if refused else {}
    first = file["first_frame"] / point_rate if point_rate else 0.0
    events = _events(parameters, values, first)
    facts |= {"events": _event_text(events)} if events else {}
    markers = tuple(label for label in labels if label not in others)
    return Contents("C3D", facts, channels, markers, usable, events, vertical="xyz".index(up[1]))


def _vertical_forces(file, path: Path) -> tuple[tuple[ListedChannel | str, ...], str, str]:
    """Vertical force on each plate (N) or why it cannot be used, upward direction, why the file cannot be."""
    try:
        recording = _recording(file, path)
    except InputError as error:
        return (), "+z", str(error).removeprefix(f"{path}: ").removeprefix(f"{path}, ")
    plates = tuple(
        ListedChannel.of(f"force plate {number}", "N", plate.rate_hz, plate.force @ DIRECTIONS[recording.up])
        if plate.fault is None
        else plate.fault.removeprefix(f"{path}, force plate {number}: ")
        for number, plate in enumerate(recording.plates, start=1)
    )
    return plates, recording.up, ""


def _plate_facts(types: list[int], values, plates: tuple[ListedChannel | str, ...]) -> dict[str, str]:
    """Type and load of each plate as text (N, %)."""
    used = int((values("FORCE_PLATFORM", "USED") or [0])[0])
    facts = {"force plates": str(used)} if used else {}
    for number, kind in enumerate(types[:used], start=1):
        text, plate = f"type {kind}", plates[number - 1] if number <= len(plates) else None
        if isinstance(plate, str):
            text += f", cannot be used: {plate}"
        elif plate is not None:
            force = np.abs(plate.values)
            loaded = force[force > LOADED_N]
            text += f", mean vertical force {plate.values.mean():.1f} N"
            if loaded.size:
                share = 100.0 * loaded.size / force.size
                text += f", loaded {share:.0f} % of the time with {loaded.mean():.0f} N"
            else:
                text += f", never above {LOADED_N:g} N: not loaded"
        facts[f"force plate {number}"] = text
    return facts


def _events(parameters, values, first_s: float) -> tuple[tuple[str, float], ...]:
    """Events in the order of time: label with its side, and time after the first frame (s)."""
    times = np.asarray(parameters.get("EVENT", {}).get("TIMES", {}).get("value", []), dtype=float)
    if times.ndim != 2 or times.shape[0] != 2:
        return ()
    seconds = 60.0 * times[0] + times[1] - first_s
    labels, sides = values("EVENT", "LABELS"), values("EVENT", "CONTEXTS")
    names = [
        " ".join(str(names[k]).strip() for names in (sides, labels) if k < len(names)) or "event"
        for k in range(seconds.size)
    ]
    return tuple(sorted(zip(names, seconds.tolist(), strict=True), key=lambda event: event[1]))


def _event_text(events: tuple[tuple[str, float], ...]) -> str:
    most = 12
    text = ", ".join(f"{label} {time:.3f} s" for label, time in events[:most])
    return text + (f" and {len(events) - most} more" if len(events) > most else "")


def _purpose(contents: Contents) -> tuple[str, str]:
    if contents.plates:
        return "whole trial", ""
    refused = contents.facts.get("not usable as a whole trial")
    if contents.markers and not refused:
        return "markers", ""
    return "other", refused or "it holds neither markers nor force plates"


FORMAT = Format(
    name="C3D",
    fits=lambda head: len(head.content) >= 512 and head.content[1] == 0x50 and head.content[0] < 0x20,
    contents=c3d_contents,
    endings=(".c3d",),
    purpose=_purpose,
    lists_events=True,
    page="c3d.md",
    read_recording=read_c3d_recording,
    read_markers=read_c3d_markers,
)
