"""Calibrate a treadmill from recordings of an unloaded, accelerated belt: arrays in, models out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tepsipe.arguments import (
    changed_options,
    checked,
    described,
    one_of,
    path_of,
    refuse_constant,
    refuse_same,
    regular_rate,
    same_length,
    samples,
    several,
    texts,
)
from tepsipe.errors import InputError, listed, quoted, refuse_other_kind
from tepsipe.signals.array_types import Samples
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.notebook_display import as_html, new_axes
from tepsipe.treadmill.calibration import ModelScore, calibrate, table_plan
from tepsipe.treadmill.options import FRAMES
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.registry import (
    MODEL_MEANINGS,
    FamilyOptions,
    FittedModel,
    calibrated_range,
    evaluate,
    fit_model,
    leaving,
    pick,
    save_models,
)
from tepsipe.treadmill.removal import held_out_errors

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# frames and mean subtraction need pulses of an empty belt and of a weight
UNSUITED = ("mean-subtraction", "loaded-frame", *FRAMES)
# R2 by which a model may fall short of another and still count as good
AS_GOOD = 0.01
SUITED = tuple(name for name in MODEL_MEANINGS if name not in UNSUITED)


def belt_recording(
    time: "Samples",
    load: "Samples",
    belt_velocity: "Samples",
    *,
    unit: str = "Nm",
    name: str = "recording",
    trimmed_s: float = 1.0,
) -> BeltRecording:
    """One recording of an unloaded, accelerated belt, to calibrate or to compensate with.

    Parameters
    ----------
    time : array_like or Signal, shape (n,)
        Instants (s), on a regular clock.
    load : array_like or Signal, shape (n,)
        Measured component of the load (``unit``), not filtered.
    belt_velocity : array_like or Signal, shape (n,)
        Velocity of the belt (m/s), not filtered.
    unit : {"Nm", "N"}
        Unit of the load.
    name : str
        Names the recording in messages and tables.
    trimmed_s : float
        Time at both ends that is neither fitted nor evaluated (s).

    Returns
    -------
    BeltRecording
        Not filtered (``unit``, m/s).

    Raises
    ------
    InputError
        If the signals cannot be used.

    Examples
    --------
    >>> import numpy as np
    >>> from tepsipe import belt_recording
    >>> time = np.arange(0.0, 20.0, 0.01)
    >>> velocity = 1.0 + 0.1 * np.sin(2.0 * np.pi * 1.5 * time)
    >>> load = 3.0 * np.gradient(velocity, time)  # N·m
    >>> recording = belt_recording(time, load, velocity, name="sine")
    >>> recording.name
    'sine'
    """
    name, trimmed_s = checked(name=name, trimmed_s=trimmed_s)
    if not isinstance(unit, str) or unit not in ("Nm", "N"):
        raise InputError(f"{name}: expected a load in Nm or N, found {described(unit)}: convert it")
    time, rate_hz = regular_rate(time, f"{name}: time")
    load = samples(load, unit, f"{name}: load")
    velocity = samples(belt_velocity, "m/s", f"{name}: belt_velocity")
    same_length(time, load=load, belt_velocity=velocity)
    refuse_constant(**{f"{name}: load": load, f"{name}: belt_velocity": velocity})
    refuse_same(**{f"{name}: belt_velocity": velocity, f"{name}: load": load})
    margin = round(trimmed_s * rate_hz)
    evaluated = np.zeros(time.size, dtype=bool)
    evaluated[margin : time.size - margin] = True
    if not evaluated.any():
        raise InputError(
            f"{name}: expected more than {2.0 * trimmed_s:g} s, found {time.size / rate_hz:.3g} s: record "
            f"longer"
        )
    return BeltRecording(
        name=name,
        condition=name,
        rate_hz=rate_hz,
        velocity=velocity,
        acceleration=np.gradient(velocity, 1.0 / rate_hz),
        raw_velocity=velocity,
        load=load,
        carried=np.zeros(load.size),
        carried_kg=0.0,
        unit=unit,
        evaluated=evaluated,
    )


@dataclass(frozen=True, repr=False)
class TreadmillCalibration:
    """Models of the belt-induced load, with scores of their prediction of held-out recordings."""

    models: Mapping[str, FittedModel]
    """Name -> model (unit of the load)."""
    scores: Sequence[ModelScore]
    """One per model and test recording (unit of the load)."""
    tests: Mapping[str, BeltRecording]
    """Name -> test recording, filtered as the models ask (unit of the load)."""
    validated: Mapping[str, float]
    """Name -> R2 in cross-validation within the calibration recordings, of the models that predict the load
    from the belt's motion alone."""

    @property
    def recommended(self) -> str:
        """Name of the simplest model that cross-validation within the calibration finds as good as the best.

        As good is an R2 of at most 0.01 less; no test recording is used. A model that follows the measured
        load (ripple-tracking) is recommended only if it was fitted alone.
        """
        best = max(self.validated.values(), default=0.0)
        alike = [name for name, r2 in self.validated.items() if r2 >= best - AS_GOOD]
        return min(alike, key=lambda name: self.models[name].model.order, default=next(iter(self.models)))

    @property
    def notes(self) -> tuple[str, ...]:
        """One sentence for each test recording outside the calibrated range."""
        ranges = next(iter(self.models.values())).calibrated
        notes = [leaving(test, ranges) for test in self.tests.values()] if ranges is not None else []
        return tuple(note for note in notes if note)

    def compensate(self, recording: BeltRecording, model: str | None = None) -> np.ndarray:
        """Measured load of a recording less the belt-induced load (unit of the load), shape (n,).

        recording: from `belt_recording`, not filtered.
        model: name of the model; `recommended` if left out.
        Returns: the residual load, filtered as in the calibration (unit of the load).
        """
        refuse_other_kind(recording, BeltRecording, "compensate", "belt_recording")
        chosen = self.recommended if model is None else one_of(model, "model", self.models)
        fitted = pick(self.models, chosen)
        return fitted.compensate(recording.filtered(fitted.lowpass))

    def save(self, path: str | Path) -> None:
        """Write the models as JSON, for `load_treadmill_models` (units as in the models' classes)."""
        path = path_of(path)
        if path.is_dir() or not path.parent.is_dir():
            raise InputError(
                f"{path}: expected a file in a folder that exists, found "
                f"{'a folder' if path.is_dir() else 'no such folder'}: choose another path"
            )
        save_models(path, list(self.models.values()))

    def to_frame(self) -> "pd.DataFrame":
        """The scores as a pandas table, one row per model and test (units in the column ``unit``)."""
        import pandas as pd

        return pd.DataFrame([vars(score) for score in self.scores])

    def summary(self, *, notes: bool = True) -> str:
        """Table of the scores, as text (unit of the load), with the notes unless ``notes`` is False."""
        unit = self.scores[0].unit
        lines = [f"{'model':<20}{'test':<20}{'R2':>8}{'limit':>8}{f'RMS before and after ({unit})':>30}"]
        for s in self.scores:
            star = "" if s.converged else " *"
            rms = f"{s.rms_before:.3f} -> {s.rms_after:.3f}"
            lines.append(f"{s.model:<20}{s.test:<20}{s.r2:>8.4f}{s.r2_limit:>8.4f}{rms:>30}{star}")
        lines += self._remarks()
        if notes:
            lines += [f"Note: {note}." for note in self.notes]
        return "\n".join(lines)

    def _remarks(self) -> list[str]:
        lines = [
            "R2: part of the load's variance that is predicted. Limit: R2 of the best linear model of the "
            "belt's acceleration on this recording. It is estimated from the coherence, so that a model may "
            "exceed it slightly."
        ]
        if any(not s.converged for s in self.scores):
            lines.append("* the search ended before it converged")
        if self.validated:
            lines.append(
                f"Recommended: {self.recommended}, the simplest model with an R2 at most {AS_GOOD:g} below "
                f"the highest in cross-validation within the calibration "
                f"({self.validated[self.recommended]:.4f} of {max(self.validated.values()):.4f}). The tests "
                "were not used to choose it."
            )
        if "ripple-tracking" in self.models:
            lines.append(
                "ripple-tracking follows the measured load, so it does not only predict it. Use it with the "
                "empty belt, or with a load whose spectral lines are far from those of the rollers."
            )
        return lines

    def __str__(self) -> str:
        return self.summary()

    def __repr__(self) -> str:
        return f"<TreadmillCalibration: {', '.join(self.models)}; recommended {self.recommended}>"

    def _repr_html_(self) -> str:
        """The scores in a notebook, with a small figure."""
        head = ("model", "test", "R2", "limit", f"RMS before ({self.scores[0].unit})", "RMS after")
        rows = [
            (s.model, s.test, f"{s.r2:.4f}", f"{s.r2_limit:.4f}", f"{s.rms_before:.3f}", f"{s.rms_after:.3f}")
            for s in self.scores
        ]
        return as_html("Models of the belt-induced load", head, rows, self._remarks(), self.notes, self._draw)

    def plot(self, ax: "Axes | None" = None) -> "Figure":
        """Measured load of the first test and its prediction by `recommended`, as a matplotlib figure.

        ax: axes to draw on; by default a new figure (6.4 inches wide).
        Returns: the figure of the axes (size in inches).
        """
        figure, (axis,) = new_axes(ax, 1, (6.4, 4.8))
        self._draw(axis)
        return figure

    def _draw(self, axis: "Axes") -> None:
        recording = next(iter(self.tests.values()))
        model = self.models[self.recommended]
        time = np.arange(recording.load.size) / recording.rate_hz
        span = slice(time.size // 2, time.size // 2 + round(20.0 * recording.rate_hz))
        axis.plot(time[span], recording.load[span], color="0.4", linewidth=1.2, label="measured")
        predicted = model.predict(recording)[span]
        label = f"predicted, {self.recommended}"
        axis.plot(time[span], predicted, color="#c8371b", linewidth=1.0, label=label)
        axis.set(xlabel="Time (s)", ylabel="Load (N·m)" if recording.unit == "Nm" else "Load (N)")
        axis.legend(loc="upper right", frameon=False)


def _recordings(given: object, what: str) -> list[BeltRecording]:
    """Recordings as a list, refused where one is something else."""
    found = several(given)
    found = [given] if found is None else found
    others = [each for each in found if not isinstance(each, BeltRecording)]
    if others or not found:
        raise InputError(
            f"calibrate_treadmill: expected recordings for {what}, found "
            f"{quoted(type(others[0]).__name__ if others else 'none')}: make them with tepsipe.belt_recording"
        )
    return found


def calibrate_treadmill(
    train: BeltRecording | Sequence[BeltRecording],
    test: BeltRecording | Sequence[BeltRecording],
    *,
    models: Sequence[str] = SUITED,
    cutoff_hz: float = 6.0,
    order: int = 2,
    zero_lag: bool = False,
    **options,
) -> TreadmillCalibration:
    """Fit models of the belt-induced load to some recordings and evaluate them on others.

    The defaults follow Hnat and van den Bogert (2014): a causal low-pass of second order at 6 Hz.

    Parameters
    ----------
    train, test : BeltRecording or sequence of BeltRecording
        From `belt_recording`, not filtered (N or N·m, m/s). A recording must not be in both.
    models : sequence of str
        Models to fit (`tepsipe.treadmill.registry.MODEL_MEANINGS`).
    cutoff_hz : float
        Cutoff of the low-pass of all signals (Hz).
    order : int
        Its order, of both passes together if it is zero-lag.
    zero_lag : bool
        Filter forward and backward, or forward only, as in real time.
    **options
        Fields of `FamilyOptions` that differ from the default.

    Returns
    -------
    TreadmillCalibration
        Models and scores (unit of the load).

    Raises
    ------
    InputError
        If a recording cannot be used, is in both groups, or a model or option is unknown.

    Examples
    --------
    >>> import numpy as np
    >>> from tepsipe import belt_recording, calibrate_treadmill
    >>> def recorded(seed):
    ...     rng = np.random.default_rng(seed)
    ...     time = np.arange(0.0, 40.0, 0.01)
    ...     velocity = 1.0 + 0.01 * np.cumsum(rng.standard_normal(time.size)) / 10.0
    ...     load = 3.0 * np.gradient(velocity, time) + 0.1 * rng.standard_normal(time.size)
    ...     return belt_recording(time, load, velocity, name=f"recording {seed}")
    ...
    >>> calibration = calibrate_treadmill(recorded(1), recorded(2), models=["fir"])
    >>> list(calibration.models)
    ['fir']
    """
    training, testing = _recordings(train, "train"), _recordings(test, "test")
    cutoff_hz, order, zero_lag = checked(cutoff_hz=cutoff_hz, order=order, zero_lag=zero_lag)
    names = [r.name for r in (*training, *testing)]
    twice = [name for name in names if names.count(name) > 1]
    same = any(
        a.load.shape == b.load.shape and np.array_equal(a.load, b.load) for a in training for b in testing
    )
    if twice or same:
        raise InputError(
            f"calibrate_treadmill: expected different recordings with names of their own to train and to "
            f"test, "
            f"found {quoted(twice[0]) if twice else 'the same load in both'}: use two separate recordings"
        )
    chosen = [one_of(name, "models", SUITED) for name in dict.fromkeys(texts(models, "models"))]
    if not chosen:
        raise InputError(f"models: expected at least one of {listed(SUITED)}, found none: name one")
    lowpass = Lowpass(cutoff_hz, order, zero_lag)
    group = "+".join(r.name for r in training)
    tests = {r.name: r.filtered(lowpass) for r in testing}
    family = changed_options(FamilyOptions, options, "calibrate_treadmill")
    shortest_s = min(r.load.size / r.rate_hz for r in (*training, *testing))
    if not 8.0 / min(r.rate_hz for r in training) <= family.spectral_segment_s <= 0.5 * shortest_s:
        raise InputError(
            f"spectral_segment_s: expected from 8 samples to half a recording of {shortest_s:.3g} s, found "
            f"{family.spectral_segment_s:g} s: change it, or record longer"
        )
    calibrating = [r.filtered(lowpass) for r in training]
    scores, fitted = calibrate(
        table_plan(chosen, group, list(tests)),
        {group: calibrating},
        {name: [r] for name, r in tests.items()},
        "load",
        family,
    )
    ranges = calibrated_range(calibrating)
    r2 = {name: np.mean([s.r2 for s in scores if s.model == name]) for name in chosen}
    kept = {
        model.name: replace(
            model, calibrated=ranges, held_out=float(r2[model.name]), errors=held_out_errors(model, testing)
        )
        for model in fitted
    }
    made = TreadmillCalibration(kept, scores, tests, _cross_validated(chosen, calibrating, family))
    best = {made.recommended: replace(kept[made.recommended], recommended=True)}
    return replace(made, models=kept | best)


def _cross_validated(
    models: Sequence[str], recordings: list[BeltRecording], options: FamilyOptions
) -> dict[str, float]:
    """Mean R2 of each model on parts of the calibration that it was not fitted to.

    The parts are the recordings, or the halves of a single one. Models that use the measured load are left
    out: the load that they predict is known to them.
    """
    parts = [[r] for r in recordings]
    if len(parts) == 1:
        (whole,) = recordings
        inside = np.flatnonzero(whole.evaluated)
        first = np.arange(whole.load.size) < inside[inside.size // 2]
        parts = [[replace(whole, evaluated=whole.evaluated & half)] for half in (first, ~first)]
    options = replace(options, shortest_s=0.0)
    found = {}
    for name in models:
        if name == "ripple-tracking":
            continue
        scores = []
        for k, held_out in enumerate(parts):
            fitted = fit_model(name, [r for j, part in enumerate(parts) if j != k for r in part], options)
            scores.append(evaluate(fitted, held_out).r2)
        found[name] = float(np.mean(scores))
    return found
