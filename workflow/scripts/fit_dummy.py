"""Estimate I, B, K of one trial of the ankle dummy by every pathway."""

import job

job.start(snakemake)

from dummy_choices import dummy_options

from tepsipe.experiments.dummy.leg_pathways import (
    Pathway,
    analyse_dummy,
    bootstrap_pathways,
    dummy_estimates,
    dummy_result,
)
from tepsipe.io.estimates import write_estimates
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial

options = dummy_options(
    snakemake.params.geometry, snakemake.params.analysis, snakemake.params.belt_fixed_labels
)
pathways = {name: Pathway(**choice) for name, choice in snakemake.params.pathways.items()}
found = analyse_dummy(read_trial(snakemake.input.trial), options, pathways)
intervals = bootstrap_pathways(found, snakemake.params.bootstrap_draws, snakemake.params.seed)
write_result(snakemake.output.fit, dummy_result(found, intervals))
write_estimates(
    snakemake.output.estimates,
    dummy_estimates(snakemake.wildcards.condition, found, intervals),
)
