"""Estimate I, B, K of one trial of the ankle dummy from the torque by the foot and the force plate."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.foot_pathways import FootOptions, FootPathway, analyse_foot
from tepsipe.experiments.dummy.leg_pathways import DummyOptions, dummy_estimates
from tepsipe.experiments.dummy.results import bootstrap_pathways, dummy_contributions, dummy_result
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import read_result, write_result
from tepsipe.io.trial import read_trial
from tepsipe.treadmill.held_out import read_held_out
from tepsipe.treadmill.plate_check import PlateCheck
from tepsipe.treadmill.registry import load_treadmill_models

geometry, choice = snakemake.params.geometry, snakemake.params.foot
condition = snakemake.wildcards.condition
calibration = read_result(snakemake.input.held_out[0])
plate = PlateCheck.from_result(calibration)
found = analyse_foot(
    plate.corrected(read_trial(snakemake.input.trial), snakemake.params.belt),
    f"dummy/{condition}",
    DummyOptions.from_settings(geometry, snakemake.params.analysis, (), snakemake.params.uncertainty),
    FootOptions.from_settings(
        geometry,
        choice,
        snakemake.params.belt,
        read_held_out(calibration),
    ),
    {name: FootPathway(**pathway) for name, pathway in choice["pathways"].items()},
    {
        load: load_treadmill_models(path)
        for load, path in zip(("Fy", "Mx"), snakemake.input.models, strict=True)
    },
)
intervals = bootstrap_pathways(found, snakemake.params.bootstrap_draws, snakemake.params.seed)
rows = dummy_estimates(condition, found, intervals)
write_result(snakemake.output.fit, dummy_result(found))
ESTIMATES.write(snakemake.output.estimates, rows)
CONTRIBUTIONS.write(snakemake.output.uncertainty, dummy_contributions(rows, found))
