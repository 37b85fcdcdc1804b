"""Results of a run, against which statements of the thesis are tested."""

from dataclasses import dataclass, field

from tepsipe.experiments.forward.scores import ForwardScore
from tepsipe.experiments.noise.rows import NoiseRow
from tepsipe.experiments.wristalyzer import names as wristalyzer
from tepsipe.io.estimates import Estimate
from tepsipe.io.result import Result
from tepsipe.reporting.planned import PlannedRow
from tepsipe.reporting.thesis_tables import TABLE_COLUMNS, TableRow
from tepsipe.treadmill.calibration import ModelScore

WRISTALYZER_TABLE, NOISE_TABLE = "table_4_1", "table_4_4"


@dataclass(frozen=True)
class Findings:
    """Results of this run against which claims are tested."""

    estimates: list[Estimate]
    """All estimates (units in them)."""
    fits: dict[str, dict[str, Result]]
    """Experiment -> condition -> fit."""
    as_printed: str
    """Pathway that reproduces the thesis."""
    scores: list[ModelScore] = field(default_factory=list)
    """Scores of the treadmill models (units in them)."""
    forward: list[ForwardScore] = field(default_factory=list)
    """Scores of the forward simulations (%)."""
    table_4_4: list[TableRow] = field(default_factory=list)
    """Rows of Table 4-4 (units in them)."""
    noise: list[NoiseRow] = field(default_factory=list)
    """Rows of the noise study (units in them)."""
    recorded: bool = False
    """Whether no trial of manipulator and dummy was simulated: nothing was fitted or predicted."""
    planned: list[PlannedRow] = field(default_factory=list)
    """What the planning says about the thesis's experiments (units in them)."""

    def score(self, model: str, train: str, test: str, load: str, cutoff_hz: float) -> float:
        """R2 (-) of a treadmill model."""
        wanted = (model, train, test, load, cutoff_hz)
        for s in self.scores:
            if (s.model, s.train, s.test, s.load, s.cutoff_hz) == wanted:
                return s.r2
        raise KeyError(wanted)

    def followed(self, parameter_set: str, quantity: str) -> list[float]:
        """VAF over the trial (%) of a simulated quantity, condition by condition."""
        wanted = (parameter_set, quantity)
        return [s.vaf_trial for s in self.forward if (s.parameter_set, s.quantity) == wanted]

    def noisy(self, estimator: str, quantity: str, noise_on: str) -> float:
        """Cell of Table 4-4 for the first simulated stiffness (unit of the quantity)."""
        for row in self.table_4_4:
            if (row.pathway, row.quantity) == (estimator, quantity):
                value = row.values[TABLE_COLUMNS.index(noise_on)]
                if value is not None:
                    return value
        raise KeyError(quantity)

    def by_condition(self, experiment: str, quantity: str, pathway: str | None = None) -> dict:
        """Condition -> value of a quantity (unit of the quantity), as printed."""
        if experiment not in self.fits:
            raise KeyError(experiment)
        pathways = {"wristalyzer": wristalyzer.PATHWAY, "dummy": pathway or self.as_printed}
        return {
            e.condition: e.value
            for e in self.estimates
            if e.experiment == experiment
            and e.quantity == quantity
            and e.pathway == pathways.get(experiment, "force")
            and (experiment != "wristalyzer" or e.estimator == wristalyzer.AS_PRINTED)
        }


def findings_of_cells(cells: dict[tuple[str, str, str], float], as_printed: str) -> Findings:
    """Findings of a study that consists of printed cells: what a measure is by the thesis's own numbers.

    cells: (table, row, column) -> number (unit of the row), as `tepsipe.reporting.ledger` has them.
    as_printed: pathway of Tables 4-2 and 4-3.
    Returns: estimates with their SEMs, and the rows of Table 4-4; nothing else.
    """
    estimates, noise = [], {}
    for (table, row, column), value in cells.items():
        if table == NOISE_TABLE:
            noise.setdefault(row, {})[column] = value
        elif not row.startswith("SEM_"):
            sem = cells.get((table, f"SEM_{row}", column))
            names = (
                ("wristalyzer", column, wristalyzer.PATHWAY, wristalyzer.AS_PRINTED)
                if table == WRISTALYZER_TABLE
                else ("dummy", column, as_printed, "printed")
            )
            estimates.append(Estimate(*names, row, "as printed", value, sem_as_printed=sem))
    nothing = [None] * len(TABLE_COLUMNS)
    rows = []
    for row, columns in noise.items():
        values = [columns.get(column) for column in TABLE_COLUMNS]
        true = [values[0], *nothing[1:]]
        rows.append(TableRow("as-tabulated", "printed", row, "as printed", values, nothing))
        rows.append(TableRow("recommended-regression", "printed", row, "as printed", true, nothing))
    fits = {e.experiment: {} for e in estimates}
    return Findings(estimates, fits, as_printed, table_4_4=rows)
