"""Checks of the standing person's K and B, which find broken assumptions in the responses themselves.

Each check compares two estimates of one quantity, or a setting with a measurement. A difference fails it only
if it is significantly larger than in a sound trial; each check has a false-alarm probability of 1 in 100.

`difference_from_window` compares the fit with a free reflex torque with least squares in a short window. Both
estimates come from the same signals: centre of the joint, soft tissue, feet and treadmill model are the same
in both, and so are their errors. Only the effects of errors that differ between the estimates count. A larger
difference has causes that no source describes: a reflex before its assumed onset, or a torque in the first
milliseconds that does not come from the joint.
"""

import numpy as np

from tepsipe.experiments.standing.free_reflex.broadband import BroadbandEpochs, by_recording
from tepsipe.experiments.standing.free_reflex.fit import (
    DISCREPANCY,
    FreeReflexFit,
    FreeReflexOptions,
    inside_window,
    noise_of_mean,
    sway_moments,
)
from tepsipe.experiments.standing.free_reflex.fit_errors import REGRESSORS, TORQUE, fit_errors
from tepsipe.identification.regression.generalised import Record, generalised_least_squares
from tepsipe.statistics.uncertainty import Budget, Source, coverage_factor
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


def failed_checks(
    fit: FreeReflexFit,
    trials: list[BroadbandEpochs],
    perturbations: int,
    pre_reflex: tuple[np.ndarray, Budget] | None,
) -> tuple[str, ...]:
    """Names of the checks, in `tepsipe.io.estimates.FLAGS`, that K and B fail.

    fit: K and B of these trials.
    perturbations: number of perturbations in them, usable or not.
    pre_reflex: B and K of the pre-reflex window less B and K of ``fit``, and the budget of the difference;
    None without such an estimate.
    """
    stiffness = float(fit.parameters[0, 1])
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
    error = _treadmill_error(trials)
    if error is not None and clearly_wrong(*error, stiffness):
        failed += dict.fromkeys(t.treadmill_flag for t in trials if t.treadmill_error is not None)
    failed += dict.fromkeys(flag for trial in trials for flag in trial.plate_flags)
    if sum(trial.count for trial in trials) < USABLE * perturbations:
        failed.append("few-perturbations")
    return tuple(failed)


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


# error of the rig's model in one trial alone, not common to the others
OWN_DISCREPANCY = "model_discrepancy_of_trial"


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
