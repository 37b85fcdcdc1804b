"""Pages of the recordings of an unloaded treadmill."""

import job

job.start(snakemake)

from tepsipe.io.result import read_result
from tepsipe.io.trial import read_trial
from tepsipe.reporting.pages.manipulators import belt_page
from tepsipe.reporting.pages.trial_page import write_page

params, files = snakemake.params, snakemake.input
calibration = read_result(files.fit[0])
for k, (condition, about) in enumerate(params.trials.items()):
    choices = {"study": params.title, "condition": condition, "chosen": params.chosen, **about}
    page = belt_page(read_trial(files.trials[k]), calibration, choices)
    write_page(snakemake.output.pages[k], page)
