"""Estimate ankle impedance and muscle latencies from all trials of one task together."""

import job

job.start(snakemake)

from standing_choices import active_options, estimators_of, person_of

from tepsipe.experiments.standing.epochs import epochs_of
from tepsipe.experiments.standing.latency import muscle_latency
from tepsipe.experiments.standing.results import (
    fit_all,
    fit_estimates,
    generator,
    standing_result,
    stiffness_by_window,
)
from tepsipe.io.estimates import write_estimates
from tepsipe.io.result import read_result, write_result
from tepsipe.signals.onsets import OnsetOptions

params, task = snakemake.params, snakemake.wildcards.task
name = f"standing/{task}"
person = person_of(params.person)
ankle_action = {muscle: choice["ankle_action"] for muscle, choice in params.muscles.items()}
active = active_options(params.active, ankle_action)
trials = [epochs_of(read_result(path)) for path in snakemake.input.responses]
fits, notes = fit_all(
    trials,
    name,
    list(params.pathways),
    estimators_of(params.estimators),
    active,
    params.bootstrap_draws,
    params.seed,
)
latencies = []
options = OnsetOptions(**{**params.latency, "search_s": tuple(params.latency["search_s"])})
anyone = any(responses.muscles for responses in trials if responses.count)
for muscle, choice in params.muscles.items() if anyone else ():
    rng = generator(params.seed, name, "latency", muscle)
    found = muscle_latency(trials, muscle, choice["lengthened_by"], options, rng)
    if isinstance(found, str):
        notes.append(f"{name}: latency of {muscle} left out: {found}")
    else:
        latencies.append(found)
facts = {
    "left_out": notes,
    "muscles": list(params.muscles),
    "trials": sum(responses.count > 0 for responses in trials),
    "responses": sum(responses.count for responses in trials),
    "critical_stiffness_Nm_per_rad": person.body.critical_stiffness,
}
windows = stiffness_by_window(
    trials,
    params.recommended,
    params.tried_windows_s,
    active,
    params.bootstrap_draws,
    generator(params.seed, name, "windows"),
)
write_result(
    snakemake.output.fit, standing_result(trials, fits, params.recommended, latencies, facts, windows)
)
write_estimates(
    snakemake.output.estimates, fit_estimates(task, fits, person.body.critical_stiffness, latencies)
)
