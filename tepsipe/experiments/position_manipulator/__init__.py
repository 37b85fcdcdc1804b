"""A human joint in a position-controlled manipulator."""

from tepsipe.experiments.experiment import Experiment

EXPERIMENT = Experiment(
    name="position_manipulator",
    raw_files={"log": None},
    of_people=True,
    names={
        "time_column": "files.columns.time",
        "angle_column": "files.columns.angle",
        "torque_column": "files.columns.torque",
        "schedule_column": "files.columns.schedule",
        "trigger_column": "files.columns.trigger",
        "angle_unit": "files.angle_unit",
        "torque_sign": "files.torque_sign",
    },
    printed=(
        "joint.name",
        "joint.positive",
        "joint.negative",
        "ingest.resample_rate_hz",
        "analysis.lowpass_cutoff_hz",
        "analysis.cut_s",
        "analysis.training_fraction",
        "analysis.block_s",
        "analysis.parallel_cascade.intrinsic_lag_s",
        "analysis.parallel_cascade.relaxation_times_s",
        "analysis.parallel_cascade.reflex_length_s",
        "time_varying.window_s",
        "time_varying.segment_s",
        "time_varying.piece_s",
    ),
    ingest_reads=("files", "ingest"),
    drawn_of=("fits",),
    fit_reads=("analysis",),
    fit_takes=("seed",),
)
