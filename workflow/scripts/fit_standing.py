"""Post-process one trial of a standing person, cut its epochs, and estimate the ankle impedance."""

import job

job.start(snakemake)

from tepsipe.experiments.standing.epochs import EpochOptions, cut_standing_epochs
from tepsipe.experiments.standing.free_reflex.fit import FreeReflexOptions
from tepsipe.experiments.standing.free_reflex.legs import cut_with_legs, leg_rows, legs_results
from tepsipe.experiments.standing.free_reflex.results import (
    FreeReflexChoices,
    budget_rows,
    fit_free,
    with_budgets,
)
from tepsipe.experiments.standing.joint_torque import process_standing
from tepsipe.experiments.standing.muscle_torque import ActiveOptions
from tepsipe.experiments.standing.options import BOTH, StandingEstimator, StandingOptions, TorquePathway
from tepsipe.experiments.standing.thesis.impedance import (
    fit_all,
    fit_estimates,
    over_sway,
    standing_result,
    trial_epochs_result,
)
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import joined, read_result, write_result
from tepsipe.io.trial import read_trial
from tepsipe.signals.filters import Lowpass
from tepsipe.statistics.uncertainty import sources_of
from tepsipe.treadmill.held_out import read_held_out
from tepsipe.treadmill.plate_check import PlateCheck
from tepsipe.treadmill.registry import load_treadmill_models, pick

params, analysis, condition = snakemake.params, snakemake.params.analysis, snakemake.wildcards.condition
name = f"standing/{condition}"
trial = read_trial(snakemake.input.trial)
options = StandingOptions.from_settings(params.person, params.belt, analysis, params.stance)
person = options.person
pathways = {key: TorquePathway(**pathway) for key, pathway in params.pathways.items()}
calibrations = dict(zip(options.belts, map(read_result, snakemake.input.held_out), strict=False))
plates = {belt: PlateCheck.from_result(found) for belt, found in calibrations.items()}
plate = PlateCheck.of_several(list(plates.values())) if plates else PlateCheck()
if options.belt == BOTH:
    for belt, check in plates.items():
        trial = check.corrected(trial, belt)
paths = iter(snakemake.input.models)
of_plates = {
    belt: {load: load_treadmill_models(path) for load, path in zip(("Fy", "Mx"), paths, strict=False)}
    for belt in options.belts
}
models = of_plates if options.belt == BOTH else of_plates[options.belt]
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
choices = FreeReflexChoices(
    params.recommended["pathway"],
    FreeReflexOptions(**params.free_reflex),
    sources_of(params.uncertainty),
    analysis["bootstrap_draws"],
    params.seed,
)
pathway = pathways[choices.pathway]
cut = []
if pathway.torque == "ankle":
    model = pathway.treadmill_model
    of_plates = {
        belt: {} if model is None else {load: pick(found, model) for load, found in of_plate.items()}
        for belt, of_plate in of_plates.items()
    }
    chosen = of_plates if options.belt == BOTH else of_plates[options.belt]
    lowpass = Lowpass(choices.options.lowpass_cutoff_hz, analysis["lowpass_order"], True)
    quoted = estimators[params.recommended["estimator"]]
    held_out = {
        belt: read_held_out(found) for belt, found in calibrations.items() if model == "bristle-frame"
    }
    cut = [
        cut_with_legs(standing, part, options, cutting, lowpass, chosen, held_out, quoted.window_s)
        for part in directions
    ]
stored = legs_results(cut)
perturbations = int(standing.onsets_s.size)
fits |= fit_free([part[BOTH] for part in cut if part], name, estimators, choices, perturbations)
torques = {"as_printed": params.as_printed, "recommended": choices.pathway}
facts = {
    "left_out": [*responses.left_out, *(notes if responses.count else [])],
    "perturbations": perturbations,
    "responses": responses.count,
    "muscles": responses.muscles,
    **over_sway(responses, choices.pathway),
    "marker_delay_s": standing.delay_s,
    "critical_stiffness_Nm_per_rad": person.body.critical_stiffness,
}
epochs = trial_epochs_result(standing, responses, torques)
write_result(snakemake.output.responses, joined(epochs, *stored))
result = standing_result(directions, fits, choices.pathway, [], facts)
write_result(snakemake.output.fit, with_budgets(result, fits))
rows = fit_estimates(condition, fits, person.body.critical_stiffness, [])
legs = {
    leg: [part[leg] for part in cut if part] for leg in options.belts if options.belt == BOTH and any(cut)
}
of_legs, budgets_of_legs = leg_rows(condition, legs, name, estimators, choices, perturbations)
CONTRIBUTIONS.write(snakemake.output.uncertainty, [*budget_rows(rows, fits), *budgets_of_legs])
# the estimate to quote is that of the task to which the trial belongs
ESTIMATES.write(snakemake.output.estimates, [*rows, *of_legs])
