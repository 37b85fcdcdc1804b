"""Parts of every report: estimates to quote, those that miss the truth, checks, provenance."""

import hashlib
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict

import numpy as np
import pandas as pd

from tepsipe.io.estimates import AT_WORK, FLAGS
from tepsipe.reporting.budgets import SOURCES
from tepsipe.reporting.ledger import (
    IMPLIED,
    NOISE_TABLE,
    TABULATED,
    WITHIN,
    best_sem_reading,
    cells_of_table,
    noise_cells,
    sem_distances,
)
from tepsipe.reporting.run import Run
from tepsipe.reporting.thesis_tables import TableRow
from tepsipe.statistics.least_squares import SEM_READINGS
from tepsipe.statistics.uncertainty import SCATTER

KEYS = ["experiment", "condition", "pathway", "estimator", "quantity"]
# source of a budget -> drawn constant of the laboratory, where their names differ
DRAWN_AS = {
    "marker_scale": "treadmill.capture.length_scale",
    "clock_ratio": "treadmill.capture.clock_ppm",
    "marker_sampling_s": "treadmill.capture.marker_sampling_hz",
    "moment_scale": "treadmill.plate.force_scale",
    "joint_centre_anterior_m": "standing.markers.joint_centre_m.0",
    "joint_centre_height_m": "standing.markers.joint_centre_m.1",
}

# kind of a printed number -> rows of the tables; tables of the dummy, and the one whose null copies another
KINDS = {
    "I, B and K": ("I", "B", "K"),
    "SEM": ("SEM_I", "SEM_B", "SEM_K"),
    "VAF": (
        *("VAF_trial", "VAF_perturbation", "VAF_cross_validated"),
        *("VAF_theta_perturbation", "VAF_theta_trial"),
    ),
}
DUMMY_TABLES, COPIED_TABLE = ("table_4_2", "table_4_3"), "table_4_3"

# facts of the record of provenance that reports print
PRINTED = ("commit", "modified", "python", "engine", "config_sha256", "seed", "packages")


def numbers(run: Run) -> dict:
    """Provenance, checks, missed truths, signs of errors, SEMs, scores (units in the keys)."""
    return {
        "provenance": provenance_of(run.provenance),
        "flags": FLAGS,
        "missed": missed(run),
        "one_sided": one_sided(run),
        "sem": sem(run),
        "scores": scores(run),
    }


def sem(run: Run) -> dict:
    """Readings of eq (3-2) with their meaning, their distances from the printed SEMs, and the nearest one."""
    reported, values = (run.study.get("reported") or {}).get("tables", {}), {}
    for table in reported:
        frame = run.rows(table)
        rows = [TableRow(*row[:4], list(row[4::2]), list(row[5::2])) for row in frame.itertuples(index=False)]
        if table == NOISE_TABLE:
            values |= noise_cells(rows, TABULATED)
        else:
            values |= cells_of_table(table, rows, list(frame.columns[4::2]))
    distances = sem_distances(values, reported)
    found = {"readings": SEM_READINGS, "best": best_sem_reading(distances)}
    return found | {"distances": [asdict(one) for one in distances]}


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
    return estimates[_true(estimates.recommended)]


def _true(cells: pd.Series) -> pd.Series:
    return cells.astype(str).str.lower() == "true"


def _compared(run: Run) -> pd.DataFrame:
    """Estimates to quote that have a truth, beside it."""
    if "recovery" not in run.tables:
        return pd.DataFrame()
    truth = run.tables["recovery"][[*KEYS, "truth", "relative_error", "covered"]]
    return _recommended(run).merge(truth, on=KEYS)


# ---- estimates that miss the truth


def missed(run: Run) -> list[dict]:
    """Recommended estimates whose 95 % interval misses the truth, and how far draws explain the error.

    The reason is read by the comparison with the truth: a source of the budget that was drawn at d standard
    deviations contributes at most abs(d) times its uncertainty to the error.

    Returns: keys of the estimate; ``error_percent``; ``error_over_u``, the error in combined standard
    uncertainties (-); ``source``, the drawn source with the largest contribution in words, None without
    one; ``drawn_sd``, its draw in standard deviations (-); ``share_percent``, its largest part of the
    error; ``rest_over_u``, the rest of the error in standard uncertainties of the other sources (-).
    """
    found = _compared(run)
    return [_miss(run, row) for _, row in found[~_true(found.covered)].iterrows()] if len(found) else []


def _miss(run: Run, row: pd.Series) -> dict:
    error = row.relative_error * row.truth
    budget = run.rows("uncertainty", **{key: row[key] for key in KEYS})
    u = dict(zip(budget.source, budget.u, strict=True)) if len(budget) else {}
    draws = {name: _draw(run, row.experiment, name) for name in u if name != SCATTER}
    parts = {name: abs(d) * u[name] for name, d in draws.items() if d is not None and d * u[name] != 0.0}
    largest = max(parts, key=parts.__getitem__) if parts else None
    rest = max(0.0, abs(error) - parts.get(largest, 0.0))
    others = math.sqrt(sum(own**2 for name, own in u.items() if name != largest))
    return {
        **row[KEYS].to_dict(),
        "error_percent": 100.0 * row.relative_error,
        "error_over_u": error / row.standard_error if row.standard_error > 0.0 else math.nan,
        "source": SOURCES.get(largest, largest),
        "drawn_sd": draws.get(largest),
        "share_percent": min(100.0, 100.0 * parts[largest] / abs(error)) if largest else 0.0,
        "rest_over_u": rest / others if others > 0.0 else math.nan,
    }


def _draw(run: Run, experiment: str, source: str) -> float | None:
    """Draw of a source of the budget in standard deviations (-); None if the laboratory does not draw it."""
    constants = run.rows("laboratory", kind="drawn")
    if not len(constants):
        return None
    parts = (experiment, "treadmill")
    own = constants.key.str.split(".").str[0].isin(parts) & constants.key.str.endswith(f".{source}")
    rows = constants[own | (constants.key == DRAWN_AS.get(source))]
    if not len(rows):
        return None
    row = rows.iloc[0]
    return float((float(row.value) - float(row.nominal)) / float(row.standard_deviation))


def one_sided(run: Run) -> list[dict]:
    """Groups of recommended estimates, one per trial, whose errors all have the same sign (%).

    A draw that all trials share, for example of the leg's mass, moves all of them alike.
    """
    compared = _compared(run)
    if not len(compared):
        return []
    groups = []
    for (experiment, pathway, estimator, quantity), rows in compared.groupby(
        ["experiment", "pathway", "estimator", "quantity"], sort=False
    ):
        errors = 100.0 * rows.relative_error.to_numpy(float)
        if len(errors) >= 5 and abs(np.sign(errors).sum()) == len(errors):
            ends = {"low_percent": float(errors.min()), "high_percent": float(errors.max()), "n": len(errors)}
            names = {"experiment": experiment, "pathway": pathway, "estimator": estimator}
            groups.append(names | {"quantity": quantity} | ends)
    return groups


# ---- scores of printed cells


def scores(run: Run) -> dict | None:
    """Number of printed cells within their tolerance, of the run and of the null model.

    Returns: ``kinds``, for I, B and K, SEM and VAF the kind, ``all`` cells, those ``within`` in the run and
    those by the ``null`` model; ``dummy``, the same for I, B and K of Tables 4-2 and 4-3; ``run_alone``,
    number of all cells that are within in the run but not by the null model; ``means``, number of rows of
    which the null model is the mean. None if the study has no cells.
    """
    cells = run.rows("cells")
    if not len(cells):
        return None
    of_dummy = cells[cells.table.isin(DUMMY_TABLES) & cells.row.isin(KINDS["I, B and K"])]
    within = cells.verdict.isin(WITHIN)
    return {
        "kinds": [_score(kind, cells[cells.row.isin(rows)]) for kind, rows in KINDS.items()],
        "dummy": _score("I, B and K", of_dummy),
        "run_alone": int((within & (cells.null_verdict != IMPLIED)).sum()),
        "means": int((cells.drop_duplicates(["table", "row"]).table != COPIED_TABLE).sum()),
    }


def _score(kind: str, cells: pd.DataFrame) -> dict:
    return {
        "kind": kind,
        "all": len(cells),
        "within": int(cells.verdict.isin(WITHIN).sum()),
        "null": int((cells.null_verdict == IMPLIED).sum()),
    }


# ---- conditions of sentences


def null_ahead(run: Run) -> bool:
    """For I, B and K, for SEM and for VAF, the null model is within the tolerance of more cells."""
    found = scores(run)
    return found is not None and all(one["null"] > one["within"] for one in found["kinds"])


def truth_missed(run: Run) -> bool:
    """The interval of a recommended estimate misses the truth."""
    return len(missed(run)) > 0


def errors_share_draw(run: Run) -> bool:
    """All errors of a recommended quantity have the same sign."""
    return len(one_sided(run)) > 0


def truth_differs(run: Run) -> bool:
    """The true K in the fitted windows differs by more than 1 % between trials of some estimator."""
    rows = run.rows("recovery", truth_of=AT_WORK, quantity="K")
    if not len(rows):
        return False
    truths = rows.groupby(["experiment", "estimator"]).truth
    return bool((truths.max() - truths.min() > 0.01 * truths.mean().abs()).any())


PREDICATES = (null_ahead, truth_missed, errors_share_draw, truth_differs)
