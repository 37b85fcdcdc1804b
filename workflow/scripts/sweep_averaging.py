"""Fit the trials of the Wristalyzer again for every number of averaged frequencies."""

import job

job.start(snakemake)

from tepsipe.arguments import options_of
from tepsipe.experiments.wristalyzer.averaging import AVERAGED_FITS, sweep_averaging
from tepsipe.experiments.wristalyzer.options import WristalyzerOptions
from tepsipe.io.trial import read_trial

options = options_of(WristalyzerOptions, snakemake.params.analysis)
rows = []
for condition, path in zip(snakemake.params.conditions, snakemake.input.trials, strict=True):
    rows += sweep_averaging(read_trial(path), condition, options, snakemake.params.numbers)
AVERAGED_FITS.write(snakemake.output.table, rows)
