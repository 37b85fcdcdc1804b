"""What the captions tell of the signals that the figures show: peaks, coherence, onsets, predictions."""

from itertools import product

import numpy as np
import pandas as pd

from tepsipe.io.result import Result
from tepsipe.reporting.figures.names import short_name
from tepsipe.reporting.numbers.format import number, percent, span
from tepsipe.reporting.numbers.simulations import owner

# time after the onset in which a muscle's response is looked for (s)
RESPONSE_S = 0.4


def belt_signals(fits: dict[str, Result]) -> dict | None:
    """Peak of the belt's velocity relative to the command (%), and its delay (ms).

    Parameters
    ----------
    fits : dict of str to Result
        Condition -> fit of the dummy.

    Returns
    -------
    dict or None
        ``peak`` and ``delay`` as text; None without a command.
    """
    peaks, delays = [], []
    for fit in fits.values():
        if "belt_command" not in fit.arrays:
            continue
        time, first = fit.arrays["time"], int(fit.arrays["windows"][0, 0])
        rate = 1.0 / float(time[1] - time[0])
        part = slice(max(0, first - round(0.06 * rate)), first + round(0.22 * rate))
        belt, command = (fit.arrays[name][part] for name in ("belt_velocity", "belt_command"))
        if np.abs(command).max() > 0.0:
            # the first half of a pulse, in whichever direction it begins
            sign = np.sign(command[np.abs(command) > 0.05 * np.abs(command).max()][0])
            belt, command = sign * belt, sign * command
            peaks.append(100.0 * float(belt.max() / command.max()))
            delays.append(1e3 * float(np.argmax(belt) - np.argmax(command)) / rate)
    return {"peak": span(peaks, 2), "delay": span(delays, 2)} if peaks else None


def muscle_signals(fits: dict[str, Result], task_fits: dict[str, Result], detector: str) -> dict:
    """Largest mean response, latencies and their differences between detectors, K without a reflex.

    Parameters
    ----------
    fits, task_fits : dict of str to Result
        Trial -> its result; task -> joint result of its trials.
    detector : str
        Detector of the recommended latency.

    Returns
    -------
    dict
        ``largest`` (muscle, condition, peak in uV, time in ms; None without responses), ``latency`` and
        ``detectors`` (ms; None without onsets), ``plain`` (task -> K in N·m/rad and windows in ms), as text.
    """
    largest: tuple[float, dict] | None = None
    for condition, fit in fits.items():
        for name, values in fit.arrays.items():
            if not name.startswith("activity/"):
                continue
            time = fit.arrays["mean/time"]
            after = (time >= 0.0) & (time <= RESPONSE_S)
            mean = values[0, after]
            peak = float(mean.max())
            if largest is None or peak > largest[0]:
                at = 1e3 * float(time[after][mean.argmax()])
                found = {"muscle": name.partition("/")[2], "condition": condition}
                largest = peak, found | {"peak": number(peak, 2), "at": f"{at:.0f}"}
    chosen, apart = [], []
    for fit in task_fits.values():
        for onsets in fit.facts["latencies"].values():
            known = {
                name: 1e3 * onset["latency_s"]
                for name, onset in onsets.items()
                if isinstance(onset, dict) and onset["latency_s"] is not None
            }
            if detector in known:
                chosen.append(known[detector])
                apart.append(max(known.values()) - min(known.values()))
    plain = {
        task: {
            "K": span(fit.arrays["windows/K"][:, 0]),
            "windows": span([1e3 * float(x) for x in fit.arrays["windows/length"]], 2),
        }
        for task, fit in task_fits.items()
        if fit.arrays["windows/length"].size
    }
    return {
        "largest": None if largest is None else largest[1],
        "latency": span(chosen, 2) if chosen else None,
        "detectors": f"{max(apart):.0f}" if apart else None,
        "plain": plain,
    }


def simulated_signals(forward: pd.DataFrame, shown: dict[str, str]) -> dict:
    """Which parameters predict best, over all conditions and in those of the figures (VAF, %).

    Parameters
    ----------
    forward : DataFrame
        Rows of ``forward.csv`` (%).
    shown : dict of str to str
        Figure -> condition.

    Returns
    -------
    dict
        ``best``: ``quantity_key`` -> parameters and number of conditions; ``shown``: figure -> condition and
        VAFs of the angle over the trial and of both torques in the perturbations, as text.
    """
    best = {}
    keys = ("vaf_perturbation", "vaf_trial")
    for quantity, key in product(dict.fromkeys(forward.quantity), keys):
        table = forward[forward.quantity == quantity].pivot(
            index="condition", columns="parameter_set", values=key
        )
        counts = table.idxmax(axis=1).value_counts()
        best[f"{quantity}_{key}"] = {
            "name": owner(counts.index[0]),
            "count": str(int(counts.iloc[0])),
            "all": str(len(table)),
        }
    return {
        "best": best,
        "shown": {
            figure: {"condition": short_name(condition), **_of_condition(forward, condition)}
            for figure, condition in shown.items()
            if condition in set(forward.condition)
        },
    }


def _of_condition(forward: pd.DataFrame, condition: str) -> dict:
    """VAF (%) of every set of parameters in one condition, the highest first."""
    own = forward[forward.condition == condition]

    def ordered(quantity: str, key: str) -> list[list[str]]:
        rows = own[own.quantity == quantity].sort_values(key, ascending=False)
        return [[owner(r.parameter_set), _vaf(getattr(r, key))] for r in rows.itertuples(index=False)]

    return {
        "angle": ordered("theta", "vaf_trial"),
        "torque": ordered("tau", "vaf_perturbation"),
        "consistent": ordered("tau_consistent", "vaf_perturbation"),
    }


def _vaf(value: float) -> str:
    return percent(value, 0) if value > -1000.0 else "below \N{MINUS SIGN}1000"
