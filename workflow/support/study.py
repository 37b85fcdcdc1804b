"""A study: its trials and settings, and look-ups of the rules on them, independent of Snakemake."""

from tepsipe.experiments.registry import EXPERIMENTS
from workflow.settings.complete import pick, settings_of
from workflow.support.lookups.estimators import Estimators
from workflow.support.lookups.manipulators import Manipulators
from workflow.support.lookups.noise import NoiseTrials
from workflow.support.lookups.sheet import Sheet, last_unless
from workflow.support.lookups.tasks import Tasks
from workflow.support.lookups.thesis import ThesisTables
from workflow.support.lookups.treadmill import Treadmill
from workflow.support.parts import PARTS
from workflow.support.people import check_people, person_of
from workflow.support.row_names import check_names, with_names
from workflow.support.trial_sheet import TrialRow

# kind of file of a simulated walk -> its name
WALKING_LOGS = {"c3d": "log.c3d", "dflow": "log.txt"}
# experiments of the thesis
OF_THESIS = ("wristalyzer", "dummy", "weight", "empty", "standing")
LEAST_COLUMNS = 3  # of a thesis's table, for a part of the study that needs it


def any_of(names) -> str:
    """Regular expression for one of the names, or for nothing at all."""
    longest_first = sorted(set(names), key=lambda name: (-len(name), name))
    return "|".join(name.replace(".", r"\.") for name in longest_first) or "(?!)"


class Study(Sheet):
    """A checked configuration and its trials.

    ``settings`` are the complete settings of every experiment. ``people`` is the table of the participants,
    None where there is none. Look-ups for one purpose are those of ``treadmill``, ``tasks``, ``noise``,
    ``thesis``, ``manipulators`` and ``estimators``.
    """

    def __init__(self, config: dict, trials: dict[tuple, TrialRow], people: dict | None = None) -> None:
        super().__init__(trials)
        self.config, self.people = config, people
        self.settings = settings_of(config)
        self.treadmill = Treadmill(self, config, self.settings)
        self.tasks = Tasks(self, self.treadmill, self.settings["standing"]["example_condition"])
        self.noise = NoiseTrials(self)
        self.thesis = ThesisTables(self, self.settings)
        self.manipulators = Manipulators(self, self.settings)
        self.estimators = Estimators(self, self.settings, self.has("foot"))

    def check(self, path: str) -> None:
        """Refuse rows of the trial sheet, whose path messages name, that do not fit the configuration."""
        for (experiment, condition), row in self.trials.items():
            check_names(experiment, condition, self.settings[experiment], row.names, path)
        rows: dict[str, list[TrialRow]] = {}
        for row in self.trials.values():
            rows.setdefault(row.experiment, []).append(row)
        check_people(rows, self.config["standing"], self.people, path, self.config["study"]["participants"])
        self.tasks.check(path)
        if self.by_belt and self.has("weight"):
            self.treadmill.check(path)

    @property
    def kind(self) -> str | None:
        """Kind of a study with rules of its own, workflow/studies/<kind>.smk; None of the others."""
        kinds = ("coverage", "plan", "walking")
        return next((kind for kind in kinds if self.config[kind] is not None), None)

    def has(self, name: str) -> bool:
        """True if an experiment, or all experiments that a part needs, are in the study."""
        if name == "participants":
            return self.by_participant
        if name == "budgets":
            return any(EXPERIMENTS[experiment].budgets for experiment in self.experiments)
        if name not in PARTS:
            return name in self.experiments
        part = PARTS[name]
        if name == "operating_points":
            return len(self.manipulators.operating_points()) > 1
        if name == "time_varying" and not self.config["position_manipulator"]["time_varying"]["enabled"]:
            return False
        if name == "wristalyzer_pooled" and not self.manipulators.periods_suffice():
            return False
        if part.tables and self.config["study"]["reported"] is None:
            return False
        # fewer printed numbers than constants determine nothing
        told = all(len(self.thesis.conditions(table)) >= LEAST_COLUMNS for table in part.tables)
        return set(part.needs) <= set(self.experiments) and told

    @property
    def repeats_thesis(self) -> bool:
        """All experiments of the thesis are simulated and compared with it: the report is the article."""
        compared = self.config["study"]["reported"] is not None and set(OF_THESIS) <= set(self.experiments)
        return compared and all(len(self.simulated(e)) == len(self.conditions(e)) for e in self.experiments)

    def of_foot(self, pattern: str) -> list[str]:
        """The pattern filled in for every trial of the dummy with a torque from the foot."""
        return self.of_trials(pattern, "dummy") if self.has("foot") else []

    def of_trial(self, experiment: str, condition: str) -> dict:
        """Settings of an experiment for one trial: names, belt and weight of its row, its person."""
        row = self.trials[experiment, condition]
        section = with_names(self.settings[experiment], row.names)
        if EXPERIMENTS[experiment].on_plate:
            section["belt"] = self.treadmill.belt_of(experiment, condition)
        if experiment == "standing":
            section["person"] = self.person(row.participant)
        if experiment in ("weight", "empty"):
            # the empty belt is analysed as a weight of nothing
            section["weight"] = self.treadmill.weight_of(experiment, condition)
            section["analysis"] = self.settings["weight"]["analysis"]
        return section

    def for_ingest(self, experiment: str, condition: str) -> dict:
        """Settings of a trial that its ingest reads; those of a whole recording only if it is one."""
        section = self.of_trial(experiment, condition)
        if "recording" in section and not self.is_one_file(experiment, condition):
            section["recording"] = None
        return pick(section, *EXPERIMENTS[experiment].ingest_reads)

    def settings_of(self, experiment: str, condition: str) -> dict:
        """All settings, with those of one trial for its experiment."""
        return self.settings | {experiment: self.of_trial(experiment, condition)}

    def person(self, participant: str | None) -> dict:
        """Settings of a person: those of the configuration, with what is known of a participant."""
        return person_of(self.settings["standing"], participant, self.people or {})

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

    def raw_inputs(self, experiment: str, condition: str, results: str) -> list[str]:
        """Raw files of a trial that jobs of this study make: none of a recorded one."""
        made = self.trials[experiment, condition].source == "virtual_lab"
        return list(self.raw_files(experiment, condition, results).values()) if made else []

    def is_one_file(self, experiment: str, condition: str) -> bool:
        """Whether a trial on the plate treadmill is one recording, without a calibration of its own."""
        row = self.trials[experiment, condition]
        return row.source == "recorded" and "calibration" not in row.files

    def simulated_walk(self, condition: str) -> dict:
        """Pulses and kind of file of a simulated trial of walking."""
        return self.config["walking"]["simulated"]["trials"][condition]

    def shown(self, experiment: str, wanted: str, role: str | None = None) -> str:
        """The configured condition; if the study lacks it, the last of its role in the sheet."""
        names = [c for c, own in self.roles(experiment).items() if role in (None, own)]
        if experiment == "weight":
            names = [c for c in names if c in self.treadmill.usual_weight()] or names
        return last_unless(wanted, names)

    def shown_several(self, experiment: str, wanted: list[str]) -> list[str]:
        """The configured conditions that the study has, or all if it has none of them."""
        names = self.treadmill.usual_weight() if experiment == "weight" else self.conditions(experiment)
        return [name for name in names if name in wanted] or names

    def shown_plate(self) -> str:
        """Calibration that figures and report show: that of the belt of the example trial with the weight."""
        example = self.shown("weight", self.settings["weight"]["example_condition"], role="validate")
        return self.treadmill.plate_of(self.treadmill.belt_of("weight", example))

    def examples(self) -> list[tuple[str, str]]:
        """(experiment, condition) of one trial of each rig with markers: the one that figures show."""
        rigs = [name for name in ("dummy", "weight", "standing") if name in self.experiments]
        return [(name, self.shown(name, self.settings[name]["example_condition"])) for name in rigs]
