"""What a user of a moving platform meets: a study from a folder, participants, refusals of bad files."""

from functools import partial

import numpy as np
import pandas as pd
import pytest
from bad_input_table import PLATFORMS
from bad_inputs import DURATION_S, ingest, paths, write_platform

from tepsipe.new_study.files import platform_columns
from tepsipe.new_study.study import new_study
from tepsipe.reporting.figures import plot_participants
from tests.reporting.test_participants import words as chapter_of
from tests.workflow.test_bad_inputs import assert_refused
from workflow.support.yaml_file import read_settings

NAMES = ["time_s", "platform_m", "ankle_angle_rad", "hip_angle_rad", "ankle_torque_Nm", "hip_torque_Nm"]


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    path = paths(tmp_path_factory.mktemp("platform"), "platform")["log"]
    write_platform(path, DURATION_S["platform"] + 0.5, 3)
    return path.read_bytes()


@pytest.mark.parametrize("entry", PLATFORMS, ids=lambda entry: entry.name)
def test_a_spoiled_table_is_refused_in_one_sentence(entry, good, tmp_path, shipped_config):
    paths(tmp_path, "platform")["log"].write_bytes(good)
    entry.spoil(tmp_path)
    assert_refused(partial(ingest, "platform", tmp_path, shipped_config), entry.words, tmp_path)


@pytest.mark.parametrize(
    ("names", "found"),
    [
        (NAMES, NAMES),
        (
            [
                "Time (s)",
                "Hip moment [Nm]",
                "Hip angle [deg]",
                "Ankle moment [Nm]",
                "Ankle angle [deg]",
                "Sway",
            ],
            [
                "Time (s)",
                "Sway",
                "Ankle angle [deg]",
                "Hip angle [deg]",
                "Ankle moment [Nm]",
                "Hip moment [Nm]",
            ],
        ),
        (NAMES[:-1], []),
        (["time_s", "ankle_pos_rad", "ankle_torque_Nm"], []),
    ],
)
def test_columns_are_known_by_joint_and_quantity(names, found):
    roles = ["time", "platform", "ankle_angle", "hip_angle", "ankle_torque", "hip_torque"]
    assert platform_columns(names) == dict(zip(roles, found, strict=False))


def test_new_study_of_two_people_with_their_own_units_and_signs(good, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    table = np.loadtxt(good.decode().splitlines(), delimiter=",", skiprows=1)[::4]
    table[:, 2:4] = np.degrees(table[:, 2:4])
    table[:, 4:] *= -1.0
    push = np.random.default_rng(1).standard_normal(table.shape[0])
    header = "\t".join(["Time (s)", "Platform (m/s)", "Ankle (deg)", "Hip (deg)", *NAMES[4:], "Push (N)"])
    (tmp_path / "lab").mkdir()
    for person in ("S01", "S02"):
        path = tmp_path / "lab" / f"{person}_sway.txt"
        np.savetxt(path, np.column_stack([table, push]), delimiter="\t", header=header, comments="")
    made = new_study("lab", output="mine")
    assert made.trials == {"platform": 2}
    assert not made.missing
    files = read_settings(tmp_path / "mine/config.yaml")["platform"]["files"]
    assert files["columns"]["ankle_angle"] == "Ankle (deg)"
    assert files["columns"]["second_perturbation"] == "Push (N)"
    told = {key: files[key] for key in ("angle_unit", "torque_sign", "platform_unit", "delimiter")}
    assert told == {"angle_unit": "deg", "torque_sign": -1, "platform_unit": "m/s", "delimiter": "tab"}
    sheet = pd.read_csv(tmp_path / "mine/trials.tsv", sep="\t", comment="#")
    assert sheet.participant.tolist() == ["S01", "S02"]
    assert sheet.experiment.tolist() == ["platform", "platform"]


def test_participants_show_the_stiffness_of_both_joints():
    choice = {"platform": ["closed-loop", "iv-intrinsic"]}
    common = {"experiment": "platform", "condition": "quiet", "pathway": "closed-loop", "unit": "Nm/rad"}
    common |= {"estimator": "iv-intrinsic", "mass_kg": np.nan}
    values = {"K_mode_ankle": (1000.0, 1100.0), "K_mode_hip": (300.0, 340.0)}
    people = pd.DataFrame(
        [
            common | {"participant": f"P{k}", "quantity": name, "value": value, "standard_error": 10.0}
            for name, pair in values.items()
            for k, value in enumerate(pair)
        ]
    )
    mean = {"n": 2, "sd": 70.0, "sem": 50.0, "ci_low": 100.0, "ci_high": 1700.0, "u_within": 10.0}
    group = pd.DataFrame(
        [common | mean | {"quantity": name, "mean": np.mean(x)} for name, x in values.items()]
    )
    words = chapter_of(people, group, shown=choice)
    assert "quiet|K of the ankle, slow|N·m/rad|2|1050|" in words
    assert "quiet|K of the hip, slow|N·m/rad|2|320|" in words
    assert "quiet|P0||1000 ± 10|300 ± 10||||" in words
    axes = plot_participants(people, group, choice).axes
    assert [axis.get_ylabel().split(" (")[0] for axis in axes] == ["$K$, slow, ankle", "$K$, slow, hip"]
