"""Gather every number and figure of the run, and typeset the report."""

import job

job.start(snakemake)

import json
from operator import methodcaller
from pathlib import Path

import pandas as pd
from typeset import typeset

from tepsipe.experiments.dummy.specification_curve import SPECIFICATIONS
from tepsipe.experiments.position_manipulator.time_varying import VARYING_ROWS
from tepsipe.experiments.thesis_dummy.tables import CELL_ROWS
from tepsipe.io.budget_table import CONTRIBUTIONS
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import read_result
from tepsipe.reporting.figures.names import short_name
from tepsipe.reporting.laboratory import LABORATORY_ROWS
from tepsipe.reporting.ledger import CELL_VERDICTS
from tepsipe.reporting.numbers import (
    abstract,
    budget,
    dummy,
    figure_findings,
    laboratory,
    operating_points,
    participants,
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
    treadmill,
    wristalyzer,
)
from tepsipe.reporting.numbers.ledger import cells_data
from tepsipe.reporting.planned import PLANNED_ROWS
from tepsipe.reporting.thesis_tables import read_table
from tepsipe.treadmill.calibration import MODEL_SCORES

choices, experiments = snakemake.params.choices, snakemake.params.experiments
fits, paths = {}, iter(snakemake.input.fits)
for experiment, conditions in snakemake.params.fitted.items():
    fits[experiment] = {condition: read_result(next(paths)) for condition in conditions}
text_columns = {"condition": str}
estimates = pd.read_csv(snakemake.input.estimates, dtype=text_columns)
provenance = json.loads(Path(snakemake.input.provenance).read_text(encoding="utf-8"))
recovery = claims = None
reported = snakemake.params.reported or None
if snakemake.input.recovery:
    recovery = shown = pd.read_csv(snakemake.input.recovery[0], dtype=text_columns)
    # of the standing person, whose chapter says more: the recommended torque, and latencies as they are used
    of_person, person = recovery.experiment == "standing", choices.get("standing")
    if person:
        own = recovery.pathway == person["recommended"]["pathway"]
        own |= recovery.estimator == person["latency"]["detector"]
        shown = recovery[~of_person | own]
if snakemake.input.claims:
    claims = pd.read_csv(snakemake.input.claims[0])

amplitudes = snakemake.params.amplitudes

data = {
    "title": snakemake.params.title,
    "recordings_source": snakemake.params.recordings_source,
    "experiments": list(experiments),
    "made": sum(len(names) for names in snakemake.params.made.values()),
    "trials": sum(len(names) for names in experiments.values()),
    "tables": {},
    "slips": {},
    "reported": None if reported is None else study.reported_data(reported, snakemake.params.start_stiffness),
    "claims": None if claims is None else study.claims_data(claims),
    "cells": cells_data(CELL_VERDICTS.read(*snakemake.input.cells)) if snakemake.input.cells else None,
    "recovery": None if recovery is None else study.recovery_data(shown),
    "laboratory": None
    if recovery is None
    else laboratory.laboratory_data(LABORATORY_ROWS.read(snakemake.input.recovery[1])),
    "provenance": study.provenance_data(provenance),
    "flags": study.flags_data(estimates),
    "names": study.names_data(estimates, choices),
    "budgets": budget.budgets_data(
        CONTRIBUTIONS.read(snakemake.input.uncertainty),
        ESTIMATES.read(snakemake.input.estimates),
        snakemake.params.foot_pathway,
    ),
    "choices": choices,
}
flagged = study.flagged_cells(estimates)
slips = [] if reported is None else reported["slips"]
for path in snakemake.input.tables:
    conditions, rows = read_table(path)
    names = [short_name(condition) for condition in conditions]
    table = Path(path).stem
    data["tables"][table] = study.table_data(rows, conditions, names, flagged)
    data["slips"][table] = study.slips_data(slips, table, conditions, names)
if "wristalyzer" in experiments:
    data["wristalyzer"] = wristalyzer.wristalyzer_data(
        fits["wristalyzer"], estimates, choices["wristalyzer"], snakemake.params.best
    ) | {
        "signals": shown_signals.manipulator_signals(
            fits["wristalyzer"],
            snakemake.params.best,
            choices["wristalyzer"]["analysis"]["lowpass_cutoff_hz"],
        )
    }
    if snakemake.input.pooled:
        data["wristalyzer"]["pooled"] = wristalyzer.pooled_data(
            read_result(snakemake.input.pooled[0]), estimates, recovery
        )
if "dummy" in experiments:
    data["dummy"] = dummy.dummy_data(fits["dummy"], estimates, choices["dummy"], recovery, amplitudes)
    data["dummy"]["belt"] = shown_signals.belt_signals(fits["dummy"])
    specifications = SPECIFICATIONS.read(snakemake.input.specification[0])
    data["dummy"]["specification"] = dummy.specification_data(specifications)
if snakemake.input.thesis_dummy:
    found, cells = snakemake.input.thesis_dummy
    data["thesis_dummy"] = thesis_dummy.thesis_dummy_data(read_result(found), CELL_ROWS.read(cells))
if snakemake.input.planned:
    data["planned"] = planned.planned_data(
        PLANNED_ROWS.read(snakemake.input.planned[0]), snakemake.params.planned_joint
    )
if snakemake.input.forward:
    forward = pd.read_csv(snakemake.input.forward[0], dtype=text_columns)
    data["simulation"] = simulations.forward_data(
        forward, snakemake.params.step_s, snakemake.params.engine
    ) | {"signals": shown_signals.simulated_signals(forward, snakemake.params.simulated)}
if snakemake.input.noise:
    noise, table = snakemake.input.noise
    columns, rows = read_table(table)
    stiffness = choices["noise"]["joint"]["stiffness_Nm_per_rad"][0]
    figure_stiffness = choices["noise"]["joint"]["stiffness_Nm_per_rad"][-1]
    data["noise"] = simulations.noise_data(pd.read_csv(noise, dtype=text_columns), choices["noise"]) | {
        "shown": simulations.noise_shown(rows, figure_stiffness),
        "table": simulations.noise_table(
            [row for row in rows if row.pathway in ("as-printed", "as-tabulated", "recommended")],
            columns,
            stiffness,
        ),
    }
if "weight" in experiments:
    plate, scores = snakemake.input.plate
    data["weight"] = treadmill.weight_data(
        fits, read_result(plate), MODEL_SCORES.read(scores), estimates, choices["weight"]
    ) | {"belt": snakemake.params.belt_of_models}
if "weight" in experiments and "dummy" in experiments:
    data["foot"] = treadmill.foot_data(estimates, choices["dummy"], recovery, amplitudes)
if "standing" in experiments:
    task_fits = dict(zip(snakemake.params.tasks, map(read_result, snakemake.input.tasks), strict=True))
    data["standing"] = standing.standing_data(
        fits["standing"],
        task_fits,
        estimates,
        choices["standing"],
        recovery,
        snakemake.params.people,
    ) | {
        "signals": shown_signals.muscle_signals(
            fits["standing"], task_fits, choices["standing"]["latency"]["detector"]
        )
    }
if snakemake.input.participants:
    text = {"participant": str, "condition": str}
    people, group = (pd.read_csv(path, dtype=text) for path in snakemake.input.participants)
    data["participants"] = participants.participants_data(
        people, group, snakemake.params.shown_of_participants
    )
if "belt" in experiments:
    calibration, scores = snakemake.input.belt
    data["belt"] = treadmill.treadmill_data(
        read_result(calibration), MODEL_SCORES.read(scores), choices["belt"], snakemake.params.roles
    )
if "position_manipulator" in experiments:
    data["position_manipulator"] = position_manipulator.manipulator_data(
        fits["position_manipulator"], estimates, choices["position_manipulator"]["joint"]
    )
if "platform" in experiments:
    data["platform"] = platform.platform_data(fits["platform"], estimates)
if snakemake.input.operating_points:
    text = {"participant": str, "condition": str}
    points, lines = (pd.read_csv(path, dtype=text) for path in snakemake.input.operating_points)
    data["operating_points"] = operating_points.operating_points_data(points, lines)
if snakemake.input.time_varying:
    rows = VARYING_ROWS.read(snakemake.input.time_varying[0])
    data["time_varying"] = time_varying.time_varying_data(rows, list(fits["position_manipulator"]))
data["recommended_coverage"] = summary.covered_of_recommended(estimates, recovery)
data["summary"] = summary.summary_of(data)
data["source"], data["abstract"] = abstract.source_of(data), abstract.abstract_of(data)
data["warnings"] = abstract.warnings_of(data)
data["figure_findings"] = figure_findings.figure_findings_of(data)
Path(snakemake.output.data).write_text(
    # a comparison of numbers from a table is numpy's truth value
    json.dumps(data, indent=1, ensure_ascii=False, default=methodcaller("item")) + "\n",
    encoding="utf-8",
)

folder = snakemake.params.source_folder
files = {str(Path(source).relative_to(folder)): source for source in snakemake.input.source}
files |= {f"figures/{Path(figure).name}": figure for figure in snakemake.input.figures}
files["report.json"] = snakemake.output.data
typeset(files, "report.typ", snakemake.output.pdf)
