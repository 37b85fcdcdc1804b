"""Folders as laboratories have them: new-study, what MISSING.md asks for, and a check that finds nothing.

The whole run of each folder takes a minute or more; it is part of the campaign of the soak benchmarks. The
tutorial treadmill_person takes a folder like the first one all the way (test_tutorials.py).
"""

import re

import numpy as np
import pytest
import yaml
from laboratory_folders import FOLDERS

from tepsipe.io.estimates import FLAGS, Estimate
from tepsipe.new_study.study import new_study
from workflow.check import main
from workflow.support.verdict import sentence

pytestmark = [pytest.mark.study, pytest.mark.slow]


def filled(folder, answers, cells):
    """Write what MISSING.md asks for: settings into a file beside the configuration, cells into the sheet."""
    (folder / "measured.yaml").write_text(yaml.safe_dump(answers))
    sheet = folder / "trials.tsv"
    header, *lines = [line.split("\t") for line in sheet.read_text().splitlines()]
    for line in lines:
        for column, values in cells.items():
            if len(line) == len(header) and line[header.index(column)] == "MISSING":
                line[header.index(column)] = values[line[1]]
    sheet.write_text("".join("\t".join(line) + "\n" for line in [header, *lines]))
    return ["config.yaml", "measured.yaml"]


@pytest.mark.parametrize("name", [name for name in FOLDERS if name != "c3d_with_plates_and_emg"])
def test_a_folder_becomes_a_study_that_check_accepts(name, shipped_truth, tmp_path, monkeypatch, capsys):
    (tmp_path / "lab").mkdir()
    answers, cells = FOLDERS[name](tmp_path / "lab", shipped_truth)
    made = new_study(tmp_path / "lab", name.replace("_", "-"), tmp_path / "study")
    assert not made.left and not made.others
    monkeypatch.chdir(made.folder)
    status = main(filled(made.folder, answers, cells))
    said = capsys.readouterr()
    # without a weight no K is quotable
    assert status == (name == "plug_in_gait"), said.err
    assert ("tepsipe: no K will be quotable: follow the verdicts" in said.err) == bool(status)
    assert "to be confirmed" not in said.out
    verdict = [line.removeprefix("verdict: ") for line in said.out.splitlines() if "verdict: " in line]
    belt = "both-" if name == "split_belt_at_100_hz" else ""
    judged = {"standing": f"standing/{belt}relax", "dummy": "dummy/dummy-01"}
    assert [line.partition(":")[0] for line in verdict] == [judged[e] for e in judged if e in made.trials]
    if name == "plug_in_gait":  # no weight
        assert "standing/relax: K will not be quotable: uncompensated: no weight was recorded" in verdict[0]
    elif verdict:
        assert re.match(r"\S+: K will be quotable, ± [\d.]+ % expected", verdict[0])
    wanted = [line for line in said.out.splitlines() if line.startswith("to be recorded: ")]
    if name == "split_belt_at_100_hz":  # both pulses of each load go forward
        lacks = "pulses backward on the empty belt, pulses backward under the weight of 20 kg"
        for line, belt in zip(wanted[:2], ("left", "right"), strict=True):
            assert line == f"to be recorded: {belt} plate: {lacks} (docs/guideline.md)"
        assert "a minute of quiet standing" in wanted[2] and "weight of 20 kg" in wanted[3]
    elif name in ("gait_with_events", "tables_with_other_names", "two_weights"):
        assert not wanted


def test_check_returns_1_for_a_recording_with_a_fault(shipped_truth, tmp_path, monkeypatch, capsys):
    (tmp_path / "lab").mkdir()
    FOLDERS["tables_with_other_names"](tmp_path / "lab", shipped_truth)
    path = tmp_path / "lab/trial_2.csv"
    header = path.read_text().splitlines()[0]
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    table[[900, 2700], 2] += np.ptp(table[:, 2])
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.7g")
    made = new_study(tmp_path / "lab", "joints", tmp_path / "study")
    monkeypatch.chdir(made.folder)
    assert main(["config.yaml"]) == 1
    said = capsys.readouterr()
    asked = [line for line in said.out.splitlines() if line.startswith("to be confirmed: ")]
    assert len(asked) == 1 and "position_manipulator/2: " in asked[0] and "(spikes)" in asked[0]
    assert said.err == "tepsipe: recordings have faults: see the lines to be confirmed\n"


def stiffness(recommended=True, flags="", interval=(80.0, 120.0)):
    names = "standing", "relax", "ankle-compensated", "free-reflex-gls", "K", "Nm/rad"
    return Estimate(*names, 100.0, None, *interval, recommended=recommended, flags=flags)


def test_verdict_states_the_half_width_or_the_reason():
    assert sentence(stiffness(), []) == "K will be quotable, ± 20 % expected"
    assert sentence(stiffness(interval=(None, None)), []) == "K will be quotable, no interval"
    flagged = sentence(stiffness(flags="frame-resonance;skin-motion"), [])
    assert flagged.startswith("K will be quotable, ± 20 % expected; frame-resonance: the frame of the")
    assert "; skin-motion: soft tissue" in flagged
    refused = sentence(stiffness(False, "negative"), ["a: left out as a whole: a step"])
    assert refused == f"K will not be quotable: negative: {FLAGS['negative']}"
    left_out = [
        "a: muscle TA left out",
        "a: left out as a whole: a step",
        "b: left out as a whole: a stumble",
    ]
    assert sentence(None, left_out) == f"K will not be quotable: {'; '.join(left_out[1:])}"
    assert sentence(None, left_out[:1]) == "K will not be quotable: a: muscle TA left out"
    assert sentence(None, []) == "K will not be quotable: no response to a perturbation was usable"
