"""Tables of load and belt velocity: jitter leaves the samples alone, what cannot be used is refused."""

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.ingest.belt_table import (
    INTERPOLATED,
    KEPT,
    BeltTableOptions,
    belt_clock,
    ingest_belt_table,
    refuse_other_unit,
    rounded_rate,
)
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.trial import read_trial, write_trial
from tepsipe.signals.resampling import repair_time_stamps

COLUMNS = {"time": "Timestamp (s)", "load": "Pitch Moment (Nm)", "velocity": "Belt Velocity (m/s)"}
NAMED_BY = {key: f"{key}_column of the trial sheet" for key in COLUMNS}
OPTIONS = BeltTableOptions(load_unit="Nm", max_gap_s=0.1, shortest_s=20.0)
RATE_HZ, DURATION_S = 100.0, 30.0
LOAD_HZ, VELOCITY_HZ = 1.3, 0.7


def load_at(time):
    """Load (Nm) at instants (s)."""
    return 12.0 * np.sin(2.0 * np.pi * LOAD_HZ * time)


def velocity_at(time):
    """Belt velocity (m/s) at instants (s)."""
    return 1.2 + 0.3 * np.cos(2.0 * np.pi * VELOCITY_HZ * time)


def table_at(time, stamps=None):
    """Samples of both signals at instants, under stamps (s) that may say otherwise."""
    stamps = time if stamps is None else stamps
    return {"time": stamps, "load": load_at(time), "velocity": velocity_at(time)}


def regular(rate_hz=RATE_HZ, duration_s=DURATION_S):
    return np.arange(round(duration_s * rate_hz) + 1) / rate_hz


def ingest(table, duration_s=DURATION_S, **changes):
    options = BeltTableOptions(**(vars(OPTIONS) | changes))
    return ingest_belt_table(table, COLUMNS, options, duration_s, "log.txt")


def refuse(table, *names, duration_s=DURATION_S, **changes):
    with pytest.raises(InputError) as caught:
        ingest(table, duration_s, **changes)
    assert_one_sentence(caught.value, "log.txt", *names)
    return str(caught.value)


# ---- a regular clock under poor stamps ---------------------------------------------------------


def assert_kept(trial, table):
    assert trial.attributes["clock"] == KEPT
    assert np.array_equal(trial.values("load"), table["load"])
    assert np.array_equal(trial.values("belt_velocity"), table["velocity"])
    assert np.array_equal(trial.time, np.arange(table["time"].size) / trial.rate_hz)


@pytest.mark.parametrize("jitter_s", [0.0, 0.001, 0.004])
def test_jitter_of_the_stamps_leaves_the_samples_one_to_one(jitter_s, rng):
    time = regular()
    stamps = np.sort(time + rng.uniform(-jitter_s, jitter_s, time.size))
    table = table_at(time, stamps)
    trial = ingest(table, DURATION_S - 0.1)
    assert_kept(trial, table)
    assert trial.rate_hz == RATE_HZ
    deviation = np.abs(stamps - time).max()
    assert trial.attributes["largest_stamp_deviation_s"] == pytest.approx(deviation, rel=0.1, abs=1e-9)


def test_units_and_clock_start_are_those_of_the_trial():
    time = regular()
    trial = ingest(table_at(time, time + 1234.5))
    assert trial.signals["load"].unit == "Nm"
    assert trial.signals["belt_velocity"].unit == "m/s"
    assert trial.time[0] == 0.0
    force = ingest_belt_table(
        table_at(time), COLUMNS | {"load": "Fx"}, BeltTableOptions("N", 0.1, 20.0), DURATION_S, "log.txt"
    )
    assert force.signals["load"].unit == "N"


@pytest.mark.parametrize("late", [1, 3, 8])
def test_stamps_that_came_late_together_leave_the_samples_one_to_one(late):
    time = regular()
    stamps = time.copy()
    stamps[1000 : 1000 + late] = stamps[1000 + late]
    table = table_at(time, stamps)
    trial = ingest(table)
    assert_kept(trial, table)
    assert trial.attributes["repeated_stamps"] == late
    assert trial.attributes["longest_step_s"] == pytest.approx((late + 1) / RATE_HZ)
    assert trial.attributes["largest_stamp_deviation_s"] == pytest.approx(late / RATE_HZ, rel=0.01)


@pytest.mark.parametrize(("rate_hz", "decimals"), [(128.0, 3), (120.0, 2), (300.0, 3)])
def test_stamps_with_few_decimals_leave_the_samples_one_to_one(rate_hz, decimals):
    time = regular(rate_hz)
    table = table_at(time, np.round(time, decimals))
    trial = ingest(table)
    assert_kept(trial, table)
    assert trial.rate_hz == rate_hz


def test_repeated_velocity_samples_are_counted_and_kept():
    time = regular()
    table = table_at(time)
    table["velocity"] = np.repeat(table["velocity"][::2], 2)[: time.size]
    trial = ingest(table)
    assert_kept(trial, table)
    assert trial.attributes["repeated_velocity_fraction"] == pytest.approx(0.5, abs=1e-3)


# ---- the rate ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("measured", "rounded"),
    [(100.0042, 100.0), (99.95, 100.0), (127.93, 128.0), (100.3, 100.3), (101.01, 101.0), (1000.4, 1000.0)],
)
def test_rate_is_rounded_where_it_is_close_to_a_plain_number(measured, rounded):
    assert rounded_rate(measured) == rounded


def test_recordings_of_one_instrument_whose_clock_drifts_have_exactly_one_rate(rng):
    rates = set()
    for drift in (-1e-5, 0.0, 1e-5, 4e-5):
        time = regular()
        stamps = np.round(time * (1.0 + drift) + rng.uniform(-0.001, 0.001, time.size), 6)
        dropped = np.delete(np.arange(time.size), [700, 1900])
        kept = ingest(table_at(time, stamps), 29.0)
        interpolated = ingest(table_at(time[dropped], stamps[dropped]), 29.0)
        assert kept.attributes["recorded_rate_hz"] == pytest.approx(RATE_HZ / (1.0 + drift), rel=2e-6)
        assert interpolated.attributes["clock"] == INTERPOLATED
        rates |= {kept.rate_hz, interpolated.rate_hz}
    assert rates == {RATE_HZ}


# ---- an irregular clock ------------------------------------------------------------------------


def largest_error(trial):
    """Largest error of either signal as part of its amplitude."""
    load = np.abs(trial.values("load") - load_at(trial.time)).max() / 12.0
    velocity = np.abs(trial.values("belt_velocity") - velocity_at(trial.time)).max() / 0.3
    return max(load, velocity)


def straight_line_error(step_s):
    """Largest error of a straight line across a step, as part of a sine's amplitude: (omega h)^2 / 8."""
    return (2.0 * np.pi * LOAD_HZ * step_s) ** 2 / 8.0


@pytest.mark.parametrize("at", [[30], [1500], [2970], [400, 1200, 1201, 1202, 2500]])
def test_dropped_samples_are_noticed_and_the_signals_recovered(at):
    time = np.delete(regular(), at)
    trial = ingest(table_at(time))
    assert trial.attributes["clock"] == INTERPOLATED
    assert trial.rate_hz == RATE_HZ
    assert np.diff(trial.time) == pytest.approx(1.0 / RATE_HZ)
    assert trial.time[-1] == pytest.approx(DURATION_S)
    assert largest_error(trial) <= 1.01 * straight_line_error(np.diff(time).max())


def test_many_dropped_samples_do_not_lower_the_rate(rng):
    time = regular()
    time = time[np.concatenate([[True], rng.uniform(size=time.size - 2) > 0.1, [True]])]
    trial = ingest(table_at(time))
    assert trial.attributes["clock"] == INTERPOLATED
    assert trial.rate_hz == RATE_HZ
    assert largest_error(trial) <= 1.01 * straight_line_error(np.diff(time).max())


def test_samples_of_an_irregular_clock_are_interpolated_between_their_stamps(rng):
    time = np.cumsum(rng.uniform(0.007, 0.013, round(DURATION_S * RATE_HZ) + 50))
    trial = ingest(table_at(time - time[0]), 29.0)
    assert trial.attributes["clock"] == INTERPOLATED
    assert trial.rate_hz == pytest.approx(RATE_HZ, rel=0.01)
    assert largest_error(trial) <= 1.01 * straight_line_error(0.013)


def test_clock_that_changes_its_rate_is_irregular():
    halves = np.concatenate([np.arange(1500) / 100.0, 15.0 + np.arange(1500) / 101.0])
    assert not belt_clock(halves).regular


def test_keeping_the_samples_beats_believing_jittered_stamps(rng):
    time = regular()
    stamps = np.sort(time + rng.uniform(-0.001, 0.001, time.size))
    kept = ingest(table_at(time, stamps), 29.0)
    repaired = repair_time_stamps(stamps, 0.1, "log.txt").keep
    believed = np.interp(time, stamps[repaired], load_at(time)[repaired])
    assert np.abs(kept.values("load") - load_at(time)).max() < 1e-12
    assert np.abs(believed - load_at(time)).max() > 0.01


# ---- missing samples ---------------------------------------------------------------------------


@pytest.mark.parametrize("dropped", [[], [1500]], ids=["kept", "interpolated"])
def test_missing_fields_are_filled_across_short_gaps_only(dropped):
    time = np.delete(regular(), dropped)
    table = table_at(time)
    table["load"][1000:1008] = np.nan
    table["velocity"][2000] = np.nan
    trial = ingest(table)
    assert trial.attributes["missing_samples"] == 9
    assert largest_error(trial) <= 1.01 * straight_line_error(0.09)
    table["load"][1000:1012] = np.nan
    refuse(table, "'Pitch Moment (Nm)'", "0.1 s", "0.13 s")
    assert ingest(table, max_gap_s=0.2).attributes["missing_samples"] == 13


def test_missing_fields_at_either_end_are_cut_not_extrapolated():
    table = table_at(regular())
    table["load"][:5] = np.nan
    table["velocity"][-3:] = np.nan
    trial = ingest(table, DURATION_S - 0.1)
    assert trial.attributes["samples_cut_at_ends"] == 8
    assert trial.time.size == table["time"].size - 8
    assert np.array_equal(trial.values("load"), table["load"][5:-3])


# ---- what is refused ---------------------------------------------------------------------------


def test_gap_in_time_is_refused():
    time = np.delete(regular(), slice(1000, 1020))
    refuse(table_at(time), "0.1 s", "0.21 s", "9.99 s")


def test_time_that_runs_backwards_is_refused():
    table = table_at(regular())
    table["time"][1000:] -= 0.05
    refuse(table, "backwards")


def test_missing_time_stamp_is_refused():
    table = table_at(regular())
    table["time"][1000] = np.nan
    refuse(table, "time stamp", "line 1001")


@pytest.mark.parametrize("key", ["load", "velocity"])
def test_infinite_number_is_refused_with_its_line(key):
    table = table_at(regular())
    table[key][1000] = np.inf
    refuse(table, repr(COLUMNS[key]), "line 1002", "inf")


@pytest.mark.parametrize("key", ["load", "velocity"])
def test_signal_that_never_changes_is_refused(key):
    table = table_at(regular())
    table[key][:] = 1.25
    refuse(table, repr(COLUMNS[key]), "1.25 throughout")


@pytest.mark.parametrize("key", ["load", "velocity"])
def test_signal_without_numbers_is_refused(key):
    table = table_at(regular())
    table[key][:] = np.nan
    refuse(table, repr(COLUMNS[key]), "none")


def test_signals_that_are_never_there_together_are_refused():
    table = table_at(regular())
    table["load"][::2] = np.nan
    table["velocity"][1::2] = np.nan
    refuse(table, repr(COLUMNS["load"]), repr(COLUMNS["velocity"]))


def test_recording_that_is_shorter_than_the_sheet_says_is_refused():
    refuse(table_at(regular()), "31 s", "30.00 s", "trial sheet", duration_s=31.0)


def test_recording_that_is_too_short_to_use_is_refused():
    refuse(table_at(regular(duration_s=12.0)), "20 s", "12.00 s", duration_s=12.0)


def test_stamps_too_coarse_to_tell_samples_apart_are_refused():
    time = np.delete(regular(300.0), 4000)
    refuse(table_at(time, np.round(time, 2)), "Timestamp (s)", "decimals")


OTHER_UNITS = [
    ("time", "Timestamp (ms)", "s", "Nm"),
    ("time", "Time [min]", "s", "Nm"),
    ("velocity", "Belt Velocity (km/h)", "m/s", "Nm"),
    ("velocity", "Belt Velocity (mm/s)", "m/s", "Nm"),
    ("velocity", "Belt Position (m)", "m/s", "Nm"),
    ("load", "Pitch Moment (Nmm)", "Nm", "Nm"),
    ("load", "Pitch Moment (N.mm)", "Nm", "Nm"),
    ("load", "Pitch Moment (kNm)", "Nm", "Nm"),
    ("load", "Pitch Moment [ft-lb]", "Nm", "Nm"),
    ("load", "Fore-aft Force (N)", "Nm", "Nm"),
    ("load", "Pitch Moment (Nm)", "N", "N"),
    ("load", "Force (kN)", "N", "N"),
    ("load", "Force (V)", "N", "N"),
]


@pytest.mark.parametrize(("key", "column", "unit", "load_unit"), OTHER_UNITS, ids=[o[1] for o in OTHER_UNITS])
def test_header_with_another_unit_is_refused(key, column, unit, load_unit):
    options = BeltTableOptions(load_unit, 0.1, 20.0)
    columns = COLUMNS | {"load": "load"} | {key: column}
    with pytest.raises(InputError) as caught:
        ingest_belt_table(table_at(regular()), columns, options, DURATION_S, "log.txt")
    assert_one_sentence(caught.value, "log.txt", repr(column), f"in {unit}")


@pytest.mark.parametrize(
    ("column", "unit"),
    [(f"Pitch Moment ({u})", "Nm") for u in ("Nm", "N.m", "N*m", "N m", "N·m", "N-m", "nm")]
    + [(f"Belt Velocity {u}", "m/s") for u in ("(m/s)", "[m/s]", "(m s^-1)", "(M/S)", "(left)", "")]
    + [("Force (left) (N)", "N"), ("Time [sec]", "s"), ("My (filtered)", "Nm"), ("()", "s")],
)
def test_header_with_the_unit_or_none_is_accepted(column, unit):
    refuse_other_unit(column, unit, "log.txt")


# ---- the file ----------------------------------------------------------------------------------


@pytest.fixture
def written(tmp_path):
    """Write a table as its instrument would; read it back as the study does."""

    def write(delimiter="\t", change=lambda text: text, encoding="utf-8"):
        table = table_at(regular())
        lines = [delimiter.join(COLUMNS.values())]
        lines += [delimiter.join(f"{v:.6f}" for v in row) for row in zip(*table.values(), strict=True)]
        path = tmp_path / "log.txt"
        path.write_text(change("\n".join(lines) + "\n"), encoding=encoding)
        return path

    return write


@pytest.mark.parametrize(("delimiter", "encoding"), [("\t", "utf-8"), (",", "utf-8"), (",", "utf-8-sig")])
def test_table_is_read_ingested_and_stored(delimiter, encoding, written, tmp_path):
    path = written(delimiter, encoding=encoding)
    table = read_text_table(path, COLUMNS, delimiter, NAMED_BY)
    trial = ingest(table)
    write_trial(tmp_path / "t.h5", trial, "belt", "slow-1", {"log": path}, vars(OPTIONS))
    again = read_trial(tmp_path / "t.h5")
    assert again.attributes["clock"] == KEPT
    assert again.values("load") == pytest.approx(load_at(regular()), abs=1e-6)
    assert again.values("belt_velocity") == pytest.approx(velocity_at(regular()), abs=1e-6)


DAMAGES = {
    "other name": (
        lambda text: text.replace("Belt Velocity (m/s)", "Belt Speed (m/s)", 1),
        ["did you mean 'Belt Speed (m/s)'", "velocity_column of the trial sheet"],
    ),
    "column left out": (
        lambda text: text.replace("Pitch Moment (Nm)", "Vertical (N)", 1),
        ["'Pitch Moment (Nm)'", "load_column of the trial sheet"],
    ),
    "column twice": (
        lambda text: text.replace("Belt Velocity (m/s)", "Pitch Moment (Nm)", 1),
        ["'Pitch Moment (Nm)'", "found 2"],
    ),
    "other delimiter": (lambda text: text.replace("\t", ";"), ["delimiter"]),
    "decimal comma": (lambda text: text.replace("0.010000", "0,010000", 1), ["'0,010000'", "line 3"]),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_table_is_refused(damage, written):
    change, names = DAMAGES[damage]
    path = written(change=change)
    with pytest.raises(InputError) as caught:
        read_text_table(path, COLUMNS, "\t", NAMED_BY)
    assert_one_sentence(caught.value, path, *names)


# ---- recordings of a real treadmill ------------------------------------------------------------


@pytest.mark.parametrize(("number", "zero_steps"), [(1, 0), (2, 1)])
def test_real_recordings_are_kept_one_to_one_on_one_clock(number, zero_steps, real_data):
    path = real_data(f"rmill-treadmill/RandomSlowSpeed{number}.txt")
    table = read_text_table(path, COLUMNS, "\t", NAMED_BY)
    trial = ingest(table, 349.0)
    assert_kept(trial, table)
    assert trial.rate_hz == RATE_HZ
    found = trial.attributes
    assert found["repeated_stamps"] == zero_steps
    assert 0.29 < found["repeated_velocity_fraction"] < 0.34
    assert found["recorded_rate_hz"] == pytest.approx(100.0042, abs=1e-4)
    assert found["largest_stamp_deviation_s"] < 0.0105


def test_real_recording_that_lacks_a_sample_is_interpolated(real_data):
    path = real_data("rmill-treadmill/RandomSlowSpeed2.txt")
    table = read_text_table(path, COLUMNS, "\t", NAMED_BY)
    trial = ingest({key: np.delete(values, 12345) for key, values in table.items()}, 349.0)
    assert trial.attributes["clock"] == INTERPOLATED
    assert trial.rate_hz == RATE_HZ
