"""Predict every Wristalyzer trial with every trial's parameters."""

import job

job.start(snakemake)

from tepsipe.experiments.budgets import cross_validation_rows
from tepsipe.experiments.wristalyzer.analysis import AS_PRINTED, PATHWAY, cross_validate_wristalyzer
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import Result, read_result, write_result

conditions = list(snakemake.params.conditions)
results = {
    condition: read_result(path) for condition, path in zip(conditions, snakemake.input.fits, strict=True)
}
matrix = cross_validate_wristalyzer(results)
write_result(snakemake.output.matrix, Result({"vaf": matrix}, {"vaf": "%"}, {"conditions": conditions}))
names = [("wristalyzer", condition, PATHWAY, AS_PRINTED) for condition in conditions]
ESTIMATES.write(snakemake.output.estimates, cross_validation_rows(names, matrix))
