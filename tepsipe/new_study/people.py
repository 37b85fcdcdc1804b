"""Participants of a study, by the names of files and folders."""

import re

from tepsipe.new_study.pairing import Group
from tepsipe.new_study.settings import PLACEHOLDER, Missing, Plan
from tepsipe.new_study.treadmill_trials import Seen

TABLE = "participants.tsv"
NAME = re.compile(
    r"(?<![A-Za-z0-9])((?:participant|subject|subj|sub|pat|proband|VP|HC|P|S)[-_ ]?\d{1,4})(?!\d)",
    re.IGNORECASE,
)
OF_PEOPLE = ("standing", "position_manipulator", "platform")
NUMBERS = {
    "mass_kg": "mass (kg)",
    "stature_m": "stature (m)",
    "com_height": "height of the centre of mass as a fraction of the stature (–)",
    "ankle_height_m": "height of the outer ankle bone above the sole (m)",
    "foot_com_m": "anterior offset of the feet's centre of mass from the ankle (m)",
}


def participants_of(groups: list[Group]) -> dict[str, str]:
    """Participant of each trial by its files' names, if all trials of an experiment name one of several.

    Returns: name of the trial's first file -> participant; without experiments of one person.
    """
    participants: dict[str, str] = {}
    for experiment in OF_PEOPLE:
        members = [g for g in groups if g.experiment == experiment]
        matches = {g.first.name: NAME.search(g.first.name) for g in members}
        if not members or not all(matches.values()):
            continue
        names = {file: re.sub(r"[^A-Za-z0-9]", "", match[1]) for file, match in matches.items()}
        if len(set(names.values())) > 1:
            participants |= names
    return participants


def plan_people(plan: Plan, groups: list[Group], people: dict[str, str], seen: dict[str, Seen]) -> str:
    """Table of the participants of a standing study as text, empty if there are none.

    Their numbers, with the units in its header, are asked for in the table instead of the configuration.

    people: as `participants_of` returns it.
    seen: name of the first file -> what a treadmill trial shows (SI units).
    """
    standing = [g for g in groups if g.experiment == "standing" and g.first.name in people]
    if not standing:
        return ""
    for number in NUMBERS:
        plan.tree["standing"]["person"].pop(number, None)
    plan.missing = [m for m in plan.missing if m.where not in {f"standing.person.{n}" for n in NUMBERS}]
    names = list(dict.fromkeys(people[g.first.name] for g in standing))
    for name in names:
        loads = [seen[g.first.name].load_N for g in standing if people[g.first.name] == name]
        plan.missing.append(
            Missing(
                f"{TABLE}, {name}",
                ", ".join(NUMBERS.values()),
                f"the plates show {max(map(abs, loads)) / 9.81:.1f} kg; "
                "com_height is 0.55 for women, 0.56 for men",
            )
        )
    plan.check.append(
        Missing(
            "standing.person",
            "places of markers are asked for once, as if they were the same for all participants",
            "those of others below standing.participants, for example {P01: {shank_markers: [...]}}",
        )
    )
    rows = [["participant", *NUMBERS], *([name, *[PLACEHOLDER] * len(NUMBERS)] for name in names)]
    return "".join("\t".join(row) + "\n" for row in rows)
