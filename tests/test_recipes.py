"""CONTRIBUTING.md is executed: its recipes add toys to a copy of the project, and a study uses them.

A recipe names the files that it writes or edits; the test fails if others are needed.
"""

import os
import re
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml
from pdf_pages import pages_of
from study_builders import estimates, plain_laboratory, snakemake, table, write_config, write_sheet

from tepsipe.io.formats import read_all_markers
from tepsipe.io.result import read_result
from tepsipe.io.trial import read_trial
from tepsipe.virtual_lab.dummy_trial import make_dummy_trial
from tepsipe.virtual_lab.treadmill_trial import Protocol
from workflow.settings.tables import README

pytestmark = [pytest.mark.slow, pytest.mark.study]
if not (Path(__file__).parents[1] / ".git").exists():
    pytest.skip("git knows which files are those of the project", allow_module_level=True)

ROOT = Path(__file__).parents[1]
# what a toy adds: files below recipes/<toy>, and lines in other files
TOYS = Path(__file__).parent / "recipes"
# toy -> heading of its recipe, and the most files that it may touch
RECIPES = {
    "estimator": ("Adding an estimator", 4),
    "reader": ("Adding a reader", 3),
    "figure": ("Adding a figure", 3),
    "setting": ("Adding a setting", 2),
    "experiment": ("Adding an experiment", 9),
}
# toy -> file -> line -> what is added below it
END = ""
LINES = {
    "estimator": {
        "tepsipe/identification/estimators.py": {
            'NEEDS_MARKERS = ("motion", "markers", "leg", "perturbations", "at_rest")\n': """

def _toy(record: Record):
    from tepsipe.identification.toy import fit_windows

    return fit_windows(record.motion, record.torque, record.perturbations, record.at_rest)


""",
            "ESTIMATORS = {\n": """\
    "toy": Estimator("ordinary least squares", NEEDS_TORQUE, _toy, true_in_windows=True),
""",
        },
        "config/config.yaml": {
            "  pathways: # from markers to parameters; add your own\n": """\
    toy:
      torque: leg
      marker_instants: aligned
      estimator: toy
"""
        },
    },
    "reader": {
        "tepsipe/io/formats.py": {
            '    "tepsipe.io.readers.trc": ("markers",),\n': """\
    "tepsipe.io.readers.toy": ("markers",),
"""
        }
    },
    "figure": {
        "tepsipe/experiments/dummy/figures.py": {
            '    yield "figure_2_9", plot_perturbations(results)\n': """\
    yield "figure_toy", plot_toy(results)
""",
            'COMMAND = {"color": COLOURS["command"], "linewidth": 0.8, "linestyle": "--", "zorder": 1}\n': '''

@in_style
def plot_toy(results: Mapping[str, Result]) -> Figure:
    """Number of fitted windows of every trial."""
    figure, axes = new_figure(1, 1, 2.0)
    axes.plot([len(result.arrays["windows"]) for result in results.values()], "o", label="windows")
    axes.set(xlabel="Trial", ylabel="Windows")
    return figure
''',
        },
        "report/captions.yaml": {"\ndummy:\n": "  figure_toy: Windows of every trial, counted by a toy.\n"},
        "report/chapters/rigs_further.typ": {'#shown("2_9")\n': '\n#shown("toy")\n'},
    },
    "setting": {
        "tepsipe/signals/perturbations.py": {
            "from typing import Annotated, Literal\n": "\nfrom annotated_types import Ge, Le\n",
            '    """Closer runs of belt motion are one perturbation."""\n': '''\
    toy_most: Annotated[int, Ge(1), Le(100)] = 100
    """Number of perturbations that are kept by a toy."""
''',
            "        options.merge_s,\n        what,\n    )": "[: options.toy_most]",
        },
        "config/config.yaml": {
            "    merge_s: 0.06 # closer runs are one perturbation, in which the belt reverses\n": """\
    toy_most: 3
""",
            "# search for perturbations and rest, as for the dummy\n      rest_before_s: 6.0\n": """\
      toy_most: 100
""",
            "# search for perturbations and rest, as for the dummy\n      rest_before_s: 4.0\n": """\
      toy_most: 100
""",
        },
    },
    "experiment": {
        "report/captions.yaml": {
            END: "toy:\n  figure_toy_stiffness: Stiffness of every spring, bent by a toy.\n"
        },
        "config/config.yaml": {
            END: """
toy:
  ingest: {resample_rate_hz: 100.0, max_gap_s: 0.05}
  analysis: {cut_s: 1.0}
"""
        },
    },
}


def git(project, *arguments):
    command = ["git", "-c", "user.name=toy", "-c", "user.email=toy", "-C", project, *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def python(project, *arguments):
    """Run a command in the copy, with the copy's code."""
    env = os.environ | {"PYTHONPATH": str(project)}
    run = subprocess.run([sys.executable, *arguments], cwd=project, capture_output=True, text=True, env=env)
    assert run.returncode == 0, run.stdout + run.stderr


def add(project, toy):
    """Follow a recipe; return the files that it touched, without those that commands write."""
    if (TOYS / toy).is_dir():
        shutil.copytree(TOYS / toy, project, dirs_exist_ok=True)
    for name, lines in LINES[toy].items():
        text = (project / name).read_text(encoding="utf-8")
        for line, added in lines.items():
            assert line == END or text.count(line) == 1, f"{name}: {line}"
            text = text.replace(line, line + added) if line else text + added
        (project / name).write_text(text, encoding="utf-8")
    git(project, "add", "-A")
    touched = git(project, "diff", "--cached", "--name-only").split()
    git(project, "commit", "-qm", toy)
    return touched


def named_files(heading):
    """Patterns of the files that the first list of a section of CONTRIBUTING.md begins with."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    section = text.partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    found = re.findall(r"^(\d)\. `([^`]+)`:", section, re.MULTILINE)
    first = [name for k, (number, name) in enumerate(found, 1) if int(number) == k]
    return [
        re.sub("<[a-z]+>", "[^/]+", re.escape(name.replace("<path>", "*")).replace(r"\*", ".+"))
        for name in first
    ]


def recorded_trial(folder):
    """Raw files of a trial of the dummy, with its markers in the toy format."""
    truth = yaml.safe_load(LABORATORY)
    files = {"log": folder / "log.mat", "calibration": folder / "cal.csv", "markers": folder / "markers.c3d"}
    folder.mkdir()
    make_dummy_trial(truth, "sine-0.4", Protocol("sine", 0.4, 4.0, DURATION_S), files)
    markers = read_all_markers(files["markers"])
    rows = (1e3 * markers.positions).reshape(len(markers.positions), -1)
    lines = [f"TOY {markers.rate_hz}", " ".join(markers.labels)]
    lines += [" ".join(f"{x:.9g}" for x in row) for row in rows]
    (folder / "markers.toy").write_text("\n".join(lines))


def recorded_spring(folder):
    """Table of the toy experiment."""
    rng, time = np.random.default_rng(1), np.arange(2001) / 100.0
    angle = 0.1 * np.sin(3.0 * time) + rng.normal(0.0, 1e-6, time.size)
    torque = STIFFNESS_NM_PER_RAD * angle + rng.normal(0.0, 0.01, time.size)
    columns = np.column_stack([time, angle, torque])
    np.savetxt(folder / "spring.csv", columns, "%.9g", ",", header="time_s,angle_rad,torque_Nm", comments="")


LABORATORY = plain_laboratory((ROOT / "config/virtual_lab.yaml").read_text())
DURATION_S, STIFFNESS_NM_PER_RAD = 30.0, 10.0
STUDY = {
    "study": {"trial_sheet": "config/tiny.tsv", "reported": None},
    "dummy": {"analysis": {"bootstrap_draws": 100}, "simulation": {"engine": "auto", "step_s": 0.002}},
}
TRIALS = [
    f"dummy sine-0.5 virtual_lab sine 0.5 4 {DURATION_S} - - - -",
    f"dummy read recorded - - - {DURATION_S} raw/log.mat - raw/cal.csv raw/markers.toy",
    "toy spring recorded - - - 20 raw/spring.csv - - -",
]


@pytest.fixture(scope="module")
def followed(tmp_path_factory):
    """A copy of the project to which every recipe was applied, and toy -> the files that this touched."""
    project = tmp_path_factory.mktemp("recipes") / "project"
    for name in git(ROOT, "ls-files", "-z", "-co", "--exclude-standard").split("\0"):
        if (ROOT / name).is_file():  # as it is now, committed or not
            (project / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, project / name)
    git(project.parent, "init", "-q", project)
    git(project, "add", "-A")
    git(project, "commit", "-qm", "copy")
    touched = {toy: add(project, toy) for toy in RECIPES}
    python(project, "-m", "workflow.settings")
    return project, touched


@pytest.fixture(scope="module")
def ran(followed):
    """The copy after a study with the toys."""
    project, _ = followed
    (project / "config/virtual_lab.yaml").write_text(LABORATORY)
    recorded_trial(project / "raw")
    recorded_spring(project / "raw")
    write_sheet(project, TRIALS)
    write_config(project, STUDY)
    run = snakemake(project)
    assert run.returncode == 0, run.stdout + run.stderr
    return project


@pytest.mark.parametrize("toy", RECIPES)
def test_recipe_names_the_files_that_it_touches_and_no_others(toy, followed):
    heading, most = RECIPES[toy]
    touched, named = followed[1][toy], named_files(heading)
    assert len(touched) <= most
    assert len(named) == len(touched), (named, touched)
    for name in touched:
        assert any(re.fullmatch(pattern, name) for pattern in named), f"{heading} does not name {name}"
    for pattern in named:
        assert any(re.fullmatch(pattern, name) for name in touched), f"{heading} need not name {pattern}"


def test_tests_of_the_recipes_pass(followed):
    """Those that the recipes ask for, and what all rules and modules promise."""
    project, touched = followed
    tests = [name for names in touched.values() for name in names if name.startswith("tests/")]
    assert len(tests) == 3
    tests += ["tests/test_contracts.py", "tests/test_walls.py"]
    python(project, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", "toy or circle or part", *tests)


def test_toy_estimator_covers_the_truth(ran):
    rows = [row for row in estimates(ran) if row["estimator"] == "toy" and row["condition"] == "sine-0.5"]
    assert {row["quantity"] for row in rows} >= {"I", "B", "K"}
    covered = {
        row["quantity"]: row["covered"]
        for row in table(ran, "recovery")
        if row["estimator"] == "toy" and row["condition"] == "sine-0.5"
    }
    assert covered == dict.fromkeys(("I", "B", "K"), "true")


def test_toy_reader_brings_a_trial_in(ran):
    trial = read_trial(ran / "results/trials/dummy/read.h5")
    assert "markers.toy" in trial.attributes["sources"]
    assert any(row["condition"] == "read" for row in estimates(ran))


def test_toy_figure_is_in_the_report(ran):
    for ending in ("svg", "csv"):
        assert (ran / f"results/figures/figure_toy.{ending}").stat().st_size
    assert "counted by a toy" in words(ran)


def test_toy_setting_is_documented_limited_and_used(ran):
    text = (ran / README.relative_to(ROOT)).read_text(encoding="utf-8")
    assert "| `analysis.toy_most` | | whole number, 1 to 100 | 3 | number of perturbations" in text
    assert len(read_result(ran / "results/fits/dummy/sine-0.5.h5").arrays["windows"]) == 3
    write_config(ran, STUDY | {"dummy": {"analysis": {"toy_most": 0}}}, "refused")
    run = snakemake(ran, "-n", config="refused")
    assert run.returncode and "dummy.analysis.toy_most" in run.stdout + run.stderr


def test_toy_experiment_has_estimates_figure_page_and_chapter(ran):
    (row,) = [row for row in estimates(ran) if row["experiment"] == "toy"]
    assert float(row["ci_low"]) < STIFFNESS_NM_PER_RAD < float(row["ci_high"])
    for ending in ("svg", "csv"):
        assert (ran / f"results/figures/figure_toy_stiffness.{ending}").stat().st_size
    assert "A toy, spring" in (ran / "results/report/trials/toy/spring.html").read_text(encoding="utf-8")
    assert "A spring for a toy" in words(ran) and "bent by a toy" in words(ran)
    report = (ran / "results/report/index.html").read_text(encoding="utf-8")
    assert "plot_toy (workflow/rules/experiments.smk:" in report
    text = (ran / README.relative_to(ROOT)).read_text(encoding="utf-8")
    assert "### toy\n\nA spring that is bent.\n" in text and "| `analysis.cut_s` | s |" in text


@cache
def words(project):
    """Text of the report."""
    pages = pages_of(project / "results/report/thesis.pdf")
    return " ".join(" ".join(page.extract_text() for page in pages).split())
