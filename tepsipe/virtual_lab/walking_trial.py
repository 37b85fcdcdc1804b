"""One walking trial of the virtual laboratory: real strides with simulated responses to pulses.

Files of a walk as a gait laboratory records it: markers and both force plates in one file, and events.

The walk is sagittal. Markers stand on lateral malleolus (the joint), knee, heel, toe and, where the walk has
its motion, the sacrum. The foot's pitch follows from the angles of hip and knee under an upright trunk; a
pulse turns the shank over the foot. Rotations thus reach the file as positions with the noise of cameras.

C3D: x to the right, y forward, z up, mm; plates of type 2 at a multiple of the frame rate. D-Flow (mocap
module): x to the right, y up, z backward, m; forces and moments about the origin at the rate of the frames.
"""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tepsipe.quantities import Height, Length, NotNegative, Point
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.walker import Joint, Walk, perturb, resample_walk

LABELS = ("LMAL", "LKNE", "LHEE", "LTOE", "SACR")
EVENTS = ("heel_strike", "toe_off", "pulse")
SIX = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
# centres of the belts: of the perturbed leg on the left (m)
LATERAL_M = (-0.285, 0.285)
# half of width and length of a belt (m)
HALF_WIDTH_M, HALF_LENGTH_M = 0.265, 0.9
ANALOG_PER_FRAME = 5
CONTACT_N = 30.0
# a C3D counts frames in 16 bits, and ezc3d truncates longer files without warning
MOST_FRAMES = 65535


@dataclass(frozen=True)
class WalkerBody:
    """What markers and plates show."""

    shank_m: Length = 0.42
    """Place of the marker on the knee above the one on the ankle."""
    heel_m: Point = (-0.06, -0.06)
    """Marker on the heel from the ankle (forward, up)."""
    toe_m: Point = (0.15, -0.07)
    """Marker on the toe from the ankle (forward, up)."""
    sacrum_height_m: Length = 1.0
    """Height of the marker on the sacrum."""
    marker_noise_m: Height = 0.0001
    """Standard deviation of a sample of a marker."""
    force_noise_N: NotNegative = 0.5
    """The same of a force."""
    moment_noise_Nm: NotNegative = 0.2
    """The same of a moment."""


def walk_markers(walk: Walk, unperturbed: Walk, body: WalkerBody) -> dict[str, np.ndarray]:
    """Positions without noise: label -> forward and up, shape (n, 2) (m).

    walk: Signals; its angle may have any constant offset.
    """
    base, signals = unperturbed.signals, walk.signals
    offset = np.median(base["angle"][base["vertical"] > CONTACT_N])
    trunk = base["hip"] - base["knee"] if {"hip", "knee"} <= base.keys() else 0.0 * base["angle"]
    flat = np.median((trunk - (base["angle"] - offset))[base["vertical"] > CONTACT_N])
    pitch = trunk - (base["angle"] - offset) - flat
    shank = pitch + (signals["angle"] - offset) + 0.5 * np.pi
    ankle = np.column_stack([signals["ankle_x"], signals["ankle_y"]])
    turned = np.column_stack([np.cos(pitch), np.sin(pitch)])
    across = np.column_stack([-turned[:, 1], turned[:, 0]])
    markers = {
        "LMAL": ankle,
        "LKNE": ankle + body.shank_m * np.column_stack([np.cos(shank), np.sin(shank)]),
        "LHEE": ankle + body.heel_m[0] * turned + body.heel_m[1] * across,
        "LTOE": ankle + body.toe_m[0] * turned + body.toe_m[1] * across,
    }
    if "com" in signals:
        markers["SACR"] = np.column_stack([signals["com"], np.full(len(ankle), body.sacrum_height_m)])
    return markers


def walk_plates(walk: Walk) -> list[np.ndarray]:
    """Force (N) and moment about the origin (N·m) on own and other foot, shape (n, 6) each.

       x points to the right, y forward.
    The force acts at height 0 on the middle of its belt, the other foot's below the origin of the axes.
    """
    first_foot = (walk.signals["anterior"], walk.signals["vertical"], walk.signals["cop"])
    second_foot = (0.0 * first_foot[0], walk.signals["other_vertical"], 0.0 * first_foot[0])
    return [
        np.column_stack([0.0 * up, forward, up, cop * up, -lateral * up, lateral * forward])
        for lateral, (forward, up, cop) in zip(LATERAL_M, (first_foot, second_foot), strict=True)
    ]


def write_events(path: Path, walk: Walk) -> None:
    """Write the events (s) as CSV, one kind per column."""
    columns = (walk.heel_strikes, walk.toe_offs, walk.onsets)
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(EVENTS)
        for k in range(max(map(len, columns))):
            writer.writerow([f"{times[k]:.6f}" if k < len(times) else "" for times in columns])


def write_truth(path: Path, joint: Joint) -> None:
    """Write the true I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad) at every per cent of stance as CSV."""
    percent = np.arange(0.0, joint.phase_percent[-1] + 0.5)
    rows = [
        ",".join(f"{x:.10g}" for x in (p, joint.inertia_kgm2, joint.damping(p), joint.stiffness(p)))
        for p in percent
    ]
    path.write_text("\n".join(["percent,I,B,K", *rows]) + "\n", encoding="utf-8")


def write_walk(
    path: Path, kind: str, walk: Walk, unperturbed: Walk, body: WalkerBody, rng: np.random.Generator
) -> None:
    """Write markers and plates as one of the laboratory's files.

    kind: c3d, or dflow (text of its mocap module).
    """
    markers = walk_markers(walk, unperturbed, body)
    positions = np.zeros((len(walk.signals["angle"]), len(markers), 3))
    for k, position in enumerate(markers.values()):
        positions[:, k, 0] = LATERAL_M[0]
        positions[:, k, 1:] = position
    positions += body.marker_noise_m * rng.standard_normal(positions.shape)
    write = {"c3d": _write_c3d, "dflow": _write_dflow}[kind]
    write(path, walk.rate_hz, tuple(markers), positions, walk_plates(walk), body, rng)


def _noise(shape: tuple[int, int], body: WalkerBody, rng: np.random.Generator) -> np.ndarray:
    scale = np.repeat([body.force_noise_N, body.moment_noise_Nm], 3)
    return scale * rng.standard_normal(shape)


def _write_dflow(path: Path, rate_hz, labels, positions, plates, body, rng) -> None:
    n = len(positions)
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    names, columns = ["TimeStamp", "FrameNumber"], [208.0 + np.arange(n) / rate_hz, 1.0 + np.arange(n)]
    for k, label in enumerate(labels):
        names += [f"{label}.Pos{axis}" for axis in "XYZ"]
        columns += list((positions[:, k] @ turn.T).T)
    for k, load in enumerate(plates):
        measured = load + _noise(load.shape, body, rng)
        for kind, vector in (("For", measured[:, :3]), ("Mom", measured[:, 3:])):
            names += [f"FP{k + 1}.{kind}{axis}" for axis in "XYZ"]
            columns += list((vector @ turn.T).T)
    formats = ["%.6f", "%d", *["%.5f"] * (len(names) - 2)]
    np.savetxt(path, np.column_stack(columns), formats, "\t", header="\t".join(names), comments="")


def _write_c3d(path: Path, rate_hz, labels, positions, plates, body, rng) -> None:
    import ezc3d  # loads a compiled library, which only makers of files need

    n = len(positions)
    if n > MOST_FRAMES:
        raise ValueError(f"expected at most {MOST_FRAMES} frames in a C3D, found {n}")
    file = ezc3d.c3d()
    point, analog = file["parameters"]["POINT"], file["parameters"]["ANALOG"]
    point["RATE"]["value"], point["UNITS"]["value"], point["LABELS"]["value"] = (
        [rate_hz],
        ["mm"],
        list(labels),
    )
    points = np.ones((4, len(labels), n))
    points[:3] = 1000.0 * positions.transpose(2, 1, 0)
    file["data"]["points"] = points
    file["data"]["meta_points"]["residuals"] = np.zeros((1, len(labels), n))
    file["data"]["meta_points"]["camera_masks"] = np.zeros((7, len(labels), n), dtype=bool)
    fine = np.arange(n * ANALOG_PER_FRAME) / ANALOG_PER_FRAME
    channels = []
    for lateral, load in zip(LATERAL_M, plates, strict=True):
        centre = np.array([lateral, 0.0, 0.0])
        about_centre = load[:, 3:] - np.cross(centre, load[:, :3])
        # x from corner 2 to corner 1, y from 4 to 1: x to the right, y backward, z down
        in_plate = np.hstack([load[:, :3] * [1.0, -1.0, -1.0], 1000.0 * about_centre * [1.0, -1.0, -1.0]])
        channels += [np.interp(fine, np.arange(n), channel) for channel in in_plate.T]
    to_file = np.tile([1.0, 1.0, 1.0, 1000.0, 1000.0, 1000.0], len(plates))
    noise = to_file * np.hstack([_noise((fine.size, 6), body, rng) for _ in plates])
    analog["RATE"]["value"] = [ANALOG_PER_FRAME * rate_hz]
    analog["LABELS"]["value"] = [f"{name}{k + 1}" for k in range(len(plates)) for name in SIX]
    analog["UNITS"]["value"] = (["N"] * 3 + ["Nmm"] * 3) * len(plates)
    file["data"]["analogs"] = (np.stack(channels) + noise.T)[None]
    _add_plates(file, len(plates))
    file.write(str(path))


def _add_plates(file, count: int) -> None:
    import ezc3d

    signs = np.array([[1.0, -1.0, 0.0], [-1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
    half = np.array([HALF_WIDTH_M, HALF_LENGTH_M, 0.0])
    corners = [1000.0 * (np.array([x, 0.0, 0.0]) + signs * half).T for x in LATERAL_M[:count]]
    for name, value in (
        ("USED", [count]),
        ("TYPE", [2] * count),
        ("ZERO", [0, 0]),
        ("CORNERS", np.stack(corners, axis=2)),
        ("ORIGIN", np.zeros((3, count))),
        ("CHANNEL", 1.0 + np.arange(6 * count).reshape(count, 6).T),
    ):
        file.add_parameter("FORCE_PLATFORM", name, np.asarray(value, dtype=float))
        if name in ("USED", "TYPE", "ZERO", "CHANNEL"):  # ezc3d adds numbers as floating point only
            file["parameters"]["FORCE_PLATFORM"][name]["type"] = ezc3d.ezc3d.INT


# peak velocity of a minimum-jerk ramp over its mean velocity
PEAK_OVER_MEAN = 1.875


def make_walking_trial(
    truth: dict,
    condition: str,
    signals: Mapping[str, np.ndarray],
    rate_hz: float,
    events: tuple[np.ndarray, np.ndarray, np.ndarray],
    protocol: dict,
    chosen: dict,
    files: Mapping[str, Path],
) -> None:
    """Write a trial as C3D and as D-Flow's text, its events, and the truth over stance.

    truth: seed, and the section walking of the laboratory's constants.
    condition: name of the trial; another name is another draw.
    signals: real walking, as of `Walk`.
    events: heel strikes (s), stances (s) and next heel strikes (s) of its usable strides.
    protocol: amplitude_m_per_s (peak velocity of the belt), interval_s (least time between pulses),
    duration_s.
    chosen: pulse_s (s), and pulses: pairs of onset (% of stance) and number.
    files: c3d, text, events, truth.
    """
    constants = truth["walking"]
    joint = Joint(**{k: tuple(v) if isinstance(v, list) else v for k, v in constants["joint"].items()})
    body = WalkerBody(**{k: tuple(v) if isinstance(v, list) else v for k, v in constants["body"].items()})
    start, stance, end = events
    # the longest run of strides that follow each other
    gaps = np.flatnonzero(~np.isclose(start[1:], end[:-1])) + 1
    run = max(np.split(np.arange(start.size), gaps), key=len)
    start, stance, end = start[run], stance[run], end[run]
    base = Walk(rate_hz, signals, np.append(start, end[-1]), start + stance)
    rng = generator(truth["seed"], "walking", condition)
    period = float(np.mean(end - start))
    strides = int(protocol["duration_s"] / period) - 2
    unperturbed = resample_walk(base, strides, rng)
    spacing = int(np.ceil(protocol["interval_s"] / period - 1e-9))
    onsets = np.repeat([p for p, _ in chosen["pulses"]], [n for _, n in chosen["pulses"]]).astype(float)
    places = rng.permutation(np.arange(2, strides - 2, max(spacing, 1)))
    if places.size < onsets.size:
        raise ValueError(
            f"expected at most {places.size} pulses in {strides} strides, {spacing} strides apart, found "
            f"{onsets.size} of {condition}"
        )
    pulses = dict(zip(places[: onsets.size].tolist(), rng.permutation(onsets).tolist(), strict=True))
    angle = protocol["amplitude_m_per_s"] * chosen["pulse_s"] / (PEAK_OVER_MEAN * joint.shank_m)
    walk = perturb(unperturbed, joint, pulses, angle, chosen["pulse_s"], 0.0, rng)
    write_walk(files["c3d"], "c3d", walk, unperturbed, body, rng)
    write_walk(files["text"], "dflow", walk, unperturbed, body, rng)
    write_events(files["events"], walk)
    write_truth(files["truth"], joint)
