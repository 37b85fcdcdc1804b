"""Predict the uncertainty of I, B, K of one design, and draw trials with noise to check it."""

import job

job.start(snakemake)

import hashlib

import numpy as np

from tepsipe.experiments.planning.design import FOOT, LEG, Design
from tepsipe.experiments.planning.plan import draw_estimates, plan_experiment
from tepsipe.io.tables import write_records
from tepsipe.reporting.plan_tables import checked_rows

name, plan = snakemake.wildcards.design, snakemake.params.plan
design = Design.from_settings(plan, name, snakemake.params.geometry, snakemake.params.uncertainty)
planned = plan_experiment(design)
# a design draws the same noise whatever the others are
seed = [plan["seed"], int(hashlib.sha256(name.encode()).hexdigest()[:8], 16)]
draws = plan["window_draws" if design.protocol.pathway in (LEG, FOOT) else "draws"]
drawn = draw_estimates(design, planned.motion, np.random.default_rng(seed), draws)
write_records(snakemake.output.rows, checked_rows(name, planned, drawn))
