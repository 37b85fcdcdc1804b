"""Peak, impulse, gain and delay of the reflex torque that is left beside the intrinsic impedance.

B and K of a fit with a free reflex torque leave, in the whole response of trial j and not only in the fitted
window, the torque

    r_j(t) = tau_j(t) - B phi_j'(t) - K phi_j(t)

with tau and phi from their means in the baseline: all delayed torque of the muscles above their tone, of
reflexes of any latency and of balance. The sign s_j of the largest rotation of the ankle is the direction of
the stretch. A torque that resists it is positive. With means over the trials,

    r(t) = mean_j s_j r_j(t),     theta = mean_j max |phi_j|,     t from 0.04 to 0.2 s after the onset

    peak = max r,     impulse = integral of r dt,     gain = impulse / theta
    delay: r reaches a fifth of its peak for the first time

The torque is still large at the end of this window, so the impulse must not end with the last sample of the
cameras inside it, up to 10 ms earlier. A cubic spline through the samples of the mean responses gives the
torque at the same instants for any rate.

For a reflex that follows the velocity of the stretch the gain is the torque per velocity at a frequency of 0.

Each source of uncertainty changes B and K and the signals together, so with every row of its root

    dr_j = dtau_j - B dphi_j' - K dphi_j - phi_j' dB - phi_j dK

and the four numbers change by half their difference at r + dr and r - dr. Type A is the scatter of the
responses, with the scatter of B and K between trials for the motions of all trials. It does not show the
misfit of the rig's model in each trial alone, which is a source of its own.

A joint that yields is not linear. After the largest rotation it leaves the line that fits the way there. The
stiffness of calf muscles falls with the rotation to the power -0.33 (Loram, Maganaris & Lakie 2007), so the
torque grows with the power 2/3. If all of this is hysteresis, springs with sliders in parallel have the same
torque on the way there (Prandtl 1928):

    K theta x^(2/3),     of springs that slide at x:  K theta (2/9) x^(-4/3) dx,     x = phi / theta

and two thirds of K that do not slide. After the first turn, this torque is below the line by

    K theta (2^(1/3) x^(2/3) - x)

with x as the travel since the turn (Masing 1926). The springs also remember later turns: where the leg swings
back once more, the torque rises again with the stiffness of small rotations. This torque less K phi_j, y_j,
moves B and K of the fit by B_y and K_y, so r_j changes by y_j - B_y phi_j' - K_y phi_j. A linear joint has
none of it. `YIELD_SHARE` of the change is removed, and the source `YIELD` is the error of the share.

The peak is not determined if its interval at 99 % contains 0, and then nothing else is. The delay is not
determined if its interval at 99 % begins before the window, or if, within its uncertainty, r has reached the
threshold at the start of the window.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.identification.cascade.pathways import stop_deflection
from tepsipe.statistics.uncertainty import Budget, coverage_factor

YIELD = "joint_yield"
# between none and all
YIELD_SHARE = 0.5
REFLEX = ("reflex_peak", "reflex_impulse", "reflex_gain", "reflex_delay")
# part of a response in which the torque is a reflex's: before it no muscle answers (s from the onset)
REFLEX_S = (0.04, 0.2)
# instants within it, to which responses are interpolated (s)
INSTANTS_S = np.linspace(*REFLEX_S, 161)
# rotations at which springs of a joint slide, relative to the largest rotation of a trial
YIELD_AT = np.geomspace(1e-3, 1.0, 25)
# share of the peak that marks the start of the torque
RISEN = 0.2
# probability with which the peak must differ from 0
CERTAIN = 0.99


@dataclass(frozen=True)
class MeanReflex:
    """Mean response of trials to the stretch of the ankle."""

    torque: Annotated[np.ndarray, "(n,)", "N·m"]
    """Torque of the reflexes at `INSTANTS_S`, positive against the stretch."""
    stretch: Annotated[float, "rad"]
    """Largest rotation of the ankle, mean over trials."""

    def changed(self, torque: np.ndarray, stretch: float) -> "MeanReflex":
        """With more torque (N·m) and stretch (rad)."""
        return MeanReflex(self.torque + torque, self.stretch + stretch)

    @property
    def values(self) -> Annotated[np.ndarray, "(4,)"]:
        """Numbers of `REFLEX` (N·m, N·m·s, N·m·s/rad, s); the delay is NaN for a torque without a peak."""
        return self.with_changes(np.zeros((1, self.torque.size)), np.zeros(1))[0]

    def with_changes(
        self, torques: Annotated[np.ndarray, "(k, n)", "N·m"], stretches: Annotated[np.ndarray, "(k,)", "rad"]
    ) -> Annotated[np.ndarray, "(k, 4)"]:
        """The same with more torque and stretch, for many changes at a time."""
        torques = np.add(self.torque, torques, order="C")  # sums of rows are then those of single torques
        peaks, impulses = torques.max(axis=-1), scipy.integrate.trapezoid(torques, INSTANTS_S, axis=-1)
        gains = impulses / (self.stretch + stretches)
        return np.stack([peaks, impulses, gains, _risen(torques, RISEN * peaks)], axis=-1)


def _risen(
    torques: Annotated[np.ndarray, "(k, n)"], thresholds: Annotated[np.ndarray, "(k,)"]
) -> Annotated[np.ndarray, "(k,)", "s"]:
    """Instants at which torques first reach thresholds, linear between `INSTANTS_S`; NaN for one of 0."""
    first = np.argmax(torques >= thresholds[:, None], axis=-1)
    at = np.maximum(first, 1)
    below, above = (_at(torques, k) for k in (at - 1, at))
    rises = (INSTANTS_S[at] - INSTANTS_S[at - 1]) / np.where(above > below, above - below, 1.0)
    inside = rises * (thresholds - below) + INSTANTS_S[at - 1]
    found = np.where(thresholds == above, INSTANTS_S[at], inside)
    return np.where(thresholds > 0.0, np.where(first == 0, REFLEX_S[0], found), np.nan)


def mean_reflex(
    time: Annotated[np.ndarray, "(n,)", "s"],
    torques: Annotated[np.ndarray, "(trials, n)", "N·m"],
    angles: Annotated[np.ndarray, "(trials, n)", "rad"],
) -> MeanReflex:
    """Mean torque of reflexes in the direction of each trial's stretch.

    time: instants from the onset, the same in all trials; those outside `REFLEX_S` only show the stretch.
    torques, angles: r and phi of the mean response of each trial.
    """
    ways, step_s = stretches(angles)[0], INSTANTS_S[1] - INSTANTS_S[0]
    largest = np.abs(_interpolated(time, angles, np.arange(time[0], time[-1], step_s))).max(axis=-1)
    return MeanReflex(_interpolated(time, ways @ torques / len(ways)), float(largest.mean()))


def _interpolated(
    time: np.ndarray, signals: Annotated[np.ndarray, "(..., n)"], instants: np.ndarray = INSTANTS_S
) -> Annotated[np.ndarray, "(..., m)"]:
    """Signals at other instants (s), by a spline; the last sample is held, for at most half a step."""
    return scipy.interpolate.CubicSpline(time, signals, axis=-1)(np.minimum(instants, time[-1]))


def stretches(angles: Annotated[np.ndarray, "(..., n)", "rad"]) -> tuple[np.ndarray, np.ndarray]:
    """Direction (1 or -1) and sample of the largest rotation of each response, shape (...)."""
    at = np.abs(angles).argmax(axis=-1)
    return np.sign(_at(angles, at)), at


def yielding(
    angles: Annotated[np.ndarray, "(trials, n)", "rad"], stiffness: float
) -> Annotated[np.ndarray, "(trials, n)", "N·m"]:
    """Torque of a joint that yields, less K phi, after the largest rotation of each trial.

    angles: from the baseline on.
    stiffness: K (N·m/rad).
    """
    slopes = np.diff(YIELD_AT ** (2.0 / 3.0), prepend=0.0) / np.diff(YIELD_AT, prepend=0.0)
    after = np.arange(angles.shape[1]) > stretches(angles)[1][:, None]
    torques = []
    for angle in angles:
        deflections = [stop_deflection(angle, radius) for radius in np.abs(angle).max() * YIELD_AT]
        torques.append(-np.diff(slopes, append=2.0 / 3.0) @ deflections - angle / 3.0)
    return np.where(after, stiffness * np.array(torques), 0.0)


def _at(signals: np.ndarray, samples: np.ndarray) -> np.ndarray:
    return np.take_along_axis(signals, samples[..., None], axis=-1)[..., 0]


@dataclass(frozen=True)
class Change:
    """Signed errors of a fit and of the signals by one source, one per row of its root."""

    parameters: Annotated[np.ndarray, "(k, 2)"]
    """B (N·m·s/rad) and K (N·m/rad)."""
    signals: Annotated[np.ndarray, "(k, trials, n, 3)"] | None = None
    """Torque (N·m), angle (rad) and rate (rad/s) of the mean responses; None where they do not change."""

    def times(self, factor: float) -> "Change":
        """The change by another size of its source."""
        return Change(factor * self.parameters, None if self.signals is None else factor * self.signals)


@dataclass(frozen=True)
class ReflexEstimate:
    """Numbers of `REFLEX` with their uncertainty."""

    values: Annotated[np.ndarray, "(4,)"]
    budget: Budget
    undetermined: tuple[str, ...]
    """Names of those that the responses do not determine."""
    mean: MeanReflex
    error: Annotated[np.ndarray, "(n,)", "N·m"]
    """Standard uncertainty of the mean torque."""


def estimate_reflex(
    time: np.ndarray,
    means: Annotated[np.ndarray, "(trials, n, 3)"],
    parameters: np.ndarray,
    scatter: Sequence[Change],
    freedom_a: float,
    sources: Mapping[str, Change],
    freedom: dict[str, float],
    expected: Change | None = None,
) -> ReflexEstimate:
    """Peak, impulse, gain and delay of the reflex torque, and their budget.

    time: instants of the responses from the onset (s).
    means: torque (N·m), angle (rad) and rate (rad/s) of the mean response of every trial.
    parameters: B (N·m·s/rad) and K (N·m/rad).
    scatter, freedom_a: changes that make up Type A, and its degrees of freedom.
    sources, freedom: source of Type B -> changes and degrees of freedom.
    expected: systematic change of the torque, one row, which is removed.
    """
    motion = means[..., [2, 1]]
    torques = means[..., 0] - motion @ parameters
    mean = mean_reflex(time, torques, means[..., 1])
    ways, at = stretches(means[..., 1])

    def moved_by(change: Change) -> tuple[np.ndarray, np.ndarray]:
        """Changes of the mean torque, shape (k, n), and of the stretch, shape (k,)."""
        moved = -np.einsum("j,jtp,kp->kt", ways, motion, change.parameters) / len(ways)
        longer = np.zeros(len(moved))
        if change.signals is not None:
            own = change.signals[..., 0] - change.signals[..., [2, 1]] @ parameters
            moved = moved + np.einsum("j,kjt->kt", ways, own) / len(ways)
            longer = (ways * change.signals[:, np.arange(len(ways)), at, 1]).mean(axis=1)
        return _interpolated(time, moved), longer

    def root(moved: np.ndarray, longer: np.ndarray) -> Annotated[np.ndarray, "(k, 4)"]:
        return 0.5 * (mean.with_changes(moved, longer) - mean.with_changes(-moved, -longer))

    if expected is not None:
        mean = mean.changed(-moved_by(expected)[0][0], 0.0)
    of_scatter = [moved_by(change) for change in scatter]
    of_sources = {name: moved_by(change) for name, change in sources.items()}
    type_a = np.sqrt(sum((root(*found) ** 2).sum(axis=0) for found in of_scatter))
    budget = Budget(type_a, freedom_a, {name: root(*found) for name, found in of_sources.items()}, freedom)
    every = (*of_scatter, *of_sources.values())
    values, error = mean.values, np.sqrt(sum((moved**2).sum(axis=0) for moved, _ in every))
    low = budget.interval(values, CERTAIN)[0]
    if not low[0] > 0.0:
        undetermined = REFLEX
    else:
        surely = float(coverage_factor(budget.effective_freedom[0], CERTAIN))
        early = mean.torque[0] + surely * error[0] >= RISEN * values[0]
        undetermined = REFLEX[3:] if early or not low[3] >= REFLEX_S[0] else ()
    return ReflexEstimate(values, budget, tuple(undetermined), mean, error)
