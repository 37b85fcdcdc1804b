"""Public function of the likelihood: markers and belt velocity in, I, B, K with intervals out."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tepsipe.arguments import checked, regular_rate, same_length, samples, texts
from tepsipe.errors import InputError, refuse_other_kind
from tepsipe.identification import notes
from tepsipe.identification.arguments import as_perturbations, samples_at_rest, shaded
from tepsipe.identification.budgets.leg import KNOWN_OF_LEGS, LegUncertainty
from tepsipe.identification.one_thread import one_thread
from tepsipe.identification.result import Curve, ImpedanceFit
from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.mechanics.segment_kinematics import SegmentMarkers, marker_samples, segment_motion
from tepsipe.signals.array_types import Samples
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.statistics.uncertainty import Source, coverage_factor, stated_sources


@one_thread()
def fit_joint_likelihood(
    time: "Samples",
    positions: "Samples",
    markers: SegmentMarkers,
    leg: Leg,
    *,
    labels: Sequence[str],
    belt_fixed: Sequence[str],
    perturbations: Sequence,
    belt_velocity: "Samples | None" = None,
    rest: np.ndarray | tuple[float, float] | None = None,
    hidden: np.ndarray | None = None,
    softening: bool = True,
    confidence: float = 0.95,
    uncertainty: "Mapping[str, float | Source] | None" = None,
) -> ImpedanceFit:
    """I, B, K of the joint under a leg on a moving belt, by the likelihood of all markers and the log.

    Nothing is filtered. See `tepsipe.identification.likelihood.likelihood`.

    Parameters
    ----------
    time : array_like or Signal, shape (n,)
        Instants (s), on a regular clock.
    positions : array_like or Signal, shape (n, all markers, 3) or (n, all markers, 2)
        Marker positions x, y, z or y, z (m) at these instants: y along the belt, z up.
    markers : SegmentMarkers
        Markers on the leg, and their positions (m).
    leg : Leg
        The leg (kg, m, kg·m²).
    labels, belt_fixed : sequence of str
        Names of all markers, in the order of ``positions``, and of those that move with the foot.
    perturbations : sequence of Perturbation or of (start, stop)
        Windows (samples), from `find_perturbations`.
    belt_velocity : array_like or Signal, shape (n,), optional
        Logged velocity of the belt (m/s), not derived from markers.
    rest : ndarray of bool, shape (n,), or (float, float), optional
        Samples at rest, or unperturbed time at the trial's start and end (s); by default the time before the
        first perturbation.
    hidden : array_like of bool, shape (n, all markers), optional
        Samples of markers that were filled, not recorded: they are reconstructed from the other markers.
    softening : bool
        Whether the joint may soften with bending.
    confidence : float
        Probability of the intervals.
    uncertainty : mapping of str to float or Source, optional
        Standard uncertainties of Type B, of the names in `LegUncertainty`; offsets of markers and the
        direction of gravity do not act. Without it, intervals are of Type A.

    Returns
    -------
    ImpedanceFit
        I (N·m·s²/rad, without the leg's own), B (N·m·s/rad), K (N·m/rad) at the amplitude of the
        perturbations, and I_small, B_small, K_small for small movements; delay of the angle after the foot
        (s); with ``softening``, K_softened (N·m/rad) and B_softened (N·m·s/rad), the stiffness lost and the
        damping gained at large angles; VAF of the angle (%).

    Raises
    ------
    InputError
        If the signals cannot be used, or the angle does not determine the parameters.

    Examples
    --------
    >>> from tepsipe import fit_joint_likelihood, load_example
    >>> dummy = load_example("dummy")
    >>> fit = fit_joint_likelihood(
    ...     dummy.time,
    ...     dummy.positions,
    ...     dummy.markers,
    ...     dummy.leg,
    ...     labels=dummy.labels,
    ...     belt_fixed=dummy.belt_fixed,
    ...     perturbations=dummy.perturbations,
    ...     belt_velocity=dummy.belt_velocity,
    ...     softening=False,
    ... )
    >>> print(f"I = {fit.I:.4f}, B = {fit.B:.3f}, K = {fit.K:.2f}")
    I = 0.0200, B = 0.150, K = 10.00
    """
    from tepsipe.identification.estimators import JOINT_LIKELIHOOD, JOINT_LIKELIHOOD_LINEAR, Record
    from tepsipe.identification.leg_fit import fit_record
    from tepsipe.identification.likelihood.channels import dummy_markers
    from tepsipe.identification.likelihood.checks import of_likelihood

    named = notes.of_names(time=(time, "s"), positions=(positions, "m"), belt_velocity=(belt_velocity, "m/s"))
    refuse_other_kind(leg, Leg, "fit_joint_likelihood", "Leg")
    refuse_other_kind(markers, SegmentMarkers, "fit_joint_likelihood", "SegmentMarkers")
    confidence, softening = checked(confidence=confidence, softening=softening)
    labels, belt_fixed = texts(labels, "labels"), texts(belt_fixed, "belt_fixed")
    sources = stated_sources(uncertainty, KNOWN_OF_LEGS, "fit_joint_likelihood")
    time, rate_hz = regular_rate(time)
    measured = marker_samples(positions)
    motion = segment_motion(time, measured, markers, leg.com_m, labels=labels)
    log = None if belt_velocity is None else samples(belt_velocity, "m/s", "belt_velocity")
    if log is not None:
        same_length(time, belt_velocity=log)
    filled = None if hidden is None else _marked(hidden, measured.shape[:2])
    windows = as_perturbations(perturbations, time.size)
    name = JOINT_LIKELIHOOD if softening else JOINT_LIKELIHOOD_LINEAR
    record = Record(
        motion=motion,
        leg=leg,
        perturbations=windows,
        at_rest=samples_at_rest(time, windows, rest),
        markers=dummy_markers(measured, list(labels), markers, tuple(belt_fixed), filled),
        belt_log=log,
    )
    follows = ()
    if log is not None:
        foot = record.markers.positions[:, record.markers.on_foot, 0].mean(axis=1)
        follows = notes.of_belt(derivative(time, butterworth_lowpass(foot, rate_hz, 0.2 * rate_hz)), log)
    known = LegUncertainty(leg, markers, sources, motion)
    factor = float(coverage_factor(np.inf, confidence))
    result, quantities, _ = fit_record(name, record, known, confidence=confidence, factor=factor)
    fit = ImpedanceFit(
        estimator=name,
        quantities=quantities,
        vaf=result.vaf_angle,
        vaf_of="the angle over the trial, from rest",
        confidence=confidence,
        curve=Curve(time, result.angle, result.simulated, "Angle (rad)", shaded(time, windows)),
        details=result,
        windows=result.parameters,
        type_b=tuple(sources),
    )
    found = notes.of_impedance(fit, motion) + notes.of_delay(result.delay_s)
    on_foot = record.markers.positions[:, record.markers.on_foot & ~record.markers.on_leg]
    found += notes.of_checks(of_likelihood(result, on_foot, windows, rate_hz, motion.layout_scale))
    found += notes.of_stiffness(quantities) + notes.of_markers(motion, record.at_rest, rate_hz)
    return replace(fit, notes=(*named, *follows, *found))


def _marked(hidden: object, shape: tuple[int, int]) -> np.ndarray:
    """Booleans of the hidden samples, shape (n, markers)."""
    try:
        filled = np.asarray(hidden)
        found = f"{filled.dtype} of shape {filled.shape}"
    except Exception:  # an object of another package may raise anything when it is converted
        filled, found = np.empty(0), f"{type(hidden).__name__} that is no array"
    if filled.dtype != bool or filled.shape != shape:
        raise InputError(
            f"hidden: expected booleans of shape {shape}, one for each sample of each marker, found {found}: "
            "give them in the order of positions"
        )
    return filled
