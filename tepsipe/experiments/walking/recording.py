"""Signals of one leg in a walking trial, on one regular clock, and its moment at the ankle.

The moment of the ankle follows from the force of the foot's own belt and the centre of pressure, at the
bandwidth of the force:

    M = F_y (x_cop - x_ankle) + F_x y_ankle

with x forward and y upward, positive in plantarflexion. Gravity and inertia of the foot are left to
`tepsipe.experiments.walking.impedance`, as a deviation of the moment that is known up to the foot's mass.
Moments from gait software are often low-passed at 6 Hz. This removes the pulse, and the scatter of the
strides with it, so the results look better than they are (`bandwidth_hz`).
"""

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.signals.filters import butterworth_lowpass

# of every recording
SIGNALS = ("angle", "vertical", "anterior", "cop", "ankle_x", "ankle_y", "other_vertical")
SEGMENT_S = 5.0  # length of the segments of a spectral estimate
COMPARED_HZ = 6.0  # cutoff of the moments that are compared
CONTACT_N = 30.0  # below this force the centre of pressure is not defined


@dataclass(frozen=True)
class WalkingRecording:
    """One leg in a walking trial."""

    name: str
    """Name of the trial, for messages."""
    rate_hz: float
    """Rate of the regular clock."""
    time: Annotated[np.ndarray, "(n,)", "s"]
    """The clock."""
    angle: Annotated[np.ndarray, "(n,)", "rad"]
    """Angle of the ankle, positive in plantarflexion."""
    vertical: Annotated[np.ndarray, "(n,)", "N"]
    anterior: Annotated[np.ndarray, "(n,)", "N"]
    """Force of the belt on this foot, upward and forward."""
    cop: Annotated[np.ndarray, "(n,)", "m"]
    """Centre of pressure below this foot, forward."""
    ankle_x: Annotated[np.ndarray, "(n,)", "m"]
    ankle_y: Annotated[np.ndarray, "(n,)", "m"]
    """Ankle joint, forward and above the belt."""
    other_vertical: Annotated[np.ndarray, "(n,)", "N"]
    """Force of the belt on the other foot, upward."""
    state: dict[str, np.ndarray] = field(default_factory=dict)
    """Further signals that may foretell a stride, for example the angle of the knee."""
    supplied_moment: Annotated[np.ndarray, "(n,)", "N·m"] | None = None
    """Moment of the ankle as supplied with the recording, positive in plantarflexion."""


def ankle_moment(recording: WalkingRecording) -> np.ndarray:
    """Moment of the ankle from force and centre of pressure, shape (n,), plantarflexion positive (N·m).

    It is not filtered. Without contact (below 30 N) it is zero.
    """
    contact = recording.vertical > CONTACT_N
    lever = recording.cop - recording.ankle_x
    moment = recording.vertical * lever + recording.anterior * recording.ankle_y
    return np.where(contact, moment, 0.0)


def bandwidth_hz(
    moment: Annotated[np.ndarray, "(n,)", "N·m"],
    reference: Annotated[np.ndarray, "(n,)", "N·m"],
    rate_hz: float,
) -> float:
    """Frequency at which a supplied moment has lost half of the power of the reference (Hz).

    The gain is the open-loop spectral estimate from the reference, |S_ry / S_rr|, averaged over three
    lines. Half the rate is returned where the gain stays above 1/sqrt(2).

    reference: moment of full bandwidth, for example `ankle_moment`.
    """
    length = round(SEGMENT_S * rate_hz)
    if moment.size < 4 * length:
        raise InputError(
            f"moment: expected at least {4 * SEGMENT_S:g} s to estimate its bandwidth, found "
            f"{moment.size / rate_hz:.3g} s: record longer"
        )
    frequency, cross = scipy.signal.csd(reference, moment, rate_hz, nperseg=length)
    _, power = scipy.signal.welch(reference, rate_hz, nperseg=length)
    weight = np.ones(3)
    gain = np.abs(np.convolve(cross, weight, "same")) / np.convolve(power, weight, "same")
    beyond = np.flatnonzero((gain < np.sqrt(0.5)) & (frequency > 1.0))
    return float(frequency[beyond[0]]) if beyond.size else 0.5 * rate_hz


def agreement(recording: WalkingRecording, stance: np.ndarray) -> float:
    """RMS difference in stance between the supplied moment and the moment from force and CoP (N·m).

    Both are low-passed alike. A large difference means that this side's moment cannot be reconstructed, for
    example because its centre of pressure or its ankle does not belong to the foot. Do not use it then.

    stance: samples that are compared.
    """
    if recording.supplied_moment is None:
        raise InputError(
            f"{recording.name}: expected a supplied moment of the ankle to compare with, found none: "
            "compare nothing"
        )
    both = np.stack([recording.supplied_moment, ankle_moment(recording)], axis=1)
    filtered = butterworth_lowpass(both, recording.rate_hz, COMPARED_HZ)
    return float(np.sqrt(np.mean(np.diff(filtered[stance], axis=1) ** 2)))
