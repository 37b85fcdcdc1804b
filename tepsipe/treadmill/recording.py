"""Input of the treadmill models: one load and the motion of the belt, on one clock.

Symbols: v belt velocity (m/s), a belt acceleration (m/s²), L belt-induced load (N or N·m).
"""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.signals.filters import Lowpass


@dataclass(frozen=True, repr=False)
class BeltRecording:
    """One recording of an accelerating belt, all signals with the same filter.

    Attributes
    ----------
    name : str
        Names the recording in messages.
    condition : str
        Name of the belt's motion: recordings of one condition have the same perturbations.
    rate_hz : float
        Sampling rate (Hz).
    velocity, acceleration : ndarray, shape (n,)
        Motion of the belt, v (m/s) and a (m/s²).
    raw_velocity : ndarray, shape (n,)
        Unfiltered velocity of the belt (m/s). Non-linear functions of it, friction and roller angle, are
        computed from it and filtered afterwards.
    load : ndarray, shape (n,)
        Belt-induced load (``unit``): measured load less the load carried.
    carried : ndarray, shape (n,)
        Load carried, known from its own motion (``unit``); zero for an empty belt.
    carried_kg : float
        Mass that presses on the belt (kg), by which its friction grows.
    rigid_kg : float
        Mass of a weight, whose load is ``carried`` and which moves with the frame (kg); 0 under anyone else,
        whose force itself drives the empty frame.
    rigid_height_m : float
        Height of the weight's centre of mass above the belt (m).
    beside, beside_carried : ndarray or None, shape (n,)
        Measured load of the plate's other component, the moment beside the force, and what of it is carried
        (its unit); None where it is not known.
    unit : str
        Unit of the load, N or Nm.
    evaluated : ndarray of bool, shape (n,)
        Samples that are fitted and evaluated.
    onsets : tuple of int
        First samples of the perturbations; empty if the belt is perturbed continuously (samples).
    lowpass : Lowpass or None
        The filter of the signals.
    """

    name: str
    condition: str
    rate_hz: float
    velocity: np.ndarray
    acceleration: np.ndarray
    raw_velocity: np.ndarray
    load: np.ndarray
    carried: np.ndarray
    carried_kg: float
    unit: str
    evaluated: np.ndarray
    onsets: tuple[int, ...] = ()
    lowpass: Lowpass | None = None
    rigid_kg: float = 0.0
    rigid_height_m: float = 0.0
    beside: np.ndarray | None = None
    beside_carried: np.ndarray | None = None

    def __repr__(self) -> str:
        filtered = "not filtered" if self.lowpass is None else f"low-pass {self.lowpass.cutoff_hz:g} Hz"
        return f"<BeltRecording {self.name!r}: {self.load.size} samples at {self.rate_hz:g} Hz, {filtered}>"

    @property
    def position(self) -> np.ndarray:
        """Distance travelled by the belt since the start of the recording (m), shape (n,), not filtered."""
        v = self.raw_velocity
        return np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1])) / self.rate_hz])

    @cached_property
    def raw_acceleration(self) -> np.ndarray:
        """Derivative of ``raw_velocity`` (m/s²), shape (n,), by a cubic spline."""
        time = np.arange(self.raw_velocity.size) / self.rate_hz
        return scipy.interpolate.CubicSpline(time, self.raw_velocity).derivative()(time)

    @cached_property
    def _known(self) -> dict[Hashable, Any]:
        return {}

    def once(self, key: Hashable, compute: Callable[[], Any]) -> Any:
        """Result of ``compute``, cached for this recording and a key that names its other inputs.

        Draws of a model's constants change one at a time, so most intermediate results can be reused. The
        result (unit of ``compute``) is shared and must not be changed.
        """
        if key not in self._known:
            self._known[key] = compute()
        return self._known[key]

    def through_lowpass(self, x: np.ndarray) -> np.ndarray:
        """``x``, shape (n,) or (n, c), filtered like the recording's signals (unit of ``x``)."""
        return x if self.lowpass is None else self.lowpass(x, self.rate_hz)

    def segments(self, x: np.ndarray) -> np.ndarray:
        """Evaluated samples of ``x`` by perturbation, shape (perturbations, w) (unit of ``x``)."""
        length = int(np.argmin(np.append(self.evaluated[self.onsets[0] :], False)))
        length = min([length, *np.diff(self.onsets).tolist()])
        return np.array([x[start : start + length] for start in self.onsets if start + length <= x.size])

    def filtered(self, lowpass: Lowpass | None) -> "BeltRecording":
        """The same recording with all signals filtered (units unchanged), itself without a filter.

        The raw velocity remains unfiltered.

        Raises
        ------
        InputError
            If the cutoff does not suit the rate.
        """
        if lowpass is None:
            return self
        columns = np.column_stack([self.velocity, self.acceleration, self.load, self.carried])
        start = columns[0] * [1.0, 0.0, 0.0, 0.0]
        velocity, acceleration, load, carried = (lowpass(columns - start, self.rate_hz) + start).T
        beside, beside_carried = (
            None if x is None else lowpass(x, self.rate_hz) for x in (self.beside, self.beside_carried)
        )
        return replace(
            self,
            velocity=velocity,
            acceleration=acceleration,
            load=load,
            carried=carried,
            lowpass=lowpass,
            beside=beside,
            beside_carried=beside_carried,
        )


def check_recordings(recordings: list[BeltRecording], shortest_s: float) -> None:
    """Refuse recordings that cannot calibrate a model, in one sentence.

    recordings: recordings to be fitted or evaluated together.
    shortest_s: shortest total time of all evaluated samples.
    """
    if not recordings:
        raise InputError(
            "expected at least one recording to calibrate the treadmill, found none: give a trial the role "
            "'calibrate' in the trial sheet"
        )
    first = recordings[0]
    seconds = sum(recording.evaluated.sum() / recording.rate_hz for recording in recordings)
    if seconds < shortest_s:
        raise InputError(
            f"{first.name}: expected at least {shortest_s:g} s to calibrate or to validate with, found "
            f"{seconds:.3g} s: record longer"
        )
    for recording in recordings:
        if abs(recording.rate_hz - first.rate_hz) > 1e-6 * first.rate_hz:
            raise InputError(
                f"{recording.name}: expected {first.rate_hz:g} Hz, the rate of {first.name}, found "
                f"{recording.rate_hz:g} Hz: resample one of the two recordings"
            )
        if recording.unit != first.unit:
            raise InputError(
                f"{recording.name}: expected the load in {first.unit}, as in {first.name}, found "
                f"{recording.unit}: correct the unit"
            )
        evaluated = recording.evaluated
        for what in ("velocity", "acceleration", "load", "carried"):
            if not np.isfinite(getattr(recording, what)).all():
                raise InputError(
                    f"{recording.name}: expected numbers for {what}, found NaN or infinite samples: fill or "
                    "cut them first"
                )
        for what, x, unit in (
            ("a belt that is accelerated", recording.velocity, "m/s"),
            ("a load that changes", recording.load, recording.unit),
        ):
            if np.ptp(x[evaluated]) <= 1e-9 * max(1.0, np.abs(x[evaluated]).max()):
                raise InputError(
                    f"{recording.name}: expected {what}, found the constant value "
                    f"{x[evaluated][0]:.4g} {unit}: check the column, or that the belt was perturbed"
                )


@dataclass(frozen=True)
class Score:
    """Accuracy of a model's prediction of the belt-induced load."""

    r2: float
    """1 - sum (L - L_model)^2 / sum (L - mean L)^2, as Hnat & van den Bogert (2014) compute it."""
    rms_before: float
    rms_after: float
    """Root mean square of L, and of L - L_model (unit of the load)."""


def score(recordings: list[BeltRecording], predictions: list[np.ndarray]) -> Score:
    """Score of predictions (unit of the load), each of shape (n,), over all evaluated samples."""
    load = np.concatenate([r.load[r.evaluated] for r in recordings])
    residual = load - np.concatenate([p[r.evaluated] for r, p in zip(recordings, predictions, strict=True)])
    total = float(np.sum((load - load.mean()) ** 2))
    return Score(
        1.0 - float(residual @ residual) / total,
        float(np.sqrt(np.mean(load**2))),
        float(np.sqrt(np.mean(residual**2))),
    )
