"""Raw files of a trial with the ankle dummy on the belt to a trial on one clock."""

from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.whole_trial import ingest_on_plate
from tepsipe.io.trial import Trial


def ingest(
    files: dict[str, str], section: dict, duration_s: float, named_by: dict, limits: Limits, rig: Rig
) -> tuple[Trial, dict]:
    """A plausible trial of the dummy, and the options used."""
    labels = section["files"]["marker_labels"]
    return ingest_on_plate(files, labels, section["ingest"], section["recording"], duration_s, limits, rig)
