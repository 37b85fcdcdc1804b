"""Numbers of the chapter on the Wristalyzer."""

import math

import numpy as np
import pandas as pd

from tepsipe.io.result import Result
from tepsipe.reporting.figures.names import unit_symbol
from tepsipe.reporting.numbers.format import _cell, by_uncertainty, number, percent, span


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
        "coherence_low": float(coherence[lowest]),
        "vaf_end": float(values("VAF_trial").fillna(-math.inf).clip(lower=-1e9).iloc[-1]),
        "vaf_at_end": percent(values("VAF_trial").iloc[-1]),
        "coherence": number(float(coherence[lowest])),
        "coherence_at": number(float(frequency[inside][lowest]), 2),
        "natural_frequency": number(
            math.sqrt(stiffness / inertia) / 2.0 / math.pi if stiffness * inertia > 0.0 else None, 2
        ),
        "starts": str(len(fits[best].arrays["many_starts/start"])),
        "one_minimum": bool(
            max(f["many_starts_stiffness_spread_Nm_per_rad"] for f in facts) < 1e-3 * abs(stiffness)
            and min(f["many_starts_converged"] for f in facts) == len(arrays["many_starts/start"])
        ),
        "modulus_depends": _depends_on_start(fits),
        "modulus_poor": bool(
            values("VAF_trial", "spectral-fit-modulus").min() < values("VAF_trial").min() - 1.0
        ),
        **_highest(values("VAF_trial")),
        "starts_converged": str(min(f["many_starts_converged"] for f in facts)),
        "starts_spread": number(max(f["many_starts_stiffness_spread_Nm_per_rad"] for f in facts), 2),
        "modulus_converged": str(sum(f["converged"]["spectral-fit-modulus"] for f in facts)),
        "trials": str(len(facts)),
        "tried": tried,
        "bins": str(choices["analysis"]["averaged_bins"]),
        "cross_validated": span(values("VAF_cross_validated"), 3) if len(fits) > 1 else number(None),
        "periodic": None,
        "regression": _regression(own),
        "pooled": None,
    }
    periodic = own[own.estimator == "spectral-fit-periods"]
    if len(periodic):
        stiffness_rows = periodic[periodic.quantity == "K"]
        data["periodic"] = {
            "period": number(choices["analysis"]["perturbation_period_s"], 3),
            "leaks": _leaks(fits, choices["analysis"]["perturbation_period_s"]),
            "damping": span(values("B", "spectral-fit-periods")),
            "stiffness": span(values("K", "spectral-fit-periods")),
            "shift_damping": percent(
                100.0 * float((values("B") / values("B", "spectral-fit-periods") - 1.0).abs().max())
            ),
            "intervals": [
                {"condition": r.condition, "interval": by_uncertainty(r.value, r.ci_low, r.ci_high)[1]}
                for r in stiffness_rows.itertuples()
            ],
        }
    return data


def _regression(own: pd.DataFrame) -> list[dict] | None:
    """Estimates with 95 % intervals of the regression over whole periods (units as in the tables)."""
    rows = own[own.estimator == "period-regression"]
    if rows.empty:
        return None
    found = []
    for condition, of_trial in rows.groupby("condition", sort=False):
        cells = {}
        for r in of_trial[of_trial.quantity.isin(["I", "B", "K"])].itertuples():
            value, interval = by_uncertainty(r.value, r.ci_low, r.ci_high)
            cells[r.quantity] = f"{value} ({interval})" if interval else value
        found.append({"condition": condition, **cells})
    return found


def _leaks(fits: dict[str, Result], period_s: float) -> bool:
    """Whether a record without its ends is more than 1 % of a period (s) from a whole number of periods."""
    periods = [
        (f.facts["kept_samples"][1] - f.facts["kept_samples"][0]) / f.facts["rate_hz"] / period_s
        for f in fits.values()
    ]
    return any(abs(p - round(p)) > 0.01 for p in periods)


def _depends_on_start(fits: dict[str, Result]) -> bool:
    """Whether K (N·m/rad) of the fit with the modulus differs by more than 1 % between starting values."""
    found = [fit.arrays["tried/modulus"][:, 2] for fit in fits.values()]
    return any(float(np.ptp(k)) > 0.01 * float(np.abs(k).min()) for k in found)


def _highest(vaf: pd.Series) -> dict:
    """Scale factor with the highest VAF (%), and whether VAF falls towards both ends."""
    best = int(vaf.fillna(-math.inf).argmax())
    return {"vaf_best": str(vaf.index[best]), "vaf_peaks": 0 < best < len(vaf) - 1}


TERMS = {
    "I": "inertia $I$",
    "B": "damping $B$, small movements",
    "K": "stiffness $K$, small movements",
    "friction": "Coulomb friction",
    "K_cubic": "hardening, torque per angle cubed",
    "K_softened": "stiffness lost at large angles",
    "B_softened": "damping gained at large angles",
    "softening_angle": "angle at which half of the softening has taken place",
}


def pooled_data(pooled: Result, estimates: pd.DataFrame, recovery: pd.DataFrame | None) -> dict:
    """Numbers of the fit to all trials of the Wristalyzer together, as text.

    Parameters
    ----------
    pooled : Result
        Shares of the groups of terms in each trial.
    estimates : DataFrame
        Rows of estimates (units in the column ``unit``).
    recovery : DataFrame or None
        Comparison with the truth, if there is one.

    Returns
    -------
    dict
        Text.
    """
    own = estimates[(estimates.experiment == "wristalyzer") & (estimates.condition == "pooled")]
    truth, linear = {}, {}
    if recovery is not None:
        true = recovery[recovery.experiment == "wristalyzer"]
        together = true[true.condition == "pooled"]
        truth = dict(zip(together.quantity, together.truth, strict=True))
        each = true[(true.estimator == "spectral-fit-periods") & (true.condition != "pooled")]
        linear = dict(zip(zip(each.condition, each.quantity, strict=True), each.truth, strict=True))
    terms = [
        {
            "quantity": TERMS[r.quantity],
            "unit": unit_symbol(r.unit),
            "value": by_uncertainty(r.value, r.ci_low, r.ci_high)[0],
            "interval": by_uncertainty(r.value, r.ci_low, r.ci_high)[1],
            "truth": number(truth.get(r.quantity)),
        }
        for r in own.itertuples()
    ]
    friction = own[own.quantity == "friction"].iloc[0]
    covered = {"covered": None}
    if recovery is not None and len(together):
        held = [str(c).lower() == "true" for c in together.covered]
        linear_held = [str(c).lower() == "true" for c in each.covered]
        covered = {
            "covered": str(sum(held)),
            "covered_linear": str(sum(linear_held)),
            "total_linear": str(len(linear_held)),
        }
    facts = pooled.facts
    order = np.argsort(pooled.arrays["rms_angle"])
    of_friction = pooled.arrays["shares/friction"][order, 1]
    rubber = pooled.arrays["shares/small"][order]
    if "shares/softening" in pooled.arrays:
        rubber = rubber + pooled.arrays["shares/softening"][order]
    return {
        "stiffness": [number(float(rubber[k, 2])) for k in (0, -1)],
        "damping": [number(float(rubber[k, 1])) for k in (0, -1)],
        "of_friction": [number(float(of_friction[k])) for k in (0, -1)],
        "terms": terms,
        **covered,
        "rows": _amplitude_rows(pooled, estimates, linear),
        "has_truth": bool(truth),
        "softens": "K_softened" in set(own.quantity),
        "friction_found": bool(friction.ci_low > 0.0),
        "friction_negative": bool(friction.ci_high < 0.0),
        "systematic": number(1e3 * facts["systematic_torque_Nm"], 2),
        "without_softening": number(1e3 * facts["without_softening_Nm"], 2),
        "delay": number(1e3 * facts["delay_s"], 2),
    }


def _amplitude_rows(pooled: Result, estimates: pd.DataFrame, linear: dict) -> list[dict]:
    """K (N·m/rad) and B (N·m·s/rad) of each trial: rubber, manipulator, linear fits."""
    shares = {n.removeprefix("shares/"): a for n, a in pooled.arrays.items() if n.startswith("shares/")}
    found = estimates[
        (estimates.experiment == "wristalyzer") & (estimates.estimator == "spectral-fit-periods")
    ].set_index(["condition", "quantity"])
    rows = []
    for k, condition in enumerate(pooled.facts["conditions"]):
        row = {"condition": condition, "angle": number(float(pooled.arrays["rms_angle"][k]))}
        for quantity, column in (("K", 2), ("B", 1)):
            rubber = sum(float(shares[n][k, column]) for n in ("small", "softening") if n in shares)
            added = sum(float(shares[n][k, column]) for n in ("hardening", "friction"))
            row[quantity] = [
                number(rubber),
                number(added),
                number(rubber + added),
                number(float(found.value[condition, quantity])),
                number(linear.get((condition, quantity))),
            ]
        rows.append(row)
    return rows
