"""Run that a report is written from, with tables, fits and settings; and its raw content for report.json."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import ModuleType

import numpy as np
import pandas as pd

from tepsipe.drawing.names import short_name, words
from tepsipe.io.result import Result
from tepsipe.quantities import UNIT_SYMBOLS


@dataclass(frozen=True)
class Run:
    """Results of a run, and facts about its study."""

    tables: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    """Name of a table -> its rows (units in them, or in the names of columns)."""
    fits: Mapping[str, Mapping[str, Result]] = field(default_factory=dict)
    """Group, mostly an experiment, -> name of a fit, mostly a condition, -> its result."""
    settings: Mapping = field(default_factory=dict)
    """Settings that the report prints, by experiment and part (units in the keys)."""
    study: Mapping = field(default_factory=dict)
    """Facts about the study: conditions, what is shown, values of the thesis (units in the keys)."""
    provenance: Mapping = field(default_factory=dict)
    """Record of code, packages and files that the run was made from."""

    def rows(self, table: str, **wanted: object) -> pd.DataFrame:
        """Rows of a table (units in them) that have these values in these columns; none without the table."""
        rows = self.tables.get(table)
        if rows is None:
            return pd.DataFrame(columns=["condition", "value", *wanted])
        for column, value in wanted.items():
            rows = rows[rows[column] == value]
        return rows

    def values(self, experiment: str, quantity: str, **wanted: object) -> pd.Series:
        """Estimates of a quantity (its unit) by condition."""
        rows = self.rows("estimates", experiment=experiment, quantity=quantity, **wanted)
        return rows.set_index("condition").value

    @property
    def simulated(self) -> bool:
        """Some trials were made by the virtual laboratory."""
        return any(self.study["made"].values())

    @property
    def facts(self) -> dict:
        """Group -> name of a fit -> its facts (units in the keys)."""
        return {group: {name: fit.facts for name, fit in fits.items()} for group, fits in self.fits.items()}


def about_study(run: Run) -> dict:
    """Title, numbers of trials and settings of a study (units in the keys), for all chapters."""
    experiments = run.study["experiments"]
    return {
        "title": run.study["title"],
        "recordings_source": run.study["recordings_source"],
        "experiments": list(experiments),
        "trials": sum(map(len, experiments.values())),
        "made": sum(map(len, run.study["made"].values())),
        "choices": run.settings,
    }


def report_content(run: Run, chapters: Mapping[str, ModuleType]) -> dict:
    """Raw content of report.json: numbers and truth values, no text of the report.

    chapters: name -> one of `tepsipe.reporting.chapters`, with as for `chapter_content`.
    Returns: keys of `about_study`; ``study``; ``facts`` of all fits (units in the keys); ``tables_read``,
    names of the tables that Typst reads itself; ``chapters``: name -> `chapter_content`; ``units``,
    ``short_names`` of conditions, and ``names`` of pathways, estimators and models as the report shows
    them.
    """
    neutral = run.study.get("reported") is None
    conditions = {name for rows in run.tables.values() if "condition" in rows for name in rows.condition}
    return raw(
        {
            **about_study(run),
            "study": run.study,
            "tables_read": list(run.tables),
            "facts": run.facts,
            "chapters": {name: chapter_content(chapter, run) for name, chapter in chapters.items()},
            "units": UNIT_SYMBOLS,
            "short_names": {name: short_name(name) for name in sorted(map(str, conditions))},
            "names": {name: words(name, neutral) for name in _identifiers(run)},
        }
    )


def _identifiers(run: Run) -> list[str]:
    """Pathways, estimators and models in the tables of a run and in its settings."""
    columns = ("pathway", "estimator", "model")
    found = {name for rows in run.tables.values() for key in columns if key in rows for name in rows[key]}
    for section in run.settings.values():
        found |= {name for key in ("estimators", "table_estimators") for name in section.get(key) or ()}
    return sorted(map(str, found))


def chapter_content(chapter: ModuleType, run: Run) -> dict:
    """Raw content of a chapter.

    chapter: one of `tepsipe.reporting.chapters`: its function ``numbers`` and its ``PREDICATES``, if any.
    Returns: ``numbers``, as that function returns them (units in the keys), and ``holds``.
    """
    holds = {predicate.__name__: bool(predicate(run)) for predicate in predicates_of(chapter)}
    return {"numbers": chapter.numbers(run), "holds": holds}


def predicates_of(chapter: ModuleType) -> Sequence[Callable[[Run], bool]]:
    """Predicates of the sentences of a chapter; it may have none."""
    return getattr(chapter, "PREDICATES", ())


def raw(value: object) -> object:
    """A value (any unit) as JSON represents it: NaN as None, infinity as text, arrays as lists."""
    if isinstance(value, Mapping):
        return {str(key): raw(own) for key, own in value.items()}
    if isinstance(value, np.ndarray | pd.Series):
        return raw(value.tolist())
    if isinstance(value, list | tuple | set):
        return [raw(own) for own in value]
    if isinstance(value, np.generic):
        return raw(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else str(value)
    return value
