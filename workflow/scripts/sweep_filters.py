"""Estimate I, B, K of one simulated trial behind every filter, with and without a treadmill model."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.foot_pathways import FootOptions
from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.planning.filter_trials import filter_estimates
from tepsipe.experiments.planning.filtering import lowpasses
from tepsipe.io.tables import write_records
from tepsipe.io.trial import read_trial
from tepsipe.reporting.plan_tables import window_rows
from tepsipe.treadmill.registry import load_treadmill_models, pick

geometry, foot = snakemake.params.geometry, snakemake.params.foot
condition, filters = snakemake.wildcards.condition, snakemake.params.filters
trial = read_trial(snakemake.input.trial)
options = FootOptions.from_settings(geometry, foot, snakemake.params.belt)
models = {
    load: pick(load_treadmill_models(path), snakemake.params.treadmill_model)
    for load, path in zip(("Fy", "Mx"), snakemake.input.models, strict=True)
}
rows = []
for lowpass in lowpasses(**filters):
    found = filter_estimates(
        trial,
        f"dummy/{condition}",
        DummyOptions.from_settings(geometry, snakemake.params.analysis),
        options,
        models,
        lowpass,
    )
    rows += window_rows(condition, found)
write_records(snakemake.output.windows, rows)
