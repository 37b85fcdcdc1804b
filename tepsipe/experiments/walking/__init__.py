"""Impedance of the ankle in the stance phase of walking, by belt pulses at random strides."""

from tepsipe.experiments.experiment import Experiment

EXPERIMENT = Experiment(
    name="walking",
    raw_files={"log": "log.c3d", "events": "events.csv"},
    optional_files=("events",),
    profiles=("ramp",),
    fitted=False,
    purposes=("whole trial",),
)
