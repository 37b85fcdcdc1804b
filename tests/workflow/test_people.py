"""Participants and belts in the trial sheet: what is analysed together, and with which person and models."""

import copy

import pytest

from tepsipe.errors import InputError
from workflow.settings.config import check_config
from workflow.support import groups, outputs
from workflow.support.checked_study import check_one_treadmill
from workflow.support.people import read_participants
from workflow.support.study import Study
from workflow.support.trial_sheet import COLUMNS, OPTIONAL_COLUMNS, read_trial_sheet

ROW = dict.fromkeys(COLUMNS + OPTIONAL_COLUMNS, "-") | {"source": "recorded", "duration_s": "60"}
PLATE = ROW | {"log": "l.mat", "calibration": "c.csv"}
STANDING = PLATE | {"experiment": "standing", "markers": "m.c3d"}
PEOPLE = {name: {"mass_kg": mass} for name, mass in (("P1", 60.0), ("P2", 80.0))}


def standing(person, task, number=1, **cells):
    named = {"condition": f"{person}-{task}-{number}", "participant": person, "task": task}
    return STANDING | named | cells


def plate(experiment, condition, role, belt, **cells):
    named = {"experiment": experiment, "condition": condition, "role": role, "belt": belt}
    markers = {"markers": "m.c3d"} if experiment == "weight" else {}
    return PLATE | markers | named | {"log": f"{experiment}-{condition}.mat"} | cells


def calibration(belt):
    return [
        plate(experiment, f"{belt}-{role}", role, belt)
        for experiment in ("weight", "empty")
        for role in ("calibrate", "validate")
    ]


@pytest.fixture
def study_of(config, tmp_path):
    def build(*rows, people=PEOPLE, **changes):
        path = tmp_path / "trials.tsv"
        rows = [
            row | {"log": f"{row['condition']}-{row['log']}"} if row["log"][:2] == "l." else row
            for row in rows
        ]
        lines = [list(rows[0]), *(list(row.values()) for row in rows)]
        path.write_text("".join("\t".join(line) + "\n" for line in lines))
        for key, value in changes.items():
            config["standing"][key] = value
        study = Study(config, read_trial_sheet(path, "."), people)
        study.check(str(path))
        return study

    return build


def refused(build, *arguments, **keywords):
    with pytest.raises(InputError) as caught:
        build(*arguments, **keywords)
    text = str(caught.value)
    assert "\n" not in text
    assert "expected" in text or "unknown" in text
    return text


# ---- participants ------------------------------------------------------------------------------------


def test_tasks_of_two_people_are_never_pooled(study_of):
    study = study_of(
        *[standing(who, task, k) for who in ("P2", "P1") for k in (2, 1) for task in ("stiff", "relax")]
    )
    assert study.tasks.names() == ["P1-relax", "P1-stiff", "P2-relax", "P2-stiff"]
    assert study.tasks.of_trials("{condition}", "P1-stiff") == ["P1-stiff-1", "P1-stiff-2"]
    # the foot is the person's: trials of the other tasks show it, those of other people do not
    assert study.tasks.of_other_tasks("{condition}", "P1-stiff") == study.tasks.of_trials(
        "{condition}", "P1-relax"
    )
    assert "<results>/estimates/standing_tasks/P2-relax.csv" in outputs.estimates(study)
    assert study.tasks.by_condition()["P2-relax-1"] == "P2-relax"
    assert outputs.participants(study) == ["<results>/tables/participants.csv", "<results>/tables/group.csv"]
    assert "<results>/figures/figure_participants.svg" in outputs.figures(study)


def test_another_order_of_the_rows_gives_the_same_pools(study_of):
    rows = [standing(who, task, k) for who in ("P1", "P2") for task in ("relax", "stiff") for k in (1, 2)]
    first, second = study_of(*rows), study_of(*rows[::-1])
    assert first.tasks.pools() == second.tasks.pools()
    assert first.tasks.names() == second.tasks.names()


def test_without_the_column_tasks_have_their_own_names(study_of):
    rows = [standing("P1", task) | {"participant": "-"} for task in ("stiff", "relax")]
    study = study_of(*rows, people=None)
    assert study.tasks.names() == ["stiff", "relax"]
    assert not (study.by_participant or study.by_belt)
    assert groups.labels(study) == {}
    assert outputs.participants(study) == groups.members(study) == []


def test_person_has_the_numbers_of_the_table_and_the_markers_of_the_configuration(study_of, config):
    own = {"P1": {"ankle_height_m": 0.09, "foot_markers": config["standing"]["person"]["foot_markers"][:2]}}
    study = study_of(standing("P1", "relax"), standing("P2", "relax"), participants=own)
    one, two = study.person("P1"), study.person("P2")
    assert (one["mass_kg"], one["ankle_height_m"], len(one["foot_markers"])) == (60.0, 0.09, 2)
    assert two == config["standing"]["person"] | {"mass_kg": 80.0}
    assert study.person(None) == config["standing"]["person"]
    assert groups.masses_kg(study) == {"standing": {"P1": 60.0, "P2": 80.0}}


def test_figures_of_a_task_show_the_person_of_the_example(study_of):
    rows = [standing(who, task) for who in ("P1", "P2") for task in ("relax", "stiff")]
    study = study_of(*rows, example_condition="P1-stiff-1")
    assert list(study.tasks.shown()) == ["P1-relax", "P1-stiff"]
    assert list(study.tasks.groups()) == ["P1-relax", "P1-stiff"]
    assert list(study.tasks.groups("P2")) == list(study.tasks.shown("P2")) == ["P2-relax", "P2-stiff"]
    # without the configured condition, the last of the sheet
    assert list(study_of(*rows, example_condition="x").tasks.shown()) == ["P2-relax", "P2-stiff"]


def test_members_of_other_experiments_are_known_by_task_or_condition(study_of):
    manipulator = ROW | {"experiment": "position_manipulator", "log": "l.csv", "participant": "P1"}
    study = study_of(
        manipulator | {"condition": "P1-rest"},
        manipulator | {"condition": "P1-push-2", "task": "push"},
        manipulator | {"condition": "rest", "participant": "P9"},
        people={"P1": {"stature_m": 1.7}, "P9": {"mass_kg": 50.0}},
    )
    found = [(m["condition"], m["participant"], m["label"], m["is_task"]) for m in groups.members(study)]
    assert found == [
        ("P1-rest", "P1", "rest", False),
        ("P1-push-2", "P1", "push", True),
        ("rest", "P9", "rest", False),
    ]
    assert groups.masses_kg(study) == {"position_manipulator": {"P1": None, "P9": 50.0}}
    assert groups.shown_estimators(study) == {"position_manipulator": ["impedance", "parallel-cascade"]}
    cells = groups.labels(study)["participant"]["position_manipulator"]
    assert cells == {"P1-rest": "P1", "P1-push-2": "P1", "rest": "P9"}


@pytest.mark.parametrize(
    ("rows", "keywords", "said"),
    [
        ([standing("P 1", "relax", condition="a")], {}, ["line 2", "'P 1'", "letters"]),
        ([standing("..", "relax", condition="a")], {}, ["line 2", "'..'"]),
        ([plate("empty", "a", "calibrate", "-", participant="P1")], {}, ["empty", "'P1'"]),
        ([standing("P1", "relax"), standing("P1", "stiff", participant="-")], {}, ["P1-stiff-1", "standing"]),
        ([standing("P3", "relax")], {}, ["'P3'", "add a row"]),
        ([standing("P1", "relax")], {"people": None}, ["body mass", "P1", "study.participants"]),
        ([standing("P1", "relax")], {"people": {"P1": {"stature_m": 1.7}}}, ["body mass", "P1", "mass_kg"]),
        ([standing("P1", "relax")], {"participants": {"P7": {}}}, ["standing.participants", "'P7'"]),
        ([standing("P1", "relax")], {"participants": {"P1": {"mass_kg": 61.0}}}, ["mass_kg", "P1", "once"]),
        # P1-a and b, P1 and a-b
        (
            [standing("P1-a", "b", 2), standing("P1", "a-b", 3)],
            {"people": {"P1-a": {"mass_kg": 1.0}, "P1": {"mass_kg": 1.0}}},
            ["'P1-a-b'"],
        ),
        ([standing("P1", "relax"), standing("P1", "stiff", condition="P1-relax")], {}, ["'P1-relax'"]),
    ],
)
def test_participants_that_cannot_be_used_are_refused_in_one_sentence(rows, keywords, said, study_of):
    text = refused(study_of, *rows, **keywords)
    for words in said:
        assert words in text, f"{words!r} is not in: {text}"


def test_markers_of_a_participant_must_be_in_the_file(config):
    marker = {"label": "toe", "anterior_offset_m": 0.1, "longitudinal_offset_m": 0.0}
    changed = copy.deepcopy(config)
    changed["standing"]["participants"] = {"P1": {"foot_markers": [marker]}}
    text = refused(check_config, changed, "mine")
    assert "standing.participants.P1.foot_markers" in text
    assert "'toe'" in text


def test_participant_of_the_configuration_has_the_keys_of_a_person(config):
    config["standing"]["participants"] = {"P1": {"mas_kg": 61.0}}
    text = refused(check_config, config, "mine")
    assert "standing.participants.P1.mas_kg" in text
    assert "mass_kg" in text


# ---- the table of the participants -------------------------------------------------------------------


@pytest.fixture
def table(tmp_path):
    def write(text):
        path = tmp_path / "participants.tsv"
        path.write_text(text)
        return path

    return write


def test_numbers_of_participants_are_read_and_a_dash_keeps_those_of_the_configuration(table):
    path = table("participant\tmass_kg\tfoot_com_m\nP1\t61.5\t-0.01\n\nP2\t-\t0.05\n")
    assert read_participants(path) == {
        "P1": {"mass_kg": 61.5, "foot_com_m": -0.01},
        "P2": {"foot_com_m": 0.05},
    }


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("participant\tmass\nP1\t60\n", ["'mass'", "did you mean 'mass_kg'?"]),
        ("participant\tmass_kg\tmass_kg\nP1\t60\t60\n", ["'mass_kg'", "twice"]),
        ("mass_kg\tstature_m\n60\t1.7\n", ["'participant'"]),
        ("participant,mass_kg\nP1,60\n", ["separated by tabs", "'participant,mass_kg'"]),
        ("participant\tmass_kg\nP1\n", ["2 cells", "line 2"]),
        ("participant\tmass_kg\nP1\t60\nP1\t60\n", ["'P1' again", "once", "line 3"]),
        ("participant\tmass_kg\nP/1\t60\n", ["'P/1'", "line 2"]),
        ("participant\tmass_kg\nP1\t60 kg\n", ["mass_kg", "'60 kg'", "0.1 to 500"]),
        ("participant\tmass_kg\nP1\tnan\n", ["mass_kg", "'nan'"]),
        ("participant\tcom_height\nP1\t55\n", ["com_height", "0.1 to 0.9", "'55'"]),
        ("participant\tmass_kg\nP1\t64000\n", ["mass_kg", "'64000'", "unit"]),
        ("participant\tstature_m\nP1\t175\n", ["stature_m", "'175'", "unit"]),
        ("participant\tmass_kg\nP1\t60", ["line break", "truncated"]),
        ("", ["participants"]),
    ],
)
def test_table_with_a_mistake_is_refused_in_one_sentence(text, said, table):
    path = table(text)
    found = refused(read_participants, path)
    for words in (str(path), *said):
        assert words in found, f"{words!r} is not in: {found}"


# ---- belts ---------------------------------------------------------------------------------------------


def test_models_are_those_of_the_belt_of_a_trial(study_of):
    rows = [standing("P1", "relax", belt="left"), standing("P1", "relax", 2)]
    study = study_of(*rows, *calibration("left"), *calibration("right"))
    assert study.treadmill.plates() == {"plate_left": "left", "plate_right": "right"}
    # a dash is the belt of the configuration
    assert [study.treadmill.belt_of("standing", f"P1-relax-{k}") for k in (1, 2)] == ["left", "right"]
    assert outputs.plate_models(study, "standing", "P1-relax-1") == [
        "<results>/treadmill_models/plate_left_Fy.json",
        "<results>/treadmill_models/plate_left_Mx.json",
    ]
    assert {tuple(trial) for trial in study.treadmill.plate_trials("left")} == {
        (experiment, f"left-{role}", role)
        for experiment in ("weight", "empty")
        for role in ("calibrate", "validate")
    }
    assert len(outputs.model_scores(study)) == len(outputs.belts_of_scores(study)) == 2
    assert study.named("standing", "P1-relax-1") == {"participant": "P1", "belt": "left"}
    assert study.named("standing", "P1-relax-2") == {"participant": "P1"}
    # trials of one task on two belts are two pools, and two rows of the tables
    assert study.tasks.names() == ["P1-left-relax", "P1-right-relax"]
    assert [m["belt"] for m in groups.members(study)] == ["left", "right"]
    assert groups.labels(study)["belt"]["standing"]["P1-left-relax"] == "left"


def test_a_person_on_both_belts_needs_the_models_of_both(study_of):
    study = study_of(standing("P1", "relax", belt="both"), *calibration("left"), *calibration("right"))
    plates = ["plate_left", "plate_right"]
    assert study.treadmill.plates_of("standing", "P1-relax-1") == plates
    assert outputs.plate_models(study, "standing", "P1-relax-1") == [
        f"<results>/treadmill_models/{plate}_{load}.json" for plate in plates for load in ("Fy", "Mx")
    ]
    assert len(outputs.held_out(study, "standing", "P1-relax-1")) == 2
    assert study.tasks.names() == ["P1-both-relax"]
    text = refused(study_of, standing("P1", "relax", belt="both"), *calibration("right"))
    assert "weight and empty on the left belt" in text
    # a weight lies on one belt
    text = refused(study_of, *[row | {"belt": "both"} for row in calibration("right")])
    assert "left or right" in text


def test_exception_for_a_belt_is_possible_where_belts_have_models_of_their_own(config):
    config["plate_treadmill"]["exceptions"] = {"standing": {"belt": "left"}}
    experiments = ["standing", "weight", "empty"]
    text = refused(check_one_treadmill, config, experiments, "mine")
    assert "name the belt of every trial in the trial sheet" in text
    check_one_treadmill(config, experiments, "mine", by_belt=True)
    config["plate_treadmill"]["exceptions"]["standing"]["lowpass_order"] = 2
    assert "lowpass_order" in refused(check_one_treadmill, config, experiments, "mine", by_belt=True)


def test_without_the_column_the_models_have_their_own_name(study_of):
    study = study_of(*[row | {"belt": "-"} for row in calibration("right")])
    assert study.treadmill.plates() == {"plate": "right"}
    assert outputs.belts_of_scores(study) == []
    assert outputs.model_scores(study) == ["<results>/treadmill_models/plate.csv"]


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([standing("P1", "relax", belt="lft")], ["line 2", "left or right", "'lft'"]),
        (
            [ROW | {"experiment": "position_manipulator", "condition": "1", "log": "l.csv", "belt": "left"}],
            ["position_manipulator", "'left'"],
        ),
        (
            [
                dict.fromkeys(STANDING, "-")
                | {"experiment": "standing", "condition": "a", "source": "virtual_lab", "duration_s": "60"}
                | {"profile": "sine", "amplitude": "0.3", "interval_s": "4", "task": "relax", "belt": "left"}
            ],
            ["virtual laboratory", "right", "'left'"],
        ),
        (
            [standing("P1", "relax", belt="left"), *calibration("right")],
            ["standing/P1-relax-1", "left belt", "weight and empty"],
        ),
        ([*calibration("right"), *calibration("left")[1:]], ["weight on the left belt", "calibrate"]),
        (
            [*calibration("right"), calibration("left")[0], *calibration("left")[2:]],
            ["weight on the left belt", "validate"],
        ),
        ([*calibration("right"), *calibration("left")[:2]], ["empty on the left belt", "calibrate"]),
    ],
)
def test_belts_that_cannot_be_used_are_refused_in_one_sentence(rows, said, study_of):
    text = refused(study_of, *rows)
    for words in said:
        assert words in text, f"{words!r} is not in: {text}"
