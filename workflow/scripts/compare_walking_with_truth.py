"""Compare I, B and K of simulated walking trials with the truth at the phase to which they belong."""

import job

job.start(snakemake)

from tepsipe.io.estimates import ESTIMATES, RECOVERIES
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.reporting.recovery import compare_phases_with_truth

curves = {
    condition: read_text_table(path, {name: name for name in ("percent", "I", "B", "K")}, ",")
    for condition, path in zip(snakemake.params.conditions, snakemake.input.truth, strict=True)
}
rows = compare_phases_with_truth(ESTIMATES.read(snakemake.input.estimates), curves)
RECOVERIES.write(snakemake.output.table, rows)
