"""Calibrate a treadmill from recordings of an unloaded, accelerated belt: arrays in, models out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tepsipe.errors import InputError, listed, quoted
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.units import Samples, regular_rate, same_length, samples
from tepsipe.treadmill.calibration import ModelScore, calibrate, table_plan
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.registry import MODEL_MEANINGS, FamilyOptions, FittedModel, pick, save_models

# frames and mean subtraction need pulses of an empty belt and of a weight
UNSUITED = ("mean-subtraction", "loaded-frame", "bristle-frame")
SUITED = tuple(name for name in MODEL_MEANINGS if name not in UNSUITED)


def belt_recording(
    time: Samples,
    load: Samples,
    belt_velocity: Samples,
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
    """
    if unit not in ("Nm", "N"):
        raise InputError(f"{name}: expected a load in Nm or N, found {quoted(unit)}: convert it")
    time, rate_hz = regular_rate(time, f"{name}: time")
    load = samples(load, unit, f"{name}: load")
    velocity = samples(belt_velocity, "m/s", f"{name}: belt_velocity")
    same_length(time, load=load, belt_velocity=velocity)
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


@dataclass(frozen=True)
class TreadmillCalibration:
    """Models of the belt-induced load, with scores of their prediction of held-out recordings.

    Attributes
    ----------
    models : mapping of str to FittedModel
        Name -> model (unit of the load).
    scores : sequence of ModelScore
        One per model and test recording (unit of the load).
    tests : mapping of str to BeltRecording
        Name -> test recording, filtered as the models ask (unit of the load).
    """

    models: Mapping[str, FittedModel]
    scores: Sequence[ModelScore]
    tests: Mapping[str, BeltRecording]

    @property
    def best(self) -> str:
        """Name of the model with the highest mean R2 on the tests."""
        mean = {
            name: float(np.mean([score.r2 for score in self.scores if score.model == name]))
            for name in self.models
        }
        return max(mean, key=mean.get)

    def compensate(self, recording: BeltRecording, model: str | None = None) -> np.ndarray:
        """Measured load of a recording less the belt-induced load (unit of the load), shape (n,).

        Parameters
        ----------
        recording : BeltRecording
            From `belt_recording`, not filtered (unit of the load, m/s).
        model : str, optional
            Name of the model; `best` if left out.

        Returns
        -------
        ndarray, shape (n,)
            The residual load, filtered as in the calibration (unit of the load).

        Raises
        ------
        InputError
            If there is no such model, or the recording has another rate or unit.
        """
        fitted = pick(self.models, self.best if model is None else model)
        filtered = recording if fitted.lowpass is None else recording.filtered(fitted.lowpass)
        return fitted.compensate(filtered)

    def save(self, path: str | Path) -> None:
        """Write the models as JSON, for `load_treadmill_models` (units as in the models' classes)."""
        save_models(path, list(self.models.values()))

    def to_frame(self):
        """The scores as a pandas table, one row per model and test (units in the column ``unit``)."""
        import pandas as pd

        return pd.DataFrame([vars(score) for score in self.scores])

    def summary(self) -> str:
        """Table of the scores, as text (unit of the load)."""
        unit = self.scores[0].unit
        lines = [f"{'model':<20}{'test':<20}{'R2':>8}{'limit':>8}{f'RMS before and after ({unit})':>30}"]
        for s in self.scores:
            star = "" if s.converged else " *"
            rms = f"{s.rms_before:.3f} -> {s.rms_after:.3f}"
            lines.append(f"{s.model:<20}{s.test:<20}{s.r2:>8.4f}{s.r2_limit:>8.4f}{rms:>30}{star}")
        lines.append(
            "R2: part of the load's variance that is predicted; limit: the most that a linear model of the "
            "belt's acceleration could reach."
        )
        if any(not s.converged for s in self.scores):
            lines.append("* the search ended before it converged")
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.summary()

    def plot(self):
        """Measured and predicted load of the first test, as a matplotlib figure."""
        import matplotlib.pyplot as plt

        recording = next(iter(self.tests.values()))
        model = self.models[self.best]
        time = np.arange(recording.load.size) / recording.rate_hz
        span = slice(time.size // 2, time.size // 2 + round(20.0 * recording.rate_hz))
        figure, axis = plt.subplots(layout="constrained")
        axis.plot(time[span], recording.load[span], color="0.4", linewidth=1.2, label="measured")
        predicted = model.predict(recording)[span]
        axis.plot(time[span], predicted, color="#c8371b", linewidth=1.0, label=f"predicted, {self.best}")
        axis.set(xlabel="Time (s)", ylabel="Load (N·m)" if recording.unit == "Nm" else "Load (N)")
        axis.legend(loc="upper right", frameon=False)
        return figure


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
    """
    training = [train] if isinstance(train, BeltRecording) else list(train)
    testing = [test] if isinstance(test, BeltRecording) else list(test)
    for recordings, what in ((training, "train"), (testing, "test")):
        if not recordings or not all(isinstance(r, BeltRecording) for r in recordings):
            raise InputError(
                f"calibrate_treadmill: expected recordings for {what}, found "
                f"{quoted(type(recordings[0]).__name__ if recordings else 'none')}: make them with "
                "tepsipe.belt_recording"
            )
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
    for name in models:
        if name not in SUITED:
            raise InputError(
                f"calibrate_treadmill: expected models of {listed(SUITED)}, found {quoted(name)}: correct it"
            )
    known = FamilyOptions.__dataclass_fields__
    for name in options:
        if name not in known:
            raise InputError(
                f"calibrate_treadmill: expected options of {listed(known)}, found {quoted(name)}: correct it"
            )
    lowpass = Lowpass(cutoff_hz, order, zero_lag)
    group = "+".join(r.name for r in training)
    tests = {r.name: r.filtered(lowpass) for r in testing}
    scores, fitted = calibrate(
        table_plan(list(models), group, list(tests)),
        {group: [r.filtered(lowpass) for r in training]},
        {name: [r] for name, r in tests.items()},
        "load",
        FamilyOptions(**options),
    )
    return TreadmillCalibration({model.name: model for model in fitted}, scores, tests)
