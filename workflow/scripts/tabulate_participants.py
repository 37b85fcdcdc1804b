"""Estimates of every participant, and means over participants."""

import job

job.start(snakemake)

from tepsipe.io.budget_table import read_budgets
from tepsipe.io.estimates import read_estimates
from tepsipe.reporting.participants import (
    Member,
    group_estimates,
    person_estimates,
    write_group,
    write_people,
)

params = snakemake.params
people = person_estimates(
    read_estimates(snakemake.input.estimates),
    [Member(**member) for member in params.members],
    params.masses_kg,
    read_budgets(snakemake.input.uncertainty),
)
write_people(snakemake.output.participants, people, params.by_belt)
write_group(snakemake.output.group, group_estimates(people), params.by_belt)
