"""One walking trial of the virtual laboratory: real strides with simulated responses to pulses."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.walker import Joint, Walk, perturb, resample_walk
from tepsipe.virtual_lab.walking_files import WalkerBody, write_events, write_truth, write_walk

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
