"""Uncertainty of I, B, K of a joint by windowed least squares, from stated sources of Type B."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tepsipe.errors import InputError
from tepsipe.identification.budgets.leg import KNOWN_OF_LEGS, LegUncertainty, leg_budget
from tepsipe.identification.budgets.manipulator import (
    MANIPULATOR_SOURCES,
    delay_contributions,
    scale_contributions,
)
from tepsipe.identification.consistency import (
    DelayProfile,
    TorqueDelay,
    combined,
    delay_profile,
    moved_by,
    residual_test,
)
from tepsipe.identification.estimators import LEAST_SQUARES_THESIS, Record, estimate
from tepsipe.identification.leg_fit import reestimator
from tepsipe.identification.regression.windows import WindowedFits
from tepsipe.identification.result import Quantity, parts_of, quantities_of
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.mechanics.inverse_dynamics import leg_pathway_torque
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.perturbations import extended_to_rest
from tepsipe.statistics.uncertainty import Budget, Source, stated_sources

# windows with the free decay are recommended from this many perturbations on, if they reduce the half-width
# of K to this part of it or less
FEWEST_WITH_DECAY, LEAST_GAIN = 3, 0.75
# largest difference of a torque from the leg's own, relative to its spread
LARGEST_DIFFERENCE = 0.1


def fit_aligned(
    name: str, record: Record, uncertainty: object, confidence: float
) -> tuple[WindowedFits, Record, TorqueDelay | None]:
    """Fit of a record whose torque has been moved by its delay, if record or statement determine it.

    name: estimator.
    uncertainty: as for `windows_budget`.
    confidence: probability of the intervals.
    Returns: fit, the record with the moved torque, and the delay; None where no delay is possible, because
    the torque is computed from the motion.
    """
    fit = estimate(name, record)
    if name == LEAST_SQUARES_THESIS or isinstance(uncertainty, LegUncertainty):
        return fit, record, None
    if not fit.crossed:
        few = "The perturbations do not repeat each other in either direction. Record 3 or more that do"
        return fit, record, TorqueDelay(DelayProfile(reason=few))
    time = record.motion.time
    profile = delay_profile(
        time, fit.regressors, fit.torque, record.perturbations, record.at_rest, confidence
    )
    stated = stated_sources(uncertainty, MANIPULATOR_SOURCES, "fit_impedance")
    delay = combined(profile, stated, fit.mean)
    if delay.uncertainty_s is None:
        return fit, record, delay
    moved = replace(record, torque=moved_by(time, record.torque, delay.removed_s))
    aligned = estimate(name, moved)
    residual = aligned.torque - aligned.predicted
    if residual_test(residual, aligned.torque, record.perturbations, record.at_rest).failed:
        other = (
            "The linear joint leaves more of the torque than noise, as with reflexes, softening or signals "
            "that were filtered differently, so that a delay cannot be told from them"
        )
        return fit, record, TorqueDelay(replace(profile, reason=other))
    return aligned, moved, delay


def windows_budget(
    fit: WindowedFits,
    name: str,
    record: Record,
    uncertainty: Mapping[str, float | Source] | LegUncertainty | None,
    delay: TorqueDelay | None = None,
) -> tuple[Budget, tuple[str, ...]]:
    """Uncertainty of the means of I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad).

    name: their estimator.
    record: what they were estimated from.
    uncertainty: stated uncertainty of the scales of torque and angle and of the torque's delay, or of a
    leg.
    delay: delay that was removed before the fit.

    Returns:
        budget: type A and one entry per source.
        sources: sources of Type B.
    """
    place = "fit_impedance"
    of_leg = isinstance(uncertainty, LegUncertainty)
    stated = uncertainty.sources if of_leg else uncertainty
    sources = stated_sources(stated, KNOWN_OF_LEGS if of_leg else MANIPULATOR_SOURCES, place)
    if sources and name == LEAST_SQUARES_THESIS:
        raise InputError(
            f"{place}: expected no uncertainty with thesis, because the error of a wrong equation is not due "
            "to its inputs, found both: leave one out"
        )
    if of_leg:
        _refuse_other_torque(uncertainty, record.torque)
        known = replace(uncertainty, sources=sources)
        return leg_budget(fit, reestimator(name, record), known), tuple(sources)
    contributions = scale_contributions(dict(zip(PARAMETERS, fit.mean, strict=True)), sources)
    freedom = {source: known.freedom for source, known in sources.items()}
    if delay is not None and delay.uncertainty_s is not None:
        u, added = fit.type_a, delay.added
        contributions["torque_delay_s"] = added[None]
        # both come from the same scatter, so that their sum has its degrees of freedom and no more
        share = added**2 / np.maximum(2.0 * u[0] ** 2 + added**2, 1e-300)
        freedom["torque_delay_s"] = u[1] * np.maximum(share, 1e-12)
    elif "torque_delay_s" in sources:
        rate = derivative(record.motion.time, record.torque)
        contributions |= delay_contributions(
            lambda x: estimate(name, replace(record, torque=x)).mean, rate, sources
        )
    return Budget(*fit.type_a, contributions, freedom), tuple(sources)


def _refuse_other_torque(known: LegUncertainty, torque: np.ndarray) -> None:
    of_leg = leg_pathway_torque("leg", known.leg, known.motion)
    if of_leg.shape != torque.shape or np.std(of_leg - torque) > LARGEST_DIFFERENCE * np.std(torque):
        raise InputError(
            "fit_impedance, uncertainty: expected a LegUncertainty whose leg and motion gave the torque, "
            "found another torque: give torque=joint_torque(motion, leg), and the same motion and leg"
        )


def with_scales(
    quantities: Mapping[str, Quantity],
    sources: Mapping[str, Source],
    confidence: float,
    further: Mapping[str, np.ndarray] | None = None,
) -> dict[str, Quantity]:
    """Bootstrapped quantities with Type B of the scales of torque and angle.

    Each end of an interval moves outwards by the half width of Type B, in quadrature, because bootstrapped
    intervals are not symmetric.

    quantities: p estimates of Type A by name.
    sources: torque_scale and angle_scale, as far as they are known.
    confidence: probability of the intervals.
    further: contributions of other sources, as in `Budget.contributions`.
    Returns: by the same names.
    """
    powers = {name: _powers(q.unit) for name, q in quantities.items()}
    values = {name: q.value for name, q in quantities.items()}
    type_a = np.array([q.standard_error for q in quantities.values()])
    contributions = scale_contributions(values, sources, powers) | dict(further or {})
    freedom = {name: sources[name].freedom for name in contributions}
    budget = Budget(type_a, np.inf, contributions, freedom)
    of_b = Budget(np.zeros_like(type_a), np.inf, contributions, freedom)
    half = of_b.interval(np.zeros_like(type_a), confidence)[1]
    wider = {
        name: replace(
            q,
            standard_error=float(budget.combined[k]),
            low=q.value - float(np.hypot(q.value - q.low, half[k])),
            high=q.value + float(np.hypot(q.high - q.value, half[k])),
        )
        for k, (name, q) in enumerate(quantities.items())
    }
    widened = wider if contributions else quantities
    return {
        name: replace(q, parts=parts)
        for (name, q), parts in zip(widened.items(), parts_of(budget), strict=True)
    }


def _powers(unit: str) -> tuple[int, int]:
    """Powers of the torque and of the angle in a unit such as N·m·s/rad."""
    torque = int("N·m" in unit)
    if "/rad" not in unit:
        return torque, int(unit.startswith("rad"))
    return torque, -2 if unit.endswith("rad²") else -1


def of_free_decay(
    result: WindowedFits,
    quantities: Mapping[str, Quantity],
    name: str,
    record: Record,
    uncertainty: object,
    confidence: float,
) -> tuple[str, ...]:
    """Recommendation of windows with the free decay, where they agree with the fit and K gains a quarter.

    result, quantities: fit and its I, B, K.
    record: as it was recorded, with a delay of the torque.
    name, uncertainty, confidence: as for `fit_aligned`.
    """
    windows, time = record.perturbations, record.motion.time
    if len(windows) < FEWEST_WITH_DECAY or any(w.until == "rest" for w in windows):
        return ()
    rate_hz = (time.size - 1) / (time[-1] - time[0])
    decay = record.motion.theta_d, rate_hz, windows, record.at_rest
    longer = extended_to_rest(*decay)
    if any(record.at_rest[w.start : w.stop].any() for w in longer):
        return ()
    seconds = float(np.median([b.stop - a.stop for a, b in zip(windows, longer, strict=True)])) / rate_hz
    if not seconds > 0.0:
        return ()
    most = LEAST_GAIN * result.type_a[0][2]
    # also at twice the threshold, because find_perturbations may measure the noise in another time of rest
    sooner = replace(record, perturbations=extended_to_rest(*decay, signal_to_noise=10.0))
    if not estimate(name, sooner).type_a[0][2] <= most:
        return ()
    extended = replace(record, perturbations=longer)
    other, aligned, delay = fit_aligned(name, extended, uncertainty, confidence)
    if not other.type_a[0][2] <= most:
        return ()
    budget, _ = windows_budget(other, name, aligned, uncertainty, delay)
    better = quantities_of(dict(zip(PARAMETERS, other.mean, strict=True)), budget, confidence)
    half, new = ({key: (q.high - q.low) / 2.0 for key, q in of.items()} for of in (quantities, better))
    if new["K"] > LEAST_GAIN * half["K"] or any(
        abs(better[key].value - quantities[key].value) > np.hypot(half[key], new[key]) for key in PARAMETERS
    ):
        return ()
    return (
        f"The joint moves on for {seconds:.2g} s after the windows. If it is passive, find_perturbations "
        f'with until="rest" gives about K = {better["K"].value:.4g} ± {new["K"]:.2g} N·m/rad instead of '
        f"{quantities['K'].value:.4g} ± {half['K']:.2g} N·m/rad.",
    )
