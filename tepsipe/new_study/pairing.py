"""Grouping of files into trials, and the experiment of each trial."""

import re
import unicodedata
from dataclasses import dataclass, field
from difflib import SequenceMatcher
from functools import cache
from pathlib import PurePosixPath

import numpy as np

from tepsipe.io.formats import formats
from tepsipe.io.names import usable_name
from tepsipe.new_study.files import FIRST, Found, samples

# words of a file's name that say what the file holds, not which trial it is of
GENERIC = {
    "log", "markers", "marker", "emg", "trial", "recording", "mocap", "record", "command", "cmd",
    "calibration", "matrix", "forces", "force", "treadmill", "data", "export", "delsys", "event", "events",
    "c3d", "mat", "txt",
}  # fmt: skip
# words in the names of folders and files -> experiment
WORDS = {
    "empty": ("empty", "unloaded", "leer", "noload"),
    "weight": ("weight", "mass", "gewicht", "weights"),
    "dummy": ("dummy", "rig", "phantom"),
    "walking": ("walking", "walk", "gait", "gang", "gehen"),
    "standing": (
        "standing",
        "stand",
        "person",
        "subject",
        "participant",
        "relax",
        "relaxed",
        "stiff",
        "tense",
    ),
}
# the number that a recorder appends to a word for the kind of file
NUMBERED = r"(?<![A-Za-z0-9])(mocap|record|treadmill|markers|log|emg)(?=\d)"
LONGEST_DIFFERENCE_S = 3.0
LEAST_ALIKE = 0.6


@dataclass
class Group:
    """The files of one trial."""

    condition: str
    first: Found
    """The file that the trial is made of: its log or table (s, units of the file)."""
    partners: dict[str, Found] = field(default_factory=dict)
    """Kind of file -> the other files."""
    experiment: str = ""
    """Experiment that the trial is taken for; empty until it is known."""
    notes: list[str] = field(default_factory=list)
    """What was guessed, for the comment beside its row."""


def group_files(files: list[Found]) -> tuple[list[Group], list[Found]]:
    """Put files of one trial together, by name and length.

    Returns:
        groups: one per trial.
        left: files that belong to no trial.
    """
    firsts = [f for f in files if f.kind in FIRST]
    groups = [Group(key_of(f.name), f) for f in firsts]
    used: set[str] = set()
    for sure in (True, False):  # files of the same name first, so that no other trial takes them
        for group in groups:
            for kind in _wanted(group.first):
                if kind in group.partners:
                    continue
                shared = kind == "calibration"
                candidates = [f for f in files if f.kind == kind and (shared or f.name not in used)]
                partner = _partner(group.first, candidates, len(firsts), sure)
                if partner is None and kind == "command" and not sure:
                    partner = _shared_command(group.first, [f for f in files if f.kind == kind])
                if partner is None:
                    continue
                group.partners[kind] = partner
                used.add(partner.name)
                if not sure and not shared:
                    group.notes.append(f"{partner.name} taken as its {kind} file by name and length")
    unused = [f for f in files if f.kind not in FIRST and f.name not in used]
    return groups, unused


def _wanted(first: Found) -> tuple[str, ...]:
    """Kinds of the files that belong to a trial, by its first file."""
    if first.kind == "whole trial":
        return (*first.format.lacks, "emg", "events")
    kinds = {
        "treadmill log": ("calibration", "markers", "emg"),
        "manipulator log": ("command",),
        "position table": ("events",),
    }
    return kinds.get(first.kind, ())


def key_of(name: str) -> str:
    """Name of the trial in a file's name, without words such as log; else that of its folder.

    name: path of the file below the folder of recordings, with slashes.
    """
    path = PurePosixPath(name)
    for part in (path.name.partition(".c3d")[0], *reversed(path.parts[:-1])):
        stem = re.sub(_endings(), "", part, flags=re.IGNORECASE)
        stem = re.sub(NUMBERED, "", stem, flags=re.IGNORECASE)
        words = [w for w in re.split(r"[_\s]+", stem) if w and w.lower() not in GENERIC]
        key = _spelled("-".join(words)).strip("-.")
        if key and key.lower() not in GENERIC:
            return key
    return "trial"


@cache
def _endings() -> str:
    """Pattern of the endings of recordings."""
    endings = {ending for known in formats() if known.purpose for ending in known.endings}
    return rf"({'|'.join(map(re.escape, sorted(endings | {'.gz'})))})\b"


def _spelled(text: str) -> str:
    """Text with the characters that names in a study may have: letters without accents, digits, dots."""
    plain = unicodedata.normalize("NFKD", text.replace("ß", "ss"))
    return re.sub(r"[^A-Za-z0-9.-]+", "-", "".join(c for c in plain if not unicodedata.combining(c)))


def _partner(first: Found, candidates: list[Found], trials: int, sure: bool) -> Found | None:
    """The file that fits a trial best, by name, folder and length (s); if ``sure``, one of its name only."""
    folder, key = PurePosixPath(first.name).parent, key_of(first.name)
    if sure:
        same = [f for f in candidates if key_of(f.name) == key and PurePosixPath(f.name).parent == folder]
        return same[0] if same else None
    best, most = None, 0.0
    for f in candidates:
        near = PurePosixPath(f.name).parent == folder
        alike = SequenceMatcher(None, key_of(f.name).lower(), key.lower()).ratio()
        if f.kind == "calibration":
            score = near + 0.1
        elif _length_fits(first, f):
            alone = len(candidates) == 1 and trials == 1
            score = 3.0 * (key_of(f.name) == key) + near * alike * (alike >= LEAST_ALIKE) + alone
        else:
            score = 0.0
        if score > most:
            best, most = f, score
    return best


def _shared_command(log: Found, commands: list[Found]) -> Found | None:
    """The only command that lasts as long as a log after its trigger; trials with one command share it."""
    length = after_trigger(log)
    fitting = [f for f in commands if abs((f.duration_s or 0.0) - length) <= LONGEST_DIFFERENCE_S]
    return fitting[0] if len(fitting) == 1 else None


def after_trigger(log: Found) -> float:
    """Length of a manipulator's log from the trigger on (s)."""
    trigger, time = (samples(log.channel(log.columns[role])) for role in ("trigger", "time"))
    return float(time[-1] - trigger.max()) if trigger.max() > 0.0 else float(np.ptp(time))


def _length_fits(first: Found, other: Found) -> bool:
    """Test for two files of one trial: lengths (s) within `LONGEST_DIFFERENCE_S` or a tenth."""
    if first.duration_s is None or other.duration_s is None:
        return True
    longest = max(LONGEST_DIFFERENCE_S, 0.1 * first.duration_s)
    return abs(first.duration_s - other.duration_s) <= longest


def name_apart(groups: list[Group]) -> None:
    """Give trials of one experiment with the same name the names of their folders, else numbers."""
    for group in groups:
        twins = [g for g in groups if (g.experiment, g.condition) == (group.experiment, group.condition)]
        if len(twins) == 1:
            continue
        for g, part in zip(twins, _folders(twins), strict=True):
            g.condition = _spelled(f"{part}-{g.condition}").lstrip("-.")
    taken: dict[str, set[str]] = {}
    for group in groups:  # as the run asks for: they become names of files on every computer
        names = taken.setdefault(group.experiment, set())
        name, number = usable_name(group.condition), 1
        group.condition = name
        while group.condition.casefold() in names:
            number += 1
            group.condition = f"{name}-{number}"
        names.add(group.condition.casefold())


def _folders(twins: list[Group]) -> list[str]:
    """Names that tell trials apart: of the folders of their files, as few as suffice, else numbers."""
    parents = [PurePosixPath(g.first.name).parent.parts for g in twins]
    for depth in range(1, max(map(len, parents)) + 1):
        names = ["-".join(parts[-depth:]) for parts in parents]
        if len({_spelled(name) for name in names}) == len(twins) and all(names):
            return names
    return [str(number) for number in range(1, len(twins) + 1)]


def experiment_by_name(name: str) -> str | None:
    """Experiment named by a file or its folders, or None."""
    words = re.split(r"[^a-z]+", name.lower())
    for part in reversed(words):
        for experiment, known in WORDS.items():
            if part in known:
                return experiment
    return None
