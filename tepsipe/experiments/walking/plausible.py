"""Walking trials whose numbers cannot be in the units that they should be in: one sentence each."""

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.walking.strides import CONTACT_N, Strides, WalkingRecording

LARGEST_TURN_RAD = 2.5  # of an ankle, from one extreme to the other
LOADS_N = (150.0, 5000.0)  # of one foot in stance
HEIGHT_M = (-0.05, 0.5)  # of the ankle in stance
LARGEST_LEVER_M = 0.5  # from ankle to centre of pressure


def refuse_other_units(recording: WalkingRecording, strides: Strides) -> None:
    """Refuse a recording whose angle, forces, lengths or events cannot be in rad, N, m and s.

    recording: signals of the perturbed leg.
    strides: strides of the same leg.
    """
    name, time = recording.name, recording.time
    outside = (strides.start < time[0]) | (strides.end > time[-1] + 1.0)
    if outside.any():
        raise InputError(
            f"{name}: expected the events within the recording, from {time[0]:.4g} to {time[-1]:.4g} s, "
            f"found strides from {strides.start[0]:.4g} to {strides.end[-1]:.4g}: give events in s on the "
            "clock of the recording, not in ms or frames, and only those that it holds"
        )
    turn = float(np.ptp(recording.angle))
    if turn > LARGEST_TURN_RAD:
        raise InputError(
            f"{name}: expected an angle of the ankle in rad, found a range of {turn:.3g}: convert degrees, "
            "or check the markers"
        )
    stance = strides.in_stance(time)
    load = float(np.median(recording.vertical[stance]))
    if not LOADS_N[0] <= load <= LOADS_N[1]:
        what = (
            "turn the sign (walking.recording.force_sign)"
            if load < -CONTACT_N
            else "give forces in N, and the events of the foot on this belt"
        )
        raise InputError(
            f"{name}: expected an upward force of {LOADS_N[0]:g} to {LOADS_N[1]:g} N in stance, found "
            f"{load:.3g}: {what}"
        )
    height = float(np.median(recording.ankle_y[stance]))
    if not HEIGHT_M[0] <= height <= HEIGHT_M[1]:
        raise InputError(
            f"{name}: expected the ankle {HEIGHT_M[0]:g} to {HEIGHT_M[1]:g} m above the belt in stance, "
            f"found {height:.3g}: give lengths in m, and correct the vertical axis or the height of the belt"
        )
    lever = float(
        np.median(np.abs(recording.cop - recording.ankle_x)[stance & (recording.vertical > CONTACT_N)])
    )
    if lever > LARGEST_LEVER_M:
        raise InputError(
            f"{name}: expected the centre of pressure within {LARGEST_LEVER_M:g} m of the ankle in stance, "
            f"found {lever:.3g} m: give both in m from one origin, of the same foot and in the same direction"
        )
