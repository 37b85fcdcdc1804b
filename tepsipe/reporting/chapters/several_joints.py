"""Report on planned experiments, several joints: conditions of its sentences."""

import pandas as pd

from tepsipe.experiments.planning.several_joints import UNKNOWN, WITHIN
from tepsipe.reporting.run import Run

TESTS_SYMMETRY = 3  # perturbations of ankle, knee and hip that determine both halves of a matrix


def numbers(run: Run) -> dict:
    """Nothing: tables have all numbers."""
    return {}


def _sets(run: Run, *, identified: bool) -> pd.DataFrame:
    return run.rows("several_joints", identified=identified)


def identified(run: Run) -> bool:
    """Some set of perturbations identifies K and B."""
    return len(_sets(run, identified=True)) > 0


def values_found(run: Run) -> bool:
    """Sets that identify K and B have values in recordings."""
    return bool((_sets(run, identified=True).quoted_percent > 0.0).any())


def others_refused(run: Run) -> bool:
    """There are sets that do not identify K and B, and none of these has a value in any recording."""
    others = _sets(run, identified=False)
    return len(others) > 0 and bool((others.quoted_percent == 0.0).all())


def others_have_values(run: Run) -> bool:
    """Sets that do not identify K and B have values in some recordings."""
    return bool((_sets(run, identified=False).quoted_percent > 0.0).any())


def _belt_refused(run: Run) -> list[bool]:
    belt = run.rows("several_joints", perturbations="belt")
    return belt.statement.str.startswith("No values: ").tolist()


def belt_insufficient(run: Run) -> bool:
    """The belt alone gives no values."""
    return any(_belt_refused(run))


def belt_sufficient(run: Run) -> bool:
    """The belt alone gives values."""
    return _belt_refused(run) == [False]


def _models(run: Run, **wanted: object) -> pd.DataFrame:
    """Rows of models, for the window of the recordings."""
    window_s = run.settings["plan"]["several_joints"]["protocol"]["after_s"]
    return run.rows("several_joints_models", window_s=window_s, **wanted)


def _least_if_symmetric(run: Run) -> float:
    """Least number of perturbations that identifies symmetric matrices; NaN if none does."""
    return _models(run, matrices="symmetric", inertia=WITHIN, identified=True).number.min()


def symmetric_identified(run: Run) -> bool:
    """Some set identifies symmetric matrices."""
    return _least_if_symmetric(run) > 0


def symmetry_untested(run: Run) -> bool:
    """The least sets that identify symmetric matrices are too small to test the symmetry."""
    return _least_if_symmetric(run) < TESTS_SYMMETRY


def scale_open(run: Run) -> bool:
    """With an unknown inertia, the belt alone identifies K and B in no model."""
    belt = _models(run, inertia=UNKNOWN, perturbations="belt")
    return len(belt) > 0 and not belt.identified.any()


def other_windows(run: Run) -> bool:
    """Other windows were tried than the one of the recordings."""
    rows = run.rows("several_joints_models", matrices="any", inertia=WITHIN)
    return len(rows) > len(_models(run, matrices="any", inertia=WITHIN))


def inertia_neglected(run: Run) -> bool:
    """Errors of K were predicted for an inertia that is taken as exact."""
    elements = run.rows("several_joints_elements")
    own = elements[elements.quantity.str.startswith("K_")]
    return bool(own.neglected_inertia_u_percent.notna().any())


PREDICATES = (
    identified,
    values_found,
    others_refused,
    others_have_values,
    belt_insufficient,
    belt_sufficient,
    symmetric_identified,
    symmetry_untested,
    scale_open,
    other_windows,
    inertia_neglected,
)
