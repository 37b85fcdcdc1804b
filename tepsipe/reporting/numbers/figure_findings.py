"""First sentences of the captions: what a figure of this run shows, chosen by its numbers."""

from tepsipe.reporting.numbers.format import number

DASH = number(None)
# values that differ by less are called the same (%)
ALIKE = 5.0


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
        ("wristalyzer", _wristalyzer),
        ("dummy", _dummy),
        ("thesis_dummy", _thesis_dummy),
        ("simulation", _simulation),
        ("noise", _noise),
        ("weight", _weight),
        ("standing", _standing),
        ("budgets", _budgets),
    )
    for name, sentences in chapters:
        if data.get(name) is not None:
            found |= sentences(data[name])
    return found


def _wristalyzer(w: dict) -> dict[str, str]:
    found = {"4_2": f"The fitted model predicts the angle with a VAF of {w['vaf']} % over the scale factors."}
    if w["natural_frequency"] != DASH:
        found["4_1"] = f"The fitted joint has a natural frequency of {w['natural_frequency']} Hz."
    if w["cross_validated"] != DASH:
        found["4_3"] = (
            f"Parameters of the other scale factors predict the angle with a mean VAF of "
            f"{w['cross_validated']} %."
        )
    if w["one_minimum"] and w["modulus_depends"]:
        found["starting_values"] = (
            "The fit to the complex residual does not depend on the starting value of K, the fit to its "
            "modulus does."
        )
    if w["periodic"] is not None:
        shift = w["periodic"]["shift_damping"]
        alike = shift != DASH and float(shift) < ALIKE
        found["averaging"] = (
            f"{'Both averages give the same admittance' if alike else 'The two averages differ'}: B differs "
            f"by at most {shift} %."
        )
    if w.get("pooled") is not None:
        low, high = w["pooled"]["stiffness"]
        found["wristalyzer_amplitudes"] = (
            f"Without friction and hardening, K is {low} N·m/rad in the trial with the smallest motion and "
            f"{high} N·m/rad in that with the largest."
        )
    return found


def _dummy(d: dict) -> dict[str, str]:
    falls = ", and K falls with amplitude" if d["falls"] else ""
    found = {
        "4_4": f"The printed equation yields K = {d['printed_stiffness']} N·m/rad and I = "
        f"{d['printed_inertia']} N·m·s²/rad{falls}."
    }
    if d["signs_explain"]:
        found["pathways"] = (
            f"The consistent equation yields a mean K of {d['recommended_mean_stiffness']} N·m/rad, the "
            f"printed equation of {d['printed_mean_stiffness']} N·m/rad, from the same recordings."
        )
    if d["vaf_lower"]:
        found["torque"] = "The printed torque is fitted better than the consistent one, which is smaller."
    if d["vaf_of_trial"]:
        found["dummy_cross_validation"] = (
            "VAF depends more on the predicted trial (column) than on the trial of the parameters (row)."
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
    c = s.get("compared")
    if c is None:
        return {}
    found = {
        "b": f"With the parameters of the printed equation the swing grows in {c['growing']} of {c['all']} "
        "conditions."
    }
    if c["angle"]:
        found["4_11"] = (
            "Over the full dataset the parameters of the Wristalyzer predict the angle better than those of "
            "TEP-SIPE as printed."
        )
    return found


def _noise(n: dict) -> dict[str, str]:
    found = {"4_12": f"The simulated joint of this figure has K = {n['figure_stiffness']} N·m/rad."}
    if n["method_sound"]:
        found["noise"] = (
            f"At {n['level']} dB on the angle, B and K of the recommended processing are at most "
            f"{n['iv_error']} % from the simulated values."
        )
    return found


def _weight(w: dict) -> dict[str, str]:
    found = {
        "4_6": f"The estimated mass of a weight of {w['mass']} kg is {w['mass_span']} kg over the trials.",
        "5_1": f"At {w['coarse']} the belt-induced force under the weight is {w['size_coarse']} times that "
        "of the empty belt.",
    }
    if w["load_matters"]:
        found["4_5"] = (
            f"Under the weight the belt-induced force is {w['size_fine']} times that of the empty belt."
        )
    if w["linear_other"] and w["best_frame"] != DASH:
        found["plate_models"] = (
            f"Under the weight, linear models of the empty belt reach R² = {w['linear_other']}, the best "
            f"frame fitted to both R² = {w['best_frame']}."
        )
    return found


def _standing(p: dict) -> dict[str, str]:
    found = {}
    if p["visible"]:
        found["4_13"] = (
            f"The perturbations are clearly visible: the ankle turns at {p['angle_over_sway']} times the "
            "standard deviation of its velocity in unperturbed standing."
        )
    if p["joints"] and not p["rigid"]:
        knees = ", ".join(f"{row['knee']}° ({row['task']})" for row in p["joints"])
        found["standing_joints"] = f"The body above the ankles is not rigid: the knee turns by {knees}."
    return found


def _budgets(budgets: dict) -> dict[str, str]:
    found = {}
    for name, budget in budgets.items():
        parts = [
            f"that of {q['quantity'] if len(q['quantity']) == 1 else 'the ' + q['quantity']} is the "
            f"{q['largest']} ({q['size']} %)"
            for q in budget["quantities"]
        ]
        if parts:
            first = parts[0].replace("that of", "The largest source of uncertainty of", 1)
            found[f"budget_{name}"] = f"{', '.join([first, *parts[1:]])}, in the typical trial."
    return found
