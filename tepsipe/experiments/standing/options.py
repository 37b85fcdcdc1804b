"""A standing person, and the choices of the analysis (thesis section 3-2)."""

from dataclasses import dataclass, replace
from typing import Annotated, Literal, Self

from annotated_types import Ge, Gt, Le

from tepsipe.mechanics.anthropometry import Feet, StandingBody, both_feet, standing_body
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.quantities import (
    Delay,
    FilterOrder,
    Frequency,
    Latency,
    Meanings,
    Pair,
    Pause,
    Positive,
    Time,
    Torque,
    Velocity,
)
from tepsipe.signals.emg import EmgOptions
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions

# readings of thesis eq (3-14): its crosses as products of vectors, or of scalars
AS_PRINTED = VECTORS, SCALARS = ("ankle-thesis-vector", "ankle-thesis")
TORQUES = {
    VECTORS: "thesis eq (3-14) as printed, its crosses read as vector products",
    SCALARS: "thesis eq (3-14) as printed, its crosses read as products of scalars",
    "ankle": "balance of moments of the feet about the ankles, derived consistently",
    "single-joint": "the body above the ankles as one inverted pendulum, from markers only; included to show "
    "that this model fails",
}
BELT_LOADS = Meanings(
    {
        "null": "F_y and M_x as measured",
        "a model of `weight.models.family`": "the predicted load is subtracted from both; requires trials of "
        "`weight` and `empty` in the study. `single-joint` does not use the plate",
        "best-frame": "the same, of `bristle-frame` and `linear-frame` with that which predicts trials best "
        "that it has not seen",
    }
)
OTHER_BELT = {"left": "right", "right": "left"}
# one foot on each belt
BOTH = "both"


@dataclass(frozen=True)
class TorquePathway:
    """Definition of one ankle torque."""

    torque: Annotated[Literal[tuple(TORQUES)], Meanings(TORQUES)]
    """Torque of both ankles."""
    treadmill_model: Annotated[str | None, BELT_LOADS]
    """Belt-induced load."""


@dataclass(frozen=True)
class Person:
    """Properties and markers of the person."""

    mass_kg: float
    """Mass of the whole body."""
    feet: Feet
    """Both feet (kg, kg·m²)."""
    body: StandingBody
    """Body above the ankles (kg, m, kg·m²)."""
    foot_com_m: float
    ankle_height_m: float
    """Anterior offset of the feet's centre of mass from the ankles, height of the ankles."""
    foot: SegmentMarkers
    shank: SegmentMarkers
    thigh: SegmentMarkers
    """Markers with anterior and longitudinal offset: from the ankle, the ankle and the knee (m)."""

    @classmethod
    def from_settings(cls, person: dict) -> Self:
        """Person of a mass (kg), a stature (m), and markers of foot, shank and thigh.

        Masses, moments of inertia and the centre of mass follow from mass and stature.
        """
        mass_kg, stature_m, ankle_height_m = (
            person[key] for key in ("mass_kg", "stature_m", "ankle_height_m")
        )
        placed = {
            segment: SegmentMarkers.from_settings(person[f"{segment}_markers"])
            for segment in ("foot", "shank", "thigh")
        }
        return cls(
            mass_kg=mass_kg,
            feet=both_feet(mass_kg, stature_m),
            body=standing_body(
                mass_kg, stature_m, person["com_height"], ankle_height_m, person["gravity_m_per_s2"]
            ),
            foot_com_m=person["foot_com_m"],
            ankle_height_m=ankle_height_m,
            **placed,
        )

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of all markers, each once."""
        return tuple(dict.fromkeys((*self.foot.labels, *self.shank.labels, *self.thigh.labels)))

    @property
    def weight(self) -> float:
        """Weight of the whole body (N)."""
        return self.mass_kg * self.body.gravity_m_per_s2


@dataclass(frozen=True)
class StanceLimits:
    """Limits of standing still on the belt; exceeding one indicates a step or a stumble."""

    foot_shift_m: Annotated[float, Gt(0), Le(1)]
    """Largest displacement of a foot marker relative to the belt within 2 s; more is a step."""
    foot_lift_m: Annotated[float, Gt(0), Le(1)]
    """Largest rise of a foot marker."""
    other_belt: Positive
    """Largest fraction of the weight on the other belt."""
    unloading: Positive
    """Largest fraction of the weight that leaves the plate for longer than `unloading_s`."""
    unloading_s: Pause
    """This time."""
    lean_rad: Annotated[float, Gt(0), Le(3.2)]
    """Largest angle of the shank relative to its median."""


@dataclass(frozen=True)
class StandingOptions:
    """Options of the post-processing."""

    person: Person
    """The person (kg, m)."""
    belt: str
    """The belt on which both feet stand, left or right; both if each foot stands on the belt of its side."""
    lowpass: Lowpass
    """Filter of all signals."""
    stretch_cutoff_hz: Frequency
    """Cutoff for the angles that determine which muscles are lengthened first, at most 0.3 of the rate; order
    as in `plate_treadmill`."""
    window: WindowOptions
    quiet_after_s: Pause
    """Time after a perturbation that does not count as unperturbed."""
    limits: StanceLimits
    """Limits beyond which a trial contains a step or a stumble (m, rad, -)."""

    @property
    def belts(self) -> tuple[str, ...]:
        """Belts that carry the person."""
        return tuple(OTHER_BELT) if self.belt == BOTH else (self.belt,)

    def of_leg(self, belt: str) -> Self:
        """Options for one leg of a person with a foot on each belt: half of the feet, on the leg's belt."""
        feet = self.person.feet
        half = Feet(0.5 * feet.mass_kg, 0.5 * feet.inertia_kgm2)
        return replace(self, person=replace(self.person, feet=half), belt=belt)

    @classmethod
    def from_settings(cls, person: dict, belt: str, analysis: dict, stance: dict) -> Self:
        """Options of a study: person, belt, filters and windows (Hz, s), limits of quiet standing."""
        return cls(
            person=Person.from_settings(person),
            belt=belt,
            lowpass=Lowpass(analysis["lowpass_cutoff_hz"], analysis["lowpass_order"], True),
            stretch_cutoff_hz=analysis["stretch_cutoff_hz"],
            window=WindowOptions(**analysis["window"]),
            quiet_after_s=analysis["quiet_after_s"],
            limits=StanceLimits(**stance),
        )


@dataclass(frozen=True)
class StandingEstimator:
    """One estimator of parameters from responses."""

    window_s: Time
    """Length of the window from the onset; the fit starts 0.03 s before the onset, because of the zero-lag
    filter; at most `analysis.after_s`."""
    inertia: bool
    """True if I is estimated in addition to B and K. The torque contains no inertia, so false is correct."""
    active: str
    """Active torque of the muscles."""


@dataclass(frozen=True)
class EpochOptions:
    """Options of the epochs."""

    before_s: Time
    """Length of an epoch before its onset."""
    after_s: Time
    """Length of an epoch after its onset."""
    baseline_s: Pair[Annotated[float, Le(0)]]
    """Baseline of an epoch, from the onset."""
    least_perturbations: Annotated[int, Ge(2)]
    """A trial with fewer usable perturbations is omitted."""
    line_hz: Frequency
    """Mains frequency, whose hum indicates a loose electrode; to remove hum, use `emg.mains_hz`."""
    max_gap_s: Time
    """Longest time for which a marker may be hidden within a response."""
    lowpass_cutoff_hz: Frequency
    lowpass_order: FilterOrder
    """Filter of the rectified electromyograms that drive the active torque, the same as for all signals."""
    emg: EmgOptions
    """Processing of the electromyograms."""

    @classmethod
    def from_settings(cls, analysis: dict, emg: dict, max_gap_s: float) -> Self:
        """Options of a study: windows (s), filters (Hz) also of the electromyograms, longest gap (s)."""
        own = {key: analysis[key] for key in cls.__dataclass_fields__ if key in analysis}
        return cls(**own, max_gap_s=max_gap_s, emg=EmgOptions(**emg))


@dataclass(frozen=True)
class FreeReflexOptions:
    """Choices of the estimator."""

    lowpass_cutoff_hz: Frequency
    """Low-pass of all signals for estimators with `active: free`, at most 0.3 of the rate; order as in
    `plate_treadmill`."""
    discrepancy: Positive
    """What the model of the rig leaves: standard deviation as a share of the largest torque."""
    discrepancy_s: Time
    """Its length."""
    reflex_Nm: Torque
    """Standard deviation of the reflex torque `reflex_after_s` after its earliest instant, at
    `reflex_speed_m_per_s` of the belt, in proportion to the speed."""
    reflex_after_s: Latency
    """This time."""
    reflex_speed_m_per_s: Velocity
    """This speed."""
    reflex_onset_s: Latency
    """Earliest instant of the reflex torque for single trials, and where no latency of an ankle muscle is
    known."""
    electromechanical_delay_s: Delay
    """From the first latency of an ankle muscle to that instant."""
    windows_s: Pair[Time]
    """The spread of K and B over these windows is a source of their uncertainty."""
