"""Reflexes, balance and muscles of a standing person, step by step.

Muscle m is driven by

    e_m = [tone_m + G_m [s(t - L_m) - s_0]_+ + G_2m [s(t - L_2m) - s_0]_+ + balance]_+

with the velocity s = sum_j w_mj phi_j' at which it is stretched, above a threshold, a short and a medium
latency earlier (M1 and M2). Balance responds to the centre of mass a longer delay earlier, and has a random
part. Force follows the drive as a twitch of second order that rises with T and falls with T_2, critically
damped if both are the same:

    T T_2 x'' + (T + T_2) x' + x = e
"""

import math

import numpy as np

from tepsipe.virtual_lab.person_constants import MUSCLES, MuscleTruth, NervesTruth, TaskTruth


def wander(nerves: NervesTruth, n: int, rate_hz: float, rng: np.random.Generator) -> np.ndarray:
    """Torque that balance adds of itself (N·m), shape (n,): an Ornstein-Uhlenbeck process."""
    kept = math.exp(-1.0 / (nerves.wander_s * rate_hz))
    steps = rng.standard_normal(n) * math.sqrt(1.0 - kept**2)
    state, out = float(rng.standard_normal()), np.empty(n)
    for k, step in enumerate(steps.tolist()):
        state = kept * state + step
        out[k] = state
    return nerves.wander_Nm * out


class Nerves:
    """Drive (-) and active torque (N·m), step by step, from what was sensed a latency ago."""

    def __init__(
        self,
        muscles: dict[str, MuscleTruth],
        task: TaskTruth,
        nerves: NervesTruth,
        p: list[float],
        stance: tuple[float, float, float],
        steps: int,
        rate_hz: float,
        rng: np.random.Generator,
    ):
        self._nerves = nerves
        self._weights = [part / sum(p) for part in p]
        self._stance = stance
        self._wander = wander(nerves, steps + 2, rate_hz, rng).tolist()
        self._balance_late = _steps(nerves.balance_delay_s * rate_hz)
        own = [muscles[name] for name in MUSCLES]
        # latencies in steps; the drive one step ahead is known, because every latency is longer than a step
        self._constants = [
            (
                tone,
                muscle.balance_per_Nm,
                gain,
                *_steps(muscle.latency_s * rate_hz),
                medium,
                *_steps(muscle.medium_latency_s * rate_hz),
                tuple(muscle.force_Nm),
                tuple(muscle.stretch),
            )
            for muscle, tone, gain, medium in zip(
                own, task.tone, task.reflex_s_per_rad, task.medium_reflex_s_per_rad, strict=True
            )
        ]
        self._stretched: list[list[float]] = [[] for _ in MUSCLES]
        self._leaned: list[float] = []
        self._twitch = [(tone, 0.0) for tone in task.tone]
        self._drive_before = list(task.tone)
        self._k = -1
        self._to_x, self._to_v = _twitch(nerves, 1.0 / rate_hz)

    def step(self, state) -> tuple[list[float], list[float]]:
        """Drive (-) and active torque at ankle, knee and hip (N·m) one step after ``state``.

        The first call, with the first state, gives them at the first state itself.
        """
        self._k += 1
        k, nerves = self._k, self._nerves
        _, _, _, th1, th2, th3, w1, w2, w3, _, foot, _ = state
        if k:
            f1, f2, f3 = self._weights
            s1, s2, s3 = self._stance
            lean = f1 * (th1 - s1) + f2 * (th2 - s2) + f3 * (th3 - s3)
            rate = f1 * w1 + f2 * w2 + f3 * w3
            self._leaned.append(nerves.balance_Nm_per_rad * lean + nerves.balance_Nms_per_rad * rate)
        wanted, leaned, (late, part) = self._wander[k], self._leaned, self._balance_late
        if k >= late:
            wanted += leaned[k - late] + part * (leaned[k - late + 1] - leaned[k - late])
        side = 0 if wanted >= 0.0 else 1
        ankle, knee, hip = w1 - foot, w2 - w1, w3 - w2
        threshold, drive_before, twitch = nerves.reflex_threshold_rad_per_s, self._drive_before, self._twitch
        (xx, xv), (vx, vv) = self._to_x, self._to_v
        drives, ankle_Nm, knee_Nm, hip_Nm = [], 0.0, 0.0, 0.0
        for m, (tone, balance, gain, late, part, medium, later, rest, forces, (a, b, c)) in enumerate(
            self._constants
        ):
            history = self._stretched[m]
            if k:
                history.append(a * ankle + b * knee + c * hip)
            e = tone + balance[side] * wanted
            if k >= late:
                before = history[k - late]
                stretch = before + part * (history[k - late + 1] - before) - threshold
                if stretch > 0.0:
                    e += gain * stretch
                if medium and k >= later:
                    before = history[k - later]
                    stretch = before + rest * (history[k - later + 1] - before) - threshold
                    if stretch > 0.0:
                        e += medium * stretch
            if e < 0.0:
                e = 0.0
            x, v = twitch[m]
            if k:
                held = 0.5 * (drive_before[m] + e)
                x, v = held + xx * (x - held) + xv * v, vx * (x - held) + vv * v
                twitch[m] = (x, v)
            drive_before[m] = e
            drives.append(e)
            over = x - tone
            ankle_Nm += forces[0] * over
            knee_Nm += forces[1] * over
            hip_Nm += forces[2] * over
        return drives, [ankle_Nm, knee_Nm, hip_Nm]


def _twitch(nerves: NervesTruth, step_s: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Exact solution for a constant drive e: x - e and T x' after a step, each from both before it."""
    rise_s, fall_s = nerves.twitch_s, nerves.relaxation_s or nerves.twitch_s
    if rise_s == fall_s:
        step = step_s / rise_s
        decay = math.exp(-step)
        return (decay * (1.0 + step), decay * step), (-decay * step, decay * (1.0 - step))
    a, b = 1.0 / rise_s, 1.0 / fall_s
    rising, falling = math.exp(-a * step_s), math.exp(-b * step_s)
    between = rising - falling
    return (
        ((b * rising - a * falling) / (b - a), a * between / (b - a)),
        (-b * between / (b - a), (b * falling - a * rising) / (b - a)),
    )


def _steps(latency: float) -> tuple[int, float]:
    """A latency in steps as whole steps, rounded up, and the part of a step by which it is shorter."""
    whole = math.ceil(latency - 1e-9)
    return whole, max(0.0, whole - latency)
