"""Torque-controlled manipulator (thesis sections 3-1-1 and 4-1-1)."""

from tepsipe.experiments.experiment import Experiment

EXPERIMENT = Experiment(
    name="wristalyzer",
    raw_files={"log": "log.txt", "command": "command.txt"},
    names={
        "time_column": "files.log_columns.time",
        "angle_column": "files.log_columns.angle",
        "trigger_column": "files.log_columns.trigger_time",
        "torque_column": "files.command_columns.torque",
        "command_time_column": "files.command_columns.time",
        "angle_unit": "files.angle_unit",
    },
    profiles=("multisine",),
    pulsed=False,
    cross_validated=True,
    budgets=True,
    thesis_tables={"table_4_1": ""},
    printed=(
        "ingest.resample_rate_hz",
        "analysis.lowpass_cutoff_hz",
        "analysis.lowpass_order",
        "analysis.cut_s",
        "analysis.averaged_bins",
        "analysis.fit_band_hz",
        "analysis.coherence_outside_root",
        "analysis.perturbation_period_s",
        "analysis.excited_band_hz",
        "analysis.start",
        "analysis.lower",
        "analysis.upper",
    ),
    true=(
        "wristalyzer.manipulator.inertia_kgm2",
        "wristalyzer.manipulator.contact_Nm_per_rad3",
        "wristalyzer.manipulator.friction_Nm",
        "dummy.rubber",
    ),
    ingest_reads=("files", "ingest"),
    fit_reads=("analysis", "-analysis.swept_bins"),
    fit_takes=("seed", "uncertainty"),
)
