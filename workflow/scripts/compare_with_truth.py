"""Compare estimates with the virtual laboratory's truth."""

import job

job.start(snakemake)

from tepsipe.io.estimates import ESTIMATES, RECOVERIES
from tepsipe.io.result import read_result
from tepsipe.reporting.laboratory import LABORATORY_ROWS, laboratory_rows
from tepsipe.reporting.recovery import compare_with_truth
from tepsipe.reporting.true_motion import linear_truth, linear_truth_standing, read_true_motion

params = snakemake.params
at_work, motions, fits = {}, iter(snakemake.input.motions), iter(snakemake.input.fits)
for condition in params.made.get("wristalyzer", ()):
    motion, fit = read_true_motion(next(motions)), read_result(next(fits))
    kept = [sample / fit.facts["rate_hz"] for sample in fit.facts["kept_samples"]]
    at_work["wristalyzer", condition, "admittance"] = linear_truth(motion, [tuple(kept)], about_mean=True)
for condition in params.made.get("dummy", ()):
    motion, fit = read_true_motion(next(motions)), read_result(next(fits))
    time, windows = fit.arrays["time"], fit.arrays["windows"]
    for pathway, length in params.windows_s.items():
        ends = time[windows[:, 1] - 1] if length is None else time[windows[:, 0]] + length
        inertia = params.truth["dummy"]["subject"]["joint_inertia_kgm2"] if pathway in params.at_foot else 0.0
        at_work["dummy", condition, pathway] = linear_truth(
            motion, list(zip(time[windows[:, 0]], ends, strict=True)), inertia_beyond=inertia
        )
if params.standing is not None:
    made = params.made["standing"]
    ankles = {condition: read_true_motion(next(motions)) for condition in made}
    onsets = {condition: read_result(next(fits)).arrays["onsets_s"] for condition in made}
    for name, conditions in params.standing["trials"].items():
        used = [condition for condition in conditions if onsets[condition].size]
        for estimator, choice in params.standing["estimators"].items() if used else ():
            at_work["standing", name, estimator] = linear_truth_standing(
                [ankles[condition] for condition in used],
                [onsets[condition] for condition in used],
                **choice,
                baseline_s=tuple(params.standing["baseline_s"]),
            )
rows = compare_with_truth(
    ESTIMATES.read(snakemake.input.estimates), params.truth, params.made, params.tasks, at_work, params.heavy
)
RECOVERIES.write(snakemake.output.table, rows)
made = [experiment for experiment, names in params.made.items() if names]
LABORATORY_ROWS.write(snakemake.output.laboratory, laboratory_rows(params.truth, made))
