"""Impedance of the ankle in one walking trial, and the strides that it would need."""

import job

job.start(snakemake)

import json
from pathlib import Path

from tepsipe.experiments.walking.fit import fit
from tepsipe.experiments.walking.needed_strides import NEEDED_ROWS
from tepsipe.experiments.walking.results import WALKING_ROWS
from tepsipe.experiments.walking.trial import read_trial
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES

params, output = snakemake.params, snakemake.output
fitted = fit(
    read_trial(dict(params.files), params.section, params.made),
    params.section,
    snakemake.wildcards.condition,
    params.seed,
    None if params.made else params.duration_s,
)
ESTIMATES.write(output.estimates, fitted.estimates)
CONTRIBUTIONS.write(output.budgets, fitted.contributions)
WALKING_ROWS.write(output.rows, fitted.further["rows"])
NEEDED_ROWS.write(output.needed, fitted.further["needed"])
about = json.dumps(fitted.result.facts, indent=1, ensure_ascii=False)
Path(output.about).write_text(about + "\n", "utf-8")
