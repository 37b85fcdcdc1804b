"""One trial with the weight, or with the empty belt: mass, and belt-induced force."""

import job

job.start(snakemake)

from tepsipe.experiments.budgets import contributions_of
from tepsipe.experiments.weight.analysis import QUANTITIES, analyse_weight, weight_estimates, weight_result
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.statistics.uncertainty import sources_of
from tepsipe.treadmill.trial_recordings import PlateOptions, Weight, marker_lag, plate_recordings

analysis = snakemake.params.analysis
experiment, condition = snakemake.wildcards.experiment, snakemake.wildcards.condition
weight = None if snakemake.params.weight is None else Weight(**snakemake.params.weight)
filters = [Lowpass(cutoff, analysis["lowpass_order"], True) for cutoff in analysis["cutoffs_hz"]]
trial, name = read_trial(snakemake.input.trial), f"{experiment}/{condition}"
choices = [(lowpass, "markers", f"{lowpass.cutoff_hz:g} Hz") for lowpass in filters]
if weight is not None:
    # the same force, with the inertia of a weight that moves exactly with the belt
    choices.append((filters[0], "belt", "belt"))
recordings = {}
for lowpass, weight_motion, label in choices:
    options = PlateOptions(
        snakemake.params.belt,
        lowpass,
        filters[0],
        WindowOptions(**analysis["window"]),
        analysis["segment_s"],
        weight_motion,
    )
    recordings[label] = plate_recordings(trial, name, condition, options, weight)["Fy"]
lag = None if weight is None else marker_lag(trial, name, options)
result = analyse_weight(recordings, sources_of(snakemake.params.uncertainty), lag)
rows = weight_estimates(experiment, condition, result)
write_result(snakemake.output.fit, weight_result(result))
ESTIMATES.write(snakemake.output.estimates, rows)
CONTRIBUTIONS.write(
    snakemake.output.uncertainty,
    [] if result.budget is None else contributions_of(rows, result.budget, QUANTITIES),
)
