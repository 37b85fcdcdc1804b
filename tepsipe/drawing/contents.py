"""Picture of a file's contents: markers, vertical forces and channels over time."""

from itertools import pairwise

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from tepsipe.drawing.style import CYCLE, in_style
from tepsipe.errors import InputError
from tepsipe.io.file_format import Channel, Contents

WIDTH_IN = 9.0
BINS = 1200  # pairs of smallest and largest sample per curve: about the pixels of the width
MOST_CHANNELS = 72
MOST_NAMES = 12


def decimated(values: np.ndarray, bins: int = BINS) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest sample of each of ``bins`` stretches, in the order of time.

    values: samples (any unit); NaN where one is missing.
    Returns: places of the kept samples in ``values`` (-), and the samples; all of them if there are at most
    ``2 * bins``. A stretch without samples keeps one NaN pair, which breaks the line.
    """
    values = np.asarray(values, dtype=float)
    if values.size <= 2 * bins:
        return np.arange(values.size), values
    edges = np.linspace(0, values.size, bins + 1).astype(int)
    kept = []
    for start, stop in pairwise(edges):
        piece = values[start:stop]
        if np.isnan(piece).all():
            kept += [start, start]
        else:
            kept += sorted((start + int(np.nanargmin(piece)), start + int(np.nanargmax(piece))))
    return np.asarray(kept), values[kept]


@in_style
def draw_contents(contents: Contents, title: str) -> Figure:
    """Draw what a file holds: markers, vertical forces, and small multiples of its channels.

    title: title of the figure, as a rule the name of the file.
    """
    markers = _markers(contents)
    channels, hidden = _shown(contents)
    top = [2.0] * (2 * bool(markers)) + [1.5] * bool(contents.plates)
    columns = 1 if len(channels) <= 6 else 2 if len(channels) <= 24 else 3
    rows = -(-len(channels) // columns)
    if not top and not rows:
        raise InputError(f"{title}: expected samples to draw, found none: name a file of recorded signals")
    heights = top + [0.8] * rows
    figure = Figure(figsize=(WIDTH_IN, sum(heights) + 1.0), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    grid = figure.add_gridspec(len(heights), columns, height_ratios=heights)
    wide = [figure.add_subplot(grid[row, :]) for row in range(len(top))]
    if markers:
        _draw_markers(wide[0], markers, contents.vertical, "vertical")
        _draw_markers(wide[1], markers, _forward(markers, contents.vertical), "forward")
    if contents.plates:
        for plate in contents.plates:
            _curve(wide[-1], plate, plate.values, label=plate.name)
        wide[-1].set_ylabel("vertical force\n(N)")
        _legend(wide[-1], len(contents.plates))
    for number, channel in enumerate(channels):
        ax = figure.add_subplot(grid[len(top) + number % rows, number // rows])
        _draw_channel(ax, channel, CYCLE[number // rows % len(CYCLE)])
    _finish(figure, contents, hidden)
    return figure


def _markers(contents: Contents) -> list[Channel]:
    """Channels of positions with at least one visible sample."""
    return [c for c in contents.channels if c.name in contents.markers and np.isfinite(c.low)]


def _shown(contents: Contents) -> tuple[list[Channel], int]:
    """At most `MOST_CHANNELS` channels that change, in the order of the file, and how many others there are.

    Points of a file with markers are left out: what is no marker was computed from them.
    """
    channels = [
        c
        for c in contents.channels
        if c.name not in contents.markers and not (contents.markers and len(c.shape) > 1)
    ]
    longest = max((c.shape[0] for c in channels if c.shape), default=0)
    drawn = [c for part in channels for c in _columns(part) if c.shape[0] > 1 and c.shape[0] * 10 >= longest]
    chosen = ([c for c in drawn if c.low < c.high] or drawn)[:MOST_CHANNELS]
    return chosen, len(drawn) - len(chosen)


def _columns(channel: Channel) -> list[Channel]:
    """A channel of several columns as one channel per column."""
    if channel.values is None or len(channel.shape) not in (1, 2):
        return []
    if len(channel.shape) == 1:
        return [channel]
    return [
        Channel.of(f"{channel.name} {k + 1}", channel.unit, channel.rate_hz, channel.values[:, k])
        for k in range(channel.shape[1])
    ]


def _forward(markers: list[Channel], vertical: int) -> int:
    """Horizontal axis along which the markers move most (-)."""
    ranges = np.array(
        [
            np.nanmedian([np.nanmax(c.values[:, k]) - np.nanmin(c.values[:, k]) for c in markers])
            for k in range(3)
        ]
    )
    ranges[vertical] = -1.0
    return int(np.argmax(ranges))


def _draw_markers(ax, markers: list[Channel], axis: int, what: str) -> None:
    for number, channel in enumerate(markers):
        style = {"linestyle": ("-", "--")[number // len(CYCLE) % 2], "linewidth": 1.1}
        if len(markers) > MOST_NAMES:
            style = {"linewidth": 0.5}
        _curve(
            ax,
            channel,
            channel.values[:, axis],
            label=channel.name,
            color=CYCLE[number % len(CYCLE)],
            **style,
        )
    ax.set_ylabel(f"{what} ({'xyz'[axis]})\n({markers[0].unit or '–'})")
    _legend(ax, len(markers))


def _legend(ax, curves: int) -> None:
    if curves <= MOST_NAMES:
        ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=min(curves, 8), borderaxespad=0.1)
    else:
        ax.set_title(f"{curves} markers", loc="left")


def _draw_channel(ax, channel: Channel, colour: str) -> None:
    _curve(ax, channel, channel.values, color=colour, linewidth=0.7)
    name = channel.name if len(channel.name) <= 40 else f"{channel.name[:39]}…"
    ax.set_title(
        name if not channel.unit or channel.unit in name else f"{name} ({channel.unit})",
        loc="left",
        fontsize=8,
        pad=2,
    )
    ax.locator_params(axis="y", nbins=2)


def _curve(ax, channel: Channel, values: np.ndarray, **style) -> None:
    positions, samples = decimated(values)
    ax.plot(positions / channel.rate_hz if channel.rate_hz else positions, samples, **style)


def _finish(figure: Figure, contents: Contents, hidden: int) -> None:
    """Common axis of time, events as lines, and how many channels are not shown."""
    axes = figure.axes
    timed = [c for c in (*contents.channels, *contents.plates) if c.values is not None and c.shape]
    seconds = all(c.rate_hz for c in timed)
    for ax in axes:
        ax.margins(x=0.0)
        if seconds:
            for _, time in contents.events:
                ax.axvline(time, color="#8a8a8a", linewidth=0.6, linestyle=":")
        if ax is not axes[0] and seconds:
            ax.sharex(axes[0])
    lowest = {ax.get_subplotspec().colspan.start: ax for ax in axes}  # the last one of every column
    for ax in axes:
        ax.tick_params(labelbottom=ax in lowest.values())
    notes = ["time (s)" if seconds else "time (s), or number of the sample where the file gives no rate"]
    notes += ["dotted: events"] if seconds and contents.events else []
    notes += [f"not shown, constant or beyond {MOST_CHANNELS}: {hidden}"] if hidden else []
    figure.supxlabel("; ".join(notes), fontsize=9.5)
