"""Other trials in a tiny study: another truth of the laboratory, and its files listed as recordings."""

import csv
import json
import shutil

import edfio
import ezc3d
import h5py
import numpy as np
import pytest
import yaml
from report_readers import faults_of_study
from study_builders import (
    OVERRIDES,
    PEOPLE,
    estimates,
    joint_in_windows,
    snakemake,
    value,
    write_config,
    write_sheet,
)

from tepsipe.io.trial import read_trial
from workflow.support.checked_study import checked_study, merged_settings
from workflow.support.recordings import ingested

pytestmark = pytest.mark.study


def test_another_truth_in_the_laboratory_is_recovered_too(own_study):
    truth = yaml.safe_load((own_study / "config/virtual_lab.yaml").read_text())
    truth["dummy"]["rubber"] |= {"stiffness_Nm_per_rad": 14.0, "damping_Nms_per_rad": 0.25}
    (own_study / "config/other_truth.yaml").write_text(yaml.safe_dump(truth))
    other = {
        "study": OVERRIDES["study"] | {"virtual_lab": "config/other_truth.yaml"},
        "pathvars": {"results": "results/other", "logs": "results/other/logs"},
    }
    write_config(own_study, other, "other")
    target = "results/other/estimates/dummy/sine-0.5.csv"
    run = snakemake(own_study, target, config="other")
    assert run.returncode == 0, run.stdout + run.stderr
    with open(own_study / target, newline="") as file:
        rows = list(csv.DictReader(file))
    small = {"pathway": "leg-output-error", "estimator": "output-error"}
    assert value(rows, **small, quantity="K") == pytest.approx(14.0, rel=0.03)
    assert value(rows, **small, quantity="B") == pytest.approx(0.25, rel=0.1)
    true = joint_in_windows(own_study / "results/other", "sine-0.5")
    assert 7.0 < true["K"] < 0.95 * 14.0  # at the working amplitude, half of it when soft
    assert value(rows, pathway="leg", quantity="K") == pytest.approx(true["K"], rel=0.02)
    assert value(rows, pathway="leg", quantity="B") == pytest.approx(true["B"], rel=0.1)


def test_check_reads_a_trial_as_its_job_does(study, monkeypatch):
    monkeypatch.chdir(study)
    files = ["config/config.yaml", "config/tiny.yaml"]
    tiny = checked_study(merged_settings(files), files)
    # one trial of each experiment
    for experiment, condition in {e: (e, c) for e, c in tiny.trials}.values():
        written = read_trial(f"results/trials/{experiment}/{condition}.h5")
        read = ingested(tiny, experiment, condition, "results")
        assert read.signals.keys() == written.signals.keys()
        for name, signal in written.signals.items():
            assert np.array_equal(read.signals[name].values.astype(signal.values.dtype), signal.values), name


def test_a_recorded_trial_gives_what_the_same_files_give_when_they_are_made(own_study):
    raw = own_study / "results/raw/dummy/sine-0.5"
    row = f"dummy own recorded - - - 46 {raw / 'log.mat'} - {raw / 'calibration.csv'} {raw / 'markers.c3d'}"
    write_sheet(own_study, [row], "recorded")
    recorded = {
        "study": {
            "trial_sheet": "config/recorded.tsv",
            "title": "Own {B} <b> trial",
            "virtual_lab": None,
            "reported": None,
        },
        "pathvars": {"results": "results/recorded", "logs": "results/recorded/logs"},
        "dummy": OVERRIDES["dummy"],
    }
    write_config(own_study, recorded, "recorded")
    run = snakemake(own_study, config="recorded")
    assert run.returncode == 0, run.stdout + run.stderr
    made = [row for row in estimates(own_study) if row["condition"] == "sine-0.5"]
    own = estimates(own_study, "results/recorded")
    own_pathways = {row["pathway"] for row in own}
    of_trial = [
        row for row in made if row["quantity"] != "VAF_cross_validated" and row["pathway"] in own_pathways
    ]
    assert [row["value"] for row in own] == [row["value"] for row in of_trial]
    assert (own_study / "results/recorded/report/thesis.pdf").exists()
    # braces in a title are text
    data = json.loads((own_study / "results/recorded/report/report.json").read_text())
    assert "Own {B} <b> trial" in json.dumps(data, ensure_ascii=False)
    assert faults_of_study(own_study / "results/recorded") == []
    page = (own_study / "results/recorded/report/trials/dummy/own.html").read_text(encoding="utf-8")
    assert "leg, single-body equation" in page and "thesis" not in page.partition("<body>")[2].lower()


@pytest.fixture(scope="module")
def people(own_study):
    """A study of three recorded trials, and the instant (s) of a perturbation in the first.

    A flat, a missing and a loose electrode and a hidden marker; a step; no electromyograms at all.
    """
    bad = own_study / "bad_person"
    for condition in PEOPLE:
        shutil.copytree(own_study / f"results/raw/standing/{condition}", bad / condition)
    edf = edfio.read_edf(bad / PEOPLE[0] / "emg.edf")
    hum = 300.0 * np.sin(2.0 * np.pi * 50.0 * np.arange(edf.signals[0].data.size) / 1000.0)
    for signal in edf.signals:
        if signal.label == "EMG SOL":
            signal.update_data(np.zeros_like(signal.data), keep_physical_range=True)
        if signal.label == "EMG BF":
            signal.update_data(hum, keep_physical_range=True)
        if signal.label == "EMG GAS":
            signal.label = "EMG gastro"
    edf.write(bad / PEOPLE[0] / "emg.edf")
    with h5py.File(own_study / f"results/epochs/standing/{PEOPLE[0]}.h5") as responses:
        onset = float(responses["onsets_s"][1])
    hide_marker(bad / PEOPLE[0] / "markers.c3d", "shank2", onset + 0.03)
    step(bad / PEOPLE[1] / "markers.c3d", 20.0)
    rows = [
        f"standing {condition} recorded - - - 41 {folder / 'log.mat'} - {folder / 'calibration.csv'} "
        f"{folder / 'markers.c3d'} - {folder / 'emg.edf'} {condition.partition('-')[0]}"
        for condition, folder in ((condition, bad / condition) for condition in PEOPLE)
    ]
    folder = own_study / f"results/raw/standing/{PEOPLE[0]}"
    rows.append(
        f"standing silent recorded - - - 41 {folder / 'log.mat'} - {folder / 'calibration.csv'} "
        f"{folder / 'markers.c3d'} - - told"
    )
    write_sheet(own_study, rows, "people")
    people = {
        "study": {"trial_sheet": "config/people.tsv", "virtual_lab": None, "reported": None},
        "pathvars": {"results": "results/people", "logs": "results/people/logs"},
        "standing": {"pathways": {"ankle-compensated": {"treadmill_model": None}}},
    }
    write_config(own_study, people, "people")
    run = snakemake(own_study, "results/people/report/report.json", config="people")
    assert run.returncode == 0, run.stdout + run.stderr
    return own_study, onset


STIFFNESS = {"pathway": "ankle", "estimator": "pre-reflex-window", "quantity": "K"}


def test_what_cannot_be_trusted_of_a_person_is_named_in_the_report_and_left_out(people):
    own_study, onset = people
    told = "\n".join(left_out(own_study / "results/people"))
    for words in (
        "muscle SOL left out: expected at least 0.25 uV",
        "muscle GAS left out: its channel is not in the file",
        "muscle BF left out: expected at most 80 % of the power from the mains",
        f"perturbation at {onset:.2f} s left out: marker 'shank2' was hidden",
        "standing/stiff-pos-0.5: left out as a whole: the foot's marker",
    ):
        assert words in told, told
    found = estimates(own_study, "results/people")
    assert {row["condition"] for row in found} == {"relax-neg-0.5", "relax", "silent", "told", "told-relax"}
    before = value(estimates(own_study), condition="relax-neg-0.5", **STIFFNESS)
    after = value(found, condition="relax-neg-0.5", **STIFFNESS)
    # one of the responses is missing, and nothing else has changed
    assert after != before
    assert after == pytest.approx(before, rel=0.2)


def test_report_of_a_person_has_marks_and_nothing_of_the_thesis(people):
    assert faults_of_study(people[0] / "results/people") == []


def test_a_person_without_electromyograms_still_has_ankles(people):
    own_study, _ = people
    found = estimates(own_study, "results/people")
    before = value(estimates(own_study), condition=PEOPLE[0], **STIFFNESS)
    assert value(found, condition="silent", **STIFFNESS) == before
    silent = [row for row in found if row["condition"].startswith(("silent", "told"))]
    assert not [row for row in silent if row["estimator"] == "emg-driven"]
    assert "standing/silent: no muscles: the trial has no file of electromyograms" in left_out(
        own_study / "results/people"
    )


def left_out(results):
    """Omissions of a standing person as the report has them: of trials, then of tasks."""
    facts = json.loads((results / "report/report.json").read_text())["facts"]
    trials = (facts["standing"], facts.get("standing_tasks", {}))
    return [sentence for own in trials for fit in own.values() for sentence in fit["left_out"]]


def hide_marker(path, label, instant_s):
    """Hide a marker for 20 ms."""
    file = ezc3d.c3d(str(path))
    labels = file["parameters"]["POINT"]["LABELS"]["value"]
    frames = slice(round(250.0 * instant_s), round(250.0 * instant_s) + 5)
    file["data"]["points"][:3, labels.index(label), frames] = np.nan
    rewrite(file, path)


def step(path, instant_s):
    """Within 0.2 s the leg goes on 8 cm further forward."""
    file = ezc3d.c3d(str(path))
    points = file["data"]["points"]
    points[1] += 80.0 * np.clip((np.arange(points.shape[2]) / 250.0 - instant_s) / 0.2, 0.0, 1.0)
    rewrite(file, path)


def rewrite(file, path):
    hidden = np.isnan(file["data"]["points"][:3]).any(axis=0)
    file["data"]["meta_points"]["residuals"] = np.where(hidden, -1.0, 0.0)[None]
    file.write(str(path))
