"""What the captions tell of the muscles: responses and onsets."""

from tepsipe.io.result import Result
from tepsipe.reporting.numbers.format import number, span

# time after the onset in which a muscle's response is looked for (s)
RESPONSE_S = 0.4


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
