"""Give every printed cell of Tables 4-1 to 4-4 a verdict."""

import job

job.start(snakemake)

from dataclasses import replace

from tepsipe.reporting.ledger import (
    CELL_VERDICTS,
    CONSISTENT,
    TABULATED,
    best_sem_reading,
    cells_of_table,
    explanations_of,
    ledger,
    noise_cells,
    null_cells,
    sem_distances,
    tolerances_of,
    with_sem_reading,
)
from tepsipe.reporting.thesis_tables import read_table
from tepsipe.statistics.least_squares import SEM_READINGS

params = snakemake.params
values = {}
for table, path in zip(params.tables, snakemake.input.tables, strict=True):
    columns, rows = read_table(path)
    values |= cells_of_table(table, rows, columns)
noise = read_table(snakemake.input.noise[1])[1] if snakemake.input.noise else []
values |= noise_cells(noise, TABULATED)
reading = best_sem_reading(sem_distances(values, params.reported))
values, consistent = (with_sem_reading(cells, reading) for cells in (values, noise_cells(noise, CONSISTENT)))
tolerances = {
    (table, row): replace(
        one, used=f"{one.used}. SEMs use eq (3-2) with ||R|| read as {SEM_READINGS[reading]}"
    )
    if row.startswith("SEM_")
    else one
    for (table, row), one in tolerances_of(params.tolerances, params.bases).items()
}
rows = ledger(
    params.reported,
    tolerances,
    values,
    explanations_of(values, params.slips, consistent),
    null_cells(params.reported, tolerances, params.slips),
    frozenset(params.recorded),
)
CELL_VERDICTS.write(snakemake.output.table, rows)
