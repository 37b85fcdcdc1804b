"""The noise study from a recorded belt to its tables: trials, cells, rows, thesis Table 4-4."""

import re
from dataclasses import fields, replace

import numpy as np
import pandas as pd
import pytest
from builders import LEG, RATE_HZ, assert_one_sentence, belt_pulses, trial_of
from typst_builders import STUDY, chapter_words, evaluated

from tepsipe.errors import InputError
from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.noise.filtered_noise import NOISE_ON, filtered_trial
from tepsipe.experiments.noise.monte_carlo import sweep, sweep_trial
from tepsipe.experiments.noise.onsets import found_from, onset_rows
from tepsipe.experiments.noise.rows import NOISE_ROWS, NoiseRow, noise_rows
from tepsipe.experiments.noise.simulate import simulate_trials
from tepsipe.experiments.noise.trial import SIGNALS, simulated_result, simulated_trial
from tepsipe.io.result import read_result, write_result
from tepsipe.mechanics.inverse_dynamics import Foot
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.reporting.chapters import noise
from tepsipe.reporting.noise_table import TABLE_4_4, table_4_4
from tepsipe.reporting.run import Run, report_content
from tepsipe.reporting.thesis_tables import TABLE_COLUMNS, read_table, write_table
from tepsipe.signals.perturbations import WindowOptions

FOOT = Foot(mass_kg=2.1, height_m=0.055)
OPTIONS = DummyOptions(
    leg=LEG,
    leg_markers=SegmentMarkers(
        ("ankle", "knee"), [[0.0, 0.0], [0.0, 0.8]]
    ),  # the noise study reads the belt alone
    lowpass_cutoff_hz=20.0,
    lowpass_order=4,
    window=WindowOptions(
        rest_before_s=2.0,
        rest_after_s=2.0,
        rest_margin_s=0.2,
        threshold_fraction=0.05,
        signal_to_noise=5.0,
        merge_s=0.06,
    ),
)
ONSETS_S = (2.0, 4.0, 6.0)
TRUTH, STIFFER = (0.015, 0.1, 10.0), (0.015, 0.1, 15.0)
SEED = 20140612
ESTIMATORS = ["as-printed", "recommended"]
LEVELS_DB = [10.0, 30.0]


def simulated(name="sine-0.3", peak_m_per_s=0.3, parameters=TRUTH, offset_m_per_s=0.0):
    time = np.arange(round(10.0 * RATE_HZ)) / RATE_HZ
    velocity = offset_m_per_s + belt_pulses(time, ONSETS_S, peak_m_per_s)[1]
    trial = trial_of(RATE_HZ, belt_velocity=(velocity, "m/s"))
    return simulate_trials(trial, name, OPTIONS, FOOT, {"": parameters}, 0.001, "auto")[""]


def cell_of(trial, noise_on, snr_db, draws, others=(), predicted_draws=25):
    """The recommended estimator's cell, made alone."""
    others = [filtered_trial(other) for other in others]
    (cell,) = sweep(
        filtered_trial(trial), noise_on, snr_db, draws, SEED, ["recommended"], others, predicted_draws
    )
    return cell


@pytest.fixture(scope="module")
def trial():
    return simulated()


@pytest.fixture(scope="module")
def stiffer():
    return simulated(parameters=STIFFER)


@pytest.fixture(scope="module")
def other():
    return simulated("sine-0.1", 0.1)


@pytest.fixture(scope="module")
def cells(trial, other):
    return sweep_trial(trial, dict.fromkeys(ESTIMATORS, LEVELS_DB), 6, SEED, [other], 2)


@pytest.fixture(scope="module")
def rows(cells):
    return noise_rows(cells)


# ---- simulated trials --------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["trial", "stiffer", "other"])
def test_joint_comes_back_without_noise_from_a_recorded_belt(name, request):
    simulation = request.getfixturevalue(name)
    cell = cell_of(simulation, "none", 20.0, 1)
    assert cell.mean == pytest.approx(simulation.truth, rel=1e-6)
    assert cell.vaf_trial == pytest.approx(100.0, abs=1e-6)
    assert cell.vaf_theta_trial > 99.9


def test_windows_hold_the_pulses_and_the_leg_stands_before(trial):
    assert trial.windows.shape == (3, 2)
    starts = trial.windows[:, 0] / RATE_HZ
    assert ((starts >= ONSETS_S) & (starts < np.add(ONSETS_S, 0.1))).all()
    outside = np.ones(trial.time.size, dtype=bool)
    for start, stop in trial.windows:
        outside[start:stop] = False
    assert np.abs(trial.y_foot_d[outside]).max() < 0.06 * np.abs(trial.y_foot_d).max()
    assert np.abs(trial.theta[:450]).max() < 1e-4 * np.abs(trial.theta).max()
    assert trial.torque("leg") == pytest.approx(trial.truth @ trial.regressors, abs=1e-9)


def test_offset_of_the_belts_sensor_moves_neither_foot_nor_leg(trial):
    offset = simulated(offset_m_per_s=0.05)
    assert offset.theta == pytest.approx(trial.theta, abs=1e-9)
    assert np.array_equal(offset.windows, trial.windows)
    assert abs(offset.y_foot[-1]) < 1e-3


def test_joint_that_cannot_carry_the_leg_is_refused():
    with pytest.raises(InputError) as caught:
        simulated(parameters=(0.015, 0.1, 1.0))
    assert_one_sentence(caught.value, "m g r", "1 Nm/rad")


def test_belt_that_rests_is_refused():
    with pytest.raises(InputError) as caught:
        simulated(peak_m_per_s=0.0)
    assert_one_sentence(caught.value, "belt velocity", "perturbations")


def test_trials_come_back_from_their_file_exactly(trial, stiffer, tmp_path):
    write_result(tmp_path / "trials.h5", simulated_result({"K_10": trial, "K_15": stiffer}))
    result = read_result(tmp_path / "trials.h5")
    assert result.facts["simulations"] == ["K_10", "K_15"]
    assert {result.units[f"K_10/{name}"] for name in SIGNALS} == set(SIGNALS.values())
    for key, expected in (("K_10", trial), ("K_15", stiffer)):
        read = simulated_trial(result, key, expected.name, LEG, FOOT)
        for field in fields(expected):
            before, after = getattr(expected, field.name), getattr(read, field.name)
            if isinstance(before, np.ndarray):
                assert np.array_equal(before, after), field.name
                assert before.dtype == after.dtype, field.name
            else:
                assert before == after, field.name
    read = simulated_trial(result, "K_15", stiffer.name, LEG, FOOT)
    again, first = (cell_of(one, "both", 20.0, 4) for one in (read, stiffer))
    assert np.array_equal(again.parameters, first.parameters)


# ---- cells -------------------------------------------------------------------------------------


def test_trial_is_swept_over_every_target_level_and_estimator_once(cells):
    found = [(cell.estimator, cell.noise_on, cell.snr_db) for cell in cells if cell.noise_on != "none"]
    noisy = [target for target in NOISE_ON if target != "none"]
    assert sorted(found) == sorted((e, t, db) for e in ESTIMATORS for t in noisy for db in LEVELS_DB)
    silent = [cell for cell in cells if cell.noise_on == "none"]
    assert [cell.estimator for cell in silent] == ESTIMATORS
    assert {cell.n_draws for cell in silent} == {1}
    assert {cell.n_draws for cell in cells if cell.noise_on != "none"} == {6}
    assert {cell.vaf_theta_trial.size for cell in cells if cell.noise_on != "none"} == {2}
    assert silent[1].mean == pytest.approx(TRUTH, rel=1e-6)


def test_estimators_have_levels_of_their_own(trial, other):
    levels = {"as-printed": LEVELS_DB, "as-tabulated": LEVELS_DB[1:]}
    cells = sweep_trial(trial, levels, 2, SEED, [other], 1)
    assert [(cell.estimator, cell.noise_on, cell.snr_db) for cell in cells] == [
        (estimator, noise_on, db)
        for estimator, own in levels.items()
        for noise_on in NOISE_ON
        for db in (own[:1] if noise_on == "none" else own)
    ]


def test_cell_of_a_sweep_is_the_cell_made_alone(cells, trial, other):
    (cell,) = [
        c for c in cells if (c.estimator, c.noise_on, c.snr_db) == ("recommended", "theta", LEVELS_DB[1])
    ]
    alone = cell_of(trial, "theta", LEVELS_DB[1], 6, [other], 2)
    assert np.array_equal(cell.parameters, alone.parameters)
    assert np.array_equal(cell.vaf_cross_validated, alone.vaf_cross_validated)
    reversed_levels = sweep_trial(trial, {"recommended": LEVELS_DB[::-1]}, 6, SEED, [other], 2)
    assert any(np.array_equal(cell.parameters, c.parameters) for c in reversed_levels)


def test_less_noise_spreads_the_recommended_estimates_less(rows):
    for target in ("tau", "theta", "both"):
        loud, quiet = (
            next(
                r.sd
                for r in rows
                if (r.estimator, r.noise_on, r.snr_db, r.quantity) == ("recommended", target, db, "K")
            )
            for db in LEVELS_DB
        )
        assert quiet < 0.3 * loud, target


# ---- rows --------------------------------------------------------------------------------------


def test_rows_tell_truth_and_apparent_impedance_of_parameters_alone(rows):
    about = {"bias", "without_noise", "apparent"}
    for row in rows:
        given = {name for name in about if getattr(row, name) is not None}
        assert given == (about if row.quantity in ("I", "B", "K") else set()), row.quantity
        assert row.stiffness_Nm_per_rad == 10.0
        if row.quantity == "K":
            assert row.mean - row.bias == pytest.approx(10.0)
            assert row.apparent == pytest.approx(3.66, rel=2e-3)
            if row.estimator == "recommended":
                assert row.without_noise == pytest.approx(10.0, rel=1e-6)
    assert set(TABLE_4_4) < {row.quantity for row in rows}


def test_rows_come_back_from_their_file(rows, tmp_path):
    path, again = tmp_path / "noise.csv", tmp_path / "again.csv"
    NOISE_ROWS.write(path, rows)
    read = NOISE_ROWS.read(path)
    assert len(read) == len(rows)
    for before, after in zip(rows, read, strict=True):
        for field in fields(NoiseRow):
            expected, found = getattr(before, field.name), getattr(after, field.name)
            assert found == (
                pytest.approx(expected, rel=1e-9) if isinstance(expected, float) else expected
            ), field.name
    NOISE_ROWS.write(again, read)
    assert again.read_bytes() == path.read_bytes()
    NOISE_ROWS.write(path, [])
    assert NOISE_ROWS.read(path) == []


@pytest.mark.parametrize(
    ("line", "column", "cell", "words"),
    [
        (0, "noise_on", "noise", "noise_on"),
        (1, "mean", "about ten", "about ten"),
        (1, "n_draws", "many", "many"),
        (1, "n_draws", "6,7", "damaged"),
    ],
)
def test_damaged_rows_are_refused(line, column, cell, words, rows, tmp_path):
    path = tmp_path / "noise.csv"
    NOISE_ROWS.write(path, rows[:2])
    lines = [text.split(",") for text in path.read_text().splitlines()]
    lines[line][lines[0].index(column)] = cell
    path.write_text("\n".join(map(",".join, lines)) + "\n")
    with pytest.raises(InputError) as caught:
        NOISE_ROWS.read(path)
    assert_one_sentence(caught.value, path, words)


@pytest.mark.parametrize("kept", [0, 100, None])
def test_file_that_was_cut_short_is_refused(kept, rows, tmp_path):
    path = tmp_path / "noise.csv"
    NOISE_ROWS.write(path, rows[:1])
    text = path.read_text()
    # nothing, a part of the header, or a row that ends before the number of draws
    path.write_text(text[: text.rindex(",1,Nms2/rad") - 3] if kept is None else text[:kept])
    with pytest.raises(InputError) as caught:
        NOISE_ROWS.read(path)
    assert_one_sentence(caught.value, path)


# ---- thesis Table 4-4 --------------------------------------------------------------------------


def row(condition, noise_on, mean, quantity="K", snr_db=20.0, estimator="recommended", stiffness=10.0):
    unit = {"K": "Nm/rad", "SEM_norm_K": "-", "SEM_count_K": "Nm/rad"}.get(quantity, "%")
    head = (condition, noise_on, snr_db, estimator, quantity)
    return NoiseRow(*head, mean, 0.1, None, 5, unit, stiffness, None, None)


def test_table_averages_over_its_conditions_at_its_level():
    rows = [
        row("sine-0.1", "tau", 9.0),
        row("sine-0.2", "tau", 12.0),
        row("minjerk-0.1", "tau", 500.0),  # not averaged
        row("sine-0.1", "tau", 700.0, snr_db=10.0),  # another level
        row("sine-0.1", "none", 10.0, snr_db=0.0),  # without noise the level does not matter
    ]
    (only,) = table_4_4(rows, {}, ["sine-0.1", "sine-0.2"], 20.0)
    assert dict(zip(TABLE_COLUMNS, only.values, strict=True)) == {
        "none": 10.0,
        "tau": 10.5,
        "theta": None,
        "both": None,
    }
    assert only.reported == [None] * 4
    assert table_4_4(rows, {}, ["sine-0.5"], 20.0) == []


def test_table_has_a_block_for_every_processing_and_stiffness_beside_what_was_printed(tmp_path):
    quantities = ("VAF_trial", "SEM_count_K", "SEM_norm_K", "unstable_fraction", "K")
    rows = [
        row("sine-0.1", noise_on, 1.0, quantity, estimator=estimator, stiffness=stiffness)
        for estimator in ESTIMATORS
        for stiffness in (10.0, 15.0)
        for quantity in quantities
        for noise_on in ("both", "theta", "tau", "none")
    ]
    reported = {"K": {"tau": 2.963, "none": 10.0, "both": 0.011, "theta": 0.028}, "SEM_K": {"theta": 0.039}}
    table = table_4_4(rows, reported, ["sine-0.1"], 20.0)
    blocks = [(r.pathway, r.estimator) for r in table]
    assert list(dict.fromkeys(blocks)) == [
        (e, f"K = {k} Nm/rad") for e in ("as-printed", "recommended") for k in (10, 15)
    ]
    for start in range(0, 16, 4):
        stiffness, norm, sem, vaf = block = table[start : start + 4]  # in the thesis's order
        assert [r.quantity for r in block] == ["K", "SEM_norm_K", "SEM_count_K", "VAF_trial"]
        assert [r.unit for r in block] == ["Nm/rad", "-", "Nm/rad", "%"]
        assert norm.reported == sem.reported
        assert stiffness.reported == [10.0, 2.963, 0.028, 0.011]
        assert sem.reported == [None, None, 0.039, None]
        assert vaf.reported == [None] * 4
    write_table(tmp_path / "table.csv", table, list(TABLE_COLUMNS))
    assert read_table(tmp_path / "table.csv") == (list(TABLE_COLUMNS), table)


def test_table_of_a_sweep_holds_the_truth_where_there_is_no_noise(rows):
    table = {(r.pathway, r.quantity): r for r in table_4_4(rows, {}, ["sine-0.3"], LEVELS_DB[1])}
    assert [q for estimator, q in table if estimator == "recommended"] == list(TABLE_4_4)
    assert [table["recommended", q].values[0] for q in "IBK"] == pytest.approx(TRUTH, rel=1e-6)
    assert [table["as-printed", q].values[0] for q in "IBK"] == pytest.approx(
        [0.0446, 0.0445, 3.66], rel=5e-3
    )
    # the wrong equation fits as well as the right one
    for pathway in ESTIMATORS:
        assert table[pathway, "VAF_perturbation"].values[0] == pytest.approx(100.0, abs=0.001)


def detected(trial, others=(), levels_db=(0.0, 20.0, 60.0)):
    rows = onset_rows(trial, others, levels_db, 4, SEED, OPTIONS.window, OPTIONS.lowpass)
    return rows, {(r.quantity, r.snr_db): r.mean for r in rows}


def test_onsets_are_found_and_exact_without_noise_and_not_where_noise_hides_them():
    rows, found = detected(simulated())
    assert (found["onsets_found", 60.0], found["onset_error", 60.0]) == (100.0, pytest.approx(0.0, abs=4.0))
    assert found["onsets_found", 0.0] == 0.0 and ("onset_error", 0.0) not in found
    assert found["onset_error", 20.0] > found["onset_error", 60.0]
    assert {(r.noise_on, r.estimator, r.n_draws) for r in rows} == {("belt", "detection", 4)}
    assert found_from(rows) == {"sine-0.3": 20.0}


def test_a_smaller_pulse_is_lost_in_the_noise_in_which_a_larger_one_is_found():
    small, large = simulated("sine-0.1", 0.1), simulated("sine-0.5", 0.5)
    levels = (15.0, 20.0, 30.0, 40.0)
    lowest = found_from(detected(small, [large], levels)[0] + detected(large, [small], levels)[0])
    assert lowest["sine-0.1"] > lowest["sine-0.5"]
    # alone, noise is relative to its own motion
    assert found_from(detected(small, (), levels)[0]) == {"sine-0.1": lowest["sine-0.5"]}


def test_a_level_counts_only_if_no_higher_one_loses_a_perturbation():
    def shares(*values):
        base = detected(simulated(), levels_db=(60.0,))[0][0]
        return [
            replace(base, snr_db=level, mean=value)
            for level, value in zip((0.0, 20.0, 40.0), values, strict=True)
        ]

    assert found_from(shares(100.0, 99.0, 100.0)) == {"sine-0.3": 40.0}
    assert found_from(shares(50.0, 100.0, 100.0)) == {"sine-0.3": 20.0}
    assert found_from(shares(100.0, 100.0, 90.0)) == {}


# ---- the report --------------------------------------------------------------------------------


def test_report_tells_how_far_estimates_are_off(rows, config):
    choices = config["noise"] | {"table_snr_db": LEVELS_DB[1], "table_estimators": ESTIMATORS, "draws": 6}
    noisy = pd.DataFrame([vars(r) for r in rows if r.noise_on != "none"])
    table = pd.DataFrame(columns=["quantity", "estimator", "pathway", "tau", "theta", "both"])
    run = Run({"noise": noisy, "table_4_4": table}, settings={"noise": choices}, study=STUDY)
    data = report_content(run, {"noise": noise}) | {"cells": None}
    tables = {name: own.to_csv(index=False) for name, own in run.tables.items()}
    words = chapter_words("noise", data, tables)
    assert "with white noise and 6 draws for each of 12 combinations" in words
    assert (
        "With noise it obtained other parameters" in words
        and "Figure 4-12, 30 dB" in words
        and "on the recorded belt" in words
    )
    assert "Mean estimate over the draws at 30 dB" in words
    assert re.search(r"I = 0\.0150 .* B = 0\.100 .* K = 10\.0 N·m/rad\. For Table 4-4 of the thesis", words)
    cells = [(estimator, target) for estimator in ESTIMATORS for target in ("tau", "theta", "both")]
    asked = [f'means("{estimator}", "{target}", "K").last()' for estimator, target in cells]
    for cell, told in zip(cells, evaluated(asked, "noise_values.typ", data, tables), strict=True):
        own = [
            r.mean
            for r in rows
            if (r.estimator, r.noise_on, r.snr_db, r.quantity) == (*cell, LEVELS_DB[1], "K")
        ]
        assert float(told) == pytest.approx(10.0 * abs(own[0] - 10.0), abs=0.51)
