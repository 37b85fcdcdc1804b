"""A person standing on a moving platform: impedance of ankle and hip."""

from tepsipe.experiments.experiment import Experiment

EXPERIMENT = Experiment(
    name="platform",
    raw_files={"log": None},
    of_people=True,
    pulsed=False,
    names={
        "time_column": "files.columns.time",
        "angle_unit": "files.angle_unit",
        "torque_sign": "files.torque_sign",
    },
    printed=(
        "ingest.resample_rate_hz",
        "analysis.band_hz",
        "analysis.averaged_bins",
        "analysis.delays_s",
        "analysis.strength",
        "analysis.largest_share",
        "analysis.mode_below_hz",
        "analysis.rejected_below",
        "analysis.training_fraction",
    ),
    ingest_reads=("files", "ingest"),
    fit_reads=("analysis",),
    drawn_of=("fits", "estimates"),
)
