"""Good calls of every public function, which the table of misuse spoils one argument at a time."""

from functools import cache

import numpy as np
from builders import LEG, RATE_HZ, Joint, swing

import tepsipe
from tepsipe import SegmentMarkers

TRUE = Joint(inertia=0.02, damping=0.2, stiffness=10.0)
LAYOUT = np.array([[0.0, 0.0], [-0.012, 0.87], [0.012, 0.39]])
FOOT = np.array([[-0.05, 0.0], [0.1, 0.0]])  # markers on the foot, relative to the ankle (m)
MARKERS = SegmentMarkers(("ankle", "top", "low"), LAYOUT)
LABELS = ["heel", "toe", "ankle", "top", "low"]


@cache
def moved():
    """A perturbed leg with noise in every signal, and its windows."""
    rng = np.random.default_rng(1)
    made = swing(TRUE)
    angle = made.motion.theta + 1e-5 * rng.standard_normal(made.time.size)
    torque = made.torque + 1e-3 * rng.standard_normal(made.time.size)
    windows = tepsipe.find_perturbations(made.time, made.belt_velocity, rest_before_s=1.9, rest_after_s=1.0)
    return made, angle, torque, windows


@cache
def positions():
    """Markers of foot and leg (m), with the noise of cameras."""
    made, angle, _, _ = moved()
    across, along = LAYOUT.T
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    y = made.belt_position[:, None] + np.hstack(
        [np.tile(FOOT[:, 0], (angle.size, 1)), across * cosine + along * sine]
    )
    z = 0.055 + np.hstack([np.tile(FOOT[:, 1], (angle.size, 1)), -across * sine + along * cosine])
    noise = 1e-5 * np.random.default_rng(2).standard_normal((*y.shape, 2))
    return np.stack([y, z], axis=2) + noise


def motion():
    """The leg's motion from its markers (s, rad, m)."""
    return tepsipe.segment_motion(moved()[0].time, positions(), MARKERS, LEG.com_m, labels=LABELS)


@cache
def driven():
    """Time (s), random torque (N·m) and the angle (rad) of a joint under it."""
    from scipy.signal import butter, lsim, sosfiltfilt

    rng = np.random.default_rng(5)
    time = np.arange(0.0, 40.0, 1.0 / RATE_HZ)
    torque = 0.5 * sosfiltfilt(butter(2, 15.0, fs=RATE_HZ, output="sos"), rng.standard_normal(time.size))
    angle = lsim(([1.0], [TRUE.inertia, TRUE.damping, TRUE.stiffness]), torque, time)[1]
    return time, torque, angle + 1e-5 * rng.standard_normal(time.size)


def response():
    """Admittance of this joint (rad/(N·m))."""
    return tepsipe.frequency_response(*driven(), band_hz=(0.5, 12.0))


@cache
def belt(seed):
    """A recording of an empty belt as arguments of `belt_recording`."""
    from scipy.signal import butter, sosfiltfilt

    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 40.0, 0.01)
    velocity = 1.2 + 0.1 * sosfiltfilt(butter(2, 5.0, fs=100.0, output="sos"), rng.standard_normal(time.size))
    load = 6.0 * np.gradient(velocity, time) + 0.05 * rng.standard_normal(time.size)
    return {"time": time, "load": load, "belt_velocity": velocity, "name": f"recording {seed}"}


def good(name):
    """Arguments of a good call of a public function, all by name."""
    made, angle, torque, windows = moved()
    time = made.time
    window = {"perturbations": windows, "bootstrap_draws": 100}
    arguments = {
        "lowpass": lambda: {"x": torque, "rate_hz": RATE_HZ},
        "find_perturbations": lambda: {
            "time": time,
            "belt_velocity": made.belt_velocity,
            "rest_before_s": 1.9,
            "rest_after_s": 1.0,
        },
        "frequency_response": lambda: dict(zip(("time", "u", "y"), driven(), strict=True)),
        "vaf": lambda: {"measured": torque, "predicted": 0.99 * torque},
        "Leg": lambda: {"mass_kg": 0.4, "com_m": 0.4485, "inertia_kgm2": 0.027},
        "SegmentMarkers": lambda: {"labels": ("ankle", "top", "low"), "layout_m": LAYOUT},
        "LegUncertainty": lambda: {
            "leg": LEG,
            "markers": MARKERS,
            "sources": {"leg_mass_kg": 0.01},
            "motion": motion(),
        },
        "segment_motion": lambda: {
            "time": time,
            "positions": positions(),
            "markers": MARKERS,
            "com_m": 0.4485,
            "labels": LABELS,
        },
        "joint_torque": lambda: {"motion": motion(), "leg": LEG},
        "simulate_joint": lambda: {
            "time": time,
            "belt_velocity": made.belt_velocity,
            "leg": LEG,
            "I": 0.02,
            "B": 0.2,
            "K": 10.0,
            "engine": "equations",
        },
        "fit_impedance": lambda: {"time": time, "angle": angle, "torque": torque, **window},
        "fit_output_error": lambda: {
            "motion": motion(),
            "foot_position": positions()[:, 0, 0],
            "belt_velocity": made.belt_velocity,
            "leg": LEG,
            "perturbations": windows,
        },
        "fit_joint_likelihood": lambda: {
            "time": time,
            "positions": positions(),
            "markers": MARKERS,
            "leg": LEG,
            "labels": LABELS,
            "belt_fixed": ["heel", "toe"],
            "perturbations": windows,
            "belt_velocity": made.belt_velocity,
            "softening": False,
        },
        "fit_admittance": lambda: {"response": response()},
        "fit_parallel_cascade": lambda: {
            **dict(zip(("time", "torque", "angle"), driven(), strict=True)),
            "bootstrap_draws": 100,
        },
        "belt_recording": lambda: belt(1),
        "calibrate_treadmill": lambda: {
            "train": tepsipe.belt_recording(**belt(1)),
            "test": tepsipe.belt_recording(**belt(2)),
            "models": ["mass-spring-damper"],
        },
        "compensate_recording": lambda: {"recording": "walk.c3d", "models": "treadmill_models.json"},
        "Signal": lambda: {"values": torque, "unit": "Nm"},
    }
    return dict(arguments[name]())


# ---- ways to spoil an argument -------------------------------------------------------------------


def scaled(factor):
    """The samples times a factor."""
    return lambda x: factor * np.asarray(x)


def cut(count):
    """The first samples."""
    return lambda x: x[:count]


def put(value, at=7):
    """One sample replaced."""

    def change(x):
        x = np.array(x, dtype=np.result_type(x, type(value)) if value is not None else object)
        x.reshape(x.shape[0], -1)[at] = value
        return x

    return change


def of_type(kind):
    """The samples as another type of NumPy."""
    return lambda x: np.asarray(x).astype(kind)


def masked(x):
    """The samples with every hundredth hidden."""
    return np.ma.masked_array(x, np.arange(x.size) % 100 == 0)


def constant(x):
    """One value throughout."""
    return np.full(x.shape, 0.1)


def series(name, factor=1.0):
    """A pandas column of this name."""

    def change(x):
        import pandas as pd

        return pd.Series(factor * x, name=name)

    return change


def signal(unit, factor=1.0):
    """A `Signal` in this unit."""
    return lambda x: tepsipe.Signal(factor * x, unit)


class Described:
    """Samples with the attributes of an xarray."""

    def __init__(self, values, **attrs):
        self.values, self.attrs, self.dtype, self.shape = values, attrs, values.dtype, values.shape

    def __array__(self, dtype=None, copy=None):
        return np.asarray(self.values, dtype)


def described(units, factor=1.0):
    """Samples with ``attrs["units"]``, as in xarray."""
    return lambda x: Described(factor * x, units=units)


def from_other(name):
    """The samples of another argument of the same call."""
    return lambda x, call: call[name]


def copied(x, call):
    """Every perturbation overwritten by the first one."""
    windows, x = moved()[3], np.array(x)
    length = min(w.stop - w.start for w in windows)
    for w in windows[1:]:
        x[w.start : w.start + length] = x[windows[0].start : windows[0].start + length]
    call["perturbations"] = [(w.start, w.start + length) for w in windows]
    return x
