"""Estimate I, B, K of one trial of the ankle dummy by every pathway."""

import job

job.start(snakemake)

import numpy as np

from tepsipe.estimates import write_estimates
from tepsipe.inverse_dynamics import Leg
from tepsipe.result_file import write_result
from tepsipe.segment_regression import LegMarkers, WindowOptions
from tepsipe.tep_sipe import (
    DummyOptions,
    Pathway,
    analyse_dummy,
    bootstrap_pathways,
    dummy_estimates,
    dummy_result,
)
from tepsipe.trial_file import read_trial

geometry, analysis = dict(snakemake.params.geometry), dict(snakemake.params.analysis)
placed = geometry["leg_markers"]
draws = analysis.pop("bootstrap_draws")
options = DummyOptions(
    leg=Leg(
        mass_kg=geometry["leg_mass_kg"],
        com_m=geometry["leg_com_m"],
        inertia_kgm2=geometry["leg_inertia_kgm2"],
        gravity_m_per_s2=geometry["gravity_m_per_s2"],
    ),
    leg_markers=LegMarkers(
        tuple(marker["label"] for marker in placed),
        np.array([[marker["across_m"], marker["along_m"]] for marker in placed]),
    ),
    lowpass_cutoff_hz=analysis.pop("lowpass_cutoff_hz"),
    lowpass_order=analysis.pop("lowpass_order"),
    window=WindowOptions(**analysis),
)
pathways = {name: Pathway(**choice) for name, choice in snakemake.params.pathways.items()}
found = analyse_dummy(read_trial(snakemake.input.trial), options, pathways)
intervals = bootstrap_pathways(found, draws, snakemake.params.seed)
write_result(snakemake.output.fit, dummy_result(found, intervals))
write_estimates(
    snakemake.output.estimates,
    dummy_estimates(snakemake.wildcards.condition, found, intervals),
)
