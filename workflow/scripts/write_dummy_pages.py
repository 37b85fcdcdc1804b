"""Pages of the trials of the ankle dummy."""

import job

job.start(snakemake)

from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import read_result
from tepsipe.io.trial import read_trial
from tepsipe.reporting.pages.dummy import dummy_page
from tepsipe.reporting.pages.trial_page import write_page

params, files = snakemake.params, snakemake.input
for k, (condition, about) in enumerate(params.trials.items()):
    foot = read_result(files.foot[k]) if files.foot else None
    estimates = ESTIMATES.read(files.estimates[k])
    if files.foot_estimates:
        estimates += ESTIMATES.read(files.foot_estimates[k])
    choices = {"study": params.title, "condition": condition, "recommended": params.recommended, **about}
    page = dummy_page(read_trial(files.trials[k]), read_result(files.fits[k]), foot, estimates, choices)
    write_page(snakemake.output.pages[k], page)
