"""Estimate I, B, K of one trial of the ankle dummy by every combination of the choices of Appendix A."""

import job

job.start(snakemake)

from dummy_choices import dummy_options

from tepsipe.foot_sipe import FootOptions
from tepsipe.inverse_dynamics import Foot
from tepsipe.specification import SpecificationOptions, specify_dummy, write_specification
from tepsipe.tep_sipe import Pathway
from tepsipe.trial_file import read_trial

geometry, foot = snakemake.params.geometry, snakemake.params.foot
found = specify_dummy(
    read_trial(snakemake.input.trial),
    snakemake.params.condition,
    dummy_options(geometry, snakemake.params.analysis, foot["riding_labels"]),
    FootOptions(
        foot=Foot(mass_kg=geometry["foot_mass_kg"], height_m=geometry["foot_height_m"]),
        ankle_label=foot["ankle_label"],
        riding_labels=tuple(foot["riding_labels"]),
        belt=foot["belt"],
    ),
    SpecificationOptions(**snakemake.params.options),
    Pathway(**snakemake.params.as_printed),
    Pathway(**snakemake.params.recommended),
)
write_specification(snakemake.output.table, found)
