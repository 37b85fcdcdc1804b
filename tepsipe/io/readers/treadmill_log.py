"""The treadmill's MATLAB log and the calibration matrix of its force plate."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError, listed, quoted
from tepsipe.io.readers.mat_file import read_mat
from tepsipe.io.readers.plain_file import read_text
from tepsipe.io.readers.plain_table import number_in

VARIABLES = {
    "sample_rate_hz": "sampling rate",
    "channel_names": "names of the transducer channels",
    "transducers_V": "transducer voltages",
    "belt_velocity_m_per_s": "measured belt velocity",
    "command_m_per_s": "commanded belt velocity",
    "trigger_V": "trigger line",
}
COMPONENTS = tuple(
    f"{name}_{belt}" for belt in ("left", "right") for name in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
)


@dataclass(frozen=True)
class TreadmillLog:
    """One treadmill log as the instrument wrote it."""

    rate_hz: float
    channels: tuple[str, ...]
    """Names of the transducer channels."""
    voltages: Annotated[np.ndarray, "(n, channels)", "V"]
    """Transducer voltages."""
    belt_velocity: Annotated[np.ndarray, "(n,)", "m/s"]
    command: Annotated[np.ndarray, "(n,)", "m/s"]
    """Measured and commanded belt velocity."""
    trigger: Annotated[np.ndarray, "(n,)", "V"]
    """Trigger line."""


@dataclass(frozen=True)
class CalibrationMatrix:
    """Forces and moments per transducer voltage (thesis section 2-1-2)."""

    components: tuple[str, ...]
    """For example ``Fy_right`` (N) and ``Mx_right`` (N·m)."""
    channels: tuple[str, ...]
    """Names of the transducer channels."""
    matrix: Annotated[np.ndarray, "(components, channels)"]
    """N/V for forces, N·m/V for moments."""

    def row(self, component: str) -> np.ndarray:
        """Row of one component, shape (channels,), in N/V or Nm/V."""
        return self.matrix[self.components.index(component)]


def read_treadmill_log(path: str | Path) -> TreadmillLog:
    """Read a treadmill log.

    path: MATLAB file of any version, plain or compressed with gzip, with the variables listed in
    `VARIABLES` (units in their names), or with one structure that has them as fields.
    """
    path = Path(path)
    content = _variables(read_mat(path, "a treadmill log"))
    for name, meaning in VARIABLES.items():
        if name not in content:
            raise InputError(
                f"{path}: expected the variable {name!r} ({meaning}), found {listed(content)}: export it "
                "again with all variables"
            )
    voltages = _numbers(path, "transducers_V", content)
    rate = _numbers(path, "sample_rate_hz", content)
    if rate.size != 1 or not np.isfinite(rate).all() or not rate.item() > 0.0:
        raise InputError(
            f"{path}: expected one positive number in 'sample_rate_hz', found {quoted(rate.tolist())}: "
            "export the log again"
        )
    if content["channel_names"] is None:
        raise InputError(
            f"{path}: expected a cell array of text in 'channel_names', found a string array: save "
            "cellstr(channel_names)"
        )
    channels = tuple(str(np.squeeze(name)).strip() for name in np.ravel(content["channel_names"]))
    lines = {
        name: np.ravel(_numbers(path, name, content))
        for name in ("belt_velocity_m_per_s", "command_m_per_s", "trigger_V")
    }
    if voltages.ndim != 2 or voltages.shape[1] != len(channels):
        raise InputError(
            f"{path}: expected one column of transducers_V for each of the {len(channels)} channel "
            f"names, found the shape {voltages.shape}: export it again"
        )
    if voltages.shape[0] < 2:
        raise InputError(
            f"{path}: expected a time series in 'transducers_V', found {voltages.shape[0]} samples: export "
            "the log again"
        )
    for name, line in lines.items():
        if line.size != voltages.shape[0]:
            raise InputError(
                f"{path}: expected {voltages.shape[0]} samples in every variable, found {line.size} "
                f"in {name!r}: the file is truncated or damaged, export it again"
            )
    return TreadmillLog(
        rate_hz=float(rate.item()),
        channels=channels,
        voltages=voltages,
        belt_velocity=lines["belt_velocity_m_per_s"],
        command=lines["command_m_per_s"],
        trigger=lines["trigger_V"],
    )


def _variables(content: dict) -> dict:
    """The variables of a log, also if they are the fields of a structure."""
    if not VARIABLES.keys() & content.keys():
        for value in content.values():
            names = value.dtype.names if isinstance(value, np.ndarray) else None
            if names is not None and value.size == 1:  # a structure of version 5
                value = {name: value[name].item() for name in names}
            if isinstance(value, dict) and VARIABLES.keys() <= value.keys():
                return value
    return content


def _numbers(path: Path, name: str, content: dict) -> np.ndarray:
    try:
        if np.iscomplexobj(content[name]):
            raise ValueError
        return np.asarray(content[name], dtype=float)
    except (TypeError, ValueError):
        raise InputError(
            f"{path}: expected numbers in {name!r}, found something else: export the log again"
        ) from None


def read_calibration_matrix(path: str | Path) -> CalibrationMatrix:
    """Read the calibration matrix of the force plate.

    path: CSV with the columns component, unit (N/V or Nm/V) and one per transducer channel; 12 rows, each
    with a line break at its end: a file without the last one may be cut within its last number.
    Returns: components, channels and the matrix.
    """
    path = Path(path)
    lines = read_text(path, "a calibration matrix", ended=True).splitlines()
    rows = [line.split(",") for line in lines if line.strip()]
    if not rows or [field.strip() for field in rows[0][:2]] != ["component", "unit"]:
        start = quoted(",".join(rows[0][:2])) if rows else "an empty file"
        raise InputError(
            f"{path}: expected the header to start with component,unit, found {start}: export the "
            "calibration matrix with its labels"
        )
    channels = tuple(field.strip() for field in rows[0][2:])
    components = []
    for number, row in enumerate(rows[1:], start=2):
        name, expected = row[0].strip(), "N/V" if row[0].strip().startswith("F") else "Nm/V"
        if len(row) != len(channels) + 2:
            raise InputError(
                f"{path}: expected {len(channels) + 2} fields on every line, found {len(row)} on "
                f"line {number}: the file is truncated or damaged, copy it again"
            )
        if name not in COMPONENTS:
            raise InputError(
                f"{path}: expected a component of {', '.join(COMPONENTS)}, found {quoted(name)} on line "
                f"{number}: remove the line or correct its label"
            )
        if row[1].strip() != expected:
            raise InputError(
                f"{path}: expected the unit {expected} for {name}, found {quoted(row[1].strip())}: convert "
                "the matrix or correct its label"
            )
        if name in components:
            raise InputError(
                f"{path}: expected every component once, found {name} again on line {number}: remove one"
            )
        components.append(name)
    for name in COMPONENTS:
        if name not in components:
            raise InputError(
                f"{path}: expected 12 components, Fx to Mz of the left and the right belt, found "
                f"{len(components)} without {name}: the file is truncated or misses a label"
            )
    return CalibrationMatrix(tuple(components), channels, _matrix(path, rows[1:], channels))


def _matrix(path: Path, rows: list[list[str]], channels: tuple[str, ...]) -> np.ndarray:
    """Numbers of all components, shape (components, channels), in N/V and N·m/V."""
    matrix = np.empty((len(rows), len(channels)))
    for k, row in enumerate(rows):
        for j, field in enumerate(row[2:]):
            try:
                matrix[k, j] = number_in(field)
            except ValueError:
                matrix[k, j] = np.nan
            if not np.isfinite(matrix[k, j]):
                raise InputError(
                    f"{path}: expected a finite number for {row[0].strip()} and {channels[j]}, found "
                    f"{quoted(field.strip())} on line {k + 2}: repair the file or export it again"
                )
    return matrix
