"""Fits with a free reflex torque among the other fits of a person, their budgets, and differences.

Checks of the standing person's K and B, which find broken assumptions in the responses themselves.

Each check compares two estimates of one quantity, or a setting with a measurement. A difference fails it only
if it is significantly larger than in a sound trial; each check has a false-alarm probability of 1 in 100.

`difference_from_window` compares the fit with a free reflex torque with least squares in a short window. Both
estimates come from the same signals: centre of the joint, soft tissue, feet and treadmill model are the same
in both, and so are their errors. Only the effects of errors that differ between the estimates count. A larger
difference has causes that no source describes: a reflex before its assumed onset, or a torque in the first
milliseconds that does not come from the joint.

Common centre of the ankle of all trials of a person, from quiet sway and palpation.

Quiet sway gives the offset m_j of the centre from the palpated one, with a standard error s_j, in trial j, by
the slope over an ankle angle of standard deviation phi_j in n_j stretches. A person has one centre in all
tasks. Noise of the markers moves m_j by 1 / phi_j, so trials count by their sway: with p_j = n_j phi_j^2, the
mean and its standard error are m = sum p_j m_j / sum p_j and s^2 = sum (p_j s_j)^2 / (sum p_j)^2. With the
standard uncertainty u_p of palpation, the weighted mean of both and its uncertainty are

    c = w m,     w = u_p^2 / (u_p^2 + s^2 + (m' u_f)^2),     u(c)^2 = (w s)^2 + ((1 - w) u_p)^2

for each coordinate. With much noise of the cameras c is the palpated centre, with little noise that of sway.
A foot that tilts in quiet sway moves m by m' as its rotation f changes by 1: with the uncertainty u_f of the
rotation (below), such a foot counts less. Responses follow the centre to first order, by their slopes; the
part of u_f in c belongs to the source of the rotation.

Rotation of a person's hindfoot, from the pulses of all tasks.

In pulse i the markers show the hindfoot's rotation theta_i(t) for an assumed share of the forefoot, and
h_i(t) for any share, with more noise (`free_body`). The ratio of both is one number of the person,

    f = sum_ij h_i theta_j / sum_ij theta_i theta_j,     i != j

summed over instants and pairs of different pulses, whose noise is independent: noise does not bias f. Pulses
in opposite directions enter with opposite signs. The same products give the share g of the forefoot: its
rotation over h. For one marker at the heel and one at the toes, at (x_h, z_h) and (x_t, z_t) from the ankle,
with R the change of their distance along y over its change along z,

    g = (z_h + R x_h) / (z_t + R x_t)

The standard error of f is that of the jackknife over pulses, with the error of the markers' places. f is
weighed against 1, the rotation for the assumed share, whose standard uncertainty is `foot_rotation`. Where
pulses do not tilt the foot, or markers do not show its parts, the assumption therefore remains. The centre of
quiet sway and the size of soft tissue are known for three rotations, and follow f by a parabola.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Annotated, Self

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.budgets import contributions_of, rows_of
from tepsipe.experiments.standing.estimates import Fits, StandingFit, of_responses, with_share
from tepsipe.experiments.standing.free_reflex.broadband import (
    FAR_M,
    OTHER_ROTATIONS,
    BroadbandEpochs,
    by_recording,
)
from tepsipe.experiments.standing.free_reflex.fit import (
    ANKLE,
    ANKLE_D,
    DISCREPANCY,
    OWN_DISCREPANCY,
    QUANTITIES,
    REGRESSORS,
    TORQUE,
    ApartFromOthers,
    FreeReflexFit,
    fit_errors,
    fit_free_reflex,
    inside_window,
    jackknife,
    noise_of_mean,
    sway_moments,
)
from tepsipe.experiments.standing.free_reflex.free_body import JointCentre
from tepsipe.experiments.standing.free_reflex.reflex import REFLEX
from tepsipe.experiments.standing.muscle_torque import FREE, NONE
from tepsipe.experiments.standing.options import FreeReflexOptions, StandingEstimator, TorquePathway
from tepsipe.experiments.standing.thesis.latency import MuscleLatency
from tepsipe.identification.consistency import CHANCE, welch
from tepsipe.identification.regression.generalised import Record, generalised_least_squares
from tepsipe.identification.result import Quantity, quantities_of
from tepsipe.io.estimates import Contribution, Estimate, flagged, recommended
from tepsipe.io.result import Result
from tepsipe.statistics.uncertainty import Budget, Source, coverage_factor, sources_of
from tepsipe.treadmill.frame_peak import FramePeak, moves_with_frame, resonance_sentence
from tepsipe.treadmill.held_out import BEYOND, UNKNOWN, clearly_wrong

# false-alarm probability of each check
CONFIDENCE = 0.99
# difference over windows of 50 to 70 ms without a free reflex torque, and range of K over windows with one
DIFFERENCE, WINDOW_RANGE = 0.05, 0.25
# motion of the soft tissue that is too large to be corrected (m)
SKIN_M = 0.003
# predicted error of K above which K is not quoted, relative to K
GROSS = 0.5
# largest share of noise in the information on B and K: the corrected estimate is biased beyond it
NOISE_SHARE = 0.1
# share of the perturbations that must be usable
USABLE = 0.7
# relative difference of a recording's B or K from the others' that matters, and beyond which no value of the
# task is quoted; recordings of several amplitudes differ by softening
TRIALS_DIFFER, TRIALS_APART = 0.25, 0.4
# least number of responses of each half of a trial for which both are compared
FEWEST_OF_HALF = 4


def failed_checks(
    fit: FreeReflexFit,
    trials: list[BroadbandEpochs],
    perturbations: int,
    pre_reflex: tuple[np.ndarray, Budget] | None,
) -> tuple[str, ...]:
    """Names of the checks, in `tepsipe.flags.FLAGS`, that K and B fail.

    fit: K and B of these trials.
    perturbations: number of perturbations in them, usable or not.
    pre_reflex: B and K of the pre-reflex window less B and K of ``fit``, and the budget of the difference;
    None without such an estimate.
    """
    stiffness = float(fit.parameters[1])
    failed = []
    if pre_reflex is not None:
        difference, budget = pre_reflex
        chance = float(coverage_factor(budget.effective_freedom, CONFIDENCE)[1] * budget.combined[1])
        if abs(difference[1]) > DIFFERENCE * abs(stiffness) + chance:
            failed.append("pre-reflex-differs")
    by_chance = float(coverage_factor(np.inf, CONFIDENCE) * fit.windows_chance[:, 1].max())
    if np.ptp(fit.windows[:, 2]) > WINDOW_RANGE * abs(stiffness) + by_chance:
        failed.append("window-sensitive")
    if fit.noise_share > NOISE_SHARE:
        failed.append("noise-biased")
    if np.sqrt(np.mean([trial.skin_m**2 for trial in trials])) > SKIN_M:
        failed.append("skin-motion")
    if any(t.calibrated_kg is not None and t.carried_kg > BEYOND * t.calibrated_kg for t in trials):
        failed.append("beyond-calibrated-mass")
    if moves_with_frame(*_frames(trials)):
        failed.append("frame-resonance")
    error = _treadmill_error(trials)
    if error is not None and clearly_wrong(*error, stiffness):
        failed += dict.fromkeys(t.treadmill_flag for t in trials if t.treadmill_error is not None)
    failed += dict.fromkeys(flag for trial in trials for flag in trial.plate_flags)
    if any(_size_apart(each) > TRIALS_DIFFER for each in fit.apart):
        failed.append("trials-differ")
    if _halves_apart(fit, trials) > TRIALS_DIFFER:
        failed.append("halves-differ")
    if sum(trial.count for trial in trials) < USABLE * perturbations:
        failed.append("few-perturbations")
    return tuple(failed)


def _halves_apart(fit: FreeReflexFit, trials: list[BroadbandEpochs]) -> float:
    """Largest relative difference of B and K between early and late responses that is none by chance.

    A response moves B and K by c_i through its deviation from the mean of its n responses. If only the m
    responses of a half counted, B and K would change by n / m times the sum of their c_i.
    """
    counts = [trial.count for trial in trials]
    if min(counts) < 2 * FEWEST_OF_HALF:
        return 0.0
    changes = np.sqrt(fit.errors.freedom / sum(counts)) * fit.errors.scatter
    of_trials = np.split(changes, np.cumsum(counts)[:-1])
    halves, errors = [], []
    for k in (0, 1):
        parts = [len(x) / len(half) * half for x in of_trials for half in [np.array_split(x, 2)[k]]]
        variance = sum(len(part) * part.var(axis=0, ddof=1) for part in parts)
        halves.append(fit.parameters + sum(part.sum(axis=0) for part in parts))
        errors.append((np.sqrt(variance), float(sum(len(part) - 1 for part in parts))))
    chance = welch(*halves, *errors)[0]
    return float((np.abs(halves[0] - halves[1]) / np.abs(fit.parameters) * (chance < CHANCE)).max())


def _size_apart(recording: ApartFromOthers) -> float:
    """Largest relative difference of B and K from the other recordings that is none by chance."""
    return float((recording.size * (recording.chance < CHANCE)).max())


def _frames(trials: list[BroadbandEpochs]) -> tuple[list[FramePeak], FramePeak | None]:
    """Resonances of the frame below the person, trial by trial, and of the empty belt."""
    empty = next((trial.empty_frame for trial in trials if trial.empty_frame is not None), None)
    return [trial.frame for trial in trials if trial.frame is not None], empty


def quotable(trials: list[BroadbandEpochs], stiffness: float) -> bool:
    """Test for a predicted error of K (N·m/rad) that is not clearly above half of it."""
    error = _treadmill_error(trials)
    return error is None or error[1] >= UNKNOWN or not clearly_wrong(*error, stiffness, GROSS)


def _treadmill_error(trials: list[BroadbandEpochs]) -> tuple[float, float] | None:
    """Predicted error of K by the treadmill model, mean over trials, and its standard error (N·m/rad).

    All trials are compared with the same recordings of the treadmill, so more trials do not reduce the error.
    """
    predicted = [trial for trial in trials if trial.treadmill_error is not None]
    if not predicted:
        return None
    errors = np.array([trial.treadmill_error for trial in predicted])
    known = errors[:, 1].max() < UNKNOWN
    # a trial with perturbations of both directions counts once
    error, uncertainty = np.mean([errors[own].mean(axis=0) for own in by_recording(predicted)], axis=0)
    return float(error), float(uncertainty) if known else UNKNOWN


def difference_from_window(
    trials: list[BroadbandEpochs],
    fit: FreeReflexFit,
    window_s: float,
    options: FreeReflexOptions,
    sources: list[Source],
) -> tuple[np.ndarray, Budget]:
    """Difference of B and K, least squares in a short window less a fit, with the budget of the difference.

    window_s: length of the short window.
    sources: uncertain constants, common to both estimates.

    Returns:
        difference: differences of B and K (N·m·s/rad, N·m/rad). Shape (2,).
        budget: budget of the difference. Type A is the scatter of the difference between responses. Sources
        of the signals and draws of the treadmill model are subtracted one by one; the onset of the reflex
        counts as in the fit, which alone has it. The spread over windows does not count: such a difference
        shows it.
    """
    inside = inside_window(trials[0].time, window_s)
    moments = sway_moments(trials, inside)
    records = [
        Record(
            target=mean[:, TORQUE],
            regressors=mean[:, REGRESSORS],
            covariance=np.eye(int(inside.sum())),
            instruments=trial.belt[inside],
            noise=noise_of_mean(moments, trial.count),
        )
        for trial, mean in ((trial, trial.perturbed[:, inside].mean(axis=0)) for trial in trials)
    ]
    short = generalised_least_squares(records)
    by_source = {source.name: source.standard_uncertainty for source in sources}
    difference = fit_errors(trials, short, records, inside, sources, options.discrepancy_s).minus(fit.errors)
    contributions = dict(difference.contributions)
    contributions[OWN_DISCREPANCY] = options.discrepancy * difference.discrepancy.reshape(-1, 2)
    if DISCREPANCY in by_source:
        contributions[DISCREPANCY] = by_source[DISCREPANCY] * difference.discrepancy.sum(axis=0)
    type_a = np.sqrt((difference.scatter**2).sum(axis=0))
    return difference.parameters, Budget(type_a, difference.freedom, contributions, fit.budget.freedom)


FOOT, PLACES, SKIN = "foot_rotation", "foot_markers_m", "skin_m"
# fewest pulses whose scatter shows how well they determine the rotation of the foot
FEWEST_PULSES = 4
# step of the rotation for the change of centre and soft tissue with it
ROTATION_STEP = 0.01


@dataclass(frozen=True)
class FootRotation:
    """Rotation of a person's hindfoot over the one for the assumed share of the forefoot."""

    rotation: float
    error: float
    """Weighted mean of markers and assumption, and its standard uncertainty."""
    share: float | None = None
    share_error: float | None = None
    """Rotation of the forefoot over the hindfoot's, from the markers alone, and its standard error; None
    where the assumption counts more than the markers."""


def foot_rotation(person: list[BroadbandEpochs], sources: dict[str, Source]) -> FootRotation:
    """Rotation of a person's hindfoot, from trials of all tasks.

    sources: uncertain constants; without `FOOT` the assumed share counts, without `PLACES` the places of the
    markers are exact.
    """
    assumed = sources[FOOT].standard_uncertainty if FOOT in sources else 0.0
    shown = [t for t in person if t.tilt is not None and t.rotation_per_m is not None]
    # of cameras with several rates those of the first trial count
    shown = [t for t in shown if t.time.size == shown[0].time.size]
    if sum(trial.count for trial in shown) < FEWEST_PULSES or not assumed:
        return FootRotation(1.0, assumed)
    way = [np.sign(trial.belt[np.abs(trial.belt[:, 0]).argmax(), 0]) for trial in shown]
    after = shown[0].time >= 0.0
    tilts = np.concatenate([sign * trial.tilt[:, after] for sign, trial in zip(way, shown, strict=True)])
    theta, hind, fore = tilts[..., 0], tilts[..., 2], tilts[..., 3]
    if not theta.any():
        return FootRotation(1.0, assumed)
    above, below, error = _ratio(hind, theta, theta)
    ahead, behind, share_error = _ratio(fore, hind, theta)
    if PLACES in sources:
        placed = sources[PLACES].standard_uncertainty * float(np.mean([t.rotation_per_m for t in shown]))
        error = float(np.hypot(error, placed * above))
    known, unknown = (assumed * below) ** 2, error**2
    foot = FootRotation(
        1.0 + assumed**2 * below * (above - below) / (known + unknown),
        assumed * float(np.sqrt(unknown / (known + unknown))),
    )
    if unknown > known:
        return foot
    return replace(foot, share=ahead / behind, share_error=share_error / abs(behind))


def _ratio(above: np.ndarray, below: np.ndarray, by: np.ndarray) -> tuple[float, float, float]:
    """Two means of products with ``by`` over pairs of different pulses, each of shape (pulses, n).

    The third number is the standard error of the first less their ratio times the second, by the jackknife.
    """
    (first, firsts), (second, seconds) = (_of_pairs(x, by) for x in (above, below))
    return first, second, float(np.sqrt(jackknife(firsts - first / second * seconds)))


def _of_pairs(x: np.ndarray, y: np.ndarray) -> tuple[float, np.ndarray]:
    """Mean product over pairs of different pulses, and the same without each pulse."""
    all_x, all_y, own, n = x.sum(axis=0), y.sum(axis=0), (x * y).sum(axis=1), len(x)
    total = float(all_x @ all_y - own.sum())
    return total / (n * (n - 1)), (total - x @ all_y - y @ all_x + 2.0 * own) / ((n - 1) * (n - 2))


def at_rotation(trial: BroadbandEpochs, rotation: float) -> tuple[JointCentre | None, float]:
    """Centre of quiet sway and motion of the soft tissue (m) for a rotation of the hindfoot."""
    if not trial.turned:
        return trial.centre, trial.skin_m
    nodes, others = np.array([1.0, *OTHER_ROTATIONS]), np.eye(3, dtype=bool)
    weights = [np.prod((rotation - nodes[~own]) / (nodes[own] - nodes[~own])) for own in others]
    centres, skins_m = zip((trial.centre, trial.skin_m), *trial.turned, strict=True)
    skin_m = float(np.dot(weights, skins_m))
    if trial.centre is None or None in centres:
        return None, skin_m
    names = ("offset_m", "moving_m", "own_m", "standard_error_m", "sway_rad", "foot_rad")
    found = {k: sum(w * getattr(x, k) for w, x in zip(weights, centres, strict=True)) for k in names}
    return replace(trial.centre, **found), skin_m


PALPATED = "palpated_centre_m"
CENTRE = ("joint_centre_anterior_m", "joint_centre_height_m")
# smallest share of the trials that must determine a centre
SHOWN = 0.5


@dataclass(frozen=True)
class CommonCentre:
    """Centre of the ankle of a person."""

    offset_m: Annotated[np.ndarray, "(2,)"]
    error_m: Annotated[np.ndarray, "(2,)"]
    """Offset from the palpated centre, anterior and upward, and its standard uncertainty for a given rotation
    of the foot."""
    per_rotation_m: Annotated[np.ndarray, "(2,)"]
    """Change of the offset with the rotation of the foot."""
    from_sway: bool
    """True if sway counts more than palpation in both coordinates."""


def common_centre(
    person: list[BroadbandEpochs], sources: dict[str, Source], foot: FootRotation
) -> CommonCentre:
    """Weighted mean of the centre from quiet sway and the palpated one.

    person: trials of all tasks of the person.
    sources: uncertain constants; without `PALPATED` sway alone counts.
    foot: rotation of the hindfoot, whose error moves the centre from sway.
    Returns: with an infinite uncertainty if neither determines the centre.
    """
    pairs = [[at_rotation(t, foot.rotation + step)[0] for step in (0.0, ROTATION_STEP)] for t in person]
    pairs = [
        [now, then] for now, then in pairs if now is not None and np.isfinite(now.standard_error_m).all()
    ]
    offset, error, slope = np.zeros(2), np.full(2, np.inf), np.zeros(2)
    if person and len(pairs) >= max(1.0, SHOWN * len(person)):
        # responses to opposite perturbations of one trial share its quiet standing, and so its centre
        pairs = list({(*now.offset_m, *now.standard_error_m): (now, then) for now, then in pairs}.values())
        by_sway = np.array([now.stretches * now.sway_rad**2 for now, _ in pairs])
        weights = by_sway / by_sway.sum()
        squares = weights**2 @ [now.standard_error_m**2 for now, _ in pairs]
        mean = weights @ [now.offset_m for now, _ in pairs]
        turned = (weights @ [then.offset_m for _, then in pairs] - mean) / ROTATION_STEP
        if np.hypot(*mean) < FAR_M + 2.0 * np.sqrt((squares + (foot.error * turned) ** 2).sum()):
            offset, error, slope = mean, np.sqrt(squares), turned
    if PALPATED not in sources:
        return CommonCentre(offset, error, slope, bool(np.isfinite(error).all()))
    palpated = sources[PALPATED].standard_uncertainty
    weight = 1.0 / (1.0 + (error**2 + (foot.error * slope) ** 2) / palpated**2)
    part = np.where(weight > 0.0, weight * np.where(weight > 0.0, error, 0.0), 0.0)
    whole = np.hypot(part, (1.0 - weight) * palpated)
    return CommonCentre(weight * offset, whole, weight * slope, bool((weight > 0.5).all()))


def with_common_centre(
    trials: list[BroadbandEpochs], sources: dict[str, Source], person: list[BroadbandEpochs]
) -> tuple[list[BroadbandEpochs], list[Source]]:
    """Trials with the foot of their person, about the person's centre, and sources with its uncertainty.

    sources: uncertain constants, among them `PALPATED`, and `CENTRE` for errors that all centres from sway
    have in common.
    person: trials of all tasks of the person.

    Returns:
        trials: with responses about the common centre (rad, N·m), for the person's rotation of the hindfoot.
        sources: the sources without `PALPATED` and `PLACES`; `CENTRE` includes the uncertainty of the common
        centre (m), and `FOOT` is the uncertainty of the rotation.
    """
    foot = foot_rotation(person, sources)
    centre = common_centre(person, sources, foot)
    of_centre = dict(zip(CENTRE, centre.error_m.tolist(), strict=True))
    known = []
    for name, source in sources.items():
        u = of_centre.get(name, 0.0)
        if name == FOOT:
            known.append(replace(source, standard_uncertainty=foot.error))
        elif name not in (PALPATED, PLACES):
            both = float(np.hypot(source.standard_uncertainty, u)) if np.isfinite(u) else None
            known.append(source if both is None else replace(source, standard_uncertainty=both))
    return [_about(trial, foot, centre) for trial in trials], known


def _about(trial: BroadbandEpochs, foot: FootRotation, centre: CommonCentre) -> BroadbandEpochs:
    """Trial with the foot and the centre of its person, and with the soft tissue that belongs to them.

    The slope of the foot's rotation becomes its total change: it also moves centre and soft tissue.
    """
    size, larger = (at_rotation(trial, foot.rotation + step)[1] for step in (0.0, ROTATION_STEP))
    present = trial.centre.offset_m if trial.centre is not None and trial.centre_used else np.zeros(2)
    moved, followed = (
        sum(d * trial.slopes[name] for name, d in zip(CENTRE, change, strict=True))
        for change in (centre.offset_m - present, centre.per_rotation_m)
    )
    perturbed, quiet = trial.perturbed + moved - (size - trial.skin_m) * trial.slopes[SKIN], trial.quiet
    if trial.tilt is not None:
        quiet = quiet.copy()
        for signals, tilt in ((perturbed, trial.tilt), (quiet, trial.quiet_tilt)):
            signals[..., [ANKLE, ANKLE_D]] -= (foot.rotation - 1.0) * tilt[..., :2]
    of_foot = trial.slopes[FOOT] + followed - (larger - size) / ROTATION_STEP * trial.slopes[SKIN]
    return replace(
        trial, perturbed=perturbed, quiet=quiet, slopes=trial.slopes | {FOOT: of_foot}, skin_m=size
    )


# K and B of both legs, and of each on a plate of its own
OF_JOINT = tuple(f"{quantity}{leg}" for quantity in QUANTITIES for leg in ("", "_left", "_right"))
# flag of a number of the reflex torque that the responses do not determine
UNDETERMINED = "reflex-not-determined"
UNKNOWN_ORIGIN, ORIGIN = "unknown_origin_m", "origin_anterior_m"


@dataclass(frozen=True)
class FreeReflexChoices:
    """Choices that all fits with a free reflex torque share."""

    pathway: str
    """Torque that is fitted."""
    options: FreeReflexOptions
    """Options of the analysis."""
    sources: dict[str, Source]
    """Uncertain constants."""

    @classmethod
    def from_settings(cls, pathway: str, free_reflex: dict, uncertainty: dict) -> Self:
        """Choices of a study; ``uncertainty`` has the sources, as `sources_of` takes them."""
        return cls(pathway, FreeReflexOptions(**free_reflex), sources_of(uncertainty))


def fit_free(
    trials: list[BroadbandEpochs],
    name: str,
    estimators: dict[str, StandingEstimator],
    choices: FreeReflexChoices,
    perturbations: int,
    reflex_onset_s: float | None = None,
    person: list[BroadbandEpochs] | None = None,
    of_emg: tuple[str, ...] = (),
) -> Fits:
    """Fit every estimator with a free reflex torque, and check it against the pre-reflex window.

    trials: trials that share their parameters.
    name: name of the trial or task in messages.
    estimators: name -> estimator; those with another active torque are passed over.
    perturbations: number of perturbations in the trials, usable or not.
    reflex_onset_s: earliest instant of a reflex torque (s); from the options if left out.
    person: trials of all tasks of the person; if left out, those of ``trials``.
    of_emg: faults of the electromyograms, which show the onset.
    """
    fits: Fits = {}
    trials, sources = with_common_centre(trials, _with_origin(trials, choices.sources), person or trials)
    for key, estimator in estimators.items() if trials else ():
        if estimator.active != FREE:
            continue
        if estimator.inertia:
            raise InputError(
                f"{name}: expected no inertia with a free reflex torque, found inertia: true for {key}: set "
                "it to false in standing.estimators"
            )
        fit = fit_free_reflex(trials, estimator.window_s, choices.options, sources, reflex_onset_s)
        check = _pre_reflex(trials, fit, estimators, choices.options, sources)
        flags = failed_checks(fit, trials, perturbations, check) + of_emg
        fits[choices.pathway, key] = _as_fit(fit, trials, flags)
    return fits


def _with_origin(trials: list[BroadbandEpochs], sources: dict[str, Source]) -> dict[str, Source]:
    """Sources, with that of the plate's origin (m) as assumed where no weight showed it in every trial."""
    kept = dict(sources)
    assumed = kept.pop(UNKNOWN_ORIGIN, None)
    if assumed is not None and not all(trial.origin_known for trial in trials):
        kept[ORIGIN] = replace(assumed, name=ORIGIN)
    return kept


def _pre_reflex(
    trials: list[BroadbandEpochs],
    fit: FreeReflexFit,
    estimators: dict[str, StandingEstimator],
    options: FreeReflexOptions,
    sources: list[Source],
) -> tuple[np.ndarray, Budget] | None:
    """B and K in the first window without active torque less B and K of a fit, and the budget of this."""
    for estimator in estimators.values():
        plain = estimator.active == NONE and not estimator.inertia
        if plain and estimator.window_s <= options.windows_s[1]:
            return difference_from_window(trials, fit, estimator.window_s, options, sources)
    return None


def _as_fit(fit: FreeReflexFit, trials: list[BroadbandEpochs], flags: tuple[str, ...]) -> StandingFit:
    values = dict(zip(QUANTITIES, fit.parameters.tolist(), strict=True))
    quantities = _flagged(quantities_of(values, fit.budget), flags)
    reflex = quantities_of(dict(zip(REFLEX, fit.reflex.values.tolist(), strict=True)), fit.reflex.budget)
    reflex = {
        name: replace(q, flags=(*flags, UNDETERMINED) if name in fit.reflex.undetermined else flags)
        for name, q in reflex.items()
    }
    return StandingFit(
        quantities | reflex | of_responses(fit.curves, fit.vaf),
        fit.curves,
        sum(trial.count for trial in trials),
        budget=fit.budget,
        windows=fit.windows,
        apart=tuple(_apart_in_words(x) for x in fit.apart if _size_apart(x) > TRIALS_DIFFER),
        quotable=all(_size_apart(x) <= TRIALS_APART for x in fit.apart) and "other-calibration" not in flags,
    )


def _apart_in_words(recording: ApartFromOthers) -> str:
    (b, k), (others_b, others_k) = recording.own, recording.others
    return (
        f"{recording.recording}: expected B and K like those of the other trials of its task ({others_b:.3g} "
        f"N·m·s/rad, {others_k:.3g} N·m/rad), found {b:.3g} and {k:.3g}: check its row of the trial sheet, "
        "its recording, and how the person stood"
    )


def _flagged(quantities: dict[str, Quantity], flags: Iterable[str]) -> dict[str, Quantity]:
    return {name: replace(quantity, flags=tuple(flags)) for name, quantity in quantities.items()}


def reflex_onset(
    latencies: list[MuscleLatency], action: dict[str, float], detector: str, options: FreeReflexOptions
) -> float | None:
    """Earliest instant of a reflex torque (s): the first latency of an ankle muscle, and the time to force.

    latencies: latencies of the muscles with a response.
    action: muscles that act at the ankle.
    detector: detector whose onset counts.
    Returns: none if no latency is known.
    """
    onsets = [
        x.onsets[detector].latency_s for x in latencies if action.get(x.muscle) and detector in x.onsets
    ]
    known = [onset for onset in onsets if onset is not None]
    return min(known) + options.electromechanical_delay_s if known else None


def centre_facts(
    trials: list[BroadbandEpochs], sources: dict[str, Source], person: list[BroadbandEpochs]
) -> dict:
    """Facts on the joint's centre: its offset (m), whether it is from sway, motion of soft tissue (m).

    ``broadband_cutoff_hz`` is the cutoff of the low-pass (Hz), which slow cameras lower, ``frame_resonance``
    a sentence on the frame below the person, ``forefoot_share`` the share of the person's markers with its
    standard error, or None, and ``foot_rotation`` the rotation of the hindfoot over the one that is assumed.
    """
    foot = foot_rotation(person, sources)
    centre = common_centre(person, sources, foot)
    skins_m = [at_rotation(trial, foot.rotation)[1] for trial in trials]
    return {
        "broadband_cutoff_hz": min((trial.cutoff_hz for trial in trials), default=None),
        "joint_centre_m": centre.offset_m.tolist() if trials else None,
        "centre_used": centre.from_sway,
        "foot_rotation": [foot.rotation, foot.error],
        "forefoot_share": None if foot.share is None else [foot.share, foot.share_error],
        "frame_resonance": resonance_sentence(*_frames(trials)),
        "skin_m": float(np.sqrt(np.mean(np.square(skins_m)))) if trials else 0.0,
    }


def quoted(
    rows: list[Estimate],
    trials: list[BroadbandEpochs],
    fits: Fits,
    chosen: dict[str, str],
    pathway: TorquePathway,
) -> list[Estimate]:
    """Rows of a task with those to quote marked; none, where the torque cannot be trusted.

    The belt-induced load must be compensated, by a treadmill model whose error of K is not clearly above half
    of it, with the calibration of the plate that was used for this model, and no trial may differ from the
    others by more than `TRIALS_APART`. Without compensation, K and B
    of the chosen pathway are flagged ``uncompensated``.

    fits: (pathway, estimator) -> fit.
    chosen: recommended ``pathway`` and ``estimator``.
    """
    if pathway.torque != "single-joint" and pathway.treadmill_model is None:
        return [*(flagged([row], "uncompensated")[0] if _of(row, chosen["pathway"]) else row for row in rows)]
    fit = fits.get((chosen["pathway"], chosen["estimator"]))
    known = fit is not None and fit.budget is not None
    if known and not (fit.quotable and quotable(trials, fit.quantities["K"].value)):
        return rows
    return [
        replace(row, recommended=True) if _of_reflex(row, fits, chosen) else row
        for row in recommended(rows, **chosen)
    ]


def _of_reflex(row: Estimate, fits: Fits, chosen: dict[str, str]) -> bool:
    """Test for a number of the reflex torque to quote: determined, beside B and K that a joint can have."""
    names = chosen["pathway"], chosen["estimator"]
    if row.quantity not in REFLEX or (row.pathway, row.estimator) != names:
        return False
    possible = all(fits[names].quantities[name].value >= 0.0 for name in QUANTITIES)
    return possible and UNDETERMINED not in row.flags.split(";")


def _of(row: Estimate, pathway: str) -> bool:
    return row.pathway == pathway and row.quantity in (*OF_JOINT, *REFLEX)


def with_budgets(result: Result, fits: Fits) -> Result:
    """The result of a trial or task with the budgets of its fits, below ``budget/<estimator>/``."""
    arrays, facts = {}, {}
    for (pathway, estimator), fit in fits.items():
        if fit.budget is None:
            continue
        b, start = fit.budget, f"budget/{estimator}"
        arrays[f"{start}/values"] = np.array([fit.quantities[name].value for name in QUANTITIES])
        arrays[f"{start}/type_a"] = b.type_a
        arrays |= {f"{start}/sources/{source}": rows for source, rows in b.contributions.items()}
        arrays[f"{start}/windows"] = fit.windows
        facts[estimator] = {
            "pathway": pathway,
            "freedom_a": b.freedom_a,
            "freedom": {name: x for name, x in b.freedom.items() if math.isfinite(x)},
            "responses": fit.responses,
            "flags": list(fit.quantities["K"].flags),
        }
    units = dict.fromkeys(arrays, "Nms/rad, Nm/rad")
    return Result(result.arrays | arrays, result.units | units, {**result.facts, "budgets": facts})


def _budget_from_result(result: Result, estimator: str) -> Budget:
    facts, start = result.facts["budgets"][estimator], f"budget/{estimator}/sources/"
    contributions = {
        key.removeprefix(start): rows for key, rows in result.arrays.items() if key.startswith(start)
    }
    type_a = result.arrays[f"budget/{estimator}/type_a"]
    return Budget(type_a, facts["freedom_a"], contributions, facts["freedom"])


def task_difference(
    name: str, more: Result, less: Result, critical_stiffness: Annotated[float, "N·m/rad"]
) -> tuple[list[Estimate], list[Contribution]]:
    """Difference of B and K between two tasks of the same person.

    Sources common to both tasks (the joint's centre, the feet's mass, the plate) are subtracted source by
    source, so the interval is narrower than the intervals of the two tasks suggest.

    name: condition of the rows, for example stiff-relax.
    more, less: results of the two tasks, with their budgets.

    Returns:
        rows: B, K and K over m g h, by every estimator with budgets in both tasks.
        contributions: their budgets.
    """
    rows, contributions = [], []
    of_more, of_less = (result.facts.get("budgets", {}) for result in (more, less))
    for estimator in of_more:
        if estimator not in of_less:
            continue
        values = more.arrays[f"budget/{estimator}/values"] - less.arrays[f"budget/{estimator}/values"]
        budget = _shared(_budget_from_result(more, estimator), _budget_from_result(less, estimator))
        flags = dict.fromkeys([*of_more[estimator]["flags"], *of_less[estimator]["flags"]])
        named = dict(zip(QUANTITIES, values.tolist(), strict=True))
        quantities = _flagged(quantities_of(named, budget), flags)
        names = ("standing", name, of_more[estimator]["pathway"], estimator)
        responses = of_more[estimator]["responses"] + of_less[estimator]["responses"]
        rows += rows_of(names, with_share(quantities, critical_stiffness), responses)
        contributions += contributions_of(names, quantities)
    return rows, contributions


def _shared(more: Budget, less: Budget) -> Budget:
    """Budget of a difference; a source whose numbers of draws differ counts as two."""
    mine, theirs = dict(more.contributions), dict(less.contributions)
    for name in [n for n in mine if n in theirs and mine[n].shape != theirs[n].shape]:
        mine[name] = np.vstack([mine[name], theirs.pop(name)])
    return Budget(more.type_a, more.freedom_a, mine, more.freedom).minus(
        Budget(less.type_a, less.freedom_a, theirs, less.freedom)
    )
