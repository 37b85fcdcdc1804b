"""Join the tables of all laboratories into the tables of the coverage."""

import job

job.start(snakemake)

import json
from pathlib import Path

from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES, RECOVERIES
from tepsipe.reporting.coverage import (
    COVERAGE_ROWS,
    DROPPED_ROWS,
    FLAG_ROWS,
    LABORATORIES,
    OUTCOME_ROWS,
    Laboratory,
    coverage_rows,
    dropped_rows,
    flag_rows,
    outcome_row,
    outcomes_of,
)

laboratories, outcomes = [], []
tables = zip(
    snakemake.input.laboratories,
    snakemake.input.estimates,
    snakemake.input.uncertainty,
    snakemake.input.recovery,
    strict=True,
)
for about, estimates, budgets, recovery in tables:
    laboratory = Laboratory(**json.loads(Path(about).read_text(encoding="utf-8")))
    laboratories.append(laboratory)
    outcomes += outcomes_of(
        laboratory,
        ESTIMATES.read(estimates),
        RECOVERIES.read(recovery),
        CONTRIBUTIONS.read(budgets),
        snakemake.params.pooled,
        snakemake.params.also_evaluated,
    )
sets = snakemake.params.sets
LABORATORIES.write(snakemake.output.laboratories, laboratories)
OUTCOME_ROWS.write(snakemake.output.outcomes, map(outcome_row, outcomes))
COVERAGE_ROWS.write(snakemake.output.coverage, coverage_rows(outcomes, sets, snakemake.params.windows_s))
DROPPED_ROWS.write(snakemake.output.dropped, dropped_rows(outcomes, sets))
FLAG_ROWS.write(snakemake.output.flags, flag_rows(outcomes, sets))
