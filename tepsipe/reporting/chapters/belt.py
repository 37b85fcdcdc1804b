"""Chapter on a recorded treadmill: recommended model and lines of the ripple."""

import pandas as pd

from tepsipe.io.result import Result
from tepsipe.reporting.run import Run
from tepsipe.treadmill.registry import MODEL_MEANINGS

# models that need the measured load of the past, besides the motion of the belt
WITH_LOAD = ("ripple-tracking",)
# gain of R² (-) for which a larger model is recommended
WORTH = 0.005


def numbers(run: Run) -> dict:
    """Recommended model, lines of the ripple (cycles per metre) and meanings of the models."""
    return {
        "recommended": _smallest_good(run),
        "tracked_orders_per_m": sorted(_fit(run).arrays.get("ripple/tracked_orders", ())),
        "meanings": MODEL_MEANINGS,
    }


def _fit(run: Run) -> Result:
    name = run.study["models"]["belt"]
    return run.fits[name][name]


def _scores(run: Run) -> pd.DataFrame:
    """Scores of the models on the first held-out recording, at the shown cutoff."""
    scores = run.tables[run.study["models"]["belt"]]
    shown_hz = float(run.settings["belt"]["analysis"]["shown_cutoff_hz"])
    wanted = (scores.test == _fit(run).facts["recordings"][0]) & (scores.cutoff_hz == shown_hz)
    return scores[wanted].set_index("model")


def _smallest_good(run: Run) -> str | None:
    """The smallest model whose R² is within `WORTH` of the best converged one; None if none predicts."""
    scores = _scores(run)
    known = scores[~scores.index.isin(WITH_LOAD) & scores.converged & (scores.r2 > 0.0)]
    good = known[known.r2 >= known.r2.max() - WORTH]
    return None if good.empty else good.order.idxmin()
