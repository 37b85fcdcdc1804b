"""Chapter on a recorded treadmill: recommended models, lines of the ripple, conditions of sentences."""

import pandas as pd

from tepsipe.io.result import Result
from tepsipe.reporting.run import Run
from tepsipe.treadmill.registry import MODEL_MEANINGS

# models that need the measured load of the past, besides the motion of the belt
WITH_LOAD = ("ripple-tracking",)
# models that look ahead, and so delay a compensation in real time
AHEAD = ("fir", "spectral")
# gain of R² (-) for which a larger model is recommended
WORTH = 0.005
# gain of R² by a lead that counts (-)
CLEAR_GAIN = 0.005


def numbers(run: Run) -> dict:
    """Recommended models, lines of the ripple (cycles per metre) and meanings of the models."""
    return {
        "recommended": _smallest_good(run, WITH_LOAD),
        "recommended_live": _smallest_good(run, (*WITH_LOAD, *AHEAD)),
        "tracked_orders_per_m": sorted(_fit(run).arrays.get("ripple/tracked_orders", ())),
        "meanings": MODEL_MEANINGS,
    }


def _fit(run: Run) -> Result:
    name = run.study["models"]["belt"]
    return run.fits[name][name]


def _scores(run: Run, shown: bool = True) -> pd.DataFrame:
    """Scores of the models on the first held-out recording, at the shown or the highest cutoff."""
    scores = run.tables[run.study["models"]["belt"]]
    shown_hz = float(run.settings["belt"]["analysis"]["shown_cutoff_hz"])
    cutoff_hz = shown_hz if shown else scores.cutoff_hz.max()
    wanted = (scores.test == _fit(run).facts["recordings"][0]) & (scores.cutoff_hz == cutoff_hz)
    return scores[wanted].set_index("model")


def _smallest_good(run: Run, without: tuple[str, ...]) -> str | None:
    """The smallest model whose R² is within `WORTH` of the best converged one; None if none predicts."""
    scores = _scores(run)
    known = scores[~scores.index.isin(without) & scores.converged & (scores.r2 > 0.0)]
    good = known[known.r2 >= known.r2.max() - WORTH]
    return None if good.empty else good.order.idxmin()


# ---- conditions of sentences


def something_predicts(run: Run) -> bool:
    """A model of the belt's motion predicts a part of the load."""
    return _smallest_good(run, WITH_LOAD) is not None


def nothing_predicts(run: Run) -> bool:
    """No model of the belt's motion predicts any part of the load."""
    return not something_predicts(run)


def recommended_is_ahead(run: Run) -> bool:
    """The recommended model looks ahead; another one predicts in real time."""
    return _smallest_good(run, WITH_LOAD) in AHEAD and _live_differs(run)


def smaller_live(run: Run) -> bool:
    """The recommended model does not look ahead; a smaller one is about the best in real time."""
    return _smallest_good(run, WITH_LOAD) not in AHEAD and _live_differs(run)


def _live_differs(run: Run) -> bool:
    live = _smallest_good(run, (*WITH_LOAD, *AHEAD))
    return live is not None and live != _smallest_good(run, WITH_LOAD)


def linear(run: Run) -> bool:
    """A model without tracking of ripple was fitted."""
    return len(_linear(run)) > 0


def linear_predicts(run: Run) -> bool:
    """The best model without tracking of ripple predicts more than the mean of the load."""
    return bool((_linear(run) > 0.0).any())


def _linear(run: Run) -> pd.Series:
    return _scores(run).r2.drop("ripple-tracking", errors="ignore")


def chosen(run: Run) -> bool:
    """The chosen model was fitted."""
    return run.settings["belt"].get("chosen") in _scores(run).index


def lead_helps(run: Run) -> bool:
    """At the highest cutoff an impulse response with a lead is clearly better than a causal one."""
    r2 = _scores(run, shown=False).r2
    return {"fir", "fir-causal"} <= set(r2.index) and r2["fir"] - r2["fir-causal"] > CLEAR_GAIN


def tracked(run: Run) -> bool:
    """A model of the family tracks ripple."""
    return "ripple-tracking" in _scores(run).index


def lines(run: Run) -> bool:
    """Ripple was tracked at one line or more."""
    return tracked(run) and len(_fit(run).arrays.get("ripple/tracked_orders", ())) > 0


def no_lines(run: Run) -> bool:
    """A model tracks ripple, and the residual has no line."""
    return tracked(run) and not lines(run)


def tracking_useless(run: Run) -> bool:
    """With tracking of ripple R² is not higher than with the best model without."""
    return tracked(run) and linear(run) and not _scores(run).r2["ripple-tracking"] > _linear(run).max()


PREDICATES = (
    something_predicts,
    nothing_predicts,
    recommended_is_ahead,
    smaller_live,
    linear,
    linear_predicts,
    chosen,
    lead_helps,
    tracked,
    lines,
    no_lines,
    tracking_useless,
)
