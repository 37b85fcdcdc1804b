"""Chapter on the noise study: largest errors at the level of the table, and conditions of its sentences."""

import math

import numpy as np
import pandas as pd

from tepsipe.experiments.noise.onsets import BELT, found_from
from tepsipe.reporting.run import Run


def numbers(run: Run) -> dict:
    """Numbers that no table has (units in the keys)."""
    combination, rows = ["condition", "noise_on", "snr_db", "estimator"], run.tables["noise"]
    return {
        "combinations": len(rows[rows.noise_on != BELT].drop_duplicates(combination)),
        "onsets": _onsets(run),
        "largest_rms_percent": {
            "instruments": _largest_rms(run, "recommended"),
            "least_squares": _largest_rms(run, "recommended-regression"),
        },
        "largest_error_percent": {
            "instruments": _consistent(run, "recommended"),
            "least_squares": _consistent(run, "recommended-regression"),
            "both_filtered": _from_apparent(run, "both"),
            "one_filtered": _from_apparent(run, "tau", "theta"),
        },
    }


def _onsets(run: Run) -> list[dict]:
    """Lowest level (dB) at which all perturbations of a trial are found."""
    found = found_from(run.rows("noise", noise_on=BELT).itertuples())
    return [{"condition": condition, "found_from_dB": level} for condition, level in found.items()]


def _largest_error(run: Run, estimator: str, noise_on: tuple[str, ...], quantity: str) -> float:
    """Largest error of the mean over the draws (%), relative to the simulated value."""
    return _largest(_rows(run, estimator, noise_on, quantity)["mean"] / _simulated(run, quantity))


def _simulated(run: Run, quantity: str) -> float:
    joint = run.settings["noise"]["joint"]
    return {"B": joint["damping_Nms_per_rad"], "K": joint["stiffness_Nm_per_rad"][0]}[quantity]


def _rows(run: Run, estimator: str, noise_on: tuple[str, ...], quantity: str) -> pd.DataFrame:
    """Rows of the simulated joint of Table 4-4, at its noise level."""
    settings = run.settings["noise"]
    own = {
        "estimator": estimator,
        "quantity": quantity,
        "snr_db": settings["table_snr_db"],
        "stiffness_Nm_per_rad": settings["joint"]["stiffness_Nm_per_rad"][0],
    }
    rows = run.rows("noise", **own)
    return rows[rows.noise_on.isin(noise_on)]


def _largest(ratios: pd.Series) -> float:
    return 100.0 * float((ratios - 1.0).abs().max())


def _consistent(run: Run, estimator: str) -> float:
    """Largest error of the means of B and K by a consistent torque, with noise on the angle (%)."""
    return max(_largest_error(run, estimator, ("theta", "both"), q) for q in ("B", "K"))


def _largest_rms(run: Run, estimator: str) -> float:
    """Largest RMS error of a single draw of B and K, as `_consistent` (%)."""

    def largest(quantity: str) -> float:
        rows, simulated = _rows(run, estimator, ("theta", "both"), quantity), _simulated(run, quantity)
        return 100.0 * float(np.hypot(rows["mean"] - simulated, rows.sd).max() / simulated)

    return max(map(largest, ("B", "K")))


def _from_apparent(run: Run, *noise_on: str) -> float:
    """Largest distance of the printed K from the apparent one (%)."""
    rows = _rows(run, "as-printed", noise_on, "K")
    return _largest(rows["mean"] / rows.apparent)


# ---- conditions of sentences


def figure_has_both(run: Run) -> bool:
    """K of the figure was computed with noise by the printed and by the recommended processing."""
    stiffness = run.settings["noise"]["joint"]["stiffness_Nm_per_rad"][-1]
    rows = run.rows("table_4_4", quantity="K", estimator=f"K = {stiffness:g} Nm/rad")
    with_noise = rows[rows[["tau", "theta", "both"]].notna().any(axis=1)]
    return {"as-printed", "recommended"} <= set(with_noise.pathway)


def method_sound(run: Run) -> bool:
    """RMS errors of the recommended processing are below 5 %, and errors of the mean printed K above."""
    printed = _largest_error(run, "as-printed", ("tau", "theta", "both"), "K")
    return _largest_rms(run, "recommended") < 5.0 < printed


def filter_dominates(run: Run) -> bool:
    """In any trial a filter of one signal alone moves the printed K further than the noise moves its mean."""
    rows = _rows(run, "as-printed", ("tau", "theta"), "K")
    by_filter, by_noise = rows.without_noise - rows.apparent, rows["mean"] - rows.without_noise
    return bool(by_filter.abs().min() > by_noise.abs().max())


def thesis_stiffness_lost(run: Run) -> bool:
    """In the thesis's Table 4-4, K with noise on the angle is below a tenth of K without noise."""
    return _lost(run, "as-printed", "_reported")


def relative_noise_keeps_stiffness(run: Run) -> bool:
    """With noise relative to the angle on it, the printed K stays above a tenth of K without noise."""
    with_noise, without = _stiffness(run, "as-printed")
    return bool(with_noise) and min(map(abs, with_noise)) > 0.1 * abs(without)


def fixed_noise_loses_stiffness(run: Run) -> bool:
    """With noise of fixed power on the angle, K falls below a tenth of K without noise."""
    return _lost(run, "as-tabulated")


def _lost(run: Run, pathway: str, suffix: str = "") -> bool:
    with_noise, without = _stiffness(run, pathway, suffix)
    return bool(with_noise) and max(map(abs, with_noise)) < 0.1 * abs(without)


def _stiffness(run: Run, pathway: str, suffix: str = "") -> tuple[list[float], float]:
    """K of Table 4-4 with noise on the angle, and without noise; no values where a cell is empty."""
    stiffness = run.settings["noise"]["joint"]["stiffness_Nm_per_rad"][0]
    rows = run.rows("table_4_4", pathway=pathway, quantity="K", estimator=f"K = {stiffness:g} Nm/rad")
    if not len(rows):
        return [], math.nan
    cells = [float(rows.iloc[0][f"{name}{suffix}"]) for name in ("theta", "both", "none")]
    return (cells[:2], cells[2]) if all(map(math.isfinite, cells)) else ([], math.nan)


def thesis_returns_simulated(run: Run) -> bool:
    """The thesis printed the simulated K without noise, and the apparent K is another by more than 10 %."""
    stiffness = run.settings["noise"]["joint"]["stiffness_Nm_per_rad"][0]
    _, printed = _stiffness(run, "as-printed", "_reported")
    apparent = _rows(run, "as-printed", ("tau", "theta", "both"), "K").apparent
    differs = len(apparent) > 0 and abs(float(apparent.iloc[0]) / stiffness - 1.0) > 0.1
    return abs(printed / stiffness - 1.0) < 0.01 and differs


def sensor_returns_first_column(run: Run) -> bool:
    """Without noise the joint's sensor returns the printed I, B, K; with noise on the torque, another I."""
    stiffness = run.settings["noise"]["joint"]["stiffness_Nm_per_rad"][0]
    rows = run.rows("table_4_4", pathway="joint-sensor", estimator=f"K = {stiffness:g} Nm/rad")
    rows = rows[rows.quantity.isin(["I", "B", "K"])].set_index("quantity")
    if len(rows) < 3:
        return False
    without = (rows.none / rows.none_reported - 1.0).abs().max()
    return bool(without < 0.01 and abs(rows.tau.I / rows.tau_reported.I - 1.0) > 0.1)


PREDICATES = (
    figure_has_both,
    method_sound,
    filter_dominates,
    thesis_stiffness_lost,
    relative_noise_keeps_stiffness,
    fixed_noise_loses_stiffness,
    thesis_returns_simulated,
    sensor_returns_first_column,
)
