"""Options of the recordings of treadmills: a log with markers, and one file of a whole trial."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Le

from tepsipe.quantities import DIFFERENT, Direction, Offset, Rate, Scale, Sign, Three, Time


@dataclass(frozen=True)
class TreadmillOptions:
    """Options for a treadmill's recording."""

    resample_rate_hz: Rate
    """Rate of the trial, set by the motion capture."""
    max_gap_s: Time | None  # None where there are no markers
    """Longest time for which a marker may be hidden."""
    marker_sampling_hz: Rate | None
    """Rate of sequential marker sampling within a frame; null if all markers are sampled simultaneously."""
    trigger_threshold_V: Annotated[float, Ge(-100), Le(100)]
    """Voltage above which the trigger line of the log is high."""


Plates = Annotated[Sequence[Annotated[int, Ge(1)]], DIFFERENT]


@dataclass(frozen=True)
class Axes:
    """Directions in the file."""

    forward: Direction = "+y"
    """Direction in the file in which a positive belt velocity moves the belt."""
    up: Direction = "+z"
    """Upward direction in the file."""


@dataclass(frozen=True)
class PlateNumbers:
    """Force plates under each belt."""

    left: Plates = ()
    """Numbers of the force plates under the left belt, from 1; loads of several are added. A belt may have
    none."""
    right: Plates = ()
    """The same of the right belt."""


@dataclass(frozen=True)
class LoadCell:
    """Load cell of a belt that is not among the force plates of the file."""

    channel: str
    """Label of the channel."""
    newton_per_unit: Scale
    """Reaction on the body per unit of the channel."""
    direction: Direction
    """Direction in the axes of the file."""
    position_m: Three[Offset]
    """Point of application in the axes of the file."""


@dataclass(frozen=True)
class LoadCells:
    """Load cells of each belt."""

    left: Sequence[LoadCell] = ()
    """Load cells of the left belt that are not among the force plates of the file; their forces and moments
    are added to those of the plates."""
    right: Sequence[LoadCell] = ()
    """The same of the right belt."""


@dataclass(frozen=True)
class ScaledChannel:
    """Channel of a velocity of the belt: (value - offset) times ``m_per_s_per_unit``."""

    channel: str | None = None
    """Label of the channel; null without one."""
    m_per_s_per_unit: Scale | None = None
    """Velocity per unit of it; null takes it from the channel's unit."""
    offset: float = 0.0
    """Its value at rest, in its unit."""


@dataclass(frozen=True)
class BeltVelocity(ScaledChannel):
    """Velocity of the belt, from a channel or from belt-fixed markers."""

    markers: Annotated[Sequence[str], DIFFERENT] = ()
    """Belt-fixed markers, whose mean velocity is used if there is no channel, and which align D-Flow's
    record file."""


@dataclass(frozen=True)
class RecordingOptions:
    """Trials whose log is one file that holds everything."""

    axes: Axes = Axes()
    plates: PlateNumbers = PlateNumbers()
    load_cells: LoadCells = LoadCells()
    force_sign: Sign = 1
    """−1 if the plates give the force on the plate instead of the reaction on the body."""
    reverse_origin: bool = False
    """True if `ORIGIN` of the plates points from the surface to the plate's origin although its z is not
    positive, as some software stores the plates of treadmills with a z of 0."""
    belt_velocity: BeltVelocity = BeltVelocity()
    belt_command: ScaledChannel = ScaledChannel()
    trigger: str | None = None
    """Channel whose rising edge (`ingest.trigger_threshold_V`) is time 0; what is later than `duration_s` is
    omitted. Null: time 0 is the first frame, and the whole file is used."""
