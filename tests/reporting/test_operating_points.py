"""Impedance against the operating point, and change within a trial: rows, lines, sheet and numbers."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from builders import assert_one_sentence, trial_of
from joint_builders import fit_of
from typst_builders import chapter_words

from tepsipe.errors import InputError
from tepsipe.experiments.position_manipulator.analysis import REFLEX_ESTIMATOR
from tepsipe.experiments.position_manipulator.figures import plot_operating_points, plot_time_varying
from tepsipe.experiments.position_manipulator.operating_points import (
    LITERATURE_SLOPE,
    OPERATING_POINTS,
    RELATIONS,
    Nominal,
    operating_points,
    relations,
)
from tepsipe.experiments.position_manipulator.options import TimeVaryingOptions
from tepsipe.experiments.position_manipulator.time_varying import (
    VARYING_ROWS,
    analyse_time_varying,
    varying_rows,
)
from tepsipe.io.estimates import Estimate
from tepsipe.io.result import Result
from tepsipe.reporting.chapters import position_manipulator
from tepsipe.reporting.run import Run, report_content
from workflow.support import outputs
from workflow.support.study import Study
from workflow.support.trial_sheet import COLUMNS, OPTIONAL_COLUMNS, read_trial_sheet

RATE = 250.0
OPTIONS = TimeVaryingOptions(
    window_s=5.0,
    window_step_s=2.5,
    block_s=2.0,
    realisation_s=None,
    segment_s=0.2,
    segment_step_s=0.1,
    bins=5,
    piece_s=2.0,
    bootstrap_draws=100,
)


def estimates_of(condition, stiffness, inertia=0.015, ratio=0.3):
    damping = 2.0 * ratio * np.sqrt(inertia * stiffness)
    values = {"I": (inertia, "Nms2/rad"), "B": (damping, "Nms/rad"), "K_working": (stiffness, "Nm/rad")}
    return [
        Estimate(
            "position_manipulator", condition, "impedance", REFLEX_ESTIMATOR, q, unit, value, 0.01 * value,
            0.98 * value, 1.02 * value,
        )
        for q, (value, unit) in values.items()
    ]  # fmt: skip


def person(name, slope, torques, rest=20.0, noise=0.0):
    """Estimates, measured means and what the sheet says, of one person at several torques."""
    rows, measured, nominal = [], {}, {}
    for k, torque in enumerate(torques):
        condition = f"{name}-{k}"
        rows += estimates_of(condition, rest + slope * abs(torque) + noise * (-1) ** k)
        measured[condition] = (0.1 * k, torque)
        nominal[condition] = Nominal(participant=name)
    return rows, measured, nominal


def test_line_of_stiffness_against_torque_is_that_of_the_person():
    rows, measured, nominal = person("P1", 5.0, (2.0, 6.0, 12.0, 20.0))
    points = operating_points(rows, measured, nominal)
    (line,) = relations(points)
    assert (line.participant, line.torque, line.trials) == ("P1", "positive", 4)
    assert line.slope_per_rad == pytest.approx(5.0)
    assert line.at_rest_Nm_per_rad == pytest.approx(20.0)
    ratios = [p.value for p in points if p.quantity == "damping_ratio"]
    assert ratios == pytest.approx([0.3] * 4)
    assert {p.torque_from for p in points} == {"measured mean"}


def test_interval_of_the_line_holds_the_scatter_between_trials():
    lines = [
        relations(operating_points(*person("P1", 5.0, (2.0, 6.0, 12.0, 20.0), noise=n)))[0] for n in (1, 2)
    ]
    widths = [line.slope_high - line.slope_low for line in lines]
    assert widths[1] == pytest.approx(2.0 * widths[0])
    assert all(line.slope_low < 5.0 < line.slope_high for line in lines)


def test_directions_of_the_torque_are_separate_muscles():
    rows, measured, nominal = person("P1", 5.0, (3.0, 9.0, 15.0))
    other, more, named = person("P1", 2.0, (-3.0, -9.0, -15.0))
    rename = {c: f"{c}-negative" for c in more}
    other = [replace(e, condition=rename[e.condition]) for e in other]
    points = operating_points(
        rows + other,
        measured | {rename[c]: v for c, v in more.items()},
        nominal | {rename[c]: v for c, v in named.items()},
    )
    slopes = {line.torque: line.slope_per_rad for line in relations(points)}
    assert slopes == {"positive": pytest.approx(5.0), "negative": pytest.approx(2.0)}


def test_trials_of_nobody_have_no_line_unless_the_sheet_gives_their_torques():
    rows, measured, _ = person("P1", 5.0, (2.0, 6.0, 12.0))
    nobody = dict.fromkeys(measured, Nominal())
    assert relations(operating_points(rows, measured, nobody)) == []
    given = {c: Nominal(torque_Nm=t) for c, (_, t) in measured.items()}
    assert len(relations(operating_points(rows, measured, given))) == 1
    two = dict(list(measured.items())[:2])
    assert relations(operating_points(rows, two, given)) == []


def test_operating_point_of_the_sheet_replaces_the_mean():
    rows, measured, nominal = person("P1", 5.0, (2.0, 6.0))
    nominal["P1-0"] = replace(nominal["P1-0"], torque_Nm=3.0)
    point = operating_points(rows, measured, nominal)[0]
    assert (point.torque_Nm, point.torque_from) == (3.0, "trial sheet")
    assert (point.angle_rad, point.angle_from) == (0.0, "measured mean")


@pytest.fixture
def tables(tmp_path):
    rows, measured, nominal = person("P1", 8.0, (2.0, 6.0, 12.0, 20.0), noise=0.5)
    more = person("P2", 3.2, (2.0, 6.0, 12.0), noise=0.5)
    points = operating_points(rows + more[0], measured | more[1], nominal | more[2])
    OPERATING_POINTS.write(tmp_path / "points.csv", points)
    RELATIONS.write(tmp_path / "lines.csv", relations(points))
    text = {"participant": str, "condition": str}
    return tuple(pd.read_csv(tmp_path / f"{name}.csv", dtype=text) for name in ("points", "lines"))


def told(chapter, tables, conditions=()):
    """Words of a chapter of a study with these tables and trials; no estimate failed a check."""
    if "operating_points" in tables:
        points = tables["operating_points"]
        estimates = points[["condition", "quantity", "value"]].assign(
            experiment="position_manipulator",
            pathway="impedance",
            estimator="parallel-cascade",
            recommended="true",
            flags="",
        )
        tables = tables | {"estimates": estimates}
    fits = {"position_manipulator": {c: fit_of() for c in conditions}}
    settings = {"position_manipulator": {"time_varying": {"window_s": 5.0, "segment_s": 0.2, "piece_s": 2.0}}}
    study = {"title": "t", "recordings_source": None, "experiments": {}, "made": {}, "reported": None}
    content = report_content(
        Run(tables, fits, settings, study), {"position_manipulator": position_manipulator}
    )
    return chapter_words(chapter, content, {n: t.to_csv(index=False) for n, t in tables.items()}, cells=" ; ")


def test_lines_of_stiffness_against_torque_are_listed(tables):
    points, lines = tables
    words = told("operating_points", {"operating_points": points, "operating_relations": lines})
    for row in lines.itertuples():
        cell = words.partition(f"{row.participant} ; {row.torque} ; {row.trials} ; ")[2].partition(" ; ")[0]
        slope, ends = cell.split(" (")
        assert float(slope) == pytest.approx(row.slope_per_rad, rel=0.05)
        assert float(ends.split(" to ")[0]) == pytest.approx(row.slope_low, rel=0.05)
    assert words.count("P1-") == 4 and words.count("P2-") == 3
    low, high = LITERATURE_SLOPE
    assert f"a slope of {low} to {high:.1f} N·m/rad per N·m" in words
    assert "was 250 to 400 N·m/rad at 100 N·m" in words
    words = told("operating_points", {"operating_points": points, "operating_relations": lines[:0]})
    assert "We did not fit a line of" in words and "In quick releases" not in words


@pytest.mark.slow
def test_figure_shows_points_lines_and_slopes_of_the_literature(tables):
    figure = plot_operating_points(*tables)
    assert len(figure.axes) == 4
    labels = figure.axes[0].get_legend_handles_labels()[1]
    assert {"P1", "P2", "slopes of the literature"} <= set(labels)


# ---- change within a trial ---------------------------------------------------------------------------


def recorded(rng, seconds=40.0, **further):
    """A trial of K = 50 to 100 Nm/rad, and a fit of it whose ends are cut by a second."""
    time = np.arange(round(seconds * RATE)) / RATE
    frequency = rng.uniform(0.3, 20.0, 50)
    waves = 0.006 / np.hypot(1.0, frequency / 4.0) * np.exp(
        1j * (2.0 * np.pi * frequency * time[:, None] + rng.uniform(0.0, 6.28, 50))
    )  # fmt: skip
    angle, rate, acceleration = (
        (waves * (2j * np.pi * frequency) ** order).sum(axis=1).imag for order in range(3)
    )
    stiffness = 50.0 * (1.0 + further.pop("rises")(time))
    torque = stiffness * angle + 0.8 * rate + 0.015 * acceleration + 0.05 * rng.standard_normal(time.size)
    trial = trial_of(RATE, angle=(angle, "rad"), torque=(torque, "Nm"), **further)
    kept = slice(250, time.size - 250)
    arrays = {"time": time[kept], "angle": angle[kept], "torque": torque[kept]}
    return trial, Result(arrays, {}, {})


def test_windows_are_placed_on_the_clock_of_the_trial(rng):
    trial, fit = recorded(rng, rises=lambda t: t / 40.0)
    found = analyse_time_varying(trial, fit, OPTIONS, rng)
    assert found.at[0] == pytest.approx(1.0 + 2.5, abs=0.01)
    assert found.values[:, 2] == pytest.approx(50.0 * (1.0 + found.at / 40.0), rel=0.05)


def test_trial_that_is_too_short_for_windows_has_no_rows(rng):
    trial, fit = recorded(rng, 8.0, rises=np.zeros_like)
    found = analyse_time_varying(trial, fit, OPTIONS, rng)
    assert found is None
    assert varying_rows("position_manipulator", "a", found) == []


def test_trigger_makes_an_ensemble_over_the_shortest_time_between_triggers(rng):
    line = np.zeros(round(40.0 * RATE))
    line[100::300] = 1.0
    rises = lambda t: np.clip((t - 0.4) % 1.2, 0.0, 1.0)  # noqa: E731
    trial, fit = recorded(rng, rises=rises, trigger=(line, "1"))
    found = analyse_time_varying(trial, fit, OPTIONS, rng)
    assert found.over == "time after the trigger"
    assert found.at.max() < 1.2
    # the first realisation begins before the fit, and the last is not whole
    assert (found.pieces == 31).all()
    inside = found.at < 0.9
    assert found.values[inside, 2] == pytest.approx(50.0 * (1.0 + found.at[inside]), rel=0.06)


def test_schedule_is_cut_like_the_fit(rng):
    time = np.arange(round(40.0 * RATE)) / RATE
    target = 1.0 - np.abs(time % 8.0 / 4.0 - 1.0)
    trial, fit = recorded(rng, rises=lambda t: target, schedule=(target, "1"))
    found = analyse_time_varying(trial, fit, OPTIONS, rng)
    assert found.over == "schedule"
    assert found.values[:, 2] == pytest.approx(50.0 * (1.0 + found.at), rel=0.05)


def test_single_trigger_is_refused(rng):
    line = np.zeros(round(40.0 * RATE))
    line[500] = 1.0
    trial, fit = recorded(rng, rises=np.zeros_like, trigger=(line, "1"))
    with pytest.raises(InputError) as caught:
        analyse_time_varying(trial, fit, OPTIONS, rng)
    assert_one_sentence(caught.value, "trigger", "found 1")


def test_rows_are_read_as_written_and_tell_a_change_from_chance(rng, tmp_path):
    rows = []
    for name, rises in (("steady", np.zeros_like), ("doubling", lambda t: t / 40.0)):
        found = analyse_time_varying(*recorded(rng, rises=rises), OPTIONS, rng)
        rows += varying_rows("position_manipulator", name, found)
    VARYING_ROWS.write(tmp_path / "rows.csv", rows)
    again = VARYING_ROWS.read(tmp_path / "rows.csv")
    assert [r.value for r in again] == pytest.approx([r.value for r in rows])
    table = pd.read_csv(tmp_path / "rows.csv", dtype={"condition": str})
    words = told("time_varying", {"time_varying": table}, ["steady", "doubling", "short"])
    assert "These trials are too short for windows: short." in words
    steady, doubling = words.split("steady: K is lowest")[1].split("doubling: K is lowest")
    assert "The differences between segments are not significant" in steady
    assert "The differences between segments are significant" in doubling
    figure = plot_time_varying(again)
    assert len(figure.axes) == 3
    assert plot_time_varying([]).axes[0].texts


# ---- trial sheet and study ---------------------------------------------------------------------------


ROW = dict.fromkeys(COLUMNS + OPTIONAL_COLUMNS, "-") | {
    "experiment": "position_manipulator",
    "source": "recorded",
    "duration_s": "60",
    "log": "log.csv",
}


@pytest.fixture
def study_of(config, tmp_path):
    def build(*rows):
        path = tmp_path / "trials.tsv"
        own = [{"log": f"log-{row['condition']}.csv"} | row for row in rows]
        lines = [list(ROW), *(list((ROW | row).values()) for row in own)]
        path.write_text("".join("\t".join(line) + "\n" for line in lines))
        study = Study(config, read_trial_sheet(path, "."))
        study.check(str(path))
        return study

    return build


def test_sheet_gives_operating_points_and_leaves_out_trials_that_move(study_of):
    study = study_of(
        {"condition": "a", "operating_torque_Nm": "-5", "operating_angle_rad": "0.1"},
        {"condition": "b"},
        {"condition": "c", "schedule_column": "phase"},
    )
    assert study.manipulators.operating_points() == {
        "a": {"participant": "", "angle_rad": 0.1, "torque_Nm": -5.0},
        "b": {"participant": "", "angle_rad": None, "torque_Nm": None},
    }
    assert study.has("operating_points")
    assert outputs.time_varying(study) == ["<results>/tables/time_varying.csv"]
    assert not study_of({"condition": "a"}, {"condition": "c", "trigger_column": "gate"}).has(
        "operating_points"
    )


def test_change_within_a_trial_can_be_left_out(study_of, config):
    config["position_manipulator"]["time_varying"]["enabled"] = False
    study = study_of({"condition": "a"})
    assert not study.has("time_varying")
    assert not any("time_varying" in path for path in outputs.everything(study))


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        ({"operating_angle_rad": "20"}, ("operating_angle_rad", "'20'")),
        ({"operating_torque_Nm": "much"}, ("operating_torque_Nm", "'much'")),
        ({"operating_torque_Nm": "inf"}, ("operating_torque_Nm", "'inf'")),
        (
            {"experiment": "wristalyzer", "command": "c.txt", "operating_torque_Nm": "5"},
            ("only trials of position_manipulator",),
        ),
    ],
)
def test_operating_point_that_cannot_be_is_refused(cells, words, study_of):
    with pytest.raises(InputError) as caught:
        study_of({"condition": "a"} | cells)
    assert_one_sentence(caught.value, *words)
