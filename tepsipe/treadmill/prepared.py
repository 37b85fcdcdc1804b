"""Preparation of a trial on the treadmill: one filter, perturbations, rest, and loads of the plate.

Every analysis of such a trial starts here. The perturbations are found in the measured belt velocity, not in
the commanded one.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.io.trial import Trial
from tepsipe.signals.perturbations import (
    Perturbation,
    WindowOptions,
    filtered_perturbations,
    rest_samples,
    unperturbed_samples,
)

# filters a signal, given with its rate (Hz)
Filter = Callable[[np.ndarray, float], np.ndarray]


@dataclass(frozen=True)
class PreparedTrial:
    """A trial on the treadmill, its filter, its perturbations and its rest."""

    trial: Trial
    """Signals as ingested."""
    name: str
    """Names the trial in messages."""
    lowpass: Filter
    """Filter of all signals; takes a signal and its rate (Hz)."""
    belt_velocity: Annotated[np.ndarray, "(n,)", "m/s"]
    """Filtered velocity of the belt."""
    perturbations: list[Perturbation]
    """Their positions (samples)."""
    at_rest: np.ndarray
    """Samples at rest."""

    @property
    def time(self) -> np.ndarray:
        """Instants (s), shape (n,)."""
        return self.trial.time

    @property
    def rate_hz(self) -> float:
        """Sampling rate (Hz)."""
        return self.trial.rate_hz

    @property
    def markers(self) -> list[str]:
        """Names of the markers, in the order of their positions (m)."""
        return self.trial.axes["marker"].tolist()

    @property
    def onsets(self) -> tuple[int, ...]:
        """First samples of the perturbations."""
        return tuple(p.start for p in self.perturbations)

    def filtered(self, x: np.ndarray) -> np.ndarray:
        """``x``, shape (n, ...), behind the filter (unit of ``x``)."""
        return self.lowpass(x, self.rate_hz)

    def from_rest(self, x: np.ndarray) -> np.ndarray:
        """``x``, shape (n,) or (n, c), less the straight line through its samples at rest (unit of ``x``)."""
        return zero_line(x, self.time, self.at_rest)

    def behind(self, lowpass: Filter) -> "PreparedTrial":
        """The same perturbations and rest (samples) with another filter of all signals."""
        velocity = lowpass(self.trial.values("belt_velocity"), self.rate_hz)
        return replace(self, lowpass=lowpass, belt_velocity=velocity)

    def load(self, belt: str) -> dict[str, np.ndarray]:
        """Fy, Fz (N) and Mx (N·m) of one belt, or of ``both`` together, filtered, each of shape (n,)."""
        belts = self.trial.axes["belt"].tolist()
        if belt == "both":
            left, right = self.load("left"), self.load("right")
            return {key: x + right[key] for key, x in left.items()}
        if belt not in belts:
            raise InputError(
                f"{self.name}: expected forces of the belt {belt!r}, found {listed(belts)}: "
                "correct plate_treadmill.belt"
            )
        return {key: self.filtered(x) for key, x in self._load_as_recorded(belt).items()}

    def _load_as_recorded(self, belt: str) -> dict[str, np.ndarray]:
        column = self.trial.axes["belt"].tolist().index(belt)
        force, moment = (self.trial.values(name)[:, column].astype(float) for name in ("force", "moment"))
        return {"Fy": force[:, 1], "Fz": force[:, 2], "Mx": moment[:, 0]}

    def as_recorded(self, belts: Sequence[str], labels: Sequence[str]) -> dict[str, np.ndarray]:
        """Loads of belts (N, N·m) and positions of markers along the belt (m) before the filter, by name."""
        along = self.trial.values("marker_position")[:, :, 1].astype(float)
        signals = {label: along[:, self.markers.index(label)] for label in labels}
        loads = ((belt, key, x) for belt in belts for key, x in self._load_as_recorded(belt).items())
        return signals | {f"{key} of the {belt} belt": x for belt, key, x in loads}

    def load_from_rest(self, belt: str) -> dict[str, np.ndarray]:
        """`load` (N, N·m), zero at rest but for Fz, each of shape (n,)."""
        load = self.load(belt)
        zeroed = {key: self.from_rest(x) for key, x in load.items()}
        # the vertical force keeps the weight on the plate, only its drift is removed
        return zeroed | {"Fz": zeroed["Fz"] + load["Fz"][self.at_rest].mean()}


def prepare_trial(
    trial: Trial, name: str, lowpass: Filter, window: WindowOptions, quiet_after_s: float | None = None
) -> PreparedTrial:
    """Filter the belt of a trial and find its perturbations and its rest.

    trial: ``belt_velocity``, and whatever the analysis needs.
    name: names the trial in messages.
    lowpass: filter of all signals; takes a signal and its rate.
    window: search for perturbations and rest.
    quiet_after_s: for a person, who never rests: all time counts as rest that is far from perturbations, by
    this after them (s). Otherwise it is the first and the last rest.
    """
    velocity = lowpass(trial.values("belt_velocity"), trial.rate_hz)
    perturbations = filtered_perturbations(velocity, trial.rate_hz, window, name)
    if quiet_after_s is None:
        at_rest = rest_samples(trial.time, window)
    else:
        margin_s = window.rest_margin_s
        at_rest = unperturbed_samples(
            trial.time.size, trial.rate_hz, perturbations, margin_s, quiet_after_s, name
        )
    return PreparedTrial(trial, name, lowpass, velocity, perturbations, at_rest)


def zero_line(x: np.ndarray, time: np.ndarray, at_rest: np.ndarray) -> np.ndarray:
    """``x`` less the straight line through its samples at rest, shape (n,) or (n, c) (unit of ``x``)."""
    basis = np.column_stack([np.ones_like(time), (time - time.mean()) / np.ptp(time)])
    return x - basis @ np.linalg.lstsq(basis[at_rest], x[at_rest], rcond=None)[0]
