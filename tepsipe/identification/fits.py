"""Public functions that estimate the impedance of a joint from arrays.

Every function takes arrays in SI units, or `Signal`s that name their unit, filters all of them alike, and
returns an `ImpedanceFit` with intervals. Defaults are what we recommend.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from tepsipe.arguments import (
    changed_options,
    checked,
    limits,
    pair,
    plausible_angle,
    refuse_constant,
    refuse_same,
    regular_rate,
    same_length,
    samples,
)
from tepsipe.errors import InputError, quoted, refuse_other_kind
from tepsipe.identification import notes
from tepsipe.identification.arguments import (
    as_perturbations,
    bootstrap_generator,
    refuse_still,
    samples_at_rest,
    shaded,
)
from tepsipe.identification.budgets.leg import KNOWN_OF_LEGS, LegUncertainty
from tepsipe.identification.budgets.manipulator import (
    MANIPULATOR_SOURCES,
    SCALES,
    delay_contributions,
    fit_response,
)
from tepsipe.identification.cascade.fit import ParallelCascadeFit
from tepsipe.identification.cascade.options import ParallelCascadeOptions
from tepsipe.identification.one_thread import one_thread
from tepsipe.identification.result import PARAMETERS, Curve, ImpedanceFit, Quantity, quantities_of, symbol_of
from tepsipe.signals.array_types import Samples
from tepsipe.signals.sample_faults import of_samples
from tepsipe.statistics.uncertainty import Source, stated_sources

if TYPE_CHECKING:
    from tepsipe.mechanics.inverse_dynamics import Leg
    from tepsipe.mechanics.segment_kinematics import SegmentMotion
    from tepsipe.signals.response import FrequencyResponse


@one_thread()
def fit_impedance(
    time: "Samples",
    angle: "Samples",
    torque: "Samples",
    *,
    perturbations: Sequence | None = None,
    rest: np.ndarray | tuple[float, float] | None = None,
    baseline: Literal["rest", "each"] = "rest",
    cutoff_hz: float | None = 20.0,
    order: int = 4,
    thesis: bool = False,
    block_s: float = 1.0,
    bootstrap_draws: int = 2000,
    confidence: float = 0.95,
    seed: int = 0,
    uncertainty: "Mapping[str, float | Source] | LegUncertainty | None" = None,
) -> ImpedanceFit:
    """I, B, K of a joint from its angle and torque, by least squares.

    With perturbations, tau = I theta'' + B theta' + K (theta - theta_rest) is fitted to each perturbation
    separately, with tau relative to its value at rest (windowed least squares, thesis eq 3-9), and the
    estimates are averaged. If at least 3 perturbations repeat each other, in either direction, only signals
    of different perturbations are multiplied, so that noise of the angle does not bias I, B and K
    (`tepsipe.identification.regression.windows`). Intervals are Student's, from the scatter of the
    perturbations and from the error of angle and torque at rest, which all perturbations share. Without
    perturbations, tau = I theta'' + B theta' + K theta + offset is fitted to the whole record, and intervals
    are bootstrapped over blocks of the record (random multipliers of their shares in the error), with the
    standard error and degrees of freedom of these clusters (`tepsipe.statistics.clusters`); noise of the
    angle then makes I, B and K too small.

    Parameters
    ----------
    time : array_like or Signal, shape (n,)
        Instants (s), on a regular clock.
    angle, torque : array_like or Signal, shape (n,)
        theta (rad) and tau (N·m), positive when it resists a positive angle; not filtered.
    perturbations : sequence of Perturbation or of (start, stop), optional
        Windows, first sample and the first after it (samples), for example from `find_perturbations`; of a
        passive joint with its free decay, ``until="rest"``.
    rest : ndarray of bool, shape (n,), or (float, float), optional
        Samples at rest, or unperturbed time at the trial's start and end (s); by default the time before the
        first perturbation.
    baseline : {"rest", "each"}
        Zero of angle and torque: their means at rest, or before each perturbation (0.2 s), for a torque that
        drifts.
    cutoff_hz : float or None
        Cutoff of the zero-lag Butterworth low-pass of all signals (Hz); None if they are filtered already.
    order : int
        Its order, both passes together.
    thesis : bool
        Leave the torque at rest in, and fit each perturbation by itself, as eq (3-9) is printed.
    block_s : float
        Length of the bootstrapped blocks (s), without perturbations.
    bootstrap_draws : int
        Bootstrap samples, without perturbations.
    confidence : float
        Probability of the intervals.
    seed : int
        Seed of the bootstrap, without perturbations.
    uncertainty : mapping of str to float or Source, or LegUncertainty, optional
        Standard uncertainties of Type B: ``torque_scale`` and ``angle_scale`` (relative), ``torque_delay_s``
        (of the torque after its record, s). For a torque of a leg from its markers, a `LegUncertainty`.
        Without it, intervals are of Type A. A stated delay is combined with the record's own.

    Returns
    -------
    ImpedanceFit
        I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad), VAF of the torque (%); with perturbations the delay of
        the torque after its record (s), for which I, B and K are corrected, or why it is undetermined
        (`tepsipe.identification.consistency`).

    Raises
    ------
    InputError
        If the signals cannot be used, or do not determine I, B and K.

    Examples
    --------
    >>> from tepsipe import fit_impedance, load_example
    >>> dummy = load_example("dummy")
    >>> fit = fit_impedance(dummy.time, dummy.angle, dummy.torque, perturbations=dummy.perturbations)
    >>> print(f"I = {fit.I:.4f}, B = {fit.B:.3f}, K = {fit.K:.2f}, VAF {fit.vaf:.1f} %")
    I = 0.0200, B = 0.145, K = 10.01, VAF 99.9 %
    >>> fit.quantities["K"]
    <10.014 [9.820, 10.208] N·m/rad>
    >>> print(fit.findings[0].partition(".")[0])
    The joint moves on for 3 s after the windows
    """
    from tepsipe.mechanics.segment_kinematics import joint_motion
    from tepsipe.signals.filters import butterworth_lowpass

    named = notes.of_names(time=(time, "s"), angle=(angle, "rad"), torque=(torque, "Nm"))
    time, rate_hz, angle, torque = _of_joint(time, angle, torque)
    rng = bootstrap_generator(bootstrap_draws, confidence, seed)
    cutoff_hz, order, thesis, block_s = checked(
        ("cutoff_hz",), cutoff_hz=cutoff_hz, order=order, thesis=thesis, block_s=block_s
    )
    if baseline not in ("rest", "each") or (thesis and baseline == "each"):
        raise InputError(
            f"baseline: expected 'rest' or, without thesis, 'each', found {quoted(baseline)}: choose one"
        )
    recorded = angle, torque
    if cutoff_hz is not None:
        angle, torque = (butterworth_lowpass(x, rate_hz, cutoff_hz, order) for x in (angle, torque))
    motion = joint_motion(time, angle)
    if perturbations is None:
        if thesis or rest is not None or baseline != "rest":
            raise InputError(
                "fit_impedance: expected perturbations with thesis, rest or baseline, because these are "
                "about what comes before a perturbation, found none: give perturbations, or leave them out"
            )
        fit = _fit_record(motion, torque, rate_hz, block_s, bootstrap_draws, confidence, rng, uncertainty)
    else:
        how = perturbations, rest, baseline, thesis, confidence, uncertainty
        fit = _fit_windows(motion, torque, rate_hz, *how)
    windows = getattr(fit.details, "perturbations", [])
    filtered = notes.of_filter(rate_hz, cutoff_hz, windows) + notes.of_repeats(*recorded, windows)
    filtered += of_samples(angle=recorded[0], torque=recorded[1])
    if not thesis:
        at_rest = samples_at_rest(motion.time, windows, rest) if windows else None
        filtered += notes.of_floors(at_rest, rate_hz, angle=recorded[0], torque=recorded[1])
    return replace(fit, notes=(*named, *fit.notes, *notes.of_impedance(fit, motion, torque), *filtered))


@one_thread()
def fit_output_error(
    motion: "SegmentMotion",
    foot_position: "Samples",
    belt_velocity: "Samples",
    leg: "Leg",
    *,
    perturbations: Sequence,
    rest: np.ndarray | tuple[float, float] | None = None,
    cutoff_hz: float = 20.0,
    order: int = 4,
    confidence: float = 0.95,
    uncertainty: "Mapping[str, float | Source] | None" = None,
) -> ImpedanceFit:
    """I, B, K of the joint under a leg on a moving belt, without a torque (output error).

    The angle is simulated over the whole trial from the motion of the foot. The estimate makes the error
    orthogonal to instruments from the logged belt velocity. Intervals assume that the leg comes to rest
    between perturbations, with the time constant 2 J / B (J: moment of inertia of leg and joint about the
    ankle); see `tepsipe.identification.regression.output_error`.

    Parameters
    ----------
    motion : SegmentMotion
        Motion of the leg, from `segment_motion` with the same cutoff and order (s, rad, m).
    foot_position : array_like or Signal, shape (n,)
        Position of the foot along the belt (m), for example the mean of belt-fixed markers; not filtered.
    belt_velocity : array_like or Signal, shape (n,)
        Logged velocity of the belt (m/s), not filtered.
    leg : Leg
        The leg (kg, m, kg·m²).
    perturbations : sequence of Perturbation or of (start, stop)
        Windows (samples), from `find_perturbations`.
    rest : ndarray of bool, shape (n,), or (float, float), optional
        Samples at rest, or unperturbed time at the trial's start and end (s); by default the time before the
        first perturbation.
    cutoff_hz : float
        Cutoff of the zero-lag Butterworth low-pass (Hz), the same as for ``motion``.
    order : int
        Its order, both passes together, the same as for ``motion``.
    confidence : float
        Probability of the intervals, which are Student's over the perturbations.
    uncertainty : mapping of str to float or Source, optional
        Standard uncertainties of Type B, of the names in `LegUncertainty`; those of the directions and of
        single markers do not act. Without it, intervals are of Type A.

    Returns
    -------
    ImpedanceFit
        I (N·m·s²/rad, without the leg's own), B (N·m·s/rad), K (N·m/rad), delay of the angle after the foot
        (s); VAF of the angle (%).

    Raises
    ------
    InputError
        If the signals cannot be used, or the angle does not determine the parameters.

    Examples
    --------
    >>> from tepsipe import fit_output_error, load_example, segment_motion
    >>> dummy = load_example("dummy")
    >>> motion = segment_motion(
    ...     dummy.time, dummy.positions, dummy.markers, dummy.leg.com_m, labels=dummy.labels
    ... )
    >>> foot = [dummy.labels.index(label) for label in dummy.belt_fixed]
    >>> fit = fit_output_error(
    ...     motion,
    ...     dummy.positions[:, foot, 0].mean(axis=1),
    ...     dummy.belt_velocity,
    ...     dummy.leg,
    ...     perturbations=dummy.perturbations,
    ... )
    >>> print(f"I = {fit.I:.4f}, B = {fit.B:.3f}, K = {fit.K:.2f}")
    I = 0.0200, B = 0.150, K = 10.00
    """
    from tepsipe.identification.estimators import OUTPUT_ERROR, Record
    from tepsipe.identification.leg_fit import fit_record
    from tepsipe.identification.likelihood.checks import scale_check
    from tepsipe.mechanics.inverse_dynamics import Leg
    from tepsipe.mechanics.segment_kinematics import SegmentMotion
    from tepsipe.signals.differentiation import derivative
    from tepsipe.signals.filters import butterworth_lowpass

    named = notes.of_names(foot_position=(foot_position, "m"), belt_velocity=(belt_velocity, "m/s"))
    refuse_other_kind(motion, SegmentMotion, "fit_output_error", "segment_motion")
    refuse_other_kind(leg, Leg, "fit_output_error", "Leg")
    time, rate_hz = regular_rate(motion.time)
    foot = samples(foot_position, "m", "foot_position")
    belt = samples(belt_velocity, "m/s", "belt_velocity")
    same_length(time, foot_position=foot, belt_velocity=belt)
    refuse_constant(foot_position=foot, belt_velocity=belt)
    refuse_same(foot_position=foot, belt_velocity=belt)
    cutoff_hz, order, confidence = checked(cutoff_hz=cutoff_hz, order=order, confidence=confidence)
    sources = stated_sources(uncertainty, KNOWN_OF_LEGS, "fit_output_error")
    foot, belt = (butterworth_lowpass(x, rate_hz, cutoff_hz, order) for x in (foot, belt))
    follows = notes.of_belt(derivative(time, foot), belt)
    windows = as_perturbations(perturbations, time.size)
    record = Record(
        motion=motion,
        leg=leg,
        perturbations=windows,
        at_rest=samples_at_rest(time, windows, rest),
        foot_position=foot,
        belt_velocity=belt,
    )
    known = LegUncertainty(leg, None, sources, motion)
    result, quantities, _ = fit_record(OUTPUT_ERROR, record, known, confidence=confidence)
    fit = ImpedanceFit(
        estimator=OUTPUT_ERROR,
        quantities=quantities | {"delay": Quantity(result.delay_s, "s")},
        vaf=result.vaf_angle,
        vaf_of="the angle over the trial, from rest",
        confidence=confidence,
        curve=Curve(time, result.angle, result.simulated, "Angle (rad)", shaded(time, windows)),
        details=result,
        windows=result.parameters,
        type_b=tuple(sources),
    )
    inertia = fit.I + leg.inertia_kgm2 + leg.mass_kg * leg.com_m**2
    follows += notes.of_delay(result.delay_s) + notes.of_rest(time, windows, inertia, fit.B)
    follows += notes.of_filter(rate_hz, cutoff_hz, windows)
    follows += notes.of_checks([scale_check(motion.layout_scale)])
    follows += notes.of_markers(motion, record.at_rest, rate_hz)
    return replace(fit, notes=(*named, *fit.notes, *notes.of_impedance(fit, motion), *follows))


@one_thread()
def fit_admittance(
    response: "FrequencyResponse",
    *,
    band_hz: tuple[float, float] | None = None,
    start: Sequence[float] | None = None,
    lower: Sequence[float] | None = None,
    upper: Sequence[float] | None = None,
    thesis: bool = False,
    confidence: float = 0.95,
    uncertainty: "Mapping[str, float | Source] | None" = None,
) -> ImpedanceFit:
    """I, B, K from a measured frequency response of the joint, angle over torque (thesis eqs 3-5 and 3-6).

    Parameters
    ----------
    response : FrequencyResponse
        Admittance theta/tau with its coherence (Hz, rad/(N·m)), from ``frequency_response(time, torque,
        angle)``.
    band_hz : (float, float), optional
        Frequencies to fit (Hz); by default all.
    start : sequence of float, optional
        Starting values of I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad); by default from the response.
    lower, upper : sequence of float, optional
        Bounds of I, B, K (units as ``start``); by default none.
    thesis : bool
        The modulus of the log ratio as residual, with the starting values and bounds of thesis Table 3-2.
        This fit has no intervals, because its search ends near its start, whatever the scatter.
    confidence : float
        Probability of the intervals. Each frequency has a variance of its own. The smearing by averaged
        frequencies and, for a periodic perturbation, the distance to the fit by another criterion are
        included (`tepsipe.identification.budgets.manipulator`).
    uncertainty : mapping of str to float or Source, optional
        Standard uncertainties of Type B: ``torque_scale`` and ``angle_scale`` (relative), ``torque_delay_s``
        (of the torque after its record, s). Without it, intervals are of Type A.

    Returns
    -------
    ImpedanceFit
        I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad); VAF of the response (%).

    Raises
    ------
    InputError
        If the response has too few frequencies, or bounds contradict each other.

    Examples
    --------
    >>> from tepsipe import fit_admittance, frequency_response, load_example
    >>> rig = load_example("manipulator")
    >>> response = frequency_response(
    ...     rig.time, rig.torque, rig.angle, period_s=rig.period_s, band_hz=(1.0, 20.0)
    ... )
    >>> fit = fit_admittance(response)
    >>> print(f"I = {fit.I:.4f}, B = {fit.B:.3f}, K = {fit.K:.2f}")
    I = 0.0150, B = 0.200, K = 10.00
    """
    from tepsipe.identification.admittance_fit import TABLE_3_2, Bounds, starting_values
    from tepsipe.identification.consistency import combined, delay_of_response
    from tepsipe.mechanics.impedance_model import admittance
    from tepsipe.signals.response import FrequencyResponse

    refuse_other_kind(
        response, FrequencyResponse, "fit_admittance", "frequency_response(time, torque, angle)"
    )
    confidence, thesis = checked(confidence=confidence, thesis=thesis)
    sources = stated_sources(uncertainty, MANIPULATOR_SOURCES, "fit_admittance")
    band = _usable(response)
    band = band if band_hz is None else band.band(*pair(band_hz, "band_hz"))
    if band.frequency_hz.size < 4:
        raise InputError(
            f"fit_admittance: expected at least 4 frequencies, found {band.frequency_hz.size}: widen the band"
        )
    if thesis:
        start, lower, upper = (
            chosen if chosen is not None else printed
            for chosen, printed in zip((start, lower, upper), TABLE_3_2, strict=True)
        )
    bounds = Bounds(
        start=starting_values(band) if start is None else samples(start, "", "start", shape=(3,)),
        lower=np.full(3, -np.inf) if lower is None else limits(lower, "lower", 3),
        upper=np.full(3, np.inf) if upper is None else limits(upper, "upper", 3),
    )
    if not ((bounds.lower < bounds.start) & (bounds.start < bounds.upper)).all():
        raise InputError(
            f"fit_admittance: expected starting values between their bounds, found "
            f"{bounds.start.tolist()} with "
            f"{bounds.lower.tolist()} and {bounds.upper.tolist()}: correct one of the three"
        )
    if not np.isfinite(admittance(bounds.start, band.frequency_hz)).all():
        raise InputError(
            f"start: expected I, B, K of a joint that resists, found {bounds.start.tolist()}: give others, "
            "or leave start out"
        )
    result, quantities = fit_response(band, bounds, sources, thesis, confidence)
    delay = None
    if not thesis:
        profile = delay_of_response(band, result.parameters, confidence)
        delay = combined(profile, sources, result.parameters)
        if delay.uncertainty_s is not None:
            turn = np.exp(-2j * np.pi * band.frequency_hz * delay.removed_s)
            band = replace(band, response=band.response * turn)
            result, quantities = fit_response(band, bounds, delay.among(sources), thesis, confidence)
    late, doubts, undetermined = notes.of_torque_delay(delay, confidence, "torque_delay_s" in sources)
    model = admittance(result.parameters, band.frequency_hz)
    residual = np.abs(band.response - model) ** 2
    found = response.notes + notes.of_response(band)
    found += () if result.converged else ("The search did not converge: do not use these numbers.",)
    found += ("A parameter lies at its bound: its value is that of the bound.",) if result.at_bound else ()
    omega = 2.0 * np.pi * band.frequency_hz
    rows = np.sqrt([np.mean(omega**4), np.mean(omega**2), 1.0])
    found += notes.of_signs(quantities, notes.shares(result.parameters, rows))
    explained = float(100.0 * (1.0 - residual.sum() / np.sum(np.abs(band.response) ** 2)))
    return ImpedanceFit(
        estimator="spectral-fit-modulus" if thesis else "spectral-fit",
        quantities=quantities | late,
        vaf=explained,
        vaf_of="the response",
        confidence=confidence,
        curve=Curve(band.frequency_hz, band.response, model, "Admittance (rad/(N·m))"),
        details=result,
        notes=found + doubts + notes.of_stiffness(quantities) + notes.of_vaf(explained, "the response"),
        findings=undetermined,
        type_b=tuple(sources),
    )


@one_thread()
def fit_parallel_cascade(
    time: "Samples",
    angle: "Samples",
    torque: "Samples",
    *,
    training_fraction: float = 0.5,
    cut_s: float = 1.0,
    cutoff_hz: float = 30.0,
    order: int = 4,
    resample_rate_hz: float = 250.0,
    block_s: float = 1.0,
    bootstrap_draws: int = 1000,
    confidence: float = 0.95,
    seed: int = 0,
    uncertainty: "Mapping[str, float | Source] | None" = None,
    **options,
) -> ImpedanceFit:
    """Intrinsic stiffness and stretch reflex of a joint under imposed movement (Kearney et al. 1997).

    The first part of the record is fitted, the rest is held out for validation.

    Parameters
    ----------
    time : array_like or Signal, shape (n,)
        Instants (s), on a regular clock.
    angle, torque : array_like or Signal, shape (n,)
        theta (rad) and tau (N·m), positive when it resists a positive angle; not filtered.
    training_fraction : float
        First part of the record that is fitted.
    cut_s : float
        Time that is cut at both ends (s).
    cutoff_hz : float
        Cutoff of the zero-lag Butterworth low-pass of all signals (Hz).
    order : int
        Its order, both passes together.
    resample_rate_hz : float
        Rate to which faster records are resampled first (Hz).
    block_s : float
        Length of the bootstrapped blocks (s).
    bootstrap_draws : int
        Bootstrap samples.
    confidence : float
        Probability of the intervals.
    seed : int
        Seed of the bootstrap.
    uncertainty : mapping of str to float or Source, optional
        Standard uncertainties of Type B: ``torque_scale`` and ``angle_scale`` (relative). Without it,
        intervals are of Type A.
    **options
        Fields of `ParallelCascadeOptions` that differ from the default.

    Returns
    -------
    ImpedanceFit
        Intrinsic I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) beyond yield, at the working amplitude and at
        short range, reflex gain (N·m·s/rad) and delay (s); VAF of the held-out torque (%), without the slow
        torque. Its ``details`` are a `ParallelCascadeFit`.

    Raises
    ------
    InputError
        If the signals cannot be used, the record is too short, the joint does not move, or the torque does
        not resist the movement.

    Examples
    --------
    >>> from tepsipe import fit_parallel_cascade, load_example
    >>> ankle = load_example("ankle")
    >>> half = slice(7500)
    >>> fit = fit_parallel_cascade(
    ...     ankle.time[half], ankle.angle[half], ankle.torque[half], bootstrap_draws=100
    ... )
    >>> print(f"K = {fit.K:.1f}, reflex gain = {fit.quantities['reflex_gain'].value:.1f}")
    K = 79.8, reflex gain = 5.0
    """
    from tepsipe.identification.cascade.checks import failed_checks
    from tepsipe.identification.cascade.parallel_cascade import identify_cascade
    from tepsipe.identification.cascade.record import fitted_part, make_record
    from tepsipe.mechanics.segment_kinematics import joint_motion
    from tepsipe.signals.filters import Lowpass
    from tepsipe.signals.resampling import regular_time, resample

    named = notes.of_names(time=(time, "s"), angle=(angle, "rad"), torque=(torque, "Nm"))
    time, rate_hz, angle, torque = _of_joint(time, angle, torque)
    rng = bootstrap_generator(bootstrap_draws, confidence, seed)
    training_fraction, cut_s, cutoff_hz, order, resample_rate_hz, block_s = checked(
        training_fraction=training_fraction,
        cut_s=cut_s,
        cutoff_hz=cutoff_hz,
        order=order,
        resample_rate_hz=resample_rate_hz,
        block_s=block_s,
    )
    chosen = changed_options(ParallelCascadeOptions, options, "fit_parallel_cascade")
    sources = stated_sources(uncertainty, SCALES, "fit_parallel_cascade")
    spoiled = of_samples(angle=angle, torque=torque)
    spoiled += notes.of_floors(None, rate_hz, angle=angle, torque=torque)
    if rate_hz > 1.001 * resample_rate_hz:
        slower = regular_time(time[0], time[-1], resample_rate_hz)
        angle, torque = (resample(time, x, slower, 0.4 * resample_rate_hz) for x in (angle, torque))
        time, rate_hz = slower, resample_rate_hz
    kept, training, block = fitted_part(
        time.size, rate_hz, cut_s, block_s, training_fraction, "fit_parallel_cascade: "
    )
    lowpass = Lowpass(cutoff_hz, order, True)
    record = make_record(angle, torque, rate_hz, kept, training, lambda x: lowpass(x, rate_hz), chosen)
    try:
        result = identify_cascade(record, block, bootstrap_draws, rng)
    except np.linalg.LinAlgError as error:
        raise InputError(
            f"fit_parallel_cascade: expected options that the record determines, found {error}: leave the "
            f"options {', '.join(options) or 'as they are'} out, or record longer"
        ) from error
    if result.impedance[0] < 0.0 and result.working_stiffness < 0.0:
        raise InputError(
            "fit_parallel_cascade: expected a torque that resists a positive angle, found a negative inertia "
            f"and a stiffness of {result.working_stiffness:.3g} N·m/rad: reverse the sign of the torque"
        )
    quantities, findings, assumed = _cascade_quantities(result, confidence)
    from tepsipe.identification.budgets.windows import with_scales

    quantities = with_scales(quantities, sources, confidence)
    measured = lowpass(torque, rate_hz)[kept]
    motion = joint_motion(time[kept], lowpass(angle, rate_hz)[kept])
    fitted = np.array([[time[kept][0], time[kept][training - 1]]])
    fit = ImpedanceFit(
        estimator="parallel-cascade",
        quantities=quantities | {"delay": Quantity.refused("s", notes.NO_DELAY)},
        vaf=result.vaf.held_out,
        vaf_of="the held-out torque",
        confidence=confidence,
        curve=Curve(time[kept], measured, result.predicted, "Torque (N·m)", fitted),
        details=result,
        findings=(*findings, notes.NO_DELAY),
        type_b=tuple(sources),
    )
    found = notes.of_impedance(fit, motion, measured) + notes.of_filter(rate_hz, cutoff_hz)
    found += notes.of_halves(result.vaf.training, result.vaf.held_out)
    failed = failed_checks(record, result)
    found += notes.of_cascade(*(name for name in failed if name != "filtered-signal" or not spoiled))
    return replace(fit, notes=(*named, *assumed, *found, *spoiled))


# ---- parts ---------------------------------------------------------------------------------------


def _of_joint(
    time: Samples, angle: Samples, torque: Samples
) -> tuple[np.ndarray, float, np.ndarray, np.ndarray]:
    """Regular time (s), its rate (Hz), angle (rad) and torque (N·m) of a joint that moves."""
    time, rate_hz = regular_rate(time)
    angle = plausible_angle(samples(angle, "rad", "angle"))
    torque = samples(torque, "Nm", "torque")
    same_length(time, angle=angle, torque=torque)
    refuse_constant(angle=angle, torque=torque)
    refuse_same(time=time, angle=angle, torque=torque)
    return time, rate_hz, angle, torque


def _fit_windows(
    motion, torque, rate_hz, perturbations, rest, baseline, thesis, confidence, uncertainty
) -> ImpedanceFit:
    """Windowed least squares, intervals over the perturbations."""
    from tepsipe.identification.budgets.windows import fit_aligned, of_free_decay, windows_budget
    from tepsipe.identification.consistency import from_own_zero
    from tepsipe.identification.estimators import LEAST_SQUARES, LEAST_SQUARES_THESIS, Record

    windows = as_perturbations(perturbations, motion.time.size)
    name = LEAST_SQUARES_THESIS if thesis else LEAST_SQUARES
    at_rest = samples_at_rest(motion.time, windows, rest)
    refuse_still(motion.theta, windows)
    if baseline == "each" and not thesis:
        moving = motion.theta, motion.theta_d, motion.theta_dd, torque
        theta, rate, acceleration, torque = (from_own_zero(x, windows, at_rest, rate_hz) for x in moving)
        motion = replace(motion, theta=theta, theta_d=rate, theta_dd=acceleration)
    record = Record(motion=motion, torque=torque, perturbations=windows, at_rest=at_rest)
    result, aligned, delay = fit_aligned(name, record, uncertainty, confidence)
    budget, sources = windows_budget(result, name, aligned, uncertainty, delay)
    quantities = quantities_of(dict(zip(PARAMETERS, result.mean, strict=True)), budget, confidence)
    decay = () if thesis else of_free_decay(result, quantities, name, record, uncertainty, confidence)
    late, doubts, undetermined = notes.of_torque_delay(delay, confidence, "torque_delay_s" in sources)
    return ImpedanceFit(
        estimator=name,
        quantities=quantities | late,
        vaf=float(result.vaf_per_perturbation.mean()),
        vaf_of="the torque, mean over the perturbations",
        confidence=confidence,
        curve=Curve(
            motion.time, result.torque, result.predicted, "Torque (N·m)", shaded(motion.time, windows)
        ),
        details=result,
        windows=result.parameters,
        notes=notes.of_windows(windows) + doubts + notes.of_consistency(result, at_rest, rate_hz, thesis),
        findings=decay + undetermined,
        type_b=sources,
    )


def _fit_record(motion, torque, rate_hz, block_s, draws, confidence, rng, uncertainty) -> ImpedanceFit:
    """One regression with an offset over the whole record, intervals over blocks."""
    from tepsipe.identification.consistency import combined, delay_of_record, halves_of_record, moved_by
    from tepsipe.signals.differentiation import derivative
    from tepsipe.statistics.clusters import errors_over_blocks
    from tepsipe.statistics.goodness_of_fit import explained
    from tepsipe.statistics.least_squares import least_squares_line

    sources = stated_sources(uncertainty, MANIPULATOR_SOURCES, "fit_impedance without perturbations")
    regressors = np.column_stack([motion.theta_dd, motion.theta_d, motion.theta, np.ones_like(motion.theta)])
    block = round(block_s * rate_hz)
    if not 16 <= 4 * block <= torque.size:
        raise InputError(
            f"fit_impedance: expected at least 4 blocks of {block_s:g} s, each of 4 samples or more, found a "
            f"record of {torque.size / rate_hz:.3g} s at {rate_hz:g} Hz: record longer, or change block_s"
        )
    profile = delay_of_record(motion.time, regressors, torque, block, confidence)
    try:
        result = least_squares_line(regressors, torque)
    except np.linalg.LinAlgError as error:
        raise InputError(
            f"fit_impedance: expected a joint that moves, found {error}: check that it was perturbed"
        ) from error
    delay = combined(profile, sources, result.parameters[:3])
    if delay.uncertainty_s is not None:
        torque = moved_by(motion.time, torque, delay.removed_s)
        result = least_squares_line(regressors, torque)
    sources = delay.among(sources)
    stated = "torque_delay_s" in (uncertainty or {})
    late_by, doubts, undetermined = notes.of_torque_delay(delay, confidence, stated)
    errors, freedom, shares = errors_over_blocks(regressors, result.residuals, block)
    # multiplier bootstrap: blocks drawn with replacement may all lack a perturbation
    drawn = sum(
        rng.standard_normal((draws, len(part))) @ part
        for part in np.array_split(shares, 1 + len(shares) // 1000)
    )
    predicted, mean = regressors @ result.parameters, torque.mean()
    late = delay_contributions(
        lambda x: np.linalg.lstsq(regressors, x)[0], derivative(motion.time, torque), sources
    )
    from tepsipe.identification.budgets.windows import with_scales

    quantities = with_scales(
        {
            name: Quantity.scaled(
                result.parameters[k], symbol_of(name), drawn[:, k], confidence, errors[k], freedom[k]
            )
            for k, name in enumerate((*PARAMETERS, "offset"))
        },
        sources,
        confidence,
        late,
    )
    return ImpedanceFit(
        estimator="regression",
        quantities=quantities | late_by,
        vaf=explained(torque - mean, predicted - mean),
        vaf_of="the torque about its mean",
        confidence=confidence,
        curve=Curve(motion.time, torque, predicted, "Torque (N·m)"),
        details=result,
        notes=doubts + notes.of_parts(halves_of_record(regressors, torque, block)),
        findings=undetermined,
        type_b=tuple(uncertainty or ()),
    )


def _usable(response):
    """A frequency response whose every part is a number, without frequencies of 0 Hz."""
    count = np.size(response.frequency_hz)
    frequency, coherence, real, imaginary = (
        samples(x, None, f"response: {name}", shape=(count,))
        for x, name in (
            (response.frequency_hz, "frequency_hz"),
            (response.coherence, "coherence"),
            (np.real(response.response), "response"),
            (np.imag(response.response), "response"),
        )
    )
    usable = (frequency > 0.0) & (coherence > 0.0) & (np.hypot(real, imaginary) > 0.0)
    if not usable.all() or (coherence > 1.0 + 1e-9).any() or (np.diff(frequency) <= 0.0).any():
        raise InputError(
            "fit_admittance: expected frequencies above 0 Hz that increase, with gains above 0 and "
            f"coherences above 0 and up to 1, found others at {int((~usable).sum())} of {count}: make the "
            "response with tepsipe.frequency_response, or choose band_hz"
        )
    return replace(response, frequency_hz=frequency, response=real + 1j * imaginary, coherence=coherence)


def _cascade_quantities(
    fit: ParallelCascadeFit, confidence: float
) -> tuple[dict[str, Quantity], tuple[str, ...], tuple[str, ...]]:
    """Quantities with intervals, findings, and notes on assumed values.

    confidence: probability of the intervals.

    Returns
    -------
    dict of str to Quantity
        I, B, K and further quantities of the terms that were selected.
    findings : tuple of str
        Sentences on the reflex and the slow torque.
    assumed : tuple of str
        Sentences on values that the record does not determine.
    """
    quantities, structure = fit.quantities(confidence), fit.structure
    # without draws that yield or relax there is no interval
    for name, with_it in (("yield_angle", ()), ("relaxation_time", ("K_relaxing",))):
        if name in quantities and not np.isfinite(quantities[name].standard_error):
            quantities = {key: q for key, q in quantities.items() if key not in (name, *with_it)}
    slow = (
        f"With the slow torque, predicted {fit.slow.horizon_s:g} s ahead from past residuals, the held-out "
        f"VAF is {fit.slow.vaf.held_out:.1f} %."
    )
    if not structure.direction:
        del quantities["reflex_gain"]
        return quantities, ("Cross-validation found no reflex.", slow), ()
    for name, value in (
        ("reflex_delay", structure.delay_s),
        ("reflex_threshold", structure.threshold_rad_per_s),
    ):
        quantities[name] = Quantity(value, symbol_of(name))
    close, assumed = [], []
    for choice in fit.assumptions:
        if not choice.determined:
            narrow = choice.high - choice.low <= notes.NARROW.get(choice.quantity, 0.0)
            (close if narrow else assumed).append(notes.of_choice(choice))
    return quantities, (*close, slow), tuple(assumed)
