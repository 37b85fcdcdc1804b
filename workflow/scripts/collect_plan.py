"""Tables of the plan study: designs, and filters, whose estimates of simulated trials meet the truth here."""

import job

job.start(snakemake)

import pandas as pd

from tepsipe.experiments.planning.design import Design
from tepsipe.experiments.planning.filtering import lowpasses
from tepsipe.io.tables import write_records
from tepsipe.reporting.plan_tables import predicted_filters, simulated_filters
from tepsipe.reporting.recovery import read_true_motion

designs = [pd.read_csv(path) for path in snakemake.input.designs]
pd.concat(designs).to_csv(snakemake.output.plan, index=False, float_format="%.10g", lineterminator="\n")
params = snakemake.params
filters = dict(params.plan["filters"])
design = Design.from_settings(params.plan, filters.pop("design"), params.geometry, params.uncertainty)
every = lowpasses(**filters)
truth = {
    condition: read_true_motion(path)
    for condition, path in zip(params.conditions, snakemake.input.truth, strict=True)
}
windows = pd.concat([pd.read_csv(path) for path in snakemake.input.windows])
rows = predicted_filters(design, every)
rows += simulated_filters(windows, truth)
write_records(snakemake.output.filters, rows)
