"""How well the analysis knows what it takes as known: sources of Type B uncertainty."""

from tepsipe.statistics import uncertainty
from workflow.settings.section import Section, made_from, setting


class Source(made_from(uncertainty.Source, without=("name",), absent=("freedom",))):
    """A source of uncertainty; null switches it off."""

    unfolded = False


class WristalyzerSources(Section):
    """Sources of the joint in the manipulator."""

    torque_scale: Source | None = setting("true over commanded torque")
    angle_scale: Source | None = setting("reading over true angle")
    torque_delay_s: Source | None = setting(
        "delay of the torque after its record; the regressions estimate it"
    )


class DummySources(Section):
    """Sources of the dummy on the treadmill."""

    leg_mass_kg: Source | None = setting("leg, of `dummy.geometry`")
    leg_com_m: Source | None = setting("the same")
    leg_inertia_kgm2: Source | None = setting("the same")
    joint_offset_m: Source | None = setting(
        "place of the joint's axis, along the belt and, independently, in height"
    )
    anterior_offset_m: Source | None = setting(
        "place of each marker of the leg across it, independent of the others"
    )
    longitudinal_offset_m: Source | None = setting("the same along the leg")
    vertical_rad: Source | None = setting("direction of gravity in the axes of the motion capture")
    marker_scale: Source | None = setting("all lengths of the motion capture")
    clock_ratio: Source | None = setting("rate of the motion capture")
    marker_sampling_s: Source | None = setting("time from one marker to the next within a frame")
    levelled_rad: Source | None = setting(
        "axes of the joint likelihood after levelling by the direction of the belt"
    )
    leg_bending_rad_per_m_per_s2: Source | None = setting(
        "angle by which the leg, which bends, lags behind the acceleration of the foot"
    )
    foot_mass_kg: Source | None = setting("foot, of `dummy.geometry`")
    foot_com_m: Source | None = setting("height of its centre of mass")
    foot_compliance_rad_per_Nm: Source | None = setting(
        "compliance of the foot on the belt, in series with the joint"
    )
    force_scale: Source | None = setting(
        "fore-aft force and, independently, vertical forces and their moment"
    )
    vertical_leak: Source | None = setting("part of the vertical force in the fore-aft one")
    origin_height_m: Source | None = setting("height of the plate's axes")
    log_delay_s: Source | None = setting(
        "delay of the logged belt velocity, by which the markers are aligned, after the forces"
    )


class WeightSources(Section):
    """Sources of the weight on the treadmill."""

    force_scale: Source | None = setting("fore-aft force")
    marker_scale: Source | None = setting("lengths of the motion capture")
    belt_force_ratio: Source | None = setting(
        "belt-induced force in phase with the acceleration, relative to the weight's own: it grows with "
        "the load"
    )


class StandingSources(Section):
    """Sources of estimators of the standing person with `active: free`, and of latencies."""

    joint_centre_anterior_m: Source | None = setting("centre of the ankle that quiet sway shows")
    joint_centre_height_m: Source | None = setting("the same")
    palpated_centre_m: Source | None = setting("the same in both directions, where quiet sway shows none")
    foot_mass: Source | None = setting("mass and moment of inertia of the feet")
    force_marker_delay_s: Source | None = setting(
        "delay of the forces after the markers, once these are aligned with the belt"
    )
    skin_m: Source | None = setting(
        "motion of soft tissue at a pulse of 0.5 m/s, beyond what the markers of the shank show, which is "
        "corrected"
    )
    tissue_hz: Source | None = setting(
        "natural frequency of that tissue, taken as 12 Hz: its size in the trial and its correction "
        "follow from it"
    )
    marked_rotation: Source | None = setting("rotation of the leg with markers over the mean of both")
    foot_markers_m: Source | None = setting(
        "place of each marker of the foot, for the rotation of the hindfoot that pulses show"
    )
    foot_rotation: Source | None = setting(
        "rotation of the hindfoot over what the markers of the foot show if the forefoot rotates half as "
        "much; of the rotation, which is small. The pulses of a person are weighed against it, and replace "
        "it where heel and toe markers determine the rotation"
    )
    force_scale: Source | None = setting("fore-aft and vertical force")
    moment_scale: Source | None = setting("moment of the vertical force")
    origin_height_m: Source | None = setting("height of the plate's axes")
    origin_anterior_m: Source | None = setting(
        "place of the plate's axes along the belt, where resting weights show it"
    )
    unknown_origin_m: Source | None = setting("the same where they do not")
    vertical_leak: Source | None = setting("part of the vertical force in the fore-aft one")
    model_discrepancy: Source | None = setting(
        "part of `standing.free_reflex.discrepancy` that all trials share"
    )
    reflex_onset_s: Source | None = setting("earliest instant of the reflex torque")
    joint_yield: Source | None = setting(
        "share of the largest hysteresis of the joint, whose stiffness falls with the rotation to the power "
        "−0.33: half of it is removed from the reflex torque; null removes none"
    )
    latency_s: Source | None = setting(
        "latency of every muscle, from the start of the belt to a stretch that can be felt"
    )


class Uncertainty(Section):
    """Sources of every experiment."""

    wristalyzer: WristalyzerSources
    dummy: DummySources
    weight: WeightSources
    standing: StandingSources
