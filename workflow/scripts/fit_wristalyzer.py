"""Estimate the joint's admittance and fit I, B, K to one Wristalyzer trial."""

import job

job.start(snakemake)

import numpy as np

from tepsipe.experiments.wristalyzer.analysis import (
    analyse_wristalyzer,
    wristalyzer_contributions,
    wristalyzer_estimates,
    wristalyzer_result,
)
from tepsipe.experiments.wristalyzer.record import WristalyzerOptions
from tepsipe.identification.admittance_fit import Bounds
from tepsipe.io.budget_table import CONTRIBUTIONS
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.statistics.uncertainty import sources_of

analysis = dict(snakemake.params.analysis)


def joint(values):
    """I, B, K as the library orders them."""
    return np.array([values[key] for key in ("I_Nms2_per_rad", "B_Nms_per_rad", "K_Nm_per_rad")])


bounds = Bounds(*[joint(analysis.pop(key)) for key in ("start", "lower", "upper")])
profile = (*analysis.pop("profile_stiffness_Nm_per_rad"), analysis.pop("profile_points"))
options = WristalyzerOptions(bounds=bounds, profile_Nm_per_rad=profile, **analysis)
found = analyse_wristalyzer(
    read_trial(snakemake.input.trial),
    options,
    np.random.default_rng(snakemake.params.seed),
    sources_of(snakemake.params.uncertainty),
)
rows = wristalyzer_estimates(snakemake.wildcards.condition, found)
write_result(snakemake.output.fit, wristalyzer_result(found))
ESTIMATES.write(snakemake.output.estimates, rows)
CONTRIBUTIONS.write(snakemake.output.uncertainty, wristalyzer_contributions(rows, found.budgets))
