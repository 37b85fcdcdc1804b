"""Tables of the thesis that a study can be compared with."""

from tepsipe.experiments.registry import EXPERIMENTS
from tepsipe.experiments.wristalyzer.names import IN_TABLE, PATHWAY
from workflow.support.lookups.sheet import Sheet


class ThesisTables:
    """Tables of the thesis with conditions in the study."""

    def __init__(self, sheet: Sheet, settings: dict) -> None:
        self.sheet, self.settings = sheet, settings

    def tables(self) -> dict[str, str]:
        """Thesis table -> its experiment, for the tables that have conditions in this study."""
        tables = {name: e for e in self.sheet.experiments for name in EXPERIMENTS[e].thesis_tables}
        return {name: e for name, e in tables.items() if self.conditions(name)}

    def conditions(self, table: str) -> list[str]:
        """Columns of a thesis table."""
        experiment = table_experiment(table)
        begins = EXPERIMENTS[experiment].thesis_tables[table]
        return [c for c in self.sheet.conditions(experiment) if c.startswith(begins)]

    def pathways(self, table: str) -> list[list]:
        """[pathway, estimator or None] of the thesis as printed, and as recommended."""
        if table_experiment(table) == "wristalyzer":
            return [[PATHWAY, name] for name in IN_TABLE]
        return [[self.settings["dummy"][key], None] for key in ("as_printed", "recommended")]


def table_experiment(table: str) -> str:
    """The experiment of a thesis table."""
    return next(name for name, experiment in EXPERIMENTS.items() if table in experiment.thesis_tables)
