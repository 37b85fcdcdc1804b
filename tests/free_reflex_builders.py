"""Responses of a standing person whose K, B and reflex are known, and their fit with a free reflex torque."""

from dataclasses import replace

import numpy as np

from tepsipe.experiments.standing.free_reflex.broadband import BroadbandEpochs
from tepsipe.experiments.standing.free_reflex.fit import fit_free_reflex
from tepsipe.experiments.standing.free_reflex.free_body import SOURCES
from tepsipe.experiments.standing.options import FreeReflexOptions, StandingEstimator

K, B = 370.0, 8.0
RATE_HZ = 250.0
OPTIONS = FreeReflexOptions(60.0, 0.02, 0.008, 1.6, 0.02, 0.5, 0.045, 0.004, (0.04, 0.08))
FREE = {"free": StandingEstimator(0.08, False, "free")}


def responses(seed=1, stiffness=K, damping=B, reflex=0.0, noise=0.05, peak=0.4, sign=1.0, **changes):
    """One trial: a sine of velocity, the torque of K and B (N·m), a reflex that grows from 45 ms on."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(-0.12 * RATE_HZ), round(0.2 * RATE_HZ) + 1) / RATE_HZ
    size = sign * peak * 0.04
    moved = np.clip(time, 0.0, 0.1)
    angle = 0.5 * size * (1.0 - np.cos(20.0 * np.pi * moved))
    rate = np.where((time >= 0.0) & (time <= 0.1), size * 10.0 * np.pi * np.sin(20.0 * np.pi * moved), 0.0)
    reflex = reflex * peak / 0.5 * np.maximum(time - 0.045, 0.0) ** 1.5 / 0.02**1.5

    def sway(epochs, n):
        steps = rng.standard_normal((epochs, n)) * noise
        return np.cumsum(steps, axis=1) * 0.2 + steps

    torque = stiffness * angle + damping * rate + reflex
    pulled = torque + sway(10, time.size)
    perturbed = np.stack([pulled, np.tile(angle, (10, 1)), np.tile(rate, (10, 1))], axis=-1)
    zero = (time >= -0.1) & (time <= -0.02)
    perturbed -= perturbed[:, zero].mean(axis=1, keepdims=True)
    quiet = np.zeros((12, 281, 3))
    quiet[..., 0] = sway(12, 281)
    slopes = {source: np.zeros((time.size, 3)) for source in SOURCES}
    slopes["force_scale"][:, 0] = torque
    slopes["marked_rotation"][:, 1:] = np.column_stack([angle, rate])
    trial = BroadbandEpochs(
        time=time,
        perturbed=perturbed,
        quiet_time=np.arange(281) / RATE_HZ - 0.12,
        quiet=quiet,
        slopes=slopes,
        draws=np.outer([0.01, -0.01, 0.0], torque),
        belt=np.column_stack([rate, angle]),
        baseline_s=(-0.1, -0.02),
        cutoff_hz=60.0,
        order=4,
        peak_m_per_s=peak,
        carried_kg=64.0,
        calibrated_kg=60.0,
        centre=None,
        centre_used=True,
        apparent=None,
        skin_m=0.0,
    )
    return replace(trial, **changes)


def group(seed=1, **changes):
    """Eight trials of a task, four in each direction."""
    sizes = (0.2, 0.3, 0.4, 0.5)
    return [
        responses(seed + 100 * k, peak=peak, sign=sign, **changes)
        for k, (peak, sign) in enumerate((p, s) for p in sizes for s in (1.0, -1.0))
    ]


def fitted(trials, window_s=0.08, sources=(), **changes):
    return fit_free_reflex(trials, window_s, OPTIONS, list(sources), **changes)
