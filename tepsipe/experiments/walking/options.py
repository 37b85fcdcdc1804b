"""Files of a walking trial, choices of its analysis, and an expected pulse."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Le, MultipleOf

from tepsipe.quantities import (
    Damping,
    Direction,
    Frequency,
    Height,
    Inertia,
    NotNegative,
    Pause,
    Positive,
    Sign,
    Some,
    Stiffness,
    Time,
)

ANKLE, KNEE, HEEL, TOE = "ankle", "knee", "heel", "toe"


@dataclass(frozen=True)
class WalkingAxes:
    """Directions in a C3D or in D-Flow's text."""

    forward: Direction
    """Direction of walking in the file."""
    up: Direction
    """Upward direction in the file."""


@dataclass(frozen=True)
class WalkingPlates:
    """Force plates under the feet."""

    own: Annotated[int, Ge(1)]
    """Number of the force plate under the perturbed foot."""
    other: Annotated[int, Ge(1)]
    """Number of that under the other foot."""


@dataclass(frozen=True)
class WalkingFiles:
    """Axes, plates, markers and channels in the files of a laboratory."""

    axes: WalkingAxes
    plates: WalkingPlates
    force_sign: Sign = 1
    """−1 if the plates give the force *on the plate*."""
    surface_m: Annotated[float, Ge(-10), Le(10)] = 0.0
    """Height of the belt in the axes of the file."""
    markers: Mapping[str, str] = field(
        default_factory=lambda: {ANKLE: "LMAL", KNEE: "LKNE", HEEL: "LHEE", TOE: "LTOE"}
    )
    """ankle, knee, heel, toe, and any others whose position may foretell a stride -> label in the file."""


@dataclass(frozen=True)
class WalkingOptions:
    """Choices of the analysis."""

    phases_percent: Some[Annotated[float, Ge(0), Le(100)]] = (20.0, 40.0, 60.0, 80.0)
    """Phases of stance at which pulses begin."""
    phase_tolerance_percent: Positive = 5.0
    """Largest distance of a pulse from its phase."""
    control_percent: Sequence[Annotated[float, Ge(100), Le(1000)]] = ()
    """Further onsets, in swing (above 100), that serve as a control."""
    lowpass_cutoff_hz: Frequency = 20.0
    """Zero-lag low-pass of all signals."""
    lowpass_order: Annotated[int, Ge(2), MultipleOf(2)] = 4
    """Order of both passes together."""
    window_s: Time = 0.1
    """Window after the onset."""
    reflex_from_s: Pause = 0.05
    """Earliest reflex moment."""
    reflex_Nm: NotNegative = 1.6
    """Its standard deviation 20 ms later."""
    matched_by: Sequence[str] | None = None
    """Signals from whose state unperturbed behaviour is predicted (null: all; `[]`: plain mean)."""
    ridge: Positive = 1.0
    """Penalty of the prediction, relative to the number of strides."""
    state_before_s: Pause = 0.04
    """The state is that so long before the onset."""
    inertia_kgm2: Inertia | None = 0.012
    """*I* as known; null to estimate it."""
    foot_mass_kg: Annotated[float, Ge(0), Le(50)] = 1.15
    """Mass of the foot."""
    foot_depth_m: Height = 0.06
    """Its centre of mass below the ankle."""
    fewest_strides: Annotated[int, Ge(3)] = 6
    """Fewest perturbed strides of a phase."""
    recovery_strides: Annotated[int, Ge(0)] = 1
    """Strides after a perturbed one that are not used."""

    @property
    def onsets_percent(self) -> tuple[float, ...]:
        """Phases and controls (% of stance)."""
        return (*self.phases_percent, *self.control_percent)


@dataclass(frozen=True)
class ExpectedPulse:
    """A planned pulse, and the joint that it perturbs."""

    amplitude_deg: Annotated[float, Gt(0), Le(90)]
    """Rotation of the ankle."""
    duration_s: Time
    """Length of the ramp."""
    stiffness_Nm_per_rad: Sequence[Stiffness]
    """Expected *K* at each phase."""
    damping_Nms_per_rad: Damping
    """Expected *B*."""
    strides: Annotated[int, Ge(1)] = 150
    """All perturbed strides, which `tables/needed.csv` divides among the phases."""
