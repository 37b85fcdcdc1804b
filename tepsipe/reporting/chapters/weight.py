"""Chapter on the belt-induced force: peaks and shapes of the force, conditions of its sentences."""

import numpy as np
import pandas as pd

from tepsipe.experiments.weight.analysis import shapes, speed_at_peak, usual_weight
from tepsipe.experiments.weight.calibrate import USUAL_ONLY
from tepsipe.io.result import Result
from tepsipe.reporting.run import Run
from tepsipe.treadmill.calibration import BOTH, OF_BOTH


def numbers(run: Run) -> dict:
    """Numbers of the usual weight over its conditions, which no table has (units in the keys)."""
    weight, empty = usual_weight(run.fits["weight"]), run.fits["empty"]
    fine, coarse = _filters(run)
    speeds, peaks = _peak_speeds(weight, fine), _peaks(weight, fine)
    alike_fine, size_fine = shapes(empty, weight, fine)
    alike_coarse, size_coarse = shapes(empty, weight, coarse)
    return {
        "conditions": list(weight),
        "peak_empty_N": _peaks(empty, fine),
        "peak_weight_N": peaks,
        "peak_belt_N": _peaks(weight, "belt"),
        "speed_at_peak": speed_at_peak(weight, fine),
        "exponent": _exponent(speeds, peaks),
        "alike_fine": alike_fine,
        "alike_coarse": alike_coarse,
        "size_fine": size_fine,
        "size_coarse": size_coarse,
    }


def _filters(run: Run) -> tuple[str, str]:
    """Names of the shown low-pass and of the lowest one."""
    cutoffs_hz = run.settings["weight"]["analysis"]["cutoffs_hz"]
    return f"{cutoffs_hz[0]:g} Hz", f"{cutoffs_hz[-1]:g} Hz"


def _peaks(results: dict[str, Result], name: str) -> list[float]:
    """Peak of the mean belt-induced force of every trial (N)."""
    return [float(np.abs(r.arrays[f"{name}/added_force"].mean(axis=0)).max()) for r in results.values()]


def _peak_speeds(results: dict[str, Result], name: str) -> list[float]:
    """Peak of the mean belt speed of every trial (m/s)."""
    return [float(np.abs(r.arrays[f"{name}/belt_velocity"].mean(axis=0)).max()) for r in results.values()]


def _exponent(speeds: list[float], peaks: list[float]) -> float | None:
    """Power of the belt speed (m/s) that peaks of the force (N) grow with."""
    if len(speeds) < 3 or not np.ptp(speeds) > 0.0 or not min(peaks) > 0.0:
        return None
    return float(np.polyfit(np.log(speeds), np.log(peaks), 1)[0])


def _mass(run: Run, quantity: str) -> pd.Series:
    return run.values("weight", quantity)


def _by_speed(run: Run, quantity: str) -> list[list[float]]:
    """Values of the usual weight (any unit) in the order of belt speed, profile by profile.

    Conditions of one profile share the words of their name before the last hyphen.
    """
    weight = usual_weight(run.fits["weight"])
    speeds = dict(zip(weight, _peak_speeds(weight, _filters(run)[0]), strict=True))
    profiles: dict[str, list[str]] = {}
    for condition in sorted(weight, key=speeds.__getitem__):
        profiles.setdefault(condition.rpartition("-")[0], []).append(condition)
    values = _mass(run, quantity)
    return [[float(values[c]) for c in own] for own in profiles.values() if len(own) > 1]


# ---- conditions of sentences


def load_matters(run: Run) -> bool:
    """In every condition the weight changes the belt-induced force by more than a tenth."""
    sizes = shapes(run.fits["empty"], usual_weight(run.fits["weight"]), _filters(run)[0])[1]
    return bool(sizes) and all(abs(x - 1.0) > 0.1 for x in sizes)


def linear_needs_load(run: Run) -> bool:
    """Linear models of the weight predict it better than those of the empty belt, by more than 0.1 of R²."""
    own, other = (_linear(run, train) for train in ("weight", "empty"))
    return bool(len(own) and len(other)) and own.min() - other.max() > 0.1


def _scores(run: Run) -> pd.DataFrame:
    """Scores of the models of the force at the shown cutoff."""
    scores = run.tables[run.study["models"]["weight"]]
    shown_hz = float(run.settings["weight"]["analysis"]["cutoffs_hz"][0])
    return scores[(scores.load == "Fy") & (scores.cutoff_hz == shown_hz)]


def _linear(run: Run, train: str) -> pd.Series:
    """R² of linear models under the weight."""
    scores = _scores(run)
    wanted = (scores.train == train) & (scores.test == "weight")
    return scores[wanted & ~scores.model.isin((*OF_BOTH, "mean-subtraction"))].r2


def frame_scored(run: Run) -> bool:
    """A model of the frame, fitted to the empty belt and the weight, was evaluated under the weight."""
    scores = _scores(run)
    wanted = (scores.train == BOTH) & (scores.test == "weight") & scores.model.isin(OF_BOTH)
    return bool(scores[wanted].r2.notna().any())


def one_set_fails(run: Run) -> bool:
    """The loaded frame predicts further weights worse if it is fitted to them as well."""
    scores = _scores(run)
    scores = scores[(scores.model == "loaded-frame") & scores.test.str.startswith("weight of ")]
    usual, every = (scores[scores.train == train].set_index("test").r2 for train in (USUAL_ONLY, BOTH))
    return len(usual) > 0 and bool((every.reindex(usual.index) < usual).all())


def scored(run: Run) -> bool:
    """Models of the force were evaluated."""
    return bool(_scores(run).rms_after.notna().any())


def foot_pathways(run: Run) -> bool:
    """The study has pathways of the torque from the foot."""
    return "dummy" in run.study["experiments"] and len(run.settings["dummy"]["foot"]["pathways"]) > 0


def force_grows(run: Run) -> bool:
    """The peak of the belt-induced force under the weight grows with the peak speed of the belt."""
    weight, fine = usual_weight(run.fits["weight"]), _filters(run)[0]
    exponent = _exponent(_peak_speeds(weight, fine), _peaks(weight, fine))
    return exponent is not None and exponent > 0.0


def mass_falls(run: Run) -> bool:
    """In each profile the mass falls from every amplitude to the next."""
    return _steadily_falls(_by_speed(run, "mass"))


def mass_sd_largest_first(run: Run) -> bool:
    """The standard deviation of the mass is largest at the smallest amplitude, and falls unsteadily."""
    profiles = _by_speed(run, "mass_sd")
    largest = bool(profiles) and all(own[0] > max(own[1:]) for own in profiles)
    return largest and not _steadily_falls(profiles)


def _steadily_falls(profiles: list[list[float]]) -> bool:
    return bool(profiles) and all(np.diff(own).max() < 0.0 for own in profiles)


def plate_agrees_worst(run: Run) -> bool:
    """The plate of the study has a larger misfit to the statements of the thesis than the other plates."""
    found = _plates(run, "misfit to the statements")
    return bool(found) and all(own > max(others) for own, *others in found)


def plate_errs_least(run: Run) -> bool:
    """The largest errors of K of person and foot are smaller with the plate of the study than with others."""
    found = _plates(run, "largest error of K")
    return bool(found) and all(own < min(others) for own, *others in found)


def _plates(run: Run, start: str) -> list[list[float]]:
    """Values of the plate of the study and of two others in measures that begin with these words."""
    rows = run.rows("plate_constants")
    if rows.empty:
        return []
    rows = rows[rows.measure.str.startswith(start)]
    return rows[["shipped", "fitted", "damped"]].astype(float).values.tolist()


PREDICATES = (
    load_matters,
    linear_needs_load,
    frame_scored,
    one_set_fails,
    scored,
    foot_pathways,
    force_grows,
    mass_falls,
    mass_sd_largest_first,
    plate_agrees_worst,
    plate_errs_least,
)
