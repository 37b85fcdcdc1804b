"""Pages of the trials with the weight, or with the empty belt."""

import job

job.start(snakemake)

from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import read_result
from tepsipe.io.trial import read_trial
from tepsipe.reporting.pages.trial_page import write_page
from tepsipe.reporting.pages.weight import weight_page

params, files = snakemake.params, snakemake.input
plates = dict(zip(params.belts, map(read_result, files.plates), strict=True))
for k, (condition, about) in enumerate(params.trials.items()):
    choices = {"study": params.title, "experiment": params.experiment, "condition": condition, **about}
    plate = plates.get(about["belt"])
    estimates = ESTIMATES.read(files.estimates[k])
    page = weight_page(read_trial(files.trials[k]), read_result(files.fits[k]), plate, estimates, choices)
    write_page(snakemake.output.pages[k], page)
