"""The tiny study again: with results that were damaged, and on another kind of processor."""

import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from study_builders import jobs, snakemake
from warm_snakemake import WarmSnakemake

pytestmark = pytest.mark.study


def test_deleted_and_damaged_results_are_planned_again_and_edited_ones_refused(own_study):
    fits, edited = own_study / "results/fits", own_study / "results/estimates/dummy/sine-0.5.csv"
    before = edited.read_bytes()
    edited.write_bytes(before + b"\n")
    run = snakemake(own_study, "-n")
    assert run.returncode != 0
    assert (
        run.stderr.count("tepsipe: results/estimates/dummy/sine-0.5.csv: expected the result as a job") == 1
    )
    edited.write_bytes(before)
    shutil.move(fits / "dummy/minjerk-0.5.h5", own_study)
    damaged = (fits / "wristalyzer/0.12.h5").read_bytes()
    (fits / "wristalyzer/0.12.h5").write_bytes(damaged[:5000])
    run = snakemake(own_study, "-n")
    assert run.returncode == 0, run.stderr
    assert "tepsipe: missing, made again: results/fits/dummy/minjerk-0.5.h5\n" in run.stderr
    assert "tepsipe: damaged, made again: results/fits/wristalyzer/0.12.h5\n" in run.stderr
    assert jobs(run)["fit_dummy"] == 1
    (fits / "wristalyzer/0.12.h5").write_bytes(damaged)
    shutil.move(own_study / "minjerk-0.5.h5", fits / "dummy")


def core_type(environment):
    """What numpy's OpenBLAS takes the processor for, or None where it cannot be asked."""
    code = (
        "import ctypes, pathlib, numpy\n"
        "folder = pathlib.Path(numpy.__file__).parents[1] / 'numpy.libs'\n"
        "library = ctypes.CDLL(str(next(folder.glob('libscipy_openblas64_*'))))\n"
        "name = library.scipy_openblas_get_corename64_\n"
        "name.restype = ctypes.c_char_p\n"
        "print(name().decode())"
    )
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    return done.stdout.strip() or None


def numbers(path):
    """Name -> numbers of a table of estimates or of an HDF5 file."""
    if path.suffix == ".h5":
        found = {}

        def visit(name, item):
            if isinstance(item, h5py.Dataset) and np.issubdtype(item.dtype, np.floating):
                found[name] = item[()]

        with h5py.File(path) as file:
            file.visititems(visit)
        return found
    rows = [line.split(",") for line in path.read_text().splitlines()]
    return {
        f"{'/'.join(row[:5])} {name}": float(cell)
        for row in rows[1:]
        for name, cell in zip(rows[0], row, strict=True)
        if name in ("value", "standard_error", "ci_low", "ci_high", "sem_as_printed") and cell
    }


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="core types of other processors")
def test_another_kind_of_processor_gives_the_same_numbers(study, own_study):
    """OpenBLAS sums in another order: tables are equal to 1e-6, HDF5 files to 1e-4 of their largest value."""
    own = core_type(dict(os.environ))
    others = [name for name in ("Nehalem", "Haswell") if name != own]
    other = dict(os.environ, OPENBLAS_CORETYPE=others[0])
    if own is None or core_type(other) != others[0]:
        pytest.skip("this OpenBLAS cannot be told its core type")
    trials = ("wristalyzer/0.12", "dummy/sine-0.5", "weight/minjerk-0.4", "standing/relax-neg-0.5")
    rules = [f"ingest_{trial.split('/')[0]}" for trial in trials]
    targets = (f"results/estimates/{trial}.csv" for trial in trials)
    options = ["-c2", *targets, "--forcerun", *rules, "--configfile", "config/tiny.yaml"]
    run = WarmSnakemake(other).run(options, own_study)
    assert run.returncode == 0, run.stdout + run.stderr
    worst = {".csv": 0.0, ".h5": 0.0}
    for trial in trials:
        for name in (f"trials/{trial}.h5", f"fits/{trial}.h5", f"estimates/{trial}.csv"):
            there, here = (numbers(project / "results" / name) for project in (study, own_study))
            assert there.keys() == here.keys()
            for key, value in there.items():
                assert np.array_equal(np.isnan(value), np.isnan(here[key])), f"{name} {key}"
                size = np.nanmax(np.abs(value), initial=0.0)
                difference = np.nanmax(np.abs(here[key] - value), initial=0.0)
                kind = Path(name).suffix
                worst[kind] = max(worst[kind], float(difference / size) if size else float(difference))
    print(f"{own}, {others[0]}: at most {worst} relative")
    assert worst[".csv"] < 1e-6
    assert worst[".h5"] < 1e-4  # shares of a budget: docs/architecture.md
    assert worst[".h5"] > 0.0  # another core type was at work
