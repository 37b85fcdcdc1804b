"""Differences between two persons, measured in one laboratory and in two: chapter 5 of the thesis.

    .venv/bin/python benchmarks/two_laboratories.py [--cores 2] [--folder results/two_laboratories]

The thesis concludes that its method could reveal the difference between healthy subjects and patients on one
experimental set-up, but may not be applicable on more than one. Here 20 persons, 10 pairs, stand in two
laboratories: treadmill, cameras and calibration are those of the laboratory, body and joints those of the
person. All are drawn as config/coverage/config.yaml says, the laboratories from its set RIGS. Each of the 40
measurements is a study by the rules of this project; those that are done stay in the folder.
"""

import argparse
import csv
import math
import multiprocessing
import shutil
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402
import yaml  # noqa: E402
from snakemake.utils import update_config  # noqa: E402

from tepsipe.virtual_lab.drawn_laboratories import draw_laboratory  # noqa: E402
from workflow.support.laboratories import TABLES, Laboratories, forget, run  # noqa: E402

SEED = 51820337
PAIRS, LABORATORIES, ATTEMPTS = 10, 2, 5
RIGS, TASK = "other-rigs", "relax"
# stiffness and damping of a person's joints over those of the file: drawn between these limits
JOINTS = (0.9, 1.8)
# pathway, estimator -> what it is
WAYS = {
    ("ankle-thesis", "as-printed"): "eq (3-14), products of scalars",
    ("ankle-thesis-vector", "as-printed"): "eq (3-14), products of vectors",
    ("ankle", "pre-reflex-window"): "consistent, belt-induced force not removed",
    ("ankle-compensated", "pre-reflex-window"): "consistent, belt-induced force removed",
    ("ankle-compensated", "free-reflex-gls"): "as recommended",
}


@dataclass(frozen=True)
class Measurement:
    """One person in one laboratory, both counted from 1."""

    person: int
    laboratory: int
    attempt: int = 1
    """A person who falls is measured again."""

    @property
    def name(self) -> str:
        """Folder of the measurement's study."""
        return f"person-{self.person}-in-{self.laboratory}"

    def files(self, study: Laboratories) -> dict[str, str]:
        """Path -> text of the files of this measurement's study."""
        drawn = study.constants["drawn"] | study.coverage["drawn"] | study.coverage["sets"][RIGS]["drawn"]
        constants, standing = (
            draw_laboratory(study.constants | {"seed": _seed(name), "drawn": drawn})
            for name in (f"laboratory {self.laboratory}", f"person {self.person}")
        )
        standing, task = standing["standing"], standing["standing"]["tasks"][TASK]
        factor = Random(_seed(f"joints {self.person}")).uniform(*JOINTS)
        for key in ("stiffness_Nm_per_rad", "damping_Nms_per_rad"):
            task[key] = [factor * value for value in task[key]]
        task["short_range_Nm_per_rad"] *= factor
        seed, rate_hz = _seed(f"{self.name}, {self.attempt}"), constants["treadmill"]["capture"]["rate_hz"]
        return study.files_of(constants | {"standing": standing, "seed": seed}, seed, rate_hz)


def _seed(name: str) -> int:
    return Random(f"{SEED}/{name}").randrange(2**31)


def study_of_one() -> Laboratories:
    """The coverage study, of which a measurement keeps weights, empty belts and trials of one task."""
    config: dict = {}
    for path in ("config/config.yaml", "config/coverage/config.yaml"):
        update_config(config, yaml.safe_load((ROOT / path).read_text(encoding="utf-8")))
    compared = {f"standing.pathways.{pathway}" for pathway, _ in WAYS} | {"standing.estimators.as-printed"}
    left_out = config["coverage"]["left_out"]
    config["coverage"]["left_out"] = [entry for entry in left_out if entry not in compared]
    for name in [name for name in config["standing"]["estimators"] if name.startswith("free-reflex-gls-")]:
        del config["standing"]["estimators"][name]
    config["coverage"]["also_evaluated"] = []
    study = Laboratories(config)
    lines = study.sheet.splitlines()
    kept = ("experiment", "weight", "empty", "standing")
    lines = [line for line in lines if line.split("\t")[0] in kept]
    # cached, so that all measurements have it
    study.sheet = "\n".join(line for line in lines if not line.startswith("standing\tstiff")) + "\n"
    return study


def measure(measurement: Measurement, folder: Path) -> None:
    """Run the study of a measurement unless it is done, and keep its tables."""
    here = folder / measurement.name
    if all((here / f"{name}.csv").is_file() for name in TABLES):
        return
    for attempt in range(1, ATTEMPTS + 1):
        failed = run(replace(measurement, attempt=attempt).files(study_of_one()), here / "study")
        if "falls" not in failed:
            break
    if failed:
        raise SystemExit(f"{measurement.name}: {failed}")
    for name in TABLES:
        shutil.copyfile(here / f"study/results/tables/{name}.csv", here / f"{name}.csv")
    forget(here / "study")


def stiffness(measurement: Measurement, folder: Path) -> dict[tuple[str, str], tuple[float, float, bool]]:
    """Way -> K of the person, its truth (Nm/rad), and whether the estimate is flagged."""
    with open(folder / measurement.name / "recovery.csv", newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["condition"] == TASK and row["quantity"] == "K"]
    return {
        (row["pathway"], row["estimator"]): (float(row["value"]), float(row["truth"]), row["flags"] != "")
        for row in rows
        if (row["pathway"], row["estimator"]) in WAYS
    }


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return math.sqrt(float(np.mean(np.square(values))))


def table(found: dict[Measurement, dict]) -> list[str]:
    """Lines of the table: errors of K (Nm/rad) by way."""
    lines = [
        "| torque and fit | laboratory 1 | laboratory 2 | pairs in 1 | in 2 | smallest in 1 | in 2 | order "
        "in 1 | in 2 | flagged |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    shape = (PAIRS, 2, LABORATORIES)
    for way, words in WAYS.items():
        values = [
            found[Measurement(2 * pair + one + 1, laboratory + 1)][way]
            for pair in range(PAIRS)
            for one in range(2)
            for laboratory in range(LABORATORIES)
        ]
        k, truth, flagged = (np.array(part).reshape(shape) for part in zip(*values, strict=True))
        error = k - truth
        difference, true = k[:, 0] - k[:, 1], truth[:, 0] - truth[:, 1]
        one = (difference - true).ravel()
        # the first person in one laboratory, the second in the other, and the reverse
        crossed = np.stack([k[:, 0, 0] - k[:, 1, 1], k[:, 0, 1] - k[:, 1, 0]], axis=1)
        crossed_true = np.stack([truth[:, 0, 0] - truth[:, 1, 1], truth[:, 0, 1] - truth[:, 1, 0]], axis=1)
        two = (crossed - crossed_true).ravel()
        right = [
            np.count_nonzero(np.sign(measured) == np.sign(actual))
            for measured, actual in ((difference, true), (crossed, crossed_true))
        ]
        by_laboratory = " | ".join(
            f"{error[..., k].mean():+.0f} ± {error[..., k].std(ddof=1):.0f}" for k in range(LABORATORIES)
        )
        cells = [f"{rms(part):.0f}" for part in (one, two)] + [
            f"{1.96 * rms(part):.0f}" for part in (one, two)
        ]
        cells += [f"{count} of {one.size}" for count in right]
        cells.append(f"{np.count_nonzero(flagged)} of {flagged.size}")
        lines.append(f"| {words} | {by_laboratory} | {' | '.join(cells)} |")
    return lines


def main() -> None:
    """Measure every person in every laboratory, and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--folder", type=Path, default=ROOT / "results/two_laboratories")
    options = parser.parse_args()
    measurements = [
        Measurement(person, laboratory)
        for person in range(1, 2 * PAIRS + 1)
        for laboratory in range(1, LABORATORIES + 1)
    ]
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(options.cores, mp_context=spawn) as pool:
        list(pool.map(measure, measurements, [options.folder.resolve()] * len(measurements)))
    found = {measurement: stiffness(measurement, options.folder) for measurement in measurements}
    print("\n".join(table(found)))


if __name__ == "__main__":
    main()
