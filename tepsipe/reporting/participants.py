"""Estimates of each participant, also per kilogram of body mass, differences between tasks, and group means.

A participant's value is that of the trials analysed together (the tasks of a standing person), or the mean
over the participant's trials of a condition. Within a person, scatter is independent between trials and
tasks, and what is not known of person and rig is the same (`tepsipe.reporting.budgets`): it does not average
out, and only its change counts in a difference. A group mean counts every person once; its interval is from
the scatter between people.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from tepsipe.io.estimates import Contribution, Estimate, Estimated
from tepsipe.io.tables import NO_COLUMN, Table
from tepsipe.reporting.budgets import difference_parts, mean_parts, parts_of
from tepsipe.statistics.group import group_mean, typical_uncertainty

# quantities that are also given per kilogram of body mass
PER_KG = ("K", "B")
NORMAL_95 = 1.959963984540054


@dataclass(frozen=True)
class Member:
    """Whose estimates the rows of one trial, or of trials analysed together, are."""

    experiment: str
    condition: str
    """Names in the rows of estimates."""
    participant: str
    """The person."""
    label: str
    """What the person's trials have in common with those of other people: the task, or the condition."""
    is_task: bool
    """Whether ``label`` is a task: differences between tasks are computed."""
    trials: int
    """Number of trials behind the rows."""
    belt: str = ""
    """Belt of the treadmill, empty where the study does not separate them."""


@dataclass(frozen=True)
class PersonEstimate:
    """One quantity of one participant; the fields are the columns of ``tables/participants.csv``."""

    experiment: str
    participant: str
    condition: str
    """Experiment, person, and task or condition; for a difference ``stiff minus relax``."""
    pathway: str
    estimator: str
    quantity: str
    unit: str
    """As in the rows of estimates; ``K_per_kg`` is K over the body mass."""
    value: float
    standard_error: float | None
    ci_low: float | None
    ci_high: float | None
    """Value, its standard error and 95 % interval within the person (``unit``)."""
    n_trials: int
    """Number of trials."""
    mass_kg: float | None
    """Body mass (kg); None where it is not known."""
    flags: str = ""
    """Failed checks of the estimates, joined by ``;``."""
    belt: str = ""
    """Belt of the treadmill, empty where the study does not separate them."""
    parts: Mapping[str, float] = field(default_factory=dict, metadata=NO_COLUMN)
    """Source -> standard uncertainty (``unit``); not a column."""


@dataclass(frozen=True)
class GroupEstimate(Estimated):
    """Mean of one quantity over people; the fields are the columns of ``tables/group.csv``."""

    n: int
    """Number of people whose value has no flag."""
    mean: float | None
    sd: float | None
    sem: float | None
    ci_low: float | None
    ci_high: float | None
    """Mean over these people, standard deviation between them, standard error of the mean and its 95 %
    interval by Student's t (``unit``); None for nobody and, except the mean, for one person."""
    u_within: float | None
    """Typical standard error within a person: root mean square over people (``unit``)."""
    n_flagged: int
    """Number of people whose value has a flag (-), and is left out."""
    belt: str = ""
    """Belt of the treadmill, empty where the study does not separate them."""


PERSON_ESTIMATES = Table(PersonEstimate, "estimates of participants")
GROUP_ESTIMATES = Table(GroupEstimate, "means over participants")


def person_estimates(
    estimates: Iterable[Estimate],
    members: list[Member],
    masses_kg: dict[str, dict[str, float | None]],
    budgets: Iterable[Contribution] = (),
) -> list[PersonEstimate]:
    """Estimates of every participant: as estimated, per kilogram, and differences between tasks.

    estimates: rows of all trials (units in them). Rows of no member are omitted, and values that are not
    finite.
    members: trials, or trials analysed together, of the participants.
    masses_kg: experiment -> participant -> body mass (kg); None where it is not known.
    budgets: rows of the uncertainty budgets, as far as there are any (units in them).
    Returns: sorted by name, so that the order of the rows does not matter.
    """
    member_of = {(m.experiment, m.condition): m for m in members}
    sources: dict[tuple, dict[str, float]] = {}
    for part in budgets:
        sources.setdefault(part.key, {})[part.source] = part.u
    found: dict[tuple, list[tuple[Member, Estimate]]] = {}
    for row in estimates:
        member = member_of.get((row.experiment, row.condition))
        if member is not None and math.isfinite(row.value):
            key = (row.experiment, member.label, member.belt, member.participant)
            key += (row.pathway, row.estimator, row.quantity, row.unit)
            found.setdefault(key, []).append((member, row))
    people = []
    for (experiment, label, belt, participant, *what), rows in found.items():
        rows.sort(key=lambda pair: pair[1].condition)
        mass = masses_kg.get(experiment, {}).get(participant)
        trials_parts = [parts_of(row, sources.get(row.key)) for _, row in rows]
        parts = mean_parts(trials_parts) if all(trials_parts) else {}
        numbers = _mean_of_trials([row for _, row in rows], parts)
        trials = sum(member.trials for member, _ in rows)
        flags = _joined(row.flags for _, row in rows)
        person = PersonEstimate(
            experiment, participant, label, *what, *numbers, trials, mass, flags, belt, parts
        )
        people.append(person)
        if mass is not None and person.quantity in PER_KG:
            people.append(_per_kg(person, mass))
    tasks = {(m.experiment, m.label) for m in members if m.is_task}
    return sorted(people + _differences(people, tasks), key=_order)


def _mean_of_trials(
    rows: list[Estimate], parts: Mapping[str, float]
) -> tuple[float, float | None, float | None, float | None]:
    """Value, standard error and interval of one trial, or of the mean of several, by its parts."""
    if len(rows) == 1:
        (row,) = rows
        return row.value, *map(_finite, (row.standard_error, row.ci_low, row.ci_high))
    value = float(np.mean([row.value for row in rows]))
    error = math.hypot(*parts.values())
    if not parts or not math.isfinite(error):
        return value, None, None, None
    return _normal(value, error)


def _normal(value: float, error: float) -> tuple[float, float, float, float]:
    return value, error, value - NORMAL_95 * error, value + NORMAL_95 * error


def _joined(flags: Iterable[str]) -> str:
    return ";".join(dict.fromkeys(flag for several in flags for flag in several.split(";") if flag))


def _finite(x: float | None) -> float | None:
    return x if x is not None and math.isfinite(x) else None


def _per_kg(person: PersonEstimate, mass_kg: float) -> PersonEstimate:
    numbers = {
        name: None if getattr(person, name) is None else getattr(person, name) / mass_kg
        for name in ("value", "standard_error", "ci_low", "ci_high")
    }
    parts = {name: u / mass_kg for name, u in person.parts.items()}
    unit = f"{person.unit}/kg"
    return replace(person, quantity=f"{person.quantity}_per_kg", unit=unit, parts=parts, **numbers)


def _differences(people: list[PersonEstimate], tasks: set[tuple[str, str]]) -> list[PersonEstimate]:
    """Differences between the tasks of each person: of two tasks the later name minus the earlier."""
    found: dict[tuple, dict[str, PersonEstimate]] = {}
    for p in people:
        if (p.experiment, p.condition) in tasks:
            key = (p.experiment, p.belt, p.participant, p.pathway, p.estimator, p.quantity)
            found.setdefault(key, {})[p.condition] = p
    rows = []
    for by_task in found.values():
        for first, second in combinations(sorted(by_task), 2):
            a, b = by_task[first], by_task[second]
            numbers: tuple = (b.value - a.value, None, None, None)
            parts = difference_parts(a.parts, b.parts) if a.parts and b.parts else {}
            error = math.hypot(*parts.values())
            if parts and math.isfinite(error):
                numbers = _normal(b.value - a.value, error)
            named: dict = dict(zip(("value", "standard_error", "ci_low", "ci_high"), numbers, strict=True))
            named |= {"n_trials": a.n_trials + b.n_trials, "flags": _joined((a.flags, b.flags))}
            named |= {"parts": parts}
            rows.append(replace(b, condition=f"{second} minus {first}", **named))
    return rows


def _order(row: PersonEstimate) -> tuple:
    about = (row.experiment, " minus " in row.condition, row.condition, row.belt)
    return (*about, row.pathway, row.estimator, row.quantity, row.participant)


def group_estimates(people: list[PersonEstimate]) -> list[GroupEstimate]:
    """Mean of every quantity over people (units in the rows), in the order of `person_estimates`.

    Flagged values are left out of the mean and counted.
    """
    found: dict[tuple, list[PersonEstimate]] = {}
    for p in people:
        key = (p.experiment, p.condition, p.belt, p.pathway, p.estimator, p.quantity, p.unit)
        found.setdefault(key, []).append(p)
    rows = []
    for (experiment, condition, belt, *what), group in found.items():
        sound = [p for p in group if not p.flags]
        numbers: tuple = (0, *[None] * 6)
        if sound:
            mean = group_mean(np.array([p.value for p in sound]))
            known = [p.standard_error for p in sound if p.standard_error is not None]
            within = typical_uncertainty(np.array(known)) if len(known) == len(sound) else None
            numbers = (mean.n, mean.mean, mean.sd, mean.sem, mean.low, mean.high, within)
        numbers += (len(group) - len(sound),)
        rows.append(GroupEstimate(experiment, condition, *what, *numbers, belt))
    return rows
