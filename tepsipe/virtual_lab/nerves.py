"""Reflexes, balance and muscles of a standing person, step by step.

Muscle m is driven by

    e_m = [tone_m + G_m [s(t - L_m) - s_0]_+ + G_2m [s(t - L_2m) - s_0]_+ + balance]_+

with the velocity s = sum_j w_mj phi_j' at which it is stretched, above a threshold, a short and a medium
latency earlier (M1 and M2). Balance responds to the centre of mass after a longer delay, and has a random
part. Force follows the drive as a twitch of second order that rises with T and falls with T_2, critically
damped if both are the same:

    T T_2 x'' + (T + T_2) x' + x = e
"""

import math
from collections.abc import Callable

import numpy as np

from tepsipe.virtual_lab.person_constants import MUSCLES, NervesTruth, Subject


def wander(nerves: NervesTruth, n: int, rate_hz: float, rng: np.random.Generator) -> np.ndarray:
    """Random torque of balance (N·m), shape (n,): an Ornstein-Uhlenbeck process."""
    kept = math.exp(-1.0 / (nerves.wander_s * rate_hz))
    steps = rng.standard_normal(n) * math.sqrt(1.0 - kept**2)
    state, out = float(rng.standard_normal()), np.empty(n)
    for k, step in enumerate(steps.tolist()):
        state = kept * state + step
        out[k] = state
    return nerves.wander_Nm * out


class Nerves:
    """Drive and active torque (N·m), step by step, from what was sensed a latency ago."""

    def __init__(
        self, subject: Subject, levers: list[float], steps: int, rate_hz: float, rng: np.random.Generator
    ):
        task, nerves = subject.task, subject.nerves
        self._nerves = nerves
        self._weights = [lever / sum(levers) for lever in levers]
        self._stance = subject.person.stance_rad
        self._wander = wander(nerves, steps + 2, rate_hz, rng).tolist()
        self._balance_late = _steps(nerves.balance_delay_s * rate_hz)
        muscles = [subject.muscles[name] for name in MUSCLES]
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
                muscles, task.tone, task.reflex_s_per_rad, task.medium_reflex_s_per_rad, strict=True
            )
        ]
        self._to_x, self._to_v = _twitch(nerves, 1.0 / rate_hz)

    def stepper(self) -> Callable[[tuple[float, ...]], tuple[list[float], list[float]]]:
        """``step(state)``: drive and active torque at ankle, knee and hip (N·m) one step after ``state``.

        The first call, with the first state, returns the values at that state itself.
        """
        (f1, f2, f3), (s1, s2, s3) = self._weights, self._stance
        nerves, wandered, (balance_late, balance_part) = self._nerves, self._wander, self._balance_late
        by_angle, by_rate = nerves.balance_Nm_per_rad, nerves.balance_Nms_per_rad
        threshold = nerves.reflex_threshold_rad_per_s
        (xx, xv), (vx, vv) = self._to_x, self._to_v
        # for every muscle: constants, its stretch, and drive and twitch at the last step
        muscles = [(constants, [], [constants[0], constants[0], 0.0]) for constants in self._constants]
        leaned: list[float] = []
        k = -1

        def step(state: tuple[float, ...]) -> tuple[list[float], list[float]]:
            nonlocal k
            k += 1
            _, _, _, th1, th2, th3, w1, w2, w3, _, foot, _ = state
            if k:
                lean = f1 * (th1 - s1) + f2 * (th2 - s2) + f3 * (th3 - s3)
                rate = f1 * w1 + f2 * w2 + f3 * w3
                leaned.append(by_angle * lean + by_rate * rate)
            wanted = wandered[k]
            if k >= balance_late:
                before = leaned[k - balance_late]
                wanted += before + balance_part * (leaned[k - balance_late + 1] - before)
            side = 0 if wanted >= 0.0 else 1
            ankle, knee, hip = w1 - foot, w2 - w1, w3 - w2
            drives, ankle_Nm, knee_Nm, hip_Nm = [], 0.0, 0.0, 0.0
            for (
                (tone, balance, gain, late, part, medium, later, rest, (on_a, on_k, on_h), (a, b, c)),
                history,
                held,
            ) in muscles:
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
                drive, x, v = held
                if k:
                    drive = 0.5 * (drive + e)
                    over = x - drive
                    x, v = drive + xx * over + xv * v, vx * over + vv * v
                held[:] = e, x, v
                drives.append(e)
                over = x - tone
                ankle_Nm += on_a * over
                knee_Nm += on_k * over
                hip_Nm += on_h * over
            return drives, [ankle_Nm, knee_Nm, hip_Nm]

        return step


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
