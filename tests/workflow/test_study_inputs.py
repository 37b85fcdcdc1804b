"""Recordings of a study that are replaced, touched, redated, copied or missing."""

import json
import os
import re

import numpy as np
import pytest
from study_builders import jobs, snakemake, write_sheet

from tepsipe.io.trial import read_sources
from workflow.support import job_outputs

pytestmark = pytest.mark.study
TRIAL = "results/trials/position_manipulator/a.h5"
YEAR_S = 365.0 * 86400.0
# recordings that are replaced and those that are only touched, and the years by which their date is moved
REPLACED = {"a": -10.0, "b": 0.0, "c": 1e-5, "d": 73.0, "e": None}
TOUCHED = {"f": -10.0, "g": 0.0, "h": 73.0}
# of the recorded joint (N·m/rad)
STIFFNESS = {name: 70.0 + k for k, name in enumerate((*REPLACED, *TOUCHED))}
TRIALS = [f"results/trials/position_manipulator/{name}.h5" for name in STIFFNESS]


def record(path, stiffness):
    """A recording of a joint, of a size that does not depend on its stiffness (N·m/rad)."""
    time = np.arange(0.0, 16.0, 0.004)
    angle = 0.002 * np.convolve(np.random.default_rng(7).standard_normal(time.size), np.hanning(30), "same")
    torque = -1.2 * np.gradient(angle, time) - stiffness * angle
    header = "time_s,ankle_pos_rad,ankle_torque_Nm"
    np.savetxt(path, np.column_stack([time, angle, torque]), "%+10.6f", ",", header=header, comments="")


@pytest.fixture(scope="module")
def recorded(project):
    """A study of recordings of a joint, whose trials have been made."""
    rows = []
    for name, stiffness in STIFFNESS.items():
        record(project / f"{name}.csv", stiffness)
        rows.append(f"position_manipulator {name} recorded - - - 16 {name}.csv - - -")
    write_sheet(project, rows)
    run = snakemake(project, *TRIALS)
    assert run.returncode == 0, run.stdout + run.stderr
    return project


def dated(path, years):
    moment = path.stat().st_mtime + years * YEAR_S
    os.utime(path, (moment, moment))


def test_another_recording_is_analysed_again_whatever_its_date_and_a_touched_one_kept(recorded):
    before = {name: (recorded / f"{name}.csv").stat() for name in STIFFNESS}

    def with_dates_of(name):
        os.utime(recorded / f"{name}.csv", ns=(before[name].st_atime_ns, before[name].st_mtime_ns))

    for name, years in REPLACED.items():
        record(recorded / f"{name}.csv", STIFFNESS[name] + 20.0)
        assert (recorded / f"{name}.csv").stat().st_size == before[name].st_size
        if years is None:  # the same size and date: only the system's own time tells
            with_dates_of(name)
        else:
            dated(recorded / f"{name}.csv", years)
    for name, years in TOUCHED.items():
        dated(recorded / f"{name}.csv", years)
    run = snakemake(recorded, *TRIALS, "-n", "--quiet", "host")
    planned = re.findall(r"output: results/trials/position_manipulator/(\w)\.h5", run.stdout + run.stderr)
    assert sorted(planned) == list(REPLACED)
    assert run.stderr.count("tepsipe: recording changed, analysed again: a.csv and 4 more\n") == 1
    for name in STIFFNESS:
        record(recorded / f"{name}.csv", STIFFNESS[name])
        with_dates_of(name)
    assert jobs(snakemake(recorded, *TRIALS, "-n")) == {}


def test_a_recording_of_the_future_is_analysed_and_kept_from_then_on(recorded):
    record(recorded / "a.csv", 90.5)
    dated(recorded / "a.csv", 73.0)
    run = snakemake(recorded, TRIAL)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "tepsipe: recording changed, analysed again: a.csv\n" in run.stderr
    _, sources = read_sources(recorded / TRIAL)
    assert sources["log"]["sha256"] == job_outputs._digest(recorded / "a.csv")
    assert jobs(snakemake(recorded, TRIAL, "-n")) == {}


def test_files_that_the_settings_name_may_be_dated_in_the_future(recorded):
    sheet = "config/tiny.tsv"
    dated(recorded / sheet, 73.0)
    run = snakemake(recorded, "results/provenance.json")
    assert run.returncode == 0, run.stdout + run.stderr
    kept = json.loads((recorded / "results/provenance.json").read_text())["files"]["trial sheet"]
    assert kept == {"file": sheet, "sha256": job_outputs._digest(recorded / sheet)}
    assert jobs(snakemake(recorded, "results/provenance.json", "-n")) == {}
    (recorded / sheet).write_text((recorded / sheet).read_text() + "# looked at\n")
    dated(recorded / sheet, -10.0)
    assert jobs(snakemake(recorded, "results/provenance.json", "-n"))["record_provenance"] == 1


def test_an_edit_of_the_library_is_seen_after_results_were_touched(recorded):
    module = recorded / "tepsipe/ingest/manipulators.py"
    before = module.read_text()
    assert jobs(snakemake(recorded, TRIAL, "-n")) == {}
    os.utime(recorded / TRIAL)
    module.write_text(f"{before}\n")
    assert jobs(snakemake(recorded, TRIAL, "-n"))["ingest_position_manipulator"] == 1
    module.write_text(before)


def test_a_missing_recording_is_named_by_its_job(recorded):
    path = recorded / "a.csv"
    path.rename(recorded / "elsewhere.csv")
    run = snakemake(recorded, TRIAL, "-n")
    assert run.returncode == 0 and jobs(run)["ingest_position_manipulator"] == 1
    (recorded / "elsewhere.csv").rename(path)


@pytest.mark.parametrize("options", [["-n"], []])
def test_a_full_disk_is_named_before_snakemake_writes_to_it(recorded, options):
    module = recorded / "workflow/support/runs.py"
    before = module.read_text()
    module.write_text(f"{before}\n\nLEAST_BYTES = 1 << 80\n")
    run = snakemake(recorded, TRIAL, *options)
    module.write_text(before)
    assert run.returncode == 1 and "Traceback" not in run.stderr
    assert f"tepsipe: {recorded}: expected space for the run, found the disk full" in run.stderr


def test_what_the_system_refuses_before_the_first_job_is_one_sentence(recorded):
    module = recorded / "workflow/support/job_outputs.py"
    before = module.read_text()
    full = 'raise OSError(28, "No space left on device", "results/a")'
    module.write_text(f"{before}\n\ndef changes(logs):\n    {full}\n")
    run = snakemake(recorded, TRIAL)
    module.write_text(before)
    assert run.returncode == 1
    (said,) = [line for line in run.stderr.splitlines() if line.startswith("tepsipe: ")]
    assert said.startswith("tepsipe: results/a: expected a folder to write to, found that the system refuses")
    assert "Traceback" not in run.stderr
