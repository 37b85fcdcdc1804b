"""Parts of every report: estimates to quote, the meaning of checks, and provenance."""

import hashlib
from collections.abc import Iterable, Mapping

import pandas as pd

from tepsipe.io.estimates import FLAGS
from tepsipe.reporting.run import Run

# facts of the record of provenance that reports print
PRINTED = ("commit", "modified", "python", "engine", "config_sha256", "seed", "packages")


def numbers(run: Run) -> dict:
    """Provenance with checksums of lists of files, and the meaning of every check (no units)."""
    return {"provenance": provenance_of(run.provenance), "flags": FLAGS}


def provenance_of(record: Mapping) -> dict:
    """Part of a record of provenance (no units) that reports print, one checksum for each kind of file."""
    files = list(record["files"].values())
    raw = [entry for kinds in record["raw_files"].values() for entry in kinds.values()]
    return {name: record[name] for name in PRINTED} | {
        "files": {kind: entry["file"] for kind, entry in record["files"].items()},
        "digests": [
            {"of": "Files of the study", "files": len(files), "sha256": digest_of(files)},
            {"of": "Raw files", "files": len(raw), "sha256": digest_of(raw)},
        ],
    }


def digest_of(entries: Iterable[dict]) -> str:
    """SHA-256 over the lines ``<sha256>  <file>`` (no unit) of some files, sorted.

    The same as ``sha256sum FILES | sort | sha256sum`` in the folder of the study.
    """
    lines = sorted(f"{entry['sha256']}  {entry['file']}\n" for entry in entries)
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def _recommended(run: Run) -> pd.DataFrame:
    """Estimates to quote."""
    estimates = run.tables["estimates"]
    return estimates[estimates.recommended.astype(str).str.lower() == "true"]


# ---- conditions of sentences


def truth_of_recommended_known(run: Run) -> bool:
    """The study reproduces the thesis with the dummy, and the truth of recommended estimates is known."""
    if run.study["reported"] is None or "dummy" not in run.study["experiments"]:
        return False
    keys = ["experiment", "condition", "pathway", "estimator", "quantity"]
    return "recovery" in run.tables and len(_recommended(run).merge(run.tables["recovery"], on=keys)) > 0


def recommended_flagged(run: Run) -> bool:
    """A recommended estimate failed a check."""
    return bool((_recommended(run)["flags"].fillna("") != "").any())


PREDICATES = (truth_of_recommended_known, recommended_flagged)
