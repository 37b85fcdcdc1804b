"""Noise of every target and level on one simulated trial."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.noise.monte_carlo import sweep_trial
from tepsipe.experiments.noise.onsets import onset_rows
from tepsipe.experiments.noise.rows import NOISE_ROWS, noise_rows
from tepsipe.experiments.noise.trial import simulated_trial
from tepsipe.io.result import read_result
from tepsipe.mechanics.inverse_dynamics import Foot

geometry, noise = snakemake.params.geometry, snakemake.params.noise
options = DummyOptions.from_settings(geometry, snakemake.params.analysis)
foot = Foot.from_settings(geometry)
condition, rows = snakemake.wildcards.condition, []
results = dict(zip(snakemake.params.conditions, map(read_result, snakemake.input.fits), strict=True))
for k, stiffness in enumerate(noise["joint"]["stiffness_Nm_per_rad"]):
    trials = {
        name: simulated_trial(result, f"K_{stiffness:g}", name, options.leg, foot)
        for name, result in results.items()
    }
    # the first stiffness is swept, the others are for the table
    levels = dict.fromkeys(noise["estimators"], noise["snr_db"]) if k == 0 else {}
    for estimator in noise["table_estimators"]:
        levels.setdefault(estimator, [noise["table_snr_db"]])
    trial = trials.pop(condition)
    if k == 0:  # the joint does not move the belt
        rows += onset_rows(
            trial,
            trials.values(),
            noise["snr_db"],
            noise["predicted_draws"],
            snakemake.params.seed,
            options.window,
            options.lowpass,
        )
    cells = sweep_trial(
        trial,
        levels,
        noise["draws"],
        snakemake.params.seed,
        trials.values(),
        noise["predicted_draws"],
        options.lowpass_cutoff_hz,
        options.lowpass_order,
    )
    rows += noise_rows(cells)
NOISE_ROWS.write(snakemake.output.noise, rows)
