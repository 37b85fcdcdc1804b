"""Trials of one file in the trial sheet, in the configuration and through Snakemake."""

import copy
import re

import h5py
import pytest
import yaml
from builders import assert_one_sentence
from c3d_builders import single_c3d, single_c3d_settings
from study_builders import OVERRIDES, snakemake, write_config, write_sheet

from tepsipe.arguments import options_of
from tepsipe.errors import InputError
from tepsipe.ingest.treadmill_options import RecordingOptions
from workflow.settings.complete import settings_of
from workflow.settings.config import check_config
from workflow.support.checked_study import check_one_treadmill, check_recordings
from workflow.support.study import Study
from workflow.support.trial_sheet import COLUMNS, OPTIONAL_COLUMNS, read_trial_sheet

HEADER = (*COLUMNS, *OPTIONAL_COLUMNS[:3])  # role, emg, task


@pytest.fixture
def sheet(tmp_path):
    def write(*rows):
        path = tmp_path / "trials.tsv"
        cells = [row.split() for row in rows]
        lines = [HEADER, *(row + ["-"] * (len(HEADER) - len(row)) for row in cells)]
        path.write_text("".join("\t".join(line) + "\n" for line in lines))
        return path

    return write


# ---- the trial sheet -------------------------------------------------------------------------------


def test_a_c3d_alone_is_a_trial(sheet):
    path = sheet(
        "dummy a recorded - - - 70 a.c3d - - -",
        "weight a recorded - - - 60 w.C3D - - - calibrate",
        "empty a recorded - - - 60 e.c3d - - - calibrate",
        "standing a recorded - - - 65 s.c3d - - - - - calm",
        "standing b recorded - - - 65 t.c3d - - - - s.edf calm",
        "weight b recorded - - - 60 w2.c3d - - - validate",
    )
    trials = read_trial_sheet(path, "/data")
    assert trials["dummy", "a"].files == {"log": "/data/a.c3d"}
    assert trials["weight", "a"].files == {"log": "/data/w.C3D"}
    assert trials["standing", "b"].files == {"log": "/data/t.c3d", "emg": "/data/s.edf"}


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("dummy a recorded - - - 70 a.c3d - plate.csv -", ["'-' for the calibration", "a.c3d", "plate.csv"]),
        ("dummy a recorded - - - 70 a.c3d - - b.c3d", ["'-' for the markers", "a.c3d", "b.c3d"]),
        ("dummy a recorded - - - 70 a.mat - - b.c3d", ["a calibration file for dummy/a"]),
        ("dummy a recorded - - - 70 - - - a.c3d", ["a log file for dummy/a"]),
    ],
)
def test_other_files_beside_it_are_refused(row, words, sheet):
    path = sheet(row)
    with pytest.raises(InputError) as caught:
        read_trial_sheet(path, ".")
    assert_one_sentence(caught.value, path, "line 2", *words)


# ---- the configuration -----------------------------------------------------------------------------


def configured(config, root, **recording):
    config = copy.deepcopy(config)
    config["plate_treadmill"]["recording"] |= recording
    check_config(config, "my-study")
    return config


VELOCITY = {"channel": "Speed", "m_per_s_per_unit": None, "offset": 0.0, "markers": []}


@pytest.mark.parametrize(
    ("recording", "words"),
    [
        ({}, ["belt_velocity", "a channel or belt-fixed markers", "dummy"]),
        ({"plates": {"left": [1], "right": [1, 2]}}, ["plates", "found 1 for both"]),
        ({"plates": {"left": [1], "right": []}}, ["plates", "right belt", "found none"]),
        ({"axes": {"forward": "+y", "up": "-y"}}, ["axes", "'+y'", "'-y'"]),
    ],
)
def test_what_a_trial_of_one_file_lacks_is_said_before_the_first_job(recording, words, config, root, sheet):
    trials = read_trial_sheet(sheet("dummy a recorded - - - 70 a.c3d - - -"), ".")
    config = configured(config, root, **recording)
    with pytest.raises(InputError) as caught:
        check_recordings(settings_of(config), trials, "my-study")
    assert_one_sentence(caught.value, "my-study: expected plate_treadmill.recording", *words)


def test_trials_of_several_files_need_no_recording(config, root, sheet):
    trials = read_trial_sheet(sheet("dummy a recorded - - - 70 a.mat - plate.csv a.c3d"), ".")
    config = configured(config, root, plates={"left": [1], "right": [1]})
    check_recordings(settings_of(config), trials, "my-study")
    assert Study(config, trials).for_ingest("dummy", "a")["recording"] is None


def test_an_experiment_may_have_other_channels(config, root, sheet):
    trials = read_trial_sheet(
        sheet("dummy a recorded - - - 70 a.c3d - - -", "standing a recorded - - - 65 s.c3d - - - - - calm"),
        ".",
    )
    other = VELOCITY | {"channel": "Speed 2"}
    config["plate_treadmill"]["exceptions"] = {
        "standing": {"recording": {"belt_velocity": other}},
        "empty": {"recording": {"force_sign": -1}},
    }
    config = configured(config, root, belt_velocity=VELOCITY)
    study = Study(config, trials)
    check_recordings(study.settings, trials, "my-study")
    check_one_treadmill(config, ["dummy", "standing", "weight", "empty"], "my-study")
    of_dummy, of_standing = (study.for_ingest(e, "a")["recording"] for e in ("dummy", "standing"))
    assert of_dummy["belt_velocity"] == VELOCITY
    assert of_standing["belt_velocity"] == other
    assert of_standing["plates"] == of_dummy["plates"]
    assert study.settings["empty"]["recording"]["force_sign"] == -1


@pytest.mark.parametrize(
    ("recording", "words"),
    [
        ({"axes": {"forward": "y", "up": "+z"}}, ["'+x'", "axes.forward"]),
        ({"plates": {"left": [0], "right": []}}, ["at least 1", "plates.left.0"]),
        ({"load_cells": {"left": [], "right": [{"channel": "a"}]}}, ["newton_per_unit", "found none"]),
        ({"force_sign": 0}, ["force_sign"]),
        ({"speed": "a"}, ["unknown key", "'plate_treadmill.recording.speed'"]),
    ],
)
def test_keys_of_recordings(recording, words, config, root):
    with pytest.raises(InputError) as caught:
        configured(config, root, **recording)
    for word in words:
        assert word in str(caught.value)


def test_examples_of_the_documentation_are_valid(config, root):
    text = (root / "docs/recordings/c3d.md").read_text(encoding="utf-8")
    examples = re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)
    assert len(examples) >= 4
    for example in examples:
        both = merged(config, yaml.safe_load(example))
        check_config(both, "c3d.md")
        options_of(RecordingOptions, settings_of(both)["standing"]["recording"])


def merged(base, changes):
    """A copy of nested mappings, overridden as Snakemake does it: key by key."""
    both = dict(base)
    for key, value in changes.items():
        inner = isinstance(value, dict) and isinstance(base.get(key), dict)
        both[key] = merged(base[key], value) if inner else value
    return both


# ---- through Snakemake -----------------------------------------------------------------------------


@pytest.mark.study
def test_a_study_of_c3d_files_gives_the_estimates_of_the_same_trials(own_study):
    raw, folder = own_study / "results/raw", own_study / "one"
    folder.mkdir()
    muscles = [f"EMG {name}" for name in ("TA", "SOL", "GAS", "BF", "RF")]
    dummy, person = raw / "dummy/sine-0.5", raw / "standing/relax-neg-0.5"

    def files(trial, *names):
        return {name.partition(".")[0]: trial / name for name in ("log.mat", "calibration.csv", *names)}

    single_c3d(files(dummy, "markers.c3d"), folder / "dummy.c3d")
    single_c3d(files(person, "markers.c3d", "emg.edf"), folder / "person.c3d", muscles, analog_rate_hz=2000.0)
    single_c3d(files(raw / "empty/sine-0.4"), folder / "empty.c3d", duration_s=28.0)
    write_sheet(
        own_study,
        [
            "dummy sine-0.5 recorded - - - 46 one/dummy.c3d - - -",
            "standing a recorded - - - 41 one/person.c3d - - - - - calm",
            "empty a recorded - - - 28 one/empty.c3d - - - calibrate",
            "weight a recorded - - - 28 one/absent.c3d - - - validate",
            "weight b recorded - - - 28 one/another.c3d - - - calibrate",
        ],
        "c3d",
    )
    content = {
        "study": {"trial_sheet": "config/c3d.tsv", "virtual_lab": None, "reported": None},
        "pathvars": {"results": "results/c3d", "logs": "results/c3d/logs"},
        "plate_treadmill": {"recording": single_c3d_settings()},
        "dummy": OVERRIDES["dummy"],
    }
    write_config(own_study, content, "c3d")
    wanted = [
        "estimates/dummy/sine-0.5.csv",
        "trials/standing/a.h5",
        "trials/empty/a.h5",
        "trials/weight/a.h5",
    ]
    run = snakemake(own_study, *(f"results/c3d/{name}" for name in wanted), "--keep-going", config="c3d")
    assert "one/absent.c3d: expected a C3D file, found no file" in run.stderr
    assert run.stderr.split("What stopped:")[1].count("tepsipe: ") == 1
    several, one = (read(own_study / results / wanted[0]) for results in ("results", "results/c3d"))
    assert several.keys() == one.keys()
    for key in [key for key in several if key[-1] in ("B", "K")]:
        # other instants of the frames change B by K times a delay, here of 0.1 ms
        late = 1e-4 * several[(*key[:-1], "K")] if key[-1] == "B" else 0.0
        assert one[key] == pytest.approx(several[key], rel=0.01, abs=late), key
    with h5py.File(own_study / "results/c3d/trials/standing/a.h5") as trial:
        assert trial["emg"].shape[1] == 5
        assert "person.c3d" in trial.attrs["sources"]
        assert '"belt_velocity"' in trial.attrs["options"]
    with h5py.File(own_study / "results/c3d/trials/empty/a.h5") as trial:
        assert "marker_position" not in trial
        assert trial["force"].shape[1:] == (2, 3)


def read(path):
    """Values of a file of estimates by pathway, estimator and quantity."""
    header, *lines = [line.split(",") for line in path.read_text().splitlines()]
    rows = [dict(zip(header, line, strict=True)) for line in lines]
    return {(row["pathway"], row["estimator"], row["quantity"]): float(row["value"]) for row in rows}
