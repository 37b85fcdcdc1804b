"""Every number that the report prints, taken from the run and formatted once."""

import math

import numpy as np
import pandas as pd

from tepsipe.output_error import ESTIMATOR
from tepsipe.result_file import Result
from tepsipe.segment_regression import ESTIMATORS
from tepsipe.specification import FILTERED, NONE, RECOMMENDED, Specification
from tepsipe.thesis_tables import TableRow

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MINUS = "\N{MINUS SIGN}"
LABELS = {
    "SEM_I": "SEM of I",
    "SEM_B": "SEM of B",
    "SEM_K": "SEM of K",
    "SE_I": "standard error of I",
    "SE_B": "standard error of B",
    "SE_K": "standard error of K",
    "error": "error",
    "VAF_trial": "VAF of the full dataset",
    "VAF_perturbation": "VAF of a perturbation",
    "VAF_cross_validated": "VAF, cross-validated",
    "VAF_theta_perturbation": "VAF of the angle, perturbation",
    "VAF_theta_trial": "VAF of the angle, full dataset",
}


def number(value: float | int | None, digits: int = 3) -> str:
    """A number (any unit) as text with ``digits`` significant digits; a dash for None."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "\N{EN DASH}"
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    if value != 0.0 and not 1e-3 <= abs(value) < 1e5:
        mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
        text = f"{mantissa}·10{str(int(exponent)).translate(SUPERSCRIPTS)}"
    elif value == 0.0:
        text = "0"
    elif isinstance(value, int):
        text = str(value)
    else:
        decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
        text = f"{value:.{decimals}f}"
    return text.replace("-", MINUS)


def percent(value: float, decimals: int = 1) -> str:
    """A percentage (%) as text."""
    return f"{value:.{decimals}f}".replace("-", MINUS)


def span(values, digits: int = 3) -> str:
    """Lowest to highest of some numbers (any unit) as text."""
    low, high = number(min(values), digits), number(max(values), digits)
    return low if low == high else f"{low} to {high}"


def span_of_decimals(values, decimals: int) -> str:
    """Lowest to highest of some numbers (any unit) as text, with so many decimals."""
    low, high = (f"{x:.{decimals}f}".replace("-", MINUS) for x in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def _cell(quantity: str, value: float | None) -> str:
    if value is None:
        return number(None)
    if quantity.startswith("VAF"):
        return percent(value, 2 if value > 99.0 else 1)
    if quantity in ("I", "B"):
        return f"{value:.4f}".replace("-", MINUS)
    if quantity == "K":
        return f"{value:.3f}".replace("-", MINUS)
    return number(value, 2)


def _printed(value: float | None) -> str:
    return number(None) if value is None else f"{value:g}".replace("-", MINUS)


def table_data(rows: list[TableRow], conditions: list[str], names: list[str]) -> list[dict]:
    """Blocks of a thesis table as text.

    Parameters
    ----------
    rows : list of TableRow
        From `lay_out_table` (units in them).
    conditions, names : list of str
        Columns, and how to call them.

    Returns
    -------
    list of dict
        One per pathway: ``pathway``, ``estimator``, ``columns``, and ``rows`` with ``label``, ``unit``,
        ``values`` and ``reported``.
    """
    if len(names) != len(conditions):
        raise ValueError("as many names as conditions are needed")
    blocks: dict[tuple, dict] = {}
    for row in rows:
        block = blocks.setdefault(
            (row.pathway, row.estimator),
            {"pathway": row.pathway, "estimator": row.estimator, "columns": names, "rows": []},
        )
        block["rows"].append(
            {
                "label": LABELS.get(row.quantity, row.quantity),
                "unit": row.unit if row.unit not in ("1", "as printed") else "",
                "values": [_cell(row.quantity, value) for value in row.values],
                "reported": [_printed(value) for value in row.reported],
            }
        )
    return list(blocks.values())


def reported_data(reported: dict, start_stiffness: float) -> dict:
    """What the text quotes from the thesis, as text.

    Parameters
    ----------
    reported : dict
        The file of reported values (units in its keys, and as in the tables).
    start_stiffness : float
        Printed starting value of K (Nm/rad).

    Returns
    -------
    dict
        Text.
    """
    wristalyzer = reported["tables"]["table_4_1"]
    stiffness = list(wristalyzer["K"].values())
    inertia = list(wristalyzer["I"].values())
    ratio = float(np.mean(stiffness) / np.mean(inertia))
    meant = {(s["table"], s["quantity"], s["condition"]): s["meant"] for s in reported["slips"]}

    def _on_belt(quantity: str) -> list[float]:
        return [
            meant.get((name, quantity, condition), value)
            for name in ("table_4_2", "table_4_3")
            for condition, value in reported["tables"][name][quantity].items()
        ]

    vaf_trial = _on_belt("VAF_trial")
    return {
        **{key: f"{value:g}" for key, value in reported["values"].items()},
        "natural_frequency_hz": number(math.sqrt(ratio) / 2.0 / math.pi, 2),
        "start_stiffness": f"{start_stiffness:g}",
        "stiffness_at_start": str(sum(abs(k - start_stiffness) < 5e-4 for k in stiffness)),
        "stiffness_count": str(len(stiffness)),
        "inertia": span(_on_belt("I"), 2),
        "stiffness": span(_on_belt("K"), 2),
        "sem_stiffness": span(_on_belt("SEM_K"), 2),
        "vaf": span(wristalyzer["VAF_trial"].values(), 2),
        "vaf_trial": f"{percent(min(vaf_trial), 2)} to {percent(max(vaf_trial), 2)}",
    }


def slips_data(slips: list[dict], table: str, conditions: list[str], names: list[str]) -> str:
    """One sentence per evident slip in a table of the thesis (no unit: values as printed).

    ``slips`` have the keys table, quantity, condition, printed, meant; ``names`` are how the table calls
    its ``conditions``.
    """
    called = dict(zip(conditions, names, strict=True))
    return " ".join(
        f"The thesis prints {slip['printed']:g} for {slip['quantity']} in {called[slip['condition']]}, "
        f"evidently a slip for {slip['meant']:g}."
        for slip in slips
        if slip["table"] == table and slip["condition"] in called
    )


def wristalyzer_data(fits: dict[str, Result], estimates: pd.DataFrame, choices: dict, best: str) -> dict:
    """Numbers of the Wristalyzer's chapter as text.

    Parameters
    ----------
    fits : dict of str to Result
        Condition -> fit.
    estimates : DataFrame
        Rows of estimates (units in the column ``unit``).
    choices : dict
        Section ``wristalyzer`` of the configuration (units in the keys).
    best : str
        Condition shown in the figures.

    Returns
    -------
    dict
        Text.
    """
    own = estimates[estimates.experiment == "wristalyzer"]

    def values(quantity: str, estimator: str = "spectral-fit") -> pd.Series:
        chosen = own[(own.quantity == quantity) & (own.estimator == estimator)]
        return chosen.set_index("condition").value

    band = choices["analysis"]["fit_band_hz"]
    arrays = fits[best].arrays
    frequency = arrays["spectral-fit/frequency"]
    inside = (frequency >= band[0]) & (frequency <= band[1])
    coherence = arrays["spectral-fit/coherence"][inside]
    lowest = int(np.argmin(coherence))
    inertia, stiffness = values("I")[best], values("K")[best]
    facts = [fit.facts for fit in fits.values()]
    own_facts = fits[best].facts
    tried = []
    for k, start in enumerate(arrays["tried/stiffness"]):
        smooth, modulus = arrays["tried/smooth"][k], arrays["tried/modulus"][k]
        cost_ratio = own_facts["tried_modulus_cost"][k] / own_facts["tried_smooth_cost"][k]
        tried.append(
            {
                "start": f"{start:g}",
                "smooth": [_cell("B", smooth[1]), _cell("K", smooth[2])],
                "modulus": [_cell("B", modulus[1]), _cell("K", modulus[2])],
                "cost": number(cost_ratio),
                "vaf": percent(own_facts["tried_modulus_vaf_percent"][k]),
                "converged": own_facts["tried_modulus_converged"][k],
            }
        )
    data = {
        "best": best,
        "vaf": span(values("VAF_trial"), 3),
        "vaf_modulus": span(values("VAF_trial", "spectral-fit-modulus"), 3),
        "inertia": span(values("I")),
        "damping": span(values("B")),
        "stiffness": span(values("K")),
        "damping_modulus": span(values("B", "spectral-fit-modulus")),
        "coherence": number(float(coherence[lowest])),
        "coherence_at": number(float(frequency[inside][lowest]), 2),
        "natural_frequency": number(math.sqrt(stiffness / inertia) / 2.0 / math.pi, 2),
        "starts": str(len(fits[best].arrays["many_starts/start"])),
        "starts_converged": str(min(f["many_starts_converged"] for f in facts)),
        "starts_spread": number(max(f["many_starts_stiffness_spread_Nm_per_rad"] for f in facts), 2),
        "modulus_converged": str(sum(f["converged"]["spectral-fit-modulus"] for f in facts)),
        "trials": str(len(facts)),
        "tried": tried,
        "bins": str(choices["analysis"]["averaged_bins"]),
        "cross_validated": span(values("VAF_cross_validated"), 3) if len(fits) > 1 else number(None),
        "periodic": None,
    }
    periodic = own[own.estimator == "spectral-fit-periods"]
    if len(periodic):
        stiffness_rows = periodic[periodic.quantity == "K"]
        data["periodic"] = {
            "period": number(choices["analysis"]["perturbation_period_s"], 3),
            "damping": span(values("B", "spectral-fit-periods")),
            "stiffness": span(values("K", "spectral-fit-periods")),
            "shift_damping": percent(
                100.0 * float((values("B") / values("B", "spectral-fit-periods") - 1.0).abs().max())
            ),
            "intervals": [
                {"condition": r.condition, "low": number(r.ci_low), "high": number(r.ci_high)}
                for r in stiffness_rows.itertuples()
            ],
        }
    return data


def dummy_data(
    fits: dict[str, Result],
    estimates: pd.DataFrame,
    choices: dict,
    recovery: pd.DataFrame | None,
    amplitudes: dict[str, float | None],
) -> dict:
    """Numbers of the ankle dummy's chapter as text.

    Parameters
    ----------
    fits : dict of str to Result
        Condition -> fit.
    estimates : DataFrame
        Rows of estimates (units in the column ``unit``).
    choices : dict
        Section ``dummy`` of the configuration (units in the keys).
    recovery : DataFrame or None
        Estimates beside the truth, where there is one.
    amplitudes : dict of str to float or None
        Condition -> velocity amplitude (m/s), None where the trial sheet has none.

    Returns
    -------
    dict
        Text.
    """
    own = estimates[estimates.experiment == "dummy"]
    printed, recommended = choices["as_printed"], choices["recommended"]

    def values(quantity: str, pathway: str) -> pd.Series:
        chosen = own[(own.quantity == quantity) & (own.pathway == pathway)]
        return chosen.set_index("condition").value

    def amplitude(condition: str) -> float:
        return math.nan if amplitudes[condition] is None else amplitudes[condition]

    geometry = choices["geometry"]
    leg_mgr = geometry["leg_mass_kg"] * geometry["gravity_m_per_s2"] * geometry["leg_com_m"]
    conditions = list(fits)
    smallest = min(conditions, key=lambda c: (amplitude(c), c))
    largest = max(conditions, key=lambda c: (amplitude(c), c))
    clear = [c for c in conditions if amplitude(c) >= 0.3] or conditions
    slope = 1e-3 * float(
        np.mean([fit.facts["damping_per_skew_Nms_per_rad_per_s"][printed] for fit in fits.values()])
    )
    stiffness = own[(own.quantity == "K") & (own.pathway == printed)]
    data = {
        "sem_stiffness": span(stiffness.sem_as_printed, 2),
        "error_stiffness": span(stiffness.standard_error, 2),
        "printed": printed,
        "recommended": recommended,
        "two_leg_inertia": number(2.0 * geometry["leg_inertia_kgm2"]),
        "two_mgr": number(2.0 * leg_mgr),
        "printed_inertia": span(values("I", printed)),
        "printed_stiffness": span(values("K", printed)),
        "printed_mean_inertia": number(values("I", printed).mean()),
        "printed_mean_stiffness": number(values("K", printed)[clear].mean()),
        "recommended_mean_inertia": number(float(values("I", recommended)[clear].mean()), 2),
        "recommended_mean_stiffness": number(float(values("K", recommended)[clear].mean())),
        "recommended_mean_damping": number(values("B", recommended)[clear].mean()),
        "shift_inertia": number(float((values("I", printed) - values("I", recommended))[clear].mean())),
        "shift_stiffness": number(float((values("K", recommended) - values("K", printed))[clear].mean())),
        "clear_from": number(min(map(amplitude, clear)), 1),
        "smallest": smallest,
        "largest": largest,
        "vaf_printed_smallest": percent(values("VAF_perturbation", printed)[smallest], 2),
        "vaf_recommended_smallest": percent(values("VAF_perturbation", recommended)[smallest]),
        "vaf_printed_largest": percent(values("VAF_perturbation", printed)[largest], 2),
        "vaf_recommended_largest": percent(values("VAF_perturbation", recommended)[largest]),
        "vaf_trial_printed": f"{percent(values('VAF_trial', printed).min())} to "
        f"{percent(values('VAF_trial', printed).max())}",
        "window_ms": number(1e3 * float(np.mean([fit.facts["mean_window_s"] for fit in fits.values()]))),
        "marker_noise_mm": number(
            1e3 * float(np.mean([fit.facts["marker_noise_m"] for fit in fits.values()])), 2
        ),
        "misfit_mm": number(1e3 * max(fit.facts["misfit_m"] for fit in fits.values()), 2),
        "perturbations": span([len(fit.arrays["windows"]) for fit in fits.values()], 2),
        "damping_per_ms": number(slope, 2),
        "skew_ms": number(abs(values("B", printed).mean() / slope), 2),
        "strober": None,
        "recovery": None,
        "output_error": None,
    }
    by_simulation = [name for name, c in choices["pathways"].items() if c["estimator"] == ESTIMATOR]
    if by_simulation:
        data["output_error"] = _output_error_data(by_simulation[0], fits, own, recovery)
    strober = choices["ingest"]["strober_frequency_hz"]
    strobed = [
        name
        for name, pathway in choices["pathways"].items()
        if pathway["marker_instants"] == "as-strobed"
        and pathway["torque"] == choices["pathways"][printed]["torque"]
    ]
    if strobed and strober:
        markers = len(choices["files"]["marker_labels"])
        data["strober"] = {
            "pathway": strobed[0],
            "frequency": number(strober, 4),
            "spread_ms": number(1e3 * (markers - 1) / strober, 2),
            "damping": number(values("B", strobed[0])[clear].mean()),
            "damping_aligned": number(values("B", printed)[clear].mean()),
        }
    if recovery is not None:
        rows = recovery[
            (recovery.experiment == "dummy")
            & (recovery.pathway == recommended)
            & recovery.condition.isin(clear)
        ]
        by = rows.groupby("quantity")
        covered = (rows.covered.astype(str).str.lower() == "true").mean()
        data["recovery"] = {
            "truth": {q: number(g.truth.iloc[0]) for q, g in by},
            "worst_stiffness": percent(100.0 * by.get_group("K").relative_error.abs().max()),
            "worst_damping": percent(100.0 * by.get_group("B").relative_error.abs().max(), 0),
            "covered": percent(100.0 * covered, 0),
            "count": str(len(clear)),
        }
    return data


def _output_error_data(
    pathway: str, fits: dict[str, Result], own: pd.DataFrame, recovery: pd.DataFrame | None
) -> dict:
    """Numbers of the output error as text."""
    rows = own[own.pathway == pathway]
    delays = [1e3 * fit.facts["output_error_delay_s"][pathway] for fit in fits.values()]
    data = {
        "pathway": pathway,
        "stiffness": span(rows[rows.quantity == "K"].value, 4),
        "damping": span(rows[rows.quantity == "B"].value),
        "inertia": number(1e3 * float(rows[rows.quantity == "I"].value.abs().max()), 1),
        "error_stiffness": span(rows[rows.quantity == "K"].standard_error, 1),
        "vaf_angle": f"{percent(rows[rows.quantity == 'VAF_theta_trial'].value.min())} to "
        f"{percent(rows[rows.quantity == 'VAF_theta_trial'].value.max(), 2)}",
        "delay_ms": number(max(map(abs, delays)), 1),
        "recovery": None,
    }
    if recovery is not None:
        known = recovery[(recovery.experiment == "dummy") & (recovery.pathway == pathway)]
        by = known.groupby("quantity")
        covered = known.covered.astype(str).str.lower() == "true"
        data["recovery"] = {
            "worst_stiffness": percent(100.0 * by.get_group("K").relative_error.abs().max()),
            "worst_damping": percent(100.0 * by.get_group("B").relative_error.abs().max()),
            "covered": str(int(covered.sum())),
            "total": str(len(known)),
        }
    return data


def specification_data(rows: list[Specification]) -> dict:
    """Numbers of the specification curve as text.

    Parameters
    ----------
    rows : list of Specification
        Of one trial (units in their names).

    Returns
    -------
    dict
        Text; ``recommended`` is None where none of them is the recommended one.
    """
    stiffness = np.array([row.K_Nm_per_rad for row in rows])
    role = np.array([row.role for row in rows])
    torque = np.array([row.torque for row in rows])
    estimator = np.array([row.estimator for row in rows])
    filtered = np.array([row.filtered for row in rows])
    damping = np.array([row.B_Nms_per_rad for row in rows])
    alike = filtered == FILTERED[0]
    vaf = np.array([row.VAF_percent for row in rows])
    sound = (torque == "leg") & alike & (estimator == "segment-regression")
    printed = (torque == "leg-printed") & alike
    data = {
        "condition": rows[0].condition,
        "count": str(len(rows)),
        "stiffness": span(stiffness, 2),
        "quarters": f"{number(np.percentile(stiffness, 25), 2)} to {number(np.percentile(stiffness, 75), 2)}",
        "sound": span(stiffness[sound]),
        "sound_count": str(int(sound.sum())),
        "leg_printed": span(stiffness[printed]),
        "leg_printed_count": str(int(printed.sum())),
        "output_error": span(stiffness[estimator == ESTIMATOR]),
        "damping": [
            {"filtered": name, "values": span(damping[(torque == "leg") & (filtered == name)], 2)}
            for name in (*FILTERED, NONE)
        ],
        "foot_rest_in": span(stiffness[(torque == "foot") & (estimator == ESTIMATORS[0])], 2),
        "foot_rest_out": span(stiffness[(torque == "foot") & (estimator == ESTIMATORS[1])], 2),
        "recommended": None,
    }
    chosen = stiffness[role == RECOMMENDED]
    if chosen.size:
        near = np.abs(stiffness / chosen[0] - 1.0) < 0.05
        high = vaf > 99.0
        data["recommended"] = {
            "stiffness": number(float(chosen[0])),
            "near": percent(100.0 * near.mean(), 0),
            "near_leg": percent(100.0 * near[torque == "leg"].mean(), 0),
            "near_filtered": [
                {
                    "filtered": name,
                    "near": percent(100.0 * near[(torque == "leg") & (filtered == name)].mean(), 0),
                }
                for name in (*FILTERED, NONE)
            ],
            "near_others": percent(100.0 * near[(torque != "leg") & (torque != "none")].mean(), 0),
            "high_vaf": str(int(high.sum())),
            "high_vaf_far": str(int((high & ~near).sum())),
        }
    return data


def claims_data(claims: pd.DataFrame) -> dict:
    """The thesis's statements with what this run found, as text (each in its unit)."""
    rows = [
        {
            "claim": row.claim,
            "where": row.where,
            "unit": "" if row.unit == "1" else row.unit,
            "reported": {"below": "< ", "above": "> "}.get(row.tolerance, "")
            + f"{row.reported:g}".replace("-", MINUS),
            "reproduced": number(float(row.reproduced), 4),
            "verdict": row.verdict,
            "section": row.section,
        }
        for row in claims.itertuples()
    ]
    counts = claims.verdict.value_counts()
    return {
        "rows": rows,
        "total": str(len(rows)),
        **{
            key.replace(" ", "_"): str(int(counts.get(key, 0)))
            for key in ("reproduced", "explained", "not reproduced")
        },
    }


def recovery_data(recovery: pd.DataFrame) -> list[dict]:
    """Estimates beside the truth (in their units), by pathway, estimator, quantity and truth, as text."""
    rows = []
    keys = ["experiment", "pathway", "estimator", "quantity", "truth"]
    for (experiment, pathway, estimator, quantity, truth), group in recovery.groupby(keys, sort=False):
        covered = (group.covered.astype(str).str.lower() == "true").sum()
        errors = group.relative_error.dropna()
        rows.append(
            {
                "experiment": experiment,
                "pathway": pathway,
                "estimator": estimator,
                "quantity": quantity,
                "unit": group.unit.iloc[0],
                "truth": number(truth),
                "low": _cell(quantity, group.value.min()),
                "high": _cell(quantity, group.value.max()),
                "median_error": percent(100.0 * errors.median()) if len(errors) else number(None),
                "covered": f"{covered} of {len(group)}",
            }
        )
    return rows


def provenance_data(provenance: dict) -> dict:
    """The provenance page as text: facts, packages and checksums (no units)."""
    commit = provenance["commit"] or "not a git checkout"
    if provenance["modified"]:
        commit += ", with uncommitted changes"
    return {
        "facts": [
            ["Commit", commit],
            ["Python", provenance["python"]],
            ["Configuration, SHA-256", provenance["config_sha256"]],
            ["Seed of the analysis", str(provenance["seed"])],
        ],
        "packages": [[name, text] for name, text in sorted(provenance["packages"].items())],
        "files": [[kind, entry["file"], entry["sha256"]] for kind, entry in provenance["files"].items()],
        "raw": [
            [trial, kind, entry["sha256"]]
            for trial, kinds in provenance["raw_files"].items()
            for kind, entry in kinds.items()
        ],
    }
