"""Folders as laboratories have them: new-study, what MISSING.md asks for, and a check that finds nothing.

The whole run of each folder takes a minute or more; it is part of the campaign of the soak benchmarks.
"""

import pytest
import yaml
from laboratory_folders import FOLDERS

from tepsipe.new_study.study import new_study
from workflow.check import main

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


@pytest.mark.parametrize("name", FOLDERS)
def test_a_folder_becomes_a_study_that_check_accepts(name, shipped_truth, tmp_path, monkeypatch, capsys):
    (tmp_path / "lab").mkdir()
    answers, cells = FOLDERS[name](tmp_path / "lab", shipped_truth)
    made = new_study(tmp_path / "lab", name.replace("_", "-"), tmp_path / "study")
    assert not made.left and not made.others
    monkeypatch.chdir(made.folder)
    status = main(filled(made.folder, answers, cells))
    said = capsys.readouterr()
    assert status == 0, said.err
    assert "to be confirmed" not in said.out
    wanted = [line for line in said.out.splitlines() if line.startswith("to be recorded: ")]
    if name == "split_belt_at_100_hz":  # both pulses of each load go forward
        lacks = "pulses backward on the empty belt, pulses backward under the weight of 20 kg"
        for line, belt in zip(wanted[:2], ("left", "right"), strict=True):
            assert line == f"to be recorded: {belt} plate: {lacks} (docs/guideline.md)"
        assert "a minute of quiet standing" in wanted[2] and "weight of 20 kg" in wanted[3]
    elif name in ("gait_with_events", "tables_with_other_names", "two_weights"):
        assert not wanted
