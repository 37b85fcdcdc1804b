"""Estimate I, B, K of one trial of the ankle dummy by every pathway."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.checks import (
    check_dummy,
    check_facts,
    flag_rows,
    known_inertia,
    quoted_rows,
)
from tepsipe.experiments.dummy.leg_pathways import DummyOptions, Pathway, analyse_dummy, dummy_estimates
from tepsipe.experiments.dummy.results import bootstrap_pathways, dummy_contributions, dummy_result
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial

params, output = snakemake.params, snakemake.output
options = DummyOptions.from_settings(
    params.geometry, params.analysis, params.belt_fixed_labels, params.uncertainty
)
pathways = {name: Pathway(**choice) for name, choice in params.pathways.items()}
trial = read_trial(snakemake.input.trial)
found = analyse_dummy(trial, options, pathways)
verdict = check_dummy(
    trial, options, found, (params.quoted, params.recommended), known_inertia(params.checks)
)
intervals = bootstrap_pathways(found, params.bootstrap_draws, params.seed)
rows = dummy_estimates(snakemake.wildcards.condition, found, intervals)
result = dummy_result(found)
result.facts.update(check_facts(verdict))
write_result(output.fit, result)
ESTIMATES.write(output.estimates, quoted_rows(flag_rows(rows, verdict), verdict))
CONTRIBUTIONS.write(output.uncertainty, dummy_contributions(rows, found))
