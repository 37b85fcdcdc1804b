"""Recordings of a folder that need studies of their own: walking, and files of another laboratory."""

from dataclasses import dataclass

import numpy as np

from tepsipe.new_study.pairing import Group
from tepsipe.new_study.treadmill_trials import Seen

NEAR_M = 0.1  # largest distance of the centres of the same plate in two files


@dataclass(frozen=True)
class _Layout:
    """Kind, vertical axis, frame rate (Hz) and centres of the plates (m) of a file with a whole trial."""

    kind: str
    up: str
    rate_hz: float | None
    centres_m: dict[str, np.ndarray]

    def fits(self, other: "_Layout") -> bool:
        """Test for files that one configuration can describe."""
        rates = {round(rate, 3) for rate in (self.rate_hz, other.rate_hz) if rate}
        return (
            (self.kind, self.up) == (other.kind, other.up)
            and len(rates) < 2
            and self.centres_m.keys() == other.centres_m.keys()
            and all(np.linalg.norm(x - other.centres_m[n]) < NEAR_M for n, x in self.centres_m.items())
        )


def parts_of(groups: list[Group], seen: dict[str, Seen]) -> dict[str, list[Group]]:
    """Trials by study: end of its name -> its trials; the largest part without walking has no end.

    Axes, plates and frame rates are those of one laboratory per study, and walking has a report of its own.

    seen: name of the first file -> what it shows (SI units).
    """
    parts: dict[str, list[Group]] = {}
    for end, own in (
        ("", [g for g in groups if g.experiment != "walking"]),
        ("walking", [g for g in groups if g.experiment == "walking"]),
    ):
        for number, part in enumerate(_by_layout(own, seen), start=1):
            parts["-".join(filter(None, (end, str(number) if number > 1 else "")))] = part
    return parts if "" in parts or len(parts) != 1 else {"": next(iter(parts.values()))}


def _by_layout(groups: list[Group], seen: dict[str, Seen]) -> list[list[Group]]:
    """Trials by the layout of their files, most of them first; those without a layout are with the first."""
    found: list[tuple[_Layout, list[Group]]] = []
    others = []
    of_cameras = sorted(groups, key=lambda g: _rate_of(g, seen) is None)  # without frames they fit several
    for group in of_cameras:
        contents = seen.get(group.first.name)
        if contents is None or group.first.kind != "whole trial":
            others.append(group)
            continue
        layout = _Layout(
            group.first.contents.kind, contents.up, contents.frame_rate_hz, contents.plate_centres_m
        )
        part = next((own for known, own in found if known.fits(layout)), None)
        if part is None:
            found.append((layout, [group]))
        else:
            part.append(group)
    parts = sorted((own for _, own in found), key=len, reverse=True)
    if others:
        parts = [[*parts[0], *others] if parts else others, *parts[1:]]
    return parts


def _rate_of(group: Group, seen: dict[str, Seen]) -> float | None:
    contents = seen.get(group.first.name)
    return None if contents is None else contents.frame_rate_hz
