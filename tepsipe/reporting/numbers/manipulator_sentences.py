"""Sentences on the human joint, chosen by the numbers of the run: abstract, and lists of trials."""

import numpy as np

from tepsipe.reporting.numbers.format import number

# up to this number of trials is named one by one
NAMED = 3


def each(texts: dict[str, str], values, unit: str = "N·m/rad") -> str:
    """A quantity of every trial: one by one for few trials, else lowest to highest and median (in ``unit``).

    Parameters
    ----------
    texts : dict of str to str
        Trial -> value as text.
    values : Series
        The values, for their range (``unit``).
    unit : str
        Unit, written after the last one.

    Returns
    -------
    str
        For example ``75 N·m/rad in trial1 and 52 N·m/rad in trial3``.
    """
    if len(texts) == 1:
        return _with_unit(next(iter(texts.values())), unit)
    if len(texts) <= NAMED:
        return joined([f"{_with_unit(text, unit)} in {condition}" for condition, text in texts.items()])
    known = np.asarray(values, dtype=float)
    known = known[np.isfinite(known)]
    low, middle, high = (number(float(x)) for x in (known.min(), np.median(known), known.max()))
    return f"{low} to {high} {unit} (median {middle}, {len(known)} trials)"


def _with_unit(text: str, unit: str) -> str:
    """A value with its unit before the bracket of the interval."""
    value, bracket, rest = text.partition(" (")
    return f"{value} {unit}{bracket}{rest}"


def joined(words: list[str]) -> str:
    """Words (no unit) with commas and a last 'and'."""
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1] if words else ""


def trials_named(found: list[str], conditions: list[str]) -> str:
    """Some of the trials in words (no unit): all of them, or by name."""
    if len(conditions) == 1:
        return "the trial" if found else ""
    if len(found) == len(conditions):
        return "both trials" if len(found) == 2 else "all trials"
    return joined(found) if len(found) <= 2 * NAMED else f"{len(found)} of {len(conditions)} trials"


def abstract_data(a: dict) -> list[list]:
    """Templates of the paragraphs of the abstract with their values (units in them)."""
    there = [r for r in a["reflexes"] if r["there"]]
    parts, left = a["parts"], a["residuals"]
    told = [
        "The intrinsic stiffness of the {of} at the recorded amplitude is {stiffness_working}, with 95 % "
        "intervals in brackets. It falls from {stiffness_small} for the smallest movements to $K$ = "
        "{stiffness_beyond} beyond the short range."
        if a["short_range"]
        else "The intrinsic stiffness of the {of} at the recorded amplitude is {stiffness_working}, with "
        "95 % intervals in brackets. Of it, $K$ = {stiffness_beyond} remains after relaxation."
        if a["with_relaxation"]
        else "The intrinsic stiffness of the {of} is $K$ = {stiffness_beyond}, with 95 % intervals in "
        "brackets.",
        "The stiffness is that of the parallel-cascade model, which predicts the torque of the held-out part "
        "from the angle alone with a VAF of {vaf_each}.",
        "Inertia, damping and stiffness alone reach {vaf_alone_each}."
        if a["reflex_raises"]
        else "This is not in every trial more than the VAF of inertia, damping and stiffness alone, "
        "{vaf_alone_each}.",
    ]
    if a["half_unpredicted"]:
        told.append("In {unpredicted}, less than half of the torque's variance follows from the angle.")
    last = [
        "The stiffness differs between the thirds of {differing}."
        if parts["differing"]
        else "The stiffness does not differ between the thirds of {a_record}.",
    ]
    if left["mostly_slow"]:
        last.append("Of the power of the residual, {below} % lies below 1 Hz.")
    delays = [r["delays"] + ("" if a["one"] else f" in {r['condition']}") for r in there]
    values = {
        "of": a["joint"]["of"],
        "delays": joined(delays) if len(delays) <= NAMED else "other delays",
        "delay": " and ".join(dict.fromkeys(r["delay"] for r in there)),
        "lasting": number(max((r["lasting_ms"] for r in there), default=0.0), 2),
        "differing": trials_named(parts["differing"], a["columns"]),
        "a_record": "the record" if a["one"] else "any record",
        "below": left["below"],
        "unpredicted": a["half_unpredicted"],
    }
    used = ("stiffness_working", "stiffness_small", "stiffness_beyond", "vaf_each", "vaf_alone_each")
    values |= {key: a[key] for key in (*used, "stiffness", "with_reflex")}
    return [[" ".join(part), values] for part in (told, _of_reflex(a, there), last)]


def _of_reflex(a: dict, there: list[dict]) -> list[str]:
    """Templates of what is said on the reflex of all trials."""
    if not there:
        return ["A reflex pathway does not improve the prediction of any fitted part."]
    told = ["A reflex pathway was found in {with_reflex}."]
    if any(r["delay_assumed"] for r in there):
        told.append("Its delay of {delay} ms is assumed: the fitted parts are predicted best with {delays}.")
        if any(r["too_early"] for r in there):
            told.append("No reflex is so early, so the pathway also holds torque of other origin.")
    if any(r["late"] for r in there):
        told.append(
            "Its response lasts up to {lasting} ms after a stretch, so it holds more than the short-latency "
            "stretch reflex."
        )
    if len(there) == len(a["reflexes"]):
        told.append("The stiffness of the model without it, {stiffness}, includes reflex torque.")
    return told
