"""Texts of the standing person, whose chapter does not yet read tables itself: one part of report.json."""

import pandas as pd

from tepsipe.reporting.numbers import abstract, figure_findings, shown_signals, standing, summary
from tepsipe.reporting.run import Run


def texts_of(run: Run, files: dict[str, str]) -> dict:
    """Numbers of the standing person as text; ``files`` are those of the tables."""
    about = run.study
    if "standing" not in about.get("experiments", ()):
        return {}
    text_columns = {"condition": str}
    estimates = pd.read_csv(files["estimates"], dtype=text_columns)
    recovery = pd.read_csv(files["recovery"], dtype=text_columns) if "recovery" in files else None
    fits, choices = run.fits, run.settings["standing"]
    tasks = {task: fits["standing_tasks"][task] for task in about["tasks"]}
    person = standing.standing_data(fits["standing"], tasks, estimates, choices, recovery, about["people"])
    signals = shown_signals.muscle_signals(fits["standing"], tasks, choices["latency"]["detector"])
    data = {"standing": person | {"signals": signals}, "reported": about["reported"]}
    data |= {"experiments": about["experiments"]}
    return data | {
        "summary": summary.summary_of(data),
        "abstract": abstract.abstract_of(data),
        "figure_findings": figure_findings.figure_findings_of(data),
    }
