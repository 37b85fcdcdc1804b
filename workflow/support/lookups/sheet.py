"""Trials of a study: which there are, and their rows."""

from tepsipe.experiments.registry import EXPERIMENTS
from workflow.support.row_names import named_by
from workflow.support.trial_sheet import TrialRow


class Sheet:
    """Trials of the trial sheet.

    ``trials`` maps (experiment, condition) to rows, in the order of the sheet; ``experiments`` are those with
    trials.
    """

    def __init__(self, trials: dict[tuple, TrialRow]) -> None:
        self.trials = trials
        self.experiments = list(dict.fromkeys(experiment for experiment, _ in trials))

    @property
    def by_participant(self) -> bool:
        """True if the sheet names participants."""
        return any(row.participant for row in self.trials.values())

    @property
    def by_belt(self) -> bool:
        """True if the sheet names the belts of its trials."""
        return any(row.belt for row in self.trials.values())

    def conditions(self, experiment: str) -> list[str]:
        """Conditions of an experiment in the order of the trial sheet."""
        return [condition for name, condition in self.trials if name == experiment]

    def simulated(self, experiment: str) -> list[str]:
        """Conditions of an experiment that are simulated."""
        names = self.conditions(experiment)
        return [c for c in names if self.trials[experiment, c].source == "virtual_lab"]

    def recorded(self, experiment: str) -> list[str]:
        """Conditions of an experiment that are not simulated."""
        made = self.simulated(experiment)
        return [c for c in self.conditions(experiment) if c not in made]

    def all_conditions(self, fitted: bool = False) -> dict[str, list[str]]:
        """Experiment -> its conditions; if ``fitted``, of those whose trials have fits of their own."""
        return {e: self.conditions(e) for e in self.experiments if EXPERIMENTS[e].fitted or not fitted}

    def all_simulated(self) -> dict[str, list[str]]:
        """Experiment -> conditions that are simulated."""
        return {experiment: self.simulated(experiment) for experiment in self.experiments}

    def of_trials(self, pattern: str, experiment: str) -> list[str]:
        """The pattern filled in for every condition of an experiment."""
        return [pattern.format(condition=condition) for condition in self.conditions(experiment)]

    def roles(self, experiment: str) -> dict[str, str]:
        """Condition -> calibrate or validate."""
        return {c: self.trials[experiment, c].role for c in self.conditions(experiment)}

    def amplitudes(self, experiment: str) -> dict[str, float | None]:
        """Condition -> velocity amplitude (m/s), None where the sheet has none."""
        return {c: self.trials[experiment, c].amplitude for c in self.conditions(experiment)}

    def extremes(self, experiment: str) -> list[str]:
        """First simulated condition with the smallest velocity amplitude, and first with the largest."""
        made, amplitudes = self.simulated(experiment), self.amplitudes(experiment)
        found = [choose(made, key=lambda c: amplitudes[c] or 0.0) for choose in (min, max)] if made else []
        return list(dict.fromkeys(found))

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

    def timing(self) -> dict[str, dict[str, list]]:
        """Experiment -> all durations (s), shortest and longest intervals (s), and amplitudes of its trials.

        Amplitudes are peak velocities (m/s), and scale factors of the Wristalyzer.
        """
        found: dict[str, dict[str, list]] = {}
        for (experiment, _), row in self.trials.items():
            own = found.setdefault(experiment, {"durations_s": [], "intervals_s": [], "amplitudes": []})
            interval = None if row.interval_s is None else [row.interval_s, row.longest_interval_s]
            for values, value in zip(own.values(), (row.duration_s, interval, row.amplitude), strict=True):
                if value is not None and value not in values:
                    values.append(value)
        return found

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

    def named(self, experiment: str, condition: str) -> dict[str, str]:
        """Participant and belt of a trial, where its row names them: they stand in the trial's file."""
        row = self.trials[experiment, condition]
        return {key: getattr(row, key) for key in ("participant", "belt") if getattr(row, key)}

    def named_by(self, experiment: str, condition: str) -> dict[str, dict[str, str]]:
        """Table of columns -> its key -> column of the trial sheet that names it, for messages."""
        names = self.trials[experiment, condition].names
        return {
            table: named_by(experiment, names, f"files.{table}") for table in EXPERIMENTS[experiment].tables
        }

    def participants(self, experiment: str) -> list[str]:
        """Participants of an experiment, in the order of their names."""
        found = {self.trials[experiment, c].participant for c in self.conditions(experiment)}
        return sorted(found - {None})


def last_unless(wanted: str, names: list[str]) -> str:
    """The wanted name if it is there, or if there is none; otherwise the last one."""
    return wanted if wanted in names or not names else names[-1]
