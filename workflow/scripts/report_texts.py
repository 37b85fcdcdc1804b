"""Texts of the chapters that do not yet read tables themselves: one part of report.json."""

import pandas as pd

from tepsipe.experiments.dummy.specification_curve import read_specification
from tepsipe.experiments.position_manipulator.time_varying import read_varying
from tepsipe.experiments.thesis_dummy.tables import read_cells
from tepsipe.reporting.figures.names import short_name
from tepsipe.reporting.laboratory import read_laboratory
from tepsipe.reporting.ledger import read_ledger
from tepsipe.reporting.numbers import (
    abstract,
    dummy,
    figure_findings,
    laboratory,
    operating_points,
    planned,
    platform,
    position_manipulator,
    shown_signals,
    simulations,
    standing,
    study,
    summary,
    thesis_dummy,
    time_varying,
)
from tepsipe.reporting.numbers.ledger import cells_data
from tepsipe.reporting.planned import read_planned
from tepsipe.reporting.run import Run, about_study
from tepsipe.reporting.thesis_tables import read_table


def texts_of(run: Run, files: dict[str, str]) -> dict:
    """Numbers as text, of chapters that do not read tables themselves; ``files`` are those of the tables."""
    choices, fits, about = run.settings, run.fits, run.study
    experiments, provenance = about["experiments"], about["provenance"]
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

    amplitudes = about["amplitudes"]

    data = {
        **about_study(run),
        "slips": {},
        "reported": None if reported is None else study.reported_data(reported, about["start_stiffness"]),
        "claims": None if claims is None else study.claims_data(claims),
        "cells": cells_data(read_ledger(files["cells"])) if "cells" in files else None,
        "recovery": None if recovery is None else study.recovery_data(shown),
        "laboratory": None
        if recovery is None
        else laboratory.laboratory_data(read_laboratory(files["laboratory"])),
        "provenance": study.provenance_data(provenance),
        "flags": study.flags_data(estimates),
        "names": study.names_data(estimates, choices),
    }
    slips = [] if reported is None else reported["slips"]
    for table in (name for name in files if name.startswith("table_4_") and name != "table_4_4"):
        conditions, _ = read_table(files[table])
        names = [short_name(condition) for condition in conditions]
        data["slips"][table] = study.slips_data(slips, table, conditions, names)
    if "dummy" in experiments:
        data["dummy"] = dummy.dummy_data(fits["dummy"], estimates, choices["dummy"], recovery, amplitudes)
        data["dummy"]["belt"] = shown_signals.belt_signals(fits["dummy"])
        specifications = read_specification(files["specification"])
        data["dummy"]["specification"] = dummy.specification_data(specifications)
    if "thesis_dummy" in files:
        data["thesis_dummy"] = thesis_dummy.thesis_dummy_data(
            fits["thesis_dummy"]["thesis_dummy"], read_cells(files["thesis_dummy"])
        )
    if "planned" in files:
        data["planned"] = planned.planned_data(read_planned(files["planned"]), about["planned_joint"])
    if "forward" in files:
        forward = pd.read_csv(files["forward"], dtype=text_columns)
        data["simulation"] = simulations.forward_data(forward, about["step_s"], about["engine"]) | {
            "signals": shown_signals.simulated_signals(forward, about["simulated"])
        }
    if "noise" in files:
        columns, rows = read_table(files["table_4_4"])
        stiffness = choices["noise"]["joint"]["stiffness_Nm_per_rad"][0]
        figure_stiffness = choices["noise"]["joint"]["stiffness_Nm_per_rad"][-1]
        data["noise"] = simulations.noise_data(
            pd.read_csv(files["noise"], dtype=text_columns), choices["noise"]
        ) | {
            "shown": simulations.noise_shown(rows, figure_stiffness),
            "table": simulations.noise_table(
                [row for row in rows if row.pathway in ("as-printed", "as-tabulated", "recommended")],
                columns,
                stiffness,
            ),
        }
    if "standing" in experiments:
        task_fits = {task: fits["standing_tasks"][task] for task in about["tasks"]}
        data["standing"] = standing.standing_data(
            fits["standing"],
            task_fits,
            estimates,
            choices["standing"],
            recovery,
            about["people"],
        ) | {
            "signals": shown_signals.muscle_signals(
                fits["standing"], task_fits, choices["standing"]["latency"]["detector"]
            )
        }
    if "position_manipulator" in experiments:
        data["position_manipulator"] = position_manipulator.manipulator_data(
            fits["position_manipulator"], estimates, choices["position_manipulator"]["joint"]
        )
    if "platform" in experiments:
        data["platform"] = platform.platform_data(fits["platform"], estimates)
    if "operating_points" in files:
        text = {"participant": str, "condition": str}
        points, lines = (
            pd.read_csv(files[name], dtype=text) for name in ("operating_points", "operating_relations")
        )
        data["operating_points"] = operating_points.operating_points_data(points, lines)
    if "time_varying" in files:
        rows = read_varying(files["time_varying"])
        data["time_varying"] = time_varying.time_varying_data(rows, list(fits["position_manipulator"]))
    data["recommended_coverage"] = summary.covered_of_recommended(estimates, recovery)
    data["summary"] = summary.summary_of(data)
    data["abstract"] = abstract.abstract_of(data)
    data["warnings"] = abstract.warnings_of(data)
    data["figure_findings"] = figure_findings.figure_findings_of(data)
    return data
