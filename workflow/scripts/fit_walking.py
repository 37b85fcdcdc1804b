"""Impedance of the ankle in one walking trial, and the strides that it would need."""

import job

job.start(snakemake)

import json
import math
from pathlib import Path

import numpy as np

from tepsipe.experiments.walking.analysis import analyse_walking
from tepsipe.experiments.walking.files import read_events, read_recording
from tepsipe.experiments.walking.impedance import WalkingOptions
from tepsipe.experiments.walking.needed import ExpectedPulse, NeededRow, needed_strides
from tepsipe.experiments.walking.recording import agreement, ankle_moment, bandwidth_hz
from tepsipe.experiments.walking.results import WalkingRow, walking_rows
from tepsipe.experiments.walking.strides import random_onsets, segment_strides
from tepsipe.io.csv_table import write_rows
from tepsipe.statistics.uncertainty import sources_of

settings, params = snakemake.params.settings, snakemake.params
condition = snakemake.wildcards.walk
recording = read_recording(params.recording, settings["columns"], settings["rate_hz"], settings["max_gap_s"])
events = read_events(params.events, settings["events"])
strides = segment_strides(
    events["heel_strike"], events["toe_off"], name=params.events, from_s=settings["from_s"]
)
chosen = settings["analysis"]
matched_by = None if chosen["matched_by"] is None else tuple(chosen["matched_by"])
options = WalkingOptions(
    **chosen | {"phases_percent": tuple(chosen["phases_percent"]), "matched_by": matched_by}
)
pulsed = events["pulse"].size > 0
onsets = events["pulse"]
if not pulsed:  # pulses of no size at random strides: what the intervals say when nothing is known
    onsets = random_onsets(strides, options.phases_percent, np.random.default_rng(params.seed))
fewest = options if pulsed else WalkingOptions(**vars(options) | {"fewest_strides": 3, "recovery_strides": 0})
found = analyse_walking(recording, strides, onsets, fewest, sources_of(settings["uncertainty"]))
rows = walking_rows(condition, "recorded" if pulsed else "none", found)
write_rows(snakemake.output.rows, WalkingRow, rows)

planned = settings["planned"]
pulse = ExpectedPulse(
    math.radians(planned["amplitude_deg"]),
    planned["duration_s"],
    dict(zip(options.phases_percent, planned["stiffness_Nm_per_rad"], strict=False)),
    planned["damping_Nms_per_rad"],
)
quiet = strides.taken(found.quiet) if pulsed else strides
needed = needed_strides(condition, recording, quiet, pulse, options)
write_rows(snakemake.output.needed, NeededRow, needed)
supplied = recording.supplied_moment
about = {
    "condition": condition,
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
