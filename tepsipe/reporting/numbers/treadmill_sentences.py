"""Sentences of the treadmill's chapter that depend on what a run shows."""

import numpy as np
import pandas as pd

from tepsipe.experiments.weight import speed_at_peak
from tepsipe.io.result import Result
from tepsipe.reporting.figures.names import words
from tepsipe.reporting.numbers.format import number, percent, span
from tepsipe.treadmill.calibration import ModelScore

# a trend counts if its slope exceeds this many standard errors (-)
CLEAR = 2.5
# highest resonance that signals of some 20 Hz show (Hz)
SEEN_HZ = 200.0
NAMES = {
    "bristles": "bristles, by which friction depends on the path of the belt",
    "stribeck": "more friction at rest than in motion",
    "lever": "a lever of the friction about the x axis",
    "second-mode": "a second mode of the frame",
}


def trend(speeds: list[float], values: list[float]) -> int:
    """1 if values (any unit) rise with speed (m/s), -1 if they fall, 0 if neither is clear."""
    x, y = np.asarray(speeds) - np.mean(speeds), np.asarray(values) - np.mean(values)
    if x.size < 3 or not (x @ x) > 0.0:
        return 0
    slope = float(x @ y / (x @ x))
    error = float(np.sqrt(np.sum((y - slope * x) ** 2) / (x.size - 2) / (x @ x)))
    return 0 if abs(slope) <= CLEAR * error else int(np.sign(slope))


def peak_speeds(results: dict[str, Result], filter_name: str) -> list[float]:
    """Peak of the mean belt speed of every trial (m/s)."""
    return [
        float(np.abs(r.arrays[f"{filter_name}/belt_velocity"].mean(axis=0)).max()) for r in results.values()
    ]


def mass_sentence(speeds: list[float], masses: list[float], spreads: list[float]) -> str:
    """What estimated mass and its standard deviation (kg) do with the belt speed (m/s)."""
    words = {
        1: "increases with amplitude",
        -1: "decreases with amplitude",
        0: "has no trend with amplitude",
    }
    of_mass, of_spread = trend(speeds, masses), trend(speeds, spreads)
    if of_mass == of_spread:
        both = words[of_mass].replace("creases", "crease").replace("has", "have")
        return f"The estimate and its standard deviation {both}."
    return f"The estimate {words[of_mass]}, its standard deviation {words[of_spread]}."


def force_sentence(weight: dict[str, Result], filter_name: str, peaks: list[float]) -> str:
    """Where the belt-induced force (N) peaks, and how it grows with the belt speed (m/s)."""
    at_peak = speed_at_peak(weight, filter_name)
    share = span([100.0 * x for x in at_peak], 3)
    text = f"Under the weight the force peaks while the belt moves at {share} % of its peak speed"
    speeds = peak_speeds(weight, filter_name)
    if len(speeds) > 2 and np.ptp(speeds) > 0.0 and min(peaks) > 0.0:
        exponent = float(np.polyfit(np.log(speeds), np.log(peaks), 1)[0])
        text += f"; the peak of the force grows with the peak speed to the power of {number(exponent, 2)}"
    return f"{text}."


def linear_sentence(own: list[float], other: list[float], before: str) -> str:
    """What linear models of the empty belt and of the weight (R2, -) say about the load."""
    if not own or not other:
        return ""
    if min(own) - max(other) > 0.1:
        return (
            f"{before} any linear model of the empty belt fails in the same way, because the belt-induced "
            "force depends on the load."
        )
    return "Here linear models of the empty belt predict about as much as those of the weight."


def resonance_sentence(empty_hz: float, loaded_hz: float) -> str:
    """Where the pitch moment shows the resonance of the frame without and with the weight (Hz)."""
    seen = {"without": empty_hz, "with": loaded_hz}
    where = [f"at {number(hz)} Hz {which}" for which, hz in seen.items() if hz < SEEN_HZ]
    if not where:
        return f"shows none below {SEEN_HZ:g} Hz, neither without nor with the weight"
    if len(where) == 2:
        return f"locates it {where[0]} and {where[1]} the weight"
    (unseen,) = (which for which, hz in seen.items() if not hz < SEEN_HZ)
    return f"locates it {where[0]} the weight and shows none below {SEEN_HZ:g} Hz {unseen} it"


def frame_of(facts: dict | None, scores: list[ModelScore], cutoff_hz: float) -> dict | None:
    """Text on the frame with bristles, from the facts of the calibration (units in their keys).

    Parameters
    ----------
    facts : dict or None
        Of `tepsipe.treadmill.calibration.mean_responses`.
    scores : list of ModelScore
        Of all models (units in them).
    cutoff_hz : float
        Cutoff at which they are shown (Hz).

    Returns
    -------
    dict or None
        Text; None without such a model.
    """
    if facts is None:
        return None
    terms = [NAMES[term] for term in facts["terms"]]
    kept = "no further term" if not terms else _listed(terms)
    resonances = [
        f"at {number(hz)} ± {number(sd, 2)} Hz at {kg:g} kg"
        if hz < SEEN_HZ
        else f"above {SEEN_HZ:g} Hz at {kg:g} kg"
        for kg, hz, sd in zip(
            facts["masses_kg"], facts["resonance_hz"], facts["resonance_sd_hz"], strict=True
        )
    ]
    own = [s for s in scores if s.model == "bristle-frame" and s.cutoff_hz == cutoff_hz]
    today = {(s.test, s.load): s for s in scores if s.model == "loaded-frame" and s.cutoff_hz == cutoff_hz}
    rows = [
        {
            "test": s.test,
            "load": s.load,
            "r2": number(s.r2, 3),
            "limit": number(s.r2_limit, 3),
            "loaded": number(today[s.test, s.load].r2, 3) if (s.test, s.load) in today else number(None),
        }
        for s in own
    ]
    return {"kept": kept, "resonances": _listed(resonances), "rows": rows}


def foot_sentences(own: pd.DataFrame, reference: str) -> list[str]:
    """Differences of K by the foot pathways from that of a pathway of the leg, and failed checks.

    Parameters
    ----------
    own : DataFrame
        Rows of estimates of the dummy (units in the column ``unit``).
    reference : str
        Pathway of the leg.

    Returns
    -------
    list of str
        One sentence per pathway from the foot with a treadmill model.
    """
    stiffness = own[own.quantity == "K"].set_index(["pathway", "condition"])
    found = []
    for pathway in dict.fromkeys(own.pathway):
        if not pathway.startswith("foot-compensated"):
            continue
        k = stiffness.loc[pathway].value
        differences = 100.0 * (k / stiffness.loc[reference].value.reindex(k.index) - 1.0).dropna()
        flags = stiffness.loc[pathway]["flags"].astype(object).fillna("").astype(str)
        failed = int(flags.str.contains("treadmill-model|beyond-calibrated-mass").sum())
        low, high = (percent(float(end), 1) for end in (differences.min(), differences.max()))
        text = f"K by “{words(pathway)}” differs from K by “{words(reference)}” by {low} to {high} %"
        text += (
            f"; in {failed} of {k.size} conditions the gate rejects the treadmill model."
            if failed
            else "; the gate accepts the treadmill model in all conditions."
        )
        found.append(text)
    return found


def _listed(parts: list[str]) -> str:
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"
