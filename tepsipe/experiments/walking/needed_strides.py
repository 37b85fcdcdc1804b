"""Perturbed strides that K will need, from unperturbed strides alone.

With the estimator's own weights w_K for an expected response, one stride has the variance
w_K' cov(e) w_K, and n strides reach a standard uncertainty u with n = w_K' cov(e) w_K / u^2.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.walking.analysis import FEWEST_UNPERTURBED
from tepsipe.experiments.walking.deviations import filter_walk, subtract_unperturbed
from tepsipe.experiments.walking.impedance import predicted_uncertainty
from tepsipe.experiments.walking.options import ExpectedPulse, WalkingOptions
from tepsipe.experiments.walking.plausible import refuse_other_units
from tepsipe.experiments.walking.strides import Strides, WalkingRecording, refuse_swapped_belts
from tepsipe.io.tables import Table
from tepsipe.signals.filters import butterworth_lowpass

FINE_HZ = 1000.0
FEWEST_PLANNED = 10  # strides of a phase


@dataclass(frozen=True)
class NeededRow:
    """Strides needed at one phase; the fields are columns of ``tables/needed.csv``."""

    condition: str
    phase_percent: float
    """Phase of the onset."""
    matching: str
    """state, or mean: how unperturbed behaviour is predicted."""
    moment_sd_Nm: float
    angle_sd_rad: float
    """Standard deviation, 60 ms after the onset, of what the prediction leaves."""
    K_Nm_per_rad: float
    """Expected K."""
    u_one_stride_Nm_per_rad: float
    """Standard uncertainty of K by one stride."""
    strides_for_15_percent: float
    """Strides for a standard uncertainty of 15 % of K."""
    planned_strides: int
    """Strides of the planned number that this phase gets, see `allocation`."""
    planned_u_percent: float
    """Standard uncertainty of K with them, of Type A (% of K)."""


NEEDED_ROWS = Table(NeededRow, "strides needed")


def allocation(needed: Sequence[float], total: int, fewest: int) -> list[int]:
    """Divide perturbed strides among phases so that all reach the same relative uncertainty of K.

    u^2 falls with the number, so each phase gets strides in proportion to its need. It gets at least
    ``fewest``, because its K also determines the rise at its neighbours, and scatter needs several strides.

    Returns: strides of each phase, together ``total``.
    """
    if total < fewest * len(needed):
        raise InputError(
            f"walking: expected at least {fewest} perturbed strides for each of {len(needed)} phases, found "
            f"{total} in all: plan more strides or fewer phases"
        )
    wanted, held = np.asarray(needed, float), np.zeros(len(needed), dtype=bool)
    while True:  # phases that need little are held at the least number, the others share the rest
        shares = np.where(
            held, fewest, wanted * (total - fewest * held.sum()) / max(wanted[~held].sum(), 1e-300)
        )
        below = ~held & (shares < fewest)
        if not below.any():
            break
        held |= below
    counts = np.floor(shares + 1e-9).astype(int)
    for k in np.argsort(counts - shares)[: total - counts.sum()]:
        counts[k] += 1
    return counts.tolist()


def needed_strides(
    condition: str,
    recording: WalkingRecording,
    strides: Strides,
    pulse: ExpectedPulse,
    options: WalkingOptions,
) -> list[NeededRow]:
    """Strides that K needs at each phase, with and without matching.

    condition: the trial, for the rows.
    """
    refuse_swapped_belts(recording, strides)
    refuse_other_units(recording, strides)
    if len(strides) < FEWEST_UNPERTURBED:
        raise InputError(
            f"{recording.name}: expected at least {FEWEST_UNPERTURBED} unperturbed strides, found "
            f"{len(strides)}: "
            "record more of them"
        )
    stance, rows = float(strides.stance.mean()), []
    planned = max(FEWEST_PLANNED, options.fewest_strides)
    for matching, chosen in (("state", options.matched_by), ("mean", ())):
        walk, predicted = filter_walk(recording, options.lowpass_cutoff_hz, options.lowpass_order, chosen), []
        for phase, stiffness in zip(options.phases_percent, pulse.stiffness_Nm_per_rad, strict=True):
            delay = np.full(len(strides), phase / 100.0 * stance)
            cut = subtract_unperturbed(
                walk,
                (strides.start + delay, delay),
                strides.start,
                options.window_s,
                options.ridge,
                options.state_before_s,
            )
            response = _response(pulse, cut.time, options)
            beta = np.array([options.inertia_kgm2 or 0.0, pulse.damping_Nms_per_rad, stiffness])
            u = predicted_uncertainty(cut, response, beta, options)
            late = np.argmin(np.abs(cut.time - 0.06))
            angle, moment = (cut.unperturbed[:, channel, late].std() for channel in (0, 3))
            count = (u / (0.15 * stiffness)) ** 2
            predicted.append((condition, phase, matching, *map(float, (moment, angle, stiffness, u, count))))
        strides_of = allocation([row[-1] for row in predicted], pulse.strides, planned)
        rows += [
            NeededRow(*row, number, 15.0 * float(np.sqrt(row[-1] / number)))
            for row, number in zip(predicted, strides_of, strict=True)
        ]
    return rows


def _response(pulse: ExpectedPulse, time: np.ndarray, options: WalkingOptions) -> np.ndarray:
    """Expected deviation of acceleration, velocity and angle, low-passed, shape (3, w)."""
    fine = np.arange(-0.5, 1.0, 1.0 / FINE_HZ)
    s = np.clip(fine / pulse.duration_s, 0.0, 1.0)
    angle = -math.radians(pulse.amplitude_deg) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    rate = np.gradient(angle, fine)
    signals = np.stack([np.gradient(rate, fine), rate, angle], axis=1)
    filtered = butterworth_lowpass(signals, FINE_HZ, options.lowpass_cutoff_hz, options.lowpass_order)
    at = [np.interp(time, fine, column) - np.interp(0.0, fine, column) for column in filtered.T]
    return np.stack(at)
