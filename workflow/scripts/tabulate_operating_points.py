"""Impedance of all trials of the position-controlled manipulator with their operating points."""

import job

job.start(snakemake)

from tepsipe.io.estimates import read_estimates
from tepsipe.io.result import read_result
from tepsipe.reporting.operating_points import (
    Nominal,
    operating_points,
    relations,
    write_operating_points,
    write_relations,
)

nominal = {condition: Nominal(**said) for condition, said in snakemake.params.nominal.items()}
measured = {}
for condition, path in zip(nominal, snakemake.input.fits, strict=True):
    arrays = read_result(path).arrays
    measured[condition] = (float(arrays["angle"].mean()), float(arrays["torque"].mean()))
rows = [row for path in snakemake.input.estimates for row in read_estimates(path)]
points = operating_points(rows, measured, nominal)
write_operating_points(snakemake.output.points, points)
write_relations(snakemake.output.relations, relations(points))
