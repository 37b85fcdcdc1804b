"""The same small study as on other processors: all numbers agree, as docs/architecture.md promises.

    .venv/bin/python benchmarks/soak/core_types.py --types Haswell Nehalem

OpenBLAS chooses its routines by the kind of processor, and they sum in different orders; OPENBLAS_CORETYPE
lets one processor take the routines of another. It is a violation if a run fails, if a table has other rows
or texts, or if a number differs by more than 1e-6 of the largest one of its quantity in a table, 1e-5 in the
data of a figure, or 1e-4 of the largest one of its array in an HDF5 file. Scores of the model hnat2014 are
not compared: its published search ends after a number of evaluations, before it converges.
"""

import argparse
import csv
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from study_builders import copy_project  # noqa: E402

# kind of result -> largest difference; data of figures have six digits
WITHIN = {"tables": 1e-6, "figures": 1e-5, "HDF5 files": 1e-4}
TYPES = ("Haswell", "Nehalem")
STOPPED = "hnat2014"
# columns that are compared by the largest number of all of them, because some hold rounding errors only: the
# bias of a parameter without noise, an inertia that is 0, or a spread that a claim compares with a limit
OF_ONE_SIZE = {
    *("value", "standard_error", "ci_low", "ci_high", "sem_as_printed", "u_type_a", "u_type_b", "truth"),
    *("mean", "sd", "bias", "without_noise", "apparent"),
    *("reported", "reproduced", "null_value"),
}
ASKED = """
import ctypes, pathlib, numpy
library = next((pathlib.Path(numpy.__file__).parents[1] / "numpy.libs").glob("libscipy_openblas64_*"))
name = ctypes.CDLL(str(library)).scipy_openblas_get_corename64_
name.restype = ctypes.c_char_p
print(name().decode())
"""


def core_type(environment: dict) -> str:
    """Kind of processor for which OpenBLAS chooses its routines; empty if it cannot be asked."""
    asked = subprocess.run([sys.executable, "-c", ASKED], env=environment, capture_output=True, text=True)
    return asked.stdout.strip()


def numbers(path: Path) -> tuple[dict[str, np.ndarray], list]:
    """Numbers of a result, by array or by quantity and column, and all of its texts."""
    values_of: dict[str, list] = {}
    texts: list = []
    if path.suffix == ".h5":
        with h5py.File(path) as file:

            def visit(name, item):
                if not isinstance(item, h5py.Dataset):
                    return
                if np.issubdtype(item.dtype, np.complexfloating):
                    values_of[f"{name}, real"], values_of[f"{name}, imaginary"] = item[()].real, item[()].imag
                elif np.issubdtype(item.dtype, np.number):
                    values_of[name] = item[()]
                elif item.dtype.kind == "O":
                    texts.append((name, item.asstr()[()].tolist()))
                else:
                    texts.append((name, item[()].tolist()))

            file.visititems(visit)
        return {name: np.asarray(values, dtype=float) for name, values in values_of.items()}, texts
    with path.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            if row.get("model") == STOPPED:
                texts.append((STOPPED, row["train"], row["test"]))
                continue
            kind = row.get("quantity") or row.get("claim") or row.get("row") or ""
            for name, cell in row.items():
                column = "estimates" if name in OF_ONE_SIZE else name
                try:
                    values_of.setdefault(f"{kind} {column}".strip(), []).append(float(cell))
                except (TypeError, ValueError):
                    texts.append((kind, name, cell))
    return {name: np.array(values) for name, values in values_of.items()}, texts


def difference(first: Path, second: Path) -> tuple[float, str]:
    """Largest difference of two results relative to their largest numbers, and where or what differs."""
    (there, texts), (here, other_texts) = numbers(first), numbers(second)
    if texts != other_texts or there.keys() != here.keys():
        return np.inf, "texts or names"
    worst = (0.0, "")
    for name, values in there.items():
        others = here[name]
        if values.shape != others.shape or not np.array_equal(np.isfinite(values), np.isfinite(others)):
            return np.inf, name
        finite = np.isfinite(values)
        if finite.any() and (size := np.abs(values[finite]).max()) > 0.0:
            worst = max(worst, (float(np.abs(others - values)[finite].max() / size), name))
    return worst


def kind_of(path: str) -> str:
    """Kind of a result, of `WITHIN`, by its path."""
    return "HDF5 files" if path.endswith(".h5") else "figures" if path.startswith("figures/") else "tables"


def study(folder: Path, environment: dict, cores: int) -> Path:
    """Results of the small study in an environment."""
    project = copy_project(folder)
    command = [sys.executable, "-m", "snakemake", f"-c{cores}", "--configfile", "config/tiny.yaml"]
    done = subprocess.run(command, cwd=project, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"the study fails:\n{(done.stdout + done.stderr)[-3000:]}")
    return project / "results"


def run(types: tuple[str, ...] = TYPES, cores: int = 2) -> list[dict]:
    """Compare the study on this processor's own routines with that on others; rows, one per other kind.

    Parameters
    ----------
    types : tuple of str
        Names of core types, as OpenBLAS has them.
    cores : int
        Number of cores of every run.
    """
    native = core_type(dict(os.environ))
    rows = []
    with tempfile.TemporaryDirectory(prefix="tepsipe-cores-") as name:
        first = study(Path(name) / "own", dict(os.environ), cores)
        files = sorted(p for p in first.rglob("*") if p.suffix in (".h5", ".csv"))
        for kind in [kind for kind in types if kind != native]:
            environment = dict(os.environ, OPENBLAS_CORETYPE=kind)
            row = {"own": native, "other": core_type(environment), "files": len(files), "violation": ""}
            rows.append(row)
            if row["other"] != kind:
                row["violation"] = f"OpenBLAS does not take the core type {kind}"
                continue
            second = study(Path(name) / kind, environment, cores)
            compared = {}
            for path in files:
                other = second / path.relative_to(first)
                if path.read_bytes() != other.read_bytes():
                    compared[path.relative_to(first).as_posix()] = difference(path, other)
            row["differ"] = len(compared)
            for result, within in WITHIN.items():
                of_kind = {path: found for path, found in compared.items() if kind_of(path) == result}
                path, (largest, where) = max(
                    of_kind.items(), key=lambda item: item[1][0], default=("", (0.0, ""))
                )
                row[result] = largest
                if largest > within:
                    row["violation"] += f"{path}: {where} differs by {largest:.1e}. "
    return rows


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--types", nargs="+", default=TYPES)
    parser.add_argument("--cores", type=int, default=2)
    given = parser.parse_args()
    rows = run(tuple(given.types), given.cores)
    print(f"| Core type | Other core type | Files | That differ | Largest in {' | '.join(WITHIN)} |")
    print(f"|---|---|---:|---:|{'---:|' * len(WITHIN)}")
    for row in rows:
        print(
            f"| {row['own']} | {row['other']} | {row['files']} | {row.get('differ', '–')} | "
            f"{' | '.join(f'{row.get(result, np.nan):.1e}' for result in WITHIN)} |"
        )
    for row in rows:
        if row["violation"]:
            print(f"  violation: {row['violation']}")
    return int(any(row["violation"] for row in rows))


if __name__ == "__main__":
    sys.exit(main())
