"""Fit of the frame with bristle friction to the mean pulses of the calibration trials.

Force and moment are fitted together, with a free zero per trial, because transducers drift and bristles hold
a force between the pulses. All combinations of the terms beyond the loaded frame are fitted, each from
several starts: the constants of the combinations with one term less, and the usual ones. The combination is
kept whose error of trials that are left out in turn is least, where every further term must bring a clear
gain: a treadmill without memory gets a model without bristles. A constant that ends at a bound counts as one
term more. Where even the best leaves far more than noise, a response without physics takes its
place (`tepsipe.treadmill.mass_models`), if it halves the left-out error.

The search for the constants of one variant: linear constants follow by least squares for every set of the
others (variable projection; Golub & Pereyra 1973). Left-out errors follow from the linearised fit. So does
the covariance of the constants: trials are clusters with independent errors, whose residuals are corrected
for the leverage of the trial on the fit (bias-reduced linearisation; Bell & McCaffrey 2002). The jackknife
overstates the influence of a single trial, for example of the only one with the fastest pulse.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Annotated, NamedTuple

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.statistics.clusters import leave_out
from tepsipe.treadmill.black_box_models import BeltModel
from tepsipe.treadmill.bristle_frame import (
    AT,
    CONSTANTS,
    IDLE,
    RUBBING,
    BristleFrame,
    Constants,
    frame_response,
    mount_response,
)
from tepsipe.treadmill.mass_models import MassResponse, fit_mass_response
from tepsipe.treadmill.pulse_windows import (
    Bristles,
    PulseWindows,
    by_direction,
    coarse_spectrum,
    mean_state,
    pulse_windows,
)
from tepsipe.treadmill.recording import BeltRecording

# terms beyond the loaded frame, each with its constants and the term that it needs
TERMS = {
    "bristles": (("bristle_m", "bristle", "bristle_per_kg"), None),
    "stribeck": (("stribeck", "stribeck_speed_m_per_s"), "bristles"),
    "lever": (("lever_m", "cross_talk_m"), None),
    "second-mode": (("second_mode", "second_mode_moment", "second_slowness"), None),
}
# constants that switch their term off where they are 0
SWITCHES = ("stribeck", "second_mode", "second_mode_moment")
# part of the load's root mean square that no model of this kind predicts
DISCREPANCY = 0.005
# evaluations after which the search of a variant ends: from a start that is only tried, from the best start,
# and of the chosen variant
BRIEF, FEW, MOST = 8, 30, 200
AT_BOUND = 2e-3  # distance of a constant from its bound that counts as none (scales of the constants)
KEPT = 64  # spectra of friction that are kept
STIFF_S2 = 1.0 / (2.0 * np.pi * 50.0) ** 2


class Search(NamedTuple):
    """Search for one constant: its scale, and start and bounds in units of the scale."""

    scale: float
    start: float
    low: float
    high: float


# the first constants of `Constants` are searched for; the others follow by least squares
SEARCHES = {
    "damping_s": Search(1e-3, 0.5, -5.0, 20.0),
    "slowness_s2": Search(STIFF_S2, 1.0, 0.0, 50.0),
    "slowness_s2_per_kg": Search(STIFF_S2 / 20.0, 0.1, 0.0, 50.0),
    "second_mode": Search(0.1, 0.5, -5.0, 6.0),
    "second_mode_moment": Search(0.1, 0.5, -5.0, 6.0),
    "second_slowness": Search(1.0, 1.5, 0.3, 4.0),
    "lag_s": Search(1e-3, 1.0, -20.0, 20.0),
    "friction_speed_m_per_s": Search(0.1, 2.0, 0.1, 5.0),
    "mount_share": Search(0.05, 0.4, -10.0, 18.0),
    "mount_time_s": Search(0.05, 1.0, 0.1, 40.0),
    "bristle_m": Search(1e-3, 0.5, 0.01, 20.0),
    "stribeck": Search(1.0, 0.2, -0.5, 3.0),
    "stribeck_speed_m_per_s": Search(0.1, 0.5, 0.05, 5.0),
}
SEARCHED = len(SEARCHES)
SCALE, START, LOW, HIGH = np.array(list(SEARCHES.values())).T
# pre-sliding distances (m) and ratios of the second mode from which the search may start
TRIED = {"bristles": ("bristle_m", (5e-5, 2e-4, 8e-4, 3e-3)), "second-mode": ("second_slowness", (0.6, 1.6))}
# natural frequencies of the empty frame from which the search may start (Hz)
FRAMES_HZ = (30.0, 50.0, 80.0)
# standard deviations of weak priors about 0 (units of the constants)
PRIOR = {"second_mode": 0.2, "second_mode_moment": 0.2, "lever_m": 0.2, "cross_talk_m": 0.02}
COMPONENTS = ("Fy", "Mx")


@dataclass(frozen=True)
class Fit:
    """One variant of the search."""

    constants: np.ndarray
    converged: bool
    at_bound: bool
    """Whether the search ended at a bound."""
    cost: float
    """Sum of squares."""
    left_out: float
    """Mean square error of left-out trials."""
    without_trial: np.ndarray
    """Change of the constants without each trial."""
    spread: np.ndarray
    """Share of each trial in the error of the constants, bias-reduced."""


def noise_weights(windows: PulseWindows) -> dict[str, float]:
    """Component -> standard deviation of one pulse about the trial's mean, and of what no model predicts."""
    weights = {}
    for component, single in windows.single.items():
        noise, size = [], []
        for k, parts in enumerate(single):
            inside = parts[:, windows.evaluated[k]]
            inside = inside - inside.mean(axis=1, keepdims=True)
            if inside.shape[0] > 1:
                noise.append(np.mean(inside.var(axis=0, ddof=1)))
            carried = windows.carried[component][k][windows.evaluated[k]]
            total = inside.mean(axis=0) + carried - carried.mean()
            size.append(windows.count[k] * np.mean(total**2))
        usual = np.mean(noise) if noise else 0.0
        weights[component] = float(np.sqrt(usual + DISCREPANCY**2 * np.mean(size)))
    return weights


def centred(windows: PulseWindows, x: np.ndarray) -> np.ndarray:
    """Evaluated samples less their mean per trial, times the root of the number of pulses, shape (..., m)."""
    mask = windows.evaluated
    mean = np.sum(x * mask, axis=-1) / mask.sum(axis=1)
    # flat positions are faster than [..., mask]
    trial, _ = np.nonzero(mask)
    inside = x.reshape(*x.shape[:-2], -1)[..., np.flatnonzero(mask)]
    return (inside - mean[..., trial]) * np.sqrt(windows.count)[trial]


class Signals:
    """Spectra of the trials' signals, each of shape (trials, n // 2 + 1), and measured load, `centred`.

    The spectra of friction are kept: most steps of a search leave them as they are.
    """

    def __init__(self, windows: PulseWindows):
        self.windows = windows
        self.acceleration, self.velocity = (
            np.fft.rfft(x, axis=1) for x in (windows.acceleration, windows.velocity)
        )
        self.carried = {c: np.fft.rfft(x, axis=1) for c, x in windows.carried.items()}
        self.total = {c: centred(windows, x + windows.carried[c]) for c, x in windows.load.items()}
        self._smooth = lru_cache(KEPT)(self._smooth)
        self._bent = lru_cache(KEPT)(self._bent)

    def _sliding(self, lag_s: float) -> np.ndarray:
        return self.windows.fine_velocity + lag_s * self.windows.fine_acceleration

    def _smooth(self, lag_s: float, friction_speed_m_per_s: float) -> np.ndarray:
        w = self._sliding(lag_s)
        return coarse_spectrum(self.windows, w / np.hypot(friction_speed_m_per_s, w))

    def _bent(self, lag_s: float, bristles: Bristles) -> np.ndarray:
        return coarse_spectrum(self.windows, mean_state(self.windows, self._sliding(lag_s), bristles))

    def rubbing(self, constants: Constants, bristles: bool) -> list[np.ndarray]:
        """Signals that the terms of friction multiply (m/s, or no unit; per kg)."""
        kg = self.windows.kg[:, None]
        smooth = self._smooth(constants.lag_s, constants.friction_speed_m_per_s)
        found = [self.velocity + constants.lag_s * self.acceleration, smooth, kg * smooth]
        if bristles:
            z = self._bent(constants.lag_s, constants.bristles)
            found += [z, kg * z]
        return found


def _responses(windows: PulseWindows, constants: Constants) -> dict[str, np.ndarray]:
    """Component -> response of frame and mounts, shape (trials, n // 2 + 1).

    ``pull`` is that of the moment to the force on a weight and its belt.
    """
    s, kg = windows.s[None, :], windows.kg[:, None]
    empty, under = (frame_response(constants, s, mass, "Mx") for mass in (0.0, kg))
    force = frame_response(constants, s, kg, "Fy") * mount_response(constants, s)
    return {"Fy": force, "Mx": empty + 0.0 * kg, "pull": windows.height_m[:, None] * (empty - under)}


def _solve(
    signals: Signals, searched: np.ndarray, terms: tuple[str, ...], weights: dict[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """All constants, the linear ones by least squares, and residuals relative to the noise, shape (2 m,)."""
    windows, named = signals.windows, Constants(*searched.tolist())
    rubbing = signals.rubbing(named, "bristles" in terms)
    responses = _responses(windows, named)

    def least_squares(
        component: str, columns: list[np.ndarray], priors: dict[int, float], known: np.ndarray | float = 0.0
    ):
        spectra = np.array([*columns, signals.carried[component]]) * responses[component]
        spectra[-1] += known
        seen = centred(windows, np.fft.irfft(spectra, windows.samples, axis=2)) / weights[component]
        rows = seen[:-1].T
        target = signals.total[component] / weights[component] - seen[-1]
        size = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
        held = np.array([1.0 / priors[k] if k in priors else 0.0 for k in range(size.size)]) / size
        stacked = np.concatenate([rows / size, np.diag(held)])
        solution = np.linalg.lstsq(stacked, np.append(target, np.zeros(size.size)), rcond=1e-10)[0] / size
        return solution, target - rows @ solution

    force, left_force = least_squares("Fy", [signals.acceleration, *rubbing], {})
    columns, priors = [signals.acceleration, signals.velocity], {}
    if "lever" in terms:
        friction = sum(b * x for b, x in zip(force[1:], rubbing, strict=True))
        columns += [friction, signals.carried["Fy"]]
        priors = {2: PRIOR["lever_m"], 3: PRIOR["cross_talk_m"]}
    own = sum(b * x for b, x in zip(force, [signals.acceleration, *rubbing], strict=True))
    pull = responses["pull"] * (signals.carried["Fy"] + own)
    moment, left_moment = least_squares("Mx", columns, priors, pull)
    constants = np.zeros(len(CONSTANTS))
    constants[:SEARCHED] = searched
    constants[SEARCHED : SEARCHED + force.size] = force
    constants[AT["moment_mass"] : AT["moment_mass"] + moment.size] = moment
    return constants, np.concatenate([left_force, left_moment])


def _changed(x: np.ndarray, k: int, value: float) -> np.ndarray:
    changed = x.copy()
    changed[k] = value
    return changed


def _absent(terms: tuple[str, ...]) -> list[str]:
    """Constants of the terms that a variant lacks."""
    names = [name for term, (names, _) in TERMS.items() if term not in terms for name in names]
    return [*names, "response_share"]


def search(
    signals: Signals,
    weights: dict[str, float],
    terms: tuple[str, ...],
    starts: list[np.ndarray],
    most: int = FEW,
) -> Fit:
    """Search for the constants of one variant from the best of several starts."""
    windows, absent = signals.windows, _absent(terms)
    free = np.array([k for k in range(SEARCHED) if CONSTANTS[k] not in absent])
    scale = SCALE.copy()
    scale[AT["slowness_s2_per_kg"]] *= 20.0 / windows.kg.max()
    base = _best_start(signals, weights, terms, starts)

    def whole(x: np.ndarray) -> np.ndarray:
        full = base.copy()
        full[free] = x * scale[free]
        return full

    def error(x: np.ndarray) -> np.ndarray:
        searched = whole(x)
        weak = [searched[AT[name]] / PRIOR[name] for name in ("second_mode", "second_mode_moment")]
        return np.append(_solve(signals, searched, terms, weights)[1], weak)

    low, high = LOW[free], HIGH[free]
    first = np.clip(base[free] / scale[free], low + 1e-3, high - 1e-3)
    solution = scipy.optimize.least_squares(
        error,
        first,
        bounds=(low, high),
        diff_step=1e-3,
        x_scale=np.maximum(np.abs(first), 0.1),
        ftol=1e-5,
        max_nfev=most,
    )
    constants, _ = _solve(signals, whole(solution.x), terms, weights)
    ends = np.minimum(solution.x - low, high - solution.x) < AT_BOUND
    # v_0 at a bound is no fault: where bristles explain the friction, the smooth part is about 0
    at_bound = bool(ends[free != AT["friction_speed_m_per_s"]].any())
    converged = bool(solution.success and not at_bound)
    return Fit(
        constants, converged, at_bound, float(solution.cost), *_leave_out(signals, weights, terms, constants)
    )


def _best_start(
    signals: Signals, weights: dict[str, float], terms: tuple[str, ...], starts: list[np.ndarray]
) -> np.ndarray:
    """The start with the least error, with the terms of a variant switched on, each from several values."""
    absent, tried = _absent(terms), []
    for start in starts:
        base = start.copy()
        for name in SWITCHES:
            base[AT[name]] = 0.0 if name in absent else base[AT[name]] or (START * SCALE)[AT[name]]
        found = [base]
        for name, values in (TRIED[term] for term in TRIED if term in terms):
            found += [_changed(x, AT[name], value) for x in list(found) for value in values]
        tried += found
    return min(tried, key=lambda x: float(np.sum(_solve(signals, x, terms, weights)[1] ** 2)))


def residuals(windows: PulseWindows, constants: Annotated[np.ndarray, "(24,)"]) -> dict[str, np.ndarray]:
    """Measured less modelled mean pulses.

    constants: those of `tepsipe.treadmill.bristle_frame.Constants` in their order.
    Returns: component -> residual (N, N·m).
    """
    return modelled_residuals(Signals(windows), constants)


def modelled_residuals(signals: Signals, constants: np.ndarray) -> dict[str, np.ndarray]:
    """As `residuals` (N, N·m)."""
    windows, named = signals.windows, Constants(*constants.tolist())
    rubbing = signals.rubbing(named, bool(named.bristle or named.bristle_per_kg))
    # a model without bristles has no signals for the last two factors
    friction = sum(getattr(named, name) * x for name, x in zip(RUBBING, rubbing, strict=False))
    added = {
        "Fy": named.force_mass * signals.acceleration + friction,
        "Mx": named.moment_mass * signals.acceleration
        + named.moment_viscous * signals.velocity
        + named.lever_m * friction
        + named.cross_talk_m * signals.carried["Fy"],
    }
    residual, responses = {}, _responses(windows, named)
    known = {"Fy": 0.0, "Mx": responses["pull"] * (signals.carried["Fy"] + added["Fy"])}
    for c in COMPONENTS:
        spectrum = (signals.carried[c] + added[c]) * responses[c] + known[c]
        modelled = np.fft.irfft(spectrum, windows.samples, axis=1)
        residual[c] = windows.load[c] + windows.carried[c] - modelled
    return residual


def _leave_out(
    signals: Signals, weights: dict[str, float], terms: tuple[str, ...], constants: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """Mean square error of left-out trials relative to the noise, the constants' change without each, and a
    root of their covariance, with a row for each trial.
    """
    windows, absent = signals.windows, _absent(terms)
    free = [k for k, name in enumerate(CONSTANTS) if name not in absent]
    trial = np.tile(np.repeat(np.arange(windows.kg.size), windows.evaluated.sum(axis=1)), len(COMPONENTS))

    def weighted(x: np.ndarray) -> np.ndarray:
        residual = modelled_residuals(signals, x)
        return np.concatenate([centred(windows, residual[c]) / weights[c] for c in COMPONENTS])

    error = weighted(constants)
    least = np.concatenate([0.1 * SCALE, np.full(len(CONSTANTS) - SEARCHED, 1e-3)])
    steps = 1e-3 * np.maximum(np.abs(constants), least)
    slopes = np.empty((error.size, len(free)))
    for column, k in enumerate(free):
        step = np.zeros(len(CONSTANTS))
        step[k] = steps[k]
        slopes[:, column] = (error - weighted(constants + step)) / steps[k]
    norm = np.maximum(np.linalg.norm(slopes, axis=0), 1e-300)
    slopes /= norm
    names = [CONSTANTS[k] for k in free]
    prior = np.array([PRIOR.get(name, np.inf) for name in names]) * norm
    squares, *found = leave_out(slopes, error, trial, prior**-2.0 + 1e-9)
    changes, spread = np.zeros((2, windows.kg.size, len(CONSTANTS)))
    changes[:, free], spread[:, free] = (x / norm for x in found)
    return float(squares.sum()), changes, spread


# smallest relative gain of the mean square error of left-out trials that another term must bring
GAIN = 0.1
# a response without physics is tried where the error of left-out trials exceeds this times the noise, and
# kept where it brings this relative gain of the mean square
UNEXPLAINED, WITHOUT_GAIN = 3.0, 0.5
# standard deviation of the constant `response_share`
SHARE_SD = 0.5
PLAIN = "loaded frame"  # the variant without further terms
WITHOUT = "without-physics"  # a response of every mass


@dataclass(frozen=True)
class Calibrated:
    """A fitted model with the draws of its errors."""

    models: dict[str, BeltModel]
    """Component -> model, with the same constants."""
    residuals: Callable[[PulseWindows, np.ndarray], dict[str, np.ndarray]]
    """Function of pulses and constants: component -> measured less modelled mean pulses (N, N·m)."""
    deviations: Annotated[np.ndarray, "(draws, 24)"]
    """Draws of the errors of the constants."""
    without_trial: Annotated[np.ndarray, "(trials, 24)"]
    """Change of the constants if a trial is left out."""
    left_out: dict[str, float]
    """Terms joined by ``+``, for every variant that was fitted -> root mean square error of left-out trials
    relative to the noise."""
    error: float
    """The error of ``left_out`` of the variant that was chosen."""
    by_mass: tuple[dict[str, MassResponse], ...] = ()
    """Of a model without physics: component -> its response if a trial is left out, trial by trial."""


def fit_bristle_frame(
    trials: list[dict[str, BeltRecording]],
    draws: int,
    rng: np.random.Generator,
    like: Calibrated | None = None,
) -> Calibrated:
    """Fit all trials together.

    trials: for each calibration trial component Fy or Mx -> recording, with two masses or more.
    draws: number of draws of the errors of the constants.
    like: fit of the same trials with another filter, whose terms are kept.
    """
    windows = pulse_windows(left_out_in_turn(trials))
    weights = noise_weights(windows)
    heaviest_kg = heaviest(windows)
    if like is None:
        best, kept, scores = _chosen(windows, weights)
    elif like.by_mass:
        best, kept, scores = None, (), {}
    else:
        known = like.models["Fy"]
        kept = known.terms
        best = search(Signals(windows), weights, kept, [known.constants[:SEARCHED]])
        scores = {"+".join(kept) or PLAIN: float(np.sqrt(best.left_out))}
    if best is None or np.sqrt(best.left_out) > UNEXPLAINED:
        left_out, responses = _without_physics(windows, weights)
        scores[WITHOUT] = float(np.sqrt(left_out))
        if best is None or left_out < (1.0 - WITHOUT_GAIN) * best.left_out:
            deviations = np.zeros((draws, len(CONSTANTS)))
            deviations[:, AT["response_share"]] = SHARE_SD * rng.standard_normal(draws)
            idle = IDLE._replace(response_share=0.0)
            models = {
                c: BristleFrame(
                    c, np.array(idle), (WITHOUT,), windows.rate_hz, heaviest_kg, True, responses[0][c]
                )
                for c in COMPONENTS
            }
            without = np.zeros((windows.kg.size, len(CONSTANTS)))
            return Calibrated(models, residuals, deviations, without, scores, scores[WITHOUT], responses[1:])
    deviations = rng.standard_normal((draws, windows.kg.size)) @ best.spread
    models = {
        c: BristleFrame(c, best.constants, kept, windows.rate_hz, heaviest_kg, best.converged)
        for c in COMPONENTS
    }
    return Calibrated(
        models, residuals, deviations, best.without_trial, scores, float(np.sqrt(best.left_out))
    )


def heaviest(windows: PulseWindows) -> float:
    """Largest mass of a calibration (kg), which needs two masses or more."""
    masses = sorted(set(windows.kg.tolist()))
    if len(masses) < 2:
        raise InputError(
            f"{windows.names[0]}: expected recordings with at least two different masses on the belt, "
            f"found only {masses[0]:g} kg: record the empty belt, a weight, and a weight near that of "
            "the subject, each with the subject's pulses"
        )
    return float(masses[-1])


def left_out_in_turn(trials: list[dict[str, BeltRecording]]) -> list[dict[str, BeltRecording]]:
    """Trials that can be left out of a fit (N, N·m).

    Pulses of opposite directions are trials of their own; the only one of a mass is split, pulse by pulse, in
    two.

    trials: for each trial component Fy or Mx -> recording.
    Returns: in the same order.
    """
    trials = by_direction(trials)
    masses = [trial["Fy"].carried_kg for trial in trials]
    parts_of_trials = []
    for trial, kg in zip(trials, masses, strict=True):
        if masses.count(kg) > 1 or len(trial["Fy"].onsets) < 2:
            parts_of_trials.append(trial)
            continue
        for half in (0, 1):
            parts = {
                c: replace(r, name=f"{r.name}, half {half + 1}", onsets=r.onsets[half::2])
                for c, r in trial.items()
            }
            parts_of_trials.append(parts)
    return parts_of_trials


def _combinations() -> list[tuple[str, ...]]:
    """Every combination of the terms in which each has the term that it needs, small ones first."""
    found = [c for size in range(len(TERMS) + 1) for c in itertools.combinations(TERMS, size)]
    return [c for c in found if all(TERMS[term][1] in (None, *c) for term in c)]


def _usual() -> list[np.ndarray]:
    """Usual constants, each with another frame."""
    frame, found = [AT["slowness_s2"], AT["slowness_s2_per_kg"]], []
    for hz in FRAMES_HZ:
        constants = START * SCALE
        constants[frame] *= (50.0 / hz) ** 2
        found.append(constants)
    return found


def _chosen(
    windows: PulseWindows, weights: dict[str, float]
) -> tuple[Fit, tuple[str, ...], dict[str, float]]:
    """The best variant, its terms, and the left-out error of every variant."""
    fits: dict[tuple[str, ...], Fit] = {}
    signals = Signals(windows)
    for terms in _combinations():
        smaller = [fits[c] for c in fits if len(c) + 1 == len(terms) and set(c) < set(terms)]
        usual, known = _usual(), [fit.constants[:SEARCHED] for fit in smaller]
        found = [search(signals, weights, terms, known or usual)]
        # frames of every frequency have been tried with one term or none
        other = search(signals, weights, terms, usual, BRIEF) if len(terms) < 2 else found[0]
        if other.cost < found[0].cost:
            found.append(search(signals, weights, terms, [other.constants[:SEARCHED]]))
        fits[terms] = min(found, key=lambda fit: _penalised(fit, terms))
    terms = min(fits, key=lambda c: _penalised(fits[c], c))
    scores = {"+".join(c) or PLAIN: float(np.sqrt(fit.left_out)) for c, fit in fits.items()}
    return search(signals, weights, terms, [fits[terms].constants[:SEARCHED]], MOST), terms, scores


def _penalised(fit: Fit, terms: tuple[str, ...]) -> float:
    """Left-out error with the gain that every term must bring, where a constant at its bound is one more."""
    return fit.left_out / (1.0 - GAIN) ** (len(terms) + fit.at_bound)


def _without_physics(
    windows: PulseWindows, weights: dict[str, float]
) -> tuple[float, tuple[dict[str, MassResponse], ...]]:
    """Mean square error of left-out trials relative to the noise, and component -> response, fitted to all
    trials and without each trial in turn.
    """
    every = np.arange(windows.kg.size)
    fits = [
        {c: fit_mass_response(windows, windows.load[c], every != k) for c in COMPONENTS} for k in (-1, *every)
    ]
    total = 0.0
    for k, fit in enumerate(fits[1:]):
        for c, response in fit.items():
            left = (windows.load[c] - response.in_windows(windows)) * (every == k)[:, None]
            total += float(np.sum((centred(windows, left) / weights[c]) ** 2))
    return total / (len(COMPONENTS) * int(windows.evaluated.sum())), tuple(fits)
