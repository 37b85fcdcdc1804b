"""Constants of the virtual laboratory: the truth."""

from workflow.settings.quantities import (
    Angle,
    Damping,
    Fraction,
    Frequency,
    Gravity,
    Height,
    Inertia,
    Length,
    Mass,
    NotNegative,
    Offset,
    Pause,
    Positive,
    Rate,
    Stature,
    Stiffness,
    Time,
    fixed,
    number,
    some,
)
from workflow.settings.section import Section, optional, partial, setting

Point = fixed(Offset, 2)
Scale = number(above=0, most=10)
Lag = number(least=0, most=10)  # s
InertiaAboveZero = number(above=0, most=20)  # kg·m²


# ---- the dummy --------------------------------------------------------------------------------------------


class Rubber(Section):
    """Joint of the dummy, the same on the treadmill and in the Wristalyzer.

    [Decision 46](../docs/decisions/0046-dummy-of-the-thesis.md).
    """

    stiffness_Nm_per_rad: Stiffness = setting("stiffness for small bending")
    damping_Nms_per_rad: Damping = setting("damping for small bending")
    softening: NotNegative = setting("fraction of the stiffness that is lost at large bending, 0 to 1")
    softening_angle_rad: number(above=0, most=3.2) = setting("bending at which half of it is lost")
    softened_damping_Nms_per_rad: Damping = setting(
        "damping that is gained at large bending, half of it at the same angle"
    )
    relaxation_share: NotNegative = setting(
        "moment of a quick bending beyond that, as a fraction of the stiffness for small bending (0: none)"
    )
    relaxation_s: Time = setting("time in which it relaxes")


class Manipulator(Section):
    """The torque-controlled manipulator."""

    inertia_kgm2: InertiaAboveZero = setting("inertia of foot and handle about the joint")
    contact_Nm_per_rad3: NotNegative = setting(
        "hardening at large angles, where the rubber is pressed against the brick", unit="N·m/rad³"
    )
    friction_Nm: NotNegative = setting("Coulomb friction of the drive train")
    friction_rate_rad_per_s: Positive = setting("rate at which it saturates")
    ripple_Nm: NotNegative = setting("torque ripple: root mean square")
    ripple_bandwidth_hz: Frequency = setting("its bandwidth")
    torque_per_factor_Nm: number(above=0, most=5000) = setting(
        "root mean square of the multisine per unit of scale factor"
    )
    torque_scale: Scale = setting("true over commanded torque")
    angle_scale: Scale = setting("reading over true angle")
    torque_delay_s: number(least=-1, most=1) = setting("delay of the torque after its command")
    band_low_hz: Frequency = setting("lowest component of the multisine")
    band_high_hz: Frequency = setting("highest component of the multisine")
    period_s: Time = setting("its period")
    command_rate_hz: Rate = setting("rate of the torque command")
    log_rate_hz: Rate = setting("mean rate of the log")
    log_jitter_s: Lag = setting("standard deviation of its instants")
    repeated_fraction: NotNegative = setting("fraction of the log's lines that repeat the preceding sample")
    missing_fraction: NotNegative = setting("fraction of the log's lines that are not written")
    encoder_step_rad: number(above=0, most=3.2) = setting("resolution of the angle")
    encoder_zero_rad: Angle = setting("its reading at rest")
    lead_s: Pause = setting("time logged before the trigger")
    tail_s: Pause = setting("time logged after the command")


class WristalyzerLab(Section):
    """The manipulator."""

    manipulator: Manipulator


class Subject(Section):
    """Brick and rod."""

    foot_mass_kg: Mass = setting("the brick: mass")
    foot_height_m: Length = setting(
        "height of the point from which markers are placed, where the analysis takes the joint to be"
    )
    foot_com_m: Point = setting("its centre of mass: [forward of that point, above the belt]")
    joint_offset_m: Point = setting("axis of the joint: [forward of that point, above it]")
    leg_mass_kg: Mass = setting("the rod: mass")
    leg_com_m: Length = setting("its centre of mass from the joint")
    leg_inertia_kgm2: InertiaAboveZero = setting("its inertia about the centre of mass")
    joint_inertia_kgm2: Inertia = setting("inertia of the joint, which turns with the rod")
    rest_angle_rad: Angle = setting("angle at which the leg stands still, as the motion capture sees it")
    position_x_m: Offset = setting("position of the foot on the plate, across the belt")
    position_y_m: Offset = setting("position of the foot on the plate, along the belt")
    gravity_m_per_s2: Gravity = setting("gravity")


class DummyMarkers(Section):
    """Markers of the dummy."""

    foot_m: some(Point) = setting("three markers: [anterior offset from the ankle, height above the belt]")
    ankle_m: Point = setting("[anterior offset from the axis of the rod, longitudinal offset from the ankle]")
    leg_m: some(Point) = setting("four markers, in the same axes")
    lateral_m: Offset = setting("position of all markers across the belt, from the foot's middle")


class FootTilt(Section):
    """The foot tilts on tape and belt."""

    compliance_rad_per_Nm: NotNegative = setting("tilt per moment; 0 is a foot that does not tilt")
    damping_ratio: NotNegative = setting("damping ratio of the tilt")
    foot_inertia_kgm2: InertiaAboveZero = setting("moment of inertia of the foot about its centre of mass")


class Wobble(Section):
    """The leg bends, or its markers wobble, as a mass on a spring that the belt accelerates."""

    hz: Frequency = setting("natural frequency", unit="Hz")
    damping: NotNegative = setting("damping ratio")
    common: float = setting(
        "fraction of the mass's displacement by which all markers of the leg move; 0 in both is a rigid leg"
    )
    growing_per_m: float = setting("the same per distance from the joint", unit="1/m")


class Slip(Section):
    """The tape of a marker gives in every pulse, by a random step that stays."""

    foot_m: Height = setting(
        "standard deviation of the step of the markers on the foot; 0 is a marker that holds"
    )
    ankle_m: Height = setting("the same of the marker on the ankle")
    settling_s: Time = setting("time constant of a step")


class DummyLab(Section):
    """The dummy."""

    rubber: Rubber
    subject: Subject
    markers: DummyMarkers
    foot_tilt: FootTilt
    wobble: Wobble
    slip: Slip


class WeightLab(Section):
    """Rigid cuboid, taped to the belt, with a marker in every upper corner.

    The heavy one lies on the belt in trials whose row names a mass.
    """

    mass_kg: Mass = setting("mass")
    width_m: Length = setting("dimension across the belt")
    length_m: Length = setting("dimension along the belt")
    height_m: Length = setting("dimension above the belt")
    com_height_m: Height = setting("height of the centre of mass above the belt")
    position_x_m: Offset = setting("position on the plate, across the belt")
    position_y_m: Offset = setting("position on the plate, along the belt")
    gravity_m_per_s2: Gravity = setting("gravity")


# ---- the standing person ----------------------------------------------------------------------------------


class PersonLab(Section):
    """Four rigid bodies: feet, shanks, thighs, upper body; lengths follow from the stature.

    What violates an assumption of the analysis is listed, with its sources, in
    [decision 48](../docs/decisions/0048-mechanisms-of-the-person.md); 0 switches it off.
    """

    mass_kg: Mass = setting("mass of the whole body")
    stature_m: Stature = setting("stature")
    ankle_height_m: number(above=0, most=0.3) = setting("height of the ankle above the belt")
    foot_com_m: number(least=-0.3, most=0.3) = setting("anterior offset of the feet's centre of mass")
    stance_rad: fixed(Angle, 3) = setting(
        "angles of shanks, thighs and upper body from the vertical in quiet standing"
    )
    position_x_m: Offset = setting("position of the ankles on the plate, across the belt")
    position_y_m: Offset = setting("position of the ankles on the plate, along the belt")
    gravity_m_per_s2: Gravity = setting("gravity")
    foot_mass: number(above=0, most=0.05) = setting("each foot, as a fraction of the body's mass")
    shank_mass: number(above=0, most=0.1) = setting("each shank")
    thigh_mass: number(above=0, most=0.25) = setting("each thigh; the upper body has the rest")
    short_range_rad: number(above=0, most=3.2) = setting(
        "rotation of the ankle after which its short-range stiffness has yielded"
    )
    foot_stiffness_Nm_per_rad: number(least=0, most=20000) = setting(
        "stiffness of heel pads and arches of both feet against tilting on the belt; 0 makes the feet rigid"
    )
    foot_damping_Nms_per_rad: number(least=0, most=20) = setting("its damping")
    forefoot_share: Fraction = setting("tilt of the forefoot relative to that of the hindfoot")
    marked_share: number(above=0, below=1) = setting(
        "part of both ankles' torque that the marked leg bears; 0.5 for equal legs"
    )
    marked_rotation: number(above=0, below=2) = setting(
        "rotation of the marked shank relative to the mean of both; 1 for equal legs"
    )
    left_share: Fraction = setting(
        "part of the weight above the feet on the left leg, if each foot is on a plate of its own (`both` in "
        "the column `belt`)"
    )


class TaskLab(Section):
    """An instruction; joints in the order ankle, knee, hip, muscles in the order TA, SOL, GAS, BF, RF."""

    stiffness_Nm_per_rad: fixed(Stiffness, 3) = setting(
        "intrinsic stiffness, both legs; at the ankle that of large rotations"
    )
    short_range_Nm_per_rad: number(least=0, most=20000) = setting(
        "stiffness that is added at the ankles in small rotations"
    )
    damping_Nms_per_rad: fixed(Damping, 3) = setting("intrinsic damping, both legs")
    tone: fixed(NotNegative, 5) = setting("drive in quiet standing, as a fraction of the largest")
    reflex_s_per_rad: fixed(NotNegative, 5) = setting(
        "drive per stretch velocity of the short-latency reflex (M1)", unit="s/rad"
    )
    medium_reflex_s_per_rad: fixed(NotNegative, 5) = setting(
        "drive per stretch velocity of the medium-latency reflex (M2)", unit="s/rad"
    )


class Tasks(Section):
    """Instructions."""

    relax: TaskLab
    stiff: TaskLab


Latency = number(least=0.01, most=1)  # s


class MuscleLab(Section):
    """A muscle."""

    latency_s: Latency = setting("time from stretch to the short-latency reflex")
    medium_latency_s: Latency = setting("time from stretch to the medium-latency reflex")
    stretch: fixed(float, 3) = setting("lengthening per angle of ankle, knee and hip")
    force_Nm: fixed(number(least=-5000, most=5000), 3) = setting(
        "torque at full drive that resists the angles of ankle, knee and hip, both legs"
    )
    balance_per_Nm: fixed(float, 2) = setting(
        "drive per torque demanded by balance at the ankle: for positive and for negative torque",
        unit="1/(N·m)",
    )


class Muscles(Section):
    """Muscles."""

    TA: MuscleLab
    SOL: MuscleLab
    GAS: MuscleLab
    BF: MuscleLab
    RF: MuscleLab


class Nerves(Section):
    """Reflexes and balance."""

    reflex_threshold_rad_per_s: NotNegative = setting("threshold of the stretch velocity for a reflex")
    twitch_s: number(above=0, most=10) = setting("time constant of the twitch response: its rise")
    relaxation_s: Lag = setting("its fall; 0 stands for `twitch_s` (critically damped)")
    balance_delay_s: number(least=0.01, most=10) = setting("delay from the centre of mass to the drive")
    balance_Nm_per_rad: NotNegative = setting("torque demanded per lean of the centre of mass")
    balance_Nms_per_rad: NotNegative = setting("torque demanded per rate of this lean")
    wander_Nm: NotNegative = setting("random component of balance: standard deviation")
    wander_s: Time = setting("its correlation time")


class PersonMarkers(Section):
    """Markers of the person."""

    foot_m: fixed(Point, 2) = setting("two markers: [anterior offset from the ankle, height above the belt]")
    shank_m: fixed(Point, 2) = setting(
        "two markers: [anterior offset from the axis of the segment, longitudinal offset from its lower "
        "joint]; one more is on the ankle"
    )
    thigh_m: fixed(Point, 3) = setting("three markers, in the same way")
    lateral_m: Offset = setting("position of all markers across the belt, from the middle between the feet")
    joint_centre_m: Point = setting(
        "[forward, up] position of the ankle's axis relative to the ankle's marker"
    )


class Skin(Section):
    """The skin under the markers."""

    frequency_hz: Frequency = setting("natural frequency of the soft tissue of shank and thigh")
    damping: Positive = setting("its damping ratio")
    shank_share: Fraction = setting(
        "part of the soft tissue's motion in which the markers of the shank take part; 0 for markers "
        "fixed to the bone"
    )
    thigh_share: Fraction = setting("the same of the thigh")
    slip_m_per_rad: float = setting("forward displacement of the ankle's marker per rotation of the ankle")


class EmgLab(Section):
    """The recorder of muscle activity."""

    rate_hz: Rate = setting("rate, a whole number")
    band_hz: fixed(Frequency, 2) = setting("corner frequencies of the spectrum of muscle activity")
    full_drive_uV: Positive = setting("root mean square at full drive")
    cross_talk: NotNegative = setting("fraction of a neighbouring muscle's signal")
    artefact_uV_per_m_per_s2: float = setting("artefact of a constant belt acceleration")
    artefact_s: Time = setting("time constant of skin and cables")
    hum_uV: NotNegative = setting("mains hum: amplitude")
    hum_hz: Frequency = setting("its frequency")
    hum_third: NotNegative = setting("its relative third harmonic")
    channel_spread: NotNegative = setting(
        "variation of artefact and hum between channels (standard deviation of the logarithm)"
    )
    baseline_uV: NotNegative = setting("baseline drift: standard deviation")
    baseline_s: Time = setting("its correlation time")
    noise_uV: NotNegative = setting("standard deviation of the white noise of electrodes and amplifier")
    limit_uV: Positive = setting("largest voltage of the converter")


class StandingLab(Section):
    """The standing person."""

    person: PersonLab
    tasks: Tasks
    muscles: Muscles
    nerves: Nerves
    markers: PersonMarkers
    skin: Skin
    emg: EmgLab


# ---- walking ----------------------------------------------------------------------------------------------


class WalkingJoint(Section):
    """The ankle whose responses are added to real strides ([walking](../docs/recordings/walking.md))."""

    phase_percent: some(number(least=0, most=100), least=2) = setting("knots over stance")
    stiffness_Nm_per_rad: some(number(least=0, most=20000), least=2) = setting("*K* at the knots")
    damping_Nms_per_rad: some(Damping, least=2) = setting("*B* at the knots")
    inertia_kgm2: Inertia = setting("*I*")
    reflex_Nms_per_rad: NotNegative = setting("reflex moment per velocity of the stretch")
    latency_s: Lag = setting("first reflex")
    twitch_s: Time = setting("time to the peak of a twitch")
    foot_mass_kg: number(least=0, most=50) = setting("mass of the foot")
    foot_depth_m: Height = setting("its centre of mass below the ankle")
    shank_m: Length = setting("displacement of the belt per rotation of the ankle")
    vertical_per_moment: float = setting("change of the vertical force with the moment", unit="1/m")
    anterior_per_moment: float = setting("change of the anterior force with the moment", unit="1/m")


class WalkingBody(Section):
    """What markers and plates show."""

    shank_m: Length = setting("place of the marker on the knee above the one on the ankle")
    heel_m: Point = setting("marker on the heel from the ankle (forward, up)")
    toe_m: Point = setting("marker on the toe from the ankle (forward, up)")
    sacrum_height_m: Length = setting("height of the marker on the sacrum")
    marker_noise_m: Height = setting("standard deviation of a sample of a marker")
    force_noise_N: NotNegative = setting("the same of a force")
    moment_noise_Nm: NotNegative = setting("the same of a moment")


class WalkingLab(Section):
    """Walking."""

    joint: WalkingJoint
    body: WalkingBody


# ---- the treadmill, the same for the dummy, the weight, the empty belt and the person ---------------------


class ProtocolLab(Section):
    """Times of a trial."""

    lead_s: Pause = setting("time logged before the trigger rises")
    tail_s: Pause = setting("time logged after it falls")
    rest_before_s: Time = setting("unperturbed time at the trial's start")
    rest_after_s: Time = setting("unperturbed time at its end")
    rest_after_weight_s: Time = setting(
        "the same at the end of trials with the weight and with the empty belt"
    )
    pulse_s: Time = setting("length of the commanded pulse")


class DriveLab(Section):
    """Drive of the belt."""

    belt_mass_kg: Mass = setting("belt, rollers and motor, reflected to the belt")
    bandwidth_hz: Frequency = setting("proportional gain over belt mass as a frequency")
    integral_time_s: Time = setting("proportional over integral gain")
    force_limit_N: number(above=0, most=100000) = setting("largest drive force")
    delay_s: Lag = setting("from command to force")
    viscous_Ns_per_m: NotNegative = setting("friction of the unloaded belt")
    velocity_step_m_per_s: number(above=0, most=10) = setting("resolution of the logged belt velocity")
    velocity_noise_m_per_s: NotNegative = setting("noise of the logged belt velocity")


class PlateLab(Section):
    """Force plate and frame."""

    belt_length_m: number(above=0, most=10) = setting("distance between the transducers along the belt")
    belt_width_m: number(above=0, most=10) = setting("distance between them across the belt")
    transducer_depth_m: Height = setting("their depth")
    sensitivity_V_per_N: Positive = setting("volts per newton")
    sensitivity_spread: NotNegative = setting("its relative spread")
    cross_talk: NotNegative = setting("relative leak between channels")
    calibration_error: NotNegative = setting("relative error of the calibration")
    force_scale: fixed(Scale, 2) = setting("gain since the calibration, [fore-aft, vertical]")
    vertical_leak: number(least=-1, most=1) = setting(
        "fraction of the vertical force that the fore-aft transducer shows"
    )
    origin_height_m: Offset = setting("height of the calibration's origin above the belt")
    origin_forward_m: Offset = setting("position of that origin, forward of the motion capture's origin")
    moment_scale: number(least=-10, most=10) = setting("gain of M_x since the calibration")
    transducer_gain: fixed(NotNegative, 4) = setting(
        "gain of the vertical transducers since the calibration, [front left, front right, rear left, rear "
        "right]"
    )
    noise_V: NotNegative = setting("white noise of a channel")
    drift_V_per_s: NotNegative = setting("standard deviation of its linear drift")
    felt_belt_mass_kg: number(least=0, most=500) = setting(
        "mass of the belt's upper run minus that of its lower run, which acts on the fore-aft transducer"
    )
    felt_roller_inertia_kgm: NotNegative = setting(
        "moment of inertia of the rollers over their radius: pitch moment per belt acceleration"
    )
    belt_lag_s: Lag = setting("mean delay of the load relative to the rollers, because the belt stretches")
    belt_lag_wander: NotNegative = setting(
        "its variation between perturbations (standard deviation of the logarithm)"
    )
    belt_lag_wander_s: Time = setting("correlation time of this variation")
    friction_N: NotNegative = setting("friction of the moving belt: unloaded")
    friction_coefficient: NotNegative = setting("additional friction per newton of load")
    friction_speed_m_per_s: number(above=0, most=10) = setting("speed of saturation")
    friction_Ns_per_m: NotNegative = setting("viscous part of the friction")
    bristle_share: Fraction = setting(
        "fraction of the friction, without its viscous part, that has a memory (0: none)"
    )
    bristle_m: Length = setting("displacement before it slides")
    friction_lever_m: Offset = setting(
        "depth under the belt's surface at which friction acts: its moment about the lateral axis"
    )
    floor_m_per_s2: NotNegative = setting("vibration of the floor: root mean square")
    floor_hz: Frequency = setting("its frequency")
    floor_damping: Positive = setting("its damping ratio")
    resonance_hz: Frequency = setting("fore-aft resonance of the unloaded frame")
    resonance_damping: Positive = setting("its damping ratio")
    resonance_mass_kg: number(above=0, most=10000) = setting("its moving mass")
    second_share: fixed(Fraction, 2) = setting(
        "second mode of the frame: its fraction of [F_y, M_x] (0: none)"
    )
    second_hz: Frequency = setting("its frequency")
    second_damping: Positive = setting("its damping ratio")
    second_mass_kg: number(above=0, most=10000) = setting("its moving mass")
    mount_share: number(least=0, below=1) = setting(
        "fraction of a fast fore-aft force that rubber mounts at the height of the belt take"
    )
    mount_relaxation_s: Time = setting("their relaxation time")
    rate_hz: Rate = setting("rate of the log")


class CaptureLab(Section):
    """Motion capture."""

    rate_hz: Rate = setting("frames per second")
    marker_sampling_hz: Rate = setting("markers per second within a frame")
    latency_s: Lag = setting("time from the trigger to the first marker of the first frame")
    clock_ppm: number(least=-100000, most=100000) = setting(
        "how much faster the clock runs than that of the treadmill's log", unit="parts per million"
    )
    length_scale: Scale = setting("measured over true lengths")
    vertical_rad: Angle = setting("angle by which an upright rod is seen to lean forwards")
    noise_m: Height = setting("standard deviation of each coordinate")
    occlusions_per_minute: NotNegative = setting(
        "mean number of occlusions of a marker per minute", unit="1/min"
    )
    occlusion_s: Pause = setting("their mean length; each hides a frame at least")


class TreadmillLab(Section):
    """The treadmill."""

    protocol: ProtocolLab
    drive: DriveLab
    plate: PlateLab
    left_plate: partial(PlateLab) = setting("constants of the plate below the left belt that differ")
    capture: CaptureLab


class Distribution(Section):
    """Distribution of a constant around its number in the file: one of the first three, and further keys."""

    normal: NotNegative = optional("`normal: s`: standard deviation *s*")
    rectangular: NotNegative = optional("`rectangular: a`: half width *a*, standard deviation *a*/√3")
    student: fixed(NotNegative, 2) = optional(
        "`student: [s, n]`: standard deviation *s*, with the tails of *n* > 2 degrees of freedom"
    )
    log_uniform: fixed(Positive, 2) = optional(
        "`log_uniform: [a, b]`: from *a* to *b*, whatever the number in the file, uniform in the logarithm"
    )
    one_of: list[float] = optional("`one_of: [a, b, ...]`: one of these, whatever the number in the file")
    relative: bool = optional("true: widths are fractions of the number, whose sign stays")
    positive: bool = optional(
        "true, for a number above 0 with an absolute width: draws of 0 or less are repeated"
    )
    below: float = optional("draws of this or more are repeated, for example of a share at 1")
    shift: float = optional(
        "the mean of each number moves by this many standard deviations, up or down at random"
    )


class VirtualLab(Section):
    """Constants of the virtual laboratory."""

    seed: int = setting(
        "seed of the laboratory. Every trial has its own generator, derived from the seed and the name of "
        "the trial",
        least=0,
    )
    wristalyzer: WristalyzerLab
    dummy: DummyLab
    weight: WeightLab
    heavy_weight: WeightLab
    standing: StandingLab
    walking: WalkingLab
    treadmill: TreadmillLab
    drawn: dict[str, Distribution] | None = setting(
        "path of a constant: its distribution; null draws nothing"
    )
