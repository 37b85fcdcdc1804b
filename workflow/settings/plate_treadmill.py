"""Settings of the instrumented treadmill with a force plate, whatever is on its belt."""

from typing import Annotated

from pydantic import Field

from tepsipe.ingest.plate_treadmill import TreadmillOptions
from tepsipe.signals.perturbations import WindowOptions
from workflow.settings.quantities import (
    Direction,
    FilterOrder,
    Frequency,
    Offset,
    Rate,
    Scale,
    Side,
    Sign,
    different,
    fixed,
    some,
)
from workflow.settings.section import Section, made_from, optional, partial, setting

# from raw files to signals on one clock
TreadmillIngest = made_from(TreadmillOptions, without=("resample_rate_hz",), needed=("max_gap_s",))
TriggerIngest = made_from(TreadmillOptions, without=("resample_rate_hz", "max_gap_s", "marker_sampling_hz"))


MarkerLabels = different(str, least=2)


class PlacedMarker(Section):
    """Marker on a segment."""

    label: str = setting("name of the marker")
    anterior_offset_m: Offset = setting(
        "anterior offset from the axis of the segment, of the foot from the ankle"
    )
    longitudinal_offset_m: Offset = setting(
        "offset along the axis from the lower joint, of the foot above the ankle"
    )


PlacedMarkers = some(PlacedMarker, least=2)


Window = made_from(WindowOptions)


class Axes(Section):
    """Directions in the file."""

    forward: Direction = setting("direction in the file in which a positive belt velocity moves the belt")
    up: Direction = setting("upward direction in the file")


Plates = different(Annotated[int, Field(ge=1)], least=0)


class PlateNumbers(Section):
    """Force plates under each belt."""

    left: Plates = setting(
        "numbers of the force plates under the left belt, from 1; loads of several are added. A belt may "
        "have none"
    )
    right: Plates = setting("the same of the right belt")


class LoadCell(Section):
    """Load cell of a belt that is not among the force plates of the file."""

    channel: str = setting("label of the channel")
    newton_per_unit: Scale = setting("reaction on the body per unit of the channel")
    direction: Direction = setting("direction in the axes of the file")
    position_m: fixed(Offset, 3) = setting("point of application in the axes of the file")


class LoadCells(Section):
    """Load cells of each belt."""

    left: list[LoadCell] = setting(
        "load cells of the left belt that are not among the force plates of the file; their forces and "
        "moments are added to those of the plates"
    )
    right: list[LoadCell] = setting("the same of the right belt")


class BeltCommand(Section):
    """Channel of a velocity of the belt."""

    channel: str | None = setting("label of the channel; null without one")
    m_per_s_per_unit: Scale | None = setting("velocity per unit of it; null takes it from the channel's unit")
    offset: float = setting("its value at rest, in its unit")


class BeltVelocity(BeltCommand):
    """Velocity of the belt, from a channel or from belt-fixed markers."""

    markers: different(str, least=0) = setting(
        "belt-fixed markers, whose mean velocity is used if there is no channel, and which align D-Flow's "
        "record file"
    )


class Recording(Section):
    """Trials whose log is one file that holds everything."""

    axes: Axes
    plates: PlateNumbers
    load_cells: LoadCells
    force_sign: Sign = setting(
        "−1 if the plates give the force on the plate instead of the reaction on the body"
    )
    reverse_origin: bool = setting(
        "true if `ORIGIN` of the plates points from the surface to the plate's origin although its z is not "
        "positive, as some software stores the plates of treadmills with a z of 0"
    )
    belt_velocity: BeltVelocity
    belt_command: BeltCommand
    trigger: str | None = setting(
        "channel whose rising edge (`ingest.trigger_threshold_V`) is time 0; what is later than `duration_s` "
        "is omitted. Null: time 0 is the first frame, and the whole file is used"
    )


class Plate(Section):
    """Belt, rate and filter of all trials on the treadmill."""

    belt: Side = setting(
        "the perturbed belt, empty or under the weight, the foot of the dummy or both feet of a person; the "
        "column `belt` of the trial sheet overrides it for one trial",
        thesis="2-1-2, 2-2",
    )
    resample_rate_hz: Rate = setting("rate of the trials; must be that of the markers", thesis="3-1-2")
    lowpass_cutoff_hz: Frequency = setting(
        "Butterworth low-pass of forces, moments, markers, belt velocity and rectified electromyograms",
        thesis="3-1-2",
    )
    lowpass_order: FilterOrder = setting("order of both passes together", thesis="3-1-2")


class RecordingException(Section):
    """Recording of one experiment that differs."""

    unfolded = False

    recording: partial(Recording) = optional("keys of `recording` with other values")


class PlateException(partial(Plate), RecordingException):
    """Settings of one experiment that differ."""


class Exceptions(Section):
    """What differs for one experiment."""

    dummy: PlateException = optional(
        "keys of `plate_treadmill` with other values, for example `{belt: left}`; refused in a study with "
        "the weight, except `recording`, of which an exception replaces the named keys"
    )
    standing: PlateException = optional("the same for `standing`")
    weight: RecordingException = optional("`recording` with other values")
    empty: RecordingException = optional("the same for `empty`")


class PlateTreadmill(Plate):
    """The instrumented treadmill of `dummy`, `weight`, `empty` and `standing`."""

    recording: Recording
    exceptions: Exceptions
