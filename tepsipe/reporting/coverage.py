"""Coverage study: what many drawn laboratories say about the intervals of every estimator.

Each laboratory is a study of its own, whose tables hold estimates, budgets and the truth. Here they become
one table: per estimator and quantity how many intervals hold the truth, the bias, the width, and the flags;
the same with one source at a time taken out of the budgets, which needs no further run; and how many trials
each check flags, one by one and all together.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.io.estimates import QUOTED, Contribution, Estimate, Recovery
from tepsipe.io.tables import Table
from tepsipe.statistics.coverage import CONFIDENCE, Share, share_of

SHIFTED = "shifted"  # all laboratories that are not of the first set, together
LEAST_FOR_QUANTILE = 20  # estimates, for the 95 % quantile of their errors
NORMAL_FACTOR = 1.9605  # a coverage factor up to this one belongs to infinite degrees of freedom


@dataclass(frozen=True)
class Laboratory:
    """One drawn laboratory."""

    number: int
    """From 1."""
    set: str
    """What it was drawn from."""
    seed: int
    """Of all its random numbers."""
    failed: str = ""
    """Why there is no result, in one sentence; empty if there is one (no unit)."""


LABORATORIES = Table(Laboratory, "drawn laboratories")


@dataclass(frozen=True)
class Outcome:
    """One estimate of one laboratory, and its true value."""

    laboratory: Laboratory
    """Where it comes from."""
    estimate: Estimate
    """Value, interval, flags (its ``unit``)."""
    truth: float
    """The true value (same unit)."""
    sources: Mapping[str, float] = field(default_factory=dict)
    """Source of Type B -> standard uncertainty that it contributes (same unit)."""

    @property
    def interval(self) -> tuple[float, float] | None:
        """Ends of the 95 % interval (unit of the estimate); None if it has none, or no value."""
        e = self.estimate
        if e.ci_low is None or e.ci_high is None or not math.isfinite(e.value):
            return None
        return e.ci_low, e.ci_high

    @property
    def flagged(self) -> bool:
        """Whether it failed a check (no unit)."""
        return bool(self.estimate.flags)

    def relative(self, value: float) -> float:
        """A number (unit of the estimate) in percent of the truth (%); not a number where that is 0."""
        return 100.0 * value / abs(self.truth) if self.truth else math.nan


@dataclass(frozen=True)
class CoverageRow:
    """One row of ``coverage.csv``."""

    experiment: str
    pathway: str
    estimator: str
    quantity: str
    """As in the estimates."""
    window_s: float | None
    """Window of the estimator (s); None if the perturbation or the whole trial is its window."""
    mechanism: str
    """Set of the laboratories; `SHIFTED` for all sets but the first."""
    n: int
    n_covered: int
    """Estimates with an interval, and those whose interval holds the truth."""
    coverage: float | None
    """n_covered / n."""
    bias_percent: float | None
    """Mean error (% of the truth)."""
    median_width_percent: float | None
    """Median width of the interval (% of the truth)."""
    flagged_percent: float
    """Estimates with a flag (% of all)."""
    false_alarm_percent: float
    """Estimates with a flag although their interval holds the truth (% of all)."""
    recommended: bool
    """Whether these are the estimates to quote, or are evaluated like them (no unit)."""
    laboratories: int
    coverage_low: float | None
    coverage_high: float | None
    """95 % interval of the coverage, laboratories as clusters."""
    withdrawn: int
    """Estimates without a value or without an interval."""
    held_percent: float
    """Estimates that are covered, flagged or withdrawn (% of all)."""
    width_ratio: float | None
    """Median width over that of the interval about the truth that holds 95 % of the errors (-): 1 is the
    narrowest that knowledge of the distribution of errors allows."""


COVERAGE_ROWS = Table(CoverageRow, "coverage of intervals")


@dataclass(frozen=True)
class DroppedRow:
    """One row of ``dropped.csv``: recommended estimates, with one source taken out of their budgets."""

    experiment: str
    pathway: str
    estimator: str
    quantity: str
    """As in the estimates."""
    mechanism: str
    """As in `CoverageRow`."""
    source: str
    share_percent: float
    """Median share of the source in the variance."""
    n: int
    n_covered: int
    """Estimates with the source in their budgets, and those covered without it."""
    coverage: float
    coverage_low: float
    coverage_high: float
    """Share with its 95 % interval, laboratories as clusters."""
    held_percent: float
    """Estimates that are covered or flagged."""


DROPPED_ROWS = Table(DroppedRow, "coverage without one source")


@dataclass(frozen=True)
class OutcomeRow:
    """One row of ``outcomes.csv``: an estimate beside its true value."""

    laboratory: int
    """Its number."""
    mechanism: str
    """Its set."""
    experiment: str
    condition: str
    pathway: str
    estimator: str
    quantity: str
    unit: str
    """As in the estimates."""
    truth: float
    value: float | None
    ci_low: float | None
    ci_high: float | None
    u_type_a: float | None
    u_type_b: float | None
    """True value, estimate, interval and uncertainties (``unit``)."""
    recommended: bool
    """Whether it is the one to quote (no unit)."""
    flags: str
    """Checks that it failed (no unit)."""


OUTCOME_ROWS = Table(OutcomeRow, "estimates of drawn laboratories")


def outcome_row(outcome: Outcome) -> OutcomeRow:
    """An outcome as a row of ``outcomes.csv`` (units in its column ``unit``)."""
    e, laboratory = outcome.estimate, outcome.laboratory
    return OutcomeRow(
        laboratory=laboratory.number,
        mechanism=laboratory.set,
        truth=outcome.truth,
        value=e.value if math.isfinite(e.value) else None,
        **{
            name: getattr(e, name)
            for name in (
                *("experiment", "condition", "pathway", "estimator", "quantity", "unit"),
                *("ci_low", "ci_high", "u_type_a", "u_type_b", "recommended", "flags"),
            )
        },
    )


def outcomes_of(
    laboratory: Laboratory,
    estimates: Sequence[Estimate],
    truths: Iterable[Recovery],
    budgets: Iterable[Contribution],
    pooled: Sequence[str] = (),
    also_evaluated: Iterable[Sequence[str]] = (),
) -> list[Outcome]:
    """Estimates of one laboratory that have a true value.

    pooled: conditions that hold several trials of the standing person; single trials of them do not count.
    also_evaluated: experiment, pathway and estimator whose I, B, K and mass are evaluated as if they were
    recommended.
    Returns: in the order of the estimates (units in them).
    """
    sources: dict[tuple, dict[str, float]] = {}
    for row in budgets:
        if row.type == "B":
            sources.setdefault(row.key, {})[row.source] = row.u
    like_recommended = {tuple(names) for names in also_evaluated}
    true = {row.key: row.truth for row in truths}
    return [
        Outcome(laboratory, _as_evaluated(e, like_recommended), true[e.key], sources.get(e.key, {}))
        for e in estimates
        if e.key in true and (e.experiment != "standing" or not pooled or e.condition in pooled)
    ]


def _as_evaluated(estimate: Estimate, like_recommended: set[tuple]) -> Estimate:
    names = (estimate.experiment, estimate.pathway, estimate.estimator)
    if names in like_recommended and estimate.quantity in QUOTED:
        return replace(estimate, recommended=True)
    return estimate


def covered(outcome: Outcome) -> bool:
    """Whether the interval holds the truth (no unit); an estimate without one is not covered."""
    ends = outcome.interval
    return ends is not None and ends[0] <= outcome.truth <= ends[1]


def coverage_rows(
    outcomes: Sequence[Outcome], sets: Sequence[str], windows_s: Mapping[str, Mapping[str, float | None]]
) -> list[CoverageRow]:
    """The table of the coverage.

    sets: names of the sets; the first is the nominal one.
    windows_s: experiment -> name of a pathway or estimator -> window (s), where there is one.
    Returns: recommended estimates first, then in the order of the estimates; for each, set by set, then all
    sets but the first together. Estimators without any interval are left out.
    """
    rows = []
    for key, own in _groups(outcomes).items():
        experiment, pathway, estimator, quantity, recommended = key
        if not any(o.interval for o in own):
            continue
        named = windows_s.get(experiment, {})
        window = named.get(pathway, named.get(estimator))
        for mechanism, chosen in _by_set(own, sets).items():
            names = (experiment, pathway, estimator, quantity, window, mechanism)
            rows.append(_coverage_row(names, recommended, chosen))
    return sorted(rows, key=lambda row: not row.recommended)


def _groups(outcomes: Sequence[Outcome]) -> dict[tuple, list[Outcome]]:
    found: dict[tuple, list[Outcome]] = {}
    for o in outcomes:
        e = o.estimate
        key = (e.experiment, e.pathway, e.estimator, e.quantity, e.recommended)
        found.setdefault(key, []).append(o)
    return found


def _by_set(own: Sequence[Outcome], names: Sequence[str]) -> dict[str, list[Outcome]]:
    """Set -> its outcomes; then those of all sets but the first."""
    found = {name: [o for o in own if o.laboratory.set == name] for name in names}
    if len(names) > 1:
        found[SHIFTED] = [o for o in own if o.laboratory.set != names[0]]
    return {name: chosen for name, chosen in found.items() if chosen}


def _coverage_row(names: tuple, recommended: bool, own: Sequence[Outcome]) -> CoverageRow:
    told = [o for o in own if o.interval]
    share = _share(told, covered)
    errors = _finite(o.relative(o.estimate.value - o.truth) for o in told)
    widths = _finite(o.relative(o.interval[1] - o.interval[0]) for o in told if o.interval)
    width = float(np.median(widths)) if len(widths) else None
    ratio = None
    if width is not None and len(errors) >= LEAST_FOR_QUANTILE:
        narrowest = 2.0 * float(np.quantile(np.abs(errors), CONFIDENCE))
        ratio = width / narrowest if narrowest > 0.0 else None
    return CoverageRow(
        *names,
        n=share.n,
        n_covered=share.held,
        coverage=share.value if share.n else None,
        bias_percent=float(np.mean(errors)) if len(errors) else None,
        median_width_percent=width,
        flagged_percent=_percent(own, lambda o: o.flagged),
        false_alarm_percent=_percent(own, lambda o: o.flagged and covered(o)),
        recommended=recommended,
        laboratories=len({o.laboratory.number for o in own}),
        coverage_low=share.low if share.n else None,
        coverage_high=share.high if share.n else None,
        withdrawn=len(own) - len(told),
        held_percent=_percent(own, lambda o: o.flagged or not o.interval or covered(o)),
        width_ratio=ratio,
    )


def _share(outcomes: Sequence[Outcome], counts: Callable[[Outcome], bool]) -> Share:
    return share_of([counts(o) for o in outcomes], [o.laboratory.number for o in outcomes])


def _percent(outcomes: Sequence[Outcome], counts: Callable[[Outcome], bool]) -> float:
    return 100.0 * sum(map(counts, outcomes)) / len(outcomes)


def _finite(values: Iterable[float]) -> np.ndarray:
    found = np.array(list(values), dtype=float)
    return found[np.isfinite(found)]


def interval_without(outcome: Outcome, source: str) -> tuple[float, float] | None:
    """The interval with one source of Type B taken out of the budget.

    outcome: the estimate with its budget (units in it).
    source: the source; its own uncertainty is taken to have infinite degrees of freedom.
    Returns: unit of the estimate; None where there is no interval. Each end moves with t u_c. Degrees of
    freedom that Type A brings shrink as u_c^4 (Welch and Satterthwaite); those of other sources stay.
    """
    ends, e = outcome.interval, outcome.estimate
    if ends is None or not e.standard_error or not math.isfinite(ends[1] - ends[0]):
        return ends
    u = e.standard_error
    left = math.sqrt(max(u**2 - outcome.sources.get(source, 0.0) ** 2, 0.0))
    factor = 0.5 * (ends[1] - ends[0]) / u
    scale = left / u
    if factor > NORMAL_FACTOR and left > 0.0:
        tail = 0.5 * (1.0 + CONFIDENCE)
        freedom = float(scipy.special.stdtridf(tail, factor))
        if freedom * ((e.u_type_a or 0.0) / u) ** 4 >= 1.0:
            scale *= float(scipy.special.stdtrit(max(freedom * scale**4, 1.0), tail)) / factor
    return e.value - scale * (e.value - ends[0]), e.value + scale * (ends[1] - e.value)


def dropped_rows(outcomes: Sequence[Outcome], sets: Sequence[str]) -> list[DroppedRow]:
    """Coverage of the recommended estimates with one source at a time taken out of their budgets.

    ``outcomes`` are those of all laboratories (units in them), ``sets`` their sets, the nominal one
    first; rows in the order of the outcomes, source by source.
    """
    rows = []
    for key, own in _groups(outcomes).items():
        if not key[-1]:
            continue
        for mechanism, chosen in _by_set(own, sets).items():
            for source in dict.fromkeys(name for o in chosen for name in o.sources):
                told = [o for o in chosen if source in o.sources and o.interval]
                if told:
                    rows.append(_dropped_row(key[:-1], mechanism, source, told))
    return rows


def _dropped_row(names: tuple, mechanism: str, source: str, told: Sequence[Outcome]) -> DroppedRow:
    def still(o: Outcome) -> bool:
        ends = interval_without(o, source)
        return ends is not None and ends[0] <= o.truth <= ends[1]

    share = _share(told, still)
    parts = [(o.sources[source] / o.estimate.standard_error) ** 2 for o in told if o.estimate.standard_error]
    return DroppedRow(
        *names,
        mechanism=mechanism,
        source=source,
        share_percent=100.0 * float(np.median(parts)) if parts else 0.0,
        n=share.n,
        n_covered=share.held,
        coverage=share.value,
        coverage_low=share.low,
        coverage_high=share.high,
        held_percent=_percent(told, lambda o: o.flagged or still(o)),
    )


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
