"""Folders and names that a study may not write to: refused before the first job."""

import copy
from pathlib import Path

import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.io.names import check_distinct, check_name
from workflow.settings.config import check_config
from workflow.support.folders import check_checkout, check_folders, check_paths, names_in_results


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A project with a study of the user in it, as the current folder."""
    for folder in (
        "project/config",
        "project/my-study/raw",
        "project/tepsipe",
        "project/workflow",
        "elsewhere",
    ):
        (tmp_path / folder).mkdir(parents=True)
    for file in (
        "Snakefile",
        "config/config.yaml",
        "my-study/config.yaml",
        "my-study/trials.tsv",
        "my-study/raw/a.mat",
    ):
        (tmp_path / "project" / file).write_text("")
    for folder, file in (("rules", "a.smk"), ("support", "outputs.py")):
        (tmp_path / "project/workflow" / folder).mkdir()
        (tmp_path / "project/workflow" / folder / file).write_text('"<results>/trials/a.h5"')
    monkeypatch.chdir(tmp_path / "project")
    return tmp_path / "project"


@pytest.fixture
def check(place, config, root):
    """Check the folders of a study whose files lie in my-study; the text of the refusal, or None."""

    def of(results, logs="results/logs", **study):
        own = copy.deepcopy(config)
        own["study"] |= {"trial_sheet": "my-study/trials.tsv", "virtual_lab": None, "reported": None} | study
        own["pathvars"] = {"results": results, "logs": logs}
        configfiles = ["config/config.yaml", "my-study/config.yaml"]
        try:
            check_paths(own, "configuration")
            check_folders(own, configfiles, ["my-study/raw/a.mat"], place, "configuration")
        except InputError as error:
            assert_one_sentence(error, "configuration")
            return str(error)
        return None

    return of


@pytest.mark.parametrize(
    ("results", "words"),
    [
        (
            "my-study",
            "which holds the configuration my-study/config.yaml: name another, for example my-study/res",
        ),
        ("./results/../my-study/", "holds the configuration"),
        (".", "holds the configuration"),
        ("config", "holds the configuration config/config.yaml"),
        ("my-study/raw", "holds the recording my-study/raw/a.mat"),
        ("..", "expected pathvars.results in the folder that the study runs in"),
        ("../elsewhere", "set study.outside to true"),
        ("link", "set study.outside to true"),
        ("inside", "holds the configuration"),
        ("linked", "holds the recording"),
        ("tepsipe/results", "lies in tepsipe/ of the source code"),
        ("my-study/trials.tsv", "which is a file"),
        ("{B}", "without '{' '}'"),
        ("-rf", "does not begin with a hyphen"),
        ("", "is not empty"),
        ("~/results", "write the home directory out"),
    ],
)
def test_results_that_would_meet_what_the_study_reads_are_refused(place, check, results, words):
    (place / "link").symlink_to(place.parent / "elsewhere")
    (place / "inside").symlink_to(place / "my-study")
    (place / "linked").mkdir()
    (place / "linked/raw").symlink_to(place / "my-study/raw")
    assert words in check(results)


@pytest.mark.parametrize(
    ("logs", "words"),
    [
        ("results", "expected pathvars.logs beside or in pathvars.results, in a folder of its own"),
        ("results/../results", "for example results/logs"),
        ("results/trials", "lies among the results in trials"),
        ("my-study", "expected pathvars.logs to be a folder of its own"),
        ("/nowhere/logs", "expected pathvars.logs in the folder that the study runs in"),
    ],
)
def test_logs_that_would_mix_with_results_or_inputs_are_refused(check, logs, words):
    assert words in check("results", logs)


def test_results_in_logs_are_refused(check):
    assert "in a folder of its own" in check("logs/results", "logs")


@pytest.mark.parametrize("results", ["results", "results/mine", "my-study/results", "config/mine"])
def test_folders_of_their_own_are_accepted(place, check, results):
    assert check(results, f"{results}/logs") is None
    (place / results).mkdir(parents=True)
    assert check(results, f"{results}/logs") is None


def test_a_folder_elsewhere_is_accepted_where_the_study_asks_for_it(place, check):
    elsewhere = str(place.parent / "elsewhere")
    assert "study.outside" in check(elsewhere)
    assert check(elsewhere, "logs", outside=True) is None
    # but not over what the study reads
    recordings = {"recordings_folder": elsewhere, "outside": True}
    assert "holds the recordings folder" in check(elsewhere, "logs", **recordings)


@pytest.mark.parametrize("sheet", [".", "..", "-rf", "{B}.tsv", "my-study"])
def test_sheet_that_is_no_file_name_is_refused(check, sheet):
    assert "study.trial_sheet" in check("results", trial_sheet=sheet)


def test_recordings_folder_is_not_the_results(place, check):
    (place / "recorded").mkdir()
    assert "holds the recordings folder recorded" in check("recorded", recordings_folder="recorded")
    assert check("recorded/results", recordings_folder="recorded") is None


@pytest.mark.parametrize("folder", ["/home/{me}/tepsipe", "/a<b>/c"])
def test_a_checkout_in_whose_path_snakemake_sees_wildcards_is_refused(folder):
    with pytest.raises(InputError, match="without") as caught:
        check_checkout(Path(folder))
    assert_one_sentence(caught.value, folder)
    check_checkout(Path("/home/my study & co/$x 'y' ü"))


def test_rules_name_what_lies_in_the_results(root):
    assert {"config.yaml", "tables", "trials", "estimates", "raw", "report", "figures"} <= names_in_results(
        root
    )


# ---- names ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        "",
        ".",
        "..",
        "-rf",
        ".hidden",
        "a/b",
        "a b",
        "{B}",
        "sine.",
        "x" * 81,
        "con",
        "NUL.1",
        "Com1",
        "a\n",
        "a_b",
    ],
)
def test_name_that_cannot_be_a_files_is_refused(name):
    with pytest.raises(InputError) as caught:
        check_name(name, "condition", "trials.tsv: line 2")
    assert_one_sentence(caught.value, "trials.tsv: line 2")


@pytest.mark.parametrize("name", ["sine-0.3", "0.12", "RandomSlow1", "übung", "x" * 80, "console", "2-"])
def test_name_of_a_file_is_accepted(name):
    check_name(name, "condition", "trials.tsv: line 2")


@pytest.mark.parametrize("names", [("sine-0.3", "Sine-0.3"), ("Straße", "STRASSE"), ("\u00e9", "e\u0301")])
def test_names_that_are_one_file_elsewhere_are_refused(names):
    with pytest.raises(InputError) as caught:
        check_distinct(names, "condition of dummy", "trials.tsv")
    assert_one_sentence(caught.value, "trials.tsv")
    check_distinct(["a", "b", "a"], "task", "trials.tsv")


def test_text_may_have_braces_and_tags_and_a_key_may_not(config, root):
    config["study"]["title"] = "K < 10 {B} & <script>bold</script>"
    check_config(config, "configuration")
    config["dummy"]["pathways"]["{B}"] = config["dummy"]["pathways"]["leg"]
    with pytest.raises(InputError, match="expected a key without braces"):
        check_config(config, "configuration")
