"""Removal of the belt-induced load from a recorded file: the same file with corrected loads."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import scipy

from tepsipe import __version__
from tepsipe.arguments import checked, one_of, path_of, texts
from tepsipe.errors import InputError, listed, quoted
from tepsipe.experiments.belt.analysis import AS_GOOD, UNSUITED
from tepsipe.experiments.belt.files import GROUP, BeltChannels, BeltFile, BeltVelocity, read_belt_file
from tepsipe.io.readers.force_plates import LEAST_LOAD_N
from tepsipe.io.readers.plain_file import plain_bytes
from tepsipe.io.readers.recording import DIRECTIONS, centre_of_pressure
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.notebook_display import new_axes
from tepsipe.treadmill.recording import BeltRecording, score
from tepsipe.treadmill.registry import MOTION, RANGED, FittedModel, leaving, read_models
from tepsipe.treadmill.removal import half_width, removed_load

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# length of the figure (s)
SHOWN_S = 5.0


@dataclass(frozen=True, repr=False)
class CompensatedLoad:
    """One load before and after the removal of the belt-induced load."""

    name: str
    unit: str
    """N or Nm."""
    model: FittedModel
    rate_hz: float
    before: Annotated[np.ndarray, "(n,)"]
    removed: Annotated[np.ndarray, "(n,)"]
    """Belt-induced load (unit of the load)."""
    half_width: np.ndarray | None
    """Half-width of the 95 % interval of the corrected load (unit of the load); None if the model was not
    evaluated on a recording that it had not seen."""
    half_width_below: np.ndarray | None
    """The same behind the low-pass of the calibration (unit of the load)."""
    within: Annotated[np.ndarray, "(n,)"] | None
    """True where velocity and acceleration of the belt lie within the range of the calibration; None if that
    range was not kept with the model."""
    r2: float
    """Fraction of the variance of the load, filtered as in the calibration, that was removed. On an empty
    belt it is the R² of the model."""

    @property
    def after(self) -> np.ndarray:
        """Corrected load (unit of the load), shape (n,)."""
        return self.before - self.removed


@dataclass(frozen=True, repr=False)
class Compensation:
    """Loads of a recording from which the belt-induced load was removed."""

    recording: Path
    output: Path | None
    loads: Mapping[str, CompensatedLoad]
    """Name -> load, in the order of the file (N, N·m)."""
    kept: Mapping[str, str]
    """Name -> reason, of the loads that were left as they were."""
    steps: Mapping[str, float]
    """Channel -> difference of two neighbouring numbers of the written file (unit of the channel), for
    files of whole numbers."""
    notes: tuple[str, ...]
    """One sentence for each model that extrapolates."""
    pressure: Mapping[str, tuple[float, float]]
    """Plate -> median shift of its centre of pressure while it is loaded, and median half-width of the 95 %
    interval (m)."""

    def __repr__(self) -> str:
        return f"<Compensation of {self.recording.name}: {listed(self.loads)}>"

    def __str__(self) -> str:
        return self.summary()

    def to_frame(self) -> "pd.DataFrame":
        """One row per load: model, R², range, half-width (units in the column ``unit``)."""
        import pandas as pd

        return pd.DataFrame([_row(load) for load in self.loads.values()])

    def summary(self) -> str:
        """Table of the loads as text (units of the loads)."""
        head = ("held-out R2", "removed R2", "within range")
        lines = [f"{'load':<20}{'model':<16}{''.join(f'{name:>13}' for name in head)}  95 % of errors"]
        for load in self.loads.values():
            row = _row(load)
            held = "unknown" if row["held_out_r2"] is None else f"{row['held_out_r2']:.4f}"
            below = "unknown"
            if row["half_width"] is not None:
                sizes = (row["half_width"], row["half_width_below_cutoff"])
                below = f"below {sizes[0]:.3g}, filtered {sizes[1]:.3g} {load.unit}"
            share = "unknown" if row["within_percent"] is None else f"{row['within_percent']:.1f} %"
            lines.append(
                f"{load.name:<20}{load.model.name:<16}{held:>13}{load.r2:>13.4f}{share:>13}  {below}"
            )
        lines += [_range_of(load.model) for load in _one_per_calibration(self.loads.values())]
        for reason in dict.fromkeys(self.kept.values()):
            names = [name for name, why in self.kept.items() if why == reason]
            lines.append(
                f"Left as {'it was' if len(names) == 1 else 'they were'}: {', '.join(names)}, {reason}."
            )
        for plate, (shift, half) in self.pressure.items():
            lines.append(
                f"Centre of pressure of {plate}: moved by {1e3 * shift:.1f} mm, 95 % of errors below "
                f"{1e3 * half:.1f} mm (medians while loaded)."
            )
        if self.steps:
            most = max(self.steps, key=lambda name: self.steps[name])
            lines.append(
                f"The file holds whole numbers: corrected samples are rounded to steps of up to "
                f"{self.steps[most]:.3g} (channel {most}, in its unit)."
            )
        lines.append(
            "Above the cutoff of the calibration nothing was removed. The models assume that the "
            "belt-induced load does not depend on what stands on the belt."
        )
        return "\n".join(lines)

    def plot(self, ax: "Axes | Sequence[Axes] | None" = None) -> "Figure":
        """Loads before and after below the cutoff, with the 95 % interval, over the 5 s with most correction.

        ax: one axes per load; by default a new figure (7 inches wide).
        Returns: the figure of the axes (size in inches).
        """
        figure, axes = new_axes(ax, len(self.loads), (7.0, 1.2 + 1.6 * len(self.loads)))
        for axis, load in zip(axes, self.loads.values(), strict=True):
            _draw(axis, load)
        axes[0].legend(loc="upper right", frameon=False, ncols=3)
        axes[-1].set_xlabel("Time (s)")
        return figure


def _row(load: CompensatedLoad) -> dict[str, object]:
    return {
        "load": load.name,
        "unit": load.unit,
        "model": load.model.name,
        "held_out_r2": load.model.held_out,
        "removed_r2": load.r2,
        "rms_before": float(np.std(load.before)),
        "rms_after": float(np.std(load.after)),
        "half_width": _median(load.half_width),
        "half_width_below_cutoff": _median(load.half_width_below),
        "within_percent": None if load.within is None else 100.0 * float(load.within.mean()),
    }


def _median(x: np.ndarray | None) -> float | None:
    return None if x is None else float(np.median(x))


def _one_per_calibration(loads) -> list[CompensatedLoad]:
    """The first of the loads of each range of belt motion."""
    by_range = {}
    for load in loads:
        key = (
            None if load.model.calibrated is None else tuple(tuple(load.model.calibrated[k]) for k in MOTION)
        )
        by_range.setdefault(key, load)
    return list(by_range.values())


def _range_of(model: FittedModel) -> str:
    if model.calibrated is None:
        return f"Range of the calibration of {model.name}: not kept with the model."
    parts = [
        f"{name} {low:.3g} to {high:.3g} {RANGED[name]}"
        for name in MOTION
        for low, high in [model.calibrated[name]]
    ]
    cutoff = "" if model.lowpass is None else f", below {model.lowpass.cutoff_hz:g} Hz"
    return f"Range of the calibration: {', '.join(parts)}{cutoff}, by {listed(model.trained_on)}."


def _draw(axis: "Axes", load: CompensatedLoad) -> None:
    """Draw a load behind a zero-lag low-pass: above the cutoff of the calibration nothing was removed."""
    time = np.arange(load.before.size) / load.rate_hz
    length = min(time.size, round(SHOWN_S * load.rate_hz))
    power = np.cumsum(np.concatenate([[0.0], load.removed**2]))
    start = int(np.argmax(power[length:] - power[:-length]))
    span = slice(start, start + length)
    before, after, unit = load.before, load.after, "N·m" if load.unit == "Nm" else "N"
    label = f"{load.name}\n({unit})"
    if load.model.lowpass is not None:
        lowpass = Lowpass(load.model.lowpass.cutoff_hz, 4, zero_lag=True).within(load.rate_hz)
        before, after = (lowpass(x, load.rate_hz) for x in (before, after))
        label = f"{load.name}\nbelow {lowpass.cutoff_hz:g} Hz ({unit})"
    axis.plot(time[span], before[span], color="0.6", linewidth=1.2, label="before")
    if load.half_width_below is not None:
        low, high = ((after + sign * load.half_width_below)[span] for sign in (-1.0, 1.0))
        axis.fill_between(
            time[span], low, high, color="#c8371b", alpha=0.2, linewidth=0.0, label="95 % interval"
        )
    axis.plot(time[span], after[span], color="#c8371b", linewidth=1.0, label="after")
    axis.set_ylabel(label)


def compensate_recording(
    recording: str | Path,
    models: str | Path,
    output: str | Path | None = None,
    *,
    velocity: str | None = None,
    belt_markers: Sequence[str] = (),
    velocity_scale: float | None = None,
    velocity_offset: float = 0.0,
    time_column: str | None = None,
    load: Sequence[str] = (),
    load_unit: str = "Nm",
    model: str | None = None,
    strict: bool = False,
) -> Compensation:
    """Remove the load that an accelerated belt induces from a recorded file.

    The copy has corrected forces and moments, and centres of pressure that follow from them. All other
    channels and parameters are those of the recording. A note in the copy names the models. Each load is
    corrected by the model that its calibration recommends, below the cutoff of the calibration, without lag.

    Parameters
    ----------
    recording : str or Path
        C3D with force plates, text of D-Flow's mocap module, or text table.
    models : str or Path
        File of models, as ``tepsipe calibrate`` writes it.
    output : str or Path, optional
        File to write, of the same kind; without it nothing is written.
    velocity : str, optional
        Channel or column of the belt velocity, or ``FILE`` or ``FILE:COLUMN`` of a text table with it.
    belt_markers : sequence of str
        Belt-fixed markers, if the velocity is in no channel.
    velocity_scale : float, optional
        Belt velocity per unit of the channel (m/s); by default it follows from the unit.
    velocity_offset : float
        Value of the channel while the belt stands still (its unit).
    time_column, load, load_unit : str, sequence of str, {"Nm", "N"}
        Columns of a table of single loads, and the unit of the loads.
    model : str, optional
        Name of one model for all loads, in place of the recommended ones.
    strict : bool
        Refuse a recording outside the range of the calibration.

    Returns
    -------
    Compensation
        Loads before and after (N, N·m), with the 95 % interval of the corrected ones.

    Raises
    ------
    InputError
        If the recording or the models cannot be used, the recording was corrected before, or with ``strict``
        the belt moves outside the range of the calibration.

    Examples
    --------
    >>> from tepsipe import compensate_recording
    >>> found = compensate_recording(
    ...     "walk.c3d", "treadmill_models.json", "walk_compensated.c3d", velocity="Belt speed"
    ... )  # doctest: +SKIP
    >>> print(found.summary())  # doctest: +SKIP
    """
    optional = ("velocity", "velocity_scale", "time_column", "model")
    velocity, velocity_scale, velocity_offset, time_column, model, strict = checked(
        optional,
        velocity=velocity,
        velocity_scale=velocity_scale,
        velocity_offset=velocity_offset,
        time_column=time_column,
        model=model,
        strict=strict,
    )
    markers = tuple(texts(belt_markers, "belt_markers"))
    source = BeltVelocity(velocity, markers, velocity_scale, velocity_offset)
    done = compensate(
        path_of(recording, "recording"),
        path_of(models, "models"),
        None if output is None else path_of(output, "output"),
        BeltChannels(source, texts(load, "load"), time_column, one_of(load_unit, "load_unit", ("Nm", "N"))),
        model=model,
        strict=strict,
    )
    if strict and done.notes:
        raise InputError(done.notes[0])
    return done


def compensate(
    path: Path, models: Path, output: Path | None, channels: BeltChannels, *, model: str | None, strict: bool
) -> Compensation:
    """As `compensate_recording` (m/s, N, N·m), but nothing is written if ``strict`` and there are notes."""
    known = read_models(models)
    _refuse_corrected(path)
    file = read_belt_file(path, channels)
    chosen, kept = _models_by_load(known, file, model, models)
    found, notes = {}, []
    for name, fitted in chosen.items():
        one = file.recording(name, fitted.model.rate_hz)
        found[name], note = _compensated(file, name, fitted, one)
        notes.append(note)
    notes = tuple(dict.fromkeys(filter(None, notes)))
    if strict and notes:
        output = None
    steps = {}
    if output is not None:
        if output.resolve() in (path.resolve(), models.resolve()):
            raise InputError(
                f"{output}: expected a file of its own to write to, found an input: name another"
            )
        corrections = {name: load.removed for name, load in found.items()}
        steps = file.write(output, corrections, _note(path, models, found))
    return Compensation(path, output, found, kept, steps, notes, _pressure(file, found))


def _refuse_corrected(path: Path) -> None:
    """Refuse a recording with the note of an earlier compensation."""
    if GROUP.encode() in plain_bytes(path, "a recording")[:200_000]:
        raise InputError(
            f"{path}: expected a recording as it was measured, found the note of an earlier compensation "
            f"({GROUP}): name the original file"
        )


def _models_by_load(
    known: list[FittedModel], file: BeltFile, model: str | None, path: Path
) -> tuple[dict[str, FittedModel], dict[str, str]]:
    """Load -> model that corrects it, and load -> reason why none does."""
    changing, alone = file.changing, len({m.load for m in known}) == 1
    chosen, kept = {}, {}
    for name, load in file.loads.items():
        own = [m for m in known if m.load == name or (alone and len(file.loads) == 1)]
        wanted = [m for m in own if (m.name == model if model is not None else m.recommended)]
        if name not in changing:
            kept[name] = "which is constant"
        elif not own:
            kept[name] = "for which there is no model"
        elif not wanted:
            raise InputError(
                f"{path}: expected the model to be one of {listed(m.name for m in own)}, found "
                f"{'none recommended' if model is None else quoted(model)}: name one of them (model)"
            )
        elif wanted[0].name in UNSUITED:
            raise InputError(
                f"{path}: expected a model of the belt's motion alone, found {wanted[0].name}, which needs "
                "the pulses and the mass on the belt: make a study of the recording, or calibrate with "
                "tepsipe calibrate"
            )
        elif wanted[0].unit != load.unit:
            raise InputError(
                f"{path}: expected a model of a load in {load.unit} for {name}, found one in "
                f"{wanted[0].unit}: correct the unit of the load (load_unit), or name the file of its models"
            )
        elif wanted[0].held_out is not None and wanted[0].held_out < AS_GOOD:
            kept[name] = "of which the model predicts nothing on the held-out recording"
        else:
            chosen[name] = wanted[0]
    if not chosen:
        first = next(iter(kept.items()), ("", "without loads"))
        raise InputError(
            f"{file.path}: expected a load that the models of {path.name} correct, "
            f"{listed(dict.fromkeys(m.load for m in known))}, found {first[0]}, {first[1]}: calibrate with "
            "recordings of the same kind"
        )
    return chosen, kept


def _compensated(
    file: BeltFile, name: str, fitted: FittedModel, one: BeltRecording
) -> tuple[CompensatedLoad, str]:
    """A load before and after, and a sentence if the model extrapolates."""
    load, removed = file.loads[name], removed_load(fitted, one)
    filtered = one.filtered(fitted.lowpass)
    r2 = score([filtered], [fitted.predict(filtered)]).r2
    note, within = "", None
    if fitted.calibrated is not None:
        note, within = leaving(filtered, fitted.calibrated, MOTION), np.ones(one.load.size, dtype=bool)
        for quantity in MOTION:
            low, high = fitted.calibrated[quantity]
            values = getattr(filtered, quantity)
            within &= (values >= low) & (values <= high)
    halves = [half_width(error, removed, one.rate_hz) for error in fitted.errors or ()]
    at = np.arange(load.values.size) * (one.rate_hz / load.rate_hz)
    if abs(one.rate_hz - load.rate_hz) > 1e-6 * load.rate_hz:
        removed = scipy.interpolate.CubicSpline(np.arange(removed.size), removed)(
            np.minimum(at, removed.size - 1)
        )
        if within is not None:
            within = within[np.minimum(np.round(at).astype(int), within.size - 1)]
        halves = [np.interp(at, np.arange(half.size), half) for half in halves]
    half, below = halves or (None, None)
    return CompensatedLoad(
        name, load.unit, fitted, load.rate_hz, load.values, removed, half, below, within, r2
    ), note


def _note(path: Path, models: Path, loads: Mapping[str, CompensatedLoad]) -> dict[str, list[str]]:
    """Lines for the copy that say what was done."""
    lines = []
    for load in loads.values():
        held, errors = load.model.held_out, load.model.errors
        error = "an unknown size"
        if errors is not None:
            error = f"hypot({errors[0][0]:.4g}, {errors[0][1]:.4g} * RMS of the correction over 0.2 s)"
        r2 = "unknown" if held is None else f"{held:.4f}"
        share = "an unknown share" if load.within is None else f"{100.0 * load.within.mean():.1f} %"
        lines.append(
            f"{load.name}: {load.model.name}, held-out R2 {r2}, 95 % of errors below {error} {load.unit}, "
            f"{share} of the samples within the range of the calibration"
        )
    ranges = [_range_of(load.model) for load in _one_per_calibration(loads.values())]
    return {
        "SOFTWARE": [f"tepsipe {__version__} compensate"],
        "RECORDING": [f"{path.name}, SHA-256 {hashlib.sha256(path.read_bytes()).hexdigest()}"],
        "MODELS": [f"{models.name}, SHA-256 {hashlib.sha256(models.read_bytes()).hexdigest()}"],
        "LOADS": lines,
        "CALIBRATION": ranges,
    }


def _pressure(file: BeltFile, loads: Mapping[str, CompensatedLoad]) -> dict[str, tuple[float, float]]:
    """Plate -> median shift of the centre of pressure and median half-width of its 95 % interval (m)."""
    found = {}
    for number, plate in enumerate(file.plates, start=1):
        own = {k: loads.get(f"plate {number} {k}") for k in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")}
        if plate.fault is not None or not any(own.values()):
            continue
        up = DIRECTIONS[file.up]
        before = np.hstack([plate.force, plate.moment])
        zero = np.zeros(before.shape[0])
        removed = np.column_stack([zero if one is None else one.removed for one in own.values()])
        half = np.column_stack(
            [zero if one is None or one.half_width is None else one.half_width for one in own.values()]
        )
        height = 0.0 if plate.corners is None else float((plate.corners @ up).mean())
        loaded = np.minimum(before[:, :3] @ up, (before - removed)[:, :3] @ up) > 10.0 * LEAST_LOAD_N
        if not loaded.any():
            continue
        places = [_centre(x[loaded], up, height) for x in (before, before - removed)]
        # p = up x M / F: both errors count, of the force at its distance from the origin
        vertical = np.abs((before - removed)[loaded, :3] @ up)
        moment = np.sqrt((half[loaded, 3:] ** 2).sum(axis=1)) / vertical
        force = np.abs(half[loaded, :3] @ np.abs(up)) * np.linalg.norm(places[1], axis=1) / vertical
        shift = float(np.median(np.linalg.norm(places[1] - places[0], axis=1)))
        found[f"plate {number}"] = shift, float(np.median(np.hypot(moment, force)))
    return found


def _centre(wrench: np.ndarray, up: np.ndarray, height: float) -> np.ndarray:
    """Centre of pressure (m), shape (n, 3), of force and moment about the origin, on a level surface."""
    force, surface = wrench[:, :3], height * up
    return centre_of_pressure(force, wrench[:, 3:] - np.cross(surface, force), up) + surface
