"""Tidy rows of estimates, the common format of all experiments, of their budgets, and beside the truth.

They are written to ``estimates.csv``, ``uncertainty.csv`` and ``recovery.csv`` in ``results/tables``.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from tepsipe.flags import FLAGS
from tepsipe.io.tables import Table, Undefinable

UNCERTAINTIES = ("standard_error", "ci_low", "ci_high", "sem_as_printed", "u_type_a", "u_type_b")
# quantities of which one estimate per trial is recommended
QUOTED = ("I", "B", "K", "mass")
# a VAF below this belongs to a diverging prediction (%)
DIVERGED_VAF = -1e6
# movements for which a true value holds
SMALL, AT_WORK = "small movements", "the fitted windows"
# quantity of a reflex whose value is searched -> its name, and factor and unit in which it is told
SEARCHED = (("reflex_delay", "delay", 1e3, "ms"), ("reflex_threshold", "threshold", 1.0, "rad/s"))
SHORTEST_REFLEX_S = 0.03
TYPES = ("A", "B")


@dataclass(frozen=True)
class Estimated:
    """The first columns of every row about an estimate."""

    experiment: str
    condition: str
    pathway: str
    estimator: str
    """Method of computing the torque, and of estimating the parameters."""
    quantity: str
    unit: str
    """For example I in Nms2/rad, or VAF_trial in %."""

    @property
    def fit(self) -> tuple[str, str, str, str]:
        """Experiment, condition, pathway and estimator."""
        return self.experiment, self.condition, self.pathway, self.estimator

    @property
    def key(self) -> tuple[str, str, str, str, str]:
        """The names of the fit, and the quantity."""
        return *self.fit, self.quantity


@dataclass(frozen=True)
class Estimate(Estimated):
    """One estimated quantity."""

    value: Undefinable
    """The estimate (``unit``)."""
    standard_error: float | None = None
    ci_low: float | None = None
    ci_high: float | None = None
    """Combined standard uncertainty and 95 % interval (``unit``); None where there is none."""
    sem_as_printed: float | None = None
    """Thesis eq (3-2) as printed; None where there is none."""
    n_perturbations: int | None = None
    """Number of perturbations behind the value."""
    u_type_a: float | None = None
    u_type_b: float | None = None
    """Standard uncertainties from the trial's own scatter and from everything else (``unit``); None where
    they were not evaluated. Their root sum of squares is ``standard_error``."""
    recommended: bool = False
    """Whether this is the estimate of its quantity to quote."""
    flags: str = ""
    """Names of the checks in `FLAGS` that the estimate failed, joined by ``;``."""


def meaning_of(flag: str, estimates: Iterable[Estimate]) -> str:
    """Meaning of a flag and what to do, with the values that the flagged estimates have.

    estimates: rows of one trial, pathway and estimator.
    """
    own, told = {e.quantity: e for e in estimates}, []
    for quantity, name, scale, unit in SEARCHED if flag == "reflex-outside-search" else ():
        used, low, high = (own.get(quantity + end) for end in ("", "_low", "_high"))
        if used and low and high and flag in used.flags.split(";"):
            ends = list(dict.fromkeys(f"{scale * end.value:.3g}" for end in (low, high)))
            one = len(ends) == 1
            short = quantity == "reflex_delay" and high.value < SHORTEST_REFLEX_S
            place = (
                f"which {'is' if one else 'are'} too short for a reflex" if short else "outside the search"
            )
            told.append(
                f"{'a ' * one}reflex {name}{'s' * (not one)} of {' to '.join(ends)} {unit}, {place}, "
                f"predict{'s' * one} the torque at least as well as the {scale * used.value:.3g} {unit} used"
            )
    meaning = FLAGS.get(flag, flag)
    return f"{' and '.join(told)}. {meaning.partition('. ')[2]}" if told else meaning


def flagged(estimates: Iterable[Estimate], *flags: str) -> list[Estimate]:
    """Estimates with further flags, names in `FLAGS`; none is repeated."""
    return [
        replace(e, flags=";".join(dict.fromkeys([*filter(None, e.flags.split(";")), *flags])))
        for e in estimates
    ]


def recommended(estimates: Iterable[Estimate], pathway: str, estimator: str | None = None) -> list[Estimate]:
    """Mark the estimates to quote.

    estimates: rows of one or more trials, the same quantity once per trial, pathway and estimator.
    estimator: the recommended estimator; any of the pathway if left out.
    Returns: rows of this pathway and estimator with a quantity of `QUOTED` are marked, and no others. Where
    B or K is negative none of its trial, pathway and estimator is; they are flagged ``negative`` instead.
    """
    rows = list(estimates)
    impossible = {e.fit for e in rows if e.quantity in ("B", "K") and e.value < 0.0}
    marked = []
    for e in rows:
        chosen = e.quantity in QUOTED and e.pathway == pathway and estimator in (None, e.estimator)
        if chosen and e.fit in impossible:
            marked += flagged([replace(e, recommended=False)], "negative")
        else:
            marked.append(replace(e, recommended=chosen))
    return marked


def _flagged_where_undefined(estimate: Estimate) -> Estimate:
    """The estimate with the flags that its numbers require, None for an uncertainty that is NaN.

    A value that is not finite gets the flag ``undefined``, unless the quantity is ``not-identified``. An
    uncertainty that is not a number gets ``no-interval``, and the VAF of a diverging prediction ``diverged``.
    A standard error of a row without Type A and B is of Type A.
    """
    if estimate.standard_error is not None and estimate.u_type_a is None and estimate.u_type_b is None:
        estimate = replace(estimate, u_type_a=estimate.standard_error)
    lost = [name for name in UNCERTAINTIES if (x := getattr(estimate, name)) is not None and math.isnan(x)]
    undefined = not math.isfinite(estimate.value)
    refused = "not-identified" in estimate.flags.split(";")
    flags = ["undefined"] * (undefined and not refused) + ["no-interval"] * bool(lost)
    if not undefined and estimate.quantity.startswith("VAF") and estimate.value < DIVERGED_VAF:
        flags.append("diverged")
    return flagged([replace(estimate, **dict.fromkeys(lost))], *flags)[0] if flags else estimate


def _check(estimate: Estimate) -> None:
    flags = [flag for flag in estimate.flags.split(";") if flag]
    if math.isnan(estimate.value) and not {"undefined", "not-identified"} & set(flags):
        raise ValueError("a row without a value and without the flag 'undefined' or 'not-identified'")
    unknown = [flag for flag in flags if flag not in FLAGS]
    if unknown:
        raise ValueError(f"the unknown flag {unknown[0]!r}")
    if (estimate.n_perturbations or 0) < 0:
        raise ValueError(f"a value of {estimate.n_perturbations} perturbations")


# participant and belt may follow, without being read
ESTIMATES = Table(
    Estimate, "estimates", check=_check, complete=_flagged_where_undefined, further=("participant", "belt")
)


@dataclass(frozen=True)
class Contribution(Estimated):
    """Contribution of one source to the uncertainty of one estimate."""

    source: str
    """Name of the source, with its own unit; `SCATTER` for Type A."""
    type: str
    """{"A", "B"}: Whether it is seen in the scatter of the trial, or known otherwise."""
    u: float
    """Standard uncertainty that it contributes to the estimate (``unit``), never negative."""


def _check_contribution(row: Contribution) -> None:
    if row.type not in TYPES or not row.u >= 0.0:
        raise ValueError(f"{row.u:g} of type {row.type!r}")


CONTRIBUTIONS = Table(Contribution, "uncertainty budgets", check=_check_contribution)


@dataclass(frozen=True)
class Recovery(Estimated):
    """One estimate and its true value; the fields are the columns of ``tables/recovery.csv``."""

    truth: float
    """The laboratory's constant, or the value of the nearest linear joint (``unit``)."""
    value: Undefinable
    """The estimate (``unit``)."""
    relative_error: float | None
    """(value - truth) / truth; None where it is not finite."""
    covered: bool | None
    """True if the 95 % interval contains the truth; None without an interval."""
    truth_of: str
    """Movements for which the truth holds."""
    recommended: bool = False
    """True if the study recommends the estimate."""
    flags: str = ""
    """Names of the checks that the trial failed for it, joined by ";"."""


RECOVERIES = Table(Recovery, "estimates beside the truth")
