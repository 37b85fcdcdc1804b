"""Chapter on the forward simulation: names of the simulated joints, and conditions of its sentences."""

import pandas as pd

from tepsipe.reporting.figures.names import PARAMETER_SETS
from tepsipe.reporting.run import Run


def numbers(run: Run) -> dict:
    """Labels of the sets of parameters (N·m·s²/rad, N·m·s/rad, N·m/rad), in the order of the figures."""
    known = set(run.tables["forward"].parameter_set)
    return {"parameter_sets": {name: label for name, label in PARAMETER_SETS.items() if name in known}}


def _of_trials(run: Run, parameter_set: str, quantity: str) -> pd.Series:
    """VAF over the full dataset."""
    return run.rows("forward", parameter_set=parameter_set, quantity=quantity).vaf_trial


# ---- conditions of sentences


def compared(run: Run) -> bool:
    """The dummy was simulated with all three sets of parameters."""
    return set(PARAMETER_SETS) <= set(run.tables["forward"].parameter_set)


def pattern_of_thesis(run: Run) -> bool:
    """The Wristalyzer's parameters always predict the angle better, the printed ones the printed torque."""
    angle, torque = (
        _of_trials(run, better, quantity).min() > _of_trials(run, worse, quantity).max()
        for better, worse, quantity in (("wristalyzer", "tep", "theta"), ("tep", "wristalyzer", "tau"))
    )
    return bool(angle and torque)


def printed_swing_grows(run: Run) -> bool:
    """With the printed parameters the swing grows in some condition."""
    return len(run.rows("forward", parameter_set="tep", state="grows")) > 0


def first_shown(run: Run) -> bool:
    """The trial of Figure 4-7 was simulated."""
    return len(run.rows("forward", condition=run.study["simulated"]["4_7"])) > 0


def second_shown(run: Run) -> bool:
    """The trial of Figure 4-8 was simulated."""
    return len(run.rows("forward", condition=run.study["simulated"]["4_8"])) > 0


PREDICATES = (compared, pattern_of_thesis, printed_swing_grows, first_shown, second_shown)
