"""Pages of the trials in the torque-controlled manipulator."""

import job

job.start(snakemake)

from tepsipe.io.estimates import read_estimates
from tepsipe.io.result import read_result
from tepsipe.io.trial import read_trial
from tepsipe.reporting.pages.manipulators import wristalyzer_page
from tepsipe.reporting.pages.trial_page import write_page

params, files = snakemake.params, snakemake.input
for condition, trial, fit, estimates, page in zip(
    params.conditions, files.trials, files.fits, files.estimates, snakemake.output.pages, strict=True
):
    choices = {"study": params.title, "condition": condition, "made": condition in params.made}
    write_page(
        page, wristalyzer_page(read_trial(trial), read_result(fit), read_estimates(estimates), choices)
    )
