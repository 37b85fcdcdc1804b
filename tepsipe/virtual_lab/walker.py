"""Walking person whose strides are real and whose responses to belt pulses are simulated.

Unperturbed walking is resampled from a recording: blocks of consecutive strides, so that the correlation
from stride to stride stays, joined in late swing. A pulse of the belt rotates the ankle into dorsiflexion by
a minimum-jerk ramp, and the response of the ankle is

    dM = -[ I dtheta'' + B(t) dtheta' + K(t) dtheta ] + reflex,

added to the force plate's signals together with the inertia of the foot. The reflex is a
critically damped twitch, driven by the velocity of the stretch after the latency.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
import scipy
from annotated_types import Ge, Le

from tepsipe.quantities import (
    AddedStiffness,
    Damping,
    Height,
    Inertia,
    Length,
    NotNegative,
    Percent,
    Several,
    Time,
)

FINE_HZ = 1000.0
BEFORE_STRIKE_S = 0.12  # strides are joined so long before the heel strike
FADE_S = 0.06
BLOCK = 5  # consecutive strides that are drawn together
HOLD_S = 0.25  # time from the onset of a ramp to its way back


@dataclass(frozen=True)
class Joint:
    """Truth of the ankle."""

    phase_percent: Several[Percent] = (0.0, 20.0, 40.0, 60.0, 80.0, 95.0, 100.0)
    """Knots over stance."""
    stiffness_Nm_per_rad: Several[AddedStiffness] = (40.0, 100.0, 180.0, 280.0, 400.0, 440.0, 300.0)
    """*K* at the knots."""
    damping_Nms_per_rad: Several[Damping] = (0.8, 1.0, 1.5, 2.0, 2.5, 2.5, 2.0)
    """*B* at the knots."""
    inertia_kgm2: Inertia = 0.012
    """*I*."""
    reflex_Nms_per_rad: NotNegative = 25.0
    """Reflex moment per velocity of the stretch."""
    latency_s: Annotated[float, Ge(0), Le(10)] = 0.052
    """First reflex."""
    twitch_s: Time = 0.06
    """Time to the peak of a twitch."""
    foot_mass_kg: Annotated[float, Ge(0), Le(50)] = 1.15
    """Mass of the foot."""
    foot_depth_m: Height = 0.06
    """Its centre of mass below the ankle."""
    shank_m: Length = 0.43
    """Displacement of the belt per rotation of the ankle."""
    vertical_per_moment: Annotated[float, "1/m"] = 0.5
    """Change of the vertical force with the moment."""
    anterior_per_moment: Annotated[float, "1/m"] = 1.1
    """Change of the anterior force with the moment."""

    def stiffness(self, percent: np.ndarray) -> np.ndarray:
        """K (N·m/rad) at phases of stance (%)."""
        return scipy.interpolate.PchipInterpolator(self.phase_percent, self.stiffness_Nm_per_rad)(percent)

    def damping(self, percent: np.ndarray) -> np.ndarray:
        """B (N·m·s/rad) at phases of stance (%)."""
        return scipy.interpolate.PchipInterpolator(self.phase_percent, self.damping_Nms_per_rad)(percent)


@dataclass(frozen=True)
class Walk:
    """A walk on a regular clock."""

    rate_hz: float
    signals: Mapping[str, np.ndarray]
    """angle (rad), vertical, anterior, other_vertical (N), cop, ankle_x, ankle_y (m) and any others."""
    heel_strikes: Annotated[np.ndarray, "(k,)", "s"]
    toe_offs: Annotated[np.ndarray, "(k,)", "s"]
    """Events."""
    onsets: Annotated[np.ndarray, "s"] = field(default_factory=lambda: np.zeros(0))
    """Onsets of pulses."""


def resample_walk(walk: Walk, strides: int, rng: np.random.Generator) -> Walk:
    """A longer walk of blocks of consecutive strides.

    walk: real one, each heel strike followed by its toe-off and the next heel strike.
    Returns: as many strides as asked for, and a part of a stride before and after.
    """
    rate, lead = walk.rate_hz, round(BEFORE_STRIKE_S * walk.rate_hz)
    last = len(walk.heel_strikes) - 1
    firsts = rng.integers(0, last - BLOCK + 1, size=strides // BLOCK + 1)
    drawn = (firsts[:, None] + np.arange(BLOCK)).ravel()[: strides + 1]
    at = np.round(walk.heel_strikes * rate).astype(int)
    fade = round(FADE_S * rate)
    rise = 0.5 - 0.5 * np.cos(np.pi * (np.arange(fade) + 0.5) / fade)
    pieces, heel, toe, written = [], [], [], 0
    names = list(walk.signals)
    all_signals = np.stack([walk.signals[name] for name in names])
    for k, base in enumerate(drawn):
        first, end = at[base] - lead, at[base + 1] - lead
        piece = all_signals[:, first:end].copy()
        if k and base != drawn[k - 1] + 1:  # the end of the last stride fades into this one
            before = at[drawn[k - 1] + 1] - lead
            piece[:, :fade] = (1.0 - rise) * all_signals[:, before : before + fade] + rise * piece[:, :fade]
        offset = walk.heel_strikes[base] - at[base] / rate
        heel.append((written + lead) / rate + offset)
        toe.append(heel[-1] + walk.toe_offs[base] - walk.heel_strikes[base])
        pieces.append(piece)
        written += end - first
    joined = np.concatenate(pieces, axis=1)
    return Walk(rate, dict(zip(names, joined, strict=True)), np.array(heel), np.array(toe[:-1]))


def ramp(time: np.ndarray, duration_s: float) -> np.ndarray:
    """Minimum-jerk ramp from 0 to 1, held, and back within 0.2 s, over the time after its onset (s)."""
    up, down = np.clip(time / duration_s, 0.0, 1.0), np.clip((time - HOLD_S) / 0.2, 0.0, 1.0)
    return _minimum_jerk(up) - _minimum_jerk(down)


def _minimum_jerk(s: np.ndarray) -> np.ndarray:
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def pulse(
    joint: Joint, percent: Annotated[float, "%"], stance_s: float, amplitude_rad: float, duration_s: float
) -> dict[str, np.ndarray]:
    """Response to one pulse at 1 kHz, from the onset until 0.5 s later.

    percent: phase of the onset.
    stance_s: duration of stance.
    amplitude_rad: Dorsiflexion.
    duration_s: duration of the ramp.
    Returns: time (s), angle (rad), joint_moment and moment on the plate (N·m), belt displacement (m) and
    acceleration (m/s2).
    """
    time = np.arange(round(0.5 * FINE_HZ)) / FINE_HZ
    angle = -amplitude_rad * ramp(time, duration_s)
    rate = np.gradient(angle, time)
    acceleration = np.gradient(rate, time)
    phase = np.minimum(percent + 100.0 * time / stance_s, joint.phase_percent[-1])
    stretch = np.interp(time - joint.latency_s, time, np.maximum(-rate, 0.0), left=0.0)
    twitch = time / joint.twitch_s**2 * np.exp(-time / joint.twitch_s)
    reflex = joint.reflex_Nms_per_rad * np.convolve(stretch, twitch)[: time.size] / FINE_HZ
    intrinsic = (
        joint.inertia_kgm2 * acceleration + joint.damping(phase) * rate + joint.stiffness(phase) * angle
    )
    displacement = joint.shank_m * angle
    foot = joint.foot_mass_kg * joint.foot_depth_m * joint.shank_m * acceleration
    joint_moment = reflex - intrinsic
    return {
        "time": time,
        "angle": angle,
        "joint_moment": joint_moment,
        "moment": joint_moment + foot,
        "displacement": displacement,
        "acceleration": joint.shank_m * acceleration,
    }


def perturb(
    walk: Walk,
    joint: Joint,
    strides: Mapping[int, float],
    amplitude_rad: float,
    duration_s: float,
    angle_noise_rad: float,
    rng: np.random.Generator,
) -> Walk:
    """Add pulses to some strides of a walk.

    strides: stride -> phase of its pulse (%); beyond 100 the foot is in the air, and the belt moves without
    it.
    amplitude_rad: Dorsiflexion.
    duration_s: duration of the ramp.
    angle_noise_rad: standard deviation of white noise of the angle.
    Returns: with pulses and their onsets.
    """
    signals = {name: np.array(values) for name, values in walk.signals.items()}
    stance = float(np.mean(walk.toe_offs - walk.heel_strikes[: len(walk.toe_offs)]))
    time = np.arange(signals["angle"].size) / walk.rate_hz
    added = {
        percent: pulse(joint, min(percent, 100.0), stance, amplitude_rad, duration_s)
        for percent in set(strides.values())
    }
    onsets = []
    for number, percent in sorted(strides.items()):
        onset = walk.heel_strikes[number] + percent / 100.0 * stance
        if percent < 100.0:
            _add(signals, time, onset, added[percent], joint)
        onsets.append(onset)
    signals["angle"] = signals["angle"] + rng.normal(0.0, angle_noise_rad, time.size)
    return Walk(walk.rate_hz, signals, walk.heel_strikes, walk.toe_offs, np.array(onsets))


def _add(signals: dict, time: np.ndarray, onset: float, added: dict, joint: Joint) -> None:
    """Add one pulse in place, by the forces and the centre of pressure that make its moment."""
    first, last = np.searchsorted(time, [onset, onset + added["time"][-1]])
    span = slice(first, last)
    values = {name: np.interp(time[span] - onset, added["time"], x) for name, x in added.items()}
    loaded = signals["vertical"][span] > 60.0
    joint_moment = values["joint_moment"] * loaded
    vertical, anterior = signals["vertical"][span], signals["anterior"][span]
    height, lever = signals["ankle_y"][span], signals["cop"][span] - signals["ankle_x"][span]
    moment = vertical * lever + anterior * height + values["moment"]
    new_vertical = vertical + joint.vertical_per_moment * joint_moment
    new_anterior = (
        anterior + joint.anterior_per_moment * joint_moment + joint.foot_mass_kg * values["acceleration"]
    )
    signals["angle"][span] += values["angle"]
    signals["ankle_x"][span] += values["displacement"]
    cop = signals["ankle_x"][span] + (moment - new_anterior * height) / np.where(loaded, new_vertical, 1.0)
    signals["cop"][span] = np.where(loaded, cop, signals["cop"][span] + values["displacement"])
    signals["vertical"][span] = np.where(loaded, new_vertical, vertical)
    signals["anterior"][span] = np.where(loaded, new_anterior, anterior)
