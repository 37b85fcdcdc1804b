# Checks and look-ups that the rules share. No rule stands here.

import compileall
import os
import sys
import time
from pathlib import Path

sys.path.insert(0, workflow.basedir)

from tepsipe.errors import InputError
from workflow.support.check import (
    check_against_schema,
    check_config,
    check_one_treadmill,
    check_plate_models,
    load_yaml,
)
from workflow.support.reach import reached_by
from workflow.support.settings import settings_of
from workflow.support.trial_sheet import RAW_FILES, read_trial_sheet
from workflow.support.version import code_version

# bytecode once, not once per job: some environments keep Python from writing it
compileall.compile_dir(Path(workflow.basedir) / "tepsipe", quiet=2)

STARTED = time.time()
SCHEMAS = Path(workflow.basedir) / "workflow" / "schemas"


def checked_trials():
    """Check every file of the configuration, then read the trial sheet."""
    load_yaml(Path(workflow.basedir) / "config" / "config.yaml")
    check_against_schema(config, SCHEMAS / "config.schema.yaml", "configuration")
    check_config(config, "configuration")
    study = config["study"]
    for key in ("virtual_lab", "reported"):
        if study[key] is not None:
            check_against_schema(load_yaml(study[key]), SCHEMAS / f"{key}.schema.yaml", study[key])
    trials = read_trial_sheet(study["trial_sheet"], study["recordings_folder"])
    for (experiment, condition), row in trials.items():
        if row.source == "virtual_lab" and study["virtual_lab"] is None:
            raise InputError(
                f"{study['trial_sheet']}: expected recordings only, because study.virtual_lab is "
                f"null, found {experiment}/{condition} to be made: name its files"
            )
    experiments = {experiment for experiment, _ in trials}
    check_one_treadmill(config, experiments, "configuration")
    if "standing" in experiments and "weight" not in experiments:
        check_plate_models(config, "configuration")
    for there, missing in (("weight", "empty"), ("empty", "weight")):
        if there in experiments and missing not in experiments:
            raise InputError(
                f"{study['trial_sheet']}: expected trials of {missing} beside those of {there}, found none: "
                "models of the treadmill need the empty belt and a known weight, add its rows"
            )
    return trials


try:
    TRIALS = checked_trials()
except InputError as error:
    sys.exit(f"tepsipe: {error}")

# every experiment's settings, with those that experiments on the treadmill share
SETTINGS = settings_of(config)
EXPERIMENTS = list(dict.fromkeys(experiment for experiment, _ in TRIALS))
# the force plate's models need the empty belt and the weight, the torque from the foot's side the models
PLATE = "weight" in EXPERIMENTS
FOOT = PLATE and "dummy" in EXPERIMENTS
# simulations compare the parameters of both experiments with the ankle dummy
SIMULATION = {"wristalyzer", "dummy"} <= set(EXPERIMENTS)


def conditions(experiment):
    """Conditions of an experiment in the order of the trial sheet."""
    return [condition for name, condition in TRIALS if name == experiment]


def made_conditions(experiment):
    """Those of them that the virtual laboratory makes."""
    return [c for c in conditions(experiment) if TRIALS[experiment, c].source == "virtual_lab"]


def roles(experiment):
    """Condition -> calibrate or validate, in the order of the trial sheet."""
    return {condition: TRIALS[experiment, condition].role for condition in conditions(experiment)}


def tasks():
    """What the person was told, in the order of the trial sheet."""
    return list(dict.fromkeys(TRIALS["standing", c].task for c in conditions("standing")))


def task_groups():
    """Conditions by task and profile, for example relax, negative-sine; in the order of the trial sheet."""
    groups = {}
    for condition in conditions("standing"):
        row = TRIALS["standing", condition]
        title = row.task if row.profile == "-" else f"{row.task}, {row.profile}"
        groups.setdefault(title, []).append(condition)
    return groups


def made_tasks():
    """Condition -> task of the person's trials that the laboratory makes, and of tasks made as a whole."""
    made = {c: TRIALS["standing", c].task for c in made_conditions("standing")}
    whole = {
        task
        for task in tasks()
        if all(c in made for c in conditions("standing") if TRIALS["standing", c].task == task)
    }
    return made | {task: task for task in tasks() if task in whole}


def of_task(pattern):
    """Input function: the pattern filled in for every condition of a task."""

    def files(wildcards):
        names = [c for c in conditions("standing") if TRIALS["standing", c].task == wildcards.task]
        return [pattern.format(condition=condition) for condition in names]

    return files


def plate_models():
    """Models of the plate's load, where there are any: of Fy, then of Mx."""
    return [f"<results>/treadmill_models/plate_{load}.json" for load in ("Fy", "Mx")] if PLATE else []


def plate_trials():
    """[experiment, condition, role] of all trials with the empty belt and with the weight."""
    return [[e, c, role] for e in ("empty", "weight") for c, role in roles(e).items()]


def any_of(names):
    """Regular expression for one of the names, or for nothing at all."""
    return "|".join(name.replace(".", r"\.") for name in names) or "(?!)"


wildcard_constraints:
    condition=any_of(sorted({condition for _, condition in TRIALS}, key=len, reverse=True)),
    task=any_of(sorted(tasks(), key=len, reverse=True)),


def trial(wildcards, experiment):
    """The trial's row of the sheet."""
    return TRIALS[experiment, wildcards.condition]


def raw_files(wildcards, experiment):
    """Kind -> path of the trial's raw files, recorded or made."""
    row = trial(wildcards, experiment)
    if row.source == "recorded":
        return row.files
    folder = f"{config['pathvars']['results']}/raw/{experiment}/{row.condition}"
    return {kind: f"{folder}/{name}" for kind, name in RAW_FILES[experiment].items()}


def raw_inputs(experiment):
    """Input function: the raw files, without recorded ones that are missing.

    A missing recording stops its own job with a sentence, not the whole study.
    """

    def files(wildcards):
        made = trial(wildcards, experiment).source == "virtual_lab"
        paths = raw_files(wildcards, experiment).values()
        return [path for path in paths if made or Path(path).is_file()]

    return files


def of_trials(pattern, experiment):
    """The pattern filled in for every condition of an experiment."""
    return [pattern.format(condition=condition) for condition in conditions(experiment)]


def library_of(script):
    """The modules that a script reaches: an edit of one re-runs the rule."""
    return [here(path) for path in reached_by(f"workflow/scripts/{script}.py", workflow.basedir)]


def here(path):
    """A file of this project, as seen from the folder that the study runs in."""
    return os.path.relpath(Path(workflow.basedir) / path)


# ---- what the study shows, by experiment ---------------------------------------------------------


def appendix_figures():
    """Figures B-1 to B-12, one per condition of the dummy, in the order of the trial sheet."""
    return [f"figure_b_{number}" for number in range(1, 1 + min(12, len(conditions("dummy"))))]


FIGURES = {
    "wristalyzer": [
        "figure_2_4",
        "figure_3_1",
        "figure_4_1",
        "figure_4_2",
        "figure_4_3",
        "figure_starting_values",
        "figure_averaging",
    ],
    "dummy": [
        "figure_2_9",
        "figure_3_3",
        "figure_4_4",
        "figure_pathways",
        "figure_torque",
        "figure_specification",
        "figure_dummy_cross_validation",
    ],
    "weight": [
        "figure_4_5",
        "figure_4_6",
        "figure_5_1",
        "figure_plate_models",
        "figure_plate_responses",
    ],
    "foot": ["figure_foot"],
    "simulation": [
        "figure_4_7",
        "figure_4_8",
        "figure_4_9",
        "figure_4_10",
        "figure_4_11",
        "figure_b",
        *appendix_figures(),
        "figure_b_13",
    ],
    "noise": ["figure_4_12", "figure_noise"],
    "standing": [
        "figure_4_13",
        "figure_4_14",
        "figure_standing_activity",
        "figure_standing_latency",
        "figure_standing_response",
        "figure_standing_stiffness",
        "figure_standing_window",
        "figure_standing_joints",
    ],
    "belt": ["figure_belt_prediction", "figure_belt_cutoff", "figure_belt_ripple"],
    "position_manipulator": [
        "figure_position_manipulator_impedance",
        "figure_position_manipulator_prediction",
        "figure_position_manipulator_responses",
    ],
}
CATEGORIES = {
    "wristalyzer": "Wristalyzer",
    "dummy": "TEP-SIPE on the ankle dummy",
    "weight": "What the treadmill adds to the force",
    "foot": "TEP-SIPE on the ankle dummy",
    "simulation": "Forward simulation",
    "noise": "Sensitivity to noise",
    "standing": "A person standing on the treadmill",
    "belt": "What the treadmill adds to the load",
    "position_manipulator": "Position-controlled manipulator",
}
TABLES = {"wristalyzer": ["table_4_1"], "dummy": ["table_4_2", "table_4_3"]}


def figure_files(experiment):
    """Named outputs of a plotting rule: every figure as SVG, in the HTML report, and as PNG."""
    files = {}
    for name in FIGURES[experiment]:
        caption = "figure_b_trial" if name in appendix_figures() else name
        files[name] = report(
            f"<results>/figures/{name}.svg",
            caption=f"../../report/captions/{caption}.rst",
            category=CATEGORIES[experiment],
            labels={"figure": name.removeprefix("figure_").replace("_", "-")},
        )
        files[f"{name}_png"] = f"<results>/figures/{name}.png"
    return files


def shown_condition(experiment, wanted):
    """The configured condition, or the last of the sheet where the study does not have it."""
    names = conditions(experiment)
    return wanted if wanted in names or not names else names[-1]


def shown_validating(experiment, wanted):
    """The same among the trials that validate models."""
    names = [condition for condition, role in roles(experiment).items() if role == "validate"]
    return wanted if wanted in names or not names else names[-1]


def shown_conditions(experiment, wanted):
    """The configured conditions that the study has, or all where it has none of them."""
    names = conditions(experiment)
    return [name for name in names if name in wanted] or names


def study_figures():
    """Every figure of the study's experiments."""
    parts = {"foot": FOOT, "simulation": SIMULATION, "noise": SIMULATION}
    shown = EXPERIMENTS + [name for name, there in parts.items() if there]
    return [f"<results>/figures/{name}.svg" for e in shown for name in FIGURES.get(e, [])]


def standing_figures():
    """Figures 4-13 and 4-14 of every trial of the standing person."""
    names = ("4_13", "4_14")
    return [f"<results>/figures/standing/{c}_{name}.png" for c in conditions("standing") for name in names]


def active_estimators():
    """Estimators of the standing person that tell the muscles' torque apart."""
    return [name for name, choice in SETTINGS["standing"]["estimators"].items() if choice["active"] != "none"]


def task_fits():
    """What the trials of each task gave together."""
    return [f"<results>/fits/standing_tasks/{task}.h5" for task in tasks()]


def study_tables():
    """The thesis's tables, where there is something to compare."""
    names = [name for e in EXPERIMENTS for name in TABLES.get(e, []) if table_conditions(name)]
    return [f"<results>/tables/{name}.csv" for name in names]


def study_forward():
    """The comparison of simulations with recordings, where both experiments are in the study."""
    return ["<results>/tables/forward.csv"] if SIMULATION else []


def noise_conditions():
    """One trial of the dummy for every profile and amplitude: the belt motions of the noise study."""
    chosen = {}
    for condition in conditions("dummy"):
        row = TRIALS["dummy", condition]
        key = condition if row.amplitude is None else (row.profile, row.amplitude)
        chosen.setdefault(key, condition)
    return list(chosen.values())


def same_profile(wildcards):
    """The noise study's trials with the same profile as one of them, itself included."""
    profile = trial(wildcards, "dummy").profile
    return [c for c in noise_conditions() if TRIALS["dummy", c].profile == profile]


def study_specification():
    """One trial of the dummy by every combination of choices, where there is a dummy."""
    return ["<results>/tables/specification.csv"] if "dummy" in EXPERIMENTS else []


def study_noise():
    """The noise study's tables, where there are simulations."""
    names = ("noise", "table_4_4") if SIMULATION else ()
    return [f"<results>/tables/{name}.csv" for name in names]


def study_models():
    """The table of the treadmill's models, where there are any."""
    return ["<results>/tables/treadmill_models.csv"] if model_scores() else []


def model_files(name, there):
    """What the calibration of treadmill models keeps for the report: responses, and scores."""
    files = [f"<results>/fits/{name}.h5", f"<results>/treadmill_models/{name}.csv"]
    return files if there else []


def model_scores():
    """Scores of the force plate's models and of those of a recorded treadmill."""
    made = {"plate": PLATE, "belt": "belt" in EXPERIMENTS}
    return [f"<results>/treadmill_models/{name}.csv" for name, there in made.items() if there]


def study_recovery():
    """The comparison with the truth, where there is a truth."""
    return [] if config["study"]["virtual_lab"] is None else ["<results>/tables/recovery.csv"]


def study_claims():
    """The check of the thesis's statements, where there is something to compare."""
    return [] if config["study"]["reported"] is None else ["<results>/tables/claims.csv"]


def all_trials():
    """HDF5 files of all trials."""
    return [f"<results>/trials/{e}/{c}.h5" for e, c in TRIALS]


def fitted_trials():
    """(experiment, condition) of all trials with a fit of their own."""
    return [(e, c) for e, c in TRIALS if e != "belt"]


def all_fits():
    """Fits of all trials."""
    return [f"<results>/fits/{e}/{c}.h5" for e, c in fitted_trials()]


def all_estimates():
    """Rows of estimates of all trials and cross-validations."""
    files = [f"<results>/estimates/{e}/{c}.csv" for e, c in fitted_trials()]
    if FOOT:
        files += of_trials("<results>/estimates/foot/{condition}.csv", "dummy")
    files += [f"<results>/estimates/standing_tasks/{task}.csv" for task in tasks()]
    crossed = [e for e in EXPERIMENTS if e in ("wristalyzer", "dummy")]
    return files + [f"<results>/cross_validation/{e}.csv" for e in crossed]


def table_conditions(table):
    """Columns of a thesis table."""
    if table == "table_4_1":
        return conditions("wristalyzer")
    profile = {"table_4_2": "sine-", "table_4_3": "minjerk-"}[table]
    return [c for c in conditions("dummy") if c.startswith(profile)]


def table_pathways(table):
    """[pathway, estimator or None] as printed and recommended."""
    if table == "table_4_1":
        return [["admittance", "spectral-fit"], ["admittance", "spectral-fit-periods"]]
    return [[SETTINGS["dummy"][key], None] for key in ("as_printed", "recommended")]


def report_sources():
    """Typst sources, captions and references of the report."""
    folder = Path(workflow.basedir) / "report"
    files = sorted(p for p in folder.rglob("*") if p.suffix in (".typ", ".rst", ".bib"))
    return [here(path) for path in files]


def experiment_conditions():
    """Experiment -> its conditions."""
    return {experiment: conditions(experiment) for experiment in EXPERIMENTS}


def fitted_conditions():
    """Experiment -> its conditions, of all trials with a fit of their own."""
    return {e: names for e, names in experiment_conditions().items() if e != "belt"}


def study_outputs():
    """What `all` asks for, but for the HTML report, which shows it."""
    return [
        f"<results>/report/{config['study']['name']}.pdf",
        "<results>/provenance.json",
        "<results>/tables/estimates.csv",
        *study_tables(),
        *study_models(),
        *study_forward(),
        *study_noise(),
        *study_specification(),
        *study_recovery(),
        *study_claims(),
        *study_figures(),
        *standing_figures(),
    ]


def say_what_stopped():
    """After a failed run: the sentence of every job that stopped, and where a bug left its trace."""
    print("\nWhat stopped:", file=sys.stderr)
    for log in sorted(Path(config["pathvars"]["logs"]).rglob("*.log")):
        if log.stat().st_mtime < STARTED or not (text := log.read_text(encoding="utf-8").strip()):
            continue
        print(text if text.startswith("tepsipe: ") else f"tepsipe: a bug, see {log}", file=sys.stderr)
    print("Everything else is kept; the next run goes on from there.", file=sys.stderr)
