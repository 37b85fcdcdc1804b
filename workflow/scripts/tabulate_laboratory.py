"""List the mechanisms and the constants of the virtual laboratory, and what it shares with the analysis."""

import job

job.start(snakemake)

from tepsipe.reporting.forms import SHARED, shared_rows
from tepsipe.reporting.laboratory import DRAWN, LABORATORY_ROWS, laboratory_rows
from tepsipe.virtual_lab.forms import FORMS

params = snakemake.params
rows = laboratory_rows(params.truth, params.experiments)
LABORATORY_ROWS.write(snakemake.output.table, rows)
drawn = [row.key for row in rows if row.kind == DRAWN]
SHARED.write(snakemake.output.shared, shared_rows(FORMS, drawn, params.sections, params.other_laws))
