"""Look-ups of the rules on the trials and settings of a study, independent of Snakemake."""

from pathlib import Path

from workflow.support.experiments import EXPERIMENTS, PARTS
from workflow.support.row_names import check_names, named_by, with_names
from workflow.support.settings import pick, settings_of
from workflow.support.trial_sheet import TrialRow


def any_of(names) -> str:
    """Regular expression for one of the names, or for nothing at all."""
    longest_first = sorted(set(names), key=lambda name: (-len(name), name))
    return "|".join(name.replace(".", r"\.") for name in longest_first) or "(?!)"


class Study:
    """A checked configuration and its trials.

    ``settings`` are the complete settings of every experiment; ``trials`` maps (experiment, condition) to
    rows of the trial sheet, in its order; ``experiments`` are those with trials.
    """

    def __init__(self, config: dict, trials: dict[tuple, TrialRow]) -> None:
        self.config, self.trials = config, trials
        self.settings = settings_of(config)
        self.experiments = list(dict.fromkeys(experiment for experiment, _ in trials))

    def check(self, path: str) -> None:
        """Refuse rows of the trial sheet, whose path messages name, that do not fit the configuration."""
        for (experiment, condition), row in self.trials.items():
            check_names(experiment, condition, self.settings[experiment].get("files", {}), row.names, path)

    # ---- experiments and files -------------------------------------------------------------------

    def has(self, name: str) -> bool:
        """Whether an experiment, or all experiments that a part needs, are in the study."""
        needs = PARTS[name].needs if name in PARTS else (name,)
        return set(needs) <= set(self.experiments)

    def conditions(self, experiment: str) -> list[str]:
        """Conditions of an experiment in the order of the trial sheet."""
        return [condition for name, condition in self.trials if name == experiment]

    def made(self, experiment: str) -> list[str]:
        """Conditions of an experiment that are simulated."""
        names = self.conditions(experiment)
        return [c for c in names if self.trials[experiment, c].source == "virtual_lab"]

    def all_conditions(self, fitted: bool = False) -> dict[str, list[str]]:
        """Experiment -> its conditions; if ``fitted``, of those whose trials have fits of their own."""
        return {e: self.conditions(e) for e in self.experiments if EXPERIMENTS[e].fitted or not fitted}

    def all_made(self) -> dict[str, list[str]]:
        """Experiment -> conditions that are simulated."""
        return {experiment: self.made(experiment) for experiment in self.experiments}

    def of_trials(self, pattern: str, experiment: str) -> list[str]:
        """The pattern filled in for every condition of an experiment."""
        return [pattern.format(condition=condition) for condition in self.conditions(experiment)]

    def of_foot(self, pattern: str) -> list[str]:
        """The pattern filled in for every trial of the dummy with a torque from the foot."""
        return self.of_trials(pattern, "dummy") if self.has("foot") else []

    def raw_files(self, experiment: str, condition: str, results: str) -> dict[str, str]:
        """Kind -> path of a trial's raw files: recorded, or simulated below the folder of the results."""
        row = self.trials[experiment, condition]
        if row.source == "recorded":
            return row.files
        folder = f"{results}/raw/{experiment}/{condition}"
        return {kind: f"{folder}/{name}" for kind, name in EXPERIMENTS[experiment].raw_files.items()}

    def recording(self, experiment: str, condition: str) -> dict | None:
        """Plates and channels of a trial that is one file; None for trials of several files."""
        alone = self.trials[experiment, condition].source == "recorded"
        alone = alone and "calibration" not in self.trials[experiment, condition].files
        return self.settings[experiment]["recording"] if alone else None

    def raw_inputs(self, experiment: str, condition: str, results: str) -> list[str]:
        """As `raw_paths`, without missing recorded files: these stop their own job, not the whole study."""
        made = self.trials[experiment, condition].source == "virtual_lab"
        paths = self.raw_files(experiment, condition, results).values()
        return [path for path in paths if made or Path(path).is_file()]

    def files(self, experiment: str, condition: str) -> dict:
        """Settings ``files`` of an experiment, with the names that the trial's row gives in their place."""
        return with_names(self.settings[experiment]["files"], self.trials[experiment, condition].names)

    def named_by(self, experiment: str, condition: str, table: str) -> dict[str, str]:
        """Key of a table's columns -> column of the trial sheet that names it, for messages."""
        return named_by(experiment, self.trials[experiment, condition].names, table)

    # ---- properties of trials, from the trial sheet ---------------------------------------------------

    def protocol(self, experiment: str, condition: str) -> dict:
        """Motion of the belt in a simulated trial."""
        row = self.trials[experiment, condition]
        random = EXPERIMENTS[experiment].at_random
        return {
            "profile": row.profile,
            "amplitude_m_per_s": row.amplitude,
            "interval_s": (row.interval_s, row.longest_interval_s) if random else row.interval_s,
            "duration_s": row.duration_s,
        }

    def amplitudes(self, experiment: str) -> dict[str, float | None]:
        """Condition -> velocity amplitude (m/s), None where the sheet has none."""
        return {c: self.trials[experiment, c].amplitude for c in self.conditions(experiment)}

    def roles(self, experiment: str) -> dict[str, str]:
        """Condition -> calibrate or validate."""
        return {c: self.trials[experiment, c].role for c in self.conditions(experiment)}

    def plate_trials(self) -> list[list[str]]:
        """[experiment, condition, role] of all trials for models of the force plate."""
        return [[e, c, role] for e in ("empty", "weight") for c, role in self.roles(e).items()]

    def task_of(self) -> dict[str, str]:
        """Condition -> task of the standing person."""
        return {c: self.trials["standing", c].task for c in self.conditions("standing")}

    def tasks(self) -> list[str]:
        """Tasks of the person, in the order of the trial sheet."""
        return list(dict.fromkeys(self.task_of().values()))

    def of_task(self, pattern: str, task: str) -> list[str]:
        """The pattern filled in for every condition of a task."""
        return [pattern.format(condition=c) for c, told in self.task_of().items() if told == task]

    def task_groups(self) -> dict[str, list[str]]:
        """Conditions by task and profile, for example relax, negative-sine; in the order of the sheet."""
        groups: dict[str, list[str]] = {}
        for condition, task in self.task_of().items():
            profile = self.trials["standing", condition].profile
            groups.setdefault(task if profile == "-" else f"{task}, {profile}", []).append(condition)
        return groups

    def made_tasks(self) -> dict[str, str]:
        """Condition -> task of simulated trials, and of tasks whose trials are all simulated."""
        told, made = self.task_of(), set(self.made("standing"))
        whole = [task for task in self.tasks() if made >= {c for c in told if told[c] == task}]
        return {c: task for c, task in told.items() if c in made} | {task: task for task in whole}

    def noise_conditions(self) -> list[str]:
        """One trial of the dummy for every profile and amplitude: the belt motions of the noise study."""
        chosen: dict = {}
        for condition in self.conditions("dummy"):
            row = self.trials["dummy", condition]
            key = condition if row.amplitude is None else (row.profile, row.amplitude)
            chosen.setdefault(key, condition)
        return list(chosen.values())

    def averaged_noise_conditions(self) -> list[str]:
        """Trials of Table 4-4 and Figure 4-12: with sinusoidal perturbations, or all if there are none."""
        names = self.noise_conditions()
        return [name for name in names if name.startswith("sine")] or names

    def same_profile(self, condition: str) -> list[str]:
        """The noise study's trials with the profile of a given trial, which is included."""
        profile = self.trials["dummy", condition].profile
        return [c for c in self.noise_conditions() if self.trials["dummy", c].profile == profile]

    # ---- tables and figures ------------------------------------------------------------------------

    def shown(self, experiment: str, wanted: str, role: str | None = None) -> str:
        """The configured condition; if the study lacks it, the last of its role in the sheet."""
        names = [c for c, own in self.roles(experiment).items() if role in (None, own)]
        return wanted if wanted in names or not names else names[-1]

    def shown_several(self, experiment: str, wanted: list[str]) -> list[str]:
        """The configured conditions that the study has, or all if it has none of them."""
        names = self.conditions(experiment)
        return [name for name in names if name in wanted] or names

    def thesis_tables(self) -> dict[str, str]:
        """Thesis table -> its experiment, for the tables that have conditions in this study."""
        tables = {name: e for e in self.experiments for name in EXPERIMENTS[e].thesis_tables}
        return {name: e for name, e in tables.items() if self.table_conditions(name)}

    def table_conditions(self, table: str) -> list[str]:
        """Columns of a thesis table."""
        experiment = table_experiment(table)
        begins = EXPERIMENTS[experiment].thesis_tables[table]
        return [c for c in self.conditions(experiment) if c.startswith(begins)]

    def table_pathways(self, table: str) -> list[list]:
        """[pathway, estimator or None] of the thesis as printed, and as recommended."""
        if table_experiment(table) == "wristalyzer":
            return [["admittance", "spectral-fit"], ["admittance", "spectral-fit-periods"]]
        return [[self.settings["dummy"][key], None] for key in ("as_printed", "recommended")]

    def active_estimators(self) -> list[str]:
        """Estimators of the standing person that separate the muscle torque."""
        choices = self.settings["standing"]["estimators"]
        return [name for name, choice in choices.items() if choice["active"] != "none"]

    def printed(self) -> dict[str, dict]:
        """Settings that the report prints, by experiment and part."""
        named = {e: EXPERIMENTS[e].printed for e in self.experiments}
        named |= {name: part.printed for name, part in PARTS.items() if self.has(name) and part.printed}
        return {name: pick(self.settings[name], *paths) for name, paths in named.items()}

    def true(self) -> list[str]:
        """Constants of the laboratory, as the truth for the estimates of simulated trials."""
        return [path for e, made in self.all_made().items() if made for path in EXPERIMENTS[e].true]


def table_experiment(table: str) -> str:
    """The experiment of a thesis table."""
    return next(name for name, experiment in EXPERIMENTS.items() if table in experiment.thesis_tables)
