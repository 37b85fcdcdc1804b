"""The feet as a free body at a high cutoff, and the change of its torque with each source of uncertainty.

The estimator with a free reflex torque uses the first milliseconds of a response, where inertia and
friction of the belt dominate. All signals are low-pass filtered alike at a higher cutoff, and two terms of
the torque are computed in another way than at 20 Hz. The acceleration of the feet comes from the belt's
encoder, because noise grows with frequency. The friction of the belt follows the vertical force at each
instant instead of the weight.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.experiments.standing.free_reflex.joint_centre import hindfoot
from tepsipe.experiments.standing.joint_torque import (
    StandingTrial,
    by_belt,
    recordings_above_rest,
    segment_poses,
)
from tepsipe.experiments.standing.options import Person, StandingOptions
from tepsipe.mechanics.anthropometry import Feet
from tepsipe.mechanics.inverse_dynamics import PlateLoad, standing_torque
from tepsipe.signals.differentiation import degree_at, derivative
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.time_alignment import advanced
from tepsipe.treadmill.compensation import added_per_kg, compensated_draws, compensated_loads
from tepsipe.treadmill.prepared import PreparedTrial
from tepsipe.treadmill.registry import FittedModel
from tepsipe.treadmill.trial_recordings import COMPONENTS

SIGNALS = ("torque", "ankle", "ankle_d")
# soft tissue on the shank: natural frequency (Hz) and damping ratio, as propagated
# (Wakeling & Nigg 2001: 10 to 20 Hz while the muscles are relaxed)
TISSUE_HZ, TISSUE_DAMPING = 12.0, 0.3
# belt speed at which the size of the tissue's motion is stated (m/s)
TISSUE_SPEED = 0.5
STEP_M = 1e-4
# offset to lower and higher frequencies, for the sensitivity to the frequency (Hz)
TISSUE_STEP_HZ = 1.0
# sources of Type B that move the signals, with the unit in which they deviate
SOURCES = (
    "joint_centre_anterior_m",
    "joint_centre_height_m",
    "foot_mass",
    "force_marker_delay_s",
    "skin_m",
    "tissue_hz",
    "marked_rotation",
    "foot_rotation",
    "force_scale",
    "moment_scale",
    "origin_height_m",
    "origin_anterior_m",
    "vertical_leak",
)


@dataclass(frozen=True)
class FreeBody:
    """Feet, plate and joint of one trial, low-pass filtered alike."""

    person: Person
    """Masses and lengths (kg, m)."""
    time: Annotated[np.ndarray, "(n,)", "s"]
    load: PlateLoad
    """Compensated load of the plate (N, N·m)."""
    load_d: PlateLoad
    """Its rate (N/s, N·m/s)."""
    shank: np.ndarray
    foot: np.ndarray
    centre: np.ndarray
    foot_com: np.ndarray
    """Angles, shape (n,) (rad), and positions, shape (n, 2) (m)."""
    belt_dd: Annotated[np.ndarray, "(n,)", "m/s²"]
    """Acceleration of the belt."""
    tissue: Annotated[np.ndarray, "(n, 3)"]
    """Change of the shank's angle (rad/m) and of the centre per metre of motion of the soft tissue."""
    near: tuple[np.ndarray, np.ndarray]
    """The same of soft tissue with a lower and a higher frequency, see `TISSUE_STEP_HZ`, shape (n, 3)."""
    draws: Annotated[np.ndarray, "(draws, n)", "N·m"]
    """Torque for every draw of the treadmill model's constants, relative to the best one."""
    skins_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Motion of the soft tissue that is subtracted if it has the assumed, lower or higher frequency."""

    def signals(self, deviations: Mapping[str, float] | None = None) -> np.ndarray:
        """Torque of both ankles (N·m), ankle angle (rad) and its rate (rad/s), shape (n, 3).

        The motion of the soft tissue is subtracted.

        deviations: source, one of `SOURCES`, -> deviation from what is assumed: of the centre of the joint
        in the shank (m), of the forces' clock (s), of the soft tissue at a pulse of 0.5 m/s (m) and of its
        frequency (Hz), of the place of the plate's axes (m); relative for mass, scales and rotations; part
        of the vertical force in the fore-aft one.
        """
        off = dict.fromkeys(SOURCES, 0.0) | dict(deviations or {})
        skin_m, lower_m, higher_m = self.skins_m
        lower, higher = self.near
        per_hz = (lower_m * lower - higher_m * higher) / (2.0 * TISSUE_STEP_HZ)
        wobble = (off["skin_m"] - skin_m) * self.tissue + off["tissue_hz"] * per_hz
        late = off["force_marker_delay_s"]
        f_y, f_z, m_x = (
            getattr(self.load, key) + late * getattr(self.load_d, key) for key in ("f_y", "f_z", "m_x")
        )
        m_x = (
            (1.0 + off["moment_scale"]) * m_x + off["origin_height_m"] * f_y + off["origin_anterior_m"] * f_z
        )
        f_y = (1.0 + off["force_scale"]) * f_y + off["vertical_leak"] * f_z
        plate = PlateLoad(f_y, (1.0 + off["force_scale"]) * f_z, m_x)
        shank = self.shank + wobble[:, 0]
        sine, cosine = np.sin(self.shank), np.cos(self.shank)
        across, along = off["joint_centre_anterior_m"], off["joint_centre_height_m"]
        shift = np.column_stack([across * cosine + along * sine, along * cosine - across * sine])
        feet = self.person.feet
        scale = 1.0 + off["foot_mass"]
        # the feet move with the belt: their other accelerations are noise at this cutoff
        acceleration = np.column_stack([self.belt_dd, np.zeros_like(self.belt_dd)])
        torque = standing_torque(
            Feet(scale * feet.mass_kg, scale * feet.inertia_kgm2),
            self.person.body.gravity_m_per_s2,
            plate,
            self.centre + shift + wobble[:, 1:],
            self.foot_com,
            acceleration,
            np.zeros_like(self.belt_dd),
        )
        # a foot is not rigid: its markers follow part of the rotation below the ankle
        foot = (1.0 + off["foot_rotation"]) * self.foot
        ankle = (1.0 + off["marked_rotation"]) * (shank - foot)
        degree = degree_at(1.0 / float(self.time[1] - self.time[0]))
        return np.column_stack([torque, ankle, derivative(self.time, ankle, degree)])


def free_body(
    standing: StandingTrial,
    options: StandingOptions,
    lowpass: Lowpass,
    models: dict[str, FittedModel],
    offset_m: Annotated[np.ndarray, "(2,)"],
) -> FreeBody:
    """The feet of a standing person as a free body.

    standing: the trial with the filter of all signals.
    lowpass: filter of all signals here.
    models: component, Fy or Mx -> treadmill model; empty for the loads as measured. For a person with a
    foot on each belt: belt -> the same.
    offset_m: offset of the joint's centre from the assumed one, anterior and longitudinal in the shank.
    """
    prepared = standing.prepared.behind(lowpass)
    time, rate, person, labels = prepared.time, prepared.rate_hz, options.person, prepared.markers
    positions = prepared.filtered(prepared.trial.values("marker_position")[:, :, 1:].astype(float))
    origin = np.asarray(offset_m, dtype=float)
    poses = segment_poses(positions, labels, person, origin) | {
        "foot": hindfoot(positions, labels, person)[0]
    }
    # from where the belt starts: a detected start precedes it by the width of the filter
    onsets = tuple(np.searchsorted(time, standing.onsets_s).tolist())
    degree = degree_at(rate)
    belt_dd = derivative(time, prepared.from_rest(prepared.belt_velocity), degree)
    peak = float(np.abs(standing.belt_velocity).max())
    tissues = []
    for hz in tissue_frequencies():
        shifted = positions.copy()
        shifted[..., 0] += STEP_M * tissue_motion(positions, labels, person, belt_dd, peak, rate, hz)
        shifted_poses = segment_poses(shifted, labels, person, origin)
        changed = [shifted_poses[key] - poses[key] for key in ("shank", "ankle_point")]
        tissues.append(advanced(time, np.column_stack(changed) / STEP_M, standing.delay_s))
    poses = {key: advanced(time, x, standing.delay_s) for key, x in poses.items()}
    height, gravity = poses["ankle_point"][:, 1], person.body.gravity_m_per_s2
    of_plates = by_belt(models, options)
    parts = [
        _plate(prepared, belt, onsets, height, gravity, of_plates.get(belt, {})) for belt in options.belts
    ]
    table = sum(part[0] for part in parts)
    draws = sum(part[1] for part in parts)
    return FreeBody(
        person=person,
        time=time,
        load=PlateLoad(*table.T),
        load_d=PlateLoad(*derivative(time, table, degree).T),
        shank=poses["shank"],
        foot=poses["foot"],
        centre=poses["ankle_point"],
        foot_com=poses["foot_com"],
        belt_dd=belt_dd,
        tissue=tissues[0],
        near=(tissues[1], tissues[2]),
        draws=draws,
    )


def _plate(
    prepared: PreparedTrial,
    belt: str,
    onsets: tuple[int, ...],
    height: np.ndarray,
    gravity_m_per_s2: float,
    models: dict[str, FittedModel],
) -> tuple[np.ndarray, np.ndarray]:
    """Load of the plate of one belt, and torque by every draw of its model relative to the best one.

    ``onsets`` are samples, ``height`` that of the ankle (m). The loads Fy, Fz (N) and Mx (N·m) have the shape
    (n, 3), the torques (draws, n) (N·m).
    """
    loads, still = prepared.load(belt), prepared.at_rest
    used, draws = {c: loads[c] for c in COMPONENTS}, np.empty((0, prepared.time.size))
    if models:
        recordings = {
            component: replace(recording, onsets=onsets)
            for component, recording in recordings_above_rest(prepared, loads, gravity_m_per_s2).items()
        }
        # the constants belong to a frame and to friction, not to a filter
        models = {c: replace(m, lowpass=prepared.lowpass) for c, m in models.items()}
        compensated = compensated_loads(models, recordings)
        by_draw = compensated_draws(models, recordings)
        draws = (by_draw["Mx"] - compensated["Mx"]) + height * (by_draw["Fy"] - compensated["Fy"])
        pressed = loads["Fz"] / gravity_m_per_s2 - recordings["Fy"].carried_kg
        per_kg = added_per_kg(models, recordings)
        used = {c: compensated[c] - pressed * per_kg[c] + loads[c][still].mean() for c in COMPONENTS}
    return np.column_stack([used["Fy"], loads["Fz"], used["Mx"]]), draws


def tissue_frequencies() -> tuple[float, float, float]:
    """Assumed frequency of the soft tissue, and a lower and a higher one (Hz)."""
    return TISSUE_HZ, TISSUE_HZ - TISSUE_STEP_HZ, TISSUE_HZ + TISSUE_STEP_HZ


def tissue_motion(
    positions: Annotated[np.ndarray, "(n, markers, 2)", "m"],
    labels: list[str],
    person: Person,
    belt_dd: Annotated[np.ndarray, "(n,)", "m/s²"],
    peak_m_per_s: float,
    rate_hz: float,
    tissue_hz: float = TISSUE_HZ,
) -> np.ndarray:
    """Motion of the soft tissue along the belt below the shank's own markers, shape (n, markers).

    The tissue is a mass on a spring over the bone, which accelerates like the marker: less near the knee than
    near the ankle. Tissue that accelerates like the belt moves by 1 at `TISSUE_SPEED`. Other markers do not
    move.

    positions: y, z, low-pass filtered.
    belt_dd: acceleration of the belt.
    peak_m_per_s, rate_hz, tissue_hz: largest speed of the belt (m/s), sampling rate, and frequency of the
    soft tissue (Hz).
    """
    width = 2.0 * np.pi * tissue_hz
    numerator, denominator, _ = scipy.signal.cont2discrete(
        ([-1.0], [1.0, 2.0 * TISSUE_DAMPING * width, width**2]), 1.0 / rate_hz, method="bilinear"
    )
    columns = [labels.index(x) for x in person.shank.labels if x not in person.foot.labels]
    time = np.arange(len(belt_dd)) / rate_hz
    driven = np.column_stack([belt_dd, derivative(time, derivative(time, positions[:, columns, 0]))])
    motion = scipy.signal.lfilter(np.ravel(numerator), denominator, driven, axis=0)
    motion *= peak_m_per_s / TISSUE_SPEED / max(float(np.abs(motion[:, 0]).max()), 1e-300)
    by_marker = np.zeros(positions.shape[:2])
    by_marker[:, columns] = motion[:, 1:]
    return by_marker
