"""Recordings of a study that are replaced, touched, redated, copied or missing."""

import json
import os

import numpy as np
import pytest
from study_builders import jobs, snakemake, write_sheet

from tepsipe.io.trial import read_sources
from workflow.support import job_outputs

pytestmark = pytest.mark.study
TRIAL = "results/trials/position_manipulator/a.h5"
YEAR_S = 365.0 * 86400.0


def record(path, stiffness):
    """A recording of a joint, of a size that does not depend on its stiffness (N·m/rad)."""
    time = np.arange(0.0, 16.0, 0.004)
    angle = 0.002 * np.convolve(np.random.default_rng(7).standard_normal(time.size), np.hanning(30), "same")
    torque = -1.2 * np.gradient(angle, time) - stiffness * angle
    header = "time_s,ankle_pos_rad,ankle_torque_Nm"
    np.savetxt(path, np.column_stack([time, angle, torque]), "%+10.6f", ",", header=header, comments="")


@pytest.fixture(scope="module")
def recorded(project):
    """A study of one recording of a joint, whose trial has been made."""
    record(project / "a.csv", 70.0)
    write_sheet(project, ["position_manipulator a recorded - - - 16 a.csv - - -"])
    run = snakemake(project, TRIAL)
    assert run.returncode == 0, run.stdout + run.stderr
    return project


def dated(path, years):
    moment = path.stat().st_mtime + years * YEAR_S
    os.utime(path, (moment, moment))


@pytest.mark.parametrize("years", [-10.0, 0.0, 1e-5, 73.0])
def test_another_recording_is_analysed_again_whatever_its_date(recorded, years):
    path, before = recorded / "a.csv", (recorded / "a.csv").stat()
    record(path, 71.0)
    dated(path, years)
    assert path.stat().st_size == before.st_size
    run = snakemake(recorded, TRIAL, "-n")
    assert jobs(run)["ingest_position_manipulator"] == 1
    assert run.stderr.count("tepsipe: recording changed, analysed again: a.csv\n") == 1
    if years == 0.0:  # replaced with a file of the same size and date, which only the system's own time tells
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
        assert jobs(snakemake(recorded, TRIAL, "-n"))["ingest_position_manipulator"] == 1
    record(path, 70.0)
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert jobs(snakemake(recorded, TRIAL, "-n")) == {}


@pytest.mark.parametrize("years", [-10.0, 0.0, 73.0])
def test_a_recording_that_was_only_touched_is_kept(recorded, years):
    dated(recorded / "a.csv", years)
    run = snakemake(recorded, TRIAL, "-n")
    assert jobs(run) == {} and "analysed again" not in run.stderr
    dated(recorded / "a.csv", -years)


def test_a_recording_of_the_future_is_analysed_and_kept_from_then_on(recorded):
    record(recorded / "a.csv", 72.0)
    dated(recorded / "a.csv", 73.0)
    run = snakemake(recorded, TRIAL)
    assert run.returncode == 0, run.stdout + run.stderr
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
    before, (made, *_) = module.read_text(), [recorded / TRIAL]
    assert jobs(snakemake(recorded, TRIAL, "-n")) == {}
    os.utime(made)
    module.write_text(f"{before}\n")
    assert jobs(snakemake(recorded, TRIAL, "-n"))["ingest_position_manipulator"] == 1
    module.write_text(before)


def test_a_missing_recording_is_named_by_its_job(recorded):
    path = recorded / "a.csv"
    path.rename(recorded / "b.csv")
    run = snakemake(recorded, TRIAL, "-n")
    assert run.returncode == 0 and jobs(run)["ingest_position_manipulator"] == 1
    (recorded / "b.csv").rename(path)


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
