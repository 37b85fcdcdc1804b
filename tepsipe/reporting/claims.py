"""Claims of the thesis that can be tested, with the findings of this run (thesis chapter 4)."""

import difflib
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.forward.scores import ForwardScore
from tepsipe.experiments.weight.analysis import shapes, speed_at_peak, usual_weight
from tepsipe.experiments.wristalyzer.names import MODULUS
from tepsipe.io.tables import Table
from tepsipe.reporting import further_measures
from tepsipe.reporting.findings import Findings
from tepsipe.reporting.ledger import (
    EXPLAINED,
    FITTED,
    IMPLIED,
    NOT_COMPUTED,
    NOT_REPRODUCED,
    PREDICTED,
    basis_of,
    null_verdict_of,
)


def _mean(values: dict) -> float:
    return float(np.mean(list(values.values())))


def _at(values: dict, *amplitudes: str) -> list[float]:
    """Values of the conditions with one of the amplitudes (m/s), every 4 s."""
    return [v for name, v in values.items() if name.split("-", 1)[-1] in amplitudes]


def _ratio(values: dict) -> float:
    return float(np.mean(_at(values, "0.5")) / np.mean(_at(values, "0.1")))


def _unsettled(forward: list[ForwardScore]) -> float:
    """Number of conditions in which a leg with the printed TEP-SIPE parameters does not settle."""
    states = {s.condition: s.state for s in forward if s.parameter_set == "thesis-tep"}
    if not states:
        raise KeyError("forward")
    return float(sum(state != "settles" for state in states.values()))


def _least_step(values: dict) -> float:
    """Smallest ratio between one amplitude and the next lower one, over both profiles."""
    steps = []
    for profile in ("sine", "minjerk"):
        along = [values[f"{profile}-0.{k}"] for k in range(1, 6)]
        steps += [b / a for a, b in pairwise(along)]
    return min(steps)


def _least_fact(findings: Findings, fact: str) -> float:
    """Smallest of a fact (any unit) over the trials in which the person stood still."""
    facts = [fit.facts[fact] for fit in findings.fits["standing"].values() if fit.facts["responses"]]
    return float(min(facts))


def _shortest_latency(findings: Findings) -> float:
    """Shortest latency of all muscles in all tasks (s)."""
    found = [e.value for e in findings.estimates if e.quantity.startswith("latency_")]
    return min(e for e in found)


def _spread(findings: Findings) -> dict:
    return {
        condition: float(fit.arrays[f"{findings.as_printed}/parameters"][:, 2].std(ddof=1))
        for condition, fit in findings.fits["dummy"].items()
    }


START_STIFFNESS = 10.0  # N·m/rad, Table 3-2
ROUNDING = 1e-9  # of the difference of two decimal numbers, in any unit

MEASURES: dict[str, Callable[[Findings], float]] = {
    "wristalyzer_inertia": lambda f: _mean(f.by_condition("wristalyzer", "I")),
    "wristalyzer_damping": lambda f: _mean(f.by_condition("wristalyzer", "B")),
    "wristalyzer_stiffness": lambda f: _mean(f.by_condition("wristalyzer", "K")),
    "wristalyzer_stiffness_at_start": lambda f: float(
        sum(abs(k - START_STIFFNESS) < 5e-4 for k in f.by_condition("wristalyzer", "K").values())
    ),
    "wristalyzer_highest_vaf": lambda f: max(f.by_condition("wristalyzer", "VAF_trial").values()),
    "wristalyzer_best_factor": lambda f: float(
        max(f.by_condition("wristalyzer", "VAF_trial").items(), key=lambda item: item[1])[0]
    ),
    "wristalyzer_lowest_cross_validated": lambda f: min(
        f.by_condition("wristalyzer", "VAF_cross_validated").values()
    ),
    "printed_inertia": lambda f: _mean(f.by_condition("dummy", "I")),
    "printed_stiffness_low": lambda f: float(np.mean(_at(f.by_condition("dummy", "K"), "0.1", "0.2", "0.3"))),
    "printed_damping": lambda f: _mean(f.by_condition("dummy", "B")),
    "printed_stiffness_ratio": lambda f: _ratio(f.by_condition("dummy", "K")),
    "printed_lowest_vaf_perturbation": lambda f: min(f.by_condition("dummy", "VAF_perturbation").values()),
    "printed_lowest_vaf_trial": lambda f: min(f.by_condition("dummy", "VAF_trial").values()),
    "printed_spread_ratio": lambda f: _ratio(_spread(f)),
    "weight_mass_sine_low": lambda f: f.by_condition("weight", "mass")["sine-0.1"],
    "weight_mass_sine_high": lambda f: f.by_condition("weight", "mass")["sine-0.5"],
    "weight_mass_minjerk_low": lambda f: f.by_condition("weight", "mass")["minjerk-0.1"],
    "weight_mass_minjerk_high": lambda f: f.by_condition("weight", "mass")["minjerk-0.5"],
    "weight_mass_spread_ratio": lambda f: _ratio(f.by_condition("weight", "mass_sd")),
    "weight_mass_fall": lambda f: float(
        np.mean(_at(f.by_condition("weight", "mass"), "0.5"))
        - np.mean(_at(f.by_condition("weight", "mass"), "0.1"))
    ),
    "weight_speed_at_peak": lambda f: min(speed_at_peak(usual_weight(f.fits["weight"]), "20 Hz")),
    "weight_least_step": lambda f: _least_step(f.by_condition("weight", "added_force_peak")),
    "weight_growth": lambda f: _ratio(f.by_condition("weight", "added_force_peak")),
    "weight_largest": lambda f: (
        f.by_condition("weight", "added_force_peak")["minjerk-0.5"]
        / f.by_condition("weight", "added_force_peak")["sine-0.5"]
    ),
    "weight_over_empty": lambda f: min(shapes(f.fits["empty"], f.fits["weight"], "20 Hz")[1]),
    "weight_shape_at_10_hz": lambda f: min(shapes(f.fits["empty"], f.fits["weight"], "10 Hz")[0]),
    "weight_size_at_10_hz": lambda f: min(shapes(f.fits["empty"], f.fits["weight"], "10 Hz")[1]),
    "simulated_angle_gap": lambda f: (
        min(f.followed("thesis-wristalyzer", "theta")) - max(f.followed("thesis-tep", "theta"))
    ),
    "simulated_torque_gap": lambda f: (
        min(f.followed("thesis-tep", "tau")) - max(f.followed("thesis-wristalyzer", "tau"))
    ),
    "simulated_growth": lambda f: _unsettled(f.forward),
    "noise_free_stiffness": lambda f: f.noisy("as-tabulated", "K", "none"),
    "noise_inertia": lambda f: f.noisy("as-tabulated", "I", "tau"),
    "noise_damping": lambda f: f.noisy("as-tabulated", "B", "tau"),
    "noise_stiffness_angle": lambda f: f.noisy("as-tabulated", "K", "theta"),
    "noise_stiffness_torque": lambda f: f.noisy("as-tabulated", "K", "tau"),
    "noise_cross_validated": lambda f: f.noisy("as-tabulated", "VAF_cross_validated", "tau"),
    "standing_angle_over_sway": lambda f: _least_fact(f, "angle_over_sway"),
    "standing_torque_over_sway": lambda f: _least_fact(f, "torque_over_sway"),
    "standing_shortest_latency": lambda f: 1e3 * _shortest_latency(f),
    "second_order_r2": lambda f: f.score("mass-spring-damper", "empty", "weight", "Fy", 20.0),
} | further_measures.MEASURES


def _modulus_fits_at_start(f: Findings) -> float:
    """Number of fits of the modulus of eq (3-6), which is not smooth, that stay at their starting K."""
    found = [
        e.value
        for e in f.estimates
        if (e.experiment, e.estimator, e.quantity) == ("wristalyzer", MODULUS, "K")
    ]
    return float(sum(abs(k - START_STIFFNESS) < 5e-4 for k in found))


def _tapered_drop(f: Findings) -> float:
    """Drop of the coherence above 20 Hz with a taper, which removes the step between the record's ends."""
    return further_measures.coherence_drop(f, "tapered")


# number that the explanation of a claim predicts, in place of one outside the tolerance
EXPLANATIONS: dict[str, Callable[[Findings], float]] = {
    "wristalyzer_stiffness_at_start": _modulus_fits_at_start,
    "wristalyzer_coherence_drop": _tapered_drop,
    "noise_free_stiffness": lambda f: f.noisy("recommended-regression", "K", "none"),
}


@dataclass(frozen=True)
class ClaimVerdict:
    """One row of ``claims.csv``."""

    claim: str
    where: str
    unit: str
    """The statement, its place in the thesis, and the unit of its number."""
    reported: float
    reproduced: float | None
    """Number of the thesis and of this run (``unit``); None if this run does not have the result."""
    tolerance: str
    """Largest difference (``unit``), or ``below`` or ``above``."""
    verdict: str
    """See `check_claims`."""
    section: str
    """Section of the report."""
    null_value: float | None
    """Of a null model (``unit``)."""
    null_verdict: str
    """``implied`` if the null model is within the tolerance, too, otherwise ``not reproduced``."""
    margin: float | None
    """Value of the thesis's own printed numbers (``unit``), if they determine it."""
    used: str
    """What was used to get the number of this run, and whether the claim can discriminate."""
    statements: str
    """Numbers of the statements of chapters 4 to 6 that it tests, joined by ``;``."""


CLAIM_VERDICTS = Table(ClaimVerdict, "claims")


def check_claims(
    claims: list[dict],
    findings: Findings,
    bases: dict[str, str],
    printed: Findings | None = None,
    nulls: Findings | None = None,
    assertions: list[dict] | None = None,
) -> list[ClaimVerdict]:
    """Test every claim.

    claims: keys claim, where, measure, unit, reported, tolerance, section (``unit`` holds for reported and
    tolerance; the tolerance ``below`` requires less than reported, ``above`` more); verdict, which a
    simulated trial within the tolerance has; used, a name in ``bases``; and optionally null_value and
    margin (``unit``), in place of those by ``nulls`` and ``printed``.
    bases: what numbers are obtained from, in words.
    printed, nulls: numbers that the thesis printed, and those of the null models, as `findings_of_cells`
    makes them.
    assertions: statements of the thesis in their order, with the ``measures`` of the claims that test them.
    Returns: one per claim: the verdict is that of the claim within the tolerance (``predicted`` in place of
    ``fitted`` if no trial was simulated), ``explained`` outside it if the number that the explanation
    predicts is within, ``not computed`` if this run does not have the result (reproduced is None),
    otherwise ``not reproduced``. A claim that is ``implied`` is measured on the printed numbers.
    """
    nothing = Findings([], {}, findings.as_printed)
    rows = [_checked(claim, findings, bases, printed or nothing, nulls or nothing) for claim in claims]
    tested = [
        [k for k, one in enumerate(assertions or [], 1) if claim["measure"] in one.get("measures", ())]
        for claim in claims
    ]
    return [
        replace(row, statements=";".join(map(str, numbers)))
        for row, numbers in zip(rows, tested, strict=True)
    ]


def _checked(
    claim: dict, findings: Findings, bases: dict[str, str], printed: Findings, nulls: Findings
) -> ClaimVerdict:
    name = claim["measure"]
    if name not in MEASURES:
        close = difflib.get_close_matches(name, MEASURES, n=3, cutoff=0.0)
        raise InputError(
            f"expected a measure of tepsipe/reporting/claims.py, found {name!r}: "
            f"did you mean {' or '.join(close)}?"
        )
    basis = basis_of(claim, bases)
    value = _measured(MEASURES[name], printed if claim["verdict"] == IMPLIED else findings)
    null, margin = (
        claim.get(key, _measured(MEASURES[name], numbers))
        for key, numbers in (("null_value", nulls), ("margin", printed))
    )
    null_verdict = null_verdict_of(None if null is None else _holds(claim, null))
    used = basis + ("; cannot discriminate: the null model is within, too" if null_verdict == IMPLIED else "")
    tolerance = claim["tolerance"]
    return ClaimVerdict(
        *(claim["claim"], claim["where"], claim["unit"], claim["reported"], value),
        tolerance=tolerance if isinstance(tolerance, str) else f"{tolerance:.10g}",
        verdict=_verdict(claim, value, findings),
        section=claim["section"],
        null_value=null,
        null_verdict=null_verdict,
        margin=margin,
        used=used,
        statements="",
    )


def _verdict(claim: dict, value: float | None, findings: Findings) -> str:
    if value is None:
        return NOT_COMPUTED
    if _holds(claim, value):
        return PREDICTED if findings.recorded and claim["verdict"] == FITTED else claim["verdict"]
    predicted = None
    if claim["measure"] in EXPLANATIONS:
        predicted = _measured(EXPLANATIONS[claim["measure"]], findings)
    return EXPLAINED if predicted is not None and _holds(claim, predicted) else NOT_REPRODUCED


def _measured(measure: Callable[[Findings], float], findings: Findings) -> float | None:
    """A finite number, or None where the study does not have what it is made of."""
    try:
        with warnings.catch_warnings():  # means of nothing are not a number
            warnings.simplefilter("ignore", RuntimeWarning)
            value = measure(findings)
    except (ValueError, KeyError, ZeroDivisionError):
        return None
    return value if np.isfinite(value) else None


def _holds(claim: dict, value: float) -> bool:
    if claim["tolerance"] == "below":
        return value < claim["reported"]
    if claim["tolerance"] == "above":
        return value > claim["reported"]
    return abs(value - claim["reported"]) <= claim["tolerance"] + ROUNDING
