"""Uncertainty of I, B, K of the ankle dummy from the motion of its leg, source by source.

*From a torque* (windowed least squares). The torque is linear in m, m r and I_l, so central differences are
exact for these. Because the leg is rigid, a wrong layout of the markers has two effects only: it shifts the
measured angle by a constant c, and the assumed centre of mass by (a, l) in the axes of the leg,

    y'' -> y'' + (a cos theta + l sin theta)'',    z'' -> z'' + (l cos theta - a sin theta)''

A rod that bends lags behind the acceleration a of its foot by c a in angle, and its centre of mass by r c a.

*From the angle over the trial* (output error, joint likelihood). The equation of motion is homogeneous in J,
B, K and p = m r, so all three are proportional to p, and I = J - I_l - m r^2. With lengths that are s times
too large and a clock that runs a times too fast,

    J -> s J,    B -> s B / a,    K -> k_g + s (K - k_g) / a^2,    k_g = m g r

Offsets of markers and delays change the angle at rest and the delay, which are estimated. Sources that move
markers against each other act on the joint likelihood by `tepsipe.identification.budgets.markers`. All
derivatives are of the result of the analysis with respect to the value of the source.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.errors import refuse_other_kind
from tepsipe.identification.likelihood.result import LikelihoodEstimates
from tepsipe.identification.regression.windows import WindowedFits
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.mechanics.segment_kinematics import SegmentMarkers, SegmentMotion, fit_rigid_segment
from tepsipe.signals.differentiation import derivative
from tepsipe.statistics.uncertainty import Budget, Source, linear_contributions

LEG_SOURCES = (
    "leg_mass_kg",
    "leg_com_m",
    "leg_inertia_kgm2",
    "joint_offset_m",
    "anterior_offset_m",
    "longitudinal_offset_m",
    "vertical_rad",
    "marker_scale",
    "clock_ratio",
    "marker_sampling_s",
    "foot_compliance_rad_per_Nm",
    "leg_bending_rad_per_m_per_s2",
)
# sources of the joint likelihood alone
LIKELIHOOD_SOURCES = ("levelled_rad",)
KNOWN_OF_LEGS = (*LEG_SOURCES, *LIKELIHOOD_SOURCES)
ANTERIOR, LONGITUDINAL = "anterior", "longitudinal"
# offsets of the markers, in the order of the columns of a layout
OFFSETS = ("anterior_offset_m", "longitudinal_offset_m")


@dataclass(frozen=True)
class LegUncertainty:
    """Leg and markers as an analysis assumes them, with their uncertainty.

    Names of the sources, each with its standard uncertainty in the unit of its name: ``leg_mass_kg``,
    ``leg_com_m``, ``leg_inertia_kgm2``; ``joint_offset_m`` of the axis, along the belt and in height;
    ``anterior_offset_m`` and ``longitudinal_offset_m`` of every marker; ``vertical_rad`` of the direction of
    gravity; ``marker_scale`` and ``clock_ratio`` of the motion capture (relative); ``marker_sampling_s`` from
    one marker to the next; ``levelled_rad`` of the axes after levelling; ``foot_compliance_rad_per_Nm``;
    ``leg_bending_rad_per_m_per_s2``.

    Attributes
    ----------
    leg : Leg
        The leg (kg, m, kg·m²).
    markers : SegmentMarkers or None
        Its markers (m); None if no source concerns them.
    sources : mapping of str to Source, or to float for `fit_impedance`
        Uncertain constants; none if Type B is not evaluated.
    motion, sampled_later : SegmentMotion
        As it was found, and as it is with a time between markers that is longer by its standard uncertainty
        (s, rad, m); None if that time does not act. Without ``sampled_later``, `fit_impedance` ignores
        ``marker_sampling_s``.
    foot : Foot, optional
        The foot (kg, m), whose inertia tilts it on a compliant belt; without it, only the joint does.

    Raises
    ------
    InputError
        If leg, markers or motion are something else.

    Examples
    --------
    >>> from tepsipe import LegUncertainty, fit_impedance, joint_torque, load_example, segment_motion
    >>> dummy = load_example("dummy")
    >>> motion = segment_motion(
    ...     dummy.time, dummy.positions, dummy.markers, dummy.leg.com_m, labels=dummy.labels
    ... )
    >>> known = LegUncertainty(
    ...     leg=dummy.leg, markers=dummy.markers, motion=motion, sources={"leg_mass_kg": 0.004}
    ... )
    >>> fit = fit_impedance(
    ...     dummy.time,
    ...     motion.theta,
    ...     joint_torque(motion, dummy.leg),
    ...     perturbations=dummy.perturbations,
    ...     cutoff_hz=None,  # the motion is filtered already
    ...     uncertainty=known,
    ... )
    >>> fit.type_b
    ('leg_mass_kg',)
    """

    leg: Leg
    markers: SegmentMarkers | None
    sources: Mapping[str, Source]
    motion: SegmentMotion
    sampled_later: SegmentMotion | None = None
    foot: Foot | None = None

    def __post_init__(self) -> None:
        place = "LegUncertainty"
        refuse_other_kind(self.leg, Leg, place, "Leg")
        refuse_other_kind(self.motion, SegmentMotion, place, "segment_motion")
        if self.markers is not None:
            refuse_other_kind(self.markers, SegmentMarkers, place, "SegmentMarkers")


def compliance_contributions(
    values: Annotated[np.ndarray, "(3,)"], sources: Mapping[str, Source]
) -> dict[str, np.ndarray]:
    """Contribution of a compliant foot to I, B, K, shape (1, 3); empty without this source.

    A compliance c in series turns Z = I s^2 + B s + K into Z / (1 + c Z), to first order Z - c Z^2:

        I -> I - c (B^2 + 2 K I),    B -> B - 2 c K B,    K -> K - c K^2

    sources: uncertain constants; c in rad/Nm.
    Returns: for `Budget.contributions`.
    """
    if "foot_compliance_rad_per_Nm" not in sources:
        return {}
    inertia, damping, stiffness = values
    slope = np.array([damping**2 + 2.0 * stiffness * inertia, 2.0 * stiffness * damping, stiffness**2])
    c = sources["foot_compliance_rad_per_Nm"].standard_uncertainty
    return {"foot_compliance_rad_per_Nm": -c * slope[None]}


def driven_tilt_contributions(
    fit: WindowedFits, leg: Leg, foot: Foot, sources: Mapping[str, Source]
) -> dict[str, np.ndarray]:
    """Contribution of a compliant foot to I, B, K of windows of a perturbation, shape (1, 3).

    Inertia tilts the foot, too, by psi = c (K theta + B theta' - a y_f'' - m h r theta''), with its height h
    and a = m_f h / 2 + m h. The equation of motion, -m r y_f'' = J theta'' + B theta' + (K - m g r) theta,
    replaces y_f'', so that psi = c (K_1 theta + B_1 theta' + D theta'') with

        K_1 = K + (a / m r) (K - m g r),    B_1 = (1 + a / m r) B,    D = (a / m r) J - m h r

    The joint bends by theta - psi. In a window the third derivative is nearly -w^2 theta', therefore

        I -> I - c (K D + B B_1),    B -> B - c (K B_1 + B K_1 - B D w^2),    K -> K - c K K_1

    The last term of B dominates in short pulses. Takes the arguments of `leg_budget`, with the leg and the
    foot (kg, m, kg·m²); empty without this source.
    """
    if "foot_compliance_rad_per_Nm" not in sources:
        return {}
    inertia, damping, stiffness = fit.mean
    p = leg.mass_kg * leg.com_m
    share = (0.5 * foot.mass_kg + leg.mass_kg) * foot.height_m / p
    about_ankle = leg.inertia_kgm2 + p * leg.com_m + inertia
    stiffness_1 = stiffness + share * (stiffness - p * leg.gravity_m_per_s2)
    damping_1 = (1.0 + share) * damping
    driven = share * about_ankle - p * foot.height_m
    slope = np.array(
        [
            stiffness * driven + damping * damping_1,
            stiffness * damping_1 + damping * stiffness_1 - damping * driven * fit.squared_rate,
            stiffness * stiffness_1,
        ]
    )
    c = sources["foot_compliance_rad_per_Nm"].standard_uncertainty
    return {"foot_compliance_rad_per_Nm": -c * slope[None]}


def leg_budget(
    fit: WindowedFits,
    reestimate: Callable[[SegmentMotion, Leg], np.ndarray] | None,
    known: LegUncertainty,
    further: Mapping[str, np.ndarray] | None = None,
) -> Budget:
    """Uncertainty of the means of I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad).

    reestimate: estimates them, shape (3,), from another motion and leg; None if they come from the angle
    over the whole trial.
    known: assumed leg, with its uncertainty.
    further: contributions of other sources to I, B, K.
    Returns: type A and one entry per source that acts.
    """
    if not known.sources:
        contributions = {}
    elif reestimate is None:
        contributions = angle_contributions(fit.mean, known.leg, known.sources)
    else:
        contributions = torque_contributions(reestimate, known)
    if reestimate is None or known.foot is None:
        contributions |= compliance_contributions(fit.mean, known.sources)
    else:
        contributions |= driven_tilt_contributions(fit, known.leg, known.foot, known.sources)
    contributions |= dict(further or {})
    freedom = {name: known.sources[name].freedom for name in contributions}
    return Budget(*fit.type_a, contributions, freedom)


def small_budget(
    fit: LikelihoodEstimates, leg: Leg, sources: Mapping[str, Source], further: Mapping[str, np.ndarray]
) -> Budget:
    """Uncertainty of I, B, K of small movements (N·m·s²/rad, N·m·s/rad, N·m/rad), as `leg_budget`."""
    contributions = angle_contributions(fit.small, leg, sources) if sources else {}
    contributions |= compliance_contributions(fit.small, sources) | dict(further)
    freedom = {name: sources[name].freedom for name in contributions}
    return Budget(np.sqrt(np.diag(fit.small_covariance)), np.inf, contributions, freedom)


def changed_leg(leg: Leg, deviations: Mapping[str, float]) -> Leg:
    """The leg (kg, m, kg·m²) with deviations of its sources."""
    return replace(
        leg,
        mass_kg=leg.mass_kg + deviations.get("leg_mass_kg", 0.0),
        com_m=leg.com_m + deviations.get("leg_com_m", 0.0),
        inertia_kgm2=leg.inertia_kgm2 + deviations.get("leg_inertia_kgm2", 0.0),
    )


def marker_sources(markers: SegmentMarkers, sources: Mapping[str, Source]) -> list[Source]:
    """One source per marker of the leg and direction (m), named source/label."""
    return [
        replace(sources[name], name=f"{name}/{label}")
        for name in OFFSETS
        if name in sources
        for label in markers.labels
    ]


def of_layout(markers: SegmentMarkers, com_m: float, deviations: Mapping[str, float]) -> np.ndarray:
    """Constants c (rad), a and l (m) for deviations of `marker_sources` (m), shape (3,)."""
    layout = markers.layout_m.copy()
    for name, deviation in deviations.items():
        kind, _, label = name.partition("/")
        if kind in OFFSETS:
            layout[markers.labels.index(label), OFFSETS.index(kind)] += deviation
    if np.array_equal(layout, markers.layout_m):
        return np.zeros(3)
    pose = fit_rigid_segment(markers.layout_m[None], layout, np.array([0.0, com_m]))
    return np.array([pose.angle[0], pose.point[0, 0], pose.point[0, 1] - com_m])


def changed_motion(
    motion: SegmentMotion, markers: SegmentMarkers, com_m: float, deviations: Mapping[str, float]
) -> SegmentMotion:
    """Motion of the leg (s, rad, m) as estimated with deviations of the sources.

    com_m: distance of the centre of mass from the ankle.
    deviations: names of `LEG_SOURCES` and of `marker_sources`, joint_offset_m with its direction after a
    slash (units in the names). marker_sampling_s is not among them.
    """
    turned, a, b = of_layout(markers, com_m, deviations)
    a += deviations.get(f"joint_offset_m/{ANTERIOR}", 0.0)
    b += deviations.get(f"joint_offset_m/{LONGITUDINAL}", 0.0) + deviations.get("leg_com_m", 0.0)
    # excessive lengths move the markers but not their layout, from whose centre the point is computed
    wider = deviations.get("marker_scale", 0.0)
    centre = markers.layout_m.mean(axis=0)
    a, b = a + wider * centre[0], b - wider * (com_m - centre[1])
    motion = _bent(motion, com_m, deviations.get("leg_bending_rad_per_m_per_s2", 0.0))
    sine, cosine = np.sin(motion.theta), np.cos(motion.theta)
    along, radial = motion.theta_dd, motion.theta_d**2
    y_dd = motion.y_dd + a * (-sine * along - cosine * radial) + b * (cosine * along - sine * radial)
    z_dd = motion.z_dd + a * (-cosine * along + sine * radial) + b * (-sine * along - cosine * radial)
    tilt = deviations.get("vertical_rad", 0.0)
    slower = 1.0 / (1.0 + deviations.get("clock_ratio", 0.0))
    larger = (1.0 + wider) * slower**2
    return replace(
        motion,
        theta=motion.theta + turned + tilt,
        theta_d=motion.theta_d * slower,
        theta_dd=motion.theta_dd * slower**2,
        y_dd=larger * (y_dd * np.cos(tilt) + z_dd * np.sin(tilt)),
        z_dd=larger * (z_dd * np.cos(tilt) - y_dd * np.sin(tilt)),
    )


def _bent(motion: SegmentMotion, com_m: float, lag: float) -> SegmentMotion:
    """Motion (s, rad, m) measured by markers on a rod that lags its foot by an angle (rad per m/s²)."""
    if lag == 0.0:
        return motion
    sine, cosine = np.sin(motion.theta), np.cos(motion.theta)
    foot_dd = motion.y_dd - com_m * (cosine * motion.theta_dd - sine * motion.theta_d**2)
    jerk = derivative(motion.time, foot_dd)
    snap = derivative(motion.time, jerk)
    return replace(
        motion,
        theta=motion.theta + lag * foot_dd,
        theta_d=motion.theta_d + lag * jerk,
        theta_dd=motion.theta_dd + lag * snap,
        y_dd=motion.y_dd + com_m * lag * snap,
    )


def by_source(contributions: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Contributions of the parts of a source, source/part, as rows of the source, (k, 3) (same units)."""
    rows: dict[str, list[np.ndarray]] = {}
    for name, values in contributions.items():
        rows.setdefault(name.partition("/")[0], []).append(values)
    return {name: np.concatenate(parts) for name, parts in rows.items()}


def torque_contributions(
    reestimate: Callable[[SegmentMotion, Leg], np.ndarray], known: LegUncertainty
) -> dict[str, np.ndarray]:
    """Contribution of each source to I, B, K from a torque of the leg.

    Takes the arguments of `leg_budget`. The result is for `Budget.contributions`, one row per
    marker and direction.
    """
    sources, leg = known.sources, known.leg
    separate = ("joint_offset_m", "marker_sampling_s", "foot_compliance_rad_per_Nm", *OFFSETS)
    parts = [source for name, source in sources.items() if name in LEG_SOURCES and name not in separate]
    if "joint_offset_m" in sources:
        offset = sources["joint_offset_m"]
        parts += [replace(offset, name=f"joint_offset_m/{d}") for d in (ANTERIOR, LONGITUDINAL)]
    parts += marker_sources(known.markers, sources)
    contributions = linear_contributions(
        lambda deviations: reestimate(
            changed_motion(known.motion, known.markers, leg.com_m, deviations), changed_leg(leg, deviations)
        ),
        parts,
    )
    if known.sampled_later is not None:
        contributions["marker_sampling_s"] = (
            reestimate(known.sampled_later, leg) - reestimate(known.motion, leg)
        )[None]
    return by_source(contributions)


def angle_contributions(
    values: Annotated[np.ndarray, "(3,)"], leg: Leg, sources: Mapping[str, Source]
) -> dict[str, np.ndarray]:
    """Exact contribution of each source to I, B, K from the angle over the whole trial.

    Returns: for `Budget.contributions`.
    """
    about_ankle = leg.inertia_kgm2 + leg.mass_kg * leg.com_m**2
    p = leg.mass_kg * leg.com_m

    def estimate(deviations: Mapping[str, float]) -> np.ndarray:
        other = changed_leg(leg, deviations)
        scale = other.mass_kg * other.com_m / p
        length = 1.0 + deviations.get("marker_scale", 0.0)
        rate = 1.0 + deviations.get("clock_ratio", 0.0)
        critical = scale * p * leg.gravity_m_per_s2
        inertia = scale * length * (values[0] + about_ankle)
        return np.array(
            [
                inertia - other.inertia_kgm2 - other.mass_kg * other.com_m**2,
                scale * length * values[1] / rate,
                critical + length * (scale * values[2] - critical) / rate**2,
            ]
        )

    acting = ("leg_mass_kg", "leg_com_m", "leg_inertia_kgm2", "marker_scale", "clock_ratio")
    return linear_contributions(estimate, [sources[name] for name in acting if name in sources])
