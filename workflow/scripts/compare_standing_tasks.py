"""K and B of one task of a standing person less those of another, with what both share subtracted."""

import job

job.start(snakemake)

from tepsipe.experiments.standing.free_reflex.results import task_difference
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES, recommended
from tepsipe.io.result import read_result

more, less = read_result(snakemake.input.more), read_result(snakemake.input.less)
critical = more.facts["critical_stiffness_Nm_per_rad"]
rows, contributions = task_difference(snakemake.wildcards.pair, more, less, critical)
ESTIMATES.write(snakemake.output.estimates, recommended(rows, **snakemake.params.recommended))
CONTRIBUTIONS.write(snakemake.output.uncertainty, contributions)
