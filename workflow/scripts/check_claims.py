"""Test the claims of the thesis against this run."""

import job

job.start(snakemake)

from tepsipe.experiments.forward.scores import read_forward
from tepsipe.experiments.noise.rows import read_noise
from tepsipe.io.estimates import read_estimates
from tepsipe.io.result import read_result
from tepsipe.reporting.claims import Findings, check_claims, write_claims
from tepsipe.reporting.planned import read_planned
from tepsipe.reporting.thesis_tables import read_table
from tepsipe.treadmill.calibration import read_scores

fits = {}
paths = iter(snakemake.input.fits)
for experiment, conditions in snakemake.params.experiments.items():
    fits[experiment] = {condition: read_result(next(paths)) for condition in conditions}
scores = [row for path in snakemake.input.scores for row in read_scores(path)]
estimates = read_estimates(snakemake.input.estimates)
forward = [row for path in snakemake.input.forward for row in read_forward(path)]
table_4_4 = read_table(snakemake.input.noise[1])[1] if snakemake.input.noise else []
findings = Findings(
    estimates,
    fits,
    snakemake.params.as_printed,
    scores,
    forward,
    table_4_4,
    noise=read_noise(snakemake.input.noise[0]) if snakemake.input.noise else [],
    recorded=snakemake.params.recorded,
    planned=[row for path in snakemake.input.planned for row in read_planned(path)],
)
write_claims(snakemake.output.table, check_claims(snakemake.params.claims, findings))
