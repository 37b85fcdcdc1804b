"""Bad inputs of the table end in their one sentence; good trials are not refused.

All of them go through real runs in `benchmarks/soak/bad_inputs.py`.
"""

import copy
import shutil
from collections.abc import Mapping
from functools import partial

import pytest
import yaml
from bad_input_table import FILES, SETTINGS, SHEETS
from bad_inputs import OTHER, RAW, ingest, make_good, sheet_rows
from study_builders import write_sheet

from tepsipe.errors import InputError
from tepsipe.mechanics.engines import resolved_engine
from workflow.support.checked_study import checked_sections, checked_study, merged_settings, with_its_file
from workflow.support.recordings import refused_recordings
from workflow.support.study import Study
from workflow.support.trial_sheet import read_trial_sheet
from workflow.support.yaml_file import override, read_settings

LONGEST = 700


def assert_refused(refusing, words, *left_out):
    """One sentence, short and without a path that only this computer has, that holds the expected words."""
    with pytest.raises(InputError) as caught:
        refusing()
    said = str(caught.value)
    for place in left_out:
        said = said.replace(f"{place}/", "")
    assert words in said
    assert "\n" not in said
    assert "Traceback" not in said
    assert len(said) < LONGEST


def test_every_bad_input_has_a_name_of_its_own():
    entries = [*FILES, *SETTINGS, *SHEETS]
    names = [entry.name for entry in entries]
    assert len(names) >= 400
    assert len(set(names)) == len(names)
    assert {entry.group for entry in FILES} == {
        *("log", "calibration", "markers", "physics", "weight", "empty", "standing", "EMG"),
        *("whole trial", "manipulator log", "command", "text tables"),
    }


@pytest.fixture(scope="module")
def good(tmp_path_factory, shipped_truth):
    folder = tmp_path_factory.mktemp("good")
    make_good(folder, shipped_truth)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("experiment", RAW)
def test_good_trials_are_ingested(experiment, good, shipped_config):
    for name in ("good", OTHER):
        assert ingest(experiment, good / experiment / name, shipped_config).time.size > 1000
    if experiment == "dummy":
        assert ingest(experiment, good / "dummy/good", shipped_config, True).time.size > 1000


class Reads(Mapping):
    """Settings that remember which of them were read, as paths."""

    def __init__(self, content, read, path=""):
        self.content, self.read, self.path = content, read, path

    def __getitem__(self, key):
        value, path = self.content[key], f"{self.path}{key}"
        if isinstance(value, dict):
            return Reads(value, self.read, f"{path}.")
        self.read.add(path)
        return value

    def __iter__(self):
        return iter(self.content)

    def __len__(self):
        return len(self.content)


def leaves(content, path=""):
    for key, value in content.items():
        yield from leaves(value, f"{path}{key}.") if isinstance(value, dict) else [f"{path}{key}"]


@pytest.mark.slow
@pytest.mark.parametrize(("experiment", "whole"), [*((name, False) for name in RAW), ("dummy", True)])
def test_ingest_reads_exactly_the_settings_that_its_experiment_declares(
    experiment, whole, good, shipped_config, monkeypatch
):
    """Others it does not have; it would stop at a missing one."""
    given, read, for_ingest = {}, set(), Study.for_ingest

    def recorded(*row):
        given.update(for_ingest(*row))
        return Reads(given, read)

    monkeypatch.setattr(Study, "for_ingest", recorded)
    ingest(experiment, good / experiment / "good", shipped_config, whole)
    assert read == set(leaves(given))


@pytest.mark.slow
@pytest.mark.parametrize("entry", FILES, ids=lambda entry: entry.name)
def test_a_spoiled_file_is_refused(entry, good, shipped_config):
    folder = good / entry.experiment / "spoiled"
    shutil.copytree(good / entry.experiment / "good", folder)
    try:
        entry.spoil(folder)
        refusing = partial(ingest, entry.experiment, folder, shipped_config, entry.whole)
        assert_refused(refusing, entry.words, folder)
    finally:
        shutil.rmtree(folder)


@pytest.mark.slow
def test_check_reads_every_recording(good, shipped_config, tmp_path):
    for experiment in ("dummy", "standing"):
        shutil.copytree(good / experiment, tmp_path / experiment)
    (tmp_path / "config").mkdir()
    write_sheet(
        tmp_path, sheet_rows(tmp_path, {key: ["good", OTHER] for key in ("dummy", "standing")}), "two"
    )
    settings = copy.deepcopy(shipped_config)
    for name in ("dummy", "standing"):
        analysis = settings[name]["analysis"]
        analysis.get("window", analysis).update(rest_before_s=2.0, rest_after_s=3.0)

    def refused():
        return refused_recordings(Study(settings, read_trial_sheet(tmp_path / "config/two.tsv", ".")))

    assert refused() == []
    settings["standing"]["person"]["mass_kg"] = 90.0
    shutil.copy(tmp_path / "dummy/good/log.mat", tmp_path / "dummy/other/log.mat")
    copied, foreign, *of_people = refused()
    assert copied.startswith("dummy/other: expected a recording of its own, found")
    assert "to move with the belt" in foreign  # the log is that of the other trial
    assert len(of_people) == 2
    assert all("on the right belt" in said and "kg" in said for said in of_people)
    settings["dummy"]["analysis"]["rest_before_s"] = 9.0
    assert any(said.startswith("dummy/good: ") and "rest" in said for said in refused())


def check(shipped_config, overlay):
    """All that is checked before the first job, in the folder of the project."""
    files = ["config/config.yaml", str(overlay)]
    config = copy.deepcopy(
        shipped_config
    )  # merged as Snakemake does it, without reading the first file again
    override(config, read_settings(overlay))
    try:
        study = checked_study(config, files)
        for key in ("virtual_lab", "reported"):
            checked_sections(config, key)
        if study.has("simulation"):
            resolved_engine(config["dummy"]["simulation"]["engine"])
    except InputError as error:
        raise InputError(with_its_file(error, config, files)) from error


@pytest.mark.parametrize("entry", SETTINGS, ids=lambda entry: entry.name)
def test_a_spoiled_configuration_is_refused(entry, root, shipped_config, tmp_path, monkeypatch):
    monkeypatch.chdir(root)
    overlay = tmp_path / "bad.yaml"
    overlay.write_text(entry.overlay if isinstance(entry.overlay, str) else yaml.safe_dump(entry.overlay))
    # the table calls a configuration so; a message names the file that holds the key
    head, colon, rest = entry.words.partition(": ")
    words = f"bad.yaml{colon}{rest}" if head == "configuration" else entry.words
    assert_refused(lambda: check(shipped_config, overlay), words, tmp_path)


@pytest.mark.parametrize(
    "overlay",
    [
        "study:\n  seed = 5\n",
        "standing: {analysis: {baseline_s: [0.0, 0.1]}}\n",
        "standing: {estimators: {mine: {window_s: 0.1}}}\n",
        "standing: {muscles: {TA: {channel: EMG SOL}}}\n",
        "coverage: true\n",
    ],
)
def test_a_refusal_names_the_file_that_holds_the_key(overlay, root, tmp_path, monkeypatch):
    monkeypatch.chdir(root)
    own = tmp_path / "own.yaml"
    own.write_text(overlay)
    files = ["config/config.yaml", str(own)]
    config = merged_settings(files)
    with pytest.raises(InputError) as caught:
        checked_study(config, files)
    assert with_its_file(caught.value, config, files).startswith(f"{own}: expected ")


@pytest.mark.parametrize("entry", SHEETS, ids=lambda entry: entry.name)
def test_a_spoiled_sheet_is_refused(entry, root, shipped_config, tmp_path, monkeypatch):
    monkeypatch.chdir(root)
    rows = [line.split("\t") for line in (root / "config/trials.tsv").read_text().splitlines()]
    entry.spoil(rows)
    (tmp_path / "bad.tsv").write_text("".join("\t".join(row) + "\n" for row in rows))
    overlay = tmp_path / "bad.yaml"
    overlay.write_text(yaml.safe_dump({"study": {"trial_sheet": str(tmp_path / "bad.tsv")}}))
    assert_refused(lambda: check(shipped_config, overlay), entry.words, tmp_path)
