"""tepsipe info: gaps, plates, events, and the picture of a file."""

import time

import numpy as np
import pytest
from dflow_builders import write_mocap

from tepsipe.cli import main
from tepsipe.drawing.contents import BINS, decimated, draw_contents
from tepsipe.io.file_format import Channel
from tepsipe.io.formats import contents_of


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_longest_gap_and_share_of_missing_samples():
    values = np.arange(20.0)
    values[[3, 8, 9, 10]] = np.nan
    channel = Channel.of("x", "m", 100.0, values)
    assert (channel.missing, channel.longest_gap) == (4, 3)
    assert channel.missing_text() == "20 %, longest 0.03 s"
    assert Channel.of("x", "m", 100.0, np.arange(4.0)).missing_text() == ""


def test_decimation_keeps_extremes_and_breaks(rng):
    values = rng.standard_normal(50_000)
    values[31_234] = 40.0
    values[777] = -40.0
    values[10_000:12_000] = np.nan
    positions, kept = decimated(values)
    assert kept.size == 2 * BINS
    assert (np.diff(positions) >= 0).all()
    assert np.nanmax(kept) == 40.0
    assert np.nanmin(kept) == -40.0
    assert np.isnan(kept).sum() > 50  # the gap stays visible
    assert decimated(values[:100])[1].size == 100


def test_picture_without_a_screen(tmp_path, capsys):
    (tmp_path / "own.csv").write_text("time_s,x_m\n0,1\n1,2\n2,0\n")
    for _ in range(2):  # an earlier picture is replaced
        assert main(["info", "own.csv", "--plot"]) == 0
        assert "written: own.csv.png" in capsys.readouterr().out
    assert (tmp_path / "own.csv.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_picture_of_markers(dummy_files):
    figure = draw_contents(contents_of(dummy_files["markers"]), "markers")
    assert [ax.get_ylabel().split()[0] for ax in figure.axes] == ["vertical", "forward"]
    assert len(figure.axes[0].lines) == 8


def test_picture_of_dflow_text_has_y_upward(tmp_path, rng):
    n = 500
    points = {
        m: np.array([0.1, h, 0.2]) + 0.01 * rng.standard_normal((n, 3)) for m, h in (("A", 0.1), ("B", 0.9))
    }
    points["A"][:, 2] += np.linspace(0.0, 0.5, n)
    points["B"][:, 2] += np.linspace(0.0, 0.5, n)
    loads = np.zeros((n, 6))
    loads[:, 1] = 600.0 + rng.standard_normal(n)
    contents = contents_of(write_mocap(tmp_path / "Mocap0001.txt", 100.0, points, {1: loads, 2: 0.0 * loads}))
    assert contents.markers == ("A", "B")
    assert contents.plates[0].low > 590.0
    figure = draw_contents(contents, "mocap")
    assert [ax.get_ylabel().split("\n")[0] for ax in figure.axes[:3]] == [
        "vertical (y)",
        "forward (z)",
        "vertical force",
    ]


@pytest.mark.slow
def test_picture_of_a_log_has_an_axis_per_transducer(dummy_files):
    figure = draw_contents(contents_of(dummy_files["log"]), "log")
    assert len(figure.axes) == 14 + 3
    assert max(ax.get_xlim()[1] for ax in figure.axes) == pytest.approx(
        contents_of(dummy_files["log"]).channels[-1].shape[0] / 1000.0, rel=0.01
    )


@pytest.mark.parametrize("name", ["own.csv", "other.png", "nowhere/a.png"])
def test_a_picture_never_overwrites_anything_else(name, tmp_path, capsys):
    (tmp_path / "own.csv").write_text("time_s,x_m\n0,1\n1,2\n2,0\n")
    (tmp_path / "other.png").write_text("notes of mine")
    assert main(["info", "own.csv", "--plot", name]) == 2
    said = capsys.readouterr().err
    assert name.split("/")[0] in said
    assert said.count("\n") == 1
    assert (tmp_path / "own.csv").read_text().startswith("time_s")
    assert (tmp_path / "other.png").read_text() == "notes of mine"


def test_a_file_without_samples_gives_no_picture(tmp_path, capsys):
    (tmp_path / "x.csv").write_text("no numbers,at all\na,b\n")
    assert main(["info", "x.csv", "--plot"]) == 2
    assert "expected samples to draw" in capsys.readouterr().err
    assert not (tmp_path / "x.csv.png").exists()


@pytest.mark.slow
def test_plates_and_events_of_a_recording_made_by_others(real_data):
    contents = contents_of(real_data("c3d/HC002D06.c3d"))
    assert contents.events[0] == ("Left Foot Strike", pytest.approx(0.12, abs=0.02))
    assert all(0.0 <= time <= 2.55 for _, time in contents.events)
    assert contents.facts["force plate 1"].startswith("type 2, mean vertical force 55.0 N, loaded 21 %")
    assert "LKneeAngles" not in contents.markers
    assert {c.name: c.unit for c in contents.channels}["LKneeAngles"] == "deg"
    channels = [ax.get_title(loc="left") for ax in draw_contents(contents, "walk").figure.axes]
    assert "Force.Fz1 (N)" in channels
    assert not any("Angles" in name for name in channels)


@pytest.mark.parametrize("every", [1, 2])  # numbers only, and every other column text
def test_a_table_of_very_many_columns_is_read_in_time_that_grows_with_their_number(tmp_path, every):
    names = [f"c{k}" for k in range(20_000)]
    cells = ["1.5" if k % every == 0 else "on" for k in range(len(names))]
    late = cells.copy()
    late[0] = "off"  # text from the second line on
    (tmp_path / "wide.csv").write_text("".join(f"{','.join(row)}\n" for row in (names, cells, late)))
    start = time.process_time()
    contents = contents_of(tmp_path / "wide.csv")
    # a second or two; comparing each column with all others takes ten times as long
    assert time.process_time() - start < 5.0
    assert [channel.name for channel in contents.channels] == names[::every][1:]
    assert contents.facts["columns of text"].split(", ")[:2] == (["c0"] if every == 1 else ["c0", "c1"])
