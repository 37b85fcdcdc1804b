"""Recordings of the position-controlled manipulator, parts of a record, and residuals, as text."""

import math

import numpy as np

from tepsipe.io.result import Result
from tepsipe.reporting.numbers.format import MINUS, by_uncertainty, number, percent, span

# probability below which equal quantities are said to differ, or a residual not to be white (-)
LEVEL = 0.05
# number of trials in the figure of the torque, which has two rows for each
SHOWN_TRIALS = 3


def recordings_data(fits: dict[str, Result]) -> list[dict]:
    """Rows of the table of the recordings: label, unit, and a text for every trial."""
    about = [fit.facts["diagnostics"]["recording"] for fit in fits.values()]
    bands = [_coherent(fit) for fit in fits.values()]

    def row(label: str, unit: str, texts) -> dict:
        return {"label": label, "unit": unit, "values": list(texts)}

    return [
        row("length recorded, used", "s", (f"{a['recorded_s']:.1f}, {a['used_s']:.1f}" for a in about)),
        row("of which fitted, held out", "s", (f"{a['fitted_s']:.1f}, {a['held_out_s']:.1f}" for a in about)),
        row("mean angle", "rad (°)", (_angle(a["mean_angle_rad"]) for a in about)),
        row("standard deviation of the angle", "rad (°)", (_angle(a["sd_angle_rad"]) for a in about)),
        row(
            "peak-to-peak angle",
            "rad (°)",
            (_angle(a["highest_angle_rad"] - a["lowest_angle_rad"]) for a in about),
        ),
        row("velocity, root mean square", "rad/s", (number(a["rms_velocity_rad_per_s"], 2) for a in about)),
        row("velocity, peak", "rad/s", (number(a["peak_velocity_rad_per_s"], 2) for a in about)),
        row("angle: half power (−3 dB) at", "Hz", (number(a["half_power_hz"], 2) for a in about)),
        row("velocity: 95 % of the power below", "Hz", (number(a["velocity_95_hz"], 2) for a in about)),
        row("mean torque", "N·m", (number(a["mean_torque_Nm"]) for a in about)),
        row("standard deviation of the torque", "N·m", (number(a["sd_torque_Nm"]) for a in about)),
        row(
            "range of the torque",
            "N·m",
            (f"{number(a['lowest_torque_Nm'], 2)} to {number(a['highest_torque_Nm'], 2)}" for a in about),
        ),
        row("torque power above the cutoff", "%", (percent(a["above_cutoff_percent"], 0) for a in about)),
        row("coherence significant", "", bands),
    ]


def validity_data(fits: dict[str, Result]) -> dict:
    """Angles (rad), velocities (rad/s) and mean torques (N·m) at which the models were fitted."""
    about = [fit.facts["diagnostics"]["recording"] for fit in fits.values()]
    low, high = min(a["lowest_angle_rad"] for a in about), max(a["highest_angle_rad"] for a in about)
    angles = f"{low:.3f} to {high:.3f} rad ({math.degrees(low):.1f} to {math.degrees(high):.1f}°)"
    return {
        "angles": "angles of " + angles.replace("-", MINUS),
        "velocity": number(max(a["peak_velocity_rad_per_s"] for a in about), 2),
        "torques": span([a["mean_torque_Nm"] for a in about], 2),
    }


def _angle(value_rad: float) -> str:
    return f"{number(value_rad)} ({number(math.degrees(value_rad), 2)})"


def _coherent(fit: Result) -> str:
    """Where the coherence is above the level of unrelated signals: at what fraction of the frequencies."""
    found = fit.arrays["diagnostics/coherence"] > fit.arrays["diagnostics/coherence_level"]
    frequency = fit.arrays["diagnostics/frequency"]
    if not found.any():
        return "nowhere"
    inside = frequency[found]
    between = f"{number(inside[0], 2)} to {number(inside[-1], 2)} Hz"
    all_between = found[(frequency >= inside[0]) & (frequency <= inside[-1])].mean()
    return between if all_between == 1.0 else f"at {percent(100.0 * all_between, 0)} % of {between}"


def parts_data(fits: dict[str, Result]) -> dict:
    """Stiffness (N·m/rad) and level of the torque (N·m) in the thirds of the records, and what differs."""
    rows, differing, drifting = [], [], []
    for condition, fit in fits.items():
        facts = fit.facts["diagnostics"]
        cells = {}
        for name in ("stiffness", "level"):
            values = fit.arrays[f"diagnostics/part_{name}"]
            half = fit.arrays[f"diagnostics/part_{name}_half_width"]
            cells[name] = [
                _plus_minus(float(value), float(width)) for value, width in zip(values, half, strict=True)
            ]
        for name, found in (("stiffness", differing), ("level", drifting)):
            if facts[f"{name}_equal_p"] is not None and facts[f"{name}_equal_p"] < LEVEL:
                found.append(condition)
        levels = fit.arrays["diagnostics/part_level"]
        rows.append(
            {
                "condition": condition,
                "stiffness": cells["stiffness"],
                "stiffness_p": probability(facts["stiffness_equal_p"]),
                "level": cells["level"],
                "level_p": probability(facts["level_equal_p"]),
                "drift": number(float(np.ptp(levels)), 2),
            }
        )
    return {"rows": rows, "differing": differing, "drifting": drifting, "count": len(rows)}


def _plus_minus(value: float, half: float) -> str:
    """A value and the half width of its 95 % interval (any unit)."""
    text, around = by_uncertainty(value, value - half, value + half)
    if not around:
        return text
    decimals = len(text.partition(".")[2])
    return f"{text} ± {half:.{decimals}f}"


def probability(p: float | None) -> str:
    """A probability (-) as text with two decimals."""
    if p is None or math.isnan(p):
        return number(None)
    return "< 0.001" if p < 0.001 else f"{p:.3f}" if p < 0.01 else f"{p:.2f}"


def residuals_data(fits: dict[str, Result]) -> dict:
    """Residual of the held-out torque: size (N·m), slow share (%), memory (s), whiteness (-)."""
    rows, white, forgetful, slow = [], [], [], []
    for condition, fit in fits.items():
        facts = fit.facts["diagnostics"]
        r = facts["residual"]
        rows.append(
            {
                "condition": condition,
                "rms": number(r["rms_Nm"], 2),
                "torque": number(r["torque_rms_Nm"], 2),
                "below": percent(r["below_1_hz_percent"], 0),
                "offset": percent(r["offset_percent"], 0),
                "memory": number(r["memory_s"], 2),
                "p": probability(r["white_p"]),
            }
        )
        if r["white_p"] >= LEVEL:
            white.append(condition)
        if r["memory_s"] > facts["recording"]["block_s"]:
            forgetful.append(condition)
        if r["below_1_hz_percent"] > 50.0:
            slow.append(condition)
    recording = next(iter(fits.values())).facts["diagnostics"]["recording"]
    shares = [fit.facts["diagnostics"]["residual"]["below_1_hz_percent"] for fit in fits.values()]
    return {
        "rows": rows,
        "white": white,
        "longer_than_block": forgetful,
        "mostly_slow": len(slow) == len(rows),
        "below": " to ".join(dict.fromkeys(percent(x, 0) for x in (min(shares), max(shares)))),
        "block": f"{recording['block_s']:g}",
        "cutoff": f"{recording['cutoff_hz']:g}",
        "count": len(rows),
    }
