"""Settings of the instrumented treadmill with a force plate, whatever is on its belt."""

from tepsipe.ingest.treadmill_options import RecordingOptions, TreadmillOptions
from tepsipe.quantities import FilterOrder, Frequency, Offset, Rate, Side
from tepsipe.signals.perturbations import WindowOptions
from workflow.settings.section import (
    Section,
    different,
    made_from,
    modelled,
    optional,
    partial,
    setting,
    some,
)

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


Recording = made_from(RecordingOptions)


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
    lowpass_order: modelled(FilterOrder) = setting("order of both passes together", thesis="3-1-2")


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
