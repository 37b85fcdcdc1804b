"""Tasks of a standing person, whose trials are also analysed together."""

from dataclasses import dataclass
from itertools import permutations

from tepsipe.errors import InputError
from tepsipe.experiments.registry import EXPERIMENTS
from tepsipe.io.names import check_distinct, check_name
from workflow.support.lookups.sheet import Sheet, last_unless
from workflow.support.lookups.treadmill import Treadmill


@dataclass(frozen=True)
class Pool:
    """Trials of a standing person that are also analysed together: those of one task.

    Where the sheet names participants or belts, those of one participant and on one belt; otherwise
    ``participant`` and ``belt`` are None, and the pool has the name of the task.
    """

    name: str
    participant: str | None
    belt: str | None
    task: str
    conditions: tuple[str, ...]


class Tasks:
    """Tasks of a study. ``example`` is the trial whose participant and belt the figures show."""

    def __init__(self, sheet: Sheet, treadmill: Treadmill, example: str) -> None:
        self.sheet, self.treadmill, self.example = sheet, treadmill, example

    def pools(self) -> dict[str, Pool]:
        """Name -> trials that are also analysed together."""
        return {pool.name: pool for pool in self._pools()}

    def names(self) -> list[str]:
        """Names of the pools: tasks of the person, in the order of the trial sheet."""
        return list(self.pools())

    def pairs(self) -> dict[str, tuple[str, str]]:
        """Name, for example stiff-relax, -> pools of two tasks of one person, the later first.

        Tasks of your own come after those of the simulated person, by name.
        """
        known = EXPERIMENTS["standing"].tasks

        def place(task: str) -> tuple[int, str]:
            return (known.index(task), "") if task in known else (len(known), task)

        found = {}
        for less, more in permutations(self._pools(), 2):
            alike = (more.participant, more.belt) == (less.participant, less.belt)
            if alike and place(more.task) > place(less.task):
                found[f"{more.name}-{less.task}"] = (more.name, less.name)
        return found

    def by_condition(self) -> dict[str, str]:
        """Condition -> name of its pool, in the order of the trial sheet."""
        found = {c: pool.name for pool in self._pools() for c in pool.conditions}
        return {c: found[c] for c in self.sheet.conditions("standing")}

    def of_trials(self, pattern: str, task: str) -> list[str]:
        """The pattern filled in for every condition of a pool."""
        return [pattern.format(condition=c) for c in self.pools()[task].conditions]

    def of_other_tasks(self, pattern: str, task: str) -> list[str]:
        """The pattern filled in for every condition of the same participant in other pools."""
        own = self.pools()[task]
        return [
            pattern.format(condition=c)
            for pool in self._pools()
            if pool.participant == own.participant and pool.name != task
            for c in pool.conditions
        ]

    def shown(self, participant: str | None = None) -> dict[str, Pool]:
        """Pools of a participant's figures; without one, of the participant and belt of the example trial."""
        pools = self.pools()
        if participant is not None or not pools:
            return {name: pool for name, pool in pools.items() if pool.participant == participant}
        example = last_unless(self.example, self.sheet.conditions("standing"))
        own = pools[self.by_condition()[example]]
        return {n: p for n, p in pools.items() if (p.participant, p.belt) == (own.participant, own.belt)}

    def shown_trials(self, participant: str | None = None) -> dict[str, str]:
        """Condition -> pool of the trials of these figures, in the order of the sheet."""
        shown = self.shown(participant)
        return {condition: pool for condition, pool in self.by_condition().items() if pool in shown}

    def groups(self, participant: str | None = None) -> dict[str, list[str]]:
        """Conditions of these figures by task and profile, for example relax, negative-sine."""
        groups: dict[str, list[str]] = {}
        for condition, pool in self.shown_trials(participant).items():
            profile = self.sheet.trials["standing", condition].profile
            groups.setdefault(pool if profile == "-" else f"{pool}, {profile}", []).append(condition)
        return groups

    def check(self, path: str) -> None:
        """Refuse equal names of tasks of two people or belts, which must not be analysed together."""
        seen: dict[str, Pool] = {}
        for pool in self._pools():
            if pool.name in seen or ("standing", pool.name) in self.sheet.trials:
                what = "a condition" if pool.name not in seen else f"the task {seen[pool.name].task}"
                raise InputError(
                    f"{path}: expected a participant, a belt and a task whose joint name is no other one's, "
                    f"found {pool.name!r} for the task {pool.task} and for {what}: rename one of the two"
                )
            seen[pool.name] = pool
            check_name(pool.name, "name of participant, belt and task together", path)
        check_distinct(seen, "name of participant, belt and task together", path)

    def _pools(self) -> list[Pool]:
        groups: dict[tuple, list[str]] = {}
        for condition in self.sheet.conditions("standing"):
            row = self.sheet.trials["standing", condition]
            belt = self.treadmill.belt_of("standing", condition) if self.sheet.by_belt else None
            groups.setdefault((row.participant, belt, row.task), []).append(condition)
        named = [
            Pool("-".join(filter(None, key)), *key, tuple(conditions)) for key, conditions in groups.items()
        ]
        if not (self.sheet.by_belt or self.sheet.participants("standing")):
            return named
        # another order of the rows must not change a result
        named = [Pool(p.name, p.participant, p.belt, p.task, tuple(sorted(p.conditions))) for p in named]
        return sorted(named, key=lambda pool: (pool.participant or "", pool.task, pool.belt or ""))
