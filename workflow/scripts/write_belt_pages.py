"""Pages of the recordings of an unloaded treadmill."""

import job

job.start(snakemake)

from tepsipe.io.result import read_result
from tepsipe.io.trial import read_trial
from tepsipe.reporting.pages.manipulators import belt_page
from tepsipe.reporting.pages.trial_page import write_page

params, files = snakemake.params, snakemake.input
calibration = read_result(files.fit[0])
for (condition, role), trial, page in zip(
    params.roles.items(), files.trials, snakemake.output.pages, strict=True
):
    choices = {
        "study": params.title,
        "condition": condition,
        "role": role,
        "chosen": params.chosen,
        "made": condition in params.made,
    }
    write_page(page, belt_page(read_trial(trial), calibration, choices))
