"""Directions in the files of a laboratory: forward, by the feet or by the belt, and places of the plates."""

import re
from collections.abc import Sequence

import numpy as np

from tepsipe.io.readers.recording import DIRECTIONS
from tepsipe.new_study.labels import plain
from tepsipe.new_study.treadmill_trials import Seen

TOES, HEELS = r"toe|fm\d|mt\d", r"hee|fcc|calc"
CARRIED_N = 50.0  # load of a belt that carries something
BOTH = 0.2  # load of the other belt, as a share, from which a foot stands on it
ALONG = 0.8  # least component of a foot along an axis of the file that it shows


def forward_of(trials: Sequence[Seen]) -> tuple[str, str]:
    """Direction in which a person or dummy faces, in the axes of the files, and why.

    The feet of the first trial with toes and heels show it, whatever the order of the trials is.

    trials: at least one trial of one file.
    """
    for seen in trials:
        foot = _foot(seen)
        if foot is None:
            continue
        axis = int(np.argmax(np.abs(foot)))
        if np.abs(foot[axis]) < ALONG:
            axis = seen.forward
        sign = "+" if foot[axis] >= 0.0 else "-"
        return f"{sign}{'xyz'[axis]}", f"toes are to that side of the heels, along {'xyz'[axis]}"
    seen = next((s for s in trials if s.positions is not None), trials[0])
    axis = "xyz"[seen.forward]
    if seen.up == "+y" and axis == "z":
        return "-z", "z is backward where y is upward, as in D-Flow"
    return f"+{axis}", f"the belt moves along {axis}; no file shows to which side it is forward"


def _foot(seen: Seen) -> np.ndarray | None:
    """Horizontal unit vector from the heels to the toes, shape (3,), or None."""
    ends = [_median(seen, pattern) for pattern in (TOES, HEELS)]
    if any(end is None for end in ends):
        return None
    foot = (ends[0] - ends[1]) * (1.0 - np.abs(DIRECTIONS[seen.up]))
    length = np.linalg.norm(foot)
    return foot / length if length > 0.0 else None


def _median(seen: Seen, pattern: str) -> np.ndarray | None:
    """Median position (m) of the markers whose labels have a pattern, or None."""
    columns = [k for k, m in enumerate(seen.markers) if re.search(pattern, plain(m), re.IGNORECASE)]
    if not columns or seen.positions is None:
        return None
    places = seen.positions[:, columns].reshape(-1, 3)
    places = places[np.isfinite(places).all(axis=1)]
    return np.median(places, axis=0) if len(places) else None


def plates_of_belts(trials: Sequence[Seen], forward: str) -> list[str]:
    """Numbers of the two plates with the largest loads from left to right, or of the only one, or none.

    forward: direction in the axes of the files.
    """
    loads: dict[str, float] = {}
    for seen in trials:
        for number, load in seen.loads_N.items():
            loads[number] = max(abs(load), loads.get(number, 0.0))
    chosen = sorted(sorted(loads, key=lambda n: -loads[n])[:2], key=int)
    places = [across(trials[0], number, forward) for number in chosen]
    if len(chosen) == 2 and None not in places and places[0] > places[1]:
        chosen.reverse()
    return chosen


def belts_of(trials: dict[str, Seen]) -> dict[str, str]:
    """Name of a trial -> the belt that carries it: left, right or both; empty if it is the same for all.

    trials: name -> trial of one file.
    """
    if not trials:
        return {}
    every = list(trials.values())
    plates = plates_of_belts(every, forward_of(every)[0])
    if len(plates) < 2:
        return {}
    belts = {}
    for name, seen in trials.items():
        loads = np.abs([seen.loads_N.get(number, 0.0) for number in plates])
        if loads.max() > CARRIED_N:
            both = loads.min() > BOTH * loads.max()
            belts[name] = "both" if both else ("left", "right")[int(np.argmax(loads))]
    return belts if len(set(belts.values())) > 1 or "both" in belts.values() else {}


def across(seen: Seen, number: str, forward: str) -> float | None:
    """Place of a force plate to the right (m), or None where the file does not give its corners."""
    centre = seen.plate_centres_m.get(number)
    return None if centre is None else float(np.cross(DIRECTIONS[forward], DIRECTIONS[seen.up]) @ centre)
