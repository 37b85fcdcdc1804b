"""Compare the estimates of a simulated trial, or of several together, with the virtual laboratory's truth."""

import job

job.start(snakemake)

from tepsipe.io.estimates import ESTIMATES, RECOVERIES
from tepsipe.io.result import read_result
from tepsipe.reporting.recovery import (
    compare_with_truth,
    linear_truth,
    linear_truth_standing,
    read_true_motion,
    true_parameters,
    true_reflex,
)

params, windows = snakemake.params, snakemake.params.windows
motions = [read_true_motion(path) for path in snakemake.input.motions]
fits = [read_result(path) for path in snakemake.input.fits]
at_work = {}
if params.experiment == "wristalyzer" and fits:
    kept = [sample / fits[0].facts["rate_hz"] for sample in fits[0].facts["kept_samples"]]
    at_work["admittance"] = linear_truth(motions[0], [tuple(kept)], about_mean=True)
elif params.experiment == "dummy":
    time, pulses = fits[0].arrays["time"], fits[0].arrays["windows"]
    for pathway, length in windows["lengths_s"].items():
        ends = time[pulses[:, 1] - 1] if length is None else time[pulses[:, 0]] + length
        beyond = params.truth["dummy"]["subject"]["joint_inertia_kgm2"] if pathway in windows["foot"] else 0.0
        at_work[pathway] = linear_truth(
            motions[0], list(zip(time[pulses[:, 0]], ends, strict=True)), inertia_beyond=beyond
        )
elif params.experiment == "standing":
    onsets = [fit.arrays["onsets_s"] for fit in fits]
    used = [k for k, own in enumerate(onsets) if own.size]
    moved, onsets = [motions[k] for k in used], [onsets[k] for k in used]
    rest = tuple(windows["baseline_s"])
    reflex = true_reflex(moved, onsets, rest) if used else {}
    for estimator, choice in windows["estimators"].items() if used else ():
        linear = linear_truth_standing(moved, onsets, **choice, baseline_s=rest)
        at_work[estimator] = linear | reflex
known = true_parameters(params.truth)[params.constants]
RECOVERIES.write(
    snakemake.output.rows, compare_with_truth(ESTIMATES.read(*snakemake.input.estimates), known, at_work)
)
