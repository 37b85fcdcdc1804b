"""Test the claims of the thesis against this run."""

import job

job.start(snakemake)

from tepsipe.experiments.forward.scores import FORWARD_SCORES
from tepsipe.experiments.noise.rows import NOISE_ROWS
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import read_result
from tepsipe.reporting.claims import CLAIM_VERDICTS, Findings, check_claims, findings_of_cells
from tepsipe.reporting.ledger import null_cells, printed_cells, tolerances_of
from tepsipe.reporting.planned import PLANNED_ROWS
from tepsipe.reporting.thesis_tables import read_table
from tepsipe.treadmill.calibration import MODEL_SCORES

fits = {}
paths = iter(snakemake.input.fits)
for experiment, conditions in snakemake.params.experiments.items():
    fits[experiment] = {condition: read_result(next(paths)) for condition in conditions}
scores = MODEL_SCORES.read(*snakemake.input.scores)
estimates = ESTIMATES.read(snakemake.input.estimates)
forward = FORWARD_SCORES.read(*snakemake.input.forward)
table_4_4 = read_table(snakemake.input.noise[1])[1] if snakemake.input.noise else []
findings = Findings(
    estimates,
    fits,
    snakemake.params.as_printed,
    scores,
    forward,
    table_4_4,
    noise=NOISE_ROWS.read(snakemake.input.noise[0]) if snakemake.input.noise else [],
    recorded=snakemake.params.recorded,
    planned=PLANNED_ROWS.read(*snakemake.input.planned),
)
params = snakemake.params
tolerances = tolerances_of(params.tolerances, params.bases)
printed, nulls = (
    findings_of_cells(cells, params.as_printed)
    for cells in (
        printed_cells(params.reported, params.slips),
        null_cells(params.reported, tolerances, params.slips),
    )
)
rows = check_claims(params.claims, findings, params.bases, printed, nulls, params.assertions)
CLAIM_VERDICTS.write(snakemake.output.table, rows)
