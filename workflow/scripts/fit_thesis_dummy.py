"""Find the dummy that returns the thesis's printed tables, and what it gives for each printed number."""

import job

job.start(snakemake)

import numpy as np

from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.thesis_dummy.inverse import (
    CELL_ROWS,
    JOINTS,
    PrintedPath,
    belt_motion,
    cell_rows,
    copied_rms,
    fit_marker_noise,
    fit_result,
    fit_tables,
    printed_and_predicted,
    swings,
)
from tepsipe.experiments.thesis_dummy.timing import linear_joint, timing_facts
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.mechanics.impedance_model import PARAMETERS

params = snakemake.params
options = DummyOptions.from_settings(params.geometry, params.analysis)
order = [params.marker_labels.index(label) for label in options.leg_markers.labels]
sampling = params.marker_sampling_hz
trials = {
    name: read_trial(path) for name, path in zip(params.conditions, snakemake.input.trials, strict=True)
}
path = PrintedPath(
    leg=options.leg,
    markers=options.leg_markers,
    sampled_after_s=np.array(order) / sampling if sampling else np.zeros(len(order)),
    rate_hz=next(iter(trials.values())).rate_hz,
    cutoff_hz=options.lowpass_cutoff_hz,
    order=options.lowpass_order,
    window=options.window,
)
belts = {name: belt_motion(trial, path) for name, trial in trials.items()}
# the search needs not all pulses
shorter = {name: belt_motion(trial, path, params.searched_s) for name, trial in trials.items()}
tables, printed, seed = list(params.tables), params.printed, params.seed
fitted = [name for table in tables for name in table]
fits = {law: fit_tables(path, shorter, printed, tables, fixed) for law, fixed in JOINTS.items()}
full = list(fits.values())[-1]
joint = full.joint
angles = {name: angle[0] for name, angle in swings(path, [joint], belts).items()}
noise = fit_marker_noise(path, belts, angles, printed["VAF_trial"], fitted, seed)
cells = printed_and_predicted(path, belts, angles, printed, fitted, noise, params.draws, seed)
followed = tuple(
    linear_joint(*(params.followed[name][quantity] for quantity in PARAMETERS))
    for name in ("thesis-wristalyzer", "thesis-without-handle")
)
timing = timing_facts(path, shorter, printed, full, followed)
write_result(snakemake.output.fit, fit_result(fits, noise, copied_rms(printed, tables), timing))
CELL_ROWS.write(snakemake.output.table, cell_rows(cells))
