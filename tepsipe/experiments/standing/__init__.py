"""A person standing on the treadmill (thesis sections 3-2 and 4-2).

The trial comes first: `options` are the person and the choices of the analysis, `stance` refuses trials with
steps, `joint_torque` computes joint angles and ankle torque from markers and force plate, and `epochs` cuts
the responses to single perturbations. `estimates` is the form of every fit to them.

Two estimators fit the responses, each a package that reads in its own order. `thesis` has the thesis's
method: intrinsic parameters and a parametric torque of the muscles, and the latencies of their reflexes.
`free_reflex` leaves the reflex torque free; it is the recommended estimate, with its uncertainty budget and
checks.
"""

from tepsipe.experiments.experiment import CHANNELS, TREADMILL_FILES, Experiment

EXPERIMENT = Experiment(
    name="standing",
    raw_files=TREADMILL_FILES | {"markers": "markers.c3d", "emg": "emg.edf"},
    optional_files=("emg",),
    profiles=("sine", "negative-sine"),
    at_random=True,
    of_people=True,
    on_plate=True,
    names=CHANNELS,
    tasks=("relax", "stiff"),
    budgets=True,
    printed=(
        "person.mass_kg",
        "person.stature_m",
        "files.marker_labels",
        "emg.band_hz",
        "emg.envelope_cutoff_hz",
        "pathways",
        "estimators",
        "latency.detector",
        "recommended",
    ),
    true=("standing.tasks", "standing.muscles"),
    purposes=("whole trial", "markers", "emg"),
    ingest_reads=("files", "muscles.*.channel", "ingest", "recording"),
    fit_reads=(
        "person",
        "belt",
        "stance",
        "emg",
        "ingest.max_gap_s",
        "analysis",
        "-analysis.tried_windows_s",
        "pathways",
        "as_printed",
        "recommended",
        "estimators",
        "active",
        "muscles.*.ankle_action",
        "free_reflex",
    ),
    fit_takes=("seed", "uncertainty", "models", "calibrations"),
    further=("responses",),
)
