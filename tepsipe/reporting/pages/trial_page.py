"""A page of one trial: panels of traces over common axes, with a header and tables.

The pages of the experiments say what is shown; this module lays it out, decimates the traces so that the page
stays small, and writes one file of HTML.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

import numpy as np

from tepsipe.reporting.pages.decimation import Run, decimate, pack, plan_runs
from tepsipe.reporting.pages.html import asset, document, json_script, text

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


def render(page: Page, places: Links = NO_LINKS, files: Links = NO_LINKS) -> str:
    """The page as one file of HTML (units in its labels), the same for the same content.

    ``places`` lead to the report and to other trials, ``files`` to what the page was made from.
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
    content = (
        f'<header>\n{_links("Report and trials", places)}<p class="study">{text(page.study)}</p>\n'
        f"<h1>{text(page.title)}</h1>\n{_links('Files', files)}</header>\n"
        f"<main>\n{page.header}{_tools(bool(page.windows))}"
        '<noscript><p class="warning">The plots need JavaScript; the tables do not.</p></noscript>\n'
        f'{"".join(body)}{page.footer}<p class="small">{text(resolution)}</p>\n</main>\n'
        f"{json_script('data', data)}\n<script>\n{asset('plot.js')}</script>\n"
    )
    return document(f"{page.title} \N{EN DASH} {page.study}", content)


def write_page(path: str | Path, page: Page, places: Links = NO_LINKS, files: Links = NO_LINKS) -> None:
    """Write a page as one file of HTML (units in its labels), with links as in `render`."""
    Path(path).write_text(render(page, places, files), encoding="utf-8", newline="\n")


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
        '<span class="hint">Drag to zoom, double-click to reset; keys: ← → + − 0'
        f"{' n p' if windows else ''}</span></nav>\n"
    )


def _resolution(coarsest_s: float, focused: bool) -> str:
    if coarsest_s == 0.0:
        return "The plots show every sample."
    extremes = f"the minimum and the maximum of every {1e3 * coarsest_s:.3g} ms or less, so no peak is lost."
    if focused:
        return f"The plots show every sample around perturbations, and elsewhere {extremes}"
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
