"""The campaign as a whole: its parts run, their tables are kept, time is limited; results are compared."""

import argparse
import contextlib
import time

import h5py
import numpy as np
import psutil
import pytest

from benchmarks.soak import core_types, soak

GIVEN = argparse.Namespace(seed=3, mutations=4, kills=1, cores=1)


@pytest.mark.slow
def test_a_part_runs_and_its_table_is_kept(monkeypatch, tmp_path):
    monkeypatch.setattr(soak, "arguments", lambda part, given: ["--mutations", "4", "--reader", "estimates"])
    monkeypatch.setattr("sys.argv", ["soak", "--part", "mutations", "--into", str(tmp_path / "results.md")])
    assert soak.main() == 0
    report = (tmp_path / "results.md").read_text()
    assert "seed 1" in report
    assert "## Damaged files\n" in report
    assert "without violations" in report
    assert report.count("| estimates | 4 |") == 1


@pytest.mark.slow
def test_a_part_that_takes_too_long_is_killed_with_all_that_it_started(monkeypatch, tmp_path):
    script = tmp_path / "mutations.py"
    script.write_text(
        "import subprocess, sys\n"
        "sleep = [sys.executable, '-c', 'import time; time.sleep(60)']\n"
        "child = subprocess.Popen(sleep, start_new_session=True)\n"
        "print(child.pid)\n"
        "child.wait()\n"
    )
    monkeypatch.setattr(soak, "HERE", tmp_path)
    code, said, took = soak.perform("mutations", GIVEN, time.monotonic() + 1.0)
    assert code != 0
    assert took < 20.0
    with contextlib.suppress(psutil.NoSuchProcess):  # what is killed ends a little later
        child = psutil.Process(int(said))
        until = time.monotonic() + 10.0
        while child.status() != psutil.STATUS_ZOMBIE:
            assert time.monotonic() < until, "what the part started still runs"
            time.sleep(0.05)


def test_every_part_is_a_script():
    for part in soak.TITLES:
        assert (soak.HERE / f"{part}.py").is_file()
        assert soak.arguments(part, GIVEN)


def table(path, value, text="K"):
    path.write_text(f"quantity,value,n\n{text},{value!r},14\nB,0.1,14\n")
    return path


def test_tables_are_compared_number_by_number(tmp_path):
    first = table(tmp_path / "a.csv", 10.0)
    assert core_types.difference(first, table(tmp_path / "b.csv", 10.0))[0] == 0.0
    assert core_types.difference(first, table(tmp_path / "b.csv", 10.001))[0] == pytest.approx(1e-4)
    assert core_types.difference(first, table(tmp_path / "b.csv", 10.0, "I"))[0] == np.inf
    assert core_types.difference(first, table(tmp_path / "b.csv", float("nan")))[0] == np.inf


def test_rounding_errors_are_compared_by_the_size_of_their_quantity(tmp_path):
    for name, bias in (("a.csv", 1e-15), ("b.csv", -7e-15)):
        (tmp_path / name).write_text(f"quantity,mean,sd,bias\nK,10.0,0.5,0.1\nK,10.0,0.0,{bias!r}\n")
    assert core_types.difference(tmp_path / "a.csv", tmp_path / "b.csv")[0] == pytest.approx(8e-16, rel=1e-3)


def test_a_claim_is_compared_by_the_larger_of_its_number_and_its_limit(tmp_path):
    for name, spread, other in (("a.csv", 2.9e-7, 0.5), ("b.csv", 2.7e-7, 0.5), ("c.csv", 2.9e-7, 0.50001)):
        rows = f"spread of K exceeds 0.1,0.1,{spread!r}\nslope,0.4,{other!r}\n"
        (tmp_path / name).write_text(f"claim,reported,reproduced\n{rows}")
    rounding, real = (
        core_types.difference(tmp_path / "a.csv", tmp_path / name) for name in ("b.csv", "c.csv")
    )
    assert rounding == (pytest.approx(2e-7, rel=1e-3), "spread of K exceeds 0.1 estimates")
    assert real == (pytest.approx(2e-5, rel=1e-3), "slope estimates")


def test_every_result_has_a_bound_of_its_kind():
    paths = ("tables/claims.csv", "figures/figure_4_1.csv", "fits/dummy/sine-0.1.h5")
    assert [core_types.kind_of(path) for path in paths] == list(core_types.WITHIN)


def test_arrays_are_compared_number_by_number(tmp_path):
    def written(name, values):
        with h5py.File(tmp_path / name, "w") as file:
            file["fits/theta"] = values
            file["names"] = ["leg", "foot"]
            file["response"] = 1j * np.ones(2)
            file["hidden"] = values > 50.0
        return tmp_path / name

    first = written("a.h5", np.array([1.0, 100.0]))
    largest, where = core_types.difference(first, written("b.h5", np.array([1.5, 100.0])))
    assert (largest, where) == (pytest.approx(0.005), "fits/theta")
    assert core_types.difference(first, written("b.h5", np.array([1.0])))[0] == np.inf
