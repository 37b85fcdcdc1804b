"""Find the best pulses within the limits of the reference pulses, of the drive, and of comfort."""

import job

job.start(snakemake)


from tepsipe.experiments.planning.design import Design
from tepsipe.experiments.planning.plan import plan_experiment
from tepsipe.experiments.planning.pulses import Limits
from tepsipe.io.tables import write_records
from tepsipe.reporting.plan_tables import compared_pulses

comparisons, shapes = [], []
for name in snakemake.params.plan["references"]:
    given = (snakemake.params.plan, name, snakemake.params.geometry, snakemake.params.uncertainty)
    found, moved = compared_pulses(
        name, plan_experiment(Design.from_settings(*given)), Limits(**snakemake.params.plan["comfort"])
    )
    comparisons += found
    shapes += moved
write_records(snakemake.output.pulses, comparisons)
write_records(snakemake.output.shapes, shapes)
