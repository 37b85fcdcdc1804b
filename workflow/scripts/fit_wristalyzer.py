"""Estimate the joint's admittance and fit I, B, K to one Wristalyzer trial."""

import job

job.start(snakemake)

import numpy as np

from tepsipe.arguments import options_of
from tepsipe.experiments.wristalyzer.analysis import (
    analyse_wristalyzer,
    wristalyzer_contributions,
    wristalyzer_estimates,
    wristalyzer_result,
)
from tepsipe.experiments.wristalyzer.record import WristalyzerOptions
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.statistics.uncertainty import sources_of

found = analyse_wristalyzer(
    read_trial(snakemake.input.trial),
    options_of(WristalyzerOptions, snakemake.params.analysis),
    np.random.default_rng(snakemake.params.seed),
    sources_of(snakemake.params.uncertainty),
)
rows = wristalyzer_estimates(snakemake.wildcards.condition, found)
write_result(snakemake.output.fit, wristalyzer_result(found))
ESTIMATES.write(snakemake.output.estimates, rows)
CONTRIBUTIONS.write(snakemake.output.uncertainty, wristalyzer_contributions(rows, found.budgets))
