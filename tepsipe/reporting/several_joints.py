"""Tables of several joints: what every set of perturbations says about stiffness and damping."""

from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np

from tepsipe.experiments.planning.several_joints import (
    EXACT,
    JOINTS,
    UNKNOWN,
    WITHIN,
    Drawn,
    Epochs,
    Set,
    SetPrediction,
    neglected_inertia,
)
from tepsipe.identification.several_joints.matrices import Limits, Setting


def named(chosen: Set) -> str:
    """Names of a set joined by + (no unit)."""
    return "+".join(chosen)


def movement(row: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """Ratio of the joint angles (rad/rad) in a movement that is given in parts of 1/sqrt(K_ii) (-)."""
    turned = row / np.sqrt(np.diag(stiffness))
    return turned / turned[np.abs(turned).argmax()]


def _ratio(row: np.ndarray, stiffness: np.ndarray) -> str:
    return " : ".join(f"{x:.1f}".replace("-", "−") for x in movement(row, stiffness))


def statement(
    one: SetPrediction, stiffness: Annotated[np.ndarray, "(3, 3)", "N·m/rad"], limits: Limits
) -> str:
    """What a set of perturbations says, in a sentence or two.

    stiffness: expected K.
    limits: of what counts as determined.
    Returns: without numbers of single elements where the matrix is not determined (no unit).
    """
    known = one.known
    pairs = len(one.setting.pairs)
    if known.all:
        of_k, of_b = 196.0 * known.errors[:pairs].max(), 196.0 * known.errors[pairs : 2 * pairs].max()
        said = (
            f"All elements are determined: 95 % intervals within ±{of_k:.2g} % of sqrt(K_ii K_jj) and "
            f"±{of_b:.2g} % of sqrt(B_ii B_jj)."
        )
        if one.setting.symmetric and len(one.perturbations) < len(JOINTS):
            said += " They assume that K and B are symmetric, which these perturbations cannot test."
        return said
    said = f"No values: {known.rank} of {known.unknowns} combinations of the unknowns are determined."
    if one.scale_open:
        return said + (
            " The scale remains unknown: with another inertia, K and B in the same proportions yield the "
            "same response to the belt, however many epochs there are."
        )
    within = known.direction_errors <= limits.stiffness
    if within.any():
        ratios = " and ".join(_ratio(row, stiffness) for row in known.directions[within])
        said += f" K is determined for movements of ankle : knee : hip = {ratios}"
        rest = " and ".join(_ratio(row, stiffness) for row in known.directions[~within])
        said += f", but not for {rest}." if rest else "."
    else:
        said += " K is determined for no movement."
    return said


def _percent(x: float) -> float | str:
    return float(100.0 * x) if np.isfinite(x) else ""


def set_rows(
    predictions: Sequence[SetPrediction],
    drawn: Mapping[Set, Sequence[Drawn]],
    matrices: tuple[np.ndarray, np.ndarray],
    limits: Limits,
) -> list[dict]:
    """One row per set of perturbations: what is predicted, and what simulated persons show.

    limits: of what counts as determined.
    Returns: ``k_rms_percent`` in per cent of sqrt(K_ii K_jj), ``coverage_percent`` of the 95 % intervals of
    all quoted elements of K and B; both empty where nothing is quoted.
    """
    rows = []
    for one in predictions:
        errors, held, quoted = _scores(drawn[one.perturbations], matrices)
        k = errors[:, :9][quoted[:, :9]]
        pairs = len(one.setting.pairs)
        rows.append(
            {
                "perturbations": named(one.perturbations),
                "number": len(one.perturbations),
                "rank": one.known.rank,
                "unknowns": one.known.unknowns,
                "condition": one.known.condition,
                "identified": str(one.known.all).lower(),
                "k_rms_percent": float(100.0 * np.sqrt((k**2).mean())) if k.size else "",
                "coverage_percent": float(100.0 * held[quoted].mean()) if quoted.any() else "",
                "statement": statement(one, matrices[0], limits),
                "movements": int((one.known.direction_errors <= limits.stiffness).sum()),
                "k_half_width_percent": float(196.0 * one.known.errors[:pairs].max()),
                "b_half_width_percent": float(196.0 * one.known.errors[pairs : 2 * pairs].max()),
                "quoted_percent": float(100.0 * quoted.mean()),
                "persons": len(drawn[one.perturbations]),
                "k_largest_error_percent": float(100.0 * np.abs(k).max()) if k.size else "",
            }
        )
    return rows


def _scores(drawn: Sequence[Drawn], matrices) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors in parts of the natural size (-), whether intervals hold, what is quoted: (persons, 18)."""
    truth = np.concatenate([np.ravel(matrix) for matrix in matrices])
    size = np.concatenate([np.sqrt(np.outer(np.diag(m), np.diag(m))).ravel() for m in matrices])
    values = np.array([[entry.value for entry in one.entries] for one in drawn])
    halves = np.array([[entry.half_width for entry in one.entries] for one in drawn])
    return (values - truth) / size, np.abs(values - truth) <= halves, np.isfinite(values)


def element_rows(
    predictions: Sequence[SetPrediction],
    drawn: Mapping[Set, Sequence[Drawn]],
    matrices: tuple[np.ndarray, np.ndarray],
    epochs: Epochs,
) -> list[dict]:
    """One row per element and set of perturbations, in per cent of sqrt(K_ii K_jj), sqrt(B_ii B_jj).

    predictions: of matrices that need not be symmetric.
    matrices: K (N·m/rad) and B (N·m·s/rad) of the persons.
    Returns: empty cells where nothing is quoted.
    """
    rows = []
    for one in predictions:
        estimates = drawn[one.perturbations]
        errors, held, quoted = _scores(estimates, matrices)
        neglected = neglected_inertia(epochs, one.perturbations, matrices) if one.known.all else None
        for k, entry in enumerate(estimates[0].entries):
            own = quoted[:, k]
            error = errors[own, k]
            rows.append(
                {
                    "perturbations": named(one.perturbations),
                    "quantity": entry.name,
                    "unit": "Nm/rad" if k < 9 else "Nms/rad",
                    "truth": float(np.concatenate([np.ravel(m) for m in matrices])[k]),
                    "predicted_u_percent": float(100.0 * one.known.errors[k]),
                    "monte_carlo_u_percent": _percent(error.std(ddof=1)) if own.sum() > 1 else "",
                    "mean_error_percent": _percent(error.mean()) if own.any() else "",
                    "inertia_u_percent": float(100.0 * one.by_inertia[k]),
                    "neglected_inertia_u_percent": "" if neglected is None else float(100.0 * neglected[k]),
                    "quoted_percent": float(100.0 * own.mean()),
                    "coverage_percent": float(100.0 * held[own, k].mean()) if own.any() else "",
                    "errors_percent": ";".join(f"{100.0 * x:.3g}" for x in error),
                }
            )
    return rows


def _inertia(setting: Setting) -> str:
    if setting.inertia_known:
        return EXACT
    return UNKNOWN if setting.inertia_covariance is None else WITHIN


def model_rows(
    cases: Mapping[float, Sequence[Sequence[SetPrediction]]],
    stiffness: Annotated[np.ndarray, "(3, 3)", "N·m/rad"],
    limits: Limits,
) -> list[dict]:
    """One row per window, model and set of perturbations.

    cases: length of the window after the onset -> predictions by model.
    stiffness: expected K.
    limits: of what counts as determined.
    Returns: largest half width of a 95 % interval of K in per cent of sqrt(K_ii K_jj).
    """
    rows = []
    for window_s, models in cases.items():
        for predictions in models:
            for one in predictions:
                setting, pairs = one.setting, len(one.setting.pairs)
                rows.append(
                    {
                        "window_s": window_s,
                        "matrices": "symmetric" if setting.symmetric else "any",
                        "inertia": _inertia(setting),
                        "perturbations": named(one.perturbations),
                        "number": len(one.perturbations),
                        "rank": one.known.rank,
                        "unknowns": one.known.unknowns,
                        "condition": one.known.condition,
                        "identified": str(one.known.all).lower(),
                        "movements": int((one.known.direction_errors <= limits.stiffness).sum()),
                        "k_half_width_percent": float(196.0 * one.known.errors[:pairs].max()),
                        "statement": statement(one, stiffness, limits),
                    }
                )
    return rows
