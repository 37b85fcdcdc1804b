"""Names that new-study writes, against the rules by which the run refuses names."""

import numpy as np
import pytest

from tepsipe.errors import InputError
from tepsipe.io.names import check_distinct, check_name, special_in, usable_name
from tepsipe.new_study.study import new_study
from workflow.support.folders import check_path
from workflow.support.trial_sheet import read_trial_sheet
from workflow.support.yaml_file import read_settings

HOSTILE = (
    *("CON", "nul", "com1.x", "Aux-1", "Run", "run", "x" * 120, "x" * 121, "a.", "-a", "..a", "ä ö", "1"),
    *("a{b}", "a*", 'a"b', "~a", "$a", "a|b", "a<b>", "a?"),
)


@pytest.fixture
def recordings(tmp_path, monkeypatch, rng):
    """Recordings of a joint with names that make trouble."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "recordings"
    folder.mkdir()
    time = np.arange(0.0, 20.0, 0.005)
    for name in HOSTILE:
        angle = 0.02 * np.convolve(rng.standard_normal(time.size), np.hanning(30), mode="same")
        table = np.column_stack([time, angle, -60.0 * angle - np.gradient(angle, time)])
        header = "time_s,ankle_angle_rad,ankle_torque_Nm"
        np.savetxt(folder / f"{name}.csv", table, "%.6f", ",", header=header, comments="")
    return folder


@pytest.mark.parametrize("output", ["study", "recordings"])
def test_the_run_accepts_every_name_that_new_study_writes(recordings, output):
    made = new_study(recordings, "a-study", output)
    trials = read_trial_sheet(made.folder / "trials.tsv", recordings.name)
    assert len(trials) == sum(made.trials.values()) >= 10
    for experiment, condition in trials:
        check_name(condition, "condition", "trials.tsv")
        for path in trials[experiment, condition].files.values():
            check_path("trials.tsv", path, "a recording")
    check_distinct([condition for _, condition in trials], "condition", "trials.tsv")
    left = {found.name: found.why for found in made.left}
    for name in HOSTILE[-8:]:
        assert "in its name: rename it" in left[f"{name}.csv"]


@pytest.mark.parametrize(
    ("folder", "name", "title"),
    [
        ("recordings", None, "Recordings of ankles"),
        ("Data", None, "Recordings of ankles"),
        ("recordings", "recordings-of-may", "Recordings of recordings-of-may"),
        ("may", None, "Recordings of may"),
    ],
)
def test_a_folder_called_after_its_content_is_titled_by_the_one_around_it(folder, name, title, recordings):
    around = recordings.with_name("ankles")
    around.mkdir()
    made = new_study(recordings.rename(around / folder), name, "study")
    assert read_settings(made.folder / "config.yaml")["study"]["title"] == title


def test_a_folder_that_the_run_refuses_is_refused(recordings):
    other = recordings.rename(recordings.with_name("of {May}"))
    with pytest.raises(InputError, match="which the run refuses"):
        new_study(other, "a-study", "study")


@pytest.mark.parametrize("name", ["", "...", "con", "CON.1", "lpt9", "x" * 500, "con." + "x" * 500, "a-"])
def test_a_usable_name_is_one_also_with_a_number(name):
    for end in ("", "-2", "-9999"):
        check_name(usable_name(name) + end, "name", "here")
    assert special_in(usable_name(name)) == []
