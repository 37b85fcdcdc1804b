"""Notes: caveats on input that can be used, but that probably is not what was meant.

Each function examines one kind of evidence and returns its sentences, none for a valid record. The limits
have a physical reason, which stands beside them. `docs/when-it-stops.md` lists the notes for users.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated

import numpy as np

from tepsipe.arguments import SPELLINGS, unit_by_name, unit_in, unit_of
from tepsipe.errors import InputError
from tepsipe.identification.cascade.fit import Assumption
from tepsipe.identification.consistency import (
    MEASURE,
    TorqueDelay,
    explains_less,
    parts_differ,
    residual_test,
    wandering,
)
from tepsipe.identification.result import ImpedanceFit, Quantity
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS
from tepsipe.mechanics.segment_kinematics import JointMotion, SegmentMotion
from tepsipe.quantities import unit_symbol
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.perturbations import Perturbation
from tepsipe.signals.response import FrequencyResponse
from tepsipe.signals.sample_faults import noise_floors, of_samples
from tepsipe.statistics.least_squares import column_lengths, triangle
from tepsipe.statistics.uncertainty import error_of_mean

if TYPE_CHECKING:
    from tepsipe.identification.likelihood.checks import Check
    from tepsipe.identification.regression.windows import WindowedFits

# below this VAF (%) the residual has more than half the standard deviation of the signal
LEAST_VAF = 75.0
# few joints have a range of motion beyond this (rad): 115 degrees
LARGEST_SWING_RAD = 2.0
# no instrument resolves less (rad, N·m)
SMALLEST_SWING_RAD, SMALLEST_TORQUE_NM = 1e-6, 1e-6
# measured signals leave a larger part of their variance unexplained
LEAST_RESIDUAL = 1e-12
# stretch perturbations reach about 10 rad/s; one of 2 degrees in 0.1 s, taken for radians, exceeds 20 rad/s
FASTEST_RAD_PER_S = 20.0
# the strongest joints of a human reach a few hundred N·m
LARGEST_TORQUE_NM = 2000.0
# a parameter below 0 matters from this part of the torque on, which filters and derivatives cannot cause
LEAST_SHARE = 0.02
# from this part of the sampling rate on, the spline's derivative of a component is over 2 % too small
LARGEST_CUTOFF = 0.2
# windows that are shorter than half a period of the cutoff lose most of the filtered response
LEAST_PERIODS = 0.5
# ratio of the foot's velocity to the belt's: it stands on the belt; another unit exceeds the second range
BELT_GAIN, BELT_GAIN_LIMIT = (0.8, 1.25), (0.4, 2.5)
# a longer delay of the angle after the foot is none of markers that cameras see at the same instants (s)
LONGEST_DELAY_S = 1e-3
# time constants of the leg between perturbations: after one, estimates scatter 1.6 times as much as their
# intervals state, after 1.7 as they state (80 simulated records each)
LEAST_REST = 1.5
# ranges that a cascade fit may leave open: the delays that are tried are 30 ms apart at most (s, rad/s)
NARROW = {"reflex_delay": 0.03, "reflex_threshold": 0.1}
# smallest delay of a torque that is noted (s), and confidence that there is one; smaller delays are corrected
# without a note
LEAST_DELAY_S, SURE = 5e-4, 0.999
NO_DELAY = (
    "The delay of the torque is undetermined: reflexes and the intrinsic response, which may begin at any "
    "time, explain a delay equally well. Measure the delay of the rig."
)
CONVENTION = "tau is positive when it resists a positive angle"


def of_names(**given: tuple[object, str]) -> tuple[str, ...]:
    """Arguments that were converted because their name ends in another unit than expected.

    **given: argument and its required unit, by the argument's name.
    Returns: one sentence per converted argument.
    """
    found = []
    for name, (values, unit) in given.items():
        actual, by_name = unit_of(values, unit, name)
        if by_name:
            label = getattr(values, "name", "")
            found.append(
                f"The {name} was converted from {actual} to {unit}, because its name is {label!r}: rename "
                "it if that is wrong."
            )
    return tuple(found)


def of_column(column: str, what: str, unit: str | None, wanted: str) -> tuple[str, tuple[str, ...]]:
    """Unit of a table's column, and a note where its name says another one.

    what: the quantity, such as angle.
    unit: unit that the user states; None for the unit in which the name ends, or ``wanted``.
    wanted: unit of the quantity in the library.

    Returns:
        unit: unit of the samples.
        notes: one sentence, or none.
    """
    if unit is None:
        found, by_name = unit_by_name(column, wanted, what)
        said = f"The {what} was converted from {found} to {wanted}, because its column is called {column!r}."
        return found, (said,) if by_name else ()
    named = unit_in(column)
    if SPELLINGS.get(named, named) in ("", unit):
        return unit, ()
    option = f"--{what.replace(' ', '-')}-unit"
    return unit, (f"The {what} was read in {unit}, but its column is called {column!r}: check {option}.",)


def of_vaf(vaf: float, what: str) -> tuple[str, ...]:
    """Low VAF (%) of the signal ``what``."""
    if vaf >= LEAST_VAF:
        return ()
    return (
        f"The VAF of {what} is only {vaf:.1f} %: more than half of its amplitude is not explained. Check "
        "that the signals belong together, their synchronisation and the columns.",
    )


def of_signs(quantities: Mapping[str, Quantity], shares: Mapping[str, float]) -> tuple[str, ...]:
    """Parameters whose whole interval lies below 0, and which matter for the torque.

    shares: amplitude of each parameter's torque relative to all of them.
    Returns: one sentence, or none.
    """
    below = []
    for name in PARAMETERS:
        q = quantities[name]
        end = q.high if np.isfinite(q.high) else q.value
        if q.value < 0.0 and end < 0.0 and shares[name] > LEAST_SHARE:
            below.append(name)
    if not below:
        return ()
    values = ", ".join(f"{name} = {quantities[name].value:.3g} {quantities[name].unit}" for name in below)
    if below == ["B"]:
        advice = (
            "a passive joint dissipates energy. Check the synchronisation of angle and torque, and that the "
            "two are not exchanged."
        )
    elif below == ["I"]:
        advice = (
            "no joint has a negative inertia. Check that all signals passed the same filter, their "
            "synchronisation, and the masses that were subtracted."
        )
    else:
        advice = f"the sign of angle or torque is probably reversed ({CONVENTION}). Reverse one of them."
    return (f"Below 0: {values}; {advice}",)


def of_exchange(
    angle_rows: Annotated[np.ndarray, "(n, 3)", "rad"], torque_rows: Annotated[np.ndarray, "(n, 3)", "N·m"]
) -> tuple[str, ...]:
    """Angle and torque that are probably exchanged.

    The torque follows from the angle by two derivatives, not the other way round. A fit of exchanged signals
    has a negative damping, and explains less than the same fit the right way round.

    angle_rows, torque_rows: second derivative, first derivative and signal.
    Returns: one sentence, or none.
    """
    left = _unexplained(angle_rows, torque_rows[:, 2])
    if left < LEAST_RESIDUAL or _unexplained(torque_rows, angle_rows[:, 2]) >= 0.5 * left:
        return ()
    return (
        "Angle and torque are probably exchanged: the angle as a function of the torque's derivatives "
        "explains more than the reverse. Check the order of the arguments.",
    )


def _unexplained(columns: np.ndarray, y: np.ndarray) -> float:
    """Part of the variance of ``y`` that a regression on columns and a constant leaves."""
    x = np.column_stack([columns, np.ones(y.size)])
    scale = column_lengths(x)
    scale = np.where(scale > 0.0, scale, 1.0)
    rows, right = triangle(x, y, scale)
    solution = np.linalg.lstsq(rows, right, rcond=None)[0] / scale
    return float(np.sum((y - x @ solution) ** 2) / np.sum((y - y.mean()) ** 2))


def of_swing(angle: np.ndarray, rate: np.ndarray) -> tuple[str, ...]:
    """Movement that is too large or too fast for radians (rad, rad/s), shape (n,)."""
    swing, fastest = float(np.ptp(angle)), float(np.percentile(np.abs(rate), 99.9))
    if swing < SMALLEST_SWING_RAD:
        return (f"The angle moves over {swing:.3g} rad only, less than instruments resolve: check its unit.",)
    if swing <= LARGEST_SWING_RAD and fastest <= FASTEST_RAD_PER_S:
        return ()
    return (
        f"The angle moves over {swing:.3g} rad at up to {fastest:.3g} rad/s, more than a perturbed joint "
        'does: it is probably in degrees, which Signal(angle, "deg") converts, or another signal.',
    )


def of_torque(torque: np.ndarray) -> tuple[str, ...]:
    """Torque (N·m), shape (n,), beyond any human joint."""
    largest = float(np.abs(torque).max())
    if largest < SMALLEST_TORQUE_NM:
        return (f"The torque reaches {largest:.3g} N·m only, less than instruments resolve: check its unit.",)
    if largest <= LARGEST_TORQUE_NM:
        return ()
    return (
        f"The torque reaches {largest:.3g} N·m, more than a human joint does: check its unit, which "
        'Signal(torque, "Nmm") converts from N·mm.',
    )


def of_proportion(angle: np.ndarray, torque: np.ndarray) -> tuple[str, ...]:
    """Torque (N·m) that is the angle (rad) times a number, both shape (n,)."""
    if _unexplained(angle[:, None], torque) > LEAST_RESIDUAL:
        return ()
    return (
        "The torque is proportional to the angle in every digit: one was probably computed from the other, "
        "or both are the same column.",
    )


def of_filter(
    rate_hz: float, cutoff_hz: float | None, windows: Sequence[Perturbation] = ()
) -> tuple[str, ...]:
    """Cutoff (Hz) that is too high for the sampling rate (Hz), or too low for the windows (samples)."""
    if cutoff_hz is None:
        return ()
    found = []
    if cutoff_hz > 1.001 * LARGEST_CUTOFF * rate_hz:
        at = 2.0 * np.pi * min(cutoff_hz / rate_hz, 0.5)
        lost = 100.0 * (1.0 - 3.0 * np.sin(at) / (2.0 + np.cos(at)) / at)
        found.append(
            f"The cutoff of {cutoff_hz:g} Hz is high for samples at {rate_hz:g} Hz: derivatives of "
            f"components there are {lost:.0f} % too small. Give cutoff_hz={LARGEST_CUTOFF * rate_hz:.3g} or "
            "record faster."
        )
    if windows:
        lasts_s = float(np.median([w.stop - w.start for w in windows])) / rate_hz
        if cutoff_hz * lasts_s < LEAST_PERIODS:
            found.append(
                f"The cutoff of {cutoff_hz:g} Hz is low for perturbations of {lasts_s:.3g} s: the filtered "
                "response spreads beyond their windows. Raise cutoff_hz or give longer windows."
            )
    return tuple(found)


def of_repeats(
    angle: Annotated[np.ndarray, "(n,)", "rad"],
    torque: Annotated[np.ndarray, "(n,)", "N·m"],
    windows: Sequence[Perturbation],
) -> tuple[str, ...]:
    """Windows that hold the same samples, as only copied data do.

    angle, torque: signals as recorded.
    Returns: one sentence, or none.
    """
    contents = [angle[w.start : w.stop].tobytes() + torque[w.start : w.stop].tobytes() for w in windows]
    copies = len(contents) - len(set(contents))
    if not copies:
        return ()
    return (
        f"{copies} of {len(contents)} perturbations hold the same samples as another one: copies are no "
        "repetitions, so the intervals are too narrow.",
    )


def of_windows(windows: Sequence[Perturbation]) -> tuple[str, ...]:
    """Windows (samples) that show no scatter, or that the next perturbation cuts off."""
    found = ["One perturbation has no interval: record more."] if len(windows) == 1 else []
    cut = sum(earlier.until == "rest" and later.start == earlier.stop for earlier, later in pairwise(windows))
    if cut:
        found.append(
            f"{cut} of {len(windows)} windows end where the next perturbation begins, before the joint was "
            "at rest: the fit uses no more of the other windows than the shortest one lasts, so wait longer "
            "between perturbations."
        )
    return tuple(found)


def of_consistency(fit: "WindowedFits", at_rest: np.ndarray, rate_hz: float, thesis: bool) -> tuple[str, ...]:
    """Residual in the perturbations beyond the residual at rest, torque that drifts, and parts that differ.

    thesis: whether the torque at rest was left in, so that a residual is expected.
    """
    if thesis or len(fit.fits) < 2:
        return ()
    found = []
    test = residual_test(fit.torque - fit.predicted, fit.torque, fit.perturbations, at_rest)
    moves = wandering(fit.torque - fit.predicted, fit.torque, fit.perturbations, at_rest, rate_hz)
    if moves:
        found.append(
            f"The torque before the perturbations wanders by {moves:.2g} N·m: the zero of the sensor drifts, "
            'or a person relaxes. Give baseline="each", which takes every perturbation from its own zero.'
        )
    if test.failed:
        found.append(
            f"The linear joint leaves {100.0 * test.part:.2g} % of the torque in the perturbations, "
            f"{test.ratio:.2g} times as much as at rest: the intervals may miss I, B and K. Check for a "
            "delay or a filter of one signal, a torque that drifts, softening, and reflexes."
        )
    angles = [fit.regressors[w.start : w.stop, 2] for w in fit.perturbations]
    direction = np.array([np.sign(x[np.argmax(np.abs(x))]) for x in angles])
    error, freedom = error_of_mean((fit.torque - fit.predicted)[at_rest])
    rows = [fit.regressors[w.start : w.stop] for w in fit.perturbations]
    of_rest = error * np.array([np.linalg.lstsq(x, np.ones(len(x)))[0] for x in rows])
    return (*found, *of_parts(parts_differ(fit.parameters, direction, of_rest, freedom)))


def of_parts(differences: Sequence[tuple[str, str, float, float]]) -> tuple[str, ...]:
    """Sentence on the clearest difference between parts of a record, as `parts_differ` returns them."""
    return tuple(
        f"{what.capitalize()} of the record give {name} = {one:.4g} and {other:.4g} "
        f"{unit_symbol(UNITS[name])}, more apart than they scatter: the joint or the recording changed. "
        "Check mounts, sensors and the subject, and fit the parts separately."
        for name, what, one, other in differences[:1]
    )


def of_cascade(*failed: str) -> tuple[str, ...]:
    """Failed checks of a parallel-cascade fit that no other note explains."""
    from tepsipe.identification.cascade.checks import MEANINGS

    return tuple(_told(name, MEANINGS[name]) for name in failed if name in MEANINGS)


def of_checks(checks: "Sequence[Check]") -> tuple[str, ...]:
    """Failed checks of a joint likelihood, as the flags of a study explain them."""
    from tepsipe.identification.likelihood.checks import MEANINGS, failed

    return tuple(_told(name, MEANINGS[name]) for name in failed(checks))


def _told(name: str, meaning: str) -> str:
    return f"{meaning[0].upper()}{meaning[1:]} ({name})."


def of_stiffness(quantities: Mapping[str, Quantity]) -> tuple[str, ...]:
    """Stiffness that may be 0."""
    q = quantities["K"]
    if not q.low <= 0.0 <= q.high:
        return ()
    return (
        f"K is not distinguishable from 0, its interval is {q.low:.3g} to {q.high:.3g} {q.unit}: do not "
        "quote it. Record more or larger perturbations, or windows that last longer.",
    )


def of_halves(training: float, held_out: float) -> tuple[str, ...]:
    """Held-out part of a record that the model of its first part explains much less (VAFs in %)."""
    if not explains_less(training, held_out):
        return ()
    return (
        f"The model explains {training:.1f} % of the part that was fitted, and only {held_out:.1f} % of the "
        "part that was held out: the joint or the recording changed. Check the second part of the record.",
    )


def of_floors(at_rest: np.ndarray | None, rate_hz: float, **signals: np.ndarray) -> tuple[str, ...]:
    """Signals that were filtered before, while others were not (as recorded, shape (n,), by name)."""
    return tuple(
        f"The {name} was filtered before it was recorded, and another signal was not: its noise "
        "vanishes at high frequencies. This biases I, B and K. Export it without a filter, or filter both "
        "alike."
        for name in noise_floors(at_rest, rate_hz, **signals)
    )


def of_markers(motion: SegmentMotion, at_rest: np.ndarray, rate_hz: float) -> tuple[str, ...]:
    """Faults of the leg's markers as recorded, and filters of some of them."""
    named = {f"marker {label!r}": x for label, x in motion.recorded.items()}
    return of_samples(**named) + of_floors(at_rest, rate_hz, **named) if named else ()


def of_torque_delay(
    delay: TorqueDelay | None, confidence: float, stated: bool
) -> tuple[dict[str, Quantity], tuple[str, ...], tuple[str, ...]]:
    """Delay of the torque after its record.

    stated: whether its standard uncertainty was stated.

    Returns:
        quantity: ``delay``; none where no delay is possible.
        notes: one sentence on a delay that is not 0.
        findings: one sentence on a delay that the record does not determine.
    """
    if delay is None:
        return {}, (), ()
    profile = delay.profile
    if not profile.determined:
        refusal = f"The delay of the torque is undetermined. {profile.reason}."
        quantity, sure = {"delay": Quantity.refused("s", refusal)}, profile.half_width_s(SURE)
        if not stated and abs(profile.value_s) > max(LEAST_DELAY_S, sure):
            d, half = 1e3 * profile.value_s, 1e3 * profile.half_width_s(confidence)
            late = "late" if d > 0.0 else "early"
            said = f"The torque was probably recorded {abs(d):.2g} ± {half:.1g} ms too {late}"
            return quantity, (f"{said}, for which I, B and K are not corrected. {MEASURE}.",), (refusal,)
        if not stated and profile.excludes_zero:
            said = "A delay of the torque explains the record better than none, but not which one"
            return quantity, (f"{said}: I, B and K are not corrected. {MEASURE}.",), (refusal,)
        return quantity, (), () if stated else (refusal,)
    d, u, half = profile.value_s, profile.standard_error_s, profile.half_width_s(confidence)
    quantity = {"delay": Quantity(d, "s", u, d - half, d + half)}
    if abs(d) < max(LEAST_DELAY_S, profile.half_width_s(SURE)) or delay.uncertainty_s is None:
        return quantity, (), ()
    values = ", ".join(f"{name} = {x:.4g}" for name, x in zip(PARAMETERS, delay.uncorrected, strict=True))
    return (
        quantity,
        (
            f"The torque was recorded {1e3 * abs(d):.2f} ± {1e3 * half:.2f} ms too "
            f"{'late' if d > 0.0 else 'early'}: I, B and K are corrected for "
            f"{1e3 * abs(delay.removed_s):.2f} ms (without it {values}). Check the synchronisation of the "
            "two signals.",
        ),
        (),
    )


def of_belt(foot_velocity: np.ndarray, belt_velocity: np.ndarray) -> tuple[str, ...]:
    """Foot that does not move with the belt (m/s), both shape (n,)."""
    foot, belt = (x - np.median(x) for x in (foot_velocity, belt_velocity))
    power = float(belt @ belt)
    gain = float(foot @ belt) / power if power > 0.0 else np.nan
    if BELT_GAIN[0] <= gain <= BELT_GAIN[1]:
        return ()
    if not BELT_GAIN_LIMIT[0] <= gain <= BELT_GAIN_LIMIT[1]:
        what = "the opposite sign" if gain < -BELT_GAIN_LIMIT[0] else "another unit or another clock"
        raise InputError(
            f"belt_velocity: expected the velocity of the foot, which stands on the belt, found the foot "
            f"{gain:.3g} times as fast: one of the two has {what}, so correct it"
        )
    return (
        f"The foot moves {gain:.3g} times as fast as the logged belt, on which it stands: check the scale "
        "and the synchronisation of the two.",
    )


def of_delay(delay_s: float) -> tuple[str, ...]:
    """Delay of the angle after the foot (s) that no common set of cameras has."""
    if abs(delay_s) <= LONGEST_DELAY_S:
        return ()
    return (
        f"The angle follows the foot {1e3 * delay_s:.3g} ms late, which the fit allows for. Markers that "
        "cameras see at the same instants have no such delay: check the synchronisation of leg and foot.",
    )


def of_rest(
    time: Annotated[np.ndarray, "(n,)", "s"], windows: Sequence[Perturbation], inertia: float, damping: float
) -> tuple[str, ...]:
    """Perturbations that follow each other before the leg has come to rest.

    inertia, damping: moment of inertia of leg and joint about the ankle (kg·m²), damping (N·m·s/rad).
    Returns: one sentence, or none.
    """
    onsets = np.array([time[w.start] for w in windows])
    apart_s = float(np.median(np.diff(onsets))) if onsets.size > 1 else np.inf
    if apart_s * damping >= LEAST_REST * 2.0 * inertia or damping <= 0.0:
        return ()
    return (
        f"The perturbations follow each other every {apart_s:.3g} s, before the leg has come to rest (time "
        f"constant {2.0 * inertia / damping:.3g} s): the intervals treat them as independent, so do not rely "
        "on these. Wait longer between perturbations, or use fit_joint_likelihood.",
    )


def of_choice(choice: Assumption) -> str:
    """Sentence on a value of a cascade fit that the record does not determine (unit of the value)."""
    unit, equal = choice.unit, choice.low == choice.high
    others = f"{choice.low:g} {unit}" if equal else f"values from {choice.low:g} to {choice.high:g} {unit}"
    return (
        f"The {choice.quantity.replace('_', ' ')} of {choice.value:g} {unit} is assumed: the record explains "
        f"{others} equally well (cross-validated VAF {choice.vaf_low:.2f} to {choice.vaf_high:.2f} %)."
    )


def of_response(response: FrequencyResponse) -> tuple[str, ...]:
    """Frequency response that is an impedance, or has the wrong sign, where an admittance was expected.

    The angle lags behind the torque, from 0 to half a turn; the torque leads the angle.
    """
    unit = response.response / np.abs(response.response)
    if float(np.average(unit.imag, weights=response.coherence)) <= 0.0:
        return ()
    if unit[: max(1, unit.size // 4)].real.mean() < 0.0:
        return (
            "The response starts opposite to the torque: the sign of angle or torque is probably reversed "
            f"({CONVENTION}).",
        )
    return (
        "The response leads its input, as an impedance does: fit_admittance needs the admittance, "
        "frequency_response(time, torque, angle).",
    )


def of_impedance(fit: ImpedanceFit, motion: JointMotion, torque: np.ndarray | None = None) -> tuple[str, ...]:
    """Notes that every fit of a motion has in common.

    motion: angle with its derivatives, filtered.
    torque: torque (N·m), filtered.
    Returns: one sentence per caveat.
    """
    rows = motion.theta_dd, motion.theta_d, motion.theta
    found = of_swing(motion.theta, motion.theta_d) + of_vaf(fit.vaf, fit.vaf_of)
    found += of_signs(fit.quantities, shares(fit.parameters, np.array([x.std() for x in rows])))
    found += of_stiffness(fit.quantities)
    if torque is None:
        return found
    if fit.B < 0.0:
        rate = derivative(motion.time, torque)
        exchanged = np.column_stack([derivative(motion.time, rate), rate, torque])
        found += of_exchange(np.column_stack(rows), exchanged)
    return found + of_torque(torque) + of_proportion(motion.theta, torque)


def shares(
    parameters: Annotated[np.ndarray, "(3,)"], amplitudes: Annotated[np.ndarray, "(3,)"]
) -> dict[str, float]:
    """Amplitude of each parameter's torque relative to their sum.

    amplitudes: standard deviations of theta'' (rad/s²), theta' (rad/s), theta (rad).
    Returns: by the parameter's name, 0 to 1.
    """
    torques = np.abs(parameters) * amplitudes
    total = float(torques.sum())
    return dict(zip(PARAMETERS, torques / total if total > 0.0 else torques, strict=True))
