"""Contents of a C3D file: markers, analog channels, force plates and events."""

from pathlib import Path

import numpy as np

from tepsipe.errors import InputError
from tepsipe.io.described import Channel, Contents

LOADED_N = 20.0  # vertical force from which a plate is loaded
# lists of points that are no markers, and the parameters with their units
NO_POSITIONS = {
    "ANGLES": "ANGLE_UNITS",
    "FORCES": "FORCE_UNITS",
    "MOMENTS": "MOMENT_UNITS",
    "POWERS": "POWER_UNITS",
    "SCALARS": "SCALAR_UNITS",
}


def c3d_contents(path: Path) -> Contents:
    """Contents of a C3D file (units as in the file)."""
    from tepsipe.io.readers.c3d import group_labels, open_c3d

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
        Channel.of(label, others.get(label, point_unit), point_rate, points[:, k])
        for k, label in enumerate(labels)
    ]
    analogs, units = data["analogs"][0], values("ANALOG", "UNITS")
    for k, label in enumerate(group_labels(file, "ANALOG")[: analogs.shape[0]]):
        unit = str(units[k]).strip() if k < len(units) else ""
        channels.append(Channel.of(label, unit, analog_rate, analogs[k]))
    facts = {"frames": str(points.shape[0])}
    maker = " ".join(str(v).strip() for name in ("COMPANY", "SOFTWARE") for v in values("MANUFACTURER", name))
    facts |= {"made by": maker} if maker.strip() else {}
    if point_rate:
        facts["duration"] = f"{points.shape[0] / point_rate:.6g} s"
    plates, up, refused = _vertical_forces(path)
    facts["upward"] = up
    facts |= _plate_facts([int(kind) for kind in values("FORCE_PLATFORM", "TYPE")], values, plates)
    usable = tuple(plate for plate in plates if isinstance(plate, Channel))
    facts |= {"not usable as a whole trial": refused} if refused else {}
    first = file["first_frame"] / point_rate if point_rate else 0.0
    events = _events(parameters, values, first)
    facts |= {"events": _event_text(events)} if events else {}
    markers = tuple(label for label in labels if label not in others)
    return Contents("C3D", facts, channels, markers, usable, events, vertical="xyz".index(up[1]))


def _vertical_forces(path: Path) -> tuple[tuple[Channel | str, ...], str, str]:
    """Vertical force on each plate (N) or why it cannot be used, upward direction, why the file cannot be."""
    from tepsipe.io.readers.c3d_recording import read_c3d_recording
    from tepsipe.io.readers.recording import DIRECTIONS

    try:
        recording = read_c3d_recording(path)
    except InputError as error:
        return (), "+z", str(error).removeprefix(f"{path}: ").removeprefix(f"{path}, ")
    plates = tuple(
        Channel.of(f"force plate {number}", "N", plate.rate_hz, plate.force @ DIRECTIONS[recording.up])
        if plate.fault is None
        else plate.fault.removeprefix(f"{path}, force plate {number}: ")
        for number, plate in enumerate(recording.plates, start=1)
    )
    return plates, recording.up, ""


def _plate_facts(types: list[int], values, plates: tuple[Channel | str, ...]) -> dict[str, str]:
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
