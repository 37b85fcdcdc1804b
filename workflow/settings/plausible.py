"""Limits of what the signals of a trial can be."""

from workflow.settings.quantities import (
    Fraction,
    Positive,
    Time,
    band,
    number,
)
from workflow.settings.section import Section, setting

Limit = float


class Plausible(Section):
    """Limits of what the signals of a trial can be."""

    rate_hz: band() = setting("sampling rate of a trial")
    belt_velocity_m_per_s: band(Limit) = setting("measured and commanded velocity of a belt")
    belt_acceleration_m_per_s2: band(Limit) = setting("its difference from sample to sample")
    marker_position_m: band(Limit) = setting("every coordinate of a marker")
    marker_speed_m_per_s: Positive = setting("highest speed of a marker from sample to sample")
    force_N: band(Limit) = setting("force components of a force plate, load of a treadmill")
    moment_Nm: band(Limit) = setting("moments of a force plate, load of a treadmill")
    angle_rad: band(Limit) = setting("angle of a joint in a manipulator")
    torque_Nm: band(Limit) = setting("torque of a joint in a manipulator")
    joint_speed_rad_per_s: Positive = setting(
        "angular velocity of this joint, which one sample in 1000 may exceed: a human ankle in a manipulator "
        "reaches 3 rad/s, an angle in degrees that is read in rad far more"
    )
    torque_per_angle_Nm_per_rad: band() = setting(
        "standard deviation of this torque over that of the angle. The torque must also do positive work "
        "on the joint, otherwise one of the two has the wrong sign"
    )
    emg_uV: band(Limit) = setting("raw electromyogram")
    frozen_s: Time = setting(
        "longest stretch of identical samples of a marker, or of the force plate under the foot, weight "
        "or person. In real recordings 0.04 s were found. Quantised channels, whose usual step is about "
        "their smallest, are exempt. In a trial of a standing person frozen stretches count as hidden, so "
        "that their perturbations are omitted"
    )
    belt_fixed_correlation: Fraction = setting(
        "lowest correlation of the velocities of a belt-fixed marker and of the belt"
    )
    belt_fixed_scale: band(number(least=0, most=10)) = setting("ratio of these velocities")
    belt_fixed_delay_s: Time = setting("longest delay between them")
    accelerated_fraction: number(least=-10, most=1) = setting(
        "lowest share of the mass on the belt that the fore-aft force accelerates with it: at least the feet"
    )
    mass_fraction: number(above=0, most=1) = setting(
        "largest relative error of the mass of weight or dummy on the plate. That of a person is compared in "
        "the same way, while the person stands still"
    )
    plate_offset_kg: number(least=0, most=500) = setting("error that is accepted for light masses")
