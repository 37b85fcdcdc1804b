"""Contents of the files of one treadmill trial: markers, belt velocity, loads, muscles, by their labels."""

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.io.file_format import Channel
from tepsipe.io.readers.recording import DIRECTIONS, Markers, Recording
from tepsipe.io.readers.recording import Channel as Samples
from tepsipe.new_study.files import Found, samples
from tepsipe.new_study.measures import (
    FOLLOWS,
    at_frames,
    follows,
    is_two_levels,
    moves_with,
    pulses_of,
    scale_of,
    smooth_velocity,
)
from tepsipe.new_study.pairing import Group

TRIGGER_V = 2.5
VELOCITY_NAMES = re.compile(r"belt|speed|veloc|v_b|geschw|band", re.IGNORECASE)
TRIGGER_NAMES = re.compile(r"trig|sync|start", re.IGNORECASE)
SPEEDS = {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "km/h": 1.0 / 3.6}
AGREES = 0.05  # largest relative difference between a scale by the unit and by the markers
# points that models of the software compute
COMPUTED = r"Angles?$|Forces?$|Moments?$|Powers?$|CentreOfMass(Floor)?$|^\*"
COMMAND_NAMES = re.compile(r"command|cmd|set ?point|target|soll", re.IGNORECASE)
LOADED_N = 20.0  # vertical force from which a plate is loaded
LEAST_LOADED = 0.02  # share of the time from which its load counts
STEP_N, LEAST_IN_AIR = 250.0, 0.1  # peak of the force below a foot, share of the time without the foot
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


@dataclass(frozen=True)
class BeltChannel:
    """A channel that holds the velocity of the belt."""

    name: str
    unit: str
    m_per_s_per_unit: float
    offset: float
    """Velocity per unit (m/s), and value at rest (unit)."""
    correlation: float
    """With the velocity of the marker that follows it best; NaN without markers."""


@dataclass
class Seen:
    """Contents of a trial's files."""

    markers: tuple[str, ...] = ()
    """Labels in the order of the file."""
    positions: Annotated[np.ndarray, "(frames, markers, 3)", "m"] | None = None
    """Positions in the axes of the file."""
    frame_rate_hz: float | None = None
    longest_gap_s: dict[str, float] = field(default_factory=dict)
    """Marker -> longest time for which it is hidden."""
    maker: str = ""
    """Maker of the motion capture system as the file names it."""
    duration_s: float = 0.0
    """Length of the trial."""
    loads_N: dict[str, float] = field(default_factory=dict)
    """Belt (``left``, ``right``), or number of the force plate, -> mean vertical force while loaded."""
    load_N: float = 0.0
    """Mean vertical force on all of them together while they are loaded."""
    contacts: int = 0
    """Steps of a person on one plate, as in walking; 0 for a plate that stays loaded."""
    plate_centres_m: dict[str, np.ndarray] = field(default_factory=dict)
    """Number of the force plate -> centre of its corners in the axes of the file (m), shape (3,)."""
    velocity: np.ndarray | None = None
    velocity_rate_hz: float | None = None
    """Velocity of the belt from the trial's start on (m/s), and its rate (Hz)."""
    belt: BeltChannel | None = None
    """Channel of the velocity in a whole trial."""
    followed: dict[str, BeltChannel] = field(default_factory=dict)
    """All channels of a whole trial that a low marker follows."""
    triggers: list[str] = field(default_factory=list)
    commands: list[str] = field(default_factory=list)
    emg: list[str] = field(default_factory=list)
    """Names of likely channels of a whole trial or of a file of electromyograms."""
    emg_rate_hz: float | None = None
    """Lowest rate of the electromyograms."""
    emg_trigger: tuple[str, float] | None = None
    """Label and threshold of the trigger in the file of electromyograms."""
    belt_fixed: list[str] = field(default_factory=list)
    """Markers that follow the pulses of the belt."""
    free: dict[str, Samples] = field(default_factory=dict)
    """Channels that may hold the velocity, of a whole trial in which nothing shows which one does."""
    forward: int = 1
    """Axis of the file along which the belt moves: 0 for x."""
    up: str = "+z"
    """Upward direction in the axes of the file, for example ``+z``."""

    @property
    def up_axis(self) -> int:
        """Vertical axis of the file: 0 for x."""
        return "xyz".index(self.up[1])

    @property
    def heights_m(self) -> np.ndarray:
        """Heights of the markers (m), shape (frames, markers)."""
        return self.positions @ DIRECTIONS[self.up]


def seen_in(group: Group) -> Seen:
    """Look into the files of a treadmill trial."""
    seen = Seen(duration_s=group.first.duration_s or 0.0)
    if group.first.kind == "whole trial":
        _see_recording(seen, group)
    else:
        _see_log(seen, group)
    emg = group.partners.get("emg")
    if emg is not None:
        _see_emg(seen, emg)
    moves = seen.velocity is not None and pulses_of(seen.velocity, seen.velocity_rate_hz) is not None
    if seen.positions is not None and moves:
        seen.belt_fixed = _followers(seen)
    return seen


def _see_markers(seen: Seen, markers: Markers | None, maker: str) -> None:
    """Markers that are visible at all, in the order of the file."""
    if markers is None:
        return
    present = np.isfinite(markers.positions).any(axis=(0, 2))
    if not present.any():
        return
    seen.markers = tuple(m for m, visible in zip(markers.labels, present, strict=True) if visible)
    seen.positions, seen.frame_rate_hz, seen.maker = markers.positions[:, present], markers.rate_hz, maker
    for k, label in enumerate(seen.markers):
        gap = Channel.of(label, "m", None, seen.positions[:, k]).longest_gap
        seen.longest_gap_s[label] = max(seen.longest_gap_s.get(label, 0.0), gap / markers.rate_hz)
    seen.forward = _moving_axis(seen)


def _see_log(seen: Seen, group: Group) -> None:
    """Log in volts, calibration matrix, markers in a file of their own."""
    from tepsipe.io.readers.treadmill_log import read_calibration_matrix, read_treadmill_log

    log = read_treadmill_log(group.first.path)
    high = np.flatnonzero(log.trigger >= TRIGGER_V)
    start, stop = (int(high[0]), int(high[-1]) + 1) if high.size else (0, log.trigger.size)
    seen.velocity, seen.velocity_rate_hz = log.belt_velocity[start:stop], log.rate_hz
    seen.duration_s = (stop - start) / log.rate_hz
    if "calibration" in group.partners:
        try:
            matrix = read_calibration_matrix(group.partners["calibration"].path)
            mean = log.voltages[start:stop].mean(axis=0)
            for belt in ("left", "right"):
                seen.loads_N[belt] = float(matrix.row(f"Fz_{belt}") @ mean)
            seen.load_N = sum(seen.loads_N.values())
        except (InputError, ValueError) as error:
            group.notes.append(f"calibration matrix not applied: {error}")
    if "markers" in group.partners:
        file = group.partners["markers"]
        markers, maker = markers_in(file)
        _see_markers(seen, markers, maker)
        seen.duration_s = min(seen.duration_s, markers.positions.shape[0] / markers.rate_hz)


def _see_recording(seen: Seen, group: Group) -> None:
    """Markers, plates and channels of one file, or of a table and a file of markers."""
    from tepsipe.io.formats import read_recording

    file = group.first
    recording = read_recording(file.path)
    seen.up = recording.up
    _see_markers(seen, _positions(recording.markers, file), file.contents.facts.get("made by", ""))
    if "markers" in group.partners:
        _see_markers(seen, *markers_in(group.partners["markers"]))
    _see_loads(seen, recording)
    lengths = [p.force.shape[0] / p.rate_hz for p in recording.plates]
    lengths += [] if seen.positions is None else [seen.positions.shape[0] / seen.frame_rate_hz]
    seen.duration_s = min(lengths, default=seen.duration_s)
    of_plates = set(_plate_channels(recording))
    free = {name: c for name, c in recording.channels.items() if name not in of_plates}
    seen.triggers = [n for n, c in free.items() if TRIGGER_NAMES.search(n) and is_two_levels(c.values)]
    seen.emg = [n for n in free if muscle_of(n) or "emg" in n.lower()]
    seen.emg_rate_hz = min((free[n].rate_hz for n in seen.emg), default=None)
    rest = {n: c for n, c in free.items() if n not in {*seen.triggers, *seen.emg}}
    seen.commands = [n for n in rest if COMMAND_NAMES.search(n)]
    seen.belt = _belt_channel(seen, {n: c for n, c in rest.items() if n not in seen.commands})
    if "record" in group.partners:
        _see_record(seen, group.partners["record"])
    elif seen.belt is not None:
        _take_velocity(seen, seen.belt, recording.channels[seen.belt.name])
    if seen.velocity is None and seen.positions is None:
        seen.free = rest
    if seen.velocity is None and seen.positions is not None:
        lowest = _lowest(seen)[0]
        seen.velocity = smooth_velocity(seen.positions[:, lowest, seen.forward], seen.frame_rate_hz)
        seen.velocity_rate_hz = seen.frame_rate_hz


def _take_velocity(seen: Seen, belt: BeltChannel, channel: Samples) -> None:
    """Velocity of the belt by one of its channels (m/s)."""
    seen.belt, seen.velocity_rate_hz = belt, channel.rate_hz
    seen.velocity = belt.m_per_s_per_unit * (channel.values - belt.offset)


def share_belt(trials: list[Seen]) -> None:
    """Take one channel of the belt for all trials in which markers follow it, and for those without markers.

    Where each belt has a channel of its own, the one that moves most is taken in a trial without markers.
    """
    counts = Counter(name for s in trials for name in s.followed)
    known = {s.belt.name: s.belt for s in trials if s.belt is not None}
    for seen in trials:
        if seen.belt is not None and seen.belt.name in seen.followed:
            commonest = max(seen.followed, key=lambda name: counts[name])
            if counts[commonest] > counts[seen.belt.name]:
                seen.belt = seen.followed[commonest]
        free = {name: known[name] for name in known if name in seen.free}
        if seen.velocity is None and free:
            moved = {n: abs(b.m_per_s_per_unit) * np.ptp(seen.free[n].values) for n, b in free.items()}
            name = max(moved, key=moved.get)
            _take_velocity(seen, free[name], seen.free[name])
        seen.free = {}


def share_labels(trials: list[Seen]) -> None:
    """Leave out the subject's name before a colon in labels of markers, if trials have several subjects."""
    subjects = {label.rpartition(":")[0] for s in trials for label in s.markers}
    plain = {label: label.rpartition(":")[2] for s in trials for label in s.markers}
    if len(subjects) < 2 or any(len({plain[m] for m in s.markers}) < len(s.markers) for s in trials):
        return
    for seen in trials:
        seen.markers = tuple(plain[label] for label in seen.markers)
        seen.belt_fixed = [plain[label] for label in seen.belt_fixed]
        seen.longest_gap_s = {plain[label]: gap for label, gap in seen.longest_gap_s.items()}


def usual_belt(trials: Iterable[Seen]) -> BeltChannel | None:
    """Channel of the belt in most trials, as the trial shows it in which a marker follows it best.

    Trials with another scale than most of them, such as a reversed sign, do not count.
    """
    belts = [s.belt for s in trials if s.belt is not None]
    counts = Counter(belt.name for belt in belts)
    best_first = sorted(belts, key=lambda b: (-counts[b.name], -float(np.nan_to_num(abs(b.correlation)))))
    scales = sorted(belt.m_per_s_per_unit for belt in belts if belt.name == best_first[0].name)
    usual = scales[len(scales) // 2] if scales else np.nan
    return next((belt for belt in best_first if abs(belt.m_per_s_per_unit / usual - 1.0) < AGREES), None)


def _see_loads(seen: Seen, recording: Recording) -> None:
    """Vertical forces of the plates, each and together."""
    vertical = {
        str(number): plate.force @ DIRECTIONS[seen.up]
        for number, plate in enumerate(recording.plates, start=1)
        if plate.fault is None and np.isfinite(plate.force).any()
    }
    seen.loads_N = {number: loaded_mean(force) for number, force in vertical.items()}
    shortest = min((force.size for force in vertical.values()), default=0)
    if shortest:
        seen.load_N = loaded_mean(sum(force[:shortest] for force in vertical.values()))
        seen.contacts = max(contacts_of(force) for force in vertical.values())
    centres = enumerate((plate.corners for plate in recording.plates), start=1)
    seen.plate_centres_m = {str(n): corners.mean(axis=0) for n, corners in centres if corners is not None}


def loaded_mean(force: np.ndarray) -> float:
    """Mean of a vertical force (N), shape (n,), over the time for which it is loaded, else over all of it."""
    loaded = np.abs(force) > LOADED_N
    return float(force[loaded].mean()) if loaded.mean() > LEAST_LOADED else float(np.nanmean(force))


def contacts_of(force: np.ndarray) -> int:
    """Steps on a plate by its vertical force (N), shape (n,); 0 if it is never or nearly always loaded."""
    size = np.abs(force)
    peak = float(np.nanmax(size))
    if not peak > STEP_N or (size < LOADED_N).mean() < LEAST_IN_AIR:
        return 0
    known = size[(size < LOADED_N) | (size > 0.5 * peak)] > LOADED_N
    return int(np.count_nonzero(np.diff(known.astype(int)) > 0)) + int(known[0])


def _see_record(seen: Seen, file: Found) -> None:
    """Belt speed in a file of D-Flow's record module: positive where the belt moves backward."""
    speeds = [c for c in file.contents.channels if VELOCITY_NAMES.search(c.name) and c.shape]
    loaded = max(seen.loads_N, key=lambda n: abs(seen.loads_N[n]), default="2")
    side = "left" if loaded == "1" else "right"
    moving = [c for c in speeds if c.high > c.low] or speeds
    chosen = next((c for c in moving if side in c.name.lower()), moving[0] if moving else None)
    if chosen is not None:
        seen.belt = BeltChannel(chosen.name, "m/s", 1.0, 0.0, np.nan)


def markers_in(file: Found) -> tuple[Markers, str]:
    """Markers of a file of markers (m), and the maker of the system that recorded them."""
    from tepsipe.io.formats import read_all_markers

    markers = read_all_markers(file.path)
    if not file.format.text:  # texts hold no points that are computed from others
        markers = _positions(markers, file)
    return markers, file.contents.facts.get("made by", "")


def _positions(markers: Markers | None, file: Found) -> Markers | None:
    """Points of a file that are markers (m), not angles or forces computed from them."""
    if markers is None or not file.contents.markers:
        return markers
    columns = [
        k
        for k, label in enumerate(markers.labels)
        if label in file.contents.markers and not re.search(COMPUTED, label)
    ]
    labels = tuple(markers.labels[k] for k in columns)
    return Markers(markers.rate_hz, labels, markers.positions[:, columns])


def _plate_channels(recording: Recording) -> list[str]:
    """Channels that look like those of force plates by name or unit."""
    forces = re.compile(r"^(N|kN|Nmm|Nm|N\.?mm|Ncm)$")
    return [
        name
        for name, c in recording.channels.items()
        if forces.match(c.unit.strip())
        or re.search(r"(^|[ ._-])(f|m)(p\d)?[ ._-]*[xyz]\d?\b", name, re.IGNORECASE)
    ]


def _moving_axis(seen: Seen) -> int:
    """Horizontal axis of the file along which the lowest markers move most."""
    low = seen.positions[:, _lowest(seen)[:3]]
    low = low[:, np.isfinite(low).any(axis=(0, 2))]
    spread = np.median(np.nanmax(low, axis=0) - np.nanmin(low, axis=0), axis=0)
    spread[seen.up_axis] = -1.0
    return int(np.argmax(spread))


def _lowest(seen: Seen) -> list[int]:
    """Numbers of the markers from low to high; those that are hidden most of the time come last."""
    heights = seen.heights_m
    visible = np.isfinite(heights).mean(axis=0) > 0.5
    middle = [float(np.nanmedian(heights[:, k])) if visible[k] else np.inf for k in range(len(seen.markers))]
    return [int(k) for k in np.argsort(middle, kind="stable")]


def _belt_channel(seen: Seen, channels: dict) -> BeltChannel | None:
    """Channel whose integral is the path of a low marker; without markers, one with a telling name and unit.

    Of several channels with telling names the one that moves most is taken.
    """
    best, rank = None, (False, 0.0)
    for name, channel in channels.items():
        values = channel.values
        if not np.isfinite(values).all() or not np.ptp(values) > 0.0:
            continue
        named = bool(VELOCITY_NAMES.search(name))
        by_unit = SPEEDS.get(channel.unit.strip(), np.nan)
        if seen.positions is None:
            if named and np.ptp(values) * by_unit > rank[1]:
                best = BeltChannel(name, channel.unit, by_unit, 0.0, np.nan)
                rank = (True, np.ptp(values) * by_unit)
            continue
        sampled = at_frames(values, channel.rate_hz, seen.positions.shape[0], seen.frame_rate_hz)
        for k in _lowest(seen)[:4]:
            marker_velocity = smooth_velocity(seen.positions[:, k, seen.forward], seen.frame_rate_hz)
            r, _ = follows(marker_velocity, sampled)
            known = seen.followed.get(name)
            if abs(r) > FOLLOWS and (known is None or abs(r) > abs(known.correlation)):
                scale = scale_of(marker_velocity, sampled, seen.frame_rate_hz)
                signed = float(np.copysign(by_unit, scale))
                scale = signed if abs(scale / signed - 1.0) < AGREES else scale
                offset = float(np.median(values))
                seen.followed[name] = BeltChannel(name, channel.unit, scale, offset, r)
                if (named, abs(r)) > rank:
                    best, rank = seen.followed[name], (named, abs(r))
    return best


def _followers(seen: Seen) -> list[str]:
    """Markers that move with the belt, in the order of the file."""
    frames = seen.positions.shape[0]
    belt = at_frames(seen.velocity, seen.velocity_rate_hz, frames, seen.frame_rate_hz)
    pulses = pulses_of(seen.velocity, seen.velocity_rate_hz)
    followers = []
    for k, label in enumerate(seen.markers):
        position = seen.positions[:, k, seen.forward]
        if np.isfinite(position).mean() > 0.9:
            r, scale = moves_with(position, belt, seen.frame_rate_hz, pulses)
            if r > FOLLOWS and 0.9 < scale < 1.1:
                followers.append(label)
    return followers


def _see_emg(seen: Seen, file: Found) -> None:
    """Labels of muscles and the trigger of a file of electromyograms."""
    for channel in file.contents.channels:
        values = samples(channel)
        if TRIGGER_NAMES.search(channel.name) and is_two_levels(values):
            seen.emg_trigger = (channel.name, 0.5 * float(values.min() + values.max()))
        else:
            seen.emg.append(channel.name)
            seen.emg_rate_hz = min(channel.rate_hz or np.inf, seen.emg_rate_hz or np.inf)


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
