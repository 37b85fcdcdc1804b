"""Fixtures that several test files share: the shipped configuration, a small laboratory, real data."""

import copy
import gc
import json
import os
import shutil
import sys
from pathlib import Path

# one thread for every process, and for those that it starts: the number is fixed when numpy is imported
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ[f"{library}_NUM_THREADS"] = "1"
# bytecode is kept where an environment keeps Python from writing it, too: without it, every process rewrites
# the assertions of all files before the first test
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

import numpy as np
import pytest
import refusals
import yaml
from builders import DUMMY_DURATION_S, LEG, WRISTALYZER_DURATION_S
from sharing import made_once

from tepsipe.virtual_lab.dummy_trial import make_dummy_trial
from tepsipe.virtual_lab.treadmill_trial import Protocol
from tepsipe.virtual_lab.wristalyzer_trial import make_wristalyzer_trial

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))  # for `workflow`, which is not installed
# what test_recipes.py adds to a copy of the project
collect_ignore = ["recipes"]


def pytest_configure(config):
    """Record which refusals of the library the tests of this process read."""
    refusals.begin(config)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session):
    """Fail a run of all tests in which no test read some refusal of the library."""
    if not hasattr(session.config, "workerinput"):
        refusals.end(session)


def pytest_terminal_summary(terminalreporter, config):
    """Name the refusals that no test read."""
    for line in config.stash.get(refusals.FAULTS, ()):
        terminalreporter.line(f"FAILED {line}")


def pytest_collection_modifyitems(config, items):
    """Where several processes share the tests, the files that take longest start first.

    The file that makes the shared study comes before all. Studies without it follow, so that no process
    waits until it is made.
    """
    if not hasattr(config, "workerinput"):
        return

    def files_of(marker):
        return [item.path for item in items if item.get_closest_marker(marker)]

    studies, slow = files_of("study"), set(files_of("slow"))
    shared = [item.path for item in items if "study" in item.fixturenames]
    turns = dict.fromkeys(slow, 3) | dict.fromkeys(studies, 1) | dict.fromkeys(shared, 2)
    turns |= dict.fromkeys(shared[:1], 0)
    items.sort(key=lambda item: turns.get(item.path, 4))


def pytest_collection_finish():
    """Leave what was imported and collected out of garbage collections, and let them be rarer.

    Both take a tenth of the time of tests that read code or settings; arrays are freed without them.
    """
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)


@pytest.fixture
def rng():
    return np.random.default_rng(20140612)


@pytest.fixture
def leg():
    return LEG


@pytest.fixture(scope="session")
def root():
    return ROOT


@pytest.fixture(scope="session")
def shipped_config():
    return yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))


@pytest.fixture
def config(shipped_config):
    return copy.deepcopy(shipped_config)


@pytest.fixture(scope="session")
def shipped_truth():
    return yaml.safe_load((ROOT / "config" / "virtual_lab.yaml").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def short_truth(shipped_truth):
    """The shipped laboratory with less rest, so that a short trial holds perturbations.

    It has a rigid foot and rod, and a plate whose friction has neither memory nor lever and whose frame has
    one mode: from short trials, estimates of known accuracy.
    """
    truth = copy.deepcopy(shipped_truth)
    truth["treadmill"]["protocol"] |= {"rest_before_s": 2.0, "rest_after_s": 3.0}
    truth["treadmill"]["plate"] |= {"bristle_share": 0.0, "friction_lever_m": 0.0, "second_share": [0.0, 0.0]}
    truth["dummy"]["foot_tilt"]["compliance_rad_per_Nm"] = truth["dummy"]["wobble"]["growing_per_m"] = 0.0
    return truth


@pytest.fixture(scope="session")
def wristalyzer_files(short_truth, tmp_path_factory):
    folder = tmp_path_factory.mktemp("wristalyzer")
    files = {"log": folder / "log.txt", "command": folder / "command.txt"}
    make_wristalyzer_trial(short_truth, "0.16", 0.16, WRISTALYZER_DURATION_S, files)
    return files


@pytest.fixture(scope="session")
def dummy_files(short_truth, tmp_path_factory):
    folder = tmp_path_factory.mktemp("dummy")
    files = {
        "log": folder / "log.mat",
        "calibration": folder / "calibration.csv",
        "markers": folder / "markers.c3d",
    }
    motion = folder / "motion.h5"
    make_dummy_trial(
        short_truth, "sine-0.5", Protocol("sine", 0.5, 2.0, DUMMY_DURATION_S), files | {"motion": motion}
    )
    return files


@pytest.fixture(scope="session")
def true_joint(dummy_files, shipped_config):
    """I, B, K of the linear joint that is nearest to the true one in the perturbations of `dummy_files`."""
    from tepsipe import find_perturbations
    from tepsipe.ingest.plate_treadmill import ingest_treadmill_files
    from tepsipe.ingest.treadmill_options import TreadmillOptions
    from tepsipe.reporting.recovery import linear_truth, read_true_motion

    dummy, rate = shipped_config["dummy"], shipped_config["plate_treadmill"]["resample_rate_hz"]
    options = TreadmillOptions(**dummy["ingest"], resample_rate_hz=rate)
    trial = ingest_treadmill_files(dummy_files, dummy["files"]["marker_labels"], options, DUMMY_DURATION_S)
    found = find_perturbations(trial.time, trial.signals["belt_velocity"])
    windows = [(trial.time[p.start], trial.time[p.stop - 1]) for p in found]
    return linear_truth(read_true_motion(dummy_files["log"].with_name("motion.h5")), windows)


@pytest.fixture
def checked_study_of(root, monkeypatch):
    """Check a shipped study, defaults and its own file, with other values of some keys."""
    from workflow.support.checked_study import checked_study, merged_settings

    monkeypatch.chdir(root)

    def check_of(name):
        files = ["config/config.yaml", f"config/{name}/config.yaml"]
        settings = merged_settings(files)

        def check(changes=()):
            config = copy.deepcopy(settings)
            for path, value in dict(changes).items():
                *sections, last = path.split("/")
                place = config
                for section in sections:
                    place = place[section]
                place[last] = value
            return checked_study(config, files)

        return check

    return check_of


@pytest.fixture(scope="session")
def study(tmp_path_factory):
    """A tiny study that has run, made once for all processes of these tests: read it and change nothing."""
    from study_builders import copy_project, digests, users_snakemake

    def make(folder):
        project = copy_project(folder / "project")
        run = users_snakemake(project)
        assert run.returncode == 0, run.stdout + run.stderr
        assert run.stdout.splitlines()[-1] == str(project / "results/report/index.html")
        (folder / "digests.json").write_text(json.dumps(digests(project / "results")))

    return made_once(tmp_path_factory, "study", make) / "project"


@pytest.fixture(scope="session")
def belt_study(tmp_path_factory):
    """A study of text files that has run, of a belt and of a person on a platform: as for `study`."""
    from belt_builders import belt_table
    from study_builders import copy_project, platform_table, treadmill_study

    def make(folder):
        project = copy_project(folder / "project")
        recordings = project / "of the belt"
        recordings.mkdir()
        for seed, name in enumerate(("first run.txt", "second.txt")):
            belt_table(recordings / name, seed)
        platform_table(recordings / "person.csv")
        belts = {"a": ("calibrate", "first run.txt"), "b": ("validate", "second.txt")}
        person = "\t".join(["platform", "quiet", "recorded", *"---", "119", "person.csv", *"---------"])
        run = treadmill_study(project, "belt", belts, [person], recordings.name)
        assert run.returncode == 0, run.stdout + run.stderr

    return made_once(tmp_path_factory, "belt-study", make) / "project"


@pytest.fixture(scope="module")
def own_study(study, tmp_path_factory):
    """A copy of the tiny study with its results, for the tests of one file to change."""
    return Path(shutil.copytree(study, tmp_path_factory.mktemp("own") / "project", symlinks=True))


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """The tiny study before its first run, for the tests of one file to change."""
    from study_builders import copy_project

    return copy_project(tmp_path_factory.mktemp("own") / "project")


@pytest.fixture(scope="session")
def real_data():
    """Path of a recording made by others; skips, saying what is missing, where it is absent."""
    folder = Path(os.environ.get("TEPSIPE_REAL_DATA", ROOT.parent / "shared" / "real-data"))

    def recording(name):
        path = folder / name
        if not path.is_file():
            pytest.skip(
                f"no real recording at {path}: put {name} there, or say with TEPSIPE_REAL_DATA "
                "which folder holds it"
            )
        return path

    return recording
