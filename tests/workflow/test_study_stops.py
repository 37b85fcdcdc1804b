"""What stops a tiny study: unusable recordings, mistakes in the configuration."""

import shutil

import numpy as np
import pytest
from scipy.io import loadmat, savemat
from study_builders import snakemake, write_config, write_sheet

pytestmark = pytest.mark.study


def test_bad_recordings_stop_their_own_jobs_with_one_sentence_each(project, study):
    raw = study / "results/raw/dummy/sine-0.5"
    bad = project / "bad"
    bad.mkdir()
    (bad / "truncated.mat").write_bytes((raw / "log.mat").read_bytes()[:300_000])
    shutil.copy(raw / "log.mat", bad / "other.mat")
    (bad / "truncated.c3d").write_bytes((raw / "markers.c3d").read_bytes()[:300_000])
    content = {k: v for k, v in loadmat(raw / "log.mat").items() if not k.startswith("__")}
    content["belt_velocity_m_per_s"] = 0.001 * np.random.default_rng(1).standard_normal(
        content["belt_velocity_m_per_s"].shape
    )
    savemat(bad / "still.mat", content)
    good = {"log": raw / "log.mat", "calibration": raw / "calibration.csv", "markers": raw / "markers.c3d"}
    cases = {
        "good": {},
        "missing": {"log": "nowhere.mat"},
        "truncated-log": {"log": bad / "truncated.mat"},
        "truncated-markers": {"log": bad / "other.mat", "markers": bad / "truncated.c3d"},
        "still": {"log": bad / "still.mat"},
    }
    rows = []
    for condition, wrong in cases.items():
        files = good | wrong
        rows.append(
            f"dummy {condition} recorded - - - 46 {files['log']} - {files['calibration']} {files['markers']}"
        )
    write_sheet(project, rows, "bad")
    write_config(
        project,
        {
            "study": {"trial_sheet": "config/bad.tsv", "virtual_lab": None, "reported": None},
            "pathvars": {"results": "results/bad", "logs": "results/bad/logs"},
        },
        "bad",
    )
    run = snakemake(project, config="bad")
    assert run.returncode != 0
    assert (project / "results/bad/estimates/dummy/good.csv").exists()
    said = run.stdout + run.stderr
    assert "Traceback" not in said
    for condition, words in {
        "missing": "nowhere.mat: expected a treadmill log, found no file",
        "truncated-log": "truncated.mat: expected a MATLAB file",
        "truncated-markers": "truncated.c3d: expected 11500 frames",
        "still": "expected the belt-fixed marker 'foot1' to move with the belt",
    }.items():
        assert not (project / f"results/bad/estimates/dummy/{condition}.csv").exists()
        (log,) = [
            text
            for rule in ("ingest_dummy", "fit_dummy")
            for path in [project / f"results/bad/logs/{rule}/{condition}.log"]
            if path.exists() and (text := path.read_text())
        ]
        assert log.startswith("tepsipe: ")
        assert log.count("\n") == 1
        assert words in log
        assert words in said


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ({"plate_treadmill": {"lowpas_cutoff_hz": 20.0}}, "did you mean 'lowpass_cutoff_hz'?"),
        (
            {"plate_treadmill": {"exceptions": {"standing": {"belt": "left"}}}},
            "found left in plate_treadmill.exceptions.standing",
        ),
        (
            {"dummy": {"simulation": {"engine": "bullet"}}},
            "expected one of 'pybullet', 'mujoco'",
        ),
    ],
)
def test_a_mistake_in_the_configuration_stops_the_run_before_anything_is_computed(project, section, words):
    """One for each function that the Snakefile calls; bad_input_table.py has the mistakes."""
    write_config(project, section, "mistaken")
    run = snakemake(project, config="mistaken")
    said = run.stdout + run.stderr
    assert run.returncode != 0
    assert words in said
    assert "Traceback" not in said
    assert "Job stats" not in said


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("study:\n  seed: 1\n  seed: 2\n", "config/text.yaml: expected YAML, found a mistake on line 3"),
        (
            "__use_yte__: true\nstudy:\n  seed: ?6 * 7\n",
            "write the values out; the code has run by now, tepsipe check looks first",
        ),
        (
            "study: {title: '{B}'}\npathvars: {results: 'results/{B}'}\n",
            "without '{' '}' for 'pathvars.results'",
        ),
    ],
)
def test_a_configuration_that_snakemake_has_loaded_is_read_strictly_all_the_same(project, text, words):
    (project / "config/text.yaml").write_text(text)
    run = snakemake(project, "-n", config="text")
    said = run.stdout + run.stderr
    assert run.returncode != 0
    assert words in said
    assert "Traceback" not in said
    assert "Job stats" not in said


def test_results_never_replace_a_configuration(project):
    (project / "mine").mkdir()
    own = "study: {trial_sheet: config/tiny.tsv}\npathvars: {results: mine, logs: mine/logs}\n"
    (project / "mine/config.yaml").write_text(own)
    run = snakemake(project, "mine/config.yaml", config="../mine/config")
    assert run.returncode != 0
    assert "which holds the configuration mine/config.yaml: name another" in run.stderr
    assert (project / "mine/config.yaml").read_text() == own
