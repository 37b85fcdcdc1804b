"""A format of files, as its reader declares it; and the contents of one file: channels, rates and gaps."""

import gzip
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from tepsipe.io.readers.plain_file import is_gzip

HEAD_BYTES = 8192


@dataclass(frozen=True)
class Channel:
    """One signal of a file."""

    name: str
    """Its name in the file."""
    unit: str
    """Its unit as given in the file; empty if there is none."""
    rate_hz: float | None
    """Sampling rate (Hz); None where the file gives none."""
    shape: tuple[int, ...]
    """Samples, and further axes."""
    missing: int
    """Number of instants with missing samples."""
    low: float
    high: float
    """Smallest and largest value (``unit``); NaN where there are no numbers."""
    longest_gap: int
    """Length of the longest run of instants with missing samples."""
    values: np.ndarray | None = field(repr=False, compare=False)
    """The samples (``unit``), shape ``shape``; None if there are no numbers."""

    @classmethod
    def of(cls, name: str, unit: str, rate_hz: float | None, values: np.ndarray) -> "Channel":
        """Describe samples (``unit``), shape (n, ...), taken at ``rate_hz`` (Hz)."""
        values = np.asarray(values)
        if values.dtype.kind not in "fiub" or not values.size:
            return cls(name, unit, rate_hz, values.shape, 0, np.nan, np.nan, 0, None)
        finite = np.isfinite(values)
        if finite.all():
            return cls(
                name, unit, rate_hz, values.shape, 0, float(values.min()), float(values.max()), 0, values
            )
        low, high = (float(f(values[finite])) if finite.any() else np.nan for f in (np.min, np.max))
        gaps = ~finite.reshape(values.shape[0], -1).all(axis=1) if values.ndim else ~finite.reshape(1)
        edges = np.flatnonzero(np.diff(np.concatenate(([False], gaps, [False]))))
        longest = int(np.diff(edges)[::2].max(initial=0))
        return cls(name, unit, rate_hz, values.shape, int(gaps.sum()), low, high, longest, values)

    def missing_text(self) -> str:
        """Share of missing samples and longest gap as text (%, s or samples), empty if there is none."""
        if not self.missing:
            return ""
        longest = (
            f"{self.longest_gap}" if self.rate_hz is None else f"{self.longest_gap / self.rate_hz:.4g} s"
        )
        return f"{100.0 * self.missing / max(self.shape[:1] or (1,)):.3g} %, longest {longest}"


@dataclass(frozen=True)
class Contents:
    """Contents of a file."""

    kind: str
    """Kind of file."""
    facts: dict[str, str]
    """Further properties given in the file (units in the text)."""
    channels: list[Channel]
    """Its signals."""
    markers: tuple[str, ...] = ()
    """Names of the channels that are positions, x, y, z."""
    plates: tuple[Channel, ...] = ()
    """Vertical force on each force plate (N)."""
    events: tuple[tuple[str, float], ...] = ()
    """Label and time (s) of each event, in the order of time."""
    vertical: int = 2
    """Vertical axis of the positions: 2 for z."""

    def summary(self) -> str:
        """The contents as text, one line per channel."""
        lines = [self.kind, *(f"{key}: {value}" for key, value in self.facts.items()), ""]
        rows = [("channel", "unit", "rate (Hz)", "shape", "missing", "smallest", "largest")]
        rows += [
            (
                c.name,
                c.unit or "–",
                "–" if c.rate_hz is None else f"{c.rate_hz:g}",
                " x ".join(map(str, c.shape)) or "1",
                c.missing_text() or "0",
                *("–" if np.isnan(x) else f"{x:.4g}" for x in (c.low, c.high)),
            )
            for c in self.channels
        ]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        for row in rows:
            label = "  ".join(cell.ljust(w) for cell, w in zip(row[:2], widths[:2], strict=True))
            right = "  ".join(cell.rjust(w) for cell, w in zip(row[2:], widths[2:], strict=True))
            lines.append(f"{label}  {right}")
        return "\n".join(lines)


@dataclass(frozen=True)
class Head:
    """Beginning of a file, by which its format is recognised."""

    content: bytes
    """First bytes, unpacked if the file is compressed with gzip; empty if it cannot be read."""
    ending: str = ""
    """Ending of its name, as by `ending_of`."""

    @classmethod
    def of(cls, path: str | Path) -> "Head":
        """Read the beginning of a file."""
        return cls(_first_bytes(Path(path)), ending_of(path))

    @cached_property
    def text(self) -> str:
        """The beginning as text; empty if it is binary."""
        return "" if b"\0" in self.content else self.content.decode("utf-8-sig", errors="replace")

    @cached_property
    def first_line(self) -> str:
        """First line that is neither blank nor begins with ``#``; empty if there is none."""
        lines = (line for line in self.text.splitlines() if line.strip())
        return next((line for line in lines if not line.startswith("#")), "")


def _first_bytes(path: Path) -> bytes:
    try:
        if not path.is_file():
            return b""
        if not is_gzip(path):
            with path.open("rb") as file:
                return file.read(HEAD_BYTES)
        with gzip.open(path, "rb") as file:
            return file.read(HEAD_BYTES)
    except (OSError, EOFError, ValueError, zlib.error):
        return b""


def ending_of(path: str | Path) -> str:
    """Ending of a file's name in lower case, without the ending of gzip."""
    suffixes = [suffix.lower() for suffix in Path(path).suffixes]
    return "".join((suffixes[:-1] if suffixes[-1:] == [".gz"] else suffixes)[-1:])


@dataclass(frozen=True, kw_only=True)
class Format:
    """A format of files; its module declares it as ``FORMAT``, and `tepsipe.io.formats` lists the module with
    the purposes of its readers.
    """

    name: str
    """Its name in messages."""
    fits: Callable[[Head], bool]
    """Recognises a file by its `Head`."""
    contents: "Callable[[Path], Contents]"
    """Takes a path and returns the `Contents` of the file."""
    endings: tuple[str, ...] = ()
    """Endings of the names of its files, in lower case."""
    text: bool = False
    """True if its files are text."""
    needs_ending: bool = False
    """True if its beginning is not characteristic: the ending of the name decides, and other formats that
    fit take precedence."""
    purpose: "str | Callable[[Contents], tuple[str, str]]" = ""
    """Purpose of its files in a study: ``markers``, ``emg``, ``whole trial``, ``table`` (which follows from
    its columns), or empty. A function takes the contents and returns a purpose and, for ``other``, the
    reason why the file is not used."""
    lacks: tuple[str, ...] = ()
    """Purposes of the files beside a whole trial in this format that complete it."""
    lists_events: bool = False
    """True if the contents list events of gait."""
    page: str = ""
    """Page of the documentation on whole trials in this format."""
    read_recording: Callable | None = None
    read_markers: Callable | None = None
    read_emg: Callable | None = None
    """Readers of a whole trial (path to `Recording`), of all markers (path to `Markers`), and of
    electromyograms (path, channels and trigger to `EmgRecording`), if files in this format hold them."""

    def purpose_of(self, contents: "Contents") -> tuple[str, str]:
        """Purpose of a file by its contents and, for ``other``, the reason why it is not used."""
        if callable(self.purpose):
            return self.purpose(contents)
        if not self.purpose:
            return "other", f"{contents.kind} is no recording of an instrument"
        return self.purpose, ""
