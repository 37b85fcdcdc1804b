"""Join the comparisons with the truth under other laws of the joint, as far as it is that of the windows."""

import job

job.start(snakemake)

from tepsipe.io.estimates import RECOVERIES
from tepsipe.reporting.recovery import AT_WORK

found = [
    (row, law)
    for path, law in zip(snakemake.input.rows, snakemake.params.laws, strict=True)
    for row in RECOVERIES.read(path)
    if row.truth_of == AT_WORK
]
laws = {"law": [law for _, law in found]}
RECOVERIES.write(snakemake.output.table, [row for row, _ in found], further=laws)
