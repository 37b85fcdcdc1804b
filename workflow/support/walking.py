"""Trial sheet of a study of walking."""

from dataclasses import dataclass
from pathlib import Path

from tepsipe.errors import InputError, listed, quoted
from workflow.support.names import check_name

COLUMNS = ("condition", "recording", "events", "source")


@dataclass(frozen=True)
class WalkingTrial:
    """A row of the sheet: paths of the recording and of its events."""

    recording: str
    events: str


def read_walking_sheet(path: str | Path, recordings_folder: str | Path) -> dict[str, WalkingTrial]:
    """Trials by condition, in the order of the sheet."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: expected the trial sheet of walking, found {error}: write it") from None
    header, *lines = [line.split("\t") for line in text.splitlines() if line.strip() and line[0] != "#"] or [
        []
    ]
    if tuple(header) != COLUMNS:
        raise InputError(
            f"{path}: expected the tab-separated columns {listed(COLUMNS)}, found {listed(header)}: correct "
            "the header"
        )
    found: dict[str, WalkingTrial] = {}
    for line in lines:
        cells = dict(zip(COLUMNS, map(str.strip, line), strict=False))
        if len(line) != len(COLUMNS) or not all(cells.values()) or cells["source"] != "recorded":
            raise InputError(
                f"{path}: expected a name, two files and the source recorded in every row, found "
                f"{quoted(' '.join(line))}: correct the row"
            )
        if cells["condition"] in found:
            raise InputError(
                f"{path}: expected every condition once, found {quoted(cells['condition'])} again: rename it"
            )
        check_name(cells["condition"], "condition", str(path))
        files = (str(Path(recordings_folder) / cells[kind]) for kind in ("recording", "events"))
        found[cells["condition"]] = WalkingTrial(*files)
    if not found:
        raise InputError(f"{path}: expected at least one trial, found none: add a row")
    return found
