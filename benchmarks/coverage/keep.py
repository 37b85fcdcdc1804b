"""Keep the tables of a coverage campaign: ``python benchmarks/coverage/keep.py [results/coverage]``.

Copies the tables of coverage, dropped sources, flags and laboratories into this folder, and writes commit,
date, checksum of the laboratory's constants, seed, the number of laboratories and the conditions of findings
that hold to ``campaign.json``. The report of the thesis's study quotes both.
"""

import csv
import json
import shutil
import sys
from datetime import date
from hashlib import sha256
from pathlib import Path

TABLES = ("coverage", "dropped", "flags", "laboratories")
HERE = Path(__file__).parent
# of the checkout that the campaign ran in
LABORATORY = HERE.parents[1] / "config/virtual_lab.yaml"


def keep(results: Path, target: Path = HERE) -> dict:
    """Copy the tables; return what is written to ``campaign.json``."""
    for name in TABLES:
        shutil.copyfile(results / f"tables/{name}.csv", target / f"{name}.csv")
    written = results / "report/coverage.json"
    report = json.loads(written.read_text(encoding="utf-8"))
    with open(target / "laboratories.csv", newline="", encoding="utf-8") as file:
        laboratories = list(csv.DictReader(file))
    study = report["study"]
    about = {
        **study["code"],
        "date": date.fromtimestamp(written.stat().st_mtime).isoformat(),
        "virtual_lab_sha256": sha256(LABORATORY.read_bytes()).hexdigest(),
        "seed": study["seed"],
        "laboratories": len(laboratories),
        "failed": sum(row["failed"] != "" for row in laboratories),
        "findings": [name for name, holds in report["chapters"]["coverage"]["holds"].items() if holds],
    }
    text = json.dumps(about, indent=1, ensure_ascii=False) + "\n"
    (target / "campaign.json").write_text(text, encoding="utf-8")
    return about


if __name__ == "__main__":
    print(json.dumps(keep(Path(*sys.argv[1:] or ["results/coverage"])), indent=1, ensure_ascii=False))
