"""Look-ups of the rules on the trials and settings of a study, independent of Snakemake."""

from dataclasses import dataclass
from itertools import permutations
from pathlib import Path

from tepsipe.errors import InputError
from tepsipe.experiments.standing.muscle_torque import ACTIVE
from tepsipe.experiments.wristalyzer.estimators import ESTIMATORS as OF_MANIPULATOR
from tepsipe.experiments.wristalyzer.names import PATHWAY
from tepsipe.identification.estimators import ESTIMATORS
from tepsipe.reporting.laboratory import MECHANISMS
from workflow.support.experiments import EXPERIMENTS, PARTS
from workflow.support.names import check_distinct, check_name
from workflow.support.people import check_people, person_of
from workflow.support.row_names import check_names, named_by, with_names
from workflow.support.settings import only, pick, plate_treadmill, settings_of
from workflow.support.trial_sheet import TrialRow, check_roles

LEAST_PERIODS = 12  # of the perturbation in all trials of the manipulator, to fit them together
# kind of file of a simulated walk -> its name
WALKING_LOGS = {"c3d": "log.c3d", "dflow": "log.txt"}
LEAST_COLUMNS = 3  # of a thesis's table, for a part of the study that needs it


def any_of(names) -> str:
    """Regular expression for one of the names, or for nothing at all."""
    longest_first = sorted(set(names), key=lambda name: (-len(name), name))
    return "|".join(name.replace(".", r"\.") for name in longest_first) or "(?!)"


@dataclass(frozen=True)
class Pool:
    """Trials of a standing person that are also analysed together: those of one task.

    Where the sheet names participants or belts, those of one participant and on one belt; otherwise
    ``participant`` and ``belt`` are None, and the pool has the name of the task.
    """

    name: str
    participant: str | None
    belt: str | None
    task: str
    conditions: tuple[str, ...]


class Study:
    """A checked configuration and its trials.

    ``settings`` are the complete settings of every experiment; ``trials`` maps (experiment, condition) to
    rows of the trial sheet, in its order; ``experiments`` are those with trials. ``people`` is the table of
    the participants, None where there is none.
    """

    def __init__(self, config: dict, trials: dict[tuple, TrialRow], people: dict | None = None) -> None:
        self.config, self.trials, self.people = config, trials, people
        self.settings = settings_of(config)
        self.experiments = list(dict.fromkeys(experiment for experiment, _ in trials))

    def check(self, path: str) -> None:
        """Refuse rows of the trial sheet, whose path messages name, that do not fit the configuration."""
        for (experiment, condition), row in self.trials.items():
            check_names(experiment, condition, self.settings[experiment], row.names, path)
        rows: dict[str, list[TrialRow]] = {}
        for row in self.trials.values():
            rows.setdefault(row.experiment, []).append(row)
        check_people(rows, self.config["standing"], self.people, path, self.config["study"]["participants"])
        self._check_pools(path)
        if self.by_belt:
            self._check_belts(path)

    def _check_pools(self, path: str) -> None:
        """Trials of two people, belts or tasks are never analysed together because of equal names."""
        seen: dict[str, Pool] = {}
        for pool in self._pools():
            if pool.name in seen or ("standing", pool.name) in self.trials:
                what = "a condition" if pool.name not in seen else f"the task {seen[pool.name].task}"
                raise InputError(
                    f"{path}: expected a participant, a belt and a task whose joint name is no other one's, "
                    f"found {pool.name!r} for the task {pool.task} and for {what}: rename one of the two"
                )
            seen[pool.name] = pool
            check_name(pool.name, "name of participant, belt and task together", path)
        check_distinct(seen, "name of participant, belt and task together", path)

    def _check_belts(self, path: str) -> None:
        """Trials that need models of the treadmill must be on a belt that has been calibrated."""
        if not self.has("weight"):
            return
        plate = [row for (e, _), row in self.trials.items() if EXPERIMENTS[e].models == "plate"]
        for belt in self.belts():
            check_roles(
                [row for row in plate if self.belt_of(row.experiment, row.condition) == belt], path, belt
            )
        for (experiment, condition), row in self.trials.items():
            belt = self.belt_of(experiment, condition)
            if row.experiment in ("dummy", "standing") and belt not in self.belts():
                raise InputError(
                    f"{path}: expected trials of weight and empty on the {belt} belt, because models of the "
                    f"treadmill are those of one belt and {experiment}/{condition} is on it, found none: add "
                    "their rows, or correct its belt"
                )

    @property
    def kind(self) -> str | None:
        """Kind of a study with rules of its own, workflow/studies/<kind>.smk; None of the others."""
        kinds = ("coverage", "plan", "walking")
        return next((kind for kind in kinds if self.config[kind] is not None), None)

    # ---- experiments and files -------------------------------------------------------------------

    def has(self, name: str) -> bool:
        """Whether an experiment, or all experiments that a part needs, are in the study."""
        if name == "participants":
            return self.by_participant
        if name == "budgets":
            return any(EXPERIMENTS[experiment].budgets for experiment in self.experiments)
        if name not in PARTS:
            return name in self.experiments
        part = PARTS[name]
        if name == "operating_points":
            return len(self.operating_points()) > 1
        if name == "time_varying" and not self.config["position_manipulator"]["time_varying"]["enabled"]:
            return False
        if name == "wristalyzer_pooled" and not self._periods_suffice():
            return False
        if part.tables and self.config["study"]["reported"] is None:
            return False
        # fewer printed numbers than constants determine nothing
        told = all(len(self.table_conditions(table)) >= LEAST_COLUMNS for table in part.tables)
        return set(part.needs) <= set(self.experiments) and told

    def _periods_suffice(self) -> bool:
        """Whether the manipulator's trials, of at least two amplitudes, can be fitted together."""
        rows = [self.trials["wristalyzer", c] for c in self.conditions("wristalyzer")]
        if len(rows) < 2:
            return False
        analysis = self.settings["wristalyzer"]["analysis"]
        period, cut = analysis["perturbation_period_s"], analysis["cut_s"]
        if period is None:
            return False
        periods = [int((row.duration_s - 2.0 * cut) / period + 1e-9) for row in rows]
        return min(periods) >= 2 and sum(periods) >= LEAST_PERIODS

    def pooled_wristalyzer(self) -> dict:
        """Choices of the manipulator's trials that hold for the fit to all of them together."""
        analysis = self.settings.get("wristalyzer", {}).get("analysis", {})
        names = ("lowpass_cutoff_hz", "lowpass_order", "cut_s")
        return {name: analysis.get(name) for name in names} | {
            "period_s": analysis.get("perturbation_period_s")
        }

    def operating_points(self) -> dict[str, dict]:
        """Condition of the position-controlled manipulator -> participant, angle (rad), torque (N·m).

        Trials with a schedule or a trigger have no operating point of their own.
        """
        name, rows = "position_manipulator", {}
        for condition in self.conditions(name):
            columns = self.of_trial(name, condition)["files"]["columns"]
            if columns["schedule"] is None and columns["trigger"] is None:
                rows[condition] = self.trials[name, condition]
        return {
            condition: {
                "participant": row.participant or "",
                "angle_rad": row.operating_angle_rad,
                "torque_Nm": row.operating_torque_Nm,
            }
            for condition, row in rows.items()
        }

    def conditions(self, experiment: str) -> list[str]:
        """Conditions of an experiment in the order of the trial sheet."""
        return [condition for name, condition in self.trials if name == experiment]

    def made(self, experiment: str) -> list[str]:
        """Conditions of an experiment that are simulated."""
        names = self.conditions(experiment)
        return [c for c in names if self.trials[experiment, c].source == "virtual_lab"]

    def recorded(self, experiment: str) -> list[str]:
        """Conditions of an experiment that are not simulated."""
        made = self.made(experiment)
        return [c for c in self.conditions(experiment) if c not in made]

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
        names = EXPERIMENTS[experiment].raw_files
        if experiment == "walking":
            names = names | {"log": WALKING_LOGS[self.simulated_walk(condition)["file"]]}
        return {kind: f"{folder}/{name}" for kind, name in names.items()}

    def simulated_walk(self, condition: str) -> dict:
        """Pulses and kind of file of a simulated trial of walking."""
        return self.config["walking"]["simulated"]["trials"][condition]

    def recording(self, experiment: str, condition: str) -> dict | None:
        """Plates and channels of a trial that is one file; None for trials of several files."""
        alone = self.trials[experiment, condition].source == "recorded"
        alone = alone and "calibration" not in self.trials[experiment, condition].files
        return self.of_trial(experiment, condition)["recording"] if alone else None

    def raw_inputs(self, experiment: str, condition: str, results: str) -> list[str]:
        """As `raw_paths`, without missing recorded files: these stop their own job, not the whole study."""
        made = self.trials[experiment, condition].source == "virtual_lab"
        paths = self.raw_files(experiment, condition, results).values()
        return [path for path in paths if made or Path(path).is_file()]

    def of_trial(self, experiment: str, condition: str) -> dict:
        """Settings of an experiment for one trial: names and belt of its row, person of its participant."""
        row = self.trials[experiment, condition]
        section = with_names(self.settings[experiment], row.names)
        if EXPERIMENTS[experiment].on_plate:
            section["belt"] = self.belt_of(experiment, condition)
        if experiment == "standing":
            section["person"] = self.person(row.participant)
        if experiment == "weight":
            section["weight"] = self.weight_of(experiment, condition)
        return section

    def settings_of(self, experiment: str, condition: str) -> dict:
        """All settings, with those of one trial for its experiment."""
        return self.settings | {experiment: self.of_trial(experiment, condition)}

    def named_by(self, experiment: str, condition: str, table: str) -> dict[str, str]:
        """Key of a table's columns -> column of the trial sheet that names it, for messages."""
        return named_by(experiment, self.trials[experiment, condition].names, f"files.{table}")

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

    def time_lines(self) -> dict[str, list[list]]:
        """Experiment -> [condition, duration (s), velocity amplitude (m/s)] of its trials.

        Amplitudes of pulses that begin backwards are negative; where the sheet has none they are None.
        """
        found: dict[str, list[list]] = {}
        for (experiment, condition), row in self.trials.items():
            amplitude = row.amplitude
            if amplitude is not None and row.profile.startswith("negative-"):
                amplitude = -amplitude
            found.setdefault(experiment, []).append([condition, row.duration_s, amplitude])
        return found

    def examples(self) -> list[tuple[str, str]]:
        """(experiment, condition) of one trial of each rig with markers: the one that figures show."""
        rigs = [name for name in ("dummy", "weight", "standing") if name in self.experiments]
        return [(name, self.shown(name, self.settings[name]["example_condition"])) for name in rigs]

    def roles(self, experiment: str) -> dict[str, str]:
        """Condition -> calibrate or validate."""
        return {c: self.trials[experiment, c].role for c in self.conditions(experiment)}

    def plate_trials(self, belt: str | None = None) -> list[list[str]]:
        """[experiment, condition, role] of the trials for models of the force plate, or of one belt of it."""
        return [
            [e, c, role]
            for e in ("empty", "weight")
            for c, role in self.roles(e).items()
            if belt is None or self.belt_of(e, c) == belt
        ]

    def weight_of(self, experiment: str, condition: str) -> dict | None:
        """Weight of a trial: the usual one, or a further one of the mass in its row; None without any."""
        if experiment != "weight":
            return None
        usual = self.settings["weight"]["weight"]
        mass = self.trials[experiment, condition].mass_kg
        if mass is None or mass == usual["mass_kg"]:
            return usual
        others = {other["mass_kg"]: other for other in self.settings["weight"]["further_weights"]}
        if mass not in others:
            known = " or ".join(f"{kg:g}" for kg in (usual["mass_kg"], *others))
            raise InputError(
                f"{self.config['study']['trial_sheet']}: expected a mass_kg of {known} for "
                f"weight/{condition}, found {mass:g}: correct it, or add the weight to "
                "weight.further_weights in the configuration"
            )
        return usual | others[mass]

    def usual_weight(self) -> list[str]:
        """Conditions of the weight of the thesis, without those of further weights."""
        usual = self.settings["weight"]["weight"]
        return [c for c in self.conditions("weight") if self.weight_of("weight", c) == usual]

    def described(self, experiment: str) -> dict[str, dict]:
        """Condition -> what a trial's page says of it: simulated or not, belt, role, task, participant."""
        made, found = self.made(experiment), {}
        for condition in self.conditions(experiment):
            row = self.trials[experiment, condition]
            found[condition] = {
                "made": condition in made,
                "belt": self.belt_of(experiment, condition),
                "role": row.role,
                "task": row.task,
                "participant": row.participant,
            }
        return found

    # ---- participants, belts and tasks ---------------------------------------------------------------

    @property
    def by_participant(self) -> bool:
        """Whether the sheet names participants."""
        return any(row.participant for row in self.trials.values())

    @property
    def by_belt(self) -> bool:
        """Whether the sheet names the belts of its trials."""
        return any(row.belt for row in self.trials.values())

    def belt_of(self, experiment: str, condition: str) -> str | None:
        """Belt of a trial, by its row or by the configuration; None if it is not on the plate treadmill."""
        if not EXPERIMENTS[experiment].on_plate:
            return None
        row = self.trials.get((experiment, condition))
        return (row and row.belt) or plate_treadmill(self.config, experiment)["belt"]

    def named(self, experiment: str, condition: str) -> dict[str, str]:
        """Participant and belt of a trial, where its row names them: they stand in the trial's file."""
        row = self.trials[experiment, condition]
        return {key: getattr(row, key) for key in ("participant", "belt") if getattr(row, key)}

    def belts(self) -> list[str]:
        """Belts with models of the force plate, in the order left, right."""
        return sorted({self.belt_of(e, c) for e in ("empty", "weight") for c in self.conditions(e)})

    def plates(self) -> dict[str, str]:
        """Name of a calibration of the force plate in its files -> its belt."""
        return {self.plate_of(belt): belt for belt in self.belts()}

    def plate_of(self, belt: str) -> str:
        """Name of a belt's calibration: plate, or plate_left and plate_right if the sheet names belts."""
        return f"plate_{belt}" if self.by_belt else "plate"

    def shown_plate(self) -> str:
        """Calibration that figures and report show: that of the belt of the example trial with the weight."""
        example = self.shown("weight", self.settings["weight"]["example_condition"], role="validate")
        return self.plate_of(self.belt_of("weight", example))

    def participants(self, experiment: str) -> list[str]:
        """Participants of an experiment, in the order of their names."""
        found = {self.trials[experiment, c].participant for c in self.conditions(experiment)}
        return sorted(found - {None})

    def _pools(self) -> list[Pool]:
        groups: dict[tuple, list[str]] = {}
        for condition in self.conditions("standing"):
            row = self.trials["standing", condition]
            belt = self.belt_of("standing", condition) if self.by_belt else None
            groups.setdefault((row.participant, belt, row.task), []).append(condition)
        named = [
            Pool("-".join(filter(None, key)), *key, tuple(conditions)) for key, conditions in groups.items()
        ]
        if not (self.by_belt or self.participants("standing")):
            return named
        # another order of the rows must not change a result
        named = [Pool(p.name, p.participant, p.belt, p.task, tuple(sorted(p.conditions))) for p in named]
        return sorted(named, key=lambda pool: (pool.participant or "", pool.task, pool.belt or ""))

    def pools(self) -> dict[str, Pool]:
        """Name -> trials that are also analysed together."""
        return {pool.name: pool for pool in self._pools()}

    def tasks(self) -> list[str]:
        """Names of the pools: tasks of the person, in the order of the trial sheet."""
        return list(self.pools())

    def task_pairs(self) -> dict[str, tuple[str, str]]:
        """Name, for example stiff-relax, -> pools of two tasks of one person, the later first.

        Tasks of your own come after those of the simulated person, by name.
        """
        known = EXPERIMENTS["standing"].tasks

        def place(task: str) -> tuple[int, str]:
            return (known.index(task), "") if task in known else (len(known), task)

        found = {}
        for less, more in permutations(self._pools(), 2):
            alike = (more.participant, more.belt) == (less.participant, less.belt)
            if alike and place(more.task) > place(less.task):
                found[f"{more.name}-{less.task}"] = (more.name, less.name)
        return found

    def task_of(self) -> dict[str, str]:
        """Condition -> name of its pool, in the order of the trial sheet."""
        found = {c: pool.name for pool in self._pools() for c in pool.conditions}
        return {c: found[c] for c in self.conditions("standing")}

    def of_task(self, pattern: str, task: str) -> list[str]:
        """The pattern filled in for every condition of a pool."""
        return [pattern.format(condition=c) for c in self.pools()[task].conditions]

    def person(self, participant: str | None) -> dict:
        """Settings of a person: those of the configuration, with what is known of a participant."""
        return person_of(self.settings["standing"], participant, self.people or {})

    def shown_pools(self, participant: str | None = None) -> dict[str, Pool]:
        """Pools of a participant's figures; without one, of the participant and belt of the example trial."""
        pools = self.pools()
        if participant is not None or not pools:
            return {name: pool for name, pool in pools.items() if pool.participant == participant}
        example = self.shown("standing", self.settings["standing"]["example_condition"])
        own = pools[self.task_of()[example]]
        return {n: p for n, p in pools.items() if (p.participant, p.belt) == (own.participant, own.belt)}

    def shown_people(self, participant: str | None = None) -> dict[str, str]:
        """Condition -> pool of the trials of these figures, in the order of the sheet."""
        shown = self.shown_pools(participant)
        return {condition: pool for condition, pool in self.task_of().items() if pool in shown}

    def task_groups(self, participant: str | None = None) -> dict[str, list[str]]:
        """Conditions of these figures by task and profile, for example relax, negative-sine."""
        groups: dict[str, list[str]] = {}
        for condition, pool in self.shown_people(participant).items():
            profile = self.trials["standing", condition].profile
            groups.setdefault(pool if profile == "-" else f"{pool}, {profile}", []).append(condition)
        return groups

    def made_tasks(self) -> dict[str, str]:
        """Condition -> task of simulated trials, and of pools whose trials are all simulated."""
        made = set(self.made("standing"))
        whole = {pool.name: pool.task for pool in self._pools() if made >= set(pool.conditions)}
        return {c: self.trials["standing", c].task for c in self.conditions("standing") if c in made} | whole

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
        if experiment == "weight":
            names = [c for c in names if c in self.usual_weight()] or names
        return wanted if wanted in names or not names else names[-1]

    def shown_several(self, experiment: str, wanted: list[str]) -> list[str]:
        """The configured conditions that the study has, or all if it has none of them."""
        names = self.usual_weight() if experiment == "weight" else self.conditions(experiment)
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
            return [[PATHWAY, name] for name, estimator in OF_MANIPULATOR.items() if estimator.in_table]
        return [[self.settings["dummy"][key], None] for key in ("as_printed", "recommended")]

    def budgeted_foot(self) -> str | None:
        """Pathway from the foot whose budget is shown: the last one with a treadmill model, None without."""
        pathways = self.settings["dummy"]["foot"]["pathways"] if self.has("foot") else {}
        compensated = [name for name, choice in pathways.items() if choice["treadmill_model"] is not None]
        return compensated[-1] if compensated else None

    def active_estimators(self) -> list[str]:
        """Estimators of the standing person that separate the muscle torque."""
        choices = self.settings["standing"]["estimators"]
        return [name for name, choice in choices.items() if ACTIVE[choice["active"]].separates]

    def dummy_windows(self) -> dict[str, float | None]:
        """Pathway of the dummy with estimates of windows -> length (s), None if that of the pulse."""
        dummy = self.settings["dummy"]
        foot = dummy["foot"]["pathways"] if self.has("foot") else {}
        legs = {name: None for name, p in dummy["pathways"].items() if ESTIMATORS[p["estimator"]].of_windows}
        return legs | {name: p["window_s"] for name, p in foot.items()}

    def standing_windows(self) -> dict | None:
        """Simulated trials of a person by condition and pool, their baseline, and the fitted windows."""
        if not self.made("standing"):
            return None
        settings, pools = self.settings["standing"], self.pools()
        return {
            "trials": {
                name: pools[name].conditions if name in pools else (name,) for name in self.made_tasks()
            },
            "baseline_s": settings["analysis"]["baseline_s"],
            "estimators": {n: only(e, "window_s", "inertia") for n, e in settings["estimators"].items()},
        }

    def windows(self) -> dict[str, dict[str, float | None]]:
        """Experiment -> name of a pathway or estimator -> its window (s)."""
        standing = self.settings["standing"]["estimators"]
        return {
            "dummy": self.dummy_windows(),
            "standing": {name: choice["window_s"] for name, choice in standing.items()},
        }

    def foot_pathways(self) -> list[str]:
        """Pathways of the dummy with the torque from the foot."""
        return list(self.settings["dummy"]["foot"]["pathways"]) if self.has("foot") else []

    def printed(self) -> dict[str, dict]:
        """Settings that the report prints, by experiment and part."""
        named = {e: EXPERIMENTS[e].printed for e in self.experiments}
        named |= {name: part.printed for name, part in PARTS.items() if self.has(name) and part.printed}
        return {name: pick(self.settings[name], *paths) for name, paths in named.items()}

    def true(self) -> list[str]:
        """Constants of the laboratory, as the truth for the estimates of simulated trials."""
        paths = [path for e, made in self.all_made().items() if made for path in EXPERIMENTS[e].true]
        return list(dict.fromkeys(paths))

    def mechanisms(self) -> list[str]:
        """Constants that say what the laboratory is like: mechanisms, and what was drawn."""
        made = [experiment for experiment, names in self.all_made().items() if names]
        if any(EXPERIMENTS[experiment].on_plate for experiment in made):
            made.append("treadmill")
        paths = [mechanism.key for mechanism in MECHANISMS if mechanism.section in made]
        return [*paths, "drawn_numbers"] if made else []


def table_experiment(table: str) -> str:
    """The experiment of a thesis table."""
    return next(name for name, experiment in EXPERIMENTS.items() if table in experiment.thesis_tables)
