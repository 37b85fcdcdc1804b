"""Names of columns, units and signs that a row of the trial sheet gives in place of the configuration's."""

import pytest

from tepsipe.errors import InputError
from tepsipe.experiments.registry import EXPERIMENTS
from workflow.settings.complete import pick, settings_of
from workflow.support.row_names import NAME_COLUMNS, check_names
from workflow.support.study import Study
from workflow.support.trial_sheet import COLUMNS, read_trial_sheet

ROW = dict.fromkeys(COLUMNS + NAME_COLUMNS, "-") | {
    "source": "recorded",
    "duration_s": "60",
    "log": "log.txt",
}
MANIPULATOR = ROW | {"experiment": "position_manipulator", "condition": "a"}
WRISTALYZER = ROW | {"experiment": "wristalyzer", "condition": "0.1", "command": "command.txt"}


@pytest.fixture
def study_of(config, tmp_path):
    def build(*rows):
        path = tmp_path / "trials.tsv"
        columns = list(rows[0])
        path.write_text(
            "".join("\t".join(line) + "\n" for line in [columns, *(list(r.values()) for r in rows)])
        )
        study = Study(config, read_trial_sheet(path, "."))
        study.check(str(path))
        return study

    return build


def refused(study_of, *rows):
    with pytest.raises(InputError) as caught:
        study_of(*rows)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("name", [name for name, known in EXPERIMENTS.items() if known.names])
def test_a_name_of_the_sheet_overrides_a_setting_that_is_there_or_that_every_row_gives(name, config):
    known = EXPERIMENTS[name]
    for column, setting in known.names.items():
        if column not in known.named:
            assert pick(settings_of(config)[name], setting)


def test_each_row_has_its_own_names_and_those_of_the_configuration_elsewhere(study_of, config):
    own = {"angle_column": "pos", "torque_column": "Torque (Nm)", "angle_unit": "deg", "torque_sign": "1"}
    study = study_of(MANIPULATOR, MANIPULATOR | {"condition": "b"} | own)
    assert study.of_trial("position_manipulator", "a")["files"] == config["position_manipulator"]["files"]
    files = study.of_trial("position_manipulator", "b")["files"]
    assert files["columns"] == config["position_manipulator"]["files"]["columns"] | {
        "angle": "pos",
        "torque": "Torque (Nm)",
    }
    assert (files["angle_unit"], files["torque_sign"]) == ("deg", 1)
    assert study.named_by("position_manipulator", "a")["columns"] == {}
    assert study.named_by("position_manipulator", "b")["columns"] == {
        "angle": "angle_column of the trial sheet",
        "torque": "torque_column of the trial sheet",
    }
    # the configuration itself is not changed
    assert study.settings["position_manipulator"]["files"] == config["position_manipulator"]["files"]


def test_log_and_command_of_a_manipulator_are_named_separately(study_of):
    own = {"time_column": "t", "command_time_column": "t", "torque_column": "tau", "trigger_column": "start"}
    study = study_of(WRISTALYZER | own)
    files = study.of_trial("wristalyzer", "0.1")["files"]
    assert files["log_columns"] == {"time": "t", "angle": "MotorAngle", "trigger_time": "start"}
    assert files["command_columns"] == {"time": "t", "torque": "tau"}
    by = study.named_by("wristalyzer", "0.1")["command_columns"]
    assert by == {
        "time": "command_time_column of the trial sheet",
        "torque": "torque_column of the trial sheet",
    }


@pytest.mark.parametrize(
    ("row", "changes", "said"),
    [
        (MANIPULATOR, {"load_column": "F"}, ["load_column", "position_manipulator", "angle_column", "'F'"]),
        (MANIPULATOR, {"angle_unit": "degrees"}, ["angle_unit", "rad or deg", "'degrees'"]),
        (MANIPULATOR, {"torque_sign": "minus"}, ["torque_sign", "1 or +1 or -1", "'minus'"]),
        (MANIPULATOR, {"angle_column": "x", "torque_column": "x"}, ["angle_column and torque_column", "'x'"]),
        # the same with a name of the configuration
        (MANIPULATOR, {"angle_column": "time_s"}, ["time_column and angle_column", "'time_s'"]),
        (WRISTALYZER, {"torque_sign": "-1"}, ["torque_sign", "wristalyzer", "'-1'"]),
        (
            ROW | {"experiment": "dummy", "condition": "d", "log": "d.c3d"},
            {"angle_column": "x"},
            ["angle_column", "dummy", "velocity_column", "'x'"],
        ),
        (
            ROW | {"experiment": "dummy", "condition": "d", "log": "d.mat"},
            {"velocity_column": "v", "calibration": "c.csv", "markers": "m.c3d"},
            ["velocity_column", "MATLAB", "'v'"],
        ),
        (
            ROW | {"experiment": "wristalyzer", "condition": "0.1", "source": "virtual_lab", "log": "-"},
            {"angle_column": "x", "profile": "multisine", "amplitude": "1"},
            ["angle_column", "virtual laboratory", "'x'"],
        ),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) and len(value) < 4 else None,
)
def test_a_name_that_cannot_be_used_is_refused_in_one_sentence(row, changes, said, study_of):
    text = refused(study_of, row | changes)
    for words in ("expected", "found", *said):
        assert words in text, f"{words!r} is not in: {text}"


def test_a_row_without_names_is_not_checked_against_the_configuration():
    same = {"files": {"columns": {"time": "x", "angle": "x"}}}
    check_names("position_manipulator", "a", same, {}, "trials.tsv")


def test_channels_of_a_whole_trial_are_named_row_by_row(study_of):
    whole = ROW | {"experiment": "dummy", "log": "d.c3d"}
    study = study_of(
        whole | {"condition": "a"},
        whole | {"condition": "b", "velocity_column": "Belt L", "trigger_column": "Sync"},
    )
    section = study.settings["dummy"]["recording"]
    assert study.for_ingest("dummy", "a")["recording"] == section
    assert study.for_ingest("dummy", "b")["recording"] == section | {
        "belt_velocity": section["belt_velocity"] | {"channel": "Belt L"},
        "trigger": "Sync",
    }
