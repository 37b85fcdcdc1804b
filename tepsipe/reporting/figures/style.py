"""Style of all figures: sizes, colours, and reproducible file contents."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import wraps
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib import font_manager
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

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
def save_figure(figure: Figure, svg: str | Path, png: str | Path) -> None:
    """Write a figure as SVG and PNG (no unit), without dates."""
    _lay_out(figure)
    figure.savefig(svg, metadata={"Date": None, "Creator": "tepsipe"})
    _write_png(figure, png)


@in_style
def save_png(figure: Figure, png: str | Path) -> None:
    """Write a figure as PNG only, 150 pixels per inch, without dates."""
    _lay_out(figure)
    _write_png(figure, png)


def _lay_out(figure: Figure) -> None:
    """Place the axes once: saving would do it again for every file, and draw the figure once more for it."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)


def _write_png(figure: Figure, png: str | Path) -> None:
    figure.savefig(png, dpi=150, metadata={"Software": "tepsipe"})
