"""Impedance of all trials of the position-controlled manipulator with their operating points."""

import job

job.start(snakemake)

from tepsipe.experiments.position_manipulator.operating_points import (
    OPERATING_POINTS,
    RELATIONS,
    Nominal,
    operating_points,
    relations,
)
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import read_result

nominal = {condition: Nominal(**said) for condition, said in snakemake.params.nominal.items()}
measured = {}
for condition, path in zip(nominal, snakemake.input.fits, strict=True):
    arrays = read_result(path).arrays
    measured[condition] = (float(arrays["angle"].mean()), float(arrays["torque"].mean()))
rows = ESTIMATES.read(*snakemake.input.estimates)
points = operating_points(rows, measured, nominal)
OPERATING_POINTS.write(snakemake.output.points, points)
RELATIONS.write(snakemake.output.relations, relations(points))
