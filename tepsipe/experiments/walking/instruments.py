"""A walking trial from the files of a gait laboratory: markers and force plates of a C3D or of D-Flow's text.

With e_1 forward and e_2 up in the axes of the file, e_3 = e_1 x e_2, the belt's surface at the height h,
force F and moment M of the plate under the foot about the file's origin,

    x_cop = (e_3 . M + h F_1) / F_2,          theta = angle(shank) - angle(foot) - pi/2

shank from ankle to knee, foot from heel to toe, both in the plane of e_1 and e_2, positive from e_1 to e_2:
plantarflexion is positive, and zero where the shank is at a right angle to the foot.
"""

from pathlib import Path

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.experiments.walking.options import ANKLE, HEEL, KNEE, TOE, WalkingFiles
from tepsipe.experiments.walking.strides import CONTACT_N, WalkingRecording
from tepsipe.ingest.whole_trial import refuse_other_vertical
from tepsipe.io.formats import read_recording, recognised
from tepsipe.io.readers.recording import DIRECTIONS, ForcePlate, Recording, select_markers
from tepsipe.signals.resampling import BAND_PER_RATE, resample

NEEDED = (ANKLE, KNEE, HEEL, TOE)


def is_of_instruments(path: str | Path) -> bool:
    """Test for a whole trial in a format of its own, such as C3D or D-Flow text; any other is a table."""
    known = recognised(path)
    return known is not None and known.read_recording is not None and known.purpose != "table"


def read_instruments(path: str | Path, files: WalkingFiles, rate_hz: float, max_gap_s: float):
    """Read one leg of a walking trial from a C3D or from the text of D-Flow's mocap module.

    rate_hz: rate of the regular clock.
    max_gap_s: longest time for which a marker may be hidden.

    Returns
    -------
    WalkingRecording
        Signals on the clock, whose time 0 is the first frame.
    """
    return walking_recording(read_recording(path), files, rate_hz, max_gap_s)


def walking_recording(
    recording: Recording, files: WalkingFiles, rate_hz: float, max_gap_s: float
) -> WalkingRecording:
    """One leg of a walking trial from markers and plates; see `read_instruments` (m, N, N·m, Hz, s)."""
    name = recording.name
    forward, up = DIRECTIONS[files.axes.forward], DIRECTIONS[files.axes.up]
    if forward @ up:
        raise InputError(
            f"{name}: expected two different axes in walking.recording, found {files.axes.forward!r} "
            f"and {files.axes.up!r}: correct one of the two"
        )
    plane = np.stack([forward, up])
    markers = _filled(recording, files, max_gap_s)
    numbers = files.plates.own, files.plates.other
    plates = [_plate(recording, number) for number in numbers]
    refuse_other_vertical(
        dict(zip(numbers, plates, strict=True)), files.axes.up, name, "walking.recording.axes.up"
    )
    last_s = min(
        (len(next(iter(markers.values()))) - 1) / recording.markers.rate_hz,
        *((len(plate.force) - 1) / plate.rate_hz for plate in plates),
    )
    clock = np.arange(np.floor(last_s * rate_hz + 1e-6) + 1) / rate_hz

    def on_clock(values: np.ndarray, own_hz: float) -> np.ndarray:
        """Samples at the instants of the clock (unit of ``values``)."""
        band = BAND_PER_RATE * rate_hz if own_hz > (1.0 + 1e-6) * rate_hz else None
        return resample(np.arange(len(values)) / own_hz, values, clock, band, own_hz)

    at = {
        name: on_clock(x @ plane.T, recording.markers.rate_hz) - [0.0, files.surface_m]
        for name, x in markers.items()
    }
    across = np.cross(forward, up)
    measured, other = (
        files.force_sign * on_clock(np.column_stack([p.force @ plane.T, p.moment @ across]), p.rate_hz)
        for p in plates
    )
    loaded = measured[:, 1] > CONTACT_N
    cop = np.where(
        loaded,
        (measured[:, 2] + files.surface_m * measured[:, 0]) / np.where(loaded, measured[:, 1], 1.0),
        0.0,
    )
    shank, foot = at[KNEE] - at[ANKLE], at[TOE] - at[HEEL]
    state = {"shank": np.arctan2(*shank.T[::-1])}
    for label in set(at) - set(NEEDED):
        state |= {f"{label}_x": at[label][:, 0], f"{label}_y": at[label][:, 1]}
    return WalkingRecording(
        name,
        rate_hz,
        clock,
        angle=np.unwrap(state["shank"] - np.arctan2(*foot.T[::-1])) - 0.5 * np.pi,
        vertical=measured[:, 1],
        anterior=measured[:, 0],
        cop=cop,
        ankle_x=at[ANKLE][:, 0],
        ankle_y=at[ANKLE][:, 1],
        other_vertical=other[:, 1],
        state=dict(sorted(state.items())),
    )


def _plate(recording: Recording, number: int) -> ForcePlate:
    """A force plate with usable data."""
    if not 1 <= number <= len(recording.plates):
        raise InputError(
            f"{recording.name}: expected a force plate {number}, found {len(recording.plates)} force plates: "
            "correct walking.recording.plates"
        )
    plate = recording.plates[number - 1]
    if plate.fault is not None:
        raise InputError(plate.fault)
    if not (np.isfinite(plate.force).all() and np.isfinite(plate.moment).all()):
        raise InputError(
            f"{recording.name}, force plate {number}: expected a number in every sample, found none in some: "
            "export the file again"
        )
    if not plate.force.any():
        raise InputError(
            f"{recording.name}, force plate {number}: expected a load, found zeros only: correct "
            "walking.recording.plates, or record the plate"
        )
    return plate


def _filled(recording: Recording, files: WalkingFiles, max_gap_s: float) -> dict[str, np.ndarray]:
    """Positions of the wanted markers, short gaps filled by a monotone cubic (m)."""
    missing = [key for key in NEEDED if key not in files.markers]
    if missing:
        raise InputError(
            f"{recording.name}: expected the markers {', '.join(NEEDED)} in walking.recording.markers, found "
            f"none for {missing[0]!r}: name it"
        )
    if recording.markers is None:
        raise InputError(f"{recording.name}: expected markers, found none: export the file with its points")
    chosen = select_markers(recording.markers, list(files.markers.values()), recording.name)
    frames = np.arange(len(chosen.positions))
    filled = {}
    for key, label, positions in zip(
        files.markers, chosen.labels, chosen.positions.transpose(1, 0, 2), strict=True
    ):
        seen = np.isfinite(positions[:, 0])
        steps = np.diff(np.concatenate([[-1], frames[seen], [frames.size]])) - 1
        longest = steps.max() / chosen.rate_hz
        if longest > max_gap_s or seen.sum() < 2:
            raise InputError(
                f"{recording.name}: expected the marker {label!r} hidden for at most {max_gap_s:g} s, found "
                f"{longest:.3g} s: cut the trial there, or fill the gap where the motion is known"
            )
        if not seen.all():
            positions = scipy.interpolate.PchipInterpolator(frames[seen], positions[seen])(
                np.clip(frames, frames[seen][0], frames[seen][-1])
            )
        filled[key] = positions
    return filled
