"""Settings of a study of walking: the ankle in stance, by pulses of the belt at random strides."""

from typing import Any, Literal

from pydantic import ConfigDict, model_validator

from tepsipe.errors import InputError
from tepsipe.experiments.walking import options
from tepsipe.experiments.walking.options import ExpectedPulse, WalkingOptions
from tepsipe.quantities import Pause, Rate, Time
from tepsipe.statistics.uncertainty import Source
from workflow.settings.section import Section, UnfitError, made_from, optional, setting, some


class WalkingAxes(made_from(options.WalkingAxes)):
    """Directions in a C3D or in D-Flow's text."""

    @model_validator(mode="after")
    def _two_axes(self) -> Any:
        if self.forward[1] == self.up[1]:
            found = f"{self.forward!r} and {self.up!r}"
            raise UnfitError("to be two different axes", "correct one of the two", found=found)
        return self


class WalkingPlates(made_from(options.WalkingPlates)):
    """Force plates under the feet."""

    @model_validator(mode="after")
    def _two_plates(self) -> Any:
        if self.own == self.other:
            found = f"{self.own} for both feet"
            raise UnfitError("to be two force plates", "correct one of the two", found=found)
        return self


class WalkingMarkers(Section):
    """Labels of markers; the positions of any others may foretell a stride."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, str]

    ankle: str = setting("label of the marker on the ankle")
    knee: str = setting("on the knee")
    heel: str = setting("on the heel")
    toe: str = setting("on the toe. Further keys name markers whose positions may foretell a stride")


class WalkingRecording(made_from(options.WalkingFiles)):
    """Recordings of instruments."""

    axes: WalkingAxes
    plates: WalkingPlates
    markers: WalkingMarkers


class WalkingColumns(Section):
    """Names in the header of a recording that is a table, of the perturbed leg."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, str]

    time: str = setting("column: time (s)")
    angle: str = setting("column: angle of the ankle (rad, plantarflexion positive)")
    vertical: str = setting("column: vertical force (N)")
    anterior: str = setting("column: anterior force (N)")
    cop: str = setting("column: centre of pressure (m)")
    ankle_x: str = setting("column: ankle, forwards (m)")
    ankle_y: str = setting("column: ankle, upwards (m)")
    other_vertical: str = setting("column: vertical force of the other foot (N)")
    supplied_moment: str | None = setting(
        "column: moment of the ankle (N·m), to compare with; null if there is none. Further keys name "
        "columns that may foretell a stride"
    )


class Events(Section):
    """Columns of the table of events (s)."""

    heel_strike: str | None = setting("column: heel strikes; null: found by the vertical force")
    toe_off: str | None = setting("column: toe-offs; null: found by the vertical force")
    pulse: str | None = setting(
        "column: pulses; null without pulses: then random strides stand for perturbed ones"
    )


class SimulatedTrial(Section):
    """A simulated trial."""

    file: Literal["c3d", "dflow"] = setting("kind of the file")
    pulse_s: Time = setting("length of the ramp")
    pulses: some(list[float]) = setting("pairs of onset (% of stance) and number of pulses")

    @model_validator(mode="after")
    def _pairs(self) -> Any:
        for k, pulse in enumerate(self.pulses):
            if len(pulse) != 2 or pulse[0] < 0 or pulse[1] < 1 or pulse[1] != int(pulse[1]):
                expected = "to be an onset (% of stance) and a whole number of pulses"
                raise UnfitError(expected, key=f"pulses.{k}", found=f"{pulse}")
        return self


class Simulated(Section):
    """Trials of the trial sheet with the source `virtual_lab`."""

    of: str = setting("recorded trial whose strides simulated trials resample")
    trials: dict[str, SimulatedTrial] = setting("condition: a simulated trial")


class WalkingSource(made_from(Source, without=("name", "freedom"))):
    """A tolerance."""

    unfolded = False


class WalkingUncertainty(Section):
    """Tolerances; any may be null or absent."""

    joint_centre_anterior_m: WalkingSource | None = optional("place of the joint's centre, forwards")
    joint_centre_vertical_m: WalkingSource | None = optional("the same in height")
    foot_mass_kg: WalkingSource | None = optional("mass of the foot")
    belt_load_kgm: WalkingSource | None = optional(
        "load that the treadmill model leaves, N·m per m/s² of belt acceleration"
    )
    sync_s: WalkingSource | None = optional("delay between forces and motion")
    angle_gain: WalkingSource | None = optional("measured over true rotation of the ankle")
    inertia_kgm2: WalkingSource | None = optional("*I* as known")


class Walking(Section):
    """The ankle in stance."""

    recording: WalkingRecording
    columns: WalkingColumns
    events: Events
    rate_hz: Rate = setting("regular clock")
    max_gap_s: Time = setting(
        "longest step between time stamps of a table, longest time for which a marker is hidden"
    )
    from_s: Pause = setting("strides before are left out")
    analysis: made_from(WalkingOptions)
    planned: made_from(ExpectedPulse)
    simulated: Simulated | None = setting("simulated trials; null without any")
    uncertainty: WalkingUncertainty

    @model_validator(mode="after")
    def _phases_and_rate(self) -> Any:
        phases, expected = self.analysis.phases_percent, self.planned.stiffness_Nm_per_rad
        if len(phases) != len(expected):
            raise InputError(
                "expected walking.planned.stiffness_Nm_per_rad to have a value for each of the "
                f"{len(phases)} phases of walking.analysis.phases_percent, found {len(expected)}: correct "
                "one of the two"
            )
        cutoff, half = self.analysis.lowpass_cutoff_hz, 0.5 * self.rate_hz
        if cutoff >= half:
            raise InputError(
                f"expected walking.analysis.lowpass_cutoff_hz below half of walking.rate_hz ({half:g} Hz), "
                f"found {cutoff:g} Hz: correct one of the two"
            )
        return self
