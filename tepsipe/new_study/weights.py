"""Weights on the treadmill: the trials of each, and conditions as those of the empty belt."""

import re

import numpy as np

from tepsipe.new_study.measures import pulses_of
from tepsipe.new_study.pairing import GENERIC, WORDS, Group
from tepsipe.new_study.plan import PLACEHOLDER, Missing, Plan
from tepsipe.new_study.treadmill_plan import belts_of
from tepsipe.new_study.treadmill_trials import Seen
from tepsipe.treadmill.options import FRAMES

GRAVITY_M_PER_S2 = 9.81
# models of a plate without the mean of the empty belt
FAMILY = (
    *("mass-spring-damper", "hnat2014", "output-error", "fir-causal", "fir", "spectral"),
    *("loaded-frame", *FRAMES),
)
SAME_MASS = 0.15  # largest relative difference of the loads of one weight
ALIKE = 0.1  # largest relative difference of the peaks of the same pulses
MASS = re.compile(r"(?<![\d.])\d+(\.\d+)?[ _-]?kg", re.IGNORECASE)
COUNTER = r"-\d{3,}$"  # that a recorder appends, another number for every file


def weights_of(groups: list[Group], seen: dict[str, Seen]) -> list[tuple[float, list[Group]]]:
    """Trials of each weight with the mass that the plates show (kg), the usual weight first.

    The usual weight has most trials; of several, it is the lightest.

    seen: name of the first file -> what it shows (SI units).
    """
    members = [g for g in groups if g.experiment == "weight"]
    shown = {g.first.name: abs(seen[g.first.name].load_N) / GRAVITY_M_PER_S2 for g in members}
    weights: list[tuple[float, list[Group]]] = []
    for group in sorted(members, key=lambda g: shown[g.first.name]):
        kg = shown[group.first.name]
        if weights and kg <= (1.0 + SAME_MASS) * weights[-1][0]:
            weights[-1][1].append(group)
        else:
            weights.append((kg, [group]))
    masses = [(float(np.mean([shown[g.first.name] for g in own])), own) for _, own in weights]
    return sorted(masses, key=lambda weight: (-len(weight[1]), weight[0]))


def without_calibration(groups: list[Group], seen: dict[str, Seen]) -> dict[str, str]:
    """Trials of weight and empty belt that cannot calibrate a treadmill: name of the first file -> why."""
    empty = [g for g in groups if g.experiment == "empty"]
    weights = weights_of(groups, seen)
    calibrations = (*empty, *(g for _, own in weights for g in own))
    if not calibrations:
        return {}
    if empty and weights and len(weights[0][1]) > 1:
        why = _on_another_belt(groups, seen)
        return {g.first.name: why for g in calibrations} if why else {}
    found = (
        f"{len(empty)} of the empty belt and {max((len(own) for _, own in weights), default=0)} of one weight"
    )
    why = (
        "models of the treadmill need a trial of the empty belt and two of one weight, to calibrate and to "
        f"validate, found {found}: record the others"
    )
    return {g.first.name: why for g in calibrations}


def _on_another_belt(groups: list[Group], seen: dict[str, Seen]) -> str:
    """Why the weights calibrate no belt that carries a person or dummy; empty if they do.

    Of several belts, `tepsipe check` states what one lacks.
    """
    belts = belts_of(groups, seen)
    used: dict[str, dict[str, str]] = {"weight": {}, "dummy": {}, "standing": {}}
    for group in groups:
        if group.experiment in used and group.first.name in belts:
            used[group.experiment][group.first.name] = belts[group.first.name]
    calibrated = set(used["weight"].values())
    carrying = used["dummy"] | used["standing"]
    if not calibrated or not carrying or calibrated & set(carrying.values()) or "both" in carrying.values():
        return ""
    name, belt = next(iter(carrying.items()))
    return (
        f"models of the treadmill are those of one belt, the weight was on the {calibrated.pop()} belt, and "
        f"{name} is on the {belt} one: record weight and empty belt there, too"
    )


def name_conditions(groups: list[Group], seen: dict[str, Seen]) -> None:
    """Give trials of weight and empty belt the names of their motion, the same for the same motion.

    Trials of further weights end with their mass. Names that are left empty, or would not be unique, stay.
    """
    weights = weights_of(groups, seen)
    ends = {g.first.name: f"-{kg:.0f}kg" for kg, own in weights[1:] for g in own}
    for experiment in ("weight", "empty"):
        members = [g for g in groups if g.experiment == experiment]
        motions = [motion_of(g.condition) for g in members]
        for known in ([re.sub(COUNTER, "", motion) for motion in motions], motions):
            names = [m + ends.get(g.first.name, "") for g, m in zip(members, known, strict=True)]
            if all(known) and len(set(names)) == len(names):
                for group, name in zip(members, names, strict=True):
                    group.condition = name
                break


def motion_of(condition: str) -> str:
    """Name of a trial without words for the weight and the empty belt, and without a mass."""
    words = {word for experiment in ("weight", "empty") for word in WORDS[experiment]}
    text = MASS.sub("", condition)
    for word in sorted(words, key=len, reverse=True):
        text = re.sub(rf"(?<![A-Za-z]){word}(?![A-Za-z])", "", text, flags=re.IGNORECASE)
    parts = [part for part in re.split(r"[-_ ]+", text) if part and part.lower() not in GENERIC]
    return "-".join(parts).strip("-.")


def plan_weights(plan: Plan, groups: list[Group], seen: dict[str, Seen]) -> None:
    """Settings of the weights: masses, heights, and models that the trials can calibrate."""
    (kg, usual), *further = weights_of(groups, seen)
    names = ", ".join(g.condition for g in usual)
    plan.ask(
        "weight.weight.mass_kg",
        "mass of the weight (kg)",
        "weigh it",
        f"the plate shows {kg:.1f} kg: {names}",
    )
    plan.ask(
        "weight.weight.com_height_m", "height of its centre of mass above the belt (m)", "measure it to 1 mm"
    )
    plan.assume(
        "weight.weight.com_forward_of_markers_m",
        None,
        "the place of the plate's origin is then not checked, which can be most of the uncertainty of K",
        "distance of its centre of mass forward of the mean of its markers (m), to 1 mm",
    )
    if further:
        keys = {"mass_kg": PLACEHOLDER, "com_height_m": PLACEHOLDER, "com_forward_of_markers_m": None}
        items = [
            (keys, f"the plate shows {kg:.1f} kg: {', '.join(g.condition for g in own)}")
            for kg, own in further
        ]
        plan.put("weight.further_weights", items, "name their masses in mass_kg of the trial sheet, too")
        how = "weigh and measure them; the same masses stand in the column mass_kg of their trials"
        plan.missing.append(
            Missing("weight.further_weights", "mass (kg) and height (m) of each further weight", how)
        )
    unlike = _unlike(groups, usual, seen)
    if unlike:
        how = "record the empty belt with the motion of the weight"
        plan.assume("weight.models.family", list(FAMILY), f"no mean-subtraction: {unlike}", how)


def _unlike(groups: list[Group], usual: list[Group], seen: dict[str, Seen]) -> str:
    """Why the mean of the empty belt cannot be subtracted from trials of the weight; empty if it can."""
    empty = {g.condition: g for g in groups if g.experiment == "empty"}
    for group in usual:
        other = empty.get(group.condition)
        if other is None:
            return f"no empty belt moves as in weight/{group.condition}"
        peaks = [_peak(seen[g.first.name]) for g in (group, other)]
        if None not in peaks and abs(peaks[0] - peaks[1]) > ALIKE * abs(peaks[0]):
            speeds = f"{peaks[1]:.2g} m/s, not {peaks[0]:.2g} m/s as with the weight"
            return f"in {group.condition} the empty belt moves at {speeds}"
    return ""


def _peak(seen: Seen) -> float | None:
    """Peak of the belt's velocity with its sign (m/s), or None."""
    if seen.velocity is None or pulses_of(seen.velocity, seen.velocity_rate_hz) is None:
        return None
    centred = seen.velocity - np.nanmedian(seen.velocity)
    return float(centred[np.nanargmax(np.abs(centred))])
