"""Least squares in a short window beside the fit with a free reflex torque: their difference, and its budget.

Both estimates come from the same signals: centre of the joint, soft tissue, feet and treadmill model are the
same in both, and so are their errors. Only what the errors do to one estimate and not to the other counts. A
difference beyond that has causes that no source describes: a reflex before its assumed onset, a torque in the
first milliseconds that is not that of the joint.
"""

import numpy as np

from tepsipe.experiments.standing.broadband import BroadbandEpochs
from tepsipe.experiments.standing.fit_errors import ANKLE, ANKLE_D, TORQUE, fit_errors
from tepsipe.experiments.standing.free_reflex import (
    DISCREPANCY,
    FreeReflexFit,
    FreeReflexOptions,
    inside_window,
)
from tepsipe.identification.generalised_least_squares import Record, generalised_least_squares
from tepsipe.statistics.uncertainty import Budget, Source

# what the model of the rig leaves in one trial alone, and not in the others
OWN_DISCREPANCY = "model_discrepancy_of_trial"


def difference_from_window(
    trials: list[BroadbandEpochs],
    fit: FreeReflexFit,
    window_s: float,
    options: FreeReflexOptions,
    sources: list[Source],
) -> tuple[np.ndarray, Budget]:
    """B and K by least squares in a short window less those of a fit, with the budget of the difference.

    Parameters
    ----------
    trials : list of BroadbandEpochs
        The trials of both.
    fit : FreeReflexFit
        The fit.
    window_s : float
        Length of the short window (s).
    options : FreeReflexOptions
        Choices (units in their names).
    sources : list of Source
        What is not known exactly (units in their names); of both estimates alike.

    Returns
    -------
    difference : ndarray, shape (2,)
        Of B and K (N·m·s/rad, N·m/rad).
    budget : Budget
        Of the difference. Its Type A is the scatter of the difference between responses. Sources of the
        signals and draws of the treadmill model are subtracted one by one; the onset of the reflex counts as
        in the fit, which alone has it. The spread over windows does not count: such a difference shows it.
    """
    inside = inside_window(trials[0].time, window_s)
    records = [
        Record(mean[:, TORQUE], mean[:, [ANKLE_D, ANKLE]], np.eye(int(inside.sum())))
        for mean in (trial.perturbed[:, inside].mean(axis=0) for trial in trials)
    ]
    short = generalised_least_squares(records)
    by_source = {source.name: source.standard_uncertainty for source in sources}
    apart = fit_errors(trials, short, records, inside, sources, options.discrepancy_s).minus(fit.errors)
    contributions = dict(apart.contributions)
    contributions[OWN_DISCREPANCY] = options.discrepancy * apart.discrepancy.reshape(-1, 2)
    if DISCREPANCY in by_source:
        contributions[DISCREPANCY] = by_source[DISCREPANCY] * apart.discrepancy.sum(axis=0)
    type_a = np.sqrt((apart.scatter**2).sum(axis=0))
    return apart.parameters, Budget(type_a, apart.freedom, contributions, fit.budget.freedom)
