"""Check the thesis's statements against this run."""

import job

job.start(snakemake)

from pathlib import Path

import yaml

from tepsipe.claims import Findings, check_claims, write_claims
from tepsipe.estimates import read_estimates
from tepsipe.result_file import read_result

reported = yaml.safe_load(Path(snakemake.input.reported).read_text(encoding="utf-8"))
fits = {}
paths = iter(snakemake.input.fits)
for experiment, conditions in snakemake.params.experiments.items():
    fits[experiment] = {condition: read_result(next(paths)) for condition in conditions}
findings = Findings(read_estimates(snakemake.input.estimates), fits, snakemake.params.as_printed)
write_claims(snakemake.output.table, check_claims(reported["claims"], findings))
