"""Plausibility of the signals of a finished trial for the rig that is said to have recorded them.

Every way into the library ends in a `Trial`, which `plausible_trial` examines: a wrong unit, a dead channel,
a frozen marker or the file of another trial is refused whatever the format of the files was.
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.ingest.agreement import (
    other_amplitude,
    refuse_foreign_markers,
    refuse_joint,
    refuse_joints,
    refuse_mass,
    refuse_other_force,
    sides_of_plates,
)
from tepsipe.ingest.limits import Limits, Rig, frozen_stretch, source, used_belt
from tepsipe.io.trial import Trial, with_faults

# a person's frozen marker counts as hidden up to this fraction of the trial; beyond it the trial is refused
FROZEN_SHARE = 0.5


@dataclass(frozen=True)
class _Kind:
    """Limit of a signal, its name in messages, and the files it may come from, the first present."""

    limit: str
    what: str
    files: tuple[str, ...]
    advice: str


_PLATE = "check the unit of the file and the calibration matrix"
_KINDS = {
    "belt_velocity": _Kind("belt_velocity_m_per_s", "a belt velocity", ("log",), "convert it to m/s"),
    "belt_command": _Kind(
        "belt_velocity_m_per_s", "a commanded belt velocity", ("log",), "convert it to m/s"
    ),
    "force": _Kind("force_N", "a force", ("log",), _PLATE),
    "moment": _Kind("moment_Nm", "a moment", ("log",), _PLATE),
    "load": _Kind("", "a load", ("log",), "check the unit of its column"),
    "marker_position": _Kind(
        "marker_position_m", "a marker position", ("markers",), "check the file's unit of length"
    ),
    "marker_position_as_sampled": _Kind(
        "marker_position_m", "a marker position", ("markers",), "check the file's unit of length"
    ),
    "angle": _Kind("angle_rad", "a joint angle", ("log",), "check the unit of its column"),
    "torque": _Kind("torque_Nm", "a torque", ("command", "log"), "convert it to N·m"),
    "joint_angle": _Kind("angle_rad", "a joint angle", ("log",), "check the unit of its column"),
    "joint_torque": _Kind("torque_Nm", "a joint torque", ("log",), "convert it to N·m"),
    "emg": _Kind("emg_uV", "an electromyogram", ("emg",), "check the unit of the channel"),
}


def plausible_trial(trial: Trial, limits: Limits, rig: Rig, files: dict[str, str]) -> Trial:
    """Return the trial if its signals are plausible for the rig.

    trial: signals as ingest made them.
    limits: plausible range of each kind of signal.
    rig: stated contents of the trial.
    files: kind of each source file -> its path, for messages.
    Returns: the same; of a person with ``marker_hidden`` set where a marker is frozen; with the fault
    ``other-amplitude`` if the belt moves faster or slower than stated; of a person on two belts with the
    attribute ``plate_sides``, a sentence, and the fault ``plates-exchanged``.
    """
    _refuse_ranges(trial, limits, files)
    _refuse_dead_plate(trial, limits, rig, files)
    trial = _without_frozen_markers(trial, limits, rig, files)
    refuse_mass(trial, rig, files)
    refuse_foreign_markers(trial, limits, rig, files)
    refuse_other_force(trial, limits, rig, files)
    refuse_joint(trial, limits, files)
    refuse_joints(trial, limits, files)
    exchanged, sides = sides_of_plates(trial, rig)
    if sides:
        trial = replace(trial, attributes=trial.attributes | {"plate_sides": sides})
    faults = ["other-amplitude"] * other_amplitude(trial, rig) + ["plates-exchanged"] * bool(exchanged)
    return with_faults(trial, *faults) if faults else trial


# ---- ranges --------------------------------------------------------------------------------------


def _refuse_ranges(trial: Trial, limits: Limits, files: dict[str, str]) -> None:
    low, high = limits.rate_hz
    if not low <= trial.rate_hz <= high:
        raise InputError(
            f"{source(files)}: expected a sampling rate of {low:g} to {high:g} Hz, found {trial.rate_hz:g} "
            "Hz: correct it in the file or the configuration, or change plausible.rate_hz"
        )
    for name, signal in trial.signals.items():
        if name not in _KINDS:
            continue
        kind = _KINDS[name]
        key = kind.limit or ("force_N" if signal.unit == "N" else "moment_Nm")
        file = source(files, *kind.files)
        _refuse_range(trial, name, signal.values, getattr(limits, key), f"plausible.{key}", file)
    if "belt_velocity" in trial.signals:
        rate = np.diff(trial.values("belt_velocity")) * trial.rate_hz
        low, high = limits.belt_acceleration_m_per_s2
        k = int(np.argmax(np.abs(rate)))
        if not low <= rate[k] <= high:
            raise InputError(
                f"{source(files, 'log')}: expected a belt acceleration of {low:g} to {high:g} m/s², found "
                f"{rate[k]:.4g} m/s² at {trial.time[k]:.3f} s: repair the belt velocity there, or change "
                "plausible.belt_acceleration_m_per_s2 in the configuration"
            )
    if "marker_position_as_sampled" in trial.signals:
        _refuse_jumps(trial, limits, files)


def _refuse_range(trial: Trial, name: str, values: np.ndarray, allowed, key: str, file: str) -> None:
    """Refuse a signal that is not a number, or outside its range."""
    signal, kind, (low, high) = trial.signals[name], _KINDS[name], allowed
    least, most = float(values.min()), float(values.max())
    if low <= least and most <= high:
        return
    flat = values.reshape(values.shape[0], -1)
    worst = np.where(np.isfinite(flat), np.maximum(low - flat, flat - high), np.inf)
    k, column = np.unravel_index(int(worst.argmax()), flat.shape)
    value = float(flat[k, column])
    where = _place(trial, signal.axes[1:], values.shape[1:], int(column))
    instant = trial.axes[signal.axes[0]][k]
    raise InputError(
        f"{file}: expected {kind.what} of {low:g} to {high:g} {signal.unit}, found {value:.4g} "
        f"{signal.unit}{where} at {instant:.3f} s: {kind.advice}, repair the sample, or change {key} in the "
        "configuration"
    )


def _place(trial: Trial, axes: tuple[str, ...], shape: tuple[int, ...], column: int) -> str:
    """Names of one component of a signal: marker, belt, direction."""
    if not axes:
        return ""
    names = [str(trial.axes[a][k]) for a, k in zip(axes, np.unravel_index(column, shape), strict=True)]
    return f" in {', '.join(names)}"


def _refuse_jumps(trial: Trial, limits: Limits, files: dict[str, str]) -> None:
    """Refuse a marker with an impossible speed between two samples."""
    positions = trial.values("marker_position_as_sampled")
    speed = np.sqrt((np.diff(positions, axis=0).astype(float) ** 2).sum(axis=2)) * trial.rate_hz
    k, marker = np.unravel_index(int(speed.argmax()), speed.shape)
    if speed[k, marker] > limits.marker_speed_m_per_s:
        raise InputError(
            f"{source(files, 'markers')}: expected markers of at most {limits.marker_speed_m_per_s:g} m/s, "
            f"found {speed[k, marker]:.4g} m/s of {str(trial.axes['marker'][marker])!r} at "
            f"{trial.time[k]:.3f} s: check the file's unit of length, remove the wrong sample there, or "
            "change plausible.marker_speed_m_per_s in the configuration"
        )


# ---- what stands still or is dead -------------------------------------------------------------------


def _refuse_dead_plate(trial: Trial, limits: Limits, rig: Rig, files: dict[str, str]) -> None:
    """Refuse fore-aft and vertical force and pitch moment that do not vary, of the belt in use."""
    belt = used_belt(trial, rig)
    if belt is None:
        return
    for name, component, what in (("force", 1, "Fy"), ("force", 2, "Fz"), ("moment", 0, "Mx")):
        values = trial.values(name)[:, belt, component]
        stretch = frozen_stretch(values[:, None], trial.rate_hz, limits.frozen_s)
        if stretch is None:
            continue
        start, stop = stretch
        throughout = stop - start == values.size
        when = "throughout" if throughout else f"from {trial.time[start]:.3f} to {trial.time[stop - 1]:.3f} s"
        unit = trial.signals[name].unit
        raise InputError(
            f"{source(files, 'log')}: expected {what} of the {rig.belt} belt to vary with its noise, found "
            f"{values[start]:.4g} {unit} {when}: check that the force plate was connected, its calibration "
            "matrix, and which belt the configuration names"
        )


def refuse_dead_channels(
    voltages: Annotated[np.ndarray, "(n, channels)", "V"],
    channels: tuple[str, ...],
    calibration: Annotated[np.ndarray, "(components, channels)"],
    name: str,
) -> None:
    """Refuse transducers that read the same voltage throughout although the calibration uses them.

    voltages: as recorded.
    calibration: forces and moments per voltage (N/V, N·m/V).
    name: names the log in messages.
    """
    dead = np.flatnonzero((np.ptp(voltages, axis=0) == 0.0) & (calibration != 0.0).any(axis=0))
    if dead.size:
        raise InputError(
            f"{name}: expected noise of every transducer, found {voltages[0, dead[0]]:.4g} "
            f"V throughout in {listed([channels[k] for k in dead], 4)}: check that its amplifier is connected"
        )


def _without_frozen_markers(trial: Trial, limits: Limits, rig: Rig, files: dict[str, str]) -> Trial:
    """Refuse frozen markers; of a person, mark stretches in which one is frozen as hidden."""
    if "marker_position_as_sampled" not in trial.signals:
        return trial
    positions = trial.values("marker_position_as_sampled")
    hidden = trial.values("marker_hidden").copy()
    changed = False
    for k, label in enumerate(trial.axes["marker"].tolist()):
        while True:
            stretch = frozen_stretch(positions[:, k], trial.rate_hz, limits.frozen_s, hidden[:, k])
            if stretch is None:
                break
            start, stop = stretch
            if not rig.person or stop - start > FROZEN_SHARE * trial.time.size:
                raise InputError(
                    f"{source(files, 'markers')}: expected the marker {label!r} to move or at least to show "
                    f"the noise of its measurement, found the same position from {trial.time[start]:.3f} to "
                    f"{trial.time[stop - 1]:.3f} s: export the markers without filling gaps by their last "
                    "position, or record the trial again"
                )
            hidden[start:stop, k] = changed = True
    if not changed:
        return trial
    signal = trial.signals["marker_hidden"]
    return replace(trial, signals=trial.signals | {"marker_hidden": replace(signal, values=hidden)})
