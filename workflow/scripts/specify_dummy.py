"""Estimate I, B, K of one trial of the ankle dummy by every combination of the choices of Appendix A."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.foot_pathways import FootOptions
from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.dummy.options import Pathway, SpecificationOptions
from tepsipe.experiments.dummy.specification_curve import SPECIFICATIONS, specify_dummy
from tepsipe.io.trial import read_trial

geometry, foot = snakemake.params.geometry, snakemake.params.foot
found = specify_dummy(
    read_trial(snakemake.input.trial),
    snakemake.params.condition,
    DummyOptions.from_settings(geometry, snakemake.params.analysis, foot["belt_fixed_labels"]),
    FootOptions.from_settings(geometry, foot, snakemake.params.belt),
    SpecificationOptions(**snakemake.params.options),
    # every combination has its markers at common instants
    Pathway(**(snakemake.params.as_printed | {"marker_instants": "aligned"})),
    Pathway(**snakemake.params.recommended),
)
SPECIFICATIONS.write(snakemake.output.table, found)
