"""Fit of the frame with bristle friction to the mean pulses of the calibration trials.

Force and moment are fitted together, with a free zero per trial, because transducers drift and bristles hold
a force between the pulses. Linear constants follow by least squares for every set of the others (variable
projection; Golub & Pereyra 1973). The fit begins with the loaded frame and adds the term that most reduces
the error of trials that are left out in turn, as long as the gain is clear: a treadmill without memory gets a
model without bristles. Left-out errors follow from the linearised fit. So does the covariance of the
constants: trials are clusters with independent errors, whose residuals are corrected for the leverage of the
trial on the fit (bias-reduced linearisation; Bell & McCaffrey 2002). The jackknife overstates the influence
of a single trial, for example of the only one with the fastest pulse.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.statistics.clusters import bias_reduced_share
from tepsipe.treadmill.bristle_frame import (
    AT,
    CONSTANTS,
    RUBBING,
    BristleFrame,
    Constants,
    frame_response,
    mount_response,
)
from tepsipe.treadmill.pulse_windows import PulseWindows, coarse_spectrum, mean_state, pulse_windows
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
# smallest relative gain of the mean square error of left-out trials that another term must bring
GAIN = 0.1
# part of the load's root mean square that no model of this kind predicts
DISCREPANCY = 0.005
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
    "damping_s_per_kg": Search(1e-5, 0.0, -10.0, 10.0),
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
# standard deviations of weak priors about 0 (units of the constants)
PRIOR = {"second_mode": 0.2, "second_mode_moment": 0.2, "lever_m": 0.2, "cross_talk_m": 0.02}
COMPONENTS = ("Fy", "Mx")
PLAIN = "loaded frame"  # the variant without further terms


@dataclass(frozen=True)
class Calibrated:
    """A fitted model with the draws of its errors.

    Attributes
    ----------
    models : dict of str to BristleFrame
        Component -> model.
    deviations : ndarray, shape (draws, 24)
        Draws of the errors of the constants.
    without_trial : ndarray, shape (trials, 24)
        Change of the constants if a trial is left out.
    left_out : dict of str to float
        Terms joined by ``+``, for every variant that was fitted -> root mean square error of left-out
        trials relative to the noise.
    """

    models: dict[str, BristleFrame]
    deviations: np.ndarray
    without_trial: np.ndarray
    left_out: dict[str, float]


@dataclass(frozen=True)
class _Fit:
    """One variant: constants, whether the search converged, their change without each trial, their spread."""

    constants: np.ndarray
    converged: bool
    left_out: float
    without_trial: np.ndarray
    spread: np.ndarray


def fit_bristle_frame(
    trials: list[dict[str, BeltRecording]],
    draws: int,
    rng: np.random.Generator,
    like: Calibrated | None = None,
) -> Calibrated:
    """Fit all trials together.

    Parameters
    ----------
    trials : list of dict of str to BeltRecording
        For each calibration trial component Fy or Mx -> recording (N, N·m), with two masses or more.
    draws : int
        Number of draws of the errors of the constants.
    rng : numpy.random.Generator
        Draws them.
    like : Calibrated, optional
        Fit of the same trials with another filter, whose terms are kept.

    Returns
    -------
    Calibrated
        Models of both components.

    Raises
    ------
    InputError
        If all trials carry the same mass, or their pulses cannot be used.
    """
    windows = pulse_windows(left_out_in_turn(trials))
    masses = sorted(set(windows.kg.tolist()))
    if len(masses) < 2:
        raise InputError(
            f"{windows.names[0]}: expected recordings with at least two different masses on the belt, "
            f"found only {masses[0]:g} kg: record the empty belt, a weight, and a weight near that of "
            "the subject, each with the subject's pulses"
        )
    if like is None:
        best, kept, scores = _chosen(windows, _weights(windows))
    else:
        known = like.models["Fy"]
        kept = known.terms
        best = _fit(windows, _weights(windows), kept, known.constants[:SEARCHED])
        scores = {"+".join(kept) or PLAIN: float(np.sqrt(best.left_out))}
    deviations = rng.standard_normal((draws, windows.kg.size)) @ best.spread
    models = {
        component: BristleFrame(
            component, best.constants, kept, windows.rate_hz, float(masses[-1]), best.converged
        )
        for component in COMPONENTS
    }
    return Calibrated(models, deviations, best.without_trial, scores)


def left_out_in_turn(trials: list[dict[str, BeltRecording]]) -> list[dict[str, BeltRecording]]:
    """Trials that can be left out of a fit (N, N·m): the only one of a mass is split, pulse by pulse, in two.

    Parameters
    ----------
    trials : list of dict of str to BeltRecording
        For each trial component Fy or Mx -> recording (N, N·m).

    Returns
    -------
    list of dict of str to BeltRecording
        In the same order.
    """
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


def _chosen(
    windows: PulseWindows, weights: dict[str, float]
) -> tuple[_Fit, tuple[str, ...], dict[str, float]]:
    """The best variant, its terms, and the left-out error of every variant that was fitted."""
    kept: tuple[str, ...] = ()
    best = _fit(windows, weights, kept, START * SCALE)
    scores = {PLAIN: float(np.sqrt(best.left_out))}
    while True:
        more = [t for t, (_, needed) in TERMS.items() if t not in kept and needed in (None, *kept)]
        tried = {
            (*kept, term): _fit(windows, weights, (*kept, term), best.constants[:SEARCHED]) for term in more
        }
        scores |= {"+".join(terms): float(np.sqrt(fit.left_out)) for terms, fit in tried.items()}
        terms = min(tried, key=lambda t: tried[t].left_out, default=kept)
        if terms == kept or tried[terms].left_out > (1.0 - GAIN) * best.left_out:
            return best, kept, scores
        kept, best = terms, tried[terms]


def _weights(windows: PulseWindows) -> dict[str, float]:
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


def _centred(windows: PulseWindows, x: np.ndarray) -> np.ndarray:
    """Evaluated samples less the mean of each trial, times the root of its number of pulses, shape (m,)."""
    mask = windows.evaluated
    mean = np.sum(x * mask, axis=1) / mask.sum(axis=1)
    return ((x - mean[:, None]) * np.sqrt(windows.count)[:, None])[mask]


def _columns(
    windows: PulseWindows, constants: Constants, bristles: bool
) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Spectra of a, v and of what the terms of friction multiply, each of shape (trials, n // 2 + 1)."""
    w = windows.fine_velocity + constants.lag_s * windows.fine_acceleration
    acceleration, velocity = (np.fft.rfft(x, axis=1) for x in (windows.acceleration, windows.velocity))
    kg = windows.kg[:, None]
    smooth = coarse_spectrum(windows, w / np.hypot(constants.friction_speed_m_per_s, w))
    rubbing = [velocity + constants.lag_s * acceleration, smooth, kg * smooth]
    if bristles:
        z = coarse_spectrum(windows, mean_state(windows, w, constants.bristles))
        rubbing += [z, kg * z]
    return acceleration, velocity, rubbing


def _responses(windows: PulseWindows, constants: Constants) -> dict[str, np.ndarray]:
    """Component -> response of frame and mounts, shape (trials, n // 2 + 1)."""
    s, kg = windows.s[None, :], windows.kg[:, None]
    force, moment = (frame_response(constants, s, kg, component) for component in COMPONENTS)
    return {"Fy": force * mount_response(constants, s), "Mx": moment}


def _solve(
    windows: PulseWindows, searched: np.ndarray, terms: tuple[str, ...], weights: dict[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """All constants, the linear ones by least squares, and residuals relative to the noise, shape (2 m,)."""
    named = Constants(*searched.tolist())
    acceleration, velocity, rubbing = _columns(windows, named, "bristles" in terms)
    responses = _responses(windows, named)
    carried = {c: np.fft.rfft(x, axis=1) for c, x in windows.carried.items()}

    def least_squares(component: str, columns: list[np.ndarray], priors: dict[int, float]):
        def seen(spectrum: np.ndarray) -> np.ndarray:
            filtered = np.fft.irfft(spectrum * responses[component], windows.samples, axis=1)
            return _centred(windows, filtered) / weights[component]

        rows = np.column_stack([seen(x) for x in columns])
        total = _centred(windows, windows.load[component] + windows.carried[component]) / weights[component]
        target = total - seen(carried[component])
        size = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
        held = np.array([1.0 / priors[k] if k in priors else 0.0 for k in range(size.size)]) / size
        stacked = np.concatenate([rows / size, np.diag(held)])
        solution = np.linalg.lstsq(stacked, np.append(target, np.zeros(size.size)), rcond=1e-10)[0] / size
        return solution, target - rows @ solution

    force, left_force = least_squares("Fy", [acceleration, *rubbing], {})
    columns, priors = [acceleration, velocity], {}
    if "lever" in terms:
        friction = sum(b * x for b, x in zip(force[1:], rubbing, strict=True))
        columns += [friction, carried["Fy"]]
        priors = {2: PRIOR["lever_m"], 3: PRIOR["cross_talk_m"]}
    moment, left_moment = least_squares("Mx", columns, priors)
    constants = np.zeros(len(CONSTANTS))
    constants[:SEARCHED] = searched
    constants[SEARCHED : SEARCHED + force.size] = force
    constants[AT["moment_mass"] : AT["moment_mass"] + moment.size] = moment
    return constants, np.concatenate([left_force, left_moment])


def _absent(terms: tuple[str, ...]) -> list[str]:
    """Constants of the terms that a variant lacks."""
    return [name for term, (names, _) in TERMS.items() if term not in terms for name in names]


def _fit(windows: PulseWindows, weights: dict[str, float], terms: tuple[str, ...], start: np.ndarray) -> _Fit:
    """Search for the constants of one variant, starting from a smaller variant's constants."""
    absent = _absent(terms)
    free = np.array([k for k in range(SEARCHED) if CONSTANTS[k] not in absent])
    scale = SCALE.copy()
    scale[AT["slowness_s2_per_kg"]] *= 20.0 / windows.kg.max()
    base = start.copy()
    for name in SWITCHES:
        base[AT[name]] = 0.0 if name in absent else base[AT[name]] or (START * SCALE)[AT[name]]

    def whole(x: np.ndarray) -> np.ndarray:
        full = base.copy()
        full[free] = x * scale[free]
        return full

    def error(x: np.ndarray) -> np.ndarray:
        searched = whole(x)
        solution = _solve(windows, searched, terms, weights)[1]
        weak = [searched[AT[name]] / PRIOR[name] for name in ("second_mode", "second_mode_moment")]
        return np.append(solution, weak)

    for name, values in (TRIED[term] for term in TRIED if term in terms):
        starts = [base.copy() for _ in range(len(values) + 1)]
        for x, value in zip(starts, values, strict=False):
            x[AT[name]] = value
        base = min(starts, key=lambda x: float(np.sum(_solve(windows, x, terms, weights)[1] ** 2)))
    low, high = LOW[free], HIGH[free]
    first = np.clip(base[free] / scale[free], low + 1e-3, high - 1e-3)
    solution = scipy.optimize.least_squares(
        error,
        first,
        bounds=(low, high),
        diff_step=1e-3,
        x_scale=np.maximum(np.abs(first), 0.1),
        ftol=1e-5,
        max_nfev=30,
    )
    constants, _ = _solve(windows, whole(solution.x), terms, weights)
    # v_0 at a bound is no fault: where bristles explain the friction, the smooth part is about 0
    at_bound = solution.active_mask[free != AT["friction_speed_m_per_s"]].any()
    converged = bool(solution.success and not at_bound)
    return _Fit(constants, converged, *_leave_out(windows, weights, terms, constants))


def residuals(windows: PulseWindows, constants: np.ndarray) -> dict[str, np.ndarray]:
    """Measured less modelled mean pulses.

    Parameters
    ----------
    windows : PulseWindows
        The trials.
    constants : ndarray, shape (24,)
        Those of `tepsipe.treadmill.bristle_frame.Constants` in their order.

    Returns
    -------
    dict of str to ndarray, shape (trials, n)
        Component -> residual (N, N·m).
    """
    named = Constants(*constants.tolist())
    bristles = bool(named.bristle or named.bristle_per_kg)
    acceleration, velocity, rubbing = _columns(windows, named, bristles)
    carried = {c: np.fft.rfft(x, axis=1) for c, x in windows.carried.items()}
    # a model without bristles has no signals for the last two factors
    friction = sum(getattr(named, name) * x for name, x in zip(RUBBING, rubbing, strict=False))
    added = {
        "Fy": named.force_mass * acceleration + friction,
        "Mx": named.moment_mass * acceleration
        + named.moment_viscous * velocity
        + named.lever_m * friction
        + named.cross_talk_m * carried["Fy"],
    }
    residual = {}
    for c, response in _responses(windows, named).items():
        modelled = np.fft.irfft((carried[c] + added[c]) * response, windows.samples, axis=1)
        residual[c] = windows.load[c] + windows.carried[c] - modelled
    return residual


def _leave_out(
    windows: PulseWindows, weights: dict[str, float], terms: tuple[str, ...], constants: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """Mean square error of left-out trials relative to the noise, the constants' change without each, and a
    root of their covariance, with a row for each trial.
    """
    absent = _absent(terms)
    free = [k for k, name in enumerate(CONSTANTS) if name not in absent]
    trial = np.tile(np.repeat(np.arange(windows.kg.size), windows.evaluated.sum(axis=1)), len(COMPONENTS))

    def weighted(x: np.ndarray) -> np.ndarray:
        residual = residuals(windows, x)
        return np.concatenate([_centred(windows, residual[c]) / weights[c] for c in COMPONENTS])

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
    normal = slopes.T @ slopes + np.diag(prior**-2.0 + 1e-9)
    total, changes, spread = 0.0, *np.zeros((2, windows.kg.size, len(CONSTANTS)))
    for k in range(windows.kg.size):
        rows = slopes[trial == k]
        moment, information = rows.T @ error[trial == k], rows.T @ rows
        change = np.linalg.solve(normal - information, -moment)
        changes[k, free] = change / norm
        spread[k, free] = bias_reduced_share(normal, information, moment) / norm
        total += float(np.sum((error[trial == k] - rows @ change) ** 2))
    return total / error.size, changes, spread
