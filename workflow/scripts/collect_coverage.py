"""Join the tables of all laboratories into the tables of the coverage."""

import job

job.start(snakemake)

import json
from pathlib import Path

from tepsipe.io.budget_table import read_budgets
from tepsipe.io.csv_table import write_rows
from tepsipe.io.estimates import read_estimates
from tepsipe.reporting.coverage import (
    CoverageRow,
    DroppedRow,
    Laboratory,
    OutcomeRow,
    coverage_rows,
    dropped_rows,
    outcome_row,
    outcomes_of,
    read_truths,
)
from tepsipe.reporting.coverage_flags import FlagRow, flag_rows

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
        read_estimates(estimates),
        read_truths(recovery),
        read_budgets(budgets),
        snakemake.params.pooled,
        snakemake.params.also_evaluated,
    )
write_rows(snakemake.output.laboratories, Laboratory, laboratories)
write_rows(snakemake.output.outcomes, OutcomeRow, map(outcome_row, outcomes))
sets = snakemake.params.sets
write_rows(snakemake.output.coverage, CoverageRow, coverage_rows(outcomes, sets, snakemake.params.windows_s))
write_rows(snakemake.output.dropped, DroppedRow, dropped_rows(outcomes, sets))
write_rows(snakemake.output.flags, FlagRow, flag_rows(outcomes, sets))
