"""Texts of the chapters that do not yet read tables themselves: one part of report.json."""

import pandas as pd

from tepsipe.reporting.figures.names import short_name
from tepsipe.reporting.laboratory import LABORATORY_ROWS
from tepsipe.reporting.ledger import CELL_VERDICTS
from tepsipe.reporting.numbers import (
    abstract,
    laboratory,
    study,
    summary,
)
from tepsipe.reporting.numbers.ledger import cells_data
from tepsipe.reporting.run import Run, about_study
from tepsipe.reporting.thesis_tables import read_table


def texts_of(run: Run, files: dict[str, str]) -> dict:
    """Numbers as text, of chapters that do not read tables themselves; ``files`` are those of the tables."""
    choices, about = run.settings, run.study
    provenance = about["provenance"]
    text_columns = {"condition": str}
    estimates = pd.read_csv(files["estimates"], dtype=text_columns)
    recovery = claims = None
    reported = about["reported"]
    if "recovery" in files:
        recovery = shown = pd.read_csv(files["recovery"], dtype=text_columns)
        # of the standing person, whose chapter says more: the recommended torque, and the latencies used
        of_person, person = recovery.experiment == "standing", choices.get("standing")
        if person:
            own = recovery.pathway == person["recommended"]["pathway"]
            own |= recovery.estimator == person["latency"]["detector"]
            shown = recovery[~of_person | own]
    if "claims" in files:
        claims = pd.read_csv(files["claims"])

    data = {
        **about_study(run),
        "slips": {},
        "reported": None if reported is None else study.reported_data(reported, about["start_stiffness"]),
        "claims": None if claims is None else study.claims_data(claims),
        "cells": cells_data(CELL_VERDICTS.read(files["cells"])) if "cells" in files else None,
        "recovery": None if recovery is None else study.recovery_data(shown),
        "laboratory": None
        if recovery is None
        else laboratory.laboratory_data(LABORATORY_ROWS.read(files["laboratory"])),
        "provenance": study.provenance_data(provenance),
        "flags": study.flags_data(estimates),
        "names": study.names_data(estimates, choices),
    }
    slips = [] if reported is None else reported["slips"]
    for table in (name for name in files if name.startswith("table_4_") and name != "table_4_4"):
        conditions, _ = read_table(files[table])
        names = [short_name(condition) for condition in conditions]
        data["slips"][table] = study.slips_data(slips, table, conditions, names)
    data["recommended_coverage"] = summary.covered_of_recommended(estimates, recovery)
    data["summary"] = summary.summary_of(data)
    data["abstract"] = abstract.abstract_of(data)
    data["warnings"] = abstract.warnings_of(data)
    return data
