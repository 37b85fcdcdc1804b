"""Table of the experiments, with all properties that the workflow needs before the first job.

A new experiment begins with an entry here. The trial sheet takes raw files and columns from this table, the
study takes tables and files, and the report takes the settings that it prints.
"""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Experiment:
    """Properties of an experiment.

    Its figures have captions below its name in report/captions.yaml, and ``draw`` of the module in
    tepsipe/reporting/figures with its name yields them.

    Attributes
    ----------
    raw_files : kind of raw file -> its name in the virtual laboratory, None if that makes none
        The kinds are columns of the trial sheet.
    optional_files : kinds of raw file that a recorded trial may lack.
    profiles : perturbation profiles of simulated trials.
    pulsed, at_random : whether perturbations are separate pulses, and whether their intervals may be a range.
    models : models of the treadmill that its trials calibrate or validate, or None.
    tasks : tasks of the simulated person, a recorded one may have any; empty if trials have no task.
    names : column of the sheet -> setting of the experiment that it overrides for its trial
        Names of a table's columns or of a file's channels, units and signs.
    named : those without such a setting, which every row must fill in.
    of_people : whether trials may name a participant.
    on_plate : whether trials are on a belt of the plate treadmill, left or right.
    fitted : whether each trial has its own fit and estimates.
    budgets : whether each fit writes an uncertainty budget.
    cross_validated : whether the parameters of each trial predict all trials.
    thesis_tables : table of the thesis -> common beginning of the names of its conditions.
    printed : settings that the report prints.
    true : constants of the laboratory, as the truth of the estimates.
    """

    raw_files: dict[str, str | None]
    optional_files: tuple[str, ...] = ()
    profiles: tuple[str, ...] = ()
    pulsed: bool = True
    at_random: bool = False
    models: str | None = None
    tasks: tuple[str, ...] = ()
    names: dict[str, str] = field(default_factory=dict)
    named: tuple[str, ...] = ()
    of_people: bool = False
    on_plate: bool = False
    fitted: bool = True
    budgets: bool = False
    cross_validated: bool = False
    thesis_tables: dict[str, str] = field(default_factory=dict)
    printed: tuple[str, ...] = ()
    true: tuple[str, ...] = ()


@dataclass(frozen=True)
class Part:
    """A part of a study without trials of its own, which needs the trials of several experiments.

    ``tables`` are those of the thesis that it needs, with conditions in the study. Its figures are found by
    its name, as for an experiment.
    """

    needs: tuple[str, ...]
    printed: tuple[str, ...] = ()
    tables: tuple[str, ...] = ()


PULSES = ("sine", "minjerk")
TREADMILL_FILES = {"log": "log.mat", "calibration": "calibration.csv"}
TABLE_OF_A_BELT = {
    "time_column": "files.columns.time",
    "load_column": "files.columns.load",
    "velocity_column": "files.columns.velocity",
}
# channels of a log that holds the whole trial
CHANNELS = {
    "velocity_column": "recording.belt_velocity.channel",
    "command_column": "recording.belt_command.channel",
    "trigger_column": "recording.trigger",
}

EXPERIMENTS = {
    "wristalyzer": Experiment(
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
    ),
    "dummy": Experiment(
        raw_files=TREADMILL_FILES | {"markers": "markers.c3d"},
        profiles=PULSES,
        of_people=True,
        on_plate=True,
        names=CHANNELS,
        cross_validated=True,
        budgets=True,
        thesis_tables={"table_4_2": "sine-", "table_4_3": "minjerk-"},
        printed=(
            "files.marker_labels",
            "ingest.resample_rate_hz",
            "ingest.max_gap_s",
            "ingest.marker_sampling_hz",
            "geometry.leg_mass_kg",
            "geometry.leg_com_m",
            "geometry.leg_inertia_kgm2",
            "geometry.foot_mass_kg",
            "geometry.foot_height_m",
            "geometry.gravity_m_per_s2",
            "analysis.lowpass_cutoff_hz",
            "analysis.lowpass_order",
            "analysis.rest_before_s",
            "analysis.rest_after_s",
            "analysis.threshold_fraction",
            "specification.command_s",
            "pathways",
            "foot.pathways",
            "as_printed",
            "recommended",
            "quoted",
        ),
        true=("dummy.rubber", "dummy.subject.joint_inertia_kgm2"),
    ),
    "weight": Experiment(
        raw_files=TREADMILL_FILES | {"markers": "markers.c3d"},
        profiles=(*PULSES, "negative-sine"),
        on_plate=True,
        names=CHANNELS,
        models="plate",
        budgets=True,
        printed=("weight.mass_kg", "analysis.cutoffs_hz", "analysis.segment_s"),
        true=("weight.mass_kg", "heavy_weight.mass_kg"),
    ),
    "empty": Experiment(
        raw_files=TREADMILL_FILES, profiles=PULSES, on_plate=True, names=CHANNELS, models="plate"
    ),
    "standing": Experiment(
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
    ),
    "belt": Experiment(
        raw_files={"log": None},
        models="belt",
        names=TABLE_OF_A_BELT,
        named=tuple(TABLE_OF_A_BELT),
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
    ),
    "position_manipulator": Experiment(
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
    ),
    "platform": Experiment(
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
    ),
    # a study of its own, with tables, figure and report of its own (workflow/studies/walking.smk)
    "walking": Experiment(
        raw_files={"log": "log.c3d", "events": "events.csv"},
        optional_files=("events",),
        profiles=("ramp",),
        fitted=False,
    ),
}

# Figures B-1 to B-12 are one per condition of the dummy, in the order of the trial sheet, with one caption
APPENDIX = tuple(f"figure_b_{number}" for number in range(1, 13))
OF_APPENDIX = "figure_b_trial"
PARTS = {
    # schematics of the thesis's rigs, and time lines of the trials
    "rigs": Part(("dummy",)),
    # the torque from the foot's side needs models of the force plate
    "foot": Part(("dummy", "weight")),
    # the dummy that the printed tables describe
    "thesis_dummy": Part(("dummy",), tables=("table_4_2", "table_4_3")),
    # simulations compare the parameters of both experiments with the dummy
    "simulation": Part(("wristalyzer", "dummy")),
    # all trials of the manipulator together, if they hold enough periods of the perturbation
    "wristalyzer_pooled": Part(("wristalyzer",)),
    # any experiment whose trials have uncertainty budgets
    "budgets": Part(()),
    # any experiment whose trials name participants
    "participants": Part(()),
    # at least two trials
    "operating_points": Part(("position_manipulator",)),
    # if the configuration wants it
    "time_varying": Part(("position_manipulator",)),
    "noise": Part(
        ("wristalyzer", "dummy"),
        printed=("joint", "table_snr_db", "draws", "table_estimators"),
    ),
}
