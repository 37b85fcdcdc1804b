"""First sentences of the captions: what a figure of this run shows, chosen by its numbers."""

import math

from tepsipe.reporting.numbers.format import MINUS, number

DASH = number(None)


def figure_findings_of(data: dict) -> dict[str, str]:
    """What the figures show, one sentence each (units in them).

    Parameters
    ----------
    data : dict
        Data of the report, texts and truth values.

    Returns
    -------
    dict of str to str
        Name of a figure -> sentence; a figure without a finding that holds in this run is not in it.
    """
    found: dict[str, str] = {}
    chapters = (("standing", _standing),)
    for name, sentences in chapters:
        if data.get(name) is not None:
            found |= sentences(data[name])
    return found


def _standing(p: dict) -> dict[str, str]:
    found = _of_muscles(p.get("signals"))
    best = p["recommended"]["estimator"]
    shares = [f"{row['over_mgh']} ({row['task']})" for row in p["estimators"] if row["name"] == best]
    if shares:
        found["standing_stiffness"] = (
            f"Both ankles together have {', '.join(shares)} times the critical stiffness m g h."
        )
    active = [row for row in p["estimators"] if row["name"] in p.get("active", ())]
    vaf = sorted((row["vaf"] for row in active if math.isfinite(_value(row["vaf"]))), key=_value)
    if vaf:
        found["standing_response"] = (
            f"With an active torque the models explain {vaf[0]} to {vaf[-1]} % of the mean torque."
        )
    if p.get("signals") is not None and p["free"]:
        plain = ", ".join(f"{x['K']} N·m/rad ({task})" for task, x in p["signals"]["plain"].items())
        ranges = " and ".join(f"{row['range']} % ({row['task']})" for row in p["free"])
        found["standing_window"] = (
            f"With a free reflex torque K changes by {ranges} between windows of "
            f"{p['free'][0]['windows_ms']} ms; without it K depends on the window: {plain}."
        )
    if p["visible"]:
        found["4_13"] = (
            f"The perturbations are clearly visible: the ankle turns at {p['angle_over_sway']} times the "
            "standard deviation of its velocity in unperturbed standing."
        )
    if p["joints"] and not p["rigid"]:
        knees = ", ".join(f"{row['knee']}° ({row['task']})" for row in p["joints"])
        found["standing_joints"] = f"The body above the ankles is not rigid: the knee turns by {knees}."
    return found


def _value(text: str) -> float:
    """A number (any unit) of a text as it is printed; NaN for dashes and powers of ten."""
    try:
        return float(text.replace(MINUS, "-"))
    except ValueError:
        return math.nan


def _of_muscles(signals: dict | None) -> dict[str, str]:
    """Responses and latencies of the muscles (uV, ms)."""
    found: dict[str, str] = {}
    if signals is None:
        return found
    if signals["largest"] is not None:
        big = signals["largest"]
        found["standing_activity"] = (
            f"The largest mean response is that of {big['muscle']} in {big['condition']}: {big['peak']} µV, "
            f"{big['at']} ms after the belt starts."
        )
    if signals["latency"] is not None:
        found["standing_latency"] = (
            f"The muscles respond {signals['latency']} ms after the start of the stretch; the three "
            f"detectors differ by at most {signals['detectors']} ms."
        )
        found["4_14"] = (
            f"The muscles respond {signals['latency']} ms after the start of the stretch; the smoothed "
            "envelopes show this too early."
        )
    return found
