"""Section on the dummy that the printed tables describe: its joint at working amplitude."""

import math

from tepsipe.experiments.thesis_dummy.profile import LIMIT_95, last_match, profile
from tepsipe.mechanics.rubber_joint import RubberJoint
from tepsipe.reporting.run import Run

AMPLITUDES_RAD = (0.005, 0.01, 0.02, 0.03)
# VAF of an angle that matches, as in the claims (%)
MATCHED_PERCENT = 75.0


def numbers(run: Run) -> dict:
    """Linear joints nearest to the full law by amplitude, and profile over the lag (units in the keys).

    ``matched`` is the largest lag at which the angle of section 4-1-3 matches (`last_match`).
    """
    constants = _laws(run)[-1]["constants"]
    half = constants["half_softening_rad"]
    joint = RubberJoint(**(constants | {"half_softening_rad": math.inf if half is None else half}))
    linear = {a: joint.linearised(a) for a in AMPLITUDES_RAD}
    return {
        "at_work": [
            {"amplitude_rad": a, "K_Nm_per_rad": own[0], "B_Nms_per_rad": own[1]} for a, own in linear.items()
        ],
        "profile": _profile(run),
        "matched": last_match(_timing(run), MATCHED_PERCENT),
        "matched_percent": MATCHED_PERCENT,
    }


def _laws(run: Run) -> list[dict]:
    """Fitted laws of the joint, the full law last."""
    return list(run.facts["thesis_dummy"]["thesis_dummy"]["laws"].values())


def full_law_predicts_best(run: Run) -> bool:
    """The full law predicts one table from the other with the smallest distance of all laws."""
    *simpler, full = (law["predicted_rms"] for law in _laws(run))
    return full < min(simpler)


def copy_predicts_best(run: Run) -> bool:
    """A copy of the other table is closer to the printed numbers than the prediction of every law."""
    null = run.facts["thesis_dummy"]["thesis_dummy"]["null_rms"]
    return null < min(law["predicted_rms"] for law in _laws(run))


def lag_bounded(run: Run) -> bool:
    """The printed numbers bound the lag of the ankle on both sides, within the range of the fits."""
    return None not in _profile(run)["lags_s"]


def unlagged_unlikely(run: Run) -> bool:
    """Without a lag of the ankle, the printed numbers are less likely than their 95 % limit allows."""
    return _profile(run)["unlagged"]["over_least"] > LIMIT_95


def _timing(run: Run) -> dict:
    return run.facts["thesis_dummy"]["thesis_dummy"]["timing"]


def _profile(run: Run) -> dict:
    return profile(_timing(run))


PREDICATES = (full_law_predicts_best, copy_predicts_best, lag_bounded, unlagged_unlikely)
