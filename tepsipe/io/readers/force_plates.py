"""Force plates of a C3D file, from their channels and the parameters of the group FORCE_PLATFORM.

In the frame of a plate x points from corner 2 to corner 1, y from corner 4 to corner 1, and z = x times y,
into the floor. The channels hold the reaction on what stands on the plate, so the vertical force in the
laboratory is positive under load. With R the directions of the plate's axes in the laboratory, c the centre
of the four corners and F, M the force and the moment about the plate's own origin at c - R o, where o is
ORIGIN, from the plate's origin to the centre of its surface (its z is negative; a positive one marks a vector
that was stored in the other direction):

    type 1:        F,  P (from c),  T_z              moment about c:  P x F + (0, 0, T_z)
    type 2:        F,  M
    type 3:        F = sums of Fx12 Fx34, Fy14 Fy23, Fz1 to Fz4; a, b the distances of the sensors
                   M = (b (Fz1 + Fz2 - Fz3 - Fz4),  a (-Fz1 + Fz2 + Fz3 - Fz4),
                        b (-Fx12 + Fx34) + a (Fy14 - Fy23)),  o = (0, 0, -|o_z|)
    type 4:        (F, M) = CAL_MATRIX times six channels

    in the laboratory:  R F,  moment about its origin  R M + (c - R o) x R F

(The C3D File Format, User Guide, group FORCE_PLATFORM.) ezc3d computes platforms, too, but its moment has the
opposite sign in type 1, and in type 3 if ORIGIN has a positive z, so only its reading of the file is used.
The frames named by ZERO, whose mean could be subtracted, are ignored: in these trials a load stands on the
plate from the first frame on.
"""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError, listed, quoted
from tepsipe.io.readers.recording import Channel, ForcePlate

FORCE_UNITS = {"N": 1.0, "kN": 1e3}
MOMENT_UNITS = {"Nm": 1.0, "Nmm": 1e-3, "Ncm": 1e-2, "kNm": 1e3}
LENGTH_UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
CHANNELS = {1: 6, 2: 6, 3: 8, 4: 6}
MOST_PLATES = 100
# from this vertical force on (N) the centre of pressure is determined
LEAST_LOAD_N = 20.0


def force_plates(
    file,
    channels: list[Channel],
    labels: list[str],
    path: Path,
    scale: Annotated[float, "m"],
    frames_hz: float,
):
    """All force plates of an opened C3D file.

    file: the file as ezc3d reads it.
    channels: its analog channels in their order, each in its unit.
    path: names the file in messages.
    scale: metres per unit of the file's lengths.
    frames_hz: frames per second (Hz), the rate of a plate without channels.

    Returns
    -------
    tuple of ForcePlate
        Forces (N) and moments about the origin of the laboratory (N·m), in its axes. A plate whose type is
        not 1 to 4, with missing parameters or channels, or with an unknown unit has a ``fault``: it stops
        only the trials that use it.
    """
    group = file["parameters"].get("FORCE_PLATFORM", {})
    used = int(_values(group, "USED")[0]) if _values(group, "USED").size else 0
    if used > MOST_PLATES:
        raise InputError(
            f"{path}: expected at most {MOST_PLATES} force plates, found {used} in FORCE_PLATFORM:USED: "
            "the file is damaged, export it again"
        )
    rate = channels[0].rate_hz if channels else frames_hz
    nothing = np.full((channels[0].values.size if channels else 0, 3), np.nan)
    plates = []
    for k in range(used):
        try:
            plates.append(_plate(group, k, channels, labels, f"{path}, force plate {k + 1}", scale))
        except InputError as error:
            plates.append(ForcePlate(nothing, nothing, rate, fault=str(error)))
    return tuple(plates)


def _values(group: dict, name: str) -> np.ndarray:
    return np.asarray(group[name]["value"] if name in group else [])


def _plate(
    group: dict, number: int, channels: list[Channel], labels: list[str], name: str, scale: float
) -> ForcePlate:
    kinds = _values(group, "TYPE").ravel()
    kind = int(kinds[number]) if kinds.size > number else None
    if kind not in CHANNELS:
        raise InputError(
            f"{name}: expected a plate of type 1, 2, 3 or 4, found the type {kind}: export its forces and "
            "moments as type 2"
        )
    selected = [_channel(group, number, k, channels, labels, name) for k in range(CHANNELS[kind])]
    plate = _load_of(selected, kind, group, number, name, scale)
    units = [
        (label, replace(channel, values=one))
        for (label, channel), one in zip(selected, np.eye(len(selected)), strict=True)
    ]
    per_unit = _load_of(units, kind, group, number, name, scale)
    calibration = np.hstack([per_unit.force, per_unit.moment]).T
    return replace(plate, channels=tuple(label for label, _ in selected), calibration=calibration)


def _load_of(selected: list, kind: int, group: dict, number: int, name: str, scale: float) -> ForcePlate:
    """Load of a plate of a type from its labelled channels."""
    corners = scale * _parameter(group, "CORNERS", (3, 4), number, name).T
    origin = scale * _parameter(group, "ORIGIN", (3,), number, name)
    if origin[2] > 0.0:
        origin = np.array([*origin[:2], -origin[2]]) if kind == 3 else -origin
    rotation, centre = plate_axes(corners, name), corners.mean(axis=0)
    if kind == 1:
        force, moment = _of_type_1(selected, scale, name)
        origin = np.zeros(3)
    elif kind == 3:
        force, moment = _of_type_3(selected, np.abs(origin[0]), np.abs(origin[1]), name)
        origin = np.array([0.0, 0.0, origin[2]])
    else:
        if kind == 4:
            selected = _calibrated(group, number, selected, name)
        force = np.column_stack([_scaled(c, FORCE_UNITS, 1.0, name) for c in selected[:3]])
        moment = np.column_stack([_scaled(c, MOMENT_UNITS, scale, name) for c in selected[3:]])
    in_lab, vector = force @ rotation.T, rotation @ origin
    loads = in_lab, moment @ rotation.T + np.cross(centre - vector, in_lab)
    force, moment = (np.where(np.isfinite(load), load, np.nan) for load in loads)
    return ForcePlate(force, moment, selected[0][1].rate_hz, corners, vector if kind in (2, 4) else None)


def channels_without(
    file,
    number: int,
    plate: ForcePlate,
    channels: list[Channel],
    removed: np.ndarray,
    scale: float,
    name: str,
) -> list[np.ndarray]:
    """Channels of a plate from which a part of its load is removed.

    Types 2 to 4 are linear: the inverse of the calibration, for eight channels the one with the smallest
    changes. In type 1 the centre of pressure follows from the new load, and stays where little stands on it.

    file: the file as ezc3d reads it; ``number`` counts the plate in it from 0.
    channels: the plate's channels in their order.
    removed: force (N) and moment about the origin of the laboratory (N·m), shape (n, 6).
    scale: metres per unit of the file's lengths.
    Returns: one array per channel, in its unit.
    """
    group = file["parameters"]["FORCE_PLATFORM"]
    if int(_values(group, "TYPE").ravel()[number]) != 1:
        change = np.linalg.pinv(plate.calibration) @ removed.T
        return [c.values - x for c, x in zip(channels, change, strict=True)]
    rotation, centre = plate_axes(plate.corners, name), plate.corners.mean(axis=0)
    force, moment = plate.force - removed[:, :3], plate.moment - removed[:, 3:]
    moment = (moment - np.cross(centre, force)) @ rotation
    force = force @ rotation
    loaded = np.abs(force[:, 2]) > LEAST_LOAD_N
    load = np.where(loaded, force[:, 2], 1.0)
    units = [
        table.get(_spelled(c.unit), default)
        for c, (table, default) in zip(
            channels,
            [(FORCE_UNITS, 1.0)] * 3 + [(LENGTH_UNITS, scale)] * 2 + [(MOMENT_UNITS, scale)],
            strict=True,
        )
    ]
    x, y = (
        np.where(loaded, new, factor * c.values)
        for new, factor, c in zip(
            (-moment[:, 1] / load, moment[:, 0] / load), units[3:5], channels[3:5], strict=True
        )
    )
    torque = moment[:, 2] - (x * force[:, 1] - y * force[:, 0])
    new = (*force.T, x, y, np.where(loaded, torque, units[5] * channels[5].values))
    return [values / factor for values, factor in zip(new, units, strict=True)]


def _of_type_1(channels: list, scale: float, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Force (N) and moment about the surface's centre (N·m) from force, centre of pressure and torque."""
    force = np.column_stack([_scaled(c, FORCE_UNITS, 1.0, name) for c in channels[:3]])
    point = np.column_stack([_scaled(c, LENGTH_UNITS, scale, name) for c in channels[3:5]])
    moment = np.cross(np.column_stack([point, np.zeros(point.shape[0])]), force)
    moment[:, 2] += _scaled(channels[5], MOMENT_UNITS, scale, name)
    return force, moment


def _of_type_3(channels: list, a: float, b: float, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Force (N) and moment about the plane of the sensors (N·m) from eight channels."""
    fx12, fx34, fy14, fy23, fz1, fz2, fz3, fz4 = (_scaled(c, FORCE_UNITS, 1.0, name) for c in channels)
    force = np.column_stack([fx12 + fx34, fy14 + fy23, fz1 + fz2 + fz3 + fz4])
    moment = np.column_stack(
        [b * (fz1 + fz2 - fz3 - fz4), a * (fz2 + fz3 - fz1 - fz4), b * (fx34 - fx12) + a * (fy14 - fy23)]
    )
    return force, moment


def _calibrated(group: dict, number: int, channels: list, name: str) -> list:
    """Channels of type 4 times the calibration matrix, in the units of the result."""
    matrix = _parameter(group, "CAL_MATRIX", (6, 6), number, name)
    if "".join(map(str, _values(group, "MATRIX_STORE").ravel()[:1])).strip().upper() == "BYROW":
        matrix = matrix.T
    values = np.column_stack([channel.values for _, channel in channels]) @ matrix.T
    known = (*[FORCE_UNITS] * 3, *[MOMENT_UNITS] * 3)
    return [
        (label, Channel(x, _spelled(c.unit) if _spelled(c.unit) in units else "", c.rate_hz))
        for (label, c), x, units in zip(channels, values.T, known, strict=True)
    ]


def plate_axes(corners: np.ndarray, name: str) -> np.ndarray:
    """Directions of the plate's axes in the laboratory, as columns."""
    x, y = corners[0] - corners[1], corners[0] - corners[3]
    z = np.cross(x, y)
    if not np.linalg.norm(z) > 1e-6:
        raise InputError(
            f"{name}: expected four corners of a plate, found {quoted(np.round(corners, 2).tolist(), 120)}: "
            "set FORCE_PLATFORM:CORNERS when exporting"
        )
    axes = np.column_stack([x, np.cross(z, x), z])
    return axes / np.linalg.norm(axes, axis=0)


def _channel(group: dict, number: int, k: int, channels: list, labels: list, name: str) -> tuple:
    """Label and channel k of a plate."""
    numbers = _values(group, "CHANNEL")
    if numbers.ndim == 1:
        numbers = numbers[:, None]
    if numbers.shape[0] <= k or numbers.shape[1] <= number:
        raise InputError(
            f"{name}: expected {k + 1} or more channels in FORCE_PLATFORM:CHANNEL, found an array of shape "
            f"{numbers.shape}: export the plate with all its channels"
        )
    index = int(numbers[k, number])
    if not 1 <= index <= len(channels):
        raise InputError(
            f"{name}: expected channels from 1 to {len(channels)} in FORCE_PLATFORM:CHANNEL, found {index}: "
            "export the analog channels of the plate, too"
        )
    return labels[index - 1], channels[index - 1]


def _parameter(group: dict, parameter: str, shape: tuple, number: int, name: str) -> np.ndarray:
    """One plate's part of a parameter (unit of the file)."""
    values = _values(group, parameter)
    if values.shape == shape:
        values = values[..., None]
    if values.shape[:-1] != shape or values.shape[-1] <= number:
        raise InputError(
            f"{name}: expected FORCE_PLATFORM:{parameter} of shape {shape} for every plate, found "
            f"{values.shape}: export the file with all parameters of its plates"
        )
    value = values[..., number].astype(float)
    if not np.isfinite(value).all():
        raise InputError(
            f"{name}: expected numbers in FORCE_PLATFORM:{parameter}, found some that are not finite: the "
            "file is damaged, export it again"
        )
    return value


def _spelled(unit: str) -> str:
    """A unit without the signs of a product."""
    return unit.strip().translate(str.maketrans("", "", " .*·-"))


def _scaled(labelled: tuple, units: dict[str, float], default: float, name: str) -> np.ndarray:
    """Samples of a channel in SI units; without a unit, in N and in the file's unit of length."""
    label, channel = labelled
    unit = _spelled(channel.unit)
    if unit and unit not in units:
        raise InputError(
            f"{name}: expected the channel {label!r} in {', '.join(units)}, found the unit "
            f"{quoted(channel.unit)}: export the plate's channels with their units (ANALOG:UNITS), one of "
            f"{listed(units)}"
        )
    return units.get(unit, default) * channel.values
