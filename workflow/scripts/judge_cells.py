"""Give every printed cell of Tables 4-1 to 4-4 a verdict."""

import job

job.start(snakemake)

from tepsipe.reporting.ledger import (
    CELL_VERDICTS,
    TABULATED,
    cells_of_table,
    explanations_of,
    ledger,
    noise_cells,
    null_cells,
    tolerances_of,
)
from tepsipe.reporting.thesis_tables import read_table

params = snakemake.params
values = {}
for table, path in zip(params.tables, snakemake.input.tables, strict=True):
    columns, rows = read_table(path)
    values |= cells_of_table(table, rows, columns)
noise = read_table(snakemake.input.noise[1])[1] if snakemake.input.noise else []
values |= noise_cells(noise, TABULATED)
tolerances = tolerances_of(params.tolerances, params.bases)
rows = ledger(
    params.reported,
    tolerances,
    values,
    explanations_of(values, params.slips, noise),
    null_cells(params.reported, tolerances, params.slips),
    frozenset(params.recorded),
)
CELL_VERDICTS.write(snakemake.output.table, rows)
