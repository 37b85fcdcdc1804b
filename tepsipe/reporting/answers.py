"""Answers of a study: the estimates to quote and those beside them, each with a verdict and its reasons.

The answer to a quantity of a trial (of a standing person: of a task) is its recommended estimate. Without
one, the answer is the estimate by the usual pathway and estimator of the study, which is not to be quoted.
Estimates of the same quantity are compared with it: those by other estimators of its pathway, and those by
other pathways that have one estimator. The rows are written to ``answers.csv`` in ``results/tables``.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from tepsipe.flags import COMPARED as PATHWAYS
from tepsipe.io.estimates import Estimate, Estimated, meaning_of
from tepsipe.io.tables import Table, Undefinable

QUOTABLE, CHECK, REFUSED, COMPARED = "quotable", "check first", "not quotable", "for comparison"
# quantities that a trial or task should have an answer to; of several joints, those of a joint's own angle
ASKED = ("I", "B", "K", "mass", "K_ankle_ankle", "B_ankle_ankle", "K_hip_hip", "B_hip_hip")


@dataclass(frozen=True)
class Answer(Estimated):
    """One estimate of an answered quantity."""

    value: Undefinable
    ci_low: float | None
    ci_high: float | None
    """The estimate and its 95 % interval (``unit``)."""
    verdict: str
    """`QUOTABLE`: recommended, and no check failed. `CHECK`: recommended, but a check failed. `REFUSED`: not
    recommended, and no other estimate is. `COMPARED`: by another pathway or estimator than the answer."""
    reasons: str
    """Meaning of every failed check, then why a pathway is shown for comparison only, joined by ``; ``."""
    to_do: str
    """What to do about every failed check, sentences."""
    flags: str
    """Names of the failed checks, joined by ``;``."""


ANSWERS = Table(Answer, "answers", further=("participant", "belt"))


def answers(estimates: Iterable[Estimate], asked: Mapping[str, Mapping[str, Sequence]]) -> list[Answer]:
    """Answers and the estimates compared with them, in the order of the estimates.

    asked: experiment -> ``conditions`` (trials or tasks with answers) and ``ways`` (pathway and estimator of
    the answers without a recommended estimate, the first that the trial has).
    """
    trials: dict[tuple[str, str], list[Estimate]] = {}
    for e in estimates:
        if e.condition in asked.get(e.experiment, {}).get("conditions", ()):
            trials.setdefault((e.experiment, e.condition), []).append(e)
    return [
        row
        for (experiment, _), own in trials.items()
        for row in _of_trial(own, [tuple(way) for way in asked[experiment]["ways"]])
    ]


def _of_trial(estimates: Sequence[Estimate], ways: Sequence[tuple[str, str]]) -> list[Answer]:
    """Answers of one trial, each followed by what it is compared with."""
    chosen = {e.quantity: e for e in estimates if e.recommended}
    ways = list(dict.fromkeys([*map(_way, chosen.values()), *ways]))
    for way in ways:
        if any(_way(e) == way for e in estimates):
            own = (e for e in estimates if _way(e) == way and e.quantity in ASKED)
            chosen = {e.quantity: e for e in own} | chosen
            break
    estimators: dict[str, set[str]] = {}
    for e in estimates:
        estimators.setdefault(e.pathway, set()).add(e.estimator)
    rows = []
    for answer in (e for e in estimates if chosen.get(e.quantity) is e):
        verdict = (CHECK if answer.flags else QUOTABLE) if answer.recommended else REFUSED
        rows.append(_answer(answer, verdict, estimates))
        for e in estimates:
            alike = e.pathway == answer.pathway or len(estimators[e.pathway]) == 1
            if e is not answer and e.quantity == answer.quantity and alike:
                rows.append(_answer(e, COMPARED, estimates))
    return rows


def _way(estimate: Estimate) -> tuple[str, str]:
    return estimate.pathway, estimate.estimator


def _answer(e: Estimate, verdict: str, estimates: Sequence[Estimate]) -> Answer:
    """The row of an estimate; the text of a check is what it found, then what to do about it."""
    own = [other for other in estimates if _way(other) == _way(e)]
    texts = [meaning_of(flag, own).partition(". ") for flag in e.flags.split(";") if flag]
    compared = [PATHWAYS[e.pathway]] if verdict == COMPARED and e.pathway in PATHWAYS else []
    reasons = "; ".join([*(found for found, _, _ in texts), *compared])
    to_do = " ".join(f"{advice}." for _, _, advice in texts)
    return Answer(*e.key, e.unit, e.value, e.ci_low, e.ci_high, verdict, reasons, to_do, e.flags)
