"""Estimates of every participant, and means over participants."""

import job

job.start(snakemake)

from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.reporting.participants import (
    GROUP_ESTIMATES,
    PERSON_ESTIMATES,
    Member,
    group_estimates,
    person_estimates,
)

params = snakemake.params
people = person_estimates(
    ESTIMATES.read(snakemake.input.estimates),
    [Member(**member) for member in params.members],
    params.masses_kg,
    CONTRIBUTIONS.read(snakemake.input.uncertainty),
)
without = () if params.by_belt else ("belt",)
PERSON_ESTIMATES.write(snakemake.output.participants, people, without=without)
GROUP_ESTIMATES.write(snakemake.output.group, group_estimates(people), without=without)
