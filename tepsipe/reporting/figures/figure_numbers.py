"""Numbers that a figure shows, as a table: every line, point, bar and cell of every panel."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection, LineCollection, PathCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

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
            rows += [f"{k},{label},{kind},{','.join(cells)}\n" for cells in _cells(values)]
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


def _cells(values: np.ndarray) -> Iterator[list[str]]:
    for row in values.tolist():
        cells = ["" if x != x else f"{x:.6g}" for x in row]
        yield cells if len(cells) == 3 else [*cells, ""]


def _name(artist) -> str:
    """Name of a series in the legend; empty for what has none."""
    label = str(artist.get_label() or "")
    return "" if label.startswith("_") else label.replace("\n", " ").replace("$", "")
