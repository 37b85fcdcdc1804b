"""Methods that answer the problems of a benchmark, at published settings: this project's are some of many.

Each method takes a `Problem` and returns its answers by quantity. A method that a kind of problem is not made
for returns none. A method that refuses a recording withdraws: it answers without a value, which counts as
flagged.

- `thesis`: torque by the printed equation (3-8), regression by (3-9), per perturbation, 20 Hz.
- `least_squares_by_hand`: what a script of a laboratory does: 20 Hz, central differences, least squares per
  perturbation or per 2 s, mean and Student's interval.
- `output_error`: angle of the leg simulated from the motion of the foot (`fit_output_error`).
- `ensemble`: realisations of 1 s fitted together (Ludvig & Perreault 2012, IEEE Transactions on Biomedical
  Engineering 59, 3541-3549).
- `parallel_cascade_1997`: impulse responses of the intrinsic and of the reflex pathway, in turns (Kearney,
  Stein & Parameswaran 1997, IEEE Transactions on Biomedical Engineering 44, 493-504): 100 Hz, intrinsic
  response of 40 ms to both sides, reflex response to the half-wave rectified velocity from 40 to 500 ms.
- `joint_likelihood`: likelihood of all markers and the log of the belt (`fit_joint_likelihood`).
- `tepsipe_defaults`: what this project recommends for an angle and a torque (`fit_impedance`,
  `fit_parallel_cascade`).
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.experiments.benchmark.problems import LEGS, QUANTITIES, UNITS, AnswerRow, Problem
from tepsipe.identification.fits import fit_impedance, fit_output_error, fit_parallel_cascade
from tepsipe.identification.likelihood_fit import fit_joint_likelihood
from tepsipe.identification.notes import of_choice
from tepsipe.identification.result import ImpedanceFit
from tepsipe.identification.time_varying import MovedJoint, impedance_of_ensemble
from tepsipe.mechanics.joint_torque import joint_torque
from tepsipe.mechanics.segment_kinematics import SegmentMotion, segment_motion
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.signals.perturbations import Perturbation, find_perturbations

# window of a standing person, before the earliest reflex torque (s)
BEFORE_REFLEX_S = 0.06
ENSEMBLE_S = 1.0


class Answer(NamedTuple):
    """An answer to one quantity of a problem (its unit); None where there is no value or no interval."""

    value: float | None = None
    low: float | None = None
    high: float | None = None
    flagged: bool = False


Answers = Mapping[str, Answer]
Method = Callable[[Problem], Answers]


def answer_all(
    problems: Iterable[Problem], methods: Mapping[str, Method], tell: Callable[[str], None] = lambda _: None
) -> dict[str, list[AnswerRow]]:
    """Answers of every method to all problems (units in `UNITS`).

    A method that refuses a recording withdraws its answer, which is then flagged. ``tell`` is given the name
    of the problem at work.
    """
    rows: dict[str, list[AnswerRow]] = {name: [] for name in methods}
    for problem in problems:
        tell(f", {problem.name}")
        for name, method in methods.items():
            try:
                answers = method(problem)
            except InputError:
                answers = dict.fromkeys(QUANTITIES[problem.kind], Answer(flagged=True))
            rows[name] += [AnswerRow(problem.name, *own) for own in _rows(answers)]
    return rows


def _rows(answers: Answers) -> Iterator[tuple[str, float | None, float | None, float | None, bool]]:
    """Quantity and answer; what is not finite is left out, an interval whose end is not as a whole."""
    for quantity, (value, *ends, flagged) in answers.items():
        if value is None or not math.isfinite(value):
            yield quantity, None, None, None, True
        elif None in ends or not np.isfinite(ends).all():
            yield quantity, value, None, None, flagged
        else:
            yield quantity, value, *ends, flagged


def thesis(problem: Problem) -> Answers:
    """Equations of the thesis as they are printed."""
    if problem.kind == "ankle":
        return {}
    time, angle, torque = _joint(problem)
    pulses = find_perturbations(time, problem.signals["belt"])
    if problem.kind not in LEGS:
        return _of_fit(problem, fit_impedance(time, angle, torque, perturbations=pulses, thesis=True))
    motion = _motion(problem)
    torque = joint_torque(motion, problem.leg, thesis=True)
    fit = fit_impedance(time, motion.theta, torque, perturbations=pulses, thesis=True, cutoff_hz=None)
    return _of_fit(problem, fit)


def least_squares_by_hand(problem: Problem) -> Answers:
    """Least squares per window, without any function of this project but the search for pulses."""
    time, *signals = _joint(problem)
    rate_hz = (time.size - 1) / (time[-1] - time[0])
    lowpass = scipy.signal.butter(2, 20.0, fs=rate_hz, output="sos")
    angle, torque = (scipy.signal.sosfiltfilt(lowpass, x) for x in signals)
    velocity = np.gradient(angle, time)
    columns = np.column_stack([np.gradient(velocity, time), velocity, angle, np.ones_like(angle)])
    if problem.kind == "ankle":
        edges = np.arange(0, time.size + 1, round(2.0 * rate_hz))
        windows = [slice(*ends) for ends in pairwise(edges[1:-1])]
    else:
        pulses = find_perturbations(time, problem.signals["belt"])
        windows = [slice(pulse.start, pulse.stop) for pulse in pulses]
    found = np.array([np.linalg.lstsq(columns[w], torque[w], rcond=None)[0][:3] for w in windows])
    n = len(found)
    half = scipy.special.stdtrit(n - 1, 0.975) * found.std(axis=0, ddof=1) / math.sqrt(n)
    answers = zip(UNITS, found.mean(axis=0).tolist(), half.tolist(), strict=True)
    return _asked(problem, {name: Answer(x, x - h, x + h) for name, x, h in answers})


def output_error(problem: Problem) -> Answers:
    """Output error of the angle, from markers of the leg and of the foot."""
    if problem.kind not in LEGS:
        return {}
    time, belt = problem.signals["time"], problem.signals["belt"]
    foot = [problem.facts["labels"].index(label) for label in problem.facts["belt_fixed"]]
    fit = fit_output_error(
        _motion(problem),
        problem.positions[:, foot, 0].mean(axis=1),
        belt,
        problem.leg,
        perturbations=find_perturbations(time, belt),
        uncertainty=problem.facts["leg_uncertainty"],
    )
    return _of_fit(problem, fit, bool(fit.notes))


def ensemble(problem: Problem) -> Answers:
    """Ensemble of realisations of 1 s, for perturbations that differ from one to the next."""
    if problem.kind != "ankle":
        return {}
    time, *signals = _joint(problem)
    rate_hz = (time.size - 1) / (time[-1] - time[0])
    joint = MovedJoint(*(butterworth_lowpass(x, rate_hz, 20.0) for x in signals), rate_hz)
    length = round(ENSEMBLE_S * rate_hz)
    found = impedance_of_ensemble(
        joint,
        np.arange(length, time.size - 2 * length, length),
        length_s=ENSEMBLE_S,
        segment_s=ENSEMBLE_S,
        step_s=ENSEMBLE_S,
        draws=1000,
        rng=np.random.default_rng(0),
    )
    ends = zip(found.values[0].tolist(), found.low[0].tolist(), found.high[0].tolist(), strict=True)
    return {name: Answer(*own) for name, own in zip(found.names, ends, strict=True)}


def parallel_cascade_1997(problem: Problem) -> Answers:
    """Parallel cascade of two impulse responses, without intervals."""
    if problem.kind != "ankle":
        return {}
    time, *signals = _joint(problem)
    every = round(0.01 * (time.size - 1) / (time[-1] - time[0]))
    angle, torque = (scipy.signal.decimate(x - x.mean(), every, ftype="fir") for x in signals)
    rectified = np.maximum(np.gradient(angle, 0.01), 0.0)
    inside = slice(60, angle.size - 10)
    intrinsic = np.column_stack([np.roll(angle, lag)[inside] for lag in range(-4, 5)])
    reflex = np.column_stack([np.roll(rectified, lag)[inside] for lag in range(4, 51)])
    reflex -= reflex.mean(axis=0)
    wanted = torque[inside] - torque[inside].mean()
    reflexive, best = np.zeros_like(wanted), math.inf
    for _ in range(20):
        response = np.linalg.lstsq(intrinsic, wanted - reflexive, rcond=None)[0]
        left = wanted - intrinsic @ response
        reflexive = reflex @ np.linalg.lstsq(reflex, left, rcond=None)[0]
        error = float(np.sum((left - reflexive) ** 2))
        if error > 0.9999 * best:
            break
        best = error
    w = 2.0 * np.pi * np.linspace(0.0, 10.0, 41)
    stiffness = np.exp(-1j * np.outer(w, 0.01 * np.arange(-4, 5))) @ response
    return {name: Answer(x) for name, x in _second_order(w, stiffness).items()}


def joint_likelihood(problem: Problem) -> Answers:
    """Likelihood of all markers and the log of the belt, with the stated uncertainties of the rig."""
    if problem.kind not in LEGS:
        return {}
    time, belt, facts = problem.signals["time"], problem.signals["belt"], problem.facts
    fit = fit_joint_likelihood(
        time,
        problem.positions,
        problem.markers,
        problem.leg,
        labels=facts["labels"],
        belt_fixed=facts["belt_fixed"],
        perturbations=find_perturbations(time, belt),
        belt_velocity=belt,
        softening=problem.kind == "softening",
        uncertainty=facts["leg_uncertainty"],
    )
    return _of_fit(problem, fit, bool(fit.notes))


def tepsipe_defaults(problem: Problem) -> Answers:
    """Recommended fits of an angle and a torque; a note flags its answers, unless it concerns the reflex."""
    time, angle, torque = _joint(problem)
    uncertainty = problem.facts["uncertainty"]
    if problem.kind == "ankle":
        fit = fit_parallel_cascade(time, angle, torque, uncertainty=uncertainty)
        # an assumed delay or threshold of the reflex says nothing against I, B and K
        assumed = {of_choice(choice) for choice in fit.details.assumptions}
        return _of_fit(problem, fit, bool({*fit.notes} - assumed), K="K_working")
    belt = problem.signals["belt"]
    how: dict = {"uncertainty": uncertainty}
    if problem.kind == "standing":
        rate_hz = (time.size - 1) / (time[-1] - time[0])
        length = round(BEFORE_REFLEX_S * rate_hz)
        pulses = [(pulse.start, pulse.start + length) for pulse in find_perturbations(time, belt)]
        how |= {"baseline": "each", "cutoff_hz": 50.0}
    else:
        until = {"until": "rest", "angle": angle} if problem.kind == "passive" else {}
        pulses: list[Perturbation] = find_perturbations(time, belt, **until)
    fit = fit_impedance(time, angle, torque, perturbations=pulses, **how)
    return _of_fit(problem, fit, bool(fit.notes))


METHODS: dict[str, Method] = {
    "thesis": thesis,
    "least-squares-by-hand": least_squares_by_hand,
    "output-error": output_error,
    "ensemble": ensemble,
    "parallel-cascade-1997": parallel_cascade_1997,
    "joint-likelihood": joint_likelihood,
    "tepsipe": tepsipe_defaults,
}


def _joint(problem: Problem) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return problem.signals["time"], problem.signals["angle"], problem.signals["torque"]


def _motion(problem: Problem) -> SegmentMotion:
    labels = problem.facts["labels"]
    time = problem.signals["time"]
    return segment_motion(time, problem.positions, problem.markers, problem.leg.com_m, labels=labels)


def _asked(problem: Problem, found: Answers) -> Answers:
    return {name: found[name] for name in QUANTITIES[problem.kind]}


def _of_fit(problem: Problem, fit: ImpedanceFit, flagged: bool = False, **named: str) -> Answers:
    """Answers of a fit; ``named`` are quantities that it calls otherwise."""
    answers = {}
    for name in QUANTITIES[problem.kind]:
        quantity = fit.quantities[named.get(name, name)]
        answers[name] = Answer(*map(float, (quantity.value, quantity.low, quantity.high)), flagged)
    return answers


def _second_order(w: np.ndarray, stiffness: np.ndarray) -> dict[str, float]:
    """I, B, K of the frequency response of a dynamic stiffness (rad/s, N·m/rad), by least squares."""
    inertia, static = np.linalg.lstsq(
        np.column_stack([-(w**2), np.ones_like(w)]), stiffness.real, rcond=None
    )[0]
    damping = w @ stiffness.imag / (w @ w)
    return {"I": float(inertia), "B": float(damping), "K": float(static)}
