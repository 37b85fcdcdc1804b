"""A tiny study in a copy of the project: what its tests share.

The fixture ``study`` (conftest.py) is made once per run and only read. A test that changes a study takes
``own_study``, a copy with results, or ``project``, one without; both belong to its file.
"""

import compileall
import csv
import hashlib
import re
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import yaml
from warm_snakemake import WarmSnakemake

from tepsipe.io.result import read_result
from tepsipe.reporting.recovery import linear_truth, read_true_motion
from tepsipe.virtual_lab.platform_person import PlatformPerson, PlatformProtocol, record_platform
from workflow.support.trial_sheet import COLUMNS, OPTIONAL_COLUMNS

ROOT = Path(__file__).parents[1]
TRIALS = [
    "wristalyzer 0.12 virtual_lab multisine 0.12 - 40 - - - -",
    "wristalyzer 0.16 virtual_lab multisine 0.16 - 40 - - - -",
    "dummy sine-0.5 virtual_lab sine 0.5 4 46 - - - -",
    "dummy minjerk-0.5 virtual_lab minjerk 0.5 4 46 - - - -",
    "weight sine-0.4 virtual_lab sine 0.4 4 28 - - - - calibrate",
    "weight minjerk-0.4 virtual_lab minjerk 0.4 4 28 - - - - validate",
    "empty sine-0.4 virtual_lab sine 0.4 4 28 - - - - calibrate",
    "empty minjerk-0.4 virtual_lab minjerk 0.4 4 28 - - - - validate",
    "standing relax-neg-0.5 virtual_lab negative-sine 0.5 4-4.5 41 - - - - - - relax",
    "standing stiff-pos-0.5 virtual_lab sine 0.5 4-4.5 41 - - - - - - stiff",
]
OVERRIDES = {
    "study": {"trial_sheet": "config/tiny.tsv"},
    "wristalyzer": {"analysis": {"random_starts": 3, "profile_points": 29}},
    # steps of 2 ms change no VAF that a test reads by more than 0.03 %
    "dummy": {"analysis": {"bootstrap_draws": 300}, "simulation": {"step_s": 0.002}},
    "noise": {"snr_db": [20], "draws": 10, "predicted_draws": 2},
    "weight": {"models": {"shortest_s": 0.5, "fir_lag_s": 0.04}},
}
PEOPLE = ("relax-neg-0.5", "stiff-pos-0.5")


def write_sheet(project, rows, name="tiny"):
    cells = [row.split("\t") if "\t" in row else row.split() for row in rows]
    header = [*COLUMNS, *OPTIONAL_COLUMNS][: max(map(len, cells))]
    lines = [header, *[row + ["-"] * (len(header) - len(row)) for row in cells]]
    (project / f"config/{name}.tsv").write_text("".join("\t".join(line) + "\n" for line in lines))


def write_config(project, content, name="tiny"):
    (project / f"config/{name}.yaml").write_text(yaml.safe_dump(content))


def plain_laboratory(text):
    """The laboratory's file for known answers: rigs without the mechanisms of test_mechanisms.py.

    The weight's mass is drawn, so that the study has a drawn constant.
    """
    before, _ = text.split("\ndrawn:\n")
    off = r"(?<=    )(bristle_share|friction_lever_m|compliance_rad_per_Nm|growing_per_m): [\d.]+"
    plain, count = re.subn(off, r"\1: 0.0", before)
    plain, modes = re.subn(r"second_share: \[[\d., ]+\]", "second_share: [0.0, 0.0]", plain)
    # one other law of the joint suffices
    plain, laws = re.subn(r"    (?:friction|power-law):\n(?:      .*\n)+", "", plain)
    assert (count, modes, laws) == (5, 1, 2)
    return f"{plain}\ndrawn:\n  weight.mass_kg: {{rectangular: 0.05}}\n"


@cache
def compiled():
    """Make the bytecode that copies of the project contain, once for all of them."""
    for package in ("tepsipe", "workflow"):
        compileall.compile_dir(ROOT / package, quiet=2)


def copy_project(target):
    compiled()
    shutil.copytree(ROOT / "benchmarks/coverage", target / "benchmarks/coverage")
    shutil.copytree(ROOT / "docs/decisions", target / "docs/decisions")
    folders = ("config", "workflow", "tepsipe", "report", "profiles")
    for name in ("Snakefile", "CITATION.cff", "requirements.txt", *folders):
        source = ROOT / name
        if source.is_dir():
            # with its bytecode, which would have to be made again in every copy
            shutil.copytree(source, target / name)
        else:
            target.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, target / name)
    settings = target / "config/config.yaml"  # PyBullet where it is installed, and elsewhere what is there
    settings.write_text(settings.read_text().replace("    engine: pybullet", "    engine: auto"))
    laboratory = target / "config/virtual_lab.yaml"
    laboratory.write_text(plain_laboratory(laboratory.read_text()))
    write_sheet(target, TRIALS)
    write_config(target, OVERRIDES)
    return target


@cache
def warm_process():
    """One for all tests of this process."""
    return WarmSnakemake()


def snakemake(project, *arguments, config="tiny", module="snakemake"):
    """Run Snakemake as the command line does, in a fork of a process that has imported it.

    module: of ``python -m``; workflow.run becomes Snakemake.
    """
    options = ["-c1", *arguments, "--configfile", f"config/{config}.yaml"]
    return warm_process().run(options, project, module)


def users_snakemake(project):
    """Run Snakemake on two cores by the command that users type, in a Python of its own."""
    command = [sys.executable, "-m", "snakemake", "-c2", "--configfile", "config/tiny.yaml"]
    return subprocess.run(command, cwd=project, capture_output=True, text=True)


def jobs(run):
    """Rule -> number of jobs in the statistics that Snakemake prints."""
    table = re.search(r"-{3,}\s+-{3,}\n(.*?)\n\n", run.stdout + run.stderr, re.DOTALL)
    rows = [line.split() for line in table.group(1).splitlines()] if table else []
    return {name: int(count) for name, count in rows if name != "total"}


def estimates(project, results="results"):
    with open(project / results / "tables/estimates.csv", newline="") as file:
        return list(csv.DictReader(file))


def table(project, name):
    with open(project / f"results/tables/{name}.csv", newline="") as file:
        return list(csv.DictReader(file))


def value(rows, **wanted):
    (row,) = [row for row in rows if all(row[key] == cell for key, cell in wanted.items())]
    return float(row["value"])


def joint_in_windows(results, condition, rig="dummy"):
    """I, B, K of the linear joint nearest to the true one in the windows of a dummy's fit."""
    fit = read_result(results / f"fits/{rig}/{condition}.h5")
    time, windows = fit.arrays["time"], fit.arrays["windows"]
    motion = read_true_motion(results / f"truth/{rig}/{condition}.h5")
    return linear_truth(motion, [(time[start], time[stop - 1]) for start, stop in windows])


def digests(folder):
    """Path below the results -> SHA-256, of everything that must be the same again."""
    folders = ("tables", "figures", "estimates", "trials", "raw", "report/trials")
    folders += ("cross_validation", "forward", "noise")
    files = [path for name in folders for path in sorted((folder / name).rglob("*")) if path.is_file()]
    files += [path for path in (folder / "report/thesis.pdf",) if path.is_file()]
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files
    }


def platform_table(path):
    """Two minutes of a person on a moving platform as a table, 50 Hz."""
    quiet = PlatformPerson(own_torque_Nm=(4.0, 2.0))
    record = record_platform(quiet, PlatformProtocol(duration_s=120.0), np.random.default_rng(1))
    table = np.column_stack([record.time, record.platform, record.angle, record.torque])
    header = "time_s,platform_m,ankle_angle_rad,hip_angle_rad,ankle_torque_Nm,hip_torque_Nm"
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.9g")


def treadmill_study(project, name, recordings, further=(), folder="."):
    """Run a study of treadmill recordings, condition -> (role, file), and of further rows of the sheet.

    folder: that of the recordings, as seen from the project.
    """
    rows = [
        "\t".join(["belt", condition, "recorded", "-", "-", "-", "39", str(file), "-", "-", "-", role])
        + "\t-\t-\tt\tMx (Nm)\tv (m/s)"
        for condition, (role, file) in recordings.items()
    ]
    write_sheet(project, [*rows, *further], name)
    content = {
        "study": {
            "name": name,
            "title": "A treadmill",
            "trial_sheet": f"config/{name}.tsv",
            "recordings_folder": folder,
            "virtual_lab": None,
            "reported": None,
        },
        "pathvars": {"results": f"results/{name}", "logs": f"results/{name}/logs"},
        "belt": {"analysis": {"cutoffs_hz": [6, 20]}},
    }
    write_config(project, content, name)
    run = snakemake(project, config=name)
    assert "Traceback" not in run.stdout + run.stderr
    return run
