"""Estimate I, B, K of one trial of the ankle dummy by every pathway."""

import job

job.start(snakemake)

from dummy_choices import dummy_options

from tepsipe.experiments.dummy.leg_pathways import Pathway, analyse_dummy
from tepsipe.experiments.dummy.results import (
    bootstrap_pathways,
    dummy_contributions,
    dummy_estimates,
    dummy_result,
)
from tepsipe.io.budget_table import write_budgets
from tepsipe.io.estimates import recommended, write_estimates
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial

params, output = snakemake.params, snakemake.output
options = dummy_options(params.geometry, params.analysis, params.belt_fixed_labels, params.uncertainty)
pathways = {name: Pathway(**choice) for name, choice in params.pathways.items()}
found = analyse_dummy(read_trial(snakemake.input.trial), options, pathways)
intervals = bootstrap_pathways(found, params.bootstrap_draws, params.seed)
rows = dummy_estimates(snakemake.wildcards.condition, found, intervals)
write_result(output.fit, dummy_result(found))
write_estimates(output.estimates, recommended(rows, params.quoted))
write_budgets(output.uncertainty, dummy_contributions(rows, found))
