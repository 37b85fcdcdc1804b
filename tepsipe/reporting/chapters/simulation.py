"""Chapter on the forward simulation: names of the simulated joints, and conditions of its sentences."""

import math
from itertools import pairwise

import numpy as np
import pandas as pd

from tepsipe.drawing.names import PARAMETER_SETS, compared_sets
from tepsipe.experiments.forward.scores import swing_sizes
from tepsipe.io.result import Result
from tepsipe.reporting.run import Run
from tepsipe.statistics.goodness_of_fit import explained

FADED = 0.5  # size of the last swing relative to the largest, below which the growth is a beat
BEYOND = 0.2  # growth beyond a limit that is more than different pulses and rounding


def numbers(run: Run) -> dict:
    """Labels of the sets of parameters, sets in figures of few, swings (see `_swings`), engines compared.

    Also the VAF (%) of the belt-induced force by the treadmill models (see `_belt_induced`).
    """
    known = _known(run)
    labels = {name: label for name, label in PARAMETER_SETS.items() if name in known}
    return {
        "parameter_sets": labels,
        "compared": compared_sets(labels),
        "swings": _swings(run),
        "both": _both(run),
        "belt_induced_vaf": _belt_induced(run),
    }


def _belt_induced(run: Run) -> list[float]:
    """VAF (%) by which each treadmill model of the foot pathways explains the belt-induced force of a trial.

    Mean over the perturbations of a trial. The belt-induced force is the measured less the simulated F_y, by
    the recommended parameters that were simulated; the model removes its own from the measured F_y.
    """
    found = []
    name = next((own for own in ("joint-likelihood", "corrected") if own in _known(run)), None)
    for condition, fit in run.fits.get("simulation", {}).items():
        foot = run.fits.get("foot", {}).get(condition)
        if foot is None or "f_y" not in fit.arrays or name is None:
            continue
        induced = fit.arrays["f_y"] - np.nan_to_num(fit.arrays[f"{name}/f_y"])
        windows = [slice(start, stop) for start, stop in fit.arrays["windows"].astype(int)]
        measured = foot.arrays["loads/Fy/measured"]
        for key in sorted(foot.arrays):
            if key.startswith("loads/Fy/") and key != "loads/Fy/measured":
                modelled = measured - foot.arrays[key]
                found.append(float(np.mean([explained(induced[w], modelled[w]) for w in windows])))
    return found


def _both(run: Run) -> dict | None:
    """Trial that two engines simulated, and by how much they differ; None without one."""
    for condition, fit in run.fits.get("simulation", {}).items():
        if fit.facts["engine_differences"] is not None:
            return {"condition": condition} | fit.facts["engine_differences"]
    return None


def _known(run: Run) -> set[str]:
    """Sets of parameters of the simulations."""
    return set(run.tables["forward"].parameter_set)


def _focus(run: Run) -> str:
    """Parameters of TEP-SIPE: numbers of the thesis, without these those of the run."""
    return "thesis-tep" if "thesis-tep" in _known(run) else "tep"


def _swings(run: Run) -> list[dict]:
    """Swing of the simulation with printed TEP-SIPE parameters against the interval of the pulses.

    One entry per condition: interval of the pulses and period of the swing (s), periods per interval, the
    most that undamped swings of equal pulses add up to, relative to the first swing, growth of the measured
    swing; time of the largest swing (s), and size of the largest and the last swing relative to the first,
    None after a fall. The parameters are those of the thesis, or those of the run without them.
    """
    name, found = _focus(run), []
    for condition, fit in run.fits.get("simulation", {}).items():
        period, interval = fit.facts["periods_s"].get(name), fit.facts["pulse_interval_s"]
        if period is None or interval is None:
            continue
        step = abs(math.sin(math.pi * interval / period))
        pulses = len(fit.arrays["windows"])
        found.append(
            {
                "condition": condition,
                "interval_s": interval,
                "period_s": period,
                "periods": interval / period,
                "limit": min(1.0 / step, pulses) if step > 0.0 else pulses,
                "measured_growth": fit.facts["measured_growth"],
            }
            | _beat(fit, name)
        )
    return found


def _beat(fit: Result, name: str) -> dict:
    """Time of the largest swing, and sizes of the largest and the last one, as `_swings`."""
    windows = fit.arrays["windows"].astype(int)
    sizes = swing_sizes(fit.arrays[f"{name}/theta"], windows.tolist())
    if not np.isfinite(sizes).all():
        return dict.fromkeys(("largest_at_s", "largest", "last"))
    k = int(np.argmax(sizes))
    at_s = float(fit.arrays["time"][windows[k, 0]])
    return {"largest_at_s": at_s, "largest": sizes[k] / sizes[0], "last": sizes[-1] / sizes[0]}


def _of_trials(run: Run, parameter_set: str, quantity: str = "theta") -> pd.Series:
    """VAF over the full dataset by condition."""
    rows = run.rows("forward", parameter_set=parameter_set, quantity=quantity)
    return rows.set_index("condition").vaf_trial


def _growth(run: Run, figure: str, parameter_set: str) -> float:
    """Growth of the swing in the trial of a figure; infinite if the leg falls, NaN without the simulation."""
    condition = run.study["simulated"][figure]
    rows = run.rows("forward", condition=condition, parameter_set=parameter_set, quantity="theta")
    if rows.empty:
        return math.nan
    row = rows.iloc[0]
    return math.inf if row.state == "falls" else float(row.growth)


# ---- conditions of sentences


def thesis_simulated(run: Run) -> bool:
    """The dummy was simulated with the numbers that the thesis printed."""
    return {"thesis-wristalyzer", "thesis-tep"} <= _known(run)


def _pattern(run: Run, manipulator: str, belt: str) -> bool:
    """The manipulator's parameters always predict the angle better, those of the belt the printed torque."""
    angle, torque = (
        _of_trials(run, better, quantity).min() > _of_trials(run, worse, quantity).max()
        for better, worse, quantity in ((manipulator, belt, "theta"), (belt, manipulator, "tau"))
    )
    return bool(angle and torque)


def pattern_of_thesis(run: Run) -> bool:
    """The Wristalyzer's parameters always predict the angle better, the printed ones the printed torque."""
    return _pattern(run, "wristalyzer", "tep")


def pattern_with_its_numbers(run: Run) -> bool:
    """The same, with the numbers that the thesis printed."""
    return _pattern(run, "thesis-wristalyzer", "thesis-tep")


def better_without_handle(run: Run) -> bool:
    """In every condition the angle is predicted better without the inertia of foot and handle."""
    fewer, printed = (_of_trials(run, f"thesis-{name}") for name in ("without-handle", "wristalyzer"))
    return len(fewer) > 0 and bool((fewer - printed > 0.0).all())


def likelihood_predicts_best(run: Run) -> bool:
    """In every condition the joint likelihood predicts the angle better than any other set."""
    rows = run.rows("forward", quantity="theta")
    by_set = rows.pivot(index="condition", columns="parameter_set", values="vaf_trial")
    if "joint-likelihood" not in by_set:
        return False
    return bool((by_set.idxmax(axis=1) == "joint-likelihood").all())


def amplifies_less_at_8_s(run: Run) -> bool:
    """With printed numbers of TEP-SIPE the swing grows more than with others, and less at long intervals."""
    grown = [_growth(run, "4_7", "thesis-tep"), _growth(run, "4_8", "thesis-tep")]
    grown.append(_growth(run, "4_8", "thesis-wristalyzer"))
    followed = _growth(run, "4_7", "thesis-wristalyzer")
    return all(a > b for a, b in pairwise(grown)) and grown[0] > followed


def amplifies_by_resonance(run: Run) -> bool:
    """The same, although both simulated legs settle once the belt rests."""
    states = {
        state
        for figure in ("4_7", "4_8")
        for state in run.rows(
            "forward", parameter_set="thesis-tep", condition=run.study["simulated"][figure]
        ).state
    }
    known = {entry["condition"] for entry in _swings(run)}
    return (
        amplifies_less_at_8_s(run)
        and states == {"settles"}
        and known >= {run.study["simulated"][figure] for figure in ("4_7", "4_8")}
    )


def growth_is_a_beat(run: Run) -> bool:
    """In the trial of Figure 4-7 the swing is largest before the last pulses and has faded after the last."""
    shown = [entry for entry in _swings(run) if entry["condition"] == run.study["simulated"]["4_7"]]
    return any(e["last"] is not None and e["last"] < FADED * e["largest"] for e in shown)


def excess_by_negative_damping(run: Run) -> bool:
    """Swings that grow beyond the limit of equal pulses exist, and all grow with the belt at rest, too."""
    name = _focus(run)
    rows = run.rows("forward", parameter_set=name, quantity="theta").set_index("condition")
    known = [entry for entry in _swings(run) if entry["condition"] in rows.index]
    beyond = [e["condition"] for e in known if rows.growth[e["condition"]] > e["limit"] + BEYOND]
    return len(beyond) > 0 and all(rows.state[condition] == "grows" for condition in beyond)


def printed_swing_grows(run: Run) -> bool:
    """With the printed parameters small swings grow in some condition."""
    return len(run.rows("forward", parameter_set="tep", state="grows")) > 0


def force_compared(run: Run) -> bool:
    """The simulated fore-aft force was compared with a measured one."""
    return len(run.rows("forward", quantity="f_y")) > 0


def first_shown(run: Run) -> bool:
    """The trial of Figure 4-7 was simulated."""
    return len(run.rows("forward", condition=run.study["simulated"]["4_7"])) > 0


def second_shown(run: Run) -> bool:
    """The trial of Figure 4-8 was simulated."""
    return len(run.rows("forward", condition=run.study["simulated"]["4_8"])) > 0


PREDICATES = (
    thesis_simulated,
    pattern_of_thesis,
    pattern_with_its_numbers,
    better_without_handle,
    likelihood_predicts_best,
    amplifies_less_at_8_s,
    amplifies_by_resonance,
    growth_is_a_beat,
    excess_by_negative_damping,
    printed_swing_grows,
    force_compared,
    first_shown,
    second_shown,
)
