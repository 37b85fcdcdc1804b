"""Numbers and sentences of the chapter on walking."""

import math

import numpy as np
import pandas as pd

from tepsipe.reporting.numbers.format import number


def walking_data(rows: pd.DataFrame, needed: pd.DataFrame, about: list[dict], study: dict) -> dict:
    """What the chapter reads.

    Parameters
    ----------
    rows, needed : DataFrame
        Tables of the study (units in their columns).
    about : list of dict
        Per trial: condition, strides (-), pulses (-), stance_s, bandwidth_hz, agreement_Nm, dropped.
    study : dict
        title, recordings_source, planned (section of the configuration), code (version).

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
        "findings": [sentence for trial in about for sentence in _sentences(trial, rows, needed)],
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
    elif len(silent):
        phases = ", ".join(f"{p:g}" for p in silent.phase_percent)
        found.append(
            f"{name}: the angle does not respond at {phases} % of stance, the interval of K is infinite."
        )
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
                number(math.degrees(mean.angle_sd_rad)),
                number(math.degrees(state.angle_sd_rad)),
                str(math.ceil(mean.strides_for_15_percent)),
                str(math.ceil(state.strides_for_15_percent)),
            ]
        )
    return cells
