"""First sentences of the captions: what a figure of this run shows, chosen by its numbers."""

import math

from tepsipe.reporting.numbers.format import MINUS, number

DASH = number(None)
RIGS = {
    "wristalyzer": "the Wristalyzer",
    "dummy": "the dummy on the belt",
    "weight": "a weight on the belt",
    "standing": "a person on the belt",
}


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
    chapters = (
        ("dummy", _dummy),
        ("thesis_dummy", _thesis_dummy),
        ("simulation", _simulation),
        ("noise", _noise),
        ("standing", _standing),
        ("position_manipulator", _manipulator),
    )
    for name, sentences in chapters:
        if data.get(name) is not None:
            found |= sentences(data[name])
    return found | _schematics(data)


def _schematics(data: dict) -> dict[str, str]:
    """What the drawings say: which rigs, how many trials, how the signals are treated."""
    if data.get("dummy") is None or "experiments" not in data:
        return {}
    rigs = [RIGS[name] for name in RIGS if name in data["experiments"]]
    ways = "from the motion of the leg"
    if "weight" in data["experiments"]:
        ways += ", or from the motion of the foot and the force plate"
    cutoff = data["choices"]["dummy"]["analysis"]["lowpass_cutoff_hz"]
    return {
        "rigs": f"The rigs are {', '.join(rigs[:-1])} and {rigs[-1]}."
        if len(rigs) > 1
        else f"The rig is {rigs[0]}.",
        "protocol": f"The study has {data['trials']} trials; those of the dummy have "
        f"{data['dummy']['perturbations']} perturbations each.",
        "signal_chain": "All signals of a trial on the treadmill come to one clock and pass the same "
        f"low-pass of {cutoff:g} Hz.",
        "free_bodies": f"The torque of the joint follows {ways}.",
    }


def _dummy(d: dict) -> dict[str, str]:
    falls = ", and K falls with amplitude" if d["falls"] else ""
    found = {
        "4_4": f"The printed equation yields K = {d['printed_stiffness']} N·m/rad and I = "
        f"{d['printed_inertia']} N·m·s²/rad{falls}."
    }
    if "window_ms" in d:
        found["3_3"] = (
            f"The fitted windows follow the motion of the belt and last {d['window_ms']} ms on average."
        )
    belt = d.get("belt")
    if belt is not None:
        found["2_9"] = (
            f"The belt reaches {belt['peak']} % of the commanded peak velocity, {belt['delay']} ms after the "
            "command."
        )
    if d["signs_explain"]:
        found["pathways"] = (
            f"The consistent equation yields a mean K of {d['recommended_mean_stiffness']} N·m/rad, the "
            f"printed equation of {d['printed_mean_stiffness']} N·m/rad, from the same recordings."
        )
    if d["vaf_lower"]:
        found["torque"] = "The printed torque is fitted better than the consistent one, which is smaller."
    found["dummy_cross_validation"] = (
        "VAF depends more on the predicted trial (column) than on the trial of the parameters (row)."
        if d["vaf_of_trial"]
        else "VAF depends on the predicted trial (column) and on the trial of the parameters (row)."
    )
    if d.get("specification") is not None:
        found |= _specification(d["specification"])
    return found


def _specification(c: dict) -> dict[str, str]:
    best = c["recommended"]
    if best is None:
        return {}
    return {
        "specification": f"Of {c['count']} combinations of choices, {best['near']} % yield a K within 5 % of "
        f"the recommended {best['stiffness']} N·m/rad."
    }


def _thesis_dummy(t: dict) -> dict[str, str]:
    return {
        "thesis_dummy": f"One joint with {t['n']} constants returns {t['fitted_within']} of {t['fitted']} "
        f"fitted and {t['predicted_within']} of {t['predicted']} other printed numbers within tolerance."
    }


def _simulation(s: dict) -> dict[str, str]:
    found = {}
    c, signals = s.get("compared"), s.get("signals")
    if c is not None:
        grows = f"the swing grows in {c['growing']} of {c['all']} conditions"
        found["b"] = (
            "With the parameters of the printed equation "
            f"{'no swing grows' if c['growing'] == '0' else grows}."
        )
    if signals is None:
        return found
    best, shown = signals["best"], signals["shown"]
    for figure, key, where in (
        ("4_10", "vaf_perturbation", "In the perturbations"),
        ("4_11", "vaf_trial", "Over the full dataset"),
    ):
        angle, torque = best[f"theta_{key}"], best[f"tau_{key}"]
        found[figure] = (
            f"{where} the angle is predicted best by the parameters of {angle['name']} in {angle['count']} "
            f"of {angle['all']} conditions, the printed torque by those of {torque['name']} in "
            f"{torque['count']}."
        )
    torque = best["tau_vaf_perturbation"]
    found["b_13"] = (
        f"The printed torque is predicted best by the parameters of {torque['name']} in {torque['count']} of "
        f"{torque['all']} conditions."
    )
    for figure in ("4_7", "4_8"):
        if figure in shown:
            first, *_, last = shown[figure]["angle"]
            found[figure] = (
                f"Over trial {shown[figure]['condition']} the parameters of {first[0]} predict the angle "
                f"best (VAF {first[1]} %), those of {last[0]} worst ({last[1]} %)."
            )
    if "4_7" in shown:
        printed, consistent = shown["4_7"]["torque"][0], shown["4_7"]["consistent"][0]
        found["4_9"] = (
            f"The printed torque is predicted best by the parameters of {printed[0]} (VAF {printed[1]} %), "
            f"the consistent torque by those of {consistent[0]} ({consistent[1]} %)."
        )
    return found


def _noise(n: dict) -> dict[str, str]:
    found = {}
    if n.get("shown") is not None:
        found["4_12"] = (
            f"At {n['level']} dB the printed processing returns K = {n['shown']['as-printed']} N·m/rad for a "
            f"simulated K of {n['figure_stiffness']} N·m/rad, the recommended one "
            f"{n['shown']['recommended']} N·m/rad."
        )
    if n["method_sound"]:
        found["noise"] = (
            f"At {n['level']} dB on the angle, B and K of the recommended processing are at most "
            f"{n['iv_error']} % from the simulated values."
        )
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


def _manipulator(a: dict) -> dict[str, str]:
    """Captions of a joint in a position-controlled manipulator."""
    found = {}
    differing, drifting = a["parts"]["differing"], a["parts"]["drifting"]
    found["position_manipulator_stationarity"] = (
        f"The intrinsic stiffness differs between the thirds of {_and(differing)}"
        if differing
        else "The intrinsic stiffness does not differ between the thirds of a record"
    ) + (f"; the torque drifts in {_and(drifting)}." if drifting else "; the torque does not drift.")
    e = a["residuals"]
    white = "is white" if len(e["white"]) == e["count"] else "is not white"
    slow = f"; {e['below']} % of its power lies below 1 Hz" if e["mostly_slow"] else ""
    found["position_manipulator_residual"] = f"The residual {white} up to {e['cutoff']} Hz{slow}."
    found["position_manipulator_prediction"] = (
        "The parallel-cascade model predicts every held-out part better than inertia, damping and stiffness "
        "alone."
        if a["reflex_raises"]
        else "The parallel-cascade model does not predict every held-out part better than inertia, damping "
        "and stiffness alone."
    )
    there = [r for r in a["reflexes"] if r["there"]]
    gains = ", ".join(f"{r['gain']} N·m·s/rad ({r['condition']})" for r in there)
    found["position_manipulator_responses"] = (
        f"The reflex gain is {gains}." if there else "No reflex improves the prediction."
    )
    return found


def _and(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
