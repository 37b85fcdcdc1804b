"""Constants of the virtual laboratory in words and units: what the report prints instead of their keys."""

# endings of keys -> unit as text shows it, the longest first
UNITS = {
    "_Nm_per_rad3": "N·m/rad³",
    "_Nms_per_rad": "N·m·s/rad",
    "_Nm_per_rad": "N·m/rad",
    "_rad_per_Nm": "rad/(N·m)",
    "_m_per_rad": "m/rad",
    "_s_per_rad": "s/rad",
    "_m_per_s2": "m/s²",
    "_per_m": "1/m",
    "_kgm2": "kg·m²",
    "_ppm": "10⁻⁶",
    "_rad": "rad",
    "_kg": "kg",
    "_hz": "Hz",
    "_Nm": "N·m",
    "_m": "m",
    "_s": "s",
}
# constant that measures a mechanism -> what it is
MEASURES = {
    "treadmill.plate.bristle_share": "part of the friction",
    "treadmill.plate.friction_lever_m": "lever about the plate's axis",
    "treadmill.plate.belt_lag_wander": "variation, relative to the lag",
    "treadmill.plate.second_share": "part of force, part of moment",
    "treadmill.plate.mount_share": "part of a fast force",
    "treadmill.plate.floor_m_per_s2": "acceleration",
    "dummy.rubber.softening": "part of the stiffness that is lost",
    "dummy.rubber.relaxation_share": "part of the stiffness",
    "dummy.foot_tilt.compliance_rad_per_Nm": "tilt per moment",
    "dummy.wobble.growing_per_m": "bending, relative to the height",
    "dummy.wobble.common": "part of the marker's motion",
    "dummy.slip.foot_m": "slip",
    "dummy.slip.ankle_m": "slip",
    "standing.skin.shank_share": "part of the segment's motion",
    "standing.skin.thigh_share": "part of the segment's motion",
    "standing.skin.slip_m_per_rad": "slip per rotation",
    "standing.person.foot_stiffness_Nm_per_rad": "stiffness",
    "standing.tasks.relax.short_range_Nm_per_rad": "stiffness, both ankles",
    "standing.tasks.stiff.short_range_Nm_per_rad": "stiffness, both ankles",
    "standing.tasks.relax.medium_reflex_s_per_rad": "gain of TA, SOL, GAS, BF, RF",
    "standing.tasks.stiff.medium_reflex_s_per_rad": "gain of TA, SOL, GAS, BF, RF",
    "standing.nerves.relaxation_s": "time constant",
    "wristalyzer.manipulator.friction_Nm": "Coulomb friction",
    "wristalyzer.manipulator.contact_Nm_per_rad3": "torque per angle cubed",
    "wristalyzer.manipulator.ripple_Nm": "torque",
}
# constant that is drawn -> what it is
DRAWN = {
    "dummy.subject.leg_mass_kg": "mass of the leg",
    "dummy.subject.leg_com_m": "centre of mass of the leg, from the joint",
    "dummy.subject.leg_inertia_kgm2": "moment of inertia of the leg",
    "dummy.subject.foot_mass_kg": "mass of the foot",
    "dummy.subject.foot_com_m": "centre of mass of the foot, forwards and up",
    "dummy.subject.joint_offset_m": "place of the joint's axis, forwards and up",
    "dummy.subject.rest_angle_rad": "angle of the leg at rest",
    "dummy.markers.foot_m": "markers of the foot",
    "dummy.markers.ankle_m": "marker of the ankle",
    "dummy.markers.leg_m": "markers of the leg",
    "weight.mass_kg": "mass of the weight",
    "heavy_weight.mass_kg": "mass of the heavy weight",
    "wristalyzer.manipulator.torque_scale": "true over commanded torque",
    "wristalyzer.manipulator.angle_scale": "measured over true angle",
    "wristalyzer.manipulator.torque_delay_s": "delay of the torque after its command",
    "treadmill.plate.force_scale": "measured over true force, fore-aft and vertical",
    "treadmill.plate.vertical_leak": "part of the vertical force in the fore-aft force",
    "treadmill.plate.origin_height_m": "height of the plate's origin above the belt",
    "treadmill.capture.latency_s": "delay of the motion capture",
    "treadmill.capture.clock_ppm": "clock of the motion capture, faster by",
    "treadmill.capture.length_scale": "measured over true lengths",
    "treadmill.capture.vertical_rad": "lean of an upright rod in the motion capture",
    "treadmill.capture.marker_sampling_hz": "frequency of sampling, marker after marker",
    "standing.person.mass_kg": "mass of the body",
    "standing.person.foot_mass": "mass of a foot, relative to the body's",
    "standing.person.shank_mass": "mass of a shank, relative to the body's",
    "standing.person.thigh_mass": "mass of a thigh, relative to the body's",
    "standing.person.foot_com_m": "centre of mass of the feet, forwards of the ankle",
    "standing.person.foot_stiffness_Nm_per_rad": "stiffness of heel pads and arches",
    "standing.person.forefoot_share": "rotation of the forefoot, relative to the hindfoot's",
    "standing.person.marked_share": "part of the torque in the leg with markers",
    "standing.person.marked_rotation": "rotation of the leg with markers, relative to the mean",
    "standing.person.short_range_rad": "end of the short range",
    "standing.markers.joint_centre_m": "axis of the ankle from its marker",
    "standing.markers.foot_m": "markers of the foot",
    "standing.markers.shank_m": "markers of the shank",
    "standing.markers.thigh_m": "markers of the thigh",
    "standing.skin.frequency_hz": "frequency of soft tissue",
    "standing.skin.shank_share": "motion of the shank's skin, relative to the bone's",
    "standing.skin.thigh_share": "motion of the thigh's skin, relative to the bone's",
    "standing.skin.slip_m_per_rad": "slip of the ankle's skin per rotation",
    "standing.nerves.twitch_s": "time constant of a twitch",
    "standing.nerves.relaxation_s": "time constant of relaxation",
}
SECTIONS = {
    "wristalyzer": "Wristalyzer",
    "dummy": "Dummy",
    "weight": "Weights",
    "heavy_weight": "Weights",
    "treadmill": "Treadmill and motion capture",
    "standing": "Standing person",
}


def unit_of(key: str) -> str:
    """Unit of a constant as text shows it, from the end of its key; empty for a ratio (no unit)."""
    return next((unit for ending, unit in UNITS.items() if key.endswith(ending)), "")


def words_of(key: str) -> str:
    """What a constant is; for one without an entry, its key's last word without the unit (no unit)."""
    if key in DRAWN:
        return DRAWN[key]
    last = key.rpartition(".")[2]
    ending = next((ending for ending in UNITS if last.endswith(ending)), "")
    return last.removesuffix(ending).replace("_", " ")


def section_of(key: str) -> str:
    """The part of the laboratory to which a constant belongs (no unit)."""
    return SECTIONS.get(key.partition(".")[0], key.partition(".")[0])
