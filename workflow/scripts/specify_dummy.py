"""Estimate I, B, K of one trial of the ankle dummy by every combination of the choices of Appendix A."""

import job

job.start(snakemake)

from dummy_choices import dummy_options

from tepsipe.experiments.dummy.foot_pathways import FootOptions
from tepsipe.experiments.dummy.leg_pathways import Pathway
from tepsipe.experiments.dummy.specification_curve import SPECIFICATIONS, SpecificationOptions, specify_dummy
from tepsipe.io.trial import read_trial
from tepsipe.mechanics.inverse_dynamics import Foot

geometry, foot = snakemake.params.geometry, snakemake.params.foot
found = specify_dummy(
    read_trial(snakemake.input.trial),
    snakemake.params.condition,
    dummy_options(geometry, snakemake.params.analysis, foot["belt_fixed_labels"]),
    FootOptions(
        foot=Foot(mass_kg=geometry["foot_mass_kg"], height_m=geometry["foot_height_m"]),
        ankle_label=foot["ankle_label"],
        belt_fixed_labels=tuple(foot["belt_fixed_labels"]),
        belt=snakemake.params.belt,
    ),
    SpecificationOptions(**snakemake.params.options),
    # every combination has its markers at common instants
    Pathway(**(snakemake.params.as_printed | {"marker_instants": "aligned"})),
    Pathway(**snakemake.params.recommended),
)
SPECIFICATIONS.write(snakemake.output.table, found)
