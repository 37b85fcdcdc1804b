"""A page of one trial: panels of traces over common axes, with a header and tables, as one file of HTML.

The pages of the experiments say what is shown; this module lays it out. Everything that a user may have named
is escaped.

Long traces keep fewer points, without losing an extreme: samples around perturbations are kept, the others
are grouped into buckets of equal length, of which the lowest and the highest sample are kept, in their order
in time.
"""

import base64
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from types import MappingProxyType
from typing import Annotated

import numpy as np

from tepsipe.io.trial import Trial
from tepsipe.signals.resampling import runs_of

# points of all traces together: two bytes each, 4/3 of that as text
MOST_POINTS = 240_000
MOST_PER_TRACE = 12_000
# Okabe and Ito (2008), without their yellow, which is too light for a line
COLOURS = {
    "black": "#1b1b1b",
    "blue": "#0072b2",
    "vermilion": "#d55e00",
    "green": "#009e73",
    "orange": "#e69f00",
    "purple": "#cc79a7",
    "sky": "#56b4e9",
    "grey": "#8a8a8a",
}
CYCLE = tuple(
    (colour, dash)
    for dash in ("", "6 3", "2 2")
    for colour in ("blue", "vermilion", "green", "purple", "orange", "sky")
)
NO_LINKS: Mapping[str, str] = MappingProxyType({})
BANDS = {
    "window": "fitted window",
    "epoch": "epoch used",
    "hidden": "filled or hidden",
    "left-out": "left out",
    "held-out": "held out",
    "cut": "not used",
}


@dataclass(frozen=True)
class Clock:
    """Regular instants that several traces share."""

    start_s: float
    rate_hz: float
    """First instant (s) and rate (Hz)."""
    size: int
    """Number of samples."""
    focus: tuple[tuple[int, int], ...] = ()
    """Parts that are drawn with every sample (samples)."""

    @classmethod
    def of(cls, time: np.ndarray, focus_s: Sequence[tuple[float, float]] = ()) -> "Clock":
        """Clock of regular instants (s), with the parts to draw with every sample (s)."""
        rate = (time.size - 1) / float(time[-1] - time[0]) if time.size > 1 else 1.0
        parts = tuple(
            (int(np.floor((a - time[0]) * rate)), int(np.ceil((b - time[0]) * rate)) + 1) for a, b in focus_s
        )
        return cls(float(time[0]), rate, time.size, parts)


@dataclass(frozen=True)
class Trace:
    """One curve."""

    label: str
    """Name in the legend."""
    values: np.ndarray
    """Samples (unit of the panel)."""
    clock: Clock
    """Their instants."""
    colour: str = "black"
    dash: str = ""
    """Name in `COLOURS`, and lengths of dashes and gaps (pixels), empty for a solid line."""
    width: float = 1.3
    """Of the line (pixels)."""


@dataclass(frozen=True)
class Band:
    """A marked stretch of an axis."""

    kind: str
    """One of `BANDS`."""
    start_s: float
    stop_s: float
    """Its ends."""
    label: str = ""
    """What is written where it is pointed at."""


@dataclass(frozen=True)
class Panel:
    """Traces over one axis."""

    title: str
    unit: str
    """Quantity, and its unit with symbols."""
    traces: tuple[Trace, ...]
    """The curves; a panel without any is left out."""
    bands: tuple[Band, ...] = ()
    """Marked stretches (s)."""
    axis: str = "time"
    """Name of the axis in `Page.axes`."""
    note: str = ""
    """A sentence below the title."""


@dataclass(frozen=True)
class Section:
    """Panels with a heading (no unit): ``heading``, ``panels``, and a sentence ``note``."""

    heading: str
    panels: tuple[Panel, ...]
    note: str = ""


@dataclass(frozen=True)
class Page:
    """All that a page shows."""

    title: str
    """Experiment and condition."""
    study: str
    """Title of the study."""
    header: str
    """HTML above and below the panels."""
    sections: tuple[Section, ...]
    """The panels."""
    footer: str = ""
    windows: tuple[Band, ...] = ()
    """Perturbations, to which the reader can jump (s)."""
    axes: dict[str, str] = field(default_factory=lambda: {"time": "Time (s)"})
    """Name -> label with unit."""


# words of a link -> address relative to the page
Links = Mapping[str, str]


def render(page: Page, places: Links = NO_LINKS, files: Links = NO_LINKS, again: str = "") -> str:
    """The page as one file of HTML (units in its labels), the same for the same content.

    ``places`` lead to the report and to other trials, ``files`` to what the page was made from; ``again`` is
    the command that makes the trial again.
    """
    sections = [
        Section(s.heading, tuple(p for p in s.panels if p.traces), s.note)
        for s in page.sections
        if any(p.traces for p in s.panels)
    ]
    panels = [panel for section in sections for panel in section.panels]
    data, resolution = _data(page, panels)
    number, body = 0, []
    for section in sections:
        body.append(f"<section>\n<h2>{text(section.heading)}</h2>\n")
        if section.note:
            body.append(f"<p>{text(section.note)}</p>\n")
        for panel in section.panels:
            body.append(_figure(panel, number))
            number += 1
        body.append("</section>\n")
    files_of_run = " (add the <code>--configfile</code> options of the run, if it had any)"
    made_again = (
        f'<p class="again">Repeat this trial: <code>{text(again)}</code>{files_of_run}</p>\n' if again else ""
    )
    content = (
        f'<header>\n{_links("Report and trials", places)}<p class="study">{text(page.study)}</p>\n'
        f"<h1>{text(page.title)}</h1>\n{_links('Files', files)}{made_again}</header>\n"
        f"<main>\n{page.header}{_tools(bool(page.windows))}"
        '<noscript><p class="warning">The plots need JavaScript; the tables do not.</p></noscript>\n'
        f'<p class="small">{text(resolution)}</p>\n{"".join(body)}{page.footer}</main>\n'
        f"{json_script('data', data)}\n<script>\n{asset('plot.js')}</script>\n"
    )
    return document(f"{page.title} \N{EN DASH} {page.study}", content)


def write_page(
    path: str | Path, page: Page, places: Links = NO_LINKS, files: Links = NO_LINKS, again: str = ""
) -> None:
    """Write a page as one file of HTML (units in its labels), with links and command as in `render`."""
    Path(path).write_text(render(page, places, files, again), encoding="utf-8", newline="\n")


def _links(name: str, links: Links) -> str:
    shown = "".join(f'<a href="{text(path)}">{text(words)}</a> ' for words, path in links.items())
    return f'<nav class="links" aria-label="{text(name)}">{shown}</nav>\n' if links else ""


# size of a thumbnail (pixels), and what it shows before and after the onset of a perturbation (s)
SMALL = (120, 32)
AROUND_S = (0.2, 1.2)


def thumbnail(page: Page) -> str:
    """A small picture (SVG) of the angle, the force or the first curve around one perturbation."""
    panels = [panel for section in page.sections for panel in section.panels if panel.traces]
    named = [panel for panel in panels if panel.title.startswith(("Angle", "Ankle", "Fore-aft"))]
    if not panels:
        return _picture("")
    panel = (named or panels)[0]
    trace, windows = panel.traces[0], page.windows
    time = trace.clock.start_s + np.arange(trace.clock.size) / trace.clock.rate_hz
    middle = windows[len(windows) // 2].start_s if windows else 0.5 * (time[0] + time[-1])
    before, after = AROUND_S if windows else (1.5, 1.5)
    shown = (time >= middle - before) & (time <= middle + after) & np.isfinite(trace.values)
    if shown.sum() < 2:
        return _picture("")
    x, y = time[shown], np.asarray(trace.values, dtype=float)[shown]
    step = max(1, x.size // SMALL[0])
    x, y = x[::step], y[::step]
    height = float(np.ptp(y)) or 1.0
    across = (x - x[0]) / (x[-1] - x[0]) * (SMALL[0] - 2) + 1.0
    down = (y.max() - y) / height * (SMALL[1] - 4) + 2.0
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, down, strict=True))
    return _picture(f'<polyline points="{points}" fill="none" stroke="#1668a8" stroke-width="1.2"/>')


def _picture(content: str) -> str:
    width, height = SMALL
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}">{content}</svg>\n'


def _figure(panel: Panel, number: int) -> str:
    unit = f" ({panel.unit})" if panel.unit else ""
    note = f'<span class="note">{text(panel.note)}</span>' if panel.note else ""
    return (
        f'<figure class="panel" id="panel-{number}"><figcaption><b>{text(panel.title + unit)}</b>{note}'
        '</figcaption><div class="legend"></div><div class="plot"></div></figure>\n'
    )


def _tools(windows: bool) -> str:
    jump = (
        '<button type="button" data-do="previous" title="Previous perturbation (p)">◀ perturbation</button>'
        '<button type="button" data-do="next" title="Next perturbation (n)">perturbation ▶</button>'
    )
    return (
        '<nav class="tools" aria-label="View">'
        f"{jump if windows else ''}"
        '<button type="button" data-do="in" title="Zoom in (+)">+</button>'
        '<button type="button" data-do="out" title="Zoom out (−)">−</button>'
        '<button type="button" data-do="all" title="Whole trial (0)">whole trial</button>'
        '<button type="button" id="theme" aria-label="Light or dark">◐</button><output id="view"></output>'
        '<span class="hint">Drag to zoom, double-click to reset. Keys: ← → move, + − zoom, 0 whole trial'
        f"{', n and p next and previous perturbation' if windows else ''}.</span></nav>\n"
    )


def _resolution(coarsest_s: float, focused: bool) -> str:
    if coarsest_s == 0.0:
        return "The plots show every sample."
    extremes = (
        f"the minimum and maximum of intervals of at most {1e3 * coarsest_s:.3g} ms, so no peak is lost."
    )
    if focused:
        return f"Around perturbations the plots show every sample. Elsewhere they show {extremes}"
    return f"The plots show {extremes}"


# ---- data for the script -------------------------------------------------------------------------


def _data(page: Page, panels: list[Panel]) -> tuple[dict, str]:
    """Content of the script's data, and a sentence about the length of the buckets (s)."""
    points = _points([trace.clock.size for panel in panels for trace in panel.traces])
    clocks: dict[Clock, tuple[int, tuple[Run, ...]]] = {}
    drawn = [_panel(panel, clocks, points) for panel in panels]
    longest = [
        run.step / clock.rate_hz for clock, (_, runs) in clocks.items() for run in runs if run.step > 1
    ]
    focused = any(len(runs) > 1 for _, runs in clocks.values())
    return {
        "axes": {
            name: {"label": label, "windows": [_band(b) for b in page.windows] if name == "time" else []}
            for name, label in page.axes.items()
        },
        "colours": COLOURS,
        "bands": BANDS,
        "clocks": [
            {"start": c.start_s, "rate": c.rate_hz, "runs": [[r.start, r.stop, r.step] for r in runs]}
            for c, (_, runs) in clocks.items()
        ],
        "panels": drawn,
    }, _resolution(max(longest, default=0.0), focused)


def _points(sizes: list[int]) -> int:
    """Points for each trace (-): short ones need all of theirs, long ones share the rest equally."""
    left, points = MOST_POINTS, 0
    for k, size in enumerate(sorted(sizes)):
        points = left // (len(sizes) - k)
        if size > points:
            break
        left -= size
    return min(MOST_PER_TRACE, points)


def _panel(panel: Panel, clocks: dict, points: int) -> dict:
    traces = []
    for trace in panel.traces:
        clock = trace.clock
        if clock not in clocks:
            clocks[clock] = (len(clocks), plan_runs(clock.size, points, clock.focus))
        number, runs = clocks[clock]
        packed = pack(decimate(trace.values, runs))
        traces.append(
            {
                "label": trace.label,
                "colour": trace.colour,
                "dash": trace.dash,
                "width": trace.width,
                "clock": number,
                "offset": packed.offset,
                "scale": packed.scale,
                "data": packed.text,
            }
        )
    return {
        "axis": panel.axis,
        "title": panel.title,
        "unit": panel.unit,
        "traces": traces,
        "bands": [_band(band) for band in panel.bands],
    }


def _band(band: Band) -> list:
    return [band.kind, round(band.start_s, 5), round(band.stop_s, 5), band.label]


# styles and scripts of the pages, which are written into them
WEB = Path(__file__).with_name("web")
# nothing is loaded from anywhere: a page that tried it would be stopped by the browser
POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"


def text(value: object) -> str:
    """Any value as text of a page or of an attribute (no unit)."""
    return escape(str(value), quote=True)


def json_script(identifier: str, content: object) -> str:
    """Data for the page's script (any unit), which no text in it can end."""
    plain = json.dumps(content, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    plain = plain.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
    return f'<script type="application/json" id="{text(identifier)}">{plain}</script>'


def asset(name: str) -> str:
    """Text of a file of the folder ``web`` (no unit), for example plot.js."""
    return (WEB / name).read_text(encoding="utf-8")


def table(header: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "", kind: str = "") -> str:
    """A table (units in its header) of cells that are HTML already; the first of every row is its heading."""
    head = "".join(f'<th scope="col">{cell}</th>' if cell else "<td></td>" for cell in header)
    body = "".join(
        f'<tr><th scope="row">{row[0]}</th>' + "".join(f"<td>{cell}</td>" for cell in row[1:]) + "</tr>\n"
        for row in rows
    )
    about = f"<caption><span>{caption}</span></caption>" if caption else ""
    return (
        f'<div class="wide" tabindex="0"><table class="{text(kind)}">{about}<thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{body}</tbody></table></div>\n"
    )


def document(title: str, body: str, policy: str | None = POLICY) -> str:
    """A whole page (no unit) with the style of all pages; ``title`` is plain text, ``body`` is HTML."""
    guard = f'<meta http-equiv="Content-Security-Policy" content="{text(policy)}">\n' if policy else ""
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"{guard}"
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{text(title)}</title>\n<style>\n{asset('page.css')}</style>\n"
        f"<script>\n{asset('theme.js')}</script>\n</head>\n"
        f"<body>\n{body}</body>\n</html>\n"
    )


LARGEST = 32767
MISSING = -32768


@dataclass(frozen=True)
class Run:
    """Consecutive samples that are kept, or grouped into buckets."""

    start: int
    stop: int
    """First sample, and the one after the last (samples)."""
    step: int
    """1 where every sample is kept, otherwise the length of a bucket (samples)."""

    @property
    def points(self) -> int:
        """Number of points that remain (-)."""
        length = self.stop - self.start
        return length if self.step == 1 else 2 * -(-length // self.step)


def plan_runs(samples: int, points: int, focus: Sequence[tuple[int, int]] = ()) -> tuple[Run, ...]:
    """Decide which samples to keep and which to group.

    samples: length of the trace (samples).
    points: number of points that may remain (-), apart from two for each part of the trace.
    focus: parts that are kept whole if they fit into three quarters of the points (samples).
    Returns: runs that cover the trace without gaps (samples).
    """
    if samples <= points:
        return (Run(0, samples, 1),) if samples else ()
    parts = _merged(focus, samples)
    kept = sum(stop - start for start, stop in parts)
    if not parts or kept > 0.75 * points:
        return (Run(0, samples, max(2, -(-2 * samples // points))),)
    step = max(2, -(-2 * (samples - kept) // (points - kept)))
    runs, at = [], 0
    for start, stop in parts:
        if start > at:
            runs.append(Run(at, start, step))
        runs.append(Run(start, stop, 1))
        at = stop
    if at < samples:
        runs.append(Run(at, samples, step))
    return tuple(runs)


def _merged(focus: Sequence[tuple[int, int]], samples: int) -> list[tuple[int, int]]:
    """Parts in their order, clipped to the trace, those that touch joined."""
    merged: list[tuple[int, int]] = []
    for start, stop in sorted((max(0, int(a)), min(samples, int(b))) for a, b in focus):
        if stop <= start:
            continue
        if merged and start <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(stop, merged[-1][1]))
        else:
            merged.append((start, stop))
    return merged


def decimate(x: np.ndarray, runs: Sequence[Run]) -> Annotated[np.ndarray, "(points,)"]:
    """Points of a trace that remain.

    x: the trace (any unit); NaN where a sample is missing.
    runs: from `plan_runs` (samples).
    Returns: samples, or lowest and highest of each bucket in their order (unit of ``x``); NaN for a bucket
    without a sample.
    """
    x = np.asarray(x, dtype=float)
    parts = [x[r.start : r.stop] if r.step == 1 else _extremes(x[r.start : r.stop], r.step) for r in runs]
    return np.concatenate(parts) if parts else np.empty(0)


def _extremes(x: np.ndarray, step: int) -> np.ndarray:
    full = np.full(-(-x.size // step) * step, np.nan)
    full[: x.size] = np.where(np.isfinite(x), x, np.nan)
    buckets = full.reshape(-1, step)
    missing = np.isnan(buckets)
    low = np.where(missing, np.inf, buckets).argmin(axis=1)
    high = np.where(missing, -np.inf, buckets).argmax(axis=1)
    at = np.sort(np.column_stack([low, high]), axis=1)
    return np.take_along_axis(buckets, at, axis=1).ravel()


@dataclass(frozen=True)
class Packed:
    """A trace as 16-bit numbers in text."""

    offset: float
    scale: float
    """The value is offset + scale * number (unit of the trace)."""
    text: str
    """Numbers, two bytes each, the low byte first, in base64; the lowest number is a missing sample."""


def pack(x: Annotated[np.ndarray, "(points,)"]) -> Packed:
    """Write points as 16-bit numbers: the step is 1/65534 of their range.

    x: from `decimate` (any unit).
    Returns: text, and what brings it back to the unit of ``x``.
    """
    there = np.isfinite(x)
    low, high = (float(x[there].min()), float(x[there].max())) if there.any() else (0.0, 0.0)
    offset, scale = 0.5 * low + 0.5 * high, (0.5 * high - 0.5 * low) / LARGEST
    numbers = np.full(x.size, MISSING, dtype="<i2")
    if scale > 0.0:
        steps = np.rint((x[there] - offset) / scale)
        numbers[there] = np.clip(steps, -LARGEST, LARGEST).astype("<i2")
    else:
        numbers[there] = 0
    return Packed(offset, scale, base64.b64encode(numbers.tobytes()).decode("ascii"))


def unpack(packed: Packed) -> np.ndarray:
    """Points of a packed trace, as the page reads them (unit of the trace), shape (points,)."""
    numbers = np.frombuffer(base64.b64decode(packed.text), dtype="<i2")
    return np.where(numbers == MISSING, np.nan, packed.offset + packed.scale * numbers)


MOST_BANDS = 300


def belt_panel(trial: Trial, clock: Clock, bands: Sequence[Band]) -> Panel:
    """Measured and commanded velocity of the belt (m/s)."""
    traces = [Trace("measured", trial.values("belt_velocity"), clock, "black")]
    command = trial.optional("belt_command")
    if command is not None:
        traces.append(Trace("command", command, clock, "vermilion", "5 3"))
    return Panel("Belt velocity", "m/s", tuple(traces), tuple(bands))


def marker_panels(trial: Trial, clock: Clock) -> list[Panel]:
    """Positions of all markers along the belt and upwards, from their medians (mm)."""
    if "marker_position" not in trial.signals:
        return []
    positions, labels = trial.values("marker_position"), trial.axes["marker"].tolist()
    hidden = hidden_bands(trial)
    panels = []
    for axis, title in ((1, "Markers along the belt"), (2, "Markers, vertical")):
        shown = 1e3 * positions[:, :, axis].astype(float)
        shown -= np.nanmedian(shown, axis=0)
        traces = [
            Trace(label, shown[:, k], clock, *CYCLE[k % len(CYCLE)], 1.0) for k, label in enumerate(labels)
        ]
        panels.append(
            Panel(title, "mm", tuple(traces), tuple(hidden), note="relative to each marker's median")
        )
    return panels


def hidden_bands(trial: Trial) -> list[Band]:
    """Stretches (s) in which a marker was hidden and its position was filled."""
    hidden = trial.optional("marker_hidden")
    if hidden is None or not hidden.any():
        return []
    time, labels = trial.time, trial.axes["marker"]
    bands = []
    for start, stop in runs_of(np.asarray(hidden).astype(bool).any(axis=1))[:MOST_BANDS]:
        which = ", ".join(labels[np.asarray(hidden)[start:stop].any(axis=0)].tolist())
        bands.append(Band("hidden", float(time[start]), float(time[stop - 1]), f"hidden: {which}"))
    return bands


def hidden_sentences(trial: Trial) -> list[str]:
    """Sentence with the number of filled samples of every marker that was hidden, if any."""
    hidden = trial.optional("marker_hidden")
    if hidden is None or not np.asarray(hidden).any():
        return []
    counts = np.asarray(hidden).sum(axis=0)
    labels = trial.axes["marker"].tolist()
    each = ", ".join(f"{label} {count}" for label, count in zip(labels, counts, strict=True) if count)
    return [f"Samples filled in where a marker was hidden: {each}."]


def force_panels(trial: Trial, clock: Clock, belt: str, bands: Sequence[Band]) -> list[Panel]:
    """Unfiltered forces on the perturbed belt: fore-aft, vertical and sideways (N)."""
    if "force" not in trial.signals or belt not in trial.axes["belt"]:
        return []
    force = trial.values("force")[:, trial.axes["belt"].tolist().index(belt)]
    panels = []
    for axis, name, colour in ((1, "Fore-aft force", "blue"), (2, "Vertical force", "green")):
        trace = Trace("unfiltered", force[:, axis], clock, colour, width=1.0)
        note = "before the low-pass filter of the analysis"
        panels.append(Panel(f"{name}, {belt} belt", "N", (trace,), tuple(bands), note=note))
    return panels


def window_bands(time: np.ndarray, windows: np.ndarray, notes: Sequence[str] = ()) -> list[Band]:
    """Fitted windows, shape (perturbations, 2) (samples), as bands (s) with their numbers."""
    last = time.size - 1
    bands = []
    for k, (start, stop) in enumerate(windows):
        note = f": {notes[k]}" if notes else ""
        ends = (float(time[min(int(i), last)]) for i in (start, stop))
        bands.append(Band("window", *ends, f"perturbation {k + 1}{note}"))
    return bands


def cut_bands(time: np.ndarray, start: int, stop: int) -> tuple[Band, ...]:
    """Both ends that are not used (s), from the samples that are."""
    ends = []
    if start > 0:
        ends.append(Band("cut", float(time[0]), float(time[start]), "not used"))
    if stop < time.size:
        ends.append(Band("cut", float(time[stop - 1]), float(time[-1]), "not used"))
    return tuple(ends)
