"""Fit treadmill models to recordings with the role calibrate, and evaluate them on those to validate."""

import job

job.start(snakemake)


from tepsipe.arguments import options_of
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.signals.filters import Lowpass
from tepsipe.treadmill.calibration import MODEL_SCORES, calibrate, table_plan, table_result
from tepsipe.treadmill.registry import FamilyOptions, save_models
from tepsipe.treadmill.table_summary import table_facts
from tepsipe.treadmill.trial_recordings import table_recording

analysis, models = snakemake.params.analysis, dict(snakemake.params.models)
family, shown_hz = models.pop("family"), analysis["shown_cutoff_hz"]
options = options_of(FamilyOptions, models)
roles = dict(snakemake.params.roles)
trials = {name: read_trial(path) for name, path in zip(roles, snakemake.input.trials, strict=True)}
ingested = {name: trial.attributes for name, trial in trials.items()}
recordings = {name: table_recording(trial, name, analysis["trimmed_s"]) for name, trial in trials.items()}
names = [condition for condition, role in roles.items() if role == "calibrate"]
train = "+".join(names)
scores = []
for cutoff in sorted({*analysis["cutoffs_hz"], shown_hz}):
    lowpass = Lowpass(cutoff, analysis["lowpass_order"], analysis["zero_lag"])
    filtered = {condition: recording.filtered(lowpass) for condition, recording in recordings.items()}
    testing = {name: [filtered[name]] for name in roles if name not in names}
    plan = table_plan(family, train, list(testing))
    found, fitted = calibrate(plan, {train: [filtered[n] for n in names]}, testing, "load", options)
    scores += found
    if cutoff == shown_hz:
        save_models(snakemake.output.models, fitted)
        calibration = [filtered[name] for name in names]
        result = table_result(fitted, [filtered[name] for name in testing], ingested)
        result.facts.update(table_facts(fitted, calibration, filtered, family, options))
        write_result(snakemake.output.fit, result)
MODEL_SCORES.write(snakemake.output.scores, scores)
