"""Pages of the trials in the torque-controlled manipulator."""

import job

job.start(snakemake)

from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import read_result
from tepsipe.io.trial import read_trial
from tepsipe.reporting.pages.manipulators import wristalyzer_page
from tepsipe.reporting.pages.trial_page import write_page

params, files = snakemake.params, snakemake.input
for k, (condition, about) in enumerate(params.trials.items()):
    trial, fit = read_trial(files.trials[k]), read_result(files.fits[k])
    choices = {"study": params.title, "condition": condition, **about}
    page = wristalyzer_page(trial, fit, ESTIMATES.read(files.estimates[k]), choices)
    write_page(snakemake.output.pages[k], page)
