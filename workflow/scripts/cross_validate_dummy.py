"""Predict every trial of the dummy with every trial's parameters, pathway by pathway."""

import job

job.start(snakemake)

from tepsipe.experiments.budgets import cross_validation_rows
from tepsipe.experiments.dummy.results import cross_validate_dummy
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import Result, read_result, write_result

conditions = list(snakemake.params.conditions)
results = {
    condition: read_result(path) for condition, path in zip(conditions, snakemake.input.fits, strict=True)
}
facts = next(iter(results.values())).facts
matrices = {name: cross_validate_dummy(results, name) for name in facts["pathways"]}
rows = []
for name, matrix in matrices.items():
    rows += cross_validation_rows([("dummy", c, name, facts["estimators"][name]) for c in conditions], matrix)
write_result(
    snakemake.output.matrices, Result(matrices, dict.fromkeys(matrices, "%"), {"conditions": conditions})
)
ESTIMATES.write(snakemake.output.estimates, rows)
