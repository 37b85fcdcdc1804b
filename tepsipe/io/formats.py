"""Registry of the formats of files, and the readers of a file of any format.

A format is recognised by the beginning of a file, plain or compressed with gzip. What the file is called
matters only where that is not enough. Modules of readers are imported by name: who reads markers depends on
those that read markers. The others are at most asked whether a file is theirs.
"""

from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from tepsipe.errors import InputError, quoted
from tepsipe.io.file_format import Contents, Format, Head, ending_of

if TYPE_CHECKING:
    from tepsipe.io.readers.recording import EmgRecording, Markers, Recording


# module that declares formats -> purposes of the files that its readers read: a whole trial, markers, emg
MODULES: dict[str, tuple[str, ...]] = {
    "tepsipe.io.readers.c3d": ("whole trial", "markers"),
    "tepsipe.io.readers.edf": ("emg",),
    "tepsipe.io.readers.mat_file": (),
    "tepsipe.io.stored": (),
    "tepsipe.io.readers.trc": ("markers",),
    "tepsipe.io.readers.any_table": ("whole trial", "markers"),
    "tepsipe.io.readers.dflow": ("whole trial",),
    "tepsipe.io.readers.emg_table": ("emg",),
}
PURPOSES = {"read_recording": "whole trial", "read_markers": "markers", "read_emg": "emg"}


def modules_for(*purposes: str) -> list[str]:
    """Names of the modules whose readers read files for one of these purposes."""
    return [name for name, own in MODULES.items() if set(own) & set(purposes)]


@cache
def formats(purpose: str | None = None) -> tuple[Format, ...]:
    """All formats, or those with a reader for a purpose, in the order in which messages list them."""
    names = MODULES if purpose is None else modules_for(purpose)
    declared = [vars(import_module(name)) for name in names]
    return tuple(known for each in declared for known in each.get("FORMATS") or (each["FORMAT"],))


@cache
def _certain_first(purpose: str | None = None) -> list[Format]:
    """The same; those whose files need the ending of their name come last."""
    return sorted(formats(purpose), key=lambda known: known.needs_ending)


def recognised(path: str | Path) -> Format | None:
    """Format of a file by its beginning alone; None if it is unknown."""
    head = Head.of(path)
    return next((known for known in _certain_first() if known.fits(head)), None)


def _recognised_for(purpose: str, path: str | Path) -> Format | None:
    """The same; formats for a purpose are asked first, all others only if none of these is certain."""
    head = Head.of(path)
    certain = (known for known in formats(purpose) if not known.needs_ending and known.fits(head))
    return next(certain, None) or recognised(path)


def format_of(path: str | Path) -> Format:
    """Format of a file by its beginning or, where that is not enough, by the ending of its name."""
    path = Path(path)
    if not path.is_file():
        found = "a folder" if path.is_dir() else "a pipe or a device" if path.exists() else "none"
        raise InputError(f"{path}: expected a file, found {found}: correct its path")
    known, ending = recognised(path), ending_of(path)
    if known is not None and not known.needs_ending:
        return known
    same_ending = [other for other in _certain_first() if ending in other.endings]
    if not same_ending:
        raise InputError(
            f"{path}: expected a file that ends in {', '.join(_endings(formats()))}, found "
            f"{ending or 'no ending'!r}: export it as one of these kinds"
        )
    return same_ending[-1]


def contents_of(path: str | Path) -> Contents:
    """Contents of a file of any format that the library reads, plain or compressed with gzip.

    path: the file; its format follows from its content or, failing that, from the ending of its name.
    """
    return format_of(path).contents(Path(path))


def holds_whole_trial(path: str | Path) -> bool:
    """Test for a name whose kind of file holds a whole trial; the file need not exist."""
    return bool(_of_whole_trials(path))


def takes_markers_beside(path: str | Path) -> bool:
    """Test for a name whose kind of file may have the markers of its whole trial in a file beside it."""
    return any(known.lacks for known in _of_whole_trials(path))


def _of_whole_trials(path: str | Path) -> list[Format]:
    """Formats of whole trials whose names end like this one."""
    if not ending_of(path):
        return []
    return [known for known in _certain_first("whole trial") if ending_of(path) in known.endings]


def read_recording(path: str | Path) -> "Recording":
    """Read a file that holds a whole trial, by the reader of its format.

    path: the file; its format follows from the ending of its name and, among texts, from its content.
    Returns: markers (m), force plates (N, N·m) and analog channels in their units.
    """
    known = _of_whole_trials(path)
    if not known:
        those = ", ".join(_endings(_certain_first("whole trial")))
        raise InputError(
            f"{path}: expected a file that holds a whole trial ({those}), found "
            f"{quoted(ending_of(path))}: name such a file as log, or a log with its calibration and markers"
        )
    head = Head.of(path)
    return next((each for each in known if each.fits(head)), known[-1]).read_recording(Path(path))


def read_all_markers(path: str | Path) -> "Markers":
    """Read all markers of a file of any format that holds them.

    path: the file, plain or, if it is text, compressed with gzip; its format follows from its content.
    Returns: rate (Hz), labels and positions (m), NaN while a marker was hidden.
    """
    known = _recognised_for("markers", path)
    if known is not None and known.text and known.read_markers is None:
        *others, last = [other.name for other in formats("markers")]
        raise InputError(
            f"{path}: expected markers as {', '.join(others)} or {last}, found {quoted(known.name)}: name "
            "D-Flow's mocap file beside its record file, and other files by their own column"
        )
    return _reader("read_markers", known)(Path(path))


def read_markers(path: str | Path, labels: list[str]) -> "Markers":
    """Read the wanted markers of a file, in the wanted order, as `read_all_markers` (Hz, m)."""
    from tepsipe.io.readers.recording import select_markers

    return select_markers(read_all_markers(path), labels, path)


def read_emg(path: str | Path, channels: dict[str, str], trigger_label: str | None) -> "EmgRecording":
    """Read the wanted muscles and the trigger of a file of any format that holds them.

    path: the file, plain or compressed with gzip; its format follows from its content.
    channels: label of the channel of each muscle. A muscle whose channel is missing is omitted and listed.
    trigger_label: label of the trigger's channel; None if the recorder was started by the trigger.
    Returns: rate (Hz), electromyograms and their limits (uV), trigger (V, or as recorded).
    """
    return _reader("read_emg", _recognised_for("emg", path))(path, channels, trigger_label)


def _reader(name: str, known: Format | None) -> Callable:
    """Reader of a file; one of another format goes to the first reader of such files, which refuses it."""
    if known is not None and getattr(known, name) is not None:
        return getattr(known, name)
    text = known is not None and known.text
    return next(getattr(other, name) for other in formats(PURPOSES[name]) if other.text == text)


def _endings(known: list[Format] | tuple[Format, ...]) -> list[str]:
    """Endings of the names of files in some formats."""
    return list(dict.fromkeys(ending for each in known for ending in each.endings))
