"""A toy: a spring that is bent, with its angle and torque in a table."""

from tepsipe.experiments.experiment import Experiment

EXPERIMENT = Experiment(
    name="toy",
    raw_files={"log": None},
    pulsed=False,
    settings="ingest.Settings",
    ingest_reads=("ingest",),
    fit_reads=("analysis",),
    drawn_of=("fits", "estimates"),
    printed=("analysis.cut_s",),
)
