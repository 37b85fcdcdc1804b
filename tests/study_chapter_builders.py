"""A run with few rows of the tables that every report may have, and the content of its report."""

import pandas as pd

from tepsipe.reporting.chapters import study
from tepsipe.reporting.run import Run, report_content

PROVENANCE = {
    "commit": "abc",
    "modified": False,
    "python": "3.13.0",
    "engine": None,
    "config_sha256": "f00",
    "seed": 1,
    "packages": {"numpy": "2.0"},
    "files": {"sheet": {"file": "a.tsv", "sha256": "ab"}},
    "raw_files": {},
}
CLAIM = {
    "claim": "K <",
    "where": "p. 3",
    "unit": "Nm/rad",
    "reported": 10.0,
    "reproduced": 9.0,
    "tolerance": "below",
    "verdict": "pattern",
    "section": "",
    "null_value": 10.0,
    "null_verdict": "not reproduced",
    "margin": "",
    "used": "a joint",
    "statements": "",
    "measure": "printed_stiffness_low",
}


def estimate(**changed):
    """Row of the estimates."""
    row = {"experiment": "position_manipulator", "condition": "trial1", "pathway": "leg", "estimator": "ls"}
    return (
        row
        | {
            "quantity": "K",
            "unit": "Nm/rad",
            "value": 9.0,
            "standard_error": 0.5,
            "recommended": False,
            "flags": "",
        }
        | changed
    )


def study_run(tables, provenance=None, **changed):
    """A run with rows of tables by name; ``changed`` are facts of its study."""
    about = {"title": "A study", "recordings_source": None, "made": {}, "reported": None}
    about |= {"experiments": {"position_manipulator": ["a", "b"]}} | changed
    frames = {"estimates": [estimate()], **tables}
    frames = {name: pd.DataFrame(rows) for name, rows in frames.items()}
    return Run(frames, {}, {}, about, PROVENANCE | (provenance or {}))


def study_content(run):
    """Content of report.json, and the tables as text."""
    text = {name: rows.to_csv(index=False) for name, rows in run.tables.items()}
    return report_content(run, {"study": study}), text
