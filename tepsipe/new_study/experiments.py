"""Experiment of each trial, by names and content, or why a recording can be no trial."""

from collections import Counter
from collections.abc import Callable

from tepsipe.errors import InputError
from tepsipe.experiments.walking.analysis import FEWEST_UNPERTURBED, FEWEST_WITHOUT_PULSES
from tepsipe.experiments.walking.options import WalkingOptions
from tepsipe.ingest.dflow import read_dflow_files
from tepsipe.new_study.files import Found, events_of
from tepsipe.new_study.measures import pulses_of
from tepsipe.new_study.pairing import Group, experiment_by_name
from tepsipe.new_study.sheet import describe_pulses
from tepsipe.new_study.table_plan import refuse_units
from tepsipe.new_study.treadmill_plan import experiment_of
from tepsipe.new_study.treadmill_trials import Seen, seen_in, share_belt, share_labels

FEWEST_PULSES = {"standing": 4}  # of the shipped configuration; elsewhere two, for the scatter
OF_TABLES = {
    "manipulator log": "wristalyzer",
    "position table": "position_manipulator",
    "belt table": "belt",
    "platform table": "platform",
}


def find_experiments(
    groups: list[Group], unused: list[Found], folder: str, tell: Callable[[str], object] = str
) -> dict[str, Seen]:
    """Give every group its experiment; groups that can be no trial are moved to ``unused``, with the reason.

    unused: files that belong to no trial, to which files are added.
    folder: name of the folder of recordings.
    tell: takes how far it is.
    Returns: name of the first file -> what a treadmill trial shows (SI units).
    """
    seen: dict[str, Seen] = {}

    def attempt(step, *arguments) -> None:
        count = len(groups)
        for number, group in enumerate(list(groups), start=1):
            tell(f", trial {number} of {count}")
            try:
                step(group, *arguments)
            except InputError as error:
                groups.remove(group)
                why = str(error).removeprefix(f"{group.first.path}: ")
                unused.append(Found(group.first.path, group.first.name, "other", None, None, {}, why))

    attempt(_find, seen, folder)
    share_belt(list(seen.values()))
    share_labels(list(seen.values()))
    attempt(_refuse_unusable, seen)
    attempt(_refuse_unaligned, seen)
    return seen


def _find(group: Group, seen: dict[str, Seen], folder: str) -> None:
    """Set the experiment of a group, and what is seen in it."""
    first = group.first
    if "events" in group.partners:
        group.experiment = "walking"
        if first.contents.markers:
            seen[first.name] = seen_in(group)
        return
    if first.kind in OF_TABLES:
        group.experiment = OF_TABLES[first.kind]
        refuse_units(group)
        return
    seen[first.name] = contents = seen_in(group)
    named = experiment_by_name(f"{folder}/{first.name}")
    if first.kind == "whole trial" and _is_walk(group, contents, named):
        group.experiment = "walking"
        return
    group.experiment = experiment_of(group, contents, named)


def _is_walk(group: Group, contents: Seen, named: str | None) -> bool:
    """Test for walking, by the events of the file, else by names, else by steps on the plates."""
    counts = Counter(label for label, _ in group.first.contents.events)
    kinds = events_of(list(counts))
    if kinds:
        strides, why = counts[kinds["heel_strike"]] - 1, f"events {', '.join(kinds.values())}"
        group.partners["events"] = group.first
    elif named == "walking" or (named is None and contents.contacts):
        strides, why = contents.contacts - 1, "name" if named else "steps on the plates"
    else:
        return False
    fewest = FEWEST_UNPERTURBED
    if "pulse" not in kinds:  # half of the strides are compared with the others, some at every phase
        fewest = 2 * FEWEST_WITHOUT_PULSES * len(WalkingOptions().phases_percent)
    if strides < fewest:
        raise InputError(
            f"expected at least {fewest} whole strides on the same plates of a person who walks "
            f"(by the {why}), found {max(strides, 0)}: record a longer walk, or a person who stands on them"
        )
    group.notes.append(f"taken for walking by its {why}")
    return True


def _refuse_unusable(group: Group, seen: dict[str, Seen]) -> None:
    """Note the pulses of a trial on the treadmill, and refuse one without markers or pulses."""
    contents = seen.get(group.first.name)
    if contents is None or group.experiment == "walking":
        return
    taken, whole = f"taken for {group.experiment}", group.first.kind == "whole trial"
    pulses = None
    if contents.velocity is not None:
        pulses = pulses_of(contents.velocity, contents.velocity_rate_hz)
    if pulses is None and (contents.velocity is not None or (whole and group.experiment != "empty")):
        # without the velocity: of an empty belt, nothing may show which channel holds it
        places = "channels, and it holds no markers" if contents.positions is None else "channels or markers"
        raise InputError(
            f"{taken}, but no pulses of the belt with rests between them are in its {places}: "
            "impedance needs a perturbation, as neither quiet standing nor a constant motion has"
        )
    if whole and group.experiment != "empty" and contents.positions is None:
        raise InputError(f"{taken}, but it holds no markers: export the file with its points")
    least = FEWEST_PULSES.get(group.experiment, 2)
    if pulses is not None and pulses.count < least:
        raise InputError(
            f"{taken}, expected at least {least} pulses of the belt, found {pulses.count} in "
            f"{contents.duration_s:.3g} s: repeat a trial that was aborted"
        )
    if pulses is not None:
        group.notes.append(describe_pulses(contents))


def _refuse_unaligned(group: Group, seen: dict[str, Seen]) -> None:
    """Refuse a file of D-Flow's record module that cannot be brought to the clock of its mocap file."""
    if "record" in group.partners and group.experiment != "walking":
        labels = tuple(seen[group.first.name].belt_fixed[:3])
        read_dflow_files(group.first.path, group.partners["record"].path, labels)
