"""Numbers of figures as tables."""

import csv

import numpy as np
from matplotlib.figure import Figure

from tepsipe.drawing.style import write_drawn


def rows_of(figure, path):
    write_drawn(figure, path)
    lines = path.read_text(encoding="utf-8").splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    return [line for line in lines if line.startswith("#")], rows


def test_lines_points_bars_and_cells_are_written_with_the_labels_of_their_panels(tmp_path):
    figure = Figure()
    left, right = figure.subplots(1, 2)
    left.plot([0.0, 0.5], [1.0, np.nan], label="torque, $K$")
    left.scatter([1.0], [2.0])
    left.set(xlabel="Time (s)", ylabel="Torque (N·m)", title="one")
    left.bar([3.0], [4.0], width=1.0)
    right.imshow([[1.0, 2.0]])
    about, rows = rows_of(figure, tmp_path / "a.csv")
    assert about[0] == "# panel 1: x: Time (s); y: Torque (N·m); one"
    of = {kind: [r for r in rows if r["kind"] == kind] for kind in ("line", "point", "bar", "cell")}
    assert [(r["series"], r["x"], r["y"]) for r in of["line"]] == [
        ("torque, K", "0", "1"),
        ("torque, K", "0.5", ""),
    ]
    assert [(r["panel"], r["x"], r["y"]) for r in of["point"]] == [("1", "1", "2")]
    assert [(r["x"], r["y"]) for r in of["bar"]] == [("2.5", "0"), ("3.5", "4")]
    assert [(r["panel"], r["x"], r["value"]) for r in of["cell"]] == [("2", "0", "1"), ("2", "1", "2")]


def test_a_drawing_without_axes_has_no_rows(tmp_path):
    figure = Figure()
    figure.subplots().set_axis_off()
    assert rows_of(figure, tmp_path / "a.csv") == ([], [])


def test_panels_that_share_an_axis_have_its_label(tmp_path):
    figure = Figure()
    above, below = figure.subplots(2, 1, sharex=True)
    below.set_xlabel("Time (s)")
    above.plot([0.0], [0.0])
    assert rows_of(figure, tmp_path / "a.csv")[0][0].startswith("# panel 1: x: Time (s)")
