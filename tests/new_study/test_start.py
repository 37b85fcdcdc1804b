"""Start of studies by the command: arguments, version, and the files that an installation contains."""

import os
import re
import runpy
import shutil
import subprocess
from pathlib import Path

import pytest

from tepsipe import __version__
from tepsipe.cli import main
from tepsipe.errors import InputError
from tepsipe.new_study import start
from tepsipe.new_study.start import (
    REQUIRED,
    arguments_of_run,
    own_files,
    refuse_other_version,
    rules_folder,
    version_of,
)
from workflow.support.imported_files import listed_in, reached_by
from workflow.support.places import place_of
from workflow.support.version import code_version

ROOT = Path(__file__).parents[2]


@pytest.fixture
def started(monkeypatch, tmp_path):
    """A study's folder, and the commands that would replace this process."""
    commands = []
    monkeypatch.chdir(tmp_path)
    for name in ("Snakefile", "config.yaml"):
        (tmp_path / name).touch()
    monkeypatch.setattr("os.execve", lambda *given: commands.append(given))
    return commands


@pytest.mark.parametrize(
    ("arguments", "handed"),
    [
        ([], ["--cores", "all"]),
        (["dummy/sine-0.3", "-n"], ["--cores", "all", "dummy/sine-0.3", "-n"]),
        (["-c2", "--forcerun", "all"], ["-c2", "--forcerun", "all"]),
        (["-nc", "2"], ["-nc", "2"]),
        (["--cores=2"], ["--cores=2"]),
        (["-j", "3"], ["-j", "3"]),
        (["--workflow-profile", "profiles/slurm"], ["--workflow-profile", "profiles/slurm"]),
        (["--configfile", "config.yaml"], ["--cores", "all", "--configfile", "config.yaml"]),
    ],
)
def test_targets_and_options_are_handed_to_snakemake_in_their_order(arguments, handed, started):
    assert arguments_of_run(arguments) == handed
    main(["run", *arguments[:1], "--any-version", *arguments[1:]])
    ((python, command, environment),) = started
    assert command == [python, "-P", "-m", "workflow.run", *handed]
    assert environment["PYTHONPATH"].split(os.pathsep)[0] == str(ROOT)


def test_a_study_without_a_snakefile_is_run_by_that_of_the_rules(started):
    Path("Snakefile").unlink()
    rules = ["--snakefile", str(ROOT / "Snakefile")]
    assert arguments_of_run(["-c2", "a/b"]) == [*rules, "-c2", "a/b", "--configfile", "config.yaml"]
    assert arguments_of_run(["-c2", "--configfile=a.yaml"]) == [*rules, "-c2", "--configfile=a.yaml"]
    assert arguments_of_run(["-c2", "-s", "my.smk"]) == ["-c2", "-s", "my.smk"]


def test_what_python_found_before_is_found_still(started, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "/mine")
    main(["run"])
    assert started[0][2]["PYTHONPATH"].split(os.pathsep) == [str(ROOT), "/mine"]


def test_a_study_of_another_version_is_refused_by_one_sentence(started, capsys):
    Path(REQUIRED).write_text("numpy\ntepsipe[study]==0.9.1 # made by it\n")
    assert main(["run", "-n"]) == 2 and not started
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "expected tepsipe 0.9.1" in said and f"found {__version__}" in said
    assert "pip install 'tepsipe[study]==0.9.1'" in said and "--any-version" in said
    main(["run", "-n", "--any-version"])
    assert len(started) == 1


@pytest.mark.parametrize(
    ("text", "version"),
    [
        (f"tepsipe[study]=={__version__}\n", __version__),
        ("tepsipe == 1.2.0rc1\n", "1.2.0rc1"),
        ("tepsipe-plugin==3\n# tepsipe==2\n", None),
        ("tepsipe[study]>=1.0\n", None),
        ("\xff", None),
    ],
)
def test_version_that_a_study_names(text, version, tmp_path):
    assert version_of(tmp_path / REQUIRED) is None
    (tmp_path / REQUIRED).write_text(text, encoding="latin-1")
    assert version_of(tmp_path / REQUIRED) == version
    if version not in (None, __version__):
        with pytest.raises(InputError, match=re.escape(version)):
            refuse_other_version(tmp_path)
    else:
        refuse_other_version(tmp_path)


def test_a_folder_without_a_study_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"expected the folder of a study, with config\.yaml, found none"):
        own_files([])
    assert own_files(["a.yaml"]) == ["a.yaml"]
    Path("config.yaml").touch()
    assert own_files([]) == ["config.yaml"]
    monkeypatch.chdir(ROOT)
    assert own_files([]) == []


# ---- an installation by pip


@pytest.fixture(scope="module")
def contained():
    """Files of the checkout that the wheel contains beside the library."""
    here = Path.cwd()
    os.chdir(ROOT)
    try:
        build = runpy.run_path("setup.py", run_name="build")  # defines without building
        return build["study_files"]()
    finally:
        os.chdir(here)


def test_a_wheel_contains_every_file_that_rules_name(contained):
    sources = [ROOT / "Snakefile", *(ROOT / "workflow").rglob("*.smk"), *(ROOT / "workflow").rglob("*.py")]
    assert {path.relative_to(ROOT).as_posix() for path in sources} <= set(contained)
    rules = "".join(path.read_text(encoding="utf-8") for path in sources)
    named = {name for name in re.findall(r'(?:here\(f?|CHECKOUT / )"([\w./-]+)"', rules) if name != "."}
    # the environment of a checkout, and campaigns that the report of the thesis quotes
    beside = {"requirements.txt", "benchmarks/plate_constants.csv"}
    assert {"CITATION.cff", "report/decisions.yaml", "config/config.yaml"} <= named
    folders = {parent.as_posix() for name in contained for parent in Path(name).parents}
    library = {name for name in named if name.split("/")[0] == "tepsipe"}
    assert named - beside - library <= {*contained, *folders}
    report = {path.relative_to(ROOT).as_posix() for path in (ROOT / "report").rglob("*") if path.is_file()}
    assert report <= set(contained)


@pytest.fixture
def installed(tmp_path):
    """Rules and library in the places that a wheel gives them, each with one module."""
    rules = tmp_path / "site-packages/tepsipe/_study"
    for path in ("workflow/scripts/fit.py", "workflow/support/parts.py", "workflow/check.py"):
        (rules / path).parent.mkdir(parents=True, exist_ok=True)
        (rules / path).touch()
    (rules / "workflow/scripts/fit.py").write_text(
        "import numpy\nfrom tepsipe.errors import InputError\nfrom workflow.support.parts import PARTS\n"
    )
    for package in ("tepsipe", "numpy"):
        (rules.parents[1] / package).mkdir(exist_ok=True)
        (rules.parents[1] / package / "__init__.py").touch()
    (rules.parent / "errors.py").touch()
    return rules


def test_an_edit_of_the_installed_library_is_seen_and_no_other_package_is(installed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = reached_by("workflow/scripts/fit.py", str(installed))
    assert found == ["tepsipe/__init__.py", "tepsipe/errors.py", "workflow/support/parts.py"]
    assert [Path(place_of(path, installed)).is_file() for path in found] == [True] * 3
    listed = Path(listed_in("fit", found, str(installed))).read_text(encoding="utf-8")
    assert [line.split()[1] for line in listed.splitlines()] == found


def test_the_rules_are_found_beside_the_library_or_below_it(installed, monkeypatch):
    assert rules_folder() == ROOT
    monkeypatch.setattr(start, "__file__", str(installed.parent / "new_study/start.py"))
    assert rules_folder() == installed
    shutil.rmtree(installed)
    with pytest.raises(InputError, match="expected the rules of studies beside the library, found none"):
        rules_folder()


def test_an_installation_in_a_repository_of_the_user_has_no_commit_of_it(installed, tmp_path):
    subprocess.run(["git", "init", "--quiet", tmp_path], check=True)
    assert code_version(installed) == {"commit": None, "date": None, "modified": None}
