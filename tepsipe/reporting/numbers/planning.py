"""Numbers and sentences of the report on planned experiments and on filters."""

import math

import pandas as pd

from tepsipe.reporting.numbers.format import number, percent, span

HALF = 0.5
# a number of perturbations as text
_NONE = "none"
# perturbations of a trial of the thesis (-), and error of a filter, over the least one, that is as good (-)
PERTURBATIONS, NEAR = 14.0, 1.25


def plan_data(plan: pd.DataFrame, pulses: pd.DataFrame, filters: pd.DataFrame, about: dict) -> dict:
    """What the report reads.

    Parameters
    ----------
    plan, pulses, filters : DataFrame
        Tables of designs, best pulses and filters (units in their columns).
    about : dict
        ``title``, ``settings`` (section plan of the configuration) and ``code`` (version).

    Returns
    -------
    dict
        Texts and cells (units in the report).
    """
    return {
        "title": about["title"],
        "code": about["code"],
        "seed": about["settings"]["seed"],
        "draws": _draws(plan),
        "findings": [*_of_designs(plan), *_of_pulses(pulses), *_of_filters(filters)],
        "recommendation": _recommendation(filters),
        "designs": [_design_cells(row) for row in plan[plan.quantity == "K"].itertuples()],
        "others": [_other_cells(row) for row in plan[plan.quantity != "K"].itertuples()],
        "pulses": [_pulse_cells(row) for row in pulses.itertuples()],
        "filters": _filter_cells(filters),
    }


def _count(value) -> str:
    return _NONE if value is None or math.isnan(value) else str(round(value))


def _design_cells(row) -> list[str]:
    return [
        row.design,
        row.pathway,
        str(row.n_perturbations),
        number(row.predicted_u),
        number(row.monte_carlo_u),
        "–" if math.isnan(row.cramer_rao) else number(row.cramer_rao),
        number(row.u_type_b),
        percent(100.0 * row.bias / row.value, 1),
        percent(row.half_width_percent, 1),
        *(_count(getattr(row, f"n_for_{k}_percent")) for k in (5, 10, 20)),
    ]


def _other_cells(row) -> list[str]:
    cells = (row.predicted_u, row.monte_carlo_u, row.u_type_b)
    return [row.design, row.quantity, *map(number, cells), percent(row.half_width_percent, 1)]


def _pulse_cells(row) -> list[str]:
    peaks = (
        row.peak_velocity_m_per_s,
        1e3 * row.peak_displacement_m,
        row.peak_acceleration_m_per_s2,
        row.peak_jerk_m_per_s3,
    )
    return [
        row.reference,
        row.limits,
        row.belt,
        number(1e3 * row.reference_u),
        number(1e3 * row.best_u),
        number(row.u_ratio, 2),
        number(1e3 * row.reference_cramer_rao),
        number(1e3 * row.best_cramer_rao),
        number(1e3 * row.least_cramer_rao),
        *(number(x, 2) for x in peaks),
    ]


def _filter_cells(filters: pd.DataFrame) -> list[list[str]]:
    """Error of K and B by pathway and cutoff of the fourth-order zero-lag filter, range over the trials."""
    shown = _usual(filters[filters.source != "predicted"])
    rows = []
    for pathway in dict.fromkeys(shown.pathway):
        for cutoff, own in shown[shown.pathway == pathway].groupby("cutoff_hz"):
            cells = [pathway, number(cutoff, 2)]
            for quantity in ("K", "B"):
                one = own[own.quantity == quantity]
                cells += [span([one.bias.min(), one.bias.max()], 2), number(one.sd_of_window.mean(), 2)]
            rows.append(cells)
    return rows


def _usual(filters: pd.DataFrame) -> pd.DataFrame:
    return filters[(filters.kind == "zero-lag") & (filters.order == 4)]


def _draws(plan: pd.DataFrame) -> str:
    """Numbers of draws of the designs."""
    return " or ".join(str(n) for n in sorted(set(plan.draws)))


def _of_designs(plan: pd.DataFrame) -> list[str]:
    ratio = 100.0 * (plan.monte_carlo_u / plan.predicted_u - 1.0)
    of_k = ratio[plan.quantity == "K"]
    chance = 100.0 * float(plan.monte_carlo_error.max())
    found = [
        f"The standard deviation of K over {_draws(plan)} draws of noise differs from the "
        "predicted one by "
        f"{percent(of_k.min())} to {percent(of_k.max())} % in {len(of_k)} designs, that of I, B and K by "
        "at most "
        f"{percent(ratio.abs().max())} %; chance alone is {percent(chance)} % (one standard error)."
    ]
    needed = plan[(plan.quantity == "K")]
    one = needed[needed.n_for_10_percent == 1]
    if len(one):
        found.append(
            f"K within ±10 % needs one perturbation in {len(one)} of {len(needed)} designs: there "
            "tolerances of the "
            "calibration, not noise, limit it."
        )
    never = needed[needed.n_for_10_percent.isna()]
    if len(never):
        names = ", ".join(never.design)
        found.append(
            f"No number of perturbations gives K within ±10 % in {names}: tolerances and bias exceed it."
        )
    return found


def _of_pulses(pulses: pd.DataFrame) -> list[str]:
    own = pulses[pulses.limits == "its own peaks"]
    back, away = own[own.belt == "returns"], own[own.belt == "one way"]
    found = []
    if len(back):
        least = (back.least_cramer_rao / back.reference_cramer_rao).min()
        verdict = "cannot be halved" if least > HALF else "may be halved"
        found.append(
            f"If the belt returns within the pulse, the standard error of K {verdict} within the "
            "reference's peaks "
            "of velocity, displacement, acceleration and jerk: of a linear joint no pulse of this length "
            "has less "
            f"than {number(least, 2)} times its Cramér-Rao bound (upper bound of the information; "
            "references: "
            f"{', '.join(back.reference)})."
        )
    if len(away):
        linear = away.best_cramer_rao / away.reference_cramer_rao
        gap = 100.0 * (away.best_cramer_rao / away.least_cramer_rao).max() - 100.0
        found.append(
            "If the belt stays where it was moved to and goes back with the next pulse, the best pulse "
            "within the "
            f"same peaks has {span(away.u_ratio.tolist(), 2)} times the standard error of K of the "
            "recommended "
            f"estimator, and {span(linear.tolist(), 2)} times the Cramér-Rao bound of a linear joint; no "
            "pulse can "
            f"be below that by more than {percent(gap)} %."
        )
    fast = pulses[pulses.limits == "its own acceleration"]
    if len(fast):
        ratio = fast.u_ratio.tolist()
        verdict = "halved" if max(ratio) < HALF else "not halved"
        found.append(
            f"Within the same acceleration and drive alone, without limits of velocity and displacement, the "
            f"standard error is {verdict}: {span(ratio, 2)} times that of the reference at the same number."
        )
    return found


def _simulated(filters: pd.DataFrame, pathway: str, quantity: str) -> pd.DataFrame:
    return filters[
        (filters.source != "predicted") & (filters.pathway == pathway) & (filters.quantity == quantity)
    ]


def _of_filters(filters: pd.DataFrame) -> list[str]:
    found = []
    raw, subtracted = (_simulated(filters, name, "K") for name in ("foot", "foot-compensated"))
    if len(raw) and len(subtracted):
        best = raw.groupby(["kind", "order", "cutoff_hz"]).bias_percent.apply(lambda x: x.abs().max()).min()
        at = subtracted.groupby(["kind", "order", "cutoff_hz"]).bias_percent.apply(lambda x: x.abs().max())
        found.append(
            "No low-pass removes the treadmill: without compensation the error of K from plate and foot "
            "is up to "
            f"{percent(best, 0)} % in some trial even behind the best of {len(at)} filters; with "
            "compensation it is "
            f"at most {percent(at.min(), 0)} to {percent(at.max(), 0)} %, depending on the filter."
        )
    alone = filters[
        (filters.source == "predicted") & (filters.filtered != "alike") & (filters.quantity == "K")
    ]
    usual = alone[(alone.kind == "zero-lag") & (alone.order == 4) & (alone.cutoff_hz == 20.0)]
    if len(usual):
        found.append(
            "Without noise a filter of torque and motion alike leaves no bias; a filter of one side "
            "only, of 20 Hz and "
            f"fourth order, changes K by {span(usual.bias_percent.tolist(), 2)} %."
        )
    return found


def _recommendation(filters: pd.DataFrame) -> list[str]:
    """Cutoffs with the least error of K and B over the simulated trials, fourth order, zero-lag."""
    found = []
    for pathway in ("leg", "foot-compensated"):
        for quantity, unit in (("K", "N·m/rad"), ("B", "N·m·s/rad")):
            own = _usual(_simulated(filters, pathway, quantity))
            if own.empty:
                continue
            # of one trial of fourteen perturbations, as in the thesis
            square = own.bias**2 + own.sd_of_window**2 / PERTURBATIONS
            error = square.groupby(own.cutoff_hz).mean() ** 0.5
            near = error.index[error <= NEAR * error.min()]
            found.append(
                f"{quantity} with the torque from "
                f"{pathway.replace('foot-compensated', 'plate and foot, compensated')}"
                f": {span([near.min(), near.max()], 2)} Hz (root mean square error at most "
                f"{number(NEAR, 3)} times the "
                f"least one, {number(float(error.min()), 2)} {unit} at "
                f"{number(float(error.idxmin()), 2)} Hz; "
                f"{number(float(error.max()), 2)} {unit} at {number(float(error.idxmax()), 2)} Hz)."
            )
    return found
