"""Join estimates, uncertainty budgets, phases and strides needed of all walking trials."""

import job

job.start(snakemake)

import pandas as pd

from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES


def join(paths: list[str], table: str) -> None:
    """Write the rows of all files, their cells as they are; a cell of no number becomes empty."""
    rows = [pd.read_csv(path, dtype=str, keep_default_na=False, na_values=["nan"]) for path in paths]
    pd.concat(rows).to_csv(table, index=False, lineterminator="\n")


given, made = snakemake.input, snakemake.output
ESTIMATES.write(made.table, ESTIMATES.read(*given.estimates))
CONTRIBUTIONS.write(made.uncertainty, CONTRIBUTIONS.read(*given.budgets))
join(given.rows, made.rows)
join(given.needed, made.needed)
