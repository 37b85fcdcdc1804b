"""Description of a file of any kind: its channels, their rates, units and gaps."""

from dataclasses import dataclass, field

import numpy as np


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
