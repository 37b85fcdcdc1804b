"""Labels of markers and of electromyograms: the leg, the segment and the muscle that they name."""

import re
from collections.abc import Iterable

SIDES = {"left": {"l", "left", "li", "links"}, "right": {"r", "right", "re", "rechts"}}
# segment of the leg -> how the label of a marker on it looks; plug-in-gait has KNE on the thigh, TIB, ANK
SEGMENTS = {
    "ankle": r"(?<!sh)ank|mal|\bfal\b|\btam\b",
    "foot": r"toe|hee|foot|fcc|fm\d|mt\d|meta",
    "shank": r"sha|shn|tib|tti|ttc|\bfax\b|calf|lower",
    "thigh": r"thi|fem|upper|kne|\bf[lm]e\b|\bftc\b",
}
KNEE = r"kne|\bfle\b"
# what an export of Delsys calls a channel of a sensor, after the sensor's name and a colon
CHANNEL = r"\s*emg[\s.]*[a-z]?\s*\d*\s*"
# muscle -> how its channel is called; the first channel that fits is taken
MUSCLES = {
    "TA": r"\b[lr]?TA\b|tib\w* *ant|\b[lr]?tib",
    "SOL": r"sol",
    "GAS": r"gas|\b[lr]?(m[gm]|gm|gl|lg)\b",
    "BF": r"\b[lr]?BF\b|bic\w* *fem|ham|\b[lr]?bic",
    "RF": r"\b[lr]?RF\b|rect|\b[lr]?rec\b",
}


def plain(label: str) -> str:
    """A label without the subject's name or the channel of a sensor, its parts separated by spaces."""
    return " ".join(_parts(label))


def _parts(label: str) -> list[str]:
    before, _, after = label.rpartition(":")
    return re.findall(r"[^\W_]+", before if before and re.fullmatch(CHANNEL, after, re.I) else after)


def muscle_of(label: str) -> str | None:
    """Muscle that the label of a channel names, or None."""
    text = plain(label)
    return next((m for m, pattern in MUSCLES.items() if re.search(pattern, text, re.IGNORECASE)), None)


def is_on(segment: str, label: str) -> bool:
    """Test for a marker on a segment of the leg, or on the ankle, by its label."""
    return bool(re.search(SEGMENTS[segment], plain(label), re.IGNORECASE))


def side_of(label: str) -> str:
    """Leg of a marker or an electrode, ``left`` or ``right``, by its label; empty if it does not show."""
    parts = _parts(label)
    for side, words in SIDES.items():
        if any(part.lower() in words for part in parts):
            return side
    sided = next((part for part in parts if re.match(r"[RL][A-Z]", part)), None)
    if sided is None:
        return ""
    rest = sided[1:]
    known = any(is_on(segment, rest) for segment in SEGMENTS) or muscle_of(rest) is not None
    return {"R": "right", "L": "left"}[sided[0]] if known else ""


def leg_of(emg: Iterable[str], markers: Iterable[str]) -> tuple[str, str]:
    """The leg to look at, and why: the only one of the muscles, else of the markers, else the right one."""
    for labels, what in ((emg, "electromyograms"), (markers, "markers")):
        sides = {side_of(label) for label in labels} - {""}
        if len(sides) == 1:
            return sides.pop(), f"the only leg of the {what}"
    return "right", "both legs are recorded, or none is named"


def of_leg(labels: Iterable[str], leg: str) -> list[str]:
    """Labels of one leg; all of them if none names a leg."""
    labels = list(labels)
    own = [label for label in labels if side_of(label) == leg]
    return own or [label for label in labels if not side_of(label)] or labels


def muscles_of(labels: list[str], leg: str = "right") -> tuple[dict[str, str], list[str]]:
    """Muscle -> label of its channel, of one leg if there is one, and the other labels."""
    own = of_leg(labels, leg)
    ordered = [*own, *(label for label in labels if label not in own)]
    by_muscle: dict[str, str] = {}
    for muscle, pattern in MUSCLES.items():
        free = (label for label in ordered if label not in by_muscle.values())
        label = next((n for n in free if re.search(pattern, plain(n), re.IGNORECASE)), None)
        if label is not None:
            by_muscle[muscle] = label
    return by_muscle, [label for label in labels if label not in by_muscle.values()]
