"""Settings of a plan study: designs of experiments, the best pulse and the best filter, several joints."""

import math
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from tepsipe.experiments.planning import design
from tepsipe.experiments.planning.pulses import Limits
from tepsipe.identification.several_joints import matrices
from tepsipe.quantities import Damping, Frequency, Inertia, Length, NotNegative, Stiffness, Time, Velocity
from tepsipe.virtual_lab.standing_chain import ChainPerson, ChainProtocol
from workflow.settings.section import (
    Section,
    UnfitError,
    made_from,
    named,
    number,
    optional,
    partial,
    refuse_unknown,
    setting,
    some,
)

NAME = "^[a-z0-9][a-z0-9.-]*$"


class PlanJoint(Section):
    """The expected joint."""

    inertia_Nms2_per_rad: Inertia = setting("expected *I*")
    damping_Nms_per_rad: Damping = setting("expected *B*")
    stiffness_Nm_per_rad: Stiffness = setting("expected *K*")


class _Pulse(Section):
    """The belt's command."""

    profile: Literal["sine", "minjerk", "half-sine", "ramp"] = setting(
        "profile of the command; the last two leave the belt displaced, and alternate"
    )
    amplitude_m_per_s: Velocity = setting("peak velocity of the command")
    duration_s: Time = setting("length of the command")


class Protocol(made_from(design.Protocol, without=("pulse",)), _Pulse):
    """Perturbations, and estimator."""


Rig = made_from(design.Rig, without=("leg_markers",))


class DesignChanges(Section):
    """What differs from `joint`, `rig` and `protocol`; nothing (`{}`) for a design without differences."""

    joint: partial(PlanJoint) = optional("keys of `joint` with other values")
    rig: partial(Rig) = optional("keys of `rig` with other values")
    protocol: partial(Protocol) = optional("keys of `protocol` with other values")


class Filters(Section):
    """Filters that are compared."""

    design: str = setting("design for which every filter is predicted")
    cutoffs_hz: some(Frequency) = setting("cutoffs")
    zero_lag_orders: list[Annotated[int, Field(ge=2, multiple_of=2)]] = setting("orders of zero-lag filters")
    one_sided_orders: list[Annotated[int, Field(ge=1)]] = setting("orders of one-sided filters")


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


class SeveralJoints(Section):
    """Stiffness and damping of ankle, knee and hip as matrices."""

    persons: int = setting(
        "recordings of the person, each with its own sway, noise, and errors of the inertia", least=2
    )
    person: made_from(ChainPerson)
    perturbations: named(ChainPerturbation, NAME) = setting("name: a perturbation")
    protocol: made_from(ChainProtocol, without=("pulses", "engine"))
    limits: made_from(matrices.Limits)
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
    comfort: made_from(Limits, "Further limits of the best pulse.")
    filters: Filters
    several_joints: SeveralJoints

    @model_validator(mode="after")
    def _known_designs(self) -> Any:
        for name in self.references:
            refuse_unknown("references", name, "plan.designs", self.designs)
        refuse_unknown("filters.design", self.filters.design, "plan.designs", self.designs)
        return self
