"""Pages of the trials of a standing person."""

import job

job.start(snakemake)

from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import read_result
from tepsipe.io.trial import read_trial
from tepsipe.reporting.pages.standing import standing_page
from tepsipe.reporting.pages.trial_page import write_page

params, files = snakemake.params, snakemake.input
for k, (condition, about) in enumerate(params.trials.items()):
    recommended = list(params.recommended.values())
    choices = {"study": params.title, "condition": condition, "recommended": recommended, **about}
    fit, epochs = read_result(files.fits[k]), read_result(files.epochs[k])
    page = standing_page(
        read_trial(files.trials[k]), fit, epochs, ESTIMATES.read(files.estimates[k]), choices
    )
    write_page(snakemake.output.pages[k], page)
