"""Conversion of a trial to the input of the treadmill models: one recording per component of the load.

On the force plate the components are the fore-aft force Fy (N) and the moment Mx (N·m) about the plate's
x axis, both of the perturbed belt. Because transducers drift, a straight line through the rest before
the first and after the last perturbation is subtracted.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.io.trial import Trial
from tepsipe.signals.differentiation import degree_at, derivative
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.signals.time_alignment import marker_delay
from tepsipe.treadmill.options import Weight
from tepsipe.treadmill.prepared import PreparedTrial, prepare_trial
from tepsipe.treadmill.recording import BeltRecording

# the moment first: it identifies the frame with which the force is fitted
COMPONENTS = {"Mx": "Nm", "Fy": "N"}
OTHER = {"Mx": "Fy", "Fy": "Mx"}
# the zero of a pulse is the mean load over this time, but at most over half the time since the last pulse,
# until so long before the pulse (s)
ZERO_BEFORE_S, ZERO_GAP_S = 1.0, 0.04


@dataclass(frozen=True)
class PlateOptions:
    """Options for the recordings of the force plate."""

    belt: str
    """The belt that is perturbed, left or right."""
    lowpass: Lowpass
    """Filter of all signals."""
    detection: Lowpass
    """Filter of the belt velocity for the detection: onsets must not depend on ``lowpass``."""
    window: WindowOptions
    """Search for perturbations and rest (s)."""
    segment_s: float
    """Length of the segments that start with the perturbations."""
    weight_motion: str = "belt"
    """{"markers", "belt"}: Source of the weight's motion. Markers, differentiated twice, are noisy and may
    lag behind the force; a weight that does not slip moves with the logged velocity of the belt."""

    @classmethod
    def from_settings(cls, belt: str, analysis: dict, lowpass: Lowpass, weight_motion: str = "belt") -> Self:
        """Options of a study, whose first filter finds the perturbations."""
        detection, window = plate_filters(analysis)[0], WindowOptions(**analysis["window"])
        return cls(belt, lowpass, detection, window, analysis["segment_s"], weight_motion)


def plate_filters(analysis: dict) -> list[Lowpass]:
    """Zero-lag filters of ``cutoffs_hz`` (Hz) and ``lowpass_order``."""
    return [Lowpass(cutoff, analysis["lowpass_order"], True) for cutoff in analysis["cutoffs_hz"]]


def plate_recordings(
    trial: Trial, name: str, condition: str, options: PlateOptions, weight: Weight | None
) -> dict[str, BeltRecording]:
    """Fy and Mx of a trial with the empty belt, or with a weight on it.

    The load of the weight follows from its motion by thesis eq (3-10) and the same for the moment:

        Fy = M y'',    Mx = M g y - h M y''

    trial: ``force``, ``moment``, ``belt_velocity``; with a weight ``marker_position``.
    weight: body on the belt; None for an empty belt.
    Returns: component -> recording (N, N·m); all samples of the segments are evaluated.
    """
    prepared = prepare_trial(trial, name, options.detection, options.window).behind(options.lowpass)
    time, onsets = prepared.time, prepared.onsets
    length = round(options.segment_s * prepared.rate_hz)
    if onsets[-1] + length > time.size or min(np.diff(onsets), default=length) < length:
        raise InputError(
            f"{name}: expected {options.segment_s:g} s between perturbations and after the last, found less: "
            "decrease segment_s or window_s in the configuration"
        )
    evaluated = np.zeros(time.size, dtype=bool)
    for onset in onsets:
        evaluated[onset : onset + length] = True
    measured = prepared.load_from_rest(options.belt)
    carried = {component: np.zeros(time.size) for component in COMPONENTS}
    if weight is not None:
        y = prepared.from_rest(_weight_position(prepared, options.weight_motion))
        degree = degree_at(prepared.rate_hz)
        inertia = weight.mass_kg * derivative(time, derivative(time, y, degree), degree)
        carried["Fy"] = inertia
        carried["Mx"] = weight.mass_kg * weight.gravity_m_per_s2 * y - weight.com_height_m * inertia
    induced = {component: measured[component] - carried[component] for component in COMPONENTS}
    mass_kg, height_m = (0.0, 0.0) if weight is None else (weight.mass_kg, weight.com_height_m)
    return {
        component: replace(
            recording,
            condition=condition,
            carried=carried[component],
            rigid_kg=mass_kg,
            rigid_height_m=height_m,
            evaluated=evaluated,
            beside=measured[OTHER[component]],
            beside_carried=carried[OTHER[component]],
        )
        for component, recording in recordings_of_loads(prepared, induced, mass_kg).items()
    }


def zeroed_per_pulse(recording: BeltRecording) -> BeltRecording:
    """The recording with the mean load before each pulse subtracted.

    Transducers drift, and the friction of a belt with memory leaves a force behind that lasts until the
    next pulse. Both are constant within a pulse.

    recording: A trial with separate pulses; others are returned unchanged (units in the class).
    """
    load = recording.load.copy()
    gap = round(ZERO_GAP_S * recording.rate_hz)
    starts = [0, *recording.onsets]
    for k, onset in enumerate(recording.onsets, start=1):
        longest = min(round(ZERO_BEFORE_S * recording.rate_hz), (onset - starts[k - 1]) // 2)
        end = max(1, onset - gap)
        zero = recording.load[max(0, end - longest) : end].mean()
        first = 0 if k == 1 else onset
        last = starts[k + 1] if k + 1 < len(starts) else load.size
        load[first:last] -= zero
    return replace(recording, load=load)


def recordings_of_loads(
    prepared: PreparedTrial, loads: dict[str, np.ndarray], carried_kg: float
) -> dict[str, BeltRecording]:
    """Recordings of the loads of a trial with the motion of its belt.

    prepared: the trial with the filter of the loads.
    loads: component -> belt-induced load, or load of a subject and belt (N, N·m).
    carried_kg: mass that presses on the belt.
    Returns: component -> recording (N, N·m), evaluated throughout, without a known load.
    """
    velocity = prepared.from_rest(prepared.belt_velocity)
    acceleration = derivative(prepared.time, velocity, degree_at(prepared.rate_hz))
    raw_velocity = prepared.from_rest(prepared.trial.values("belt_velocity"))
    return {
        component: BeltRecording(
            name=prepared.name,
            condition=prepared.name,
            rate_hz=prepared.rate_hz,
            velocity=velocity,
            acceleration=acceleration,
            raw_velocity=raw_velocity,
            load=loads[component],
            carried=np.zeros(velocity.size),
            carried_kg=carried_kg,
            unit=unit,
            evaluated=np.ones(velocity.size, dtype=bool),
            onsets=prepared.onsets,
            lowpass=prepared.lowpass,
            beside=loads[OTHER[component]],
            beside_carried=np.zeros(velocity.size),
        )
        for component, unit in COMPONENTS.items()
    }


def _weight_position(prepared: PreparedTrial, weight_motion: str) -> np.ndarray:
    """Position of the weight along the belt (m), shape (n,)."""
    if weight_motion == "markers":
        return _marker_position(prepared)
    velocity = prepared.from_rest(prepared.belt_velocity)
    return scipy.interpolate.CubicSpline(prepared.time, velocity).antiderivative()(prepared.time)


def _marker_position(prepared: PreparedTrial) -> np.ndarray:
    """Mean position of all markers along the belt (m), shape (n,)."""
    markers = prepared.trial.values("marker_position")[:, :, 1].astype(float)
    return prepared.filtered(markers.mean(axis=1))


def marker_lag(trial: Trial, name: str, options: PlateOptions) -> float:
    """Time by which the weight's markers lag behind the logged belt (s)."""
    prepared = prepare_trial(trial, name, options.detection, options.window).behind(options.lowpass)
    velocity = prepared.from_rest(prepared.belt_velocity)
    return marker_delay(prepared.time, _marker_position(prepared), velocity, name)


def table_recording(trial: Trial, name: str, trimmed_s: float) -> BeltRecording:
    """The recording of a treadmill's load and belt velocity in a table.

    The acceleration is the central difference of the velocity, as in Hnat & van den Bogert (2014).

    trial: ``load`` (N or N·m) and ``belt_velocity``.
    trimmed_s: time at both ends that is neither fitted nor evaluated (s), because of filter transients.
    """
    velocity, load = trial.values("belt_velocity"), trial.values("load")
    margin = round(trimmed_s * trial.rate_hz)
    evaluated = np.zeros(load.size, dtype=bool)
    evaluated[margin : load.size - margin] = True
    return BeltRecording(
        name=name,
        condition=name,
        rate_hz=trial.rate_hz,
        velocity=velocity,
        acceleration=np.gradient(velocity, 1.0 / trial.rate_hz),
        raw_velocity=velocity,
        load=load,
        carried=np.zeros(load.size),
        carried_kg=0.0,
        unit=trial.signals["load"].unit,
        evaluated=evaluated,
    )
