"""Raw files of a person standing on the plate treadmill to a trial on one clock."""

from tepsipe.arguments import options_of
from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.ingest.standing import ingest_standing_files
from tepsipe.ingest.treadmill_options import RecordingOptions, TreadmillOptions
from tepsipe.io.trial import Trial


def ingest(
    files: dict[str, str], section: dict, duration_s: float, named_by: dict, limits: Limits, rig: Rig
) -> tuple[Trial, dict]:
    """A plausible trial of the person, and the options used."""
    of_files, recording = section["files"], section["recording"]
    options = TreadmillOptions(**section["ingest"])
    trial = ingest_standing_files(
        files,
        of_files["marker_labels"],
        {muscle: choice["channel"] for muscle, choice in section["muscles"].items()},
        of_files["emg_trigger"],
        of_files["emg_trigger_threshold"],
        options,
        duration_s,
        options_of(RecordingOptions, recording or {}),
    )
    used = vars(options) | ({} if recording is None else {"recording": recording})
    return plausible_trial(trial, limits, rig, files), used
