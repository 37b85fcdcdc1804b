"""Post-process one trial of a standing person, cut its epochs, and estimate the ankle impedance."""

import job

job.start(snakemake)

from tepsipe.experiments.standing.epochs import EpochOptions, cut_standing_epochs
from tepsipe.experiments.standing.free_reflex.broadband import (
    GROUPS,
    broadband_result,
    cut_broadband,
    with_treadmill_error,
)
from tepsipe.experiments.standing.free_reflex.results import (
    FreeReflexChoices,
    budget_rows,
    fit_free,
    with_budgets,
)
from tepsipe.experiments.standing.joint_torque import process_standing
from tepsipe.experiments.standing.muscle_torque import ActiveOptions
from tepsipe.experiments.standing.options import StandingEstimator, StandingOptions, TorquePathway
from tepsipe.experiments.standing.thesis.results import (
    fit_all,
    fit_estimates,
    over_sway,
    standing_result,
    trial_epochs_result,
)
from tepsipe.io.budget_table import CONTRIBUTIONS
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import joined, read_result, write_result
from tepsipe.io.trial import read_trial
from tepsipe.signals.filters import Lowpass
from tepsipe.treadmill.held_out import read_held_out
from tepsipe.treadmill.plate_check import PlateCheck
from tepsipe.treadmill.registry import load_treadmill_models, pick

params, analysis, condition = snakemake.params, snakemake.params.analysis, snakemake.wildcards.condition
name = f"standing/{condition}"
calibration = read_result(snakemake.input.held_out[0]) if snakemake.input.held_out else None
plate = PlateCheck() if calibration is None else PlateCheck.from_result(calibration)
trial = read_trial(snakemake.input.trial)
options = StandingOptions.from_settings(params.person, params.belt, analysis, params.stance)
person = options.person
pathways = {key: TorquePathway(**pathway) for key, pathway in params.pathways.items()}
loads = zip(("Fy", "Mx"), snakemake.input.models, strict=False)
models = {load: load_treadmill_models(path) for load, path in loads}
standing = process_standing(trial, name, options, pathways, models, plate)
cutting = EpochOptions.from_settings(analysis, params.emg, params.max_gap_s)
responses = cut_standing_epochs(standing, cutting)
directions = responses.by_direction()
estimators = {key: StandingEstimator(**choice) for key, choice in params.estimators.items()}
fits, notes = fit_all(
    directions,
    name,
    list(params.pathways),
    estimators,
    ActiveOptions.from_settings(params.active, params.ankle_action),
    analysis["bootstrap_draws"],
    params.seed,
)
choices = FreeReflexChoices.from_settings(
    params.recommended["pathway"],
    params.free_reflex,
    params.uncertainty,
    analysis["bootstrap_draws"],
    params.seed,
)
pathway = pathways[choices.pathway]
own = []
if pathway.torque == "ankle":
    model = pathway.treadmill_model
    chosen = {} if model is None else {load: pick(of_load, model) for load, of_load in models.items()}
    lowpass = Lowpass(choices.options.lowpass_cutoff_hz, analysis["lowpass_order"], True)
    cut = [cut_broadband(standing, part, options, cutting, lowpass, chosen) for part in directions]
    quoted = estimators[params.recommended["estimator"]]
    held_out = read_held_out(calibration) if calibration and model == "bristle-frame" else None
    for broadband, part in zip(cut, directions, strict=True):
        if broadband is not None and held_out is not None:
            broadband = with_treadmill_error(
                broadband, part, held_out, person.ankle_height_m, quoted.window_s
            )
        own += [] if broadband is None else [broadband]
fits |= fit_free(own, name, estimators, choices, int(standing.onsets_s.size))
torques = {"as_printed": params.as_printed, "recommended": choices.pathway}
facts = {
    "left_out": [*responses.left_out, *(notes if responses.count else [])],
    "perturbations": int(standing.onsets_s.size),
    "responses": responses.count,
    "muscles": responses.muscles,
    **over_sway(responses, choices.pathway),
    "marker_delay_s": standing.delay_s,
    "critical_stiffness_Nm_per_rad": person.body.critical_stiffness,
}
epochs = trial_epochs_result(standing, responses, torques)
write_result(snakemake.output.responses, joined(epochs, *map(broadband_result, own, GROUPS)))
result = standing_result(directions, fits, choices.pathway, [], facts)
write_result(snakemake.output.fit, with_budgets(result, fits))
rows = fit_estimates(condition, fits, person.body.critical_stiffness, [])
CONTRIBUTIONS.write(snakemake.output.uncertainty, budget_rows(rows, fits))
# the estimate to quote is that of the task to which the trial belongs
ESTIMATES.write(snakemake.output.estimates, rows)
