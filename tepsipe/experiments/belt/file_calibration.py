"""Calibration of a treadmill from two recorded files, for each of their loads."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.experiments.belt.analysis import AS_GOOD, TreadmillCalibration, calibrate_treadmill
from tepsipe.experiments.belt.files import BeltChannels, read_belt_file
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.notebook_display import new_axes
from tepsipe.treadmill.calibration import coherence_limit
from tepsipe.treadmill.options import ModelOptions
from tepsipe.treadmill.registry import save_models

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

# shortest table that calibrates (s)
SHORTEST_S = 20.0
# length of the segments of the coherence (s)
SEGMENT_S = ModelOptions.spectral_segment_s
# half-width of the 95 % interval over the standard deviation of noise
NORMAL_95 = 1.96


@dataclass(frozen=True)
class FileCalibration:
    """Models of all loads of a treadmill."""

    loads: Mapping[str, TreadmillCalibration]
    """Name of the load -> its models and their scores (unit of the load)."""
    left: tuple[str, ...] = ()
    """Loads of force plates of which no linear model explains more than 1 %, by their coherence with the
    acceleration of the belt: they have no models."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on all loads, each once."""
        return tuple(dict.fromkeys(note for one in self.loads.values() for note in one.notes))

    def save(self, path: Path) -> None:
        """Write the models of all loads as JSON (units as in the models' classes)."""
        save_models(path, [model for one in self.loads.values() for model in one.models.values()])

    def to_frame(self) -> "pd.DataFrame":
        """Scores of all models (units in the column ``unit``)."""
        import pandas as pd

        scores = [replace(s, load=load) for load, one in self.loads.items() for s in one.scores]
        return pd.DataFrame([vars(score) for score in scores])

    def summary(self) -> str:
        """Scores as text (unit of the load)."""
        if len(self.loads) == 1 and not self.left:
            return next(iter(self.loads.values())).summary(notes=False)
        lines = [f"{'load':<20}{'recommended':<20}{'R2':>8}{'limit':>8}   95 % of errors"]
        for load, one in self.loads.items():
            model = one.models[one.recommended]
            score = next(s for s in one.scores if s.model == one.recommended)
            constant, relative = model.errors[0]
            lines.append(
                f"{load:<20}{one.recommended:<20}{score.r2:>8.4f}{score.r2_limit:>8.4f}   below "
                f"{constant:.3g} {score.unit} and {100.0 * relative:.0f} % of the correction"
            )
        if self.left:
            lines.append(f"Not induced by the belt, and without a model: {', '.join(self.left)}.")
        return "\n".join(lines)

    def plot(self) -> "Figure":
        """Measured and predicted loads of the test (size in inches)."""
        figure, axes = new_axes(None, len(self.loads), (6.4, 2.4 + 2.4 * len(self.loads)))
        for axis, (load, one) in zip(axes, self.loads.items(), strict=True):
            one.plot(axis)
            if len(self.loads) > 1:
                axis.set_title(load, fontsize="medium", loc="left")
        return figure


def calibrate_files(
    train: Path,
    test: Path,
    channels: Sequence[BeltChannels],
    *,
    cutoff_hz: float = 6.0,
    zero_lag: bool = False,
) -> FileCalibration:
    """Fit models of all loads of a file and evaluate them on another.

    train, test: recordings of the unloaded treadmill, of the same kind.
    channels: what is read of each.
    cutoff_hz, zero_lag: low-pass of all signals (Hz).
    Returns: models and scores by load (N, N·m).
    """
    files = [
        read_belt_file(path, chosen, SHORTEST_S) for path, chosen in zip((train, test), channels, strict=True)
    ]
    train_file, test_file = files
    if not train_file.changing:
        raise InputError(
            f"{train}: expected a load that changes with the belt, found constant ones: record again"
        )
    found, left = {}, []
    lowpass = Lowpass(cutoff_hz, 4 if zero_lag else 2, zero_lag)
    for load in train_file.changing:
        if load not in test_file.changing:
            raise InputError(
                f"{test}: expected the load {load!r} of {train.name}, found {listed(test_file.changing)} "
                "that change: record it, or name the loads of both files (--load)"
            )
        rate_hz = train_file.rate_hz(load, cutoff_hz)
        test_hz = rate_hz if test_file.plates else test_file.loads[load].rate_hz
        training, testing = train_file.recording(load, rate_hz), test_file.recording(load, test_hz)
        if train_file.plates:
            limits = [coherence_limit([r.filtered(lowpass)], SEGMENT_S) for r in (training, testing)]
            if max(limits) < AS_GOOD:
                left.append(load)
                continue
        one = calibrate_treadmill(
            training, testing, cutoff_hz=cutoff_hz, order=lowpass.order, zero_lag=zero_lag
        )
        named = load if train_file.plates or len(train_file.changing) > 1 else ""
        beyond = NORMAL_95 * test_file.beyond(load, test_hz)
        models = {
            name: replace(
                model,
                load=named,
                errors=((float(np.hypot(model.errors[0][0], beyond)), model.errors[0][1]), model.errors[1]),
            )
            for name, model in one.models.items()
        }
        found[load] = replace(one, models=models)
    if not found:
        raise InputError(
            f"{train}: expected a load that follows the acceleration of the belt, found none among "
            f"{listed(left)}: check the belt velocity, and that the belt was accelerated"
        )
    return FileCalibration(found, tuple(left))
