"""Chapter on the plan of the thesis's experiments: conditions of its sentences."""

from tepsipe.reporting.planned import LEAST, RATIO
from tepsipe.reporting.run import Run

# a filter changes nothing below this, and distorts above the other (%)
NOTHING_PERCENT, DISTORTED_PERCENT = 0.5, 5.0


def numbers(run: Run) -> dict:
    """No numbers: the chapter reads them from the table of the plan."""
    return {}


def _changes(run: Run, design: str) -> list[float]:
    """Change of I, B and K by a filter (%)."""
    return [abs(x) for x in run.rows("planned", design=design, measure="change").value]


def _ratio(run: Run, design: str, measure: str = RATIO) -> float:
    """Standard uncertainty of K with the best pulse of a kind, by that of the sine; infinite without one."""
    rows = run.rows("planned", design=design, measure=measure, quantity="K")
    return float(rows.value.iloc[0]) if len(rows) else float("inf")


# ---- conditions of sentences


def filter_of_both_changes_nothing(run: Run) -> bool:
    """A filter of torque and motion changes I, B and K by less than 0.5 %."""
    found = [x for kind in ("zero-lag", "one-sided") for x in _changes(run, f"{kind}, all signals")]
    return bool(found) and max(found) < NOTHING_PERCENT


def filter_of_one_distorts(run: Run) -> bool:
    """Each filter of the torque alone changes some parameter by more than 5 %."""
    found = [_changes(run, f"{kind}, torque only") for kind in ("zero-lag", "one-sided")]
    return all(own and max(own) > DISTORTED_PERCENT for own in found)


def one_sided_filter_worst(run: Run) -> bool:
    """A one-sided filter of the torque alone changes every parameter more than a zero-lag one does."""
    lagging, zero_lag = (_changes(run, f"{kind}, torque only") for kind in ("one-sided", "zero-lag"))
    return bool(lagging) and all(a > b for a, b in zip(lagging, zero_lag, strict=True))


def no_returning_pulse_halves(run: Run) -> bool:
    """Even the smallest bound of a pulse that returns the belt exceeds half of the sine's uncertainty."""
    design = "best, belt returns"
    return 0.5 < _ratio(run, design) * _ratio(run, design, LEAST) < float("inf")


def best_one_way_pulse_halves(run: Run) -> bool:
    """The best pulse that leaves the belt displaced gives at most half of the uncertainty of the sine."""
    return _ratio(run, "best, one way") <= 0.5


PREDICATES = (
    filter_of_both_changes_nothing,
    filter_of_one_distorts,
    one_sided_filter_worst,
    no_returning_pulse_halves,
    best_one_way_pulse_halves,
)
