"""Coverage study: how many trials each check flags, one by one and all together."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from tepsipe.io.tables import Table
from tepsipe.reporting.coverage import SHIFTED, Outcome
from tepsipe.statistics.coverage import share_of

ANY = "any"  # all checks together


@dataclass(frozen=True)
class FlagRow:
    """One row of ``flags.csv``: trials whose recommended estimates have a flag."""

    experiment: str
    """As in the estimates; tasks count as trials of the standing person."""
    flag: str
    """Name of the check; `ANY` for all together."""
    mechanism: str
    """Set of the laboratories; `SHIFTED` for all sets but the first."""
    trials: int
    flagged: int
    """Trials with a recommended estimate, and those of which at least one has the flag."""
    percent: Annotated[float, "%"]
    low: Annotated[float, "%"]
    high: Annotated[float, "%"]
    """Their share with its 95 % interval, laboratories as clusters."""


FLAG_ROWS = Table(FlagRow, "flags of recommended estimates")


def flag_rows(outcomes: Sequence[Outcome], sets: Sequence[str]) -> list[FlagRow]:
    """Flags of recommended estimates, trial by trial.

    sets: names of the sets; the first is the nominal one.
    Returns: experiment by experiment, set by set: all checks together, then each that was failed (units in
    it).
    """
    trials: dict[str, dict[tuple, set[str]]] = {}
    names: dict[int, str] = {}
    for o in outcomes:
        if o.estimate.recommended:
            names[o.laboratory.number] = o.laboratory.set
            own = trials.setdefault(o.estimate.experiment, {})
            found = own.setdefault((o.laboratory.number, o.estimate.condition), set())
            found |= set(filter(None, o.estimate.flags.split(";")))
    rows = []
    for experiment, own in trials.items():
        for mechanism in (*sets, SHIFTED):
            chosen = {key: flags for key, flags in own.items() if _is_of(names[key[0]], mechanism, sets)}
            if not chosen:
                continue
            for flag in (ANY, *sorted({flag for flags in chosen.values() for flag in flags})):
                rows.append(_row(experiment, flag, mechanism, chosen))
    return rows


def _is_of(name: str, mechanism: str, sets: Sequence[str]) -> bool:
    return name != sets[0] if mechanism == SHIFTED else name == mechanism


def _row(experiment: str, flag: str, mechanism: str, chosen: dict[tuple, set[str]]) -> FlagRow:
    held = [bool(flags) if flag == ANY else flag in flags for flags in chosen.values()]
    share = share_of(held, [laboratory for laboratory, _ in chosen])
    ends = (100.0 * share.low, 100.0 * share.high)
    return FlagRow(experiment, flag, mechanism, share.n, share.held, 100.0 * share.value, *ends)
