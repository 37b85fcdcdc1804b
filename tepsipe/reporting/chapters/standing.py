"""Chapter on the standing person: numbers of fits, and conditions of its sentences."""

import numpy as np

from tepsipe.experiments.standing.muscle_torque import FREE, NONE
from tepsipe.experiments.standing.options import SCALARS
from tepsipe.io.estimates import FLAGS
from tepsipe.io.result import Result
from tepsipe.reporting.budgets import source_words
from tepsipe.reporting.run import Run
from tepsipe.statistics.uncertainty import SCATTER

# times after an onset in which a muscle responds and segments rotate (s)
RESPONSE_S, ROTATION_S = 0.4, 0.3
# clearly visible peaks, in standard deviations of sway; rotation of the knee by that of the shank in a rigid
# body; K of a torque that misses most of it, by K of the recommended one
VISIBLE, RIGID, LITTLE_PERCENT = 3.0, 0.1, 20.0


def numbers(run: Run) -> dict:
    """Numbers that no table has (units in the keys), the pre-reflex estimator, and sources in words."""
    estimator = run.settings["standing"]["recommended"]["estimator"]
    sources = run.rows("uncertainty", experiment="standing").source.unique()
    return {
        "largest_response": _largest_response(run.fits["standing"]),
        "tasks": {task: _task(fit, estimator) for task, fit in _tasks(run).items()},
        "pre_reflex": _pre_reflex(run.settings["standing"]),
        "share_percent": _shares(run),
        "sources": {s: "scatter between trials" if s == SCATTER else source_words(s) for s in sources},
    }


def _tasks(run: Run) -> dict[str, Result]:
    return run.fits.get("standing_tasks", {})


def _largest_response(fits: dict[str, Result]) -> dict | None:
    """The highest peak of a mean electromyogram; None without electromyograms."""
    found = []
    for condition, fit in fits.items():
        for name in (name for name in fit.arrays if name.startswith("activity/")):
            time, mean = fit.arrays["mean/time"], fit.arrays[name][0]
            after = (time >= 0.0) & (time <= RESPONSE_S)
            peak = {"peak_uV": mean[after].max(), "at_ms": 1e3 * time[after][mean[after].argmax()]}
            found.append({"muscle": name.removeprefix("activity/"), "condition": condition} | peak)
    return max(found, key=lambda response: response["peak_uV"], default=None)


def _task(fit: Result, estimator: str) -> dict:
    """Estimates by length of the window, without and with a free reflex torque; rotations; warnings."""
    windows = {"length_s": fit.arrays["windows/length"], "K_Nm_per_rad": fit.arrays["windows/K"][:, 0]}
    found = {"windows": windows, "rotation_mrad": _rotations(fit)}
    budget = fit.facts.get("budgets", {}).get(estimator)
    if budget is not None:
        columns = ("length_s", "B_Nms_per_rad", "K_Nm_per_rad")
        found["free_windows"] = dict(zip(columns, fit.arrays[f"budget/{estimator}/windows"].T, strict=True))
        found["warnings"] = [FLAGS[flag] for flag in budget["flags"]]
    return found


def _rotations(fit: Result) -> dict[str, float]:
    """Rotations after an onset, peak to peak, means over trials (mrad); none without a response."""
    if "mean/time" not in fit.arrays:
        return {}
    near = (fit.arrays["mean/time"] >= 0.0) & (fit.arrays["mean/time"] <= ROTATION_S)
    turned = {name: fit.arrays[f"mean/{name}"][:, near] for name in ("shank", "thigh", "knee")}
    return {name: float(1e3 * np.ptp(angle, axis=1).mean()) for name, angle in turned.items()}


def _pre_reflex(settings: dict) -> str:
    """The first estimator without inertia and torque of muscles; the recommended one if there is none."""
    names = [n for n, e in settings["estimators"].items() if e["active"] == NONE and not e["inertia"]]
    return [*names, settings["recommended"]["estimator"]][0]


def _shares(run: Run) -> dict[str, list[float]]:
    """Pathway -> K of every task by it, relative to K by the recommended pathway (%)."""
    settings, tasks = run.settings["standing"], list(_tasks(run))
    found = {
        pathway: run.values("standing", "K", pathway=pathway, estimator=_pre_reflex(settings)).reindex(tasks)
        for pathway in settings["pathways"]
    }
    best = found[settings["recommended"]["pathway"]]
    return {pathway: (100.0 * own / best).dropna().tolist() for pathway, own in found.items()}


# ---- conditions of sentences


def visible(run: Run) -> bool:
    """In every usable trial the ankle turns by more than three standard deviations of its sway."""
    stood = [fit.facts for fit in run.fits["standing"].values() if fit.facts["responses"]]
    return bool(stood) and min(facts["angle_over_sway"] for facts in stood) > VISIBLE


def knee_turns(run: Run) -> bool:
    """In a task the knee rotates by at least a tenth of the rotation of the shank."""
    rotations = [found for fit in _tasks(run).values() if (found := _rotations(fit))]
    return any(found["knee"] >= RIGID * found["shank"] for found in rotations)


def free_reflex(run: Run) -> bool:
    """A task has recommended estimates that allow for any reflex torque, with their budget."""
    estimator = run.settings["standing"]["recommended"]["estimator"]
    return any(estimator in fit.facts.get("budgets", {}) for fit in _tasks(run).values())


def printed_little(run: Run) -> bool:
    """By eq (3-14), read as scalars, K of every task is below a fifth of K by the recommended torque."""
    pathways = run.settings["standing"]["pathways"]
    found = [x for p, own in _shares(run).items() if pathways[p]["torque"] == SCALARS for x in own]
    return bool(found) and max(map(abs, found)) < LITTLE_PERCENT


def window_matters(run: Run) -> bool:
    """In every task, the range of K without a reflex torque over the windows exceeds half of the mean."""
    spreads = [_window_spread(fit.arrays["windows/K"][:, 0]) for fit in _tasks(run).values()]
    return bool(spreads) and min(spreads) > 0.5


def free_reflex_not_steadier(run: Run) -> bool:
    """In no task does K depend less on the window with a free reflex torque, over the same lengths."""
    estimator, found = run.settings["standing"]["recommended"]["estimator"], []
    for fit in _tasks(run).values():
        if estimator in fit.facts.get("budgets", {}):
            lengths, _, free = fit.arrays[f"budget/{estimator}/windows"].T
            ends = (lengths.min() - 1e-6, lengths.max() + 1e-6)
            inside = (fit.arrays["windows/length"] >= ends[0]) & (fit.arrays["windows/length"] <= ends[1])
            found.append(_window_spread(free) < _window_spread(fit.arrays["windows/K"][inside, 0]))
    return bool(found) and not any(found)


def _window_spread(stiffness: np.ndarray) -> float:
    """Range over the mean; 0 without two values."""
    known = stiffness[np.isfinite(stiffness)]
    return float(np.ptp(known) / abs(known.mean())) if known.size > 1 else 0.0


def active_biased(run: Run) -> bool:
    """No interval of B of a task by an estimator with an active torque covers the truth."""
    settings = run.settings["standing"]
    names = [n for n, e in settings["estimators"].items() if e["active"] not in (NONE, FREE)]
    rows = run.rows(
        "recovery", experiment="standing", quantity="B", pathway=settings["recommended"]["pathway"]
    )
    rows = rows[rows.condition.isin(list(_tasks(run)))] if len(rows) else rows
    rows = rows[rows.estimator.isin(names)] if len(rows) else rows
    return len(rows) > 0 and not (rows.covered.astype(str).str.lower() == "true").any()


PREDICATES = (
    visible,
    knee_turns,
    free_reflex,
    printed_little,
    window_matters,
    free_reflex_not_steadier,
    active_biased,
)
