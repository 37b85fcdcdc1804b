"""Impedance of the ankle in one walking trial, and the strides that it would need."""

import job

job.start(snakemake)

import json
from pathlib import Path

import numpy as np

from tepsipe.experiments.walking.analysis import analyse_walking, without_pulses
from tepsipe.experiments.walking.impedance import WalkingOptions
from tepsipe.experiments.walking.needed_strides import NEEDED_ROWS, ExpectedPulse, needed_strides
from tepsipe.experiments.walking.results import WALKING_ROWS, walking_estimates, walking_rows
from tepsipe.experiments.walking.strides import agreement, ankle_moment, bandwidth_hz
from tepsipe.experiments.walking.trial import read_trial
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.signals.resampling import refuse_short
from tepsipe.statistics.uncertainty import sources_of

settings, params = snakemake.params.settings, snakemake.params
condition = snakemake.wildcards.condition
recording, strides, events = read_trial(dict(params.files), settings, params.made)
if not params.made:
    refuse_short(float(np.ptp(recording.time)), params.duration_s, recording.name)
options = WalkingOptions(**settings["analysis"])
onsets, pulsed = events["pulse"], events["pulse"].size > 0
fewest = options
if not pulsed:
    onsets, fewest = without_pulses(strides, options, np.random.default_rng(params.seed))
found = analyse_walking(recording, strides, onsets, fewest, sources_of(settings["uncertainty"]))
estimates, budgets = walking_estimates(condition, found)
ESTIMATES.write(snakemake.output.estimates, estimates)
CONTRIBUTIONS.write(snakemake.output.budgets, budgets)
rows = walking_rows(condition, "recorded" if pulsed else "none", found)
WALKING_ROWS.write(snakemake.output.rows, rows)

quiet = strides.taken(found.quiet) if pulsed else strides
needed = needed_strides(condition, recording, quiet, ExpectedPulse(**settings["planned"]), options)
NEEDED_ROWS.write(snakemake.output.needed, needed)
supplied = recording.supplied_moment
about = {
    "condition": condition,
    "source": "virtual_lab" if params.made else "recorded",
    "strides": len(strides),
    "pulses": len(onsets) if pulsed else 0,
    "stance_s": found.stance_s,
    "bandwidth_hz": None
    if supplied is None
    else bandwidth_hz(supplied, ankle_moment(recording), recording.rate_hz),
    "agreement_Nm": None if supplied is None else agreement(recording, strides.in_stance(recording.time)),
    "dropped": list(found.dropped),
}
Path(snakemake.output.about).write_text(json.dumps(about, indent=1, ensure_ascii=False) + "\n", "utf-8")
