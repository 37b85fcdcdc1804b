"""Calibration of a treadmill from two recorded files, for each of their loads."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.experiments.belt.analysis import TreadmillCalibration, calibrate_treadmill
from tepsipe.experiments.belt.files import BeltVelocity, read_belt_file
from tepsipe.signals.notebook_display import new_axes
from tepsipe.treadmill.registry import save_models

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

# shortest table that calibrates (s)
SHORTEST_S = 20.0
# half-width of the 95 % interval over the standard deviation of noise
NORMAL_95 = 1.96


@dataclass(frozen=True)
class FileCalibration:
    """Models of all loads of a treadmill."""

    loads: Mapping[str, TreadmillCalibration]
    """Name of the load -> its models and their scores (unit of the load)."""

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
        if len(self.loads) == 1:
            return next(iter(self.loads.values())).summary(notes=False)
        lines = [f"{'load':<20}{'recommended':<20}{'R2':>8}{'limit':>8}   95 % of errors, R2 on the test"]
        for load, one in self.loads.items():
            model = one.models[one.recommended]
            score = next(s for s in one.scores if s.model == one.recommended)
            constant, relative = model.errors[0]
            lines.append(
                f"{load:<20}{one.recommended:<20}{score.r2:>8.4f}{score.r2_limit:>8.4f}   below "
                f"{constant:.3g} "
                f"{score.unit} and {100.0 * relative:.0f} % of the correction"
            )
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
    velocities: Sequence[BeltVelocity],
    *,
    loads: Sequence[str] = (),
    time: str | None = None,
    load_unit: str = "Nm",
    cutoff_hz: float = 6.0,
    zero_lag: bool = False,
) -> FileCalibration:
    """Fit models of all loads of a file and evaluate them on another.

    train, test: recordings of the unloaded treadmill, of the same kind.
    velocities: source of the belt velocity of each.
    loads, time, load_unit: as for `read_belt_file`.
    cutoff_hz, zero_lag: low-pass of all signals (Hz).
    Returns: models and scores by load (N, N·m).
    """
    files = [
        read_belt_file(path, velocity, loads=loads, time=time, load_unit=load_unit, shortest_s=SHORTEST_S)
        for path, velocity in zip((train, test), velocities, strict=True)
    ]
    training = files[0].recordings(None, cutoff_hz)
    if not training:
        raise InputError(
            f"{train}: expected a load that changes with the belt, found constant ones: record again"
        )
    rate_hz = next(iter(training.values())).rate_hz
    testing = files[1].recordings(rate_hz if files[1].plates else None, cutoff_hz)
    found = {}
    for load, recording in training.items():
        if load not in testing:
            raise InputError(
                f"{test}: expected the load {load!r} of {train.name}, found {listed(testing)} that change: "
                f"record "
                "it, or name the loads of both files (--load)"
            )
        one = calibrate_treadmill(
            recording, testing[load], cutoff_hz=cutoff_hz, order=4 if zero_lag else 2, zero_lag=zero_lag
        )
        named = load if files[0].plates or len(training) > 1 else ""
        beyond = NORMAL_95 * files[1].beyond(load, recording.rate_hz)
        models = {
            name: replace(
                model,
                load=named,
                errors=((float(np.hypot(model.errors[0][0], beyond)), model.errors[0][1]), model.errors[1]),
            )
            for name, model in one.models.items()
        }
        found[load] = replace(one, models=models)
    return FileCalibration(found)
