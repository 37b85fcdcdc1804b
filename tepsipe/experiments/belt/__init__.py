"""A recorded treadmill without a rig: models of its belt-induced load."""

from tepsipe.experiments.experiment import Experiment

# every row of the sheet names the columns of its table
COLUMNS = {
    "time_column": "files.columns.time",
    "load_column": "files.columns.load",
    "velocity_column": "files.columns.velocity",
}

EXPERIMENT = Experiment(
    name="belt",
    raw_files={"log": None},
    models="belt",
    names=COLUMNS,
    named=tuple(COLUMNS),
    fitted=False,
    printed=(
        "chosen",
        "analysis.shown_cutoff_hz",
        "analysis.lowpass_order",
        "analysis.zero_lag",
        "analysis.trimmed_s",
        "models.fir_lead_s",
        "models.ripple.memory_s",
    ),
    ingest_reads=("files", "ingest"),
)
