"""Model of the belt-induced load with friction that remembers: the loaded frame, bristles and a lever.

    F_y = R_M S [ true + m a + c w + (f_0 + f_1 M) w / sqrt(v_0^2 + w^2) + (b_0 + b_1 M) z ],   w = v + T a
    M_x = R_0 [ true + m_x a + c_x v + lever F_friction + x F_true ]
          + h (R_0 - R_M) [ F_true + m a + F_friction ]
    R_0(s) = (1 - p) (1 + d s) / D_0 + p (1 + r d s) / (1 + r d s + r^2 e_0 s^2)
    R_M(s) = R_0 D_0 / D_M,    D_M(s) = 1 + d s + (e_0 + e_1 M) s^2
    S(s) = 1 - k t s / (1 + t s)

R_M is the response to a weight of the mass M, whose load is known as M times the acceleration of the belt,
and which moves with the frame; the transducers measure the force of its springs and dampers. The force that
a person or a dummy exerts on the belt is itself the input of the frame, which is then empty: R_0. A moment
always passes through the empty frame; that of a weight at the height h is known from its own acceleration, of
which the frame's is a part. The friction f_0 + f_1 M grows with all that presses on the belt. What stands on
it moves with the belt and the first mode of the frame, which adds -e_1 s^2 F_y / (R_0 S D_0) to a.

Symbols as in `tepsipe.treadmill.mass_models`; further z, the deflection of the bristles between belt and
deck (`tepsipe.treadmill.pulse_windows`), with the pre-sliding distance d_z, the excess of friction at rest u
and its speed v_s; p the share of a second mode of the frame, p_F of the force and p_M of the moment, r times
slower; lever the height of the friction, all terms of F_y with w and z, about the x axis (m); x cross-talk
from the true fore-aft force to the moment (m). The pulses of all trials are fitted together, force and moment
with one frame. Where this does not explain the calibration, all constants are idle and a response without
physics takes their place, mass by mass (`tepsipe.treadmill.mass_models`).
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, NamedTuple

import numpy as np

from tepsipe.treadmill.black_box_models import BeltModel
from tepsipe.treadmill.mass_models import MassResponse
from tepsipe.treadmill.pulse_windows import (
    Bristles,
    bent_in_turn,
    from_each_pulse,
    held,
    over_line,
    pulses_of,
)
from tepsipe.treadmill.recording import BeltRecording


class Constants(NamedTuple):
    """Constants of the model, the same for fore-aft force and moment.

    All from ``force_mass`` to ``cross_talk_m`` follow from the others by least squares.
    """

    damping_s: float
    slowness_s2: float
    slowness_s2_per_kg: float
    """Frame: d (s), e_0 (s²), e_1 (s²/kg)."""
    second_mode: float
    second_mode_moment: float
    second_slowness: float
    lag_s: float
    friction_speed_m_per_s: float
    """Smooth friction: T (s), v_0 (m/s)."""
    mount_share: Annotated[float, "s"]
    mount_time_s: float
    """Mounts of the transducers: k, t."""
    bristle_m: float
    stribeck: float
    stribeck_speed_m_per_s: float
    force_mass: float = 0.0
    force_viscous: float = 0.0
    friction: float = 0.0
    friction_per_kg: float = 0.0
    bristle: float = 0.0
    bristle_per_kg: float = 0.0
    """Force: m (N over m/s²), c (N over m/s), f_0 (N), f_1 (N/kg), b_0 (N), b_1 (N/kg)."""
    moment_mass: float = 0.0
    moment_viscous: float = 0.0
    lever_m: float = 0.0
    cross_talk_m: float = 0.0
    """Moment: m_x (N·m over m/s²), c_x (N·m over m/s), lever (m), x (m)."""
    response_share: float = 0.0
    """Without physics: deviation of the load's dependence on the mass from that of a rigid weight, as a
    share of it."""

    @property
    def bristles(self) -> Bristles:
        """The bristles (m, -, m/s)."""
        return Bristles(self.bristle_m, self.stribeck, self.stribeck_speed_m_per_s)


# names of the constants in their order
CONSTANTS = Constants._fields
AT = {name: k for k, name in enumerate(CONSTANTS)}
# constants with which neither frame nor friction does anything
IDLE = Constants(
    *[0.0] * 6,
    lag_s=0.0,
    friction_speed_m_per_s=1.0,
    mount_share=0.0,
    mount_time_s=1.0,
    bristle_m=1.0,
    stribeck=0.0,
    stribeck_speed_m_per_s=1.0,
)
# constants on which the response of the frame, the friction and the state of the bristles depend
OF_FRAME = (*CONSTANTS[:6], "mount_share", "mount_time_s")
OF_BRISTLES = ("lag_s", "bristle_m", "stribeck", "stribeck_speed_m_per_s")
# plausible treadmill: resonance (Hz), share of the mounts, lag of the belt (s)
LOWEST_HZ, MOUNT_SHARES, LONGEST_LAG_S = 10.0, (-0.05, 0.9), 0.0199
# factors of the terms of friction: viscous, smooth and of the bristles, each with its share per kilogram
RUBBING = ("force_viscous", "friction", "friction_per_kg", "bristle", "bristle_per_kg")
OF_FRICTION = (*OF_BRISTLES, "friction_speed_m_per_s", *RUBBING)


@dataclass(frozen=True)
class BristleFrame(BeltModel):
    """The model's constants, the same for fore-aft force and moment."""

    component: str
    """{"Fy", "Mx"}: The load that it predicts."""
    constants: Annotated[np.ndarray, "(24,)"]
    """Those of `Constants` in their order."""
    terms: tuple[str, ...]
    """Parts beyond the loaded frame that cross-validation kept, of
    `tepsipe.treadmill.bristle_fit.TERMS`, or ``without-physics``."""
    rate_hz: float
    """Sampling rate of the calibration."""
    heaviest_kg: float
    """Largest mass of the calibration."""
    converged: bool = True
    """Whether the optimisation converged inside its bounds."""
    by_mass: MassResponse | None = None
    """Response without physics, where physics does not explain the calibration."""

    @property
    def holds_errors(self) -> bool:
        """True: it has them from the bootstrap of its calibration and from held-out trials."""
        return True

    @property
    def order(self) -> int:
        """Order of the frame's response."""
        return 4 if self.named.second_mode else 2

    @cached_property
    def named(self) -> Constants:
        """The constants by their names."""
        return Constants(*self.constants.tolist())

    def moved(self, step: np.ndarray) -> "BristleFrame":
        """The model with a step, shape (24,), added to its ``constants``."""
        return replace(self, constants=self.constants + step)

    def resonance_hz(self, carried_kg: float) -> float:
        """Natural frequency of the frame (Hz) with a weight on the belt (kg)."""
        slowness = self.named.slowness_s2 + carried_kg * self.named.slowness_s2_per_kg
        return float(1.0 / (2.0 * np.pi * np.sqrt(slowness))) if slowness > 0.0 else float("inf")

    def plausible(self, mass_kg: float) -> bool:
        """Test for a resonance, mounts, friction under a mass (kg), and lag as a treadmill can have."""
        c, (low, high) = self.named, MOUNT_SHARES
        sliding = (c.friction + mass_kg * c.friction_per_kg) + (c.bristle + mass_kg * c.bristle_per_kg)
        return bool(
            np.isfinite(self.constants).all()
            and 0.0 <= c.slowness_s2 <= (1.0 / (2.0 * np.pi * LOWEST_HZ)) ** 2
            and low <= c.mount_share <= high
            and abs(c.lag_s) <= LONGEST_LAG_S
            and sliding + 0.5 * c.force_viscous >= 0.0
        )

    def predict(self, recording: BeltRecording) -> np.ndarray:
        """L (unit of the load), shape (n,), relative to its value before each pulse.

        The force of a weight is its mass times the belt's acceleration.
        """
        carried_force = recording.rigid_kg * recording.acceleration
        load = recording.carried + self.added(recording, carried_force)
        predicted = self._through(recording, over_line(load)) - recording.carried
        predicted = predicted + self._pull(recording) + self._free(recording)
        return from_each_pulse(recording, predicted)

    def compensate(
        self,
        recording: BeltRecording,
        force: np.ndarray | None = None,
        friction: Annotated[np.ndarray, "(n,)", "N"] | None = None,
    ) -> np.ndarray:
        """Measured load, corrected for the frame's response and the belt-induced load, less the known load.

        force: true fore-aft force (N), whose cross-talk is subtracted from the moment.
        friction: output of `friction`, if it is known already.
        Returns: true load less the load carried, but for a constant (unit of the load).
        """
        key = ("spectrum", *self._constants(self._of_response))
        measured = recording.load + recording.carried
        whole = recording.once(key, lambda: over_line(measured - self._free(recording)))
        key = ("before", self.component, *self._constants((*OF_FRAME, *self._of_response)))
        before = recording.once(key, lambda: self._through(recording, whole, inverse=True))
        if self.component == "Mx" and recording.rigid_kg:
            before = before - self._through(recording, over_line(self._pull(recording)), inverse=True)
        added = self.added(recording, np.zeros_like(before) if force is None else force, friction)
        return before - added - recording.carried

    def added(
        self, recording: BeltRecording, force: np.ndarray, friction: np.ndarray | None = None
    ) -> np.ndarray:
        """Belt-induced load before the response of the frame (unit of the load), shape (n,).

        ``force`` is the true fore-aft force, ``friction`` the output of `friction` (N), both of shape (n,).
        """
        c = self.named
        needed = self.component == "Fy" or c.lever_m != 0.0
        if friction is None and needed:
            friction = self.friction(recording)
        if self.component == "Fy":
            return c.force_mass * recording.acceleration + friction
        added = (
            c.moment_mass * recording.acceleration
            + c.moment_viscous * recording.velocity
            + c.cross_talk_m * force
        )
        return added + c.lever_m * friction if needed else added

    def added_per_kg(self, recording: BeltRecording) -> np.ndarray:
        """Friction of another kg on the belt, before the frame's response (N or N·m), shape (n,)."""
        force = np.zeros(recording.load.size)
        heavier = replace(recording, carried_kg=recording.carried_kg + 1.0)
        return self.added(heavier, force) - self.added(recording, force)

    def frame_acceleration(self, recording: BeltRecording) -> np.ndarray:
        """Acceleration of the frame (m/s²), shape (n,), from the measured fore-aft force."""
        c = self.named
        measured, line = over_line(recording.load + recording.carried)
        s = 2j * np.pi * np.fft.rfftfreq(line.size, 1.0 / recording.rate_hz)
        before = measured / (frame_response(c, s, 0.0, "Fy") * mount_response(c, s))
        return np.fft.irfft(-c.slowness_s2_per_kg * s**2 * before / _first_mode(c, s, 0.0), line.size)

    def shared_friction(self, other: BeltModel, recording: BeltRecording) -> np.ndarray | None:
        """Output of `friction` (N), shape (n,), if ``other`` has the same constants; else None."""
        same = isinstance(other, BristleFrame) and np.array_equal(self.constants, other.constants)
        return self.friction(recording) if same else None

    def friction(self, recording: BeltRecording) -> np.ndarray:
        """Force of friction on the belt, viscous, smooth and of the bristles (N), shape (n,)."""
        return recording.once(("friction", *self._constants(OF_FRICTION)), lambda: self._friction(recording))

    def _friction(self, recording: BeltRecording) -> np.ndarray:
        kg, c = recording.carried_kg, self.named
        pulses = recording.once("pulses", lambda: pulses_of(recording))
        w = pulses.velocity + c.lag_s * pulses.acceleration
        smooth = c.friction + kg * c.friction_per_kg
        bristle = c.bristle + kg * c.bristle_per_kg
        rubbing, last = smooth * w / np.hypot(c.friction_speed_m_per_s, w), 0.0
        if bristle != 0.0:
            key = ("bristles", *self._constants(OF_BRISTLES))
            z, last = recording.once(key, lambda: bent_in_turn(pulses, w, c.bristles))
            rubbing = rubbing + bristle * z
        sliding = recording.velocity + c.lag_s * recording.acceleration
        last = np.broadcast_to(bristle * last, pulses.start.shape)
        return c.force_viscous * sliding + held(recording, pulses, rubbing, last)

    @property
    def _of_response(self) -> tuple[str, ...]:
        return () if self.by_mass is None else ("response_share",)

    def _free(self, recording: BeltRecording) -> np.ndarray | float:
        """Load without physics (unit of the load), shape (n,)."""
        return 0.0 if self.by_mass is None else self.by_mass.load(recording, self.named.response_share)

    def _constants(self, names: tuple[str, ...]) -> list[float]:
        return [getattr(self.named, name) for name in names]

    def _pull(self, recording: BeltRecording) -> np.ndarray | float:
        """Moment (N·m), shape (n,), by which the frame's motion under a weight changes M_x."""
        if self.component == "Fy" or not recording.rigid_kg:
            return 0.0
        kg = recording.rigid_kg + self.named.force_mass
        spectrum, line = over_line(kg * recording.acceleration + self.friction(recording))
        s = 2j * np.pi * np.fft.rfftfreq(line.size, 1.0 / recording.rate_hz)
        empty, under = (frame_response(self.named, s, mass, "Mx") for mass in (0.0, recording.rigid_kg))
        return recording.rigid_height_m * np.fft.irfft((empty - under) * spectrum, line.size)

    def _through(
        self, recording: BeltRecording, x: tuple[np.ndarray, np.ndarray], *, inverse: bool = False
    ) -> np.ndarray:
        """A signal, as `over_line`, filtered by the response to a force or a moment, or by its inverse."""
        spectrum, line = x
        s = 2j * np.pi * np.fft.rfftfreq(line.size, 1.0 / recording.rate_hz)
        if self.component == "Fy":
            response = frame_response(self.named, s, recording.rigid_kg, "Fy") * mount_response(self.named, s)
        else:
            response = frame_response(self.named, s, 0.0, "Mx")
        return np.fft.irfft(spectrum * (1.0 / response if inverse else response), line.size) + line


def frame_response(
    constants: Constants, s: np.ndarray, rigid_kg: float | np.ndarray, component: str
) -> np.ndarray:
    """R_M at s (rad/s), for a weight on the belt (kg), and Fy (N) or Mx (N·m)."""
    share = constants.second_mode if component == "Fy" else constants.second_mode_moment
    damping, ratio = constants.damping_s * s, constants.second_slowness
    empty = (1.0 - share) * (1.0 + damping)
    if share != 0.0:
        first, damping = _first_mode(constants, s, 0.0), ratio * damping
        second = 1.0 + damping + ratio**2 * constants.slowness_s2 * s**2
        empty = empty + share * first * (1.0 + damping) / second
    return empty / _first_mode(constants, s, rigid_kg)


def _first_mode(constants: Constants, s: np.ndarray, rigid_kg: float | np.ndarray) -> np.ndarray:
    """D_M at s (rad/s), for a weight (kg)."""
    slowness = constants.slowness_s2 + constants.slowness_s2_per_kg * rigid_kg
    return 1.0 + constants.damping_s * s + slowness * s**2


def mount_response(constants: Constants, s: np.ndarray) -> np.ndarray:
    """S at s (rad/s)."""
    time_s = constants.mount_time_s
    return 1.0 - constants.mount_share * time_s * s / (1.0 + time_s * s)
