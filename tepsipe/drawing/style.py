"""Style of all figures: sizes, colours, maps of VAF, reproducible files, and the numbers that a figure shows.

The numbers are a table of every line, point, bar and cell of every panel.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import wraps
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib import font_manager
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import Collection, LineCollection, PathCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

WIDTH_IN = 6.3
# phases as parts of pi: angles are in radians throughout
PHASE_TICKS = {
    -1.5 * np.pi: "−3π/2",
    -np.pi: "−π",
    -0.5 * np.pi: "−π/2",
    0.0: "0",
    0.5 * np.pi: "π/2",
    np.pi: "π",
}
# the font of the report's text
FONT = "Libertinus Serif"
FONT_FILES = sorted(Path(__file__).with_name("fonts").glob("*.otf"))
# smallest lettering of a figure as wide as the text (pt)
SMALLEST_PT = 7.5
COLOURS = {
    "measured": "#1b1b1b",
    "model": "#d55e00",
    "as printed": "#d55e00",
    "recommended": "#0072b2",
    "other": "#8a8a8a",
    "compensated": "#009e73",
    "compensated too": "#93cfa5",
    "other too": "#c9c9c9",
    "joint likelihood": "#cc79a7",
    "command": "#8a8a8a",
    "window": "#f3e3b5",
    "I": "#0072b2",
    "B": "#009e73",
    "K": "#d55e00",
}
CYCLE = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#4b4b4b"]
# of the models of the belt-induced load
MODEL_COLOURS = {
    "mean-subtraction": "#8a8a8a",
    "mass-spring-damper": "#e69f00",
    "hnat2014": "#d55e00",
    "output-error": "#cc79a7",
    "fir-causal": "#7fb2d9",
    "fir": "#0072b2",
    "spectral": "#4b4b4b",
    "loaded-frame": "#009e73",
    "bristle-frame": "#0b5d3b",
    "linear-frame": "#6a51a3",
    "ripple-tracking": "#009e73",
}

STYLE = {
    "font.family": FONT,
    "mathtext.fontset": "custom",
    "mathtext.rm": FONT,
    "mathtext.it": f"{FONT}:italic",
    "mathtext.bf": f"{FONT}:bold",
    "mathtext.cal": FONT,
    "mathtext.fallback": "stix",
    "font.size": 9.5,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.5,
    "legend.fontsize": 8.5,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    # where it is anyway, as no figure has ticks at the top; it would be looked for whenever a figure is drawn
    "axes.titley": 1.0,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.1,
    "legend.frameon": False,
    "axes.prop_cycle": matplotlib.cycler(color=CYCLE),
    "svg.fonttype": "path",
    "svg.hashsalt": "tepsipe",
    "path.simplify_threshold": 0.3,
}


@dataclass(frozen=True)
class Drawing:
    """A schematic or flow chart of report/drawings.typ: that source, and ``shown``, what the run gives it."""

    source: str
    shown: Mapping


def _add_own_fonts() -> None:
    """Make the figures' own font known to matplotlib, and STIX where the user's list of fonts lacks it."""
    known = font_manager.get_font_names()
    if FONT not in known:
        for path in FONT_FILES:
            font_manager.fontManager.addfont(path)
    if "STIXGeneral" not in known:
        for path in sorted(Path(matplotlib.get_data_path(), "fonts/ttf").glob("STIX*.ttf")):
            font_manager.fontManager.addfont(path)


def in_style(draw: Callable) -> Callable:
    """A function (no unit) that draws or writes in `STYLE`; matplotlib's own settings stay as they are."""

    @wraps(draw)
    def drawn(*arguments, **keywords):
        _add_own_fonts()
        with matplotlib.rc_context(STYLE):
            return draw(*arguments, **keywords)

    return drawn


def example_and_panels(
    count: int, columns: int, height_in: float, example: float = 1.5, **keywords
) -> tuple[Figure, Axes, np.ndarray]:
    """A figure with one wide panel above a grid of small ones, which share their time axis.

    Parameters
    ----------
    count, columns : int
        Number of the small panels, and of those in a row.
    height_in : float
        Height of the figure (inches).
    example : float
        Height of the wide panel relative to a small one.
    keywords
        ``sharey``: ``"row"`` for a common axis of the panels in a row.

    Returns
    -------
    Figure
        As wide as the report's text.
    Axes
        The wide panel.
    ndarray of Axes, shape (rows, columns)
        The small panels; those beyond ``count`` are not visible.
    """
    rows = -(-count // columns)
    figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
    FigureCanvasAgg(figure)
    above, below = figure.subfigures(2, 1, height_ratios=[example, rows])
    axes = below.subplots(rows, columns, sharex=True, squeeze=False, **keywords)
    for axis in axes.flat[count:]:
        axis.set_visible(False)
    return figure, above.subplots(), axes


def new_figure(rows: int = 1, columns: int = 1, height_in: float = 3.0, **keywords):
    """A figure as wide as the report's text and ``height_in`` high (inches), with its axes."""
    figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, **keywords)


def legend_above(figure: Figure, axis: Axes, columns: int, **keywords) -> None:
    """Put the legend of one of the axes above all of them, where it hides no data (no unit)."""
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=columns, **keywords)


@in_style
def save_figure(figure: Figure, svg: str | Path) -> None:
    """Write a figure as SVG (no unit), without dates."""
    _lay_out(figure)
    figure.savefig(svg, metadata={"Date": None, "Creator": "tepsipe"})


@in_style
def save_png(figure: Figure, png: str | Path) -> None:
    """Write a figure as PNG only, 150 pixels per inch, without dates."""
    _lay_out(figure)
    # the usual compression takes twice as long, for larger files
    figure.savefig(png, dpi=150, metadata={"Software": "tepsipe"}, pil_kwargs={"compress_level": 3})


def _lay_out(figure: Figure) -> None:
    """Place the axes once: saving would draw the figure once more for it.

    Drawing would place empty labels, too, beside the tick labels.
    """
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        if not axis.get_label_text():
            axis.set_label_coords(0.0, 0.0)


MAP = "cividis"


@in_style
def plot_matrix(matrix: np.ndarray, names: list[str], what: str, labels: tuple[str, str]) -> Figure:
    """Cross-validation as a map of VAF (%)."""
    size = len(names)
    figure, axes = new_figure(height_in=2.3 if size < 8 else 3.2)
    image = axes.imshow(matrix, cmap=MAP, aspect="auto")
    axes.set_xticks(range(size), names, rotation=45 if size > 8 else 0, ha="right" if size > 8 else "center")
    axes.set_yticks(range(size), names)
    axes.grid(False)
    middle = 0.5 * (matrix.max() + matrix.min())
    digits = 0 if np.ptp(matrix) > 3.0 else 2
    for row in range(size):
        for column in range(size):
            value = matrix[row, column]
            colour = "black" if value > middle else "white"
            axes.text(
                column,
                row,
                f"{value:.{digits}f}",
                ha="center",
                va="center",
                color=colour,
                fontsize=8.5 if size < 8 else SMALLEST_PT,
            )
    axes.set(ylabel=labels[0], xlabel=labels[1])
    figure.colorbar(image, ax=axes, label=what)
    return figure


def draw_vafs(axis: Axes, vafs: np.ndarray, fontsize: float = SMALLEST_PT) -> None:
    """Numbers on a map of VAF from 0 to 100 %; cells below 0 are white, those without a number have a dash.

    ``vafs`` has a row for every row of the map (%).
    """
    shown = np.ma.masked_less(np.ma.masked_invalid(vafs), 0.0)
    axis.imshow(shown, cmap=MAP, vmin=0.0, vmax=100.0, aspect="auto")
    for (row, column), value in np.ndenumerate(vafs):
        dark = 0.0 <= value < 55.0
        axis.text(
            column,
            row,
            _vaf(value),
            ha="center",
            va="center_baseline",
            color="white" if dark else "black",
            fontsize=fontsize,
        )
    axis.grid(visible=False)
    axis.tick_params(length=0.0)


def _vaf(value: float) -> str:
    if not np.isfinite(value):
        return "\N{EN DASH}"
    if value <= -1e5:
        exponent = int(np.floor(np.log10(-value)))
        return rf"$-10^{{{exponent}}}$"
    return f"{value:.0f}".replace("-0", "0").replace("-", "\N{MINUS SIGN}")


HEADER = "panel,series,kind,x,y,value\n"


def write_drawn(figure: Figure, path: str | Path) -> None:
    """Write the numbers of a figure as CSV, with six digits and in the units of its axes.

    Lines that begin with # name the axes of every panel. A drawing without axes has no rows. ``value`` is
    that of a cell of an image; of a bar, x and y are two of its corners.
    """
    head, rows = [], []
    panels = [axis for axis in figure.axes if axis.get_visible() and axis.axison]
    for k, axis in enumerate(panels, start=1):
        head.append(f"# panel {k}: {_about(axis)}\n")
        for series, kind, values in _drawn(axis):
            label = '"' + series.replace('"', "'") + '"' if "," in series else series
            rows.append(_cells(values).replace("\0", f"{k},{label},{kind},"))
    Path(path).write_text("".join([*head, HEADER, *rows]), encoding="utf-8", newline="\n")


def _about(axis: Axes) -> str:
    """Labels of a panel; panels that share an axis have its label only once in the figure."""
    shared = axis.get_shared_x_axes().get_siblings(axis)
    x = next((a.get_xlabel() for a in [axis, *shared] if a.get_xlabel()), "")
    shared = axis.get_shared_y_axes().get_siblings(axis)
    y = next((a.get_ylabel() for a in [axis, *shared] if a.get_ylabel()), "")
    titles = [axis.get_title(loc=loc) for loc in ("left", "center", "right")]
    words = f"x: {x}; y: {y}" + "".join(f"; {title}" for title in titles if title)
    return re.sub(r"\s+", " ", words.replace("$", ""))


def _drawn(axis: Axes) -> Iterator[tuple[str, str, np.ndarray]]:
    """Series, kind and numbers (x, y or x, y, value) of all that is drawn in a panel."""
    for line in axis.lines:
        values = np.column_stack(np.broadcast_arrays(*(np.asarray(v) for v in line.get_data())))
        if line.get_visible() and values.size:
            yield _name(line), "line", _numbers(values)
    for collection in axis.collections:
        if collection.get_visible():
            yield from _of_collection(collection)
    for patch in axis.patches:
        if isinstance(patch, Rectangle) and patch.get_visible():
            (x, y), width, height = patch.get_xy(), patch.get_width(), patch.get_height()
            yield _name(patch), "bar", _numbers(np.array([[x, y], [x + width, y + height]]))
    for image in axis.images:
        values = np.ma.filled(np.ma.asarray(image.get_array(), dtype=float), np.nan)
        if values.ndim == 2:
            row, column = np.indices(values.shape)
            yield _name(image), "cell", np.column_stack([column.ravel(), row.ravel(), values.ravel()])


def _of_collection(collection: Collection) -> Iterable[tuple[str, str, np.ndarray]]:
    if isinstance(collection, PathCollection):
        yield (
            _name(collection),
            "point",
            _numbers(np.ma.filled(collection.get_offsets().astype(float), np.nan)),
        )
        return
    kind = "segment" if isinstance(collection, LineCollection) else "area"
    for path in collection.get_paths():
        if path.vertices.size:
            yield _name(collection), kind, path.vertices


def _numbers(values: np.ndarray) -> np.ndarray:
    return np.asarray(values, dtype=float)


def _cells(values: np.ndarray) -> str:
    """Lines of CSV, each with a NUL in front; all numbers are formatted at once, because there are many."""
    line = "\0%.6g,%.6g,%.6g\n" if values.shape[1] == 3 else "\0%.6g,%.6g,\n"
    return (line * len(values) % tuple(values.ravel().tolist())).replace("nan", "")


def _name(artist) -> str:
    """Name of a series in the legend; empty for what has none."""
    label = str(artist.get_label() or "")
    return "" if label.startswith("_") else label.replace("\n", " ").replace("$", "")
