"""Estimate ankle impedance and muscle latencies from all trials of one task together."""

import job

job.start(snakemake)

from tepsipe.experiments.standing.epochs import epochs_of
from tepsipe.experiments.standing.free_reflex.fit import FreeReflexOptions
from tepsipe.experiments.standing.free_reflex.legs import leg_rows, legs_of
from tepsipe.experiments.standing.free_reflex.results import (
    FreeReflexChoices,
    budget_rows,
    centre_facts,
    fit_free,
    quoted,
    reflex_onset,
    with_budgets,
)
from tepsipe.experiments.standing.muscle_torque import ActiveOptions
from tepsipe.experiments.standing.options import Person, StandingEstimator, TorquePathway
from tepsipe.experiments.standing.thesis.impedance import (
    fit_all,
    fit_estimates,
    generator,
    standing_result,
    stiffness_by_window,
)
from tepsipe.experiments.standing.thesis.latency import muscle_latency
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import read_result, write_result
from tepsipe.signals.onsets import OnsetOptions
from tepsipe.statistics.uncertainty import sources_of

params, task = snakemake.params, snakemake.wildcards.task
name = f"standing/{task}"
person = Person.from_settings(params.person)
ankle_action = {muscle: choice["ankle_action"] for muscle, choice in params.muscles.items()}
active = ActiveOptions.from_settings(params.active, ankle_action)
stored = [read_result(path) for path in snakemake.input.responses]
whole = [epochs_of(result) for result in stored]
trials = [part for responses in whole for part in responses.by_direction()]
estimators = {key: StandingEstimator(**choice) for key, choice in params.estimators.items()}
fits, notes = fit_all(
    trials,
    name,
    list(params.pathways),
    estimators,
    active,
    params.bootstrap_draws,
    params.seed,
)
latencies = []
options = OnsetOptions(**params.latency)
anyone = any(responses.muscles for responses in trials if responses.count)
for muscle, choice in params.muscles.items() if anyone else ():
    rng = generator(params.seed, name, "latency", muscle)
    found = muscle_latency(trials, muscle, choice["lengthened_by"], options, rng)
    if isinstance(found, str):
        notes.append(f"{name}: latency of {muscle} left out: {found}")
    else:
        latencies.append(found)
choices = FreeReflexChoices(
    params.recommended["pathway"],
    FreeReflexOptions(**params.free_reflex),
    sources_of(params.uncertainty),
    params.bootstrap_draws,
    params.seed,
)
onset = reflex_onset(latencies, active.action, options.detector, choices.options)
broadband, legs = legs_of(stored)
perturbations = sum(result.arrays["processed/onsets_s"].size for result in stored)
fits |= fit_free(broadband, name, estimators, choices, perturbations, onset)
facts = {
    "left_out": notes,
    "muscles": list(params.muscles),
    "trials": sum(responses.count > 0 for responses in whole),
    "responses": sum(responses.count for responses in trials),
    **centre_facts(broadband, choices.sources),
    "critical_stiffness_Nm_per_rad": person.body.critical_stiffness,
}
windows = stiffness_by_window(
    trials,
    choices.pathway,
    params.tried_windows_s,
    active,
    params.bootstrap_draws,
    generator(params.seed, name, "windows"),
)
result = standing_result(trials, fits, choices.pathway, latencies, facts, windows)
write_result(snakemake.output.fit, with_budgets(result, fits))
stretch = choices.sources.get("latency_s")
rows = fit_estimates(task, fits, person.body.critical_stiffness, latencies, stretch)
of_legs, budgets_of_legs = leg_rows(task, legs, name, estimators, choices, perturbations, onset)
CONTRIBUTIONS.write(snakemake.output.uncertainty, [*budget_rows(rows, fits), *budgets_of_legs])
pathway = TorquePathway(**params.pathways[choices.pathway])
rows = quoted([*rows, *of_legs], broadband, fits, params.recommended, pathway)
ESTIMATES.write(snakemake.output.estimates, rows)
