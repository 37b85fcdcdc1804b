"""From a trial to the input of the treadmill models: one recording per component of the measured load.

On the force plate the components are the fore-aft force Fy (N) and the moment Mx (N·m) about the plate's
x axis, both of the perturbed belt. Because transducers drift, a straight line through the rest before
the first and after the last perturbation is subtracted.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from tepsipe.errors import InputError, listed
from tepsipe.io.trial import Trial
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions, perturbations_of, rest_samples
from tepsipe.signals.time_alignment import marker_delay
from tepsipe.treadmill.recording import BeltRecording

# the moment first: it identifies the frame with which the force is fitted
COMPONENTS = {"Mx": "Nm", "Fy": "N"}


@dataclass(frozen=True)
class Weight:
    """A rigid body that is fixed to the belt.

    Attributes
    ----------
    mass_kg : float
        Its mass M (kg).
    com_height_m : float
        Height h of its centre of mass over the belt (m).
    gravity_m_per_s2 : float
        Acceleration of gravity g (m/s²).
    """

    mass_kg: float
    com_height_m: float
    gravity_m_per_s2: float


@dataclass(frozen=True)
class PlateOptions:
    """Options for the recordings of the force plate.

    Attributes
    ----------
    belt : str
        The belt that is perturbed, left or right.
    lowpass : Lowpass
        Filter of all signals.
    detection : Lowpass
        Filter of the belt velocity for the detection: onsets must not depend on ``lowpass``.
    window : WindowOptions
        Search for perturbations and rest (s).
    segment_s : float
        Length of the segments that start with the perturbations (s).
    weight_motion : {"markers", "belt"}
        Source of the weight's motion. Markers, differentiated twice, are noisy and may lag behind the
        force; a weight that does not slip moves with the logged velocity of the belt.
    """

    belt: str
    lowpass: Lowpass
    detection: Lowpass
    window: WindowOptions
    segment_s: float
    weight_motion: str = "belt"


def zero_line(x: np.ndarray, time: np.ndarray, at_rest: np.ndarray) -> np.ndarray:
    """``x`` less the straight line through its samples at rest, shape (n,) or (n, c) (unit of ``x``)."""
    basis = np.column_stack([np.ones_like(time), (time - time.mean()) / np.ptp(time)])
    return x - basis @ np.linalg.lstsq(basis[at_rest], x[at_rest], rcond=None)[0]


def plate_recordings(
    trial: Trial, name: str, condition: str, options: PlateOptions, weight: Weight | None
) -> dict[str, BeltRecording]:
    """Fy and Mx of a trial with the empty belt, or with a weight on it.

    The load of the weight follows from its motion by thesis eq (3-10) and the same for the moment:

        Fy = M y'',    Mx = M g y - h M y''

    Parameters
    ----------
    trial : Trial
        ``force`` (N), ``moment`` (N·m), ``belt_velocity`` (m/s); with a weight ``marker_position`` (m).
    name, condition : str
        Name the trial and the belt's motion.
    options : PlateOptions
        Choices (units in their names).
    weight : Weight or None
        Body on the belt (kg, m); None for an empty belt.

    Returns
    -------
    dict of str to BeltRecording
        Component -> recording (N, N·m); all samples of the segments are evaluated.

    Raises
    ------
    InputError
        If no perturbation or no rest is found, a segment is cut off, or the belt is not in the trial.
    """
    time, rate = trial.time, trial.rate_hz
    at_rest = rest_samples(time, options.window)
    moving = options.detection(trial.values("belt_velocity"), rate)
    onsets = tuple(p.start for p in perturbations_of(moving, rate, options.window, name))
    length = round(options.segment_s * rate)
    if onsets[-1] + length > time.size or min(np.diff(onsets), default=length) < length:
        raise InputError(
            f"{name}: expected {options.segment_s:g} s between perturbations and after the last, found less: "
            "decrease segment_s or window_s in the configuration"
        )
    evaluated = np.zeros(time.size, dtype=bool)
    for onset in onsets:
        evaluated[onset : onset + length] = True
    velocity = zero_line(options.lowpass(trial.values("belt_velocity"), rate), time, at_rest)
    measured = measured_load(trial, name, options.belt, options.lowpass, at_rest)
    carried = {component: np.zeros(time.size) for component in COMPONENTS}
    if weight is not None:
        y = zero_line(_weight_position(trial, options, velocity), time, at_rest)
        inertia = weight.mass_kg * derivative(time, derivative(time, y))
        carried["Fy"] = inertia
        carried["Mx"] = weight.mass_kg * weight.gravity_m_per_s2 * y - weight.com_height_m * inertia
    return recordings_of_loads(
        trial,
        name,
        condition,
        options.lowpass,
        at_rest,
        {component: measured[component] - carried[component] for component in COMPONENTS},
        carried,
        0.0 if weight is None else weight.mass_kg,
        evaluated,
        onsets,
    )


def zeroed_per_pulse(recording: BeltRecording, before_s: float = 1.0, gap_s: float = 0.04) -> BeltRecording:
    """The recording with a zero of its own for every pulse: the mean load before it is subtracted.

    Transducers drift, and the friction of a belt with memory leaves a force behind that lasts until the
    next pulse. Both are constant within a pulse.

    Parameters
    ----------
    recording : BeltRecording
        A trial with separate pulses; others are returned unchanged (units in the class).
    before_s, gap_s : float
        The mean is that of ``before_s``, but at most of half the time since the last pulse, until
        ``gap_s`` before the pulse (s).

    Returns
    -------
    BeltRecording
        With another load (unit of the load).
    """
    load = recording.load.copy()
    gap = round(gap_s * recording.rate_hz)
    starts = [0, *recording.onsets]
    for k, onset in enumerate(recording.onsets, start=1):
        longest = min(round(before_s * recording.rate_hz), (onset - starts[k - 1]) // 2)
        end = max(1, onset - gap)
        zero = recording.load[max(0, end - longest) : end].mean()
        first = 0 if k == 1 else onset
        last = starts[k + 1] if k + 1 < len(starts) else load.size
        load[first:last] -= zero
    return replace(recording, load=load)


def recordings_of_loads(
    trial: Trial,
    name: str,
    condition: str,
    lowpass: Lowpass,
    at_rest: np.ndarray,
    loads: dict[str, np.ndarray],
    carried: dict[str, np.ndarray],
    carried_kg: float,
    evaluated: np.ndarray,
    onsets: tuple[int, ...],
) -> dict[str, BeltRecording]:
    """Recordings of the loads of a trial with the motion of its belt.

    Parameters
    ----------
    trial : Trial
        ``belt_velocity`` (m/s).
    name, condition : str
        Name the trial and the belt's motion.
    lowpass : Lowpass
        Filter of the loads.
    at_rest : ndarray of bool, shape (n,)
        Samples at rest (-).
    loads, carried : dict of str to ndarray, shape (n,)
        Component -> measured load less the load carried, and load carried (N, N·m).
    carried_kg : float
        Mass on the belt (kg).
    evaluated : ndarray of bool, shape (n,)
        Samples that are fitted and evaluated (-).
    onsets : tuple of int
        First samples of the perturbations (samples).

    Returns
    -------
    dict of str to BeltRecording
        Component -> recording (N, N·m).
    """
    raw_velocity, rate = trial.values("belt_velocity"), trial.rate_hz
    velocity = zero_line(lowpass(raw_velocity, rate), trial.time, at_rest)
    return {
        component: BeltRecording(
            name=name,
            condition=condition,
            rate_hz=rate,
            velocity=velocity,
            acceleration=derivative(trial.time, velocity),
            raw_velocity=zero_line(raw_velocity, trial.time, at_rest),
            load=loads[component],
            carried=carried[component],
            carried_kg=carried_kg,
            unit=unit,
            evaluated=evaluated,
            onsets=onsets,
            lowpass=lowpass,
        )
        for component, unit in COMPONENTS.items()
    }


def _weight_position(trial: Trial, options: PlateOptions, velocity: np.ndarray) -> np.ndarray:
    if options.weight_motion == "belt":
        return scipy.interpolate.CubicSpline(trial.time, velocity).antiderivative()(trial.time)
    return _marker_position(trial, options.lowpass)


def _marker_position(trial: Trial, lowpass: Lowpass) -> np.ndarray:
    """Mean position of all markers along the belt (m), shape (n,)."""
    markers = trial.values("marker_position")[:, :, 1].astype(float)
    return lowpass(markers.mean(axis=1), trial.rate_hz)


def marker_lag(trial: Trial, name: str, options: PlateOptions) -> float:
    """Time by which the weight's markers lag behind the logged belt (s).

    Raises
    ------
    InputError
        If no rest is found, or the markers do not follow the belt.
    """
    at_rest = rest_samples(trial.time, options.window)
    velocity = options.lowpass(trial.values("belt_velocity"), trial.rate_hz)
    position = _marker_position(trial, options.lowpass)
    return marker_delay(trial.time, position, zero_line(velocity, trial.time, at_rest), name)


def measured_load(
    trial: Trial, name: str, belt: str, lowpass: Lowpass, at_rest: np.ndarray
) -> dict[str, np.ndarray]:
    """Fy, Fz (N) and Mx (N·m) of the perturbed belt, filtered, each of shape (n,); zero at rest but for Fz.

    Raises
    ------
    InputError
        If the belt is not in the trial.
    """
    filtered = filtered_load(trial, name, belt, lowpass)
    zeroed = {key: zero_line(x, trial.time, at_rest) for key, x in filtered.items()}
    # the vertical force keeps the weight on the plate, only its drift is removed
    return zeroed | {"Fz": zeroed["Fz"] + filtered["Fz"][at_rest].mean()}


def filtered_load(trial: Trial, name: str, belt: str, lowpass: Lowpass) -> dict[str, np.ndarray]:
    """Fy, Fz (N) and Mx (N·m) of one belt, filtered, each of shape (n,).

    Raises
    ------
    InputError
        If the belt is not in the trial.
    """
    belts = trial.axes["belt"].tolist()
    if belt not in belts:
        raise InputError(
            f"{name}: expected forces of the belt {belt!r}, found {listed(belts)}: "
            "correct plate_treadmill.belt"
        )
    column = belts.index(belt)
    columns = {
        "Fy": trial.values("force")[:, column, 1],
        "Fz": trial.values("force")[:, column, 2],
        "Mx": trial.values("moment")[:, column, 0],
    }
    return {key: lowpass(x.astype(float), trial.rate_hz) for key, x in columns.items()}


def table_recording(trial: Trial, name: str, trimmed_s: float) -> BeltRecording:
    """The recording of a treadmill's load and belt velocity in a table.

    The acceleration is the central difference of the velocity, as in Hnat & van den Bogert (2014).

    Parameters
    ----------
    trial : Trial
        ``load`` (N or N·m) and ``belt_velocity`` (m/s).
    name : str
        Names the recording.
    trimmed_s : float
        Time at both ends that is neither fitted nor evaluated (s), because of filter transients.

    Returns
    -------
    BeltRecording
        Unfiltered (unit of the load).
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
