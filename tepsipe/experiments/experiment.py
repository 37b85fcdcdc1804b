"""An experiment as one object: what a study must know of it before any trial is read.

The object of an experiment stands in the ``__init__`` of its folder. Its parts are modules of that folder and
are imported by name when they are needed, so that a study knows all experiments without numpy, and a job
reaches the part that it runs and no other.
"""

from dataclasses import dataclass, field
from importlib import import_module
from types import ModuleType


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """Properties of an experiment, and the folder of its parts."""

    name: str
    """Its name in the trial sheet, in settings and in results."""
    folder: str = ""
    """Folder of its parts in `tepsipe.experiments`, by default its name."""
    raw_files: dict[str, str | None]
    """Kind of raw file, a column of the sheet -> name in the virtual laboratory, None if that makes none."""
    optional_files: tuple[str, ...] = ()
    """Kinds of raw file that a recorded trial may lack."""
    purposes: tuple[str, ...] = ()
    """Purposes of raw files whose format follows from their contents (`tepsipe.io.formats.MODULES`)."""
    settings: str = ""
    """Dataclass of its settings in a module of its folder, such as ``fit.Settings``; empty where
    `workflow/settings` has the model of its section."""
    ingest_reads: tuple[str, ...] = ()
    """Settings that its ingest reads, as paths in its section: ``*`` stands for every key, and a path after
    ``-`` is left out."""
    fit_reads: tuple[str, ...] = ()
    """Settings that the fit of a trial reads; likewise."""
    fit_takes: tuple[str, ...] = ()
    """Further arguments of the fit: seed, uncertainty (sources), models and calibrations of the plates."""
    further: tuple[str, ...] = ()
    """Further results of the fit, beside estimates and, if it takes its sources, uncertainty."""
    drawn_of: tuple[str, ...] = ()
    """Results of its trials of which its figures are drawn: fits, estimates; none where a rule of its own
    draws them."""
    profiles: tuple[str, ...] = ()
    """Perturbation profiles of simulated trials."""
    pulsed: bool = True
    """Whether perturbations are separate pulses."""
    at_random: bool = False
    """Whether their intervals may be a range."""
    models: str | None = None
    """Models of the treadmill that its trials calibrate or validate."""
    tasks: tuple[str, ...] = ()
    """Tasks of the simulated person, a recorded one may have any; empty if trials have no task."""
    names: dict[str, str] = field(default_factory=dict)
    """Column of the sheet -> setting of the experiment that it overrides for its trial: names of a table's
    columns or of a file's channels, units and signs."""
    named: tuple[str, ...] = ()
    """Those without such a setting, which every row must fill in."""
    of_people: bool = False
    """Whether trials may name a participant."""
    on_plate: bool = False
    """Whether trials are on a belt of the plate treadmill, left or right."""
    fitted: bool = True
    """Whether each trial has its own fit and estimates."""
    budgets: bool = False
    """Whether each fit writes an uncertainty budget."""
    cross_validated: bool = False
    """Whether the parameters of each trial predict all trials."""
    thesis_tables: dict[str, str] = field(default_factory=dict)
    """Table of the thesis -> common beginning of the names of its conditions."""
    printed: tuple[str, ...] = ()
    """Settings that the report prints."""
    true: tuple[str, ...] = ()
    """Constants of the laboratory, as the truth of the estimates."""

    def __post_init__(self):
        """Name the folder."""
        object.__setattr__(self, "folder", self.folder or self.name)

    def module(self, part: str) -> str:
        """Name of the module of one of its parts, such as ``ingest``."""
        return f"{__package__}.{self.folder}.{part}"

    def part(self, part: str) -> ModuleType:
        """The module of one of its parts, imported when it is asked for."""
        return import_module(self.module(part))

    @property
    def options(self) -> type:
        """The dataclass of its settings, imported when it is asked for."""
        module, name = self.settings.split(".")
        return getattr(self.part(module), name)

    @property
    def tables(self) -> tuple[str, ...]:
        """Settings of its files that name the columns of a table, which rows of the sheet may override."""
        settings = [setting.split(".") for setting in self.names.values()]
        return tuple(dict.fromkeys(part[1] for part in settings if part[0] == "files" and len(part) == 3))


# shared by the experiments on the plate treadmill
PULSES = ("sine", "minjerk")
TREADMILL_FILES: dict[str, str | None] = {"log": "log.mat", "calibration": "calibration.csv"}
# channels of a log that holds the whole trial
CHANNELS = {
    "velocity_column": "recording.belt_velocity.channel",
    "command_column": "recording.belt_command.channel",
    "trigger_column": "recording.trigger",
}
