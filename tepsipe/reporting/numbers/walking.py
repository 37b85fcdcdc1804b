"""Numbers and sentences of the chapter on walking."""

import math

import numpy as np
import pandas as pd

from tepsipe.reporting.numbers.format import number


def walking_data(
    rows: pd.DataFrame,
    needed: pd.DataFrame,
    about: list[dict],
    study: dict,
    recovery: pd.DataFrame | None = None,
) -> dict:
    """What the chapter reads.

    Parameters
    ----------
    rows, needed : DataFrame
        Tables of the study (units in their columns).
    about : list of dict
        Per trial: condition, strides (-), pulses (-), stance_s, bandwidth_hz, agreement_Nm, dropped.
    study : dict
        title, recordings_source, planned (section of the configuration), code (version).
    recovery : DataFrame or None
        Truth of simulated trials (units in its column), None where there are none.

    Returns
    -------
    dict
        Texts and cells (units in the chapter).
    """
    return {
        "title": study["title"],
        "source": study["recordings_source"] or "",
        "code": study["code"],
        "amplitude": f"{study['planned']['amplitude_deg']:g}",
        "ramp": f"{1e3 * study['planned']['duration_s']:g}",
        "damping": f"{study['planned']['damping_Nms_per_rad']:g}",
        "simulated": [trial["condition"] for trial in about if trial.get("source") == "virtual_lab"],
        "findings": [
            *(sentence for trial in about for sentence in _sentences(trial, rows, needed)),
            *([] if recovery is None else _recovered(recovery)),
        ],
        "strides": study["planned"]["strides"],
        "rows": [_cells(row) for row in rows[rows.quantity != "I"].itertuples()],
        "needed": _needed(needed),
        "dropped": [text for trial in about for text in trial["dropped"]],
    }


def _sentences(trial: dict, rows: pd.DataFrame, needed: pd.DataFrame) -> list[str]:
    name = trial["condition"]
    pulses = f"{trial['pulses']} pulses" if trial["pulses"] else "no pulses"
    found = [f"{name}: {trial['strides']} strides with a stance of {number(trial['stance_s'])} s, {pulses}."]
    if trial["bandwidth_hz"] is not None:
        below = trial["bandwidth_hz"] < 15.0
        verdict = "it cannot show a pulse" if below else "it can show a pulse"
        found.append(
            f"{name}: the supplied moment of the ankle has a bandwidth of {number(trial['bandwidth_hz'])} "
            f"Hz: {verdict}. "
            f"The moment from force and centre of pressure differs from it by "
            f"{number(trial['agreement_Nm'])} N·m RMS "
            "below 6 Hz."
        )
    own = rows[(rows.condition == name) & (rows.quantity == "K")]
    silent = own[own["flags"] == "no-response"]
    if len(silent) == len(own) and not trial["pulses"]:
        found.append(
            f"{name}: pulses of no size at random strides give infinite intervals of K at all {len(own)} "
            "phases."
        )
    in_the_air = own[own["flags"] == "no-contact"]
    if len(in_the_air):
        phases = ", ".join(f"{p:g}" for p in in_the_air.phase_percent)
        found.append(
            f"{name}: at {phases} % of stance the foot is in the air; pulses there are a control, and have "
            "no impedance."
        )
    if len(silent) and (len(silent) < len(own) or trial["pulses"]):
        phases = ", ".join(f"{p:g}" for p in silent.phase_percent)
        found.append(
            f"{name}: the angle does not respond at {phases} % of stance, the interval of K is infinite."
        )
    if trial.get("source") == "virtual_lab":
        return found
    matched = needed[(needed.condition == name) & (needed.matching == "state")]
    counts = [
        f"{math.ceil(c)} at {p:g} %"
        for p, c in zip(matched.phase_percent, matched.strides_for_15_percent, strict=True)
    ]
    first, *others = counts
    first = first.replace(" at", " perturbed strides at", 1)
    found.append(
        f"{name}: a standard uncertainty of 15 % of the expected K needs {first} of stance"
        + "".join(f", {count}" for count in others)
        + "."
    )
    return found


def _recovered(recovery: pd.DataFrame) -> list[str]:
    """How far K of simulated trials is from the truth."""
    found = []
    for condition, own in recovery[recovery.quantity == "K"].groupby("condition", sort=False):
        errors = 100.0 * own.relative_error.astype(float)
        held = int(own.covered.astype(str).str.lower().eq("true").sum())
        each = ", ".join(
            f"{error:+.1f} % at {pathway.removeprefix('stance-')} %".replace("-", "−")
            for error, pathway in zip(errors, own.pathway, strict=True)
        )
        found.append(
            f"{condition}, simulated: errors of K are {each} of stance; {held} of {len(own)} intervals hold "
            "the truth."
        )
    return found


def _cells(row) -> list[str]:
    ends = [float(row.ci_low), float(row.ci_high)]
    finite = np.isfinite(ends).all()
    return [
        row.condition,
        f"{row.phase_percent:g}",
        f"{row.at_percent:.0f}" if finite else "–",
        row.quantity,
        number(float(row.value)) if finite else "–",
        f"{number(ends[0])} to {number(ends[1])}" if finite else "infinite",
        number(float(row.u_type_a)) if finite else "–",
        number(float(row.u_type_b)) if finite else "–",
        str(row.perturbed),
        str(row.unperturbed),
    ]


def _needed(needed: pd.DataFrame) -> list[list[str]]:
    cells = []
    for (condition, phase), own in needed.groupby(["condition", "phase_percent"], sort=False):
        state, mean = (own[own.matching == kind].iloc[0] for kind in ("state", "mean"))
        cells.append(
            [
                condition,
                f"{phase:g}",
                number(state.K_Nm_per_rad),
                number(mean.moment_sd_Nm),
                number(state.moment_sd_Nm),
                str(math.ceil(mean.strides_for_15_percent)),
                str(math.ceil(state.strides_for_15_percent)),
                str(int(state.planned_strides)),
                f"{state.planned_u_percent:.0f}",
            ]
        )
    return cells
