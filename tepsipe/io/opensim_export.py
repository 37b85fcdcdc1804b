"""Angles, torques and ground reactions as OpenSim's motion (.mot) and storage (.sto) files.

Both begin with a name, ``version=1``, ``nRows``, ``nColumns``, ``inDegrees`` and ``endheader``, followed by
the names of the columns, the first of which is ``time``, and the rows (OpenSim's documentation, "Storage
(.sto) files" and "Motion (.mot) files"). An angle has the name of a coordinate of the model, its torque the
same name with ``_moment``, as in the output of inverse dynamics. OpenSim's axes are x forward, y up and z
to the right, the study's x to the right, y forward and z up.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError, listed, printable, quoted
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial

COORDINATE = "ankle_angle_r"
# names by which a pathway is searched; the first one present is used
PREFERRED = ("leg", "foot-compensated", "foot")
# study's x, y, z -> OpenSim's x, y, z
TO_OPENSIM = [1, 2, 0]
# below this vertical force (N) there is no centre of pressure: the moment is taken about the origin
LEAST_LOAD_N = 20.0
RADIANS = {"rad": 1.0, "deg": np.pi / 180.0}


@dataclass(frozen=True)
class Storage:
    """Columns of a .mot or .sto file."""

    name: str
    """Name on the first line."""
    time: Annotated[np.ndarray, "(n,)", "s"]
    columns: dict[str, np.ndarray]
    """Angles in degrees if ``in_degrees``, forces (N), positions (m), moments (N·m)."""
    in_degrees: bool
    """Whether angles are in degrees."""


def write_storage(storage: Storage, path: str | Path) -> None:
    """Write a .mot or .sto file (units as in `Storage`), ten significant digits."""
    columns = {"time": storage.time, **storage.columns}
    for column in columns:
        if not column.isprintable() or column.split() != [column]:
            raise InputError(
                f"{path}: expected names of columns without white space, found {quoted(column)}: give the "
                "coordinate as the OpenSim model names it, for example ankle_angle_r"
            )
    head = [
        printable(Path(storage.name).name),
        "version=1",
        f"nRows={storage.time.size}",
        f"nColumns={len(columns)}",
        f"inDegrees={'yes' if storage.in_degrees else 'no'}",
        "endheader",
        "\t".join(columns),
    ]
    with open(path, "w", encoding="utf-8", newline="\n") as file:
        file.write("\n".join(head) + "\n")
        np.savetxt(file, np.column_stack(list(columns.values())), fmt="%.10g", delimiter="\t")


def motion_of(
    content: Trial | Result,
    name: str,
    trial: Trial | None = None,
    pathway: str | None = None,
    coordinate: str = COORDINATE,
) -> Storage:
    """Angle of a trial or result for a .mot file; ground reactions of a trial on the force plates.

    content: trial or result, as `tepsipe.io.stored.read_stored` returns it.
    name: name of the motion, and of the source in messages.
    trial: the trial of a result, for the time of its samples.
    pathway: pathway of a result; by default ``leg``, ``foot-compensated``, ``foot``, or the first.
    coordinate: coordinate of the model.
    Returns: angle (degrees); or, of each belt, force, point of application and torque in OpenSim's axes,
    the point at the origin while the vertical force is below 20 N.
    """
    if isinstance(content, Trial):
        if "angle" in content.signals:
            angle = content.signals["angle"]
            degrees = np.degrees(RADIANS.get(angle.unit, 1.0) * angle.values)
            return Storage(name, content.time, {coordinate: degrees}, True)
        if "force" in content.signals and "moment" in content.signals:
            return Storage(name, content.time, _ground_reactions(content), True)
        names = content.signals
    else:
        angle = _angle(content, pathway, name)
        if angle is not None:
            time = _time(content, trial, angle.size, name)
            return Storage(name, time, {coordinate: np.degrees(angle)}, True)
        names = content.arrays
    raise InputError(
        f"{name}: expected an angle or forces of force plates, found {listed(names)}: export a trial, or the "
        "fit of a wristalyzer, dummy or position manipulator"
    )


def torque_of(
    content: Trial | Result,
    name: str,
    trial: Trial | None = None,
    pathway: str | None = None,
    coordinate: str = COORDINATE,
) -> Storage:
    """Torque of a trial or result for a .sto file.

    content, name, trial, pathway, coordinate: as `motion_of`.
    Returns: torque, named as the coordinate with ``_moment``.
    """
    if isinstance(content, Trial):
        torque = content.optional("torque")
        time = content.time
        names = content.signals
    else:
        torque = _torque(content, pathway, name)
        time = None if torque is None else _time(content, trial, torque.size, name)
        names = content.arrays
    if torque is None:
        raise InputError(
            f"{name}: expected a torque, found {listed(names)}: export the fit of a dummy or wristalyzer, "
            "the epochs of a person, or a trial of a manipulator"
        )
    return Storage(name, time, {f"{coordinate}_moment": torque}, False)


def _pathway(result: Result, wanted: str | None, name: str) -> str | None:
    """The pathway to be exported, None if the result has none."""
    available = [key.removesuffix("/torque") for key in result.arrays if key.count("/") == 1]
    available = [key for key in dict.fromkeys(available) if f"{key}/torque" in result.arrays]
    if wanted is not None and wanted not in available:
        raise InputError(
            f"{name}: expected the pathway {wanted!r}, found {listed(available)}: name one of these"
        )
    return wanted or next((key for key in (*PREFERRED, *available) if key in available), None)


def _angle(result: Result, wanted: str | None, name: str) -> np.ndarray | None:
    """Angle (rad), shape (n,)."""
    pathway = _pathway(result, wanted, name)
    if f"{pathway}/angle" in result.arrays:
        return result.arrays[f"{pathway}/angle"]
    if f"{pathway}/regressors" in result.arrays:
        return result.arrays[f"{pathway}/regressors"][:, 2] + float(result.facts.get("theta_rest_rad", 0.0))
    return _first(result, ("theta", "angle", "processed/ankle"))


def _torque(result: Result, wanted: str | None, name: str) -> np.ndarray | None:
    """Torque (N·m), shape (n,)."""
    pathway = _pathway(result, wanted, name)
    if pathway is not None:
        return result.arrays[f"{pathway}/torque"]
    return _first(result, ("tau", "torque", "processed/torque_recommended"))


def _first(result: Result, names: tuple[str, ...]) -> np.ndarray | None:
    return next((result.arrays[n] for n in names if n in result.arrays and result.arrays[n].ndim == 1), None)


def _time(result: Result, trial: Trial | None, samples: int, name: str) -> np.ndarray:
    """Instants of a result's samples (s)."""
    if trial is None:
        candidates = [_first(result, (key,)) for key in ("time", "processed/time")]
        time = next((x for x in candidates if x is not None and x.size == samples), None)
    else:
        time = trial.time
    if time is None and "rate_hz" in result.facts:
        time = np.arange(samples) / float(result.facts["rate_hz"])
    if time is None:
        raise InputError(
            f"{name}: expected the time of its samples, found none in the file: name its trial, too"
        )
    if time.size != samples:
        raise InputError(
            f"{name}: expected the time of {samples} samples, found {time.size}: name the trial of this fit"
        )
    return time


def _ground_reactions(trial: Trial) -> dict[str, np.ndarray]:
    """Force (N), point of application (m) and torque there (N·m) of each belt, in OpenSim's axes."""
    columns = {}
    for k, belt in enumerate(trial.axes["belt"].tolist()):
        force, moment = (trial.values(name)[:, k].astype(float) for name in ("force", "moment"))
        loaded = np.abs(force[:, 2]) >= LEAST_LOAD_N
        vertical = np.where(loaded, force[:, 2], 1.0)
        point = np.zeros_like(force)
        point[:, 0] = np.where(loaded, -moment[:, 1] / vertical, 0.0)
        point[:, 1] = np.where(loaded, moment[:, 0] / vertical, 0.0)
        torque = moment - np.cross(point, force)
        for label, values in (("force_{}_v", force), ("force_{}_p", point), ("torque_{}_", torque)):
            turned = values[:, TO_OPENSIM]
            for axis, column in zip("xyz", turned.T, strict=True):
                columns[f"ground_{label.format(belt)}{axis}"] = column
    return columns
