"""Figures and HTML of results: in a notebook each figure is shown once, and none stays open."""

import base64
import functools
import html
import io
import sys
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tepsipe.errors import InputError, quoted

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# backends that write files and show nothing
FILES_ONLY = ("agg", "cairo", "pdf", "pgf", "ps", "svg", "template")


def new_axes(
    ax: "Axes | Sequence[Axes] | None", rows: int, figsize: tuple[float, float]
) -> tuple["Figure", list["Axes"]]:
    """Axes to draw on, one below the other: given ones, or those of a new figure.

    ax: given axes, as many as ``rows``.
    figsize: width and height of a new figure (inches).

    Returns:
        figure: figure of the axes (size in inches).
        axes: the axes.
    """
    if ax is None:
        figure = _new_figure(figsize)
        return figure, list(figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0])
    given = list(np.ravel(np.array(ax, dtype=object)))
    if len(given) != rows or not all(hasattr(axis, "plot") and hasattr(axis, "figure") for axis in given):
        wanted = "one matplotlib Axes" if rows == 1 else f"a list of {rows} matplotlib Axes"
        kind = type(given[0]).__name__ if len(given) == 1 else f"{len(given)} objects"
        raise InputError(f"plot: expected {wanted} as ax, found {quoted(kind)}: make them with plt.subplots")
    return _shown_once(given[0].figure), given


def _new_figure(figsize: tuple[float, float]) -> "Figure":
    """A figure that pyplot shows, or one of which it knows nothing where it could show none."""
    import matplotlib.pyplot as plt
    from matplotlib.figure import Figure

    backend = plt.get_backend().lower()
    if backend in FILES_ONLY:
        return Figure(figsize=figsize, layout="constrained")
    # not by rc_context, which would also undo what the backend sets when it is loaded by this first figure
    most, plt.rcParams["figure.max_open_warning"] = plt.rcParams["figure.max_open_warning"], 0
    try:
        figure = plt.figure(figsize=figsize, layout="constrained")
    finally:
        plt.rcParams["figure.max_open_warning"] = most
    return _shown_once(figure)


def _shown_once(figure: "Figure") -> "Figure":
    """The figure: a cell of a notebook shows what it returns, and then all open figures, but not this one."""
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is not None and "inline" in pyplot.get_backend().lower():
        figure._repr_mimebundle_ = functools.partial(_close, figure)  # type: ignore[attr-defined]
    return figure


def _close(figure: "Figure", include: Any = None, exclude: Any = None) -> dict[str, Any]:
    """Close a figure that IPython is about to show by the formats of its own choice."""
    import matplotlib.pyplot as plt

    plt.close(figure)
    return {}


def as_html(
    title: str,
    head: Sequence[str],
    rows: Iterable[Sequence[str]],
    lines: Iterable[str],
    notes: Iterable[str],
    draw: Callable[[Any], Any] | None,
    panels: int = 1,
) -> str:
    """A result for a notebook: table, remarks, notes and a small figure.

    title: Heading.
    head, rows: cells of the table, its values with their units.
    lines, notes: remarks below the table; notes are set apart.
    draw: draws on the axes that it is given; None for no figure.
    panels: number of axes of the figure.
    """

    def cells(kind: str, texts: Sequence[str]) -> str:
        return "<tr>" + "".join(f"<{kind}>{html.escape(text)}</{kind}>" for text in texts) + "</tr>"

    table = f"<thead>{cells('th', head)}</thead><tbody>{''.join(cells('td', row) for row in rows)}</tbody>"
    parts = [f"<strong>{html.escape(title)}</strong>", f"<table>{table}</table>"]
    parts += [f"<div>{html.escape(line)}</div>" for line in lines]
    flag = "margin: 0.3em 0; padding-left: 0.6em; border-left: 3px solid #c8371b"
    parts += [f'<div style="{flag}">{html.escape(note)}</div>' for note in notes]
    if draw is not None:
        parts.append(_picture(draw, panels))
    return f"<div>{''.join(parts)}</div>"


def _picture(draw: Callable[[Any], Any], panels: int) -> str:
    """A small figure as an HTML image, on a canvas of its own."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.0, 1.1 + 1.3 * panels), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(panels, 1, sharex=True, squeeze=False)[:, 0]
    draw(axes[0] if panels == 1 else list(axes))
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=80)
    return f'<img alt="figure" src="data:image/png;base64,{base64.b64encode(file.getvalue()).decode()}">'
