"""Find the dummy that returns the thesis's printed tables, and what it gives for each printed number."""

import job

job.start(snakemake)

from tepsipe.experiments.thesis_dummy.fit import fit
from tepsipe.experiments.thesis_dummy.inverse import CELL_ROWS
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial

params = snakemake.params
trials = {
    name: read_trial(path) for name, path in zip(params.conditions, snakemake.input.trials, strict=True)
}
result, rows = fit(trials, params.section, list(params.tables), params.printed, params.followed, params.seed)
write_result(snakemake.output.fit, result)
CELL_ROWS.write(snakemake.output.table, rows)
