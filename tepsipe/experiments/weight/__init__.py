"""A weight on the belt, or nothing: belt-induced force (thesis sections 2-1-2 and 4-1-2)."""

from tepsipe.experiments.experiment import CHANNELS, PULSES, TREADMILL_FILES, Experiment

WEIGHT = Experiment(
    name="weight",
    raw_files=TREADMILL_FILES | {"markers": "markers.c3d"},
    profiles=(*PULSES, "negative-sine"),
    on_plate=True,
    names=CHANNELS,
    models="plate",
    budgets=True,
    printed=("weight.mass_kg", "further_weights", "analysis.cutoffs_hz", "analysis.segment_s"),
    true=("weight.mass_kg", "heavy_weight.mass_kg"),
    purposes=("whole trial", "markers"),
    ingest_reads=("files", "ingest", "recording"),
    fit_reads=("weight", "belt", "analysis"),
    fit_takes=("uncertainty",),
)

EMPTY = Experiment(
    name="empty",
    folder="weight",
    raw_files=TREADMILL_FILES,
    profiles=PULSES,
    on_plate=True,
    names=CHANNELS,
    models="plate",
    purposes=("whole trial", "markers"),
    ingest_reads=("ingest", "recording"),
    fit_reads=WEIGHT.fit_reads,
    fit_takes=WEIGHT.fit_takes,
)
