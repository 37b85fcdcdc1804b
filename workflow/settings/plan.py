"""Settings of a plan study: designs of experiments, the best pulse and the best filter, several joints."""

import math
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from workflow.settings.quantities import (
    Acceleration,
    Damping,
    Frequency,
    Gravity,
    Inertia,
    Length,
    Mass,
    NotNegative,
    Positive,
    Rate,
    Stiffness,
    Time,
    Velocity,
    fixed,
    named,
    number,
    some,
)
from workflow.settings.section import Section, UnfitError, optional, partial, refuse_unknown, setting, whole

NAME = "^[a-z0-9][a-z0-9.-]*$"
Rest = number(least=1, most=3600)  # s


class PlanJoint(Section):
    """The expected joint."""

    inertia_Nms2_per_rad: Inertia = setting("expected *I*")
    damping_Nms_per_rad: Damping = setting("expected *B*")
    stiffness_Nm_per_rad: Stiffness = setting("expected *K*")


class Drive(Section):
    """The belt's servo with its load."""

    bandwidth_hz: Frequency | None = setting("bandwidth; null: the belt follows every command")
    integral_s: Time = setting("proportional over integral gain")
    acceleration_m_per_s2: Acceleration = setting("largest force over the moved mass")


class Rig(Section):
    """Instruments."""

    foot_markers: int = setting("markers on the foot, in addition to that on the ankle", least=1)
    marker_noise_m: number(above=0, most=0.1) = setting("noise of a marker in each direction")
    camera_rate_hz: number(least=80, most=100000) = setting("rate of the cameras")
    log_noise_m_per_s: Velocity = setting("noise of the logged belt velocity")
    log_rate_hz: Rate = setting("rate of the log")
    force_noise_N: NotNegative = setting("noise of the plate's forces")
    moment_noise_Nm: NotNegative = setting("noise of the plate's moments")
    plate_rate_hz: Rate = setting("rate of the plate")
    sync_jitter_s: number(least=0, most=1) = setting(
        "standard uncertainty of the time between plate and cameras"
    )
    drive: Drive


class Protocol(Section):
    """Perturbations, and estimator."""

    profile: Literal["sine", "minjerk", "half-sine", "ramp"] = setting(
        "profile of the command; the last two leave the belt displaced, and alternate"
    )
    amplitude_m_per_s: Velocity = setting("peak velocity of the command")
    duration_s: Time = setting("length of the command")
    number: int = setting("number of perturbations", least=1)
    interval_s: Time = setting("time from onset to onset")
    rest_before_s: Rest = setting("unperturbed time before them")
    rest_after_s: Rest = setting("unperturbed time after them")
    pathway: Literal["joint-likelihood", "joint-likelihood-linear", "leg", "foot"] = setting("estimator")
    cutoff_hz: Frequency = setting("low-pass of `leg` and `foot`")
    order: int = setting("its order", least=1)
    zero_lag: bool = setting("true for a zero-lag filter")


class DesignChanges(Section):
    """What differs from `joint`, `rig` and `protocol`; nothing (`{}`) for a design without differences."""

    joint: partial(PlanJoint) = optional("keys of `joint` with other values")
    rig: partial(Rig) = optional("keys of `rig` with other values")
    protocol: partial(Protocol) = optional("keys of `protocol` with other values")


class Comfort(Section):
    """Further limits of the best pulse."""

    velocity_m_per_s: Velocity = setting("largest velocity")
    displacement_m: Length = setting("largest displacement")
    acceleration_m_per_s2: Acceleration = setting("largest acceleration")
    jerk_m_per_s3: Positive = setting("largest jerk", unit="m/s³")


class Filters(Section):
    """Filters that are compared."""

    design: str = setting("design for which every filter is predicted")
    cutoffs_hz: some(Frequency) = setting("cutoffs")
    zero_lag_orders: list[Annotated[int, Field(ge=2, multiple_of=2)]] = setting("orders of zero-lag filters")
    one_sided_orders: list[Annotated[int, Field(ge=1)]] = setting("orders of one-sided filters")


class ChainPerson(Section):
    """Both shanks, both thighs, and trunk with head and arms."""

    mass_kg: fixed(Mass, 3) = setting("mass of both shanks, both thighs, trunk with head and arms")
    length_m: fixed(Length, 3) = setting("their lengths")
    com_m: fixed(Length, 3) = setting("their centres of mass above the lower end")
    inertia_kgm2: fixed(number(above=0, most=20), 3) = setting(
        "their moments of inertia about the centre of mass"
    )
    posture_deg: fixed(number(least=-45, most=45), 3) = setting(
        "angles of shank, thigh and trunk from the vertical, positive forwards"
    )
    stiffness_Nm_per_rad: fixed(fixed(float, 3), 3) = setting(
        "expected *K*; rows are torques, columns angles of ankle, knee, hip"
    )
    damping_Nms_per_rad: fixed(fixed(float, 3), 3) = setting("expected *B*")
    own_torque_Nm: fixed(Positive, 3) = setting("standard deviation of the torque that makes sway")
    own_band_hz: fixed(Frequency, 2) = setting("its band")
    gravity_m_per_s2: Gravity = setting("acceleration of gravity")


class ChainPerturbation(Section):
    """A minimum-jerk movement of the belt, or a half-sine force on a segment."""

    displacement_m: Length = optional("displacement of the belt")
    duration_s: Time = setting("length of the movement or force")
    force_N: number(above=0, most=10000) = optional("peak force")
    segment: Literal["shank", "thigh", "trunk"] = optional("segment on which it acts")
    height_m: number(least=0, most=3) = optional("its height above the segment's lower end")

    @model_validator(mode="after")
    def _one_kind(self) -> Any:
        force, given = {"force_N", "segment", "height_m"}, self.model_fields_set - {"duration_s"}
        if given not in ({"displacement_m"}, force):
            raise UnfitError(
                "to have displacement_m (the belt moves), or force_N, segment and height_m (a force)",
                found=", ".join(sorted(given)) or "none of them",
            )
        return self


class ChainProtocol(Section):
    """Repetitions and recording."""

    epochs: int = setting("repetitions of each perturbation", least=2)
    before_s: Time = setting("recorded before each onset")
    after_s: Time = setting("recorded after each onset")
    unperturbed_s: Time = setting("recorded of unperturbed standing")
    rate_hz: whole(50, 100, 125, 200, 250, 500) = setting("rate of the angles")
    angle_noise_rad: number(above=0, most=1) = setting("standard deviation of the noise of one sample")
    force_noise_N: NotNegative = setting("the same of the force")
    belt_noise_m_per_s2: NotNegative = setting("the same of the belt's acceleration")


class DeterminedLimits(Section):
    """What counts as determined."""

    stiffness_percent: Positive = setting(
        "half width of a 95 % interval of *K*<sub>ij</sub> in per cent of √(*K*<sub>ii</sub> "
        "*K*<sub>jj</sub>), and standard error of every direction of the unknowns"
    )
    damping_percent: Positive = setting("the same of *B*")


class SeveralJoints(Section):
    """Stiffness and damping of ankle, knee and hip as matrices."""

    persons: int = setting(
        "recordings of the person, each with its own sway, noise, and errors of the inertia", least=2
    )
    person: ChainPerson
    perturbations: named(ChainPerturbation, NAME) = setting("name: a perturbation")
    protocol: ChainProtocol
    limits: DeterminedLimits
    inertia_percent: NotNegative = setting(
        "standard uncertainty of every mass, centre of mass and moment of inertia"
    )
    windows_s: list[Time] = setting("other lengths after the onset that are predicted")

    @model_validator(mode="after")
    def _unperturbed_long_enough(self) -> Any:
        protocol = self.protocol
        epoch_s = protocol.before_s + protocol.after_s + 0.002
        of_windows = 20.0 * (protocol.before_s + max([protocol.after_s, *self.windows_s]) + 0.02)
        least = max(epoch_s * (protocol.epochs * len(self.perturbations) + 1), of_windows)
        if protocol.unperturbed_s < least:
            raise UnfitError(
                f"of at least {math.ceil(least)} s for {protocol.epochs} epochs of {len(self.perturbations)} "
                "perturbations",
                "lengthen it, or take fewer epochs",
                "protocol.unperturbed_s",
                f"{protocol.unperturbed_s:g} s",
            )
        return self


class Plan(Section):
    """What an experiment will show before it is done."""

    seed: int = setting("of the noise", least=0)
    draws: int = setting("trials with noise of every design", least=2)
    window_draws: int = setting("trials with noise of designs with windowed least squares", least=2)
    joint: PlanJoint
    rig: Rig
    protocol: Protocol
    designs: named(DesignChanges, NAME) = setting(
        "name of a design: what differs in `joint`, `rig` and `protocol`"
    )
    references: some(str) = setting("designs whose pulses the best pulse is compared with")
    comfort: Comfort
    filters: Filters
    several_joints: SeveralJoints

    @model_validator(mode="after")
    def _known_designs(self) -> Any:
        for design in self.references:
            refuse_unknown("references", design, "plan.designs", self.designs)
        refuse_unknown("filters.design", self.filters.design, "plan.designs", self.designs)
        return self
