"""Give every printed cell of Tables 4-1 to 4-4 a verdict."""

import job

job.start(snakemake)

from tepsipe.io.result import read_result
from tepsipe.reporting.ledger import (
    CELL_VERDICTS,
    TABULATED,
    cells_of_table,
    explanations_of,
    ledger,
    noise_cells,
    ordinary_errors,
    tolerances_of,
)
from tepsipe.reporting.thesis_tables import read_table

params = snakemake.params
values = {}
for table, path in zip(params.tables, snakemake.input.tables, strict=True):
    columns, rows = read_table(path)
    values |= cells_of_table(table, rows, columns)
fits = dict(zip(params.conditions, map(read_result, snakemake.input.fits), strict=True))
for table in params.tables:
    if table != "table_4_1":
        own = {name: fit for name, fit in fits.items() if name in params.reported[table]["K"]}
        values |= ordinary_errors(table, own, params.as_printed)
noise = read_table(snakemake.input.noise[1])[1] if snakemake.input.noise else []
values |= noise_cells(noise, TABULATED)
rows = ledger(
    params.reported,
    tolerances_of(params.tolerances),
    values,
    explanations_of(values, params.slips, noise),
    frozenset(params.recorded),
)
CELL_VERDICTS.write(snakemake.output.table, rows)
