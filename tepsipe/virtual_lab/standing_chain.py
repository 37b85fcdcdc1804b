"""A person with ankle, knee and hip who stands on a belt and is perturbed, simulated by a multi-body engine.

The joints resist deviations from a posture by a 3 x 3 stiffness and a 3 x 3 damping, whose elements off the
diagonal are muscles that cross two joints. The person's own torque, coloured noise at every joint, makes
sway. A perturbation is a pulse of a horizontal force on a segment, or of the belt's acceleration. Each is
repeated at random instants of the sway and in a random direction, from the state and with the own torque of
that instant, so that the person has settled before each.

Recordings of persons with ankle, knee and hip as an HDF5 file, one group per person.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt, Le

from tepsipe.quantities import Frequency, Gravity, Length, Mass, NotNegative, Pair, Positive, Three, Time
from tepsipe.virtual_lab.platform_person import coloured_noise
from tepsipe.virtual_lab.seeds import generator

Matrix = tuple[tuple[float, float, float], ...]
# step of the simulation, and time in which the sway settles (s)
STEP_S, SETTLING_S = 0.001, 10.0


@dataclass(frozen=True)
class ChainPerson:
    """Constants of the person; three each, of shank, thigh and trunk or of ankle, knee and hip."""

    mass_kg: Three[Mass]
    """Mass of both shanks, both thighs, trunk with head and arms."""
    length_m: Three[Length]
    """Their lengths."""
    com_m: Three[Length]
    """Their centres of mass above the lower end."""
    inertia_kgm2: Three[Annotated[float, Gt(0), Le(20)]]
    """Their moments of inertia about the centre of mass."""
    posture_deg: Three[Annotated[float, Ge(-45), Le(45)]]
    """Angles of shank, thigh and trunk from the vertical, positive forwards."""
    stiffness_Nm_per_rad: Three[Three[float]]
    """Expected *K*; rows are torques, columns angles of ankle, knee, hip."""
    damping_Nms_per_rad: Three[Three[float]]
    """Expected *B*."""
    own_torque_Nm: Three[Positive]
    """Standard deviation of the torque that makes sway."""
    own_band_hz: Pair[Frequency]
    """Its band."""
    gravity_m_per_s2: Gravity = 9.81
    """Acceleration of gravity."""


@dataclass(frozen=True)
class Pulse:
    """A perturbation."""

    segment: int | None
    """Pushed segment, 0 for the shank; None for the belt."""
    size: float
    """Peak of the force, half a sine (N), or displacement of the belt in a minimum-jerk movement (m)."""
    duration_s: float
    """Length."""
    height_m: float = 0.0
    """Height of the force above the lower end of the segment."""

    def at(self, time: np.ndarray) -> np.ndarray:
        """Force (N) or acceleration of the belt (m/s²) at times after the onset (s)."""
        s = time / self.duration_s
        if self.segment is None:
            shape = (60.0 * s - 180.0 * s**2 + 120.0 * s**3) / self.duration_s**2
        else:
            shape = np.sin(np.pi * s)
        return np.where((s >= 0.0) & (s <= 1.0), self.size * shape, 0.0)


@dataclass(frozen=True)
class ChainProtocol:
    """Perturbations and their measurement."""

    pulses: Mapping[str, Pulse]
    """By name."""
    epochs: Annotated[int, Ge(2)]
    """Repetitions of each perturbation."""
    before_s: Time
    """Recorded before each onset."""
    after_s: Time
    """Recorded after each onset."""
    unperturbed_s: Time
    """Recorded of unperturbed standing."""
    rate_hz: Literal[50, 100, 125, 200, 250, 500]
    """Rate of the angles."""
    angle_noise_rad: Annotated[float, Gt(0), Le(1)]
    """Standard deviation of the noise of one sample."""
    force_noise_N: NotNegative = 0.0
    """The same of the force."""
    belt_noise_m_per_s2: NotNegative = 0.0
    """The same of the belt's acceleration."""
    engine: str = "auto"
    """{"pybullet", "mujoco", "auto"}: Engine; "auto", and any other name, take the first that is
    installed."""


@dataclass(frozen=True)
class ChainRecord:
    """Signals recorded by the instruments."""

    unperturbed: Annotated[np.ndarray, "(n, 3)", "rad"]
    """Absolute angles of the segments in unperturbed standing."""
    angle: Mapping[str, np.ndarray]
    """The same around every onset of a pulse (rad), shape (epochs, samples, 3)."""
    drive: Mapping[str, np.ndarray]
    """Force (N) or acceleration of the belt (m/s²), signed, at 1 kHz from the onset on, shape (epochs,
    after_s / 1 ms + 1)."""


def record_chain(person: ChainPerson, protocol: ChainProtocol, rng: np.random.Generator) -> ChainRecord:
    """Let the person stand and perturb them."""
    settling, kept = round(SETTLING_S / STEP_S), round(protocol.unperturbed_s / STEP_S)
    every = round(1.0 / (protocol.rate_hz * STEP_S))
    before, after = round(protocol.before_s / STEP_S), round(protocol.after_s / STEP_S)
    spontaneous = np.column_stack(
        [
            sd * coloured_noise(rng, settling + kept, STEP_S, person.own_band_hz, 2)
            for sd in person.own_torque_Nm
        ]
    )
    signs = {name: rng.choice([-1.0, 1.0], protocol.epochs) for name in protocol.pulses}
    starts = _instants(settling, kept, before + after, protocol, rng)
    with _engine(protocol.engine)(
        person.mass_kg, person.length_m, person.com_m, person.inertia_kgm2, person.gravity_m_per_s2, STEP_S
    ) as body:
        mover = _Mover(body, person)
        states = mover.sway(spontaneous)
        responses = {
            name: np.array(
                [
                    mover.perturbed(states[start], spontaneous[start:], pulse, sign, (before, after))[::every]
                    for start, sign in zip(starts[name], signs[name], strict=True)
                ]
            )
            for name, pulse in protocol.pulses.items()
        }
    still = np.array([q for q, _, _ in states[settling::every]])

    def seen(q: np.ndarray) -> np.ndarray:
        angle = np.cumsum(q, axis=-1)
        return angle + protocol.angle_noise_rad * rng.standard_normal(angle.shape)

    elapsed = STEP_S * np.arange(after + 1)
    drives = {}
    for name, pulse in protocol.pulses.items():
        noise = protocol.belt_noise_m_per_s2 if pulse.segment is None else protocol.force_noise_N
        exact = signs[name][:, None] * pulse.at(elapsed)
        drives[name] = exact + noise * rng.standard_normal(exact.shape)
    return ChainRecord(seen(still), {name: seen(q) for name, q in responses.items()}, drives)


def _engine(name: str):
    """Function that builds the chain in an engine."""
    if name != "mujoco":
        try:
            from tepsipe.virtual_lab.chain_pybullet import built

            return built
        except ImportError:
            if name == "pybullet":
                raise
    from tepsipe.virtual_lab.chain_mujoco import built

    return built


def _instants(settling: int, kept: int, length: int, protocol: ChainProtocol, rng) -> dict[str, np.ndarray]:
    """Steps at which the epochs of every pulse begin, in the sway, none overlapping another."""
    places = kept // (length + 1)
    needed = protocol.epochs * len(protocol.pulses)
    if places < needed:
        raise ValueError(f"{needed} epochs do not fit into {protocol.unperturbed_s:g} s: record longer")
    chosen = settling + (length + 1) * rng.permutation(places)[:needed]
    return dict(zip(protocol.pulses, chosen.reshape(len(protocol.pulses), -1), strict=True))


class _Mover:
    """Steps the chain with the torque of its joints."""

    def __init__(self, body, person: ChainPerson):
        self.body = body
        self.posture = tuple(np.diff(np.deg2rad(person.posture_deg), prepend=0.0).tolist())
        hold = body.holding_torque(self.posture)
        k, b = np.array(person.stiffness_Nm_per_rad), np.array(person.damping_Nms_per_rad)
        self.constant = tuple((np.array(hold) + k @ np.array(self.posture)).tolist())
        self.rows = tuple(map(tuple, np.hstack([k, b]).tolist()))

    def _torque(self, q, rate, last, spontaneous) -> tuple[float, float, float]:
        """Torques of the joints; the rate at the step is extrapolated from the two half steps before it."""
        (q1, q2, q3), (c1, c2, c3), (n1, n2, n3) = q, self.constant, spontaneous
        w1, w2, w3 = (
            1.5 * rate[0] - 0.5 * last[0],
            1.5 * rate[1] - 0.5 * last[1],
            1.5 * rate[2] - 0.5 * last[2],
        )
        # plain numbers, which are faster than short arrays
        (k11, k12, k13, b11, b12, b13), (k21, k22, k23, b21, b22, b23), third = self.rows
        k31, k32, k33, b31, b32, b33 = third
        return (
            c1 + n1 - k11 * q1 - k12 * q2 - k13 * q3 - b11 * w1 - b12 * w2 - b13 * w3,
            c2 + n2 - k21 * q1 - k22 * q2 - k23 * q3 - b21 * w1 - b22 * w2 - b23 * w3,
            c3 + n3 - k31 * q1 - k32 * q2 - k33 * q3 - b31 * w1 - b32 * w2 - b33 * w3,
        )

    def sway(self, spontaneous: np.ndarray) -> list[tuple]:
        """Angles (rad), rates half a step and three half steps before (rad/s) at every step."""
        q, rate = self.posture, (0.0, 0.0, 0.0)
        last, states = rate, []
        self.body.put(q, rate)
        for k, torque in enumerate(spontaneous.tolist()):
            states.append((q, rate, last))
            before, (q, rate) = rate, self.body.step(self._torque(q, rate, last, torque), 0.0)
            last = before
            if not abs(sum(q)) < 1.0:
                raise RuntimeError(f"the person falls after {k * STEP_S:.1f} s")
        return states

    def perturbed(
        self, state, spontaneous: np.ndarray, pulse: Pulse, sign: float, steps: tuple[int, int]
    ) -> np.ndarray:
        """Joint angles (rad) at every step from before the onset to after it, shape (n, 3)."""
        before, after = steps
        q, rate, last = state
        self.body.put(q, rate)
        drive = sign * pulse.at(STEP_S * np.arange(-before, after + 1))
        angles = []
        for u, torque in zip(drive.tolist(), spontaneous[: drive.size].tolist(), strict=True):
            angles.append(q)
            if u and pulse.segment is not None:
                self.body.push(pulse.segment, pulse.height_m, u, q)
            acceleration = u if pulse.segment is None else 0.0
            before_it, (q, rate) = rate, self.body.step(self._torque(q, rate, last, torque), acceleration)
            last = before_it
        return np.array(angles)


SEGMENTS = ("shank", "thigh", "trunk")


def chain_protocol(perturbations: dict, protocol: dict, engine: str) -> ChainProtocol:
    """Protocol of sections of settings and the engine's name.

    A perturbation has a ``displacement_m`` of the belt, or a ``force_N`` on a ``segment`` at ``height_m``.
    """
    return ChainProtocol(
        pulses={name: _pulse(one) for name, one in perturbations.items()}, **protocol, engine=engine
    )


def _pulse(one: dict) -> Pulse:
    if "displacement_m" in one:
        return Pulse(None, one["displacement_m"], one["duration_s"])
    return Pulse(SEGMENTS.index(one["segment"]), one["force_N"], one["duration_s"], one["height_m"])


def write_chain_trials(
    path: str | Path, person: ChainPerson, protocol: ChainProtocol, seed: int, persons: int
) -> None:
    """Record the person several times, with other sway and noise each time (rad, N, m/s²).

    path: HDF5 file that is written.
    seed: seed of all draws.
    persons: number of recordings.
    """
    import h5py  # only who writes a file needs it

    with h5py.File(path, "w") as file:
        for k in range(persons):
            record = record_chain(person, protocol, generator(seed, "several-joints", str(k)))
            _write(file.create_group(str(k)), record, protocol)


def _write(group, record: ChainRecord, protocol: ChainProtocol) -> None:
    group.attrs["rate_hz"] = protocol.rate_hz
    group.attrs["drive_rate_hz"] = 1.0 / STEP_S
    group.attrs["before"] = round(protocol.before_s * protocol.rate_hz)
    group.create_dataset("unperturbed", data=record.unperturbed).attrs["units"] = "rad"
    for name, arrays in (("angle", record.angle), ("drive", record.drive)):
        subgroup = group.create_group(name)
        subgroup.attrs["names"] = list(arrays)
        for key, values in arrays.items():
            belt = protocol.pulses[key].segment is None
            unit = "rad" if name == "angle" else "m/s2" if belt else "N"
            subgroup.create_dataset(key, data=values).attrs["units"] = unit
