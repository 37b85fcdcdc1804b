"""A standing person, and the choices of the analysis (thesis section 3-2)."""

from dataclasses import dataclass, replace
from typing import Self

from tepsipe.mechanics.anthropometry import Feet, StandingBody, both_feet, standing_body
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions

TORQUES = ("ankle-thesis", "ankle", "single-joint")
OTHER_BELT = {"left": "right", "right": "left"}
# one foot on each belt
BOTH = "both"


@dataclass(frozen=True)
class TorquePathway:
    """Definition of one ankle torque."""

    torque: str
    """{"ankle-thesis", "ankle", "single-joint"}: Free body: the feet by the thesis equation, the feet, or
    the body as one inverted pendulum."""
    treadmill_model: str | None
    """Model of the belt-induced load that is subtracted from Fy and Mx; None for the loads as measured."""


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

    foot_shift_m: float
    foot_lift_m: float
    """Displacement of the foot's markers relative to the belt, and above their height at rest."""
    other_belt: float
    """Fraction of the weight on the other belt."""
    unloading: float
    """Fraction of the weight that leaves the plate for longer than ``unloading_s``, for example into the
    harness."""
    unloading_s: float
    """Shorter unloading counts as a jolt."""
    lean_rad: float
    """Angle of the shank relative to its median."""


@dataclass(frozen=True)
class StandingOptions:
    """Options of the post-processing."""

    person: Person
    """The person (kg, m)."""
    belt: str
    """The belt on which both feet stand, left or right; both if each foot stands on the belt of its side."""
    lowpass: Lowpass
    stretch_lowpass: Lowpass
    """Filter of all signals; filter of the angles that determine which muscles are stretched first."""
    window: WindowOptions
    """Search for perturbations and rest (s)."""
    quiet_after_s: float
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
        order = analysis["lowpass_order"]
        return cls(
            person=Person.from_settings(person),
            belt=belt,
            lowpass=Lowpass(analysis["lowpass_cutoff_hz"], order, True),
            stretch_lowpass=Lowpass(analysis["stretch_cutoff_hz"], order, True),
            window=WindowOptions(**analysis["window"]),
            quiet_after_s=analysis["quiet_after_s"],
            limits=StanceLimits(**stance),
        )


@dataclass(frozen=True)
class StandingEstimator:
    """One estimator of parameters from responses."""

    window_s: float
    """Length of the fitted window from the onset."""
    inertia: bool
    """Whether I is estimated; the torque does not contain the inertia of the feet or of the body."""
    active: str
    """Model of the delayed torque of the muscles, of `tepsipe.experiments.standing.muscle_torque.ACTIVE`."""
