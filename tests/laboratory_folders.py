"""Folders of recordings as other laboratories have them, and what their MISSING.md asks for.

Each function writes a folder of small files with the virtual laboratory, and returns the values that a user
would fill in: settings by their keys, and cells of the trial sheet by column and condition.
"""

import copy
import tempfile
from pathlib import Path

import ezc3d
import numpy as np
from c3d_builders import single_c3d

from tepsipe.virtual_lab.dummy_trial import make_dummy_trial
from tepsipe.virtual_lab.standing_trial import make_standing_trial
from tepsipe.virtual_lab.treadmill_trial import Protocol
from tepsipe.virtual_lab.walker import Joint, perturb
from tepsipe.virtual_lab.walking_trial import WalkerBody, write_walk
from tepsipe.virtual_lab.weight_trial import make_weight_trial
from tests.experiments.test_walking import synthetic_walk

MUSCLES = ("TA", "SOL", "GAS", "BF", "RF")
Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # x right, y up, z backward
PLUG_IN_GAIT = {"foot1": "RTOE", "foot2": "RHEE", "ankle": "RANK", "shank1": "RTIB", "shank2": "RSHA"}
PLUG_IN_GAIT |= {"thigh1": "RTHI", "thigh2": "RTHJ", "thigh3": "RKNE"}
# anterior and longitudinal offsets of the markers (m)
PLACES = {
    "foot": {"foot1": (0.14, -0.05), "foot2": (-0.05, -0.05), "ankle": (0.0, 0.0)},
    "shank": {"ankle": (0.0, 0.0), "shank1": (0.025, 0.37), "shank2": (-0.02, 0.16)},
    "thigh": {"thigh1": (0.03, 0.3), "thigh2": (-0.03, 0.18), "thigh3": (0.03, 0.06)},
}
DUMMY = {
    "leg_mass_kg": 0.4,
    "leg_com_m": 0.4485,
    "leg_inertia_kgm2": 0.027,
    "foot_mass_kg": 2.1,
    "foot_height_m": 0.055,
}
LEG = {"leg1": (-0.012, 0.6), "leg2": (0.012, 0.5), "leg3": (-0.012, 0.4), "leg4": (0.012, 0.3)}


def laboratory(truth, rate_hz=250.0):
    """The shipped laboratory with cameras of a rate, which sample all markers at once, and short rests."""
    truth = copy.deepcopy(truth)
    truth["treadmill"]["protocol"] |= {"rest_before_s": 2.0, "rest_after_s": 3.0, "rest_after_weight_s": 3.0}
    truth["treadmill"]["capture"] |= {
        "rate_hz": rate_hz,
        "marker_sampling_hz": 1e6,
        "occlusions_per_minute": 0.0,
    }
    return truth


def trial_of(make, truth, path, name, *protocol, emg=(), **options):
    """One C3D of a trial, by a function of the virtual laboratory."""
    length = protocol[-1].duration_s if "empty" in name else None
    with tempfile.TemporaryDirectory() as raw:
        files = {"log": Path(raw) / "log.mat", "calibration": Path(raw) / "calibration.csv"}
        files |= {} if "empty" in name else {"markers": Path(raw) / "markers.c3d"}
        files |= {"emg": Path(raw) / "emg.edf"} if emg else {}
        make(truth, name, *protocol, files, **options)
        return single_c3d(files, path, [f"EMG {muscle}" for muscle in emg], duration_s=length)


def weights(folder, truth, heavy=False, belts=("right",)):
    """Trials of a weight and the empty belt, and of a heavy weight, on one belt or on each of two."""
    kinds = {"weight20kg" if heavy else "weight": "weight", "empty": None}
    kinds |= {"weight60kg": "heavy_weight"} if heavy else {}
    for name, section in kinds.items():
        own = {key: value for key, value in truth.items() if key not in ("weight", "heavy_weight")}
        if section is not None:
            own["weight"] = truth[section]
        for belt in belts:
            on = f"_{belt}" if len(belts) > 1 else ""
            for number, profile in (("01", "sine"), ("02", "minjerk")):
                path, protocol = folder / f"{name}{on}_{number}.c3d", Protocol(profile, 0.4, 2.0, 22.0)
                trial_of(make_weight_trial, own, path, f"{name}-{number}", protocol, belt=belt)
    usual = {"mass_kg": 20.0, "com_height_m": 0.1, "com_forward_of_markers_m": None}
    answers = {"weight": {"ingest": {"marker_sampling_hz": None}, "weight": usual}}
    if heavy:
        further = {"mass_kg": 60.0, "com_height_m": 0.15, "com_forward_of_markers_m": None}
        answers["weight"]["further_weights"] = [further]
    return answers


def person(folder, truth, belt="right", rename=None):
    """A person in two trials of a task, with electromyograms."""
    for k in (1, 2):
        protocol = Protocol("sine" if k == 1 else "negative-sine", 0.4, (2.0, 2.4), 20.0)
        path = folder / f"relax_{k}.c3d"
        trial_of(make_standing_trial, truth, path, f"relax-{k}", "relax", protocol, emg=MUSCLES, belt=belt)
    labels = rename or {}
    numbers = {
        "mass_kg": 64.0,
        "stature_m": 1.75,
        "com_height": 0.55,
        "ankle_height_m": 0.08,
        "foot_com_m": 0.05,
    }
    segments = {
        f"{segment}_markers": [
            {"label": labels.get(m, m), "anterior_offset_m": a, "longitudinal_offset_m": b}
            for m, (a, b) in places.items()
        ]
        for segment, places in PLACES.items()
    }
    return {"standing": {"ingest": {"marker_sampling_hz": None}, "person": numbers | segments}}


def c3d_with_plates_and_emg(folder, truth):
    """One C3D per trial with both plates and electromyograms."""
    truth = laboratory(truth)
    return weights(folder, truth) | person(folder, truth), {}


def plug_in_gait(folder, truth):
    """Labels of plug-in-gait, y up, and muscles by underscores."""
    truth = laboratory(truth)
    answers = person(folder, truth, rename=PLUG_IN_GAIT)
    for path in folder.glob("*.c3d"):
        _relabel(path)
    return answers, {}


def _relabel(path):
    file = ezc3d.c3d(str(path))
    point, analog, plates = (file["parameters"][name] for name in ("POINT", "ANALOG", "FORCE_PLATFORM"))
    point["LABELS"]["value"] = [PLUG_IN_GAIT.get(label, label) for label in point["LABELS"]["value"]]
    analog["LABELS"]["value"] = [label.replace("EMG ", "EMG.R_") for label in analog["LABELS"]["value"]]
    points = file["data"]["points"]
    points[:3] = np.einsum("ij,jkl->ikl", Y_UP, points[:3])
    plates["CORNERS"]["value"] = np.einsum("ij,jkl->ikl", Y_UP, np.asarray(plates["CORNERS"]["value"]))
    file["data"]["meta_points"]["residuals"] = np.where(np.isnan(points[:1]).any(axis=0), -1.0, 0.0)[None]
    file["data"]["meta_points"]["camera_masks"] = np.zeros((7, *points.shape[1:]), dtype=bool)
    file.write(str(path))


def split_belt_at_100_hz(folder, truth):
    """A foot on each of two belts, a weight and the empty belt on both, cameras of 100 Hz."""
    truth = laboratory(truth, 100.0)
    return weights(folder, truth, belts=("left", "right")) | person(folder, truth, "both"), {}


def two_weights(folder, truth):
    """A dummy, the empty belt, and two weights."""
    truth = laboratory(truth)
    trial_of(make_dummy_trial, truth, folder / "dummy_01.c3d", "dummy-01", Protocol("sine", 0.4, 2.0, 14.0))
    leg = [{"label": "ankle", "anterior_offset_m": 0.0, "longitudinal_offset_m": 0.0}]
    leg += [{"label": m, "anterior_offset_m": a, "longitudinal_offset_m": b} for m, (a, b) in LEG.items()]
    dummy = {"ingest": {"marker_sampling_hz": None}, "geometry": DUMMY | {"leg_markers": leg}}
    heavy = {f"{number}-60kg": "60" for number in ("01", "02")}
    return weights(folder, truth, heavy=True) | {"dummy": dummy}, {"mass_kg": heavy}


def gait_with_events(folder, truth):
    """Walking on two plates, whose events and pulses are marked in the C3D."""
    base = synthetic_walk(40)
    pulses = dict.fromkeys(range(4, 37, 4), 40.0)
    walk = perturb(base, Joint(), pulses, 0.03, 0.06, 0.0, np.random.default_rng(1))
    path = folder / "gait_1.c3d"
    write_walk(path, "c3d", walk, base, WalkerBody(), np.random.default_rng(2))
    mark(
        path,
        [
            *(("Left", "Foot Strike", t) for t in walk.heel_strikes),
            *(("Left", "Foot Off", t) for t in walk.toe_offs),
            *(("General", "Pulse", t) for t in walk.onsets),
        ],
    )
    return {"walking": {"analysis": {"foot_mass_kg": 1.1}}}, {}


def mark(path, events):
    """Add events (context, label, s) to a C3D."""
    file = ezc3d.c3d(str(path))
    contexts, labels, times = zip(*events, strict=True)
    file.add_parameter("EVENT", "USED", [len(events)])
    file.add_parameter("EVENT", "CONTEXTS", list(contexts))
    file.add_parameter("EVENT", "LABELS", list(labels))
    file.add_parameter("EVENT", "TIMES", np.array([np.zeros(len(times)), times]))
    points = file["data"]["points"]
    hidden = np.isnan(points[:3]).any(axis=0)
    file["data"]["meta_points"]["residuals"] = np.where(hidden, -1.0, 0.0)[None]
    file["data"]["meta_points"]["camera_masks"] = np.zeros((7, *hidden.shape), dtype=bool)
    file.write(str(path))


def tables_with_other_names(folder, truth):
    """Tables of a joint whose columns have other names, units and signs in each file."""
    headers = ["Time (s),Angle (deg),Torque (Nm)", "t_s,ankle_rad,M_Nm", "time,theta_deg,tau_Nm"]
    for k, (header, in_degrees, sign) in enumerate(
        zip(headers, (True, False, True), (1, -1, 1), strict=True)
    ):
        rng = np.random.default_rng(k)
        time = np.arange(0.0, 30.0, 0.005)
        angle = 0.03 * np.convolve(rng.standard_normal(time.size), np.hanning(40) / 6.0, mode="same")
        velocity = np.gradient(angle, time)
        torque = 0.01 * np.gradient(velocity, time) + 1.0 * velocity + 60.0 * angle
        torque += 0.01 * rng.standard_normal(time.size)
        table = np.column_stack([time, np.degrees(angle) if in_degrees else angle, sign * torque])
        np.savetxt(
            folder / f"trial_{k + 1}.csv", table, delimiter=",", header=header, comments="", fmt="%.7g"
        )
    return {}, {}


FOLDERS = {
    folder.__name__: folder
    for folder in (
        c3d_with_plates_and_emg,
        plug_in_gait,
        split_belt_at_100_hz,
        two_weights,
        gait_with_events,
        tables_with_other_names,
    )
}
