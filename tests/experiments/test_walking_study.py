"""The study of walking: files, sheet, strides needed, tables, and real unperturbed strides."""

import gzip
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import yaml
from typst_builders import evaluated, page_of, plain_words

from tepsipe.errors import InputError
from tepsipe.experiments.walking.analysis import analyse_walking
from tepsipe.experiments.walking.deviations import Deviations
from tepsipe.experiments.walking.figures import plot_walking
from tepsipe.experiments.walking.files import read_events, read_recording
from tepsipe.experiments.walking.impedance import predicted_uncertainty
from tepsipe.experiments.walking.needed_strides import needed_strides
from tepsipe.experiments.walking.options import ExpectedPulse, WalkingOptions
from tepsipe.experiments.walking.results import walking_rows
from tepsipe.experiments.walking.strides import (
    agreement,
    ankle_moment,
    bandwidth_hz,
    random_onsets,
    segment_strides,
)
from tepsipe.io.result import Result
from tepsipe.reporting.chapters import walking as chapter
from tepsipe.reporting.run import Run, report_content
from tests.experiments.test_walking import WALK, analysed, pulsed, recorded, synthetic_walk

NAMES = ("time", "angle", "vertical", "anterior", "cop", "ankle_x", "ankle_y", "other_vertical")
COLUMNS = {name: name for name in NAMES} | {"supplied_moment": None}
TWO_PHASES = WalkingOptions(phases_percent=(40.0, 80.0))


def expected(degrees, stiffness=200.0):
    return ExpectedPulse(degrees, 0.06, (stiffness, stiffness), 2.0)


def quiet(walk):
    return segment_strides(walk.heel_strikes, walk.toe_offs)


def test_uncertainty_of_one_stride_falls_with_the_amplitude():
    rng = np.random.default_rng(7)
    time = np.arange(1, 11) / 100.0
    # a scatter of 10 Nm, beside which 2 % of the response does not count
    unperturbed = np.zeros((60, 8, 10))
    unperturbed[:, 3] = rng.normal(0.0, 10.0, (60, 10))
    angle = 0.02 * np.minimum(time / 0.06, 1.0) ** 2
    response = np.stack([np.gradient(np.gradient(angle, time), time), np.gradient(angle, time), angle])
    deviations, beta = Deviations(time, unperturbed[:0], unperturbed), np.array([0.0, 2.0, 200.0])
    one, two = (
        predicted_uncertainty(deviations, size * response, beta, WalkingOptions()) for size in (1.0, 2.0)
    )
    assert one == pytest.approx(2.0 * two, rel=0.01)


def test_strides_needed_are_what_an_experiment_shows():
    rows = needed_strides("a", recorded(WALK), quiet(WALK), expected(2.0, 206.0), TWO_PHASES)
    planned = next(row for row in rows if row.phase_percent == 40.0 and row.matching == "state")
    fit = analysed(pulsed(WALK)).phases[40.0]
    shown = fit.budget.type_a[2] / np.sqrt(1.0 / fit.perturbed + 1.0 / fit.unperturbed)
    assert planned.u_one_stride_Nm_per_rad == pytest.approx(shown, rel=0.4)


def test_files_give_the_arrays_that_were_written(tmp_path):
    walk = synthetic_walk(20)
    time = np.arange(walk.signals["angle"].size) / walk.rate_hz
    table = pd.DataFrame({"time": time} | {name: walk.signals[name] for name in NAMES[1:]})
    with gzip.open(tmp_path / "walk.csv.gz", "wt") as file:
        table.to_csv(file, index=False)
    found = read_recording(tmp_path / "walk.csv.gz", COLUMNS, 100.0, 0.05)
    assert found.angle[:-1] == pytest.approx(walk.signals["angle"][: found.angle.size - 1])
    (tmp_path / "events.csv").write_text("hs,to,pulse\n1.5,2.4,\n2.8,,3.1\n4.1,5.0,NaN\n")
    events = read_events(tmp_path / "events.csv", {"heel_strike": "hs", "toe_off": "to", "pulse": "pulse"})
    assert events["heel_strike"].tolist() == [1.5, 2.8, 4.1]
    assert events["toe_off"].tolist() == [2.4, 5.0] and events["pulse"].tolist() == [3.1]


def test_files_that_cannot_be_used(tmp_path):
    events = tmp_path / "events.csv"
    events.write_text("hs,to\n1.5,late\n")
    with pytest.raises(InputError, match=r"expected a column 'lhs' of events, found hs, to"):
        read_events(events, {"heel_strike": "lhs"})
    with pytest.raises(InputError, match=r"expected events in s in the column 'to', found .*late"):
        read_events(events, {"toe_off": "to"})
    walk = tmp_path / "walk.csv"
    rows = [",".join(NAMES), *(",".join([str(t), *["1"] * 7]) for t in (0.0, 0.01, 0.5, 0.51))]
    walk.write_text("\n".join(rows) + "\n")
    with pytest.raises(InputError, match=r"rise by at most 0.05 s, found steps from 0.01 to 0.49 s"):
        read_recording(walk, COLUMNS, 100.0, 0.05)
    with pytest.raises(InputError, match=r"matched_by to name signals among .*found 'elbow'"):
        analysed(pulsed(WALK), WalkingOptions(matched_by=("elbow",)))


def settings_of(root):
    return yaml.safe_load((root / "config/walking/config.yaml").read_text(encoding="utf-8"))["walking"]


def test_shipped_options_are_the_defaults_and_the_controls(root):
    analysis = settings_of(root)["analysis"]
    lists = {key: tuple(analysis[key]) for key in ("phases_percent", "control_percent")}
    assert WalkingOptions(**analysis | lists) == replace(WalkingOptions(), control_percent=(125.0,))


def frames(rows, needed):
    return pd.DataFrame([vars(row) for row in rows]), pd.DataFrame([vars(row) for row in needed])


PLANNED = {"amplitude_deg": 2.0, "duration_s": 0.06, "damping_Nms_per_rad": 2.0, "strides": 150}
ABOUT = {
    "condition": "slow",
    "source": "recorded",
    "strides": 89,
    "pulses": 28,
    "stance_s": 0.9,
    "bandwidth_hz": 6.0,
    "agreement_Nm": 0.7,
    "dropped": ["one"],
}
CODE = {"commit": None, "modified": None}


def words(rows, needed, **about):
    """Words of the report on one trial, its rows of the impedance, and what was dropped."""
    study = {"title": "T", "recordings_source": None, "experiments": {"walking": ["slow"]}, "made": {}}
    fits = {"slow": Result({}, {}, ABOUT | about)}
    settings = {"walking": {"planned": PLANNED}}
    run = Run({"walking": rows, "needed": needed}, {"walking": fits}, settings, study | {"code": CODE})
    tables = {name: table.to_csv(index=False) for name, table in run.tables.items()}
    data = report_content(run, {"walking": chapter})
    shown = evaluated(["impedances", "dropped"], "walking.typ", data, tables)
    return plain_words(page_of(data, tables, '#include "walking.typ"')), *shown


@pytest.mark.slow
def test_the_chapter_says_what_the_tables_hold():
    needed = needed_strides("slow", recorded(WALK), quiet(WALK), expected(2.0), TWO_PHASES)
    found = analysed(pulsed(WALK))
    rows, table = frames(walking_rows("slow", "recorded", found), needed)
    text, cells, dropped = words(rows, table)
    assert "6.00 Hz, which is not enough to show the response to a pulse" in text
    assert "infinite" not in text.partition("Method")[0]
    assert len(cells) == 4 and dropped == ["one"] and "Left out" in text
    assert len(plot_walking(rows, table).axes) == 2
    assert (
        "30.0 Hz, which is enough to show the response to a pulse" in words(rows, table, bandwidth_hz=30.0)[0]
    )
    silent, _ = frames(walking_rows("slow", "none", analysed(pulsed(WALK, degrees=0.0))), needed)
    text, *_ = words(silent, table, pulses=0, bandwidth_hz=None)
    assert silent["value"].isna().all() and set(silent["flags"]) == {"no-response"}
    assert "intervals of K are infinite at all 2 phases" in text and "not enough to show" not in text
    assert "the angle does not respond at 40, 80 % of stance" in words(silent, table)[0]
    plot_walking(silent, table)


def test_real_strides_without_pulses_say_nothing_of_the_joint(real_data, root):
    """38 strides of one person; the supplied moment is low-passed, that from the force agrees with it."""
    settings = settings_of(root)
    recording = read_recording(
        real_data("walking/UnpertPre_data.csv.gz"), settings["columns"], 100.0, settings["max_gap_s"]
    )
    events = read_events(real_data("walking/UnpertPre__event.csv.gz"), settings["events"])
    strides = segment_strides(events["heel_strike"], events["toe_off"], from_s=8.0)
    assert len(strides) == 38 and strides.dropped == ()
    assert bandwidth_hz(recording.supplied_moment, ankle_moment(recording), 100.0) == pytest.approx(6, abs=1)
    assert agreement(recording, strides.in_stance(recording.time)) < 1.0
    onsets = random_onsets(strides, (20.0, 40.0, 60.0, 80.0), np.random.default_rng(1))
    options = WalkingOptions(fewest_strides=4, recovery_strides=0)
    found = analyse_walking(recording, strides, onsets, options)
    assert list(found.phases) == [20.0, 40.0, 60.0, 80.0]
    assert all(np.isinf(fit.low[2]) and fit.flags == "no-response" for fit in found.phases.values())
