"""Misuse of the public functions: how a good call is spoiled, and what the answer to it says.

Each row has the function, the spoiled arguments, and words of the answer. `REFUSED` calls raise one
`InputError`, `NOTED` calls give numbers and a note, `SAME` calls give the numbers of the good call. A
function as the value of an argument changes the good value. `FILES` are trials that `read_trial` refuses.
"""

import datetime
import math
from dataclasses import replace

import h5py
import numpy as np
import scipy.sparse
from misuse import (
    LAYOUT,
    constant,
    copied,
    cut,
    described,
    driven,
    from_other,
    good,
    masked,
    of_type,
    put,
    scaled,
    series,
    signal,
)

import tepsipe

NAN, INF = math.nan, math.inf


class Unconvertible:
    """Object of another package that fails when it is converted."""

    def __array__(self, *_, **__):
        raise RuntimeError("no numbers here")


class Quantity:
    """Samples in a unit of pint that is no angle."""

    units = "furlong"

    def __init__(self, values):
        self.magnitude = values

    def m_as(self, unit):
        raise ValueError(f"no {unit}")


def first_three(x):
    """A response at three frequencies."""
    return replace(x, frequency_hz=x.frequency_hz[:3], response=x.response[:3], coherence=x.coherence[:3])


def swung(x):
    """A sinusoid of 2 Hz at 250 samples per second, whose acceleration is proportional to its angle."""
    return 0.1 * np.sin(4.0 * np.pi * np.arange(x.size) / 250.0)


REFUSED = [
    # samples: kind, shape, gaps
    ("fit_impedance", {"angle": None}, "angle: expected an array of numbers"),
    ("fit_impedance", {"angle": "angle.csv"}, "array of numbers"),
    ("fit_impedance", {"angle": of_type(str)}, "array of numbers"),
    ("fit_impedance", {"angle": of_type(bool)}, "bool is no real number"),
    ("fit_impedance", {"angle": of_type(object)}, "object is no real number"),
    ("fit_impedance", {"angle": of_type(complex)}, "complex128 is no real number"),
    ("fit_impedance", {"angle": lambda x: (v for v in x)}, "generator"),
    ("fit_impedance", {"angle": lambda x: [[1.0, 2.0], [3.0]]}, "rows of different lengths"),
    ("fit_impedance", {"angle": lambda x: {"angle": x}}, "array of numbers"),
    ("fit_impedance", {"angle": []}, "empty array"),
    ("fit_impedance", {"angle": 0.1}, "shape (n)"),
    ("fit_impedance", {"angle": cut(-1)}, "2500 samples"),
    ("fit_impedance", {"angle": lambda x: x[:, None]}, "select or transpose"),
    ("fit_impedance", {"angle": put(NAN)}, "sample 7"),
    ("fit_impedance", {"angle": put(INF)}, "sample 7"),
    ("fit_impedance", {"angle": masked}, "masked"),
    ("fit_impedance", {"torque": masked}, "25 of 2500 missing, masked or infinite"),
    ("fit_impedance", {"angle": constant}, "0.1 throughout"),
    ("fit_impedance", {"torque": constant}, "0.1 throughout"),
    ("fit_impedance", {"torque": scaled(1e300)}, "at most 1e+12"),
    ("fit_impedance", {"angle": scaled(1000.0)}, "looks like degrees"),
    ("fit_impedance", {"torque": from_other("angle")}, "the same samples in both"),
    ("fit_impedance", {"angle": from_other("torque")}, "the same samples in both"),
    ("fit_impedance", {"angle": from_other("time")}, "the same samples in both"),
    ("fit_impedance", {"angle": lambda x: Unconvertible()}, "Unconvertible: no numbers here"),
    ("fit_impedance", {"cutoff_hz": np.timedelta64(3, "s")}, "cutoff_hz: expected"),
    ("fit_impedance", {"perturbations": lambda x: scipy.sparse.eye(3)}, "perturbations: expected"),
    ("calibrate_treadmill", {"train": np.array(1.0)}, "expected recordings"),
    # units
    ("fit_impedance", {"angle": signal("furlong")}, "deg, mrad, rad"),
    ("fit_impedance", {"angle": signal("Nm")}, "'Nm'"),
    ("fit_impedance", {"angle": described("mm")}, "'mm'"),
    ("fit_impedance", {"angle": series("ankle_torque_Nm")}, "exchanged"),
    ("fit_impedance", {"torque": series("angle (rad)")}, "exchanged"),
    ("Signal", {"unit": 5}, "a unit as text"),
    # time
    ("fit_impedance", {"time": scaled(1000.0)}, "milliseconds"),
    ("fit_impedance", {"time": lambda x: np.arange(x.size)}, "numbers of samples"),
    ("fit_impedance", {"time": scaled(-1.0)}, "increase"),
    ("fit_impedance", {"time": scaled(0.0)}, "increase"),
    ("fit_impedance", {"time": lambda x: np.sqrt(x)}, "regular clock"),
    ("fit_impedance", {"time": lambda x: (1e3 * x).astype("datetime64[ms]")}, "dates or durations"),
    ("fit_impedance", {"time": lambda x: x[:5]}, "at least 8 instants"),
    # windows and rest
    ("fit_impedance", {"perturbations": "all"}, "a list of windows"),
    ("fit_impedance", {"perturbations": np.array(4)}, "a list of windows"),
    ("fit_impedance", {"perturbations": {500: 540}}, "a list of windows"),
    ("fit_impedance", {"perturbations": []}, "at least one"),
    ("fit_impedance", {"perturbations": [(2.0, 2.2)]}, "samples, not seconds"),
    ("fit_impedance", {"perturbations": [(0, INF)]}, "samples, not seconds"),
    ("fit_impedance", {"perturbations": [(500, NAN)]}, "samples, not seconds"),
    ("fit_impedance", {"perturbations": [(500, 540, 580)]}, "pairs"),
    ("fit_impedance", {"perturbations": [(True, 540)]}, "samples, not seconds"),
    ("fit_impedance", {"perturbations": [(540, 500)]}, "4 samples or more"),
    ("fit_impedance", {"perturbations": [(2490, 2510)]}, "within the record's 2500"),
    ("fit_impedance", {"perturbations": [(500, 540)] * 5}, "the same window twice"),
    ("fit_impedance", {"perturbations": [(500, 540), (530, 570)]}, "windows that overlap"),
    ("fit_impedance", {"rest": (NAN, 1.0)}, "rest: expected a number of at least 0"),
    ("fit_impedance", {"rest": (-1.0, 1.0)}, "found -1"),
    ("fit_impedance", {"rest": ("1", "1")}, "found '1'"),
    ("fit_impedance", {"rest": (1.0, 2.0, 3.0)}, "booleans or two times"),
    ("fit_impedance", {"rest": 1.0}, "booleans or two times"),
    ("fit_impedance", {"rest": (0.0, 0.0)}, "at least 0.25 s"),
    ("fit_impedance", {"rest": (9.0, 1.0)}, "a perturbation in it"),
    ("fit_impedance", {"perturbations": None, "rest": (1.0, 1.0)}, "perturbations with thesis, rest"),
    # options
    ("fit_impedance", {"cutoff_hz": "20"}, "cutoff_hz: expected a number above 0, found '20'"),
    ("fit_impedance", {"cutoff_hz": NAN}, "found nan"),
    ("fit_impedance", {"cutoff_hz": 0}, "above 0, found 0"),
    ("fit_impedance", {"cutoff_hz": True}, "found True"),
    ("fit_impedance", {"cutoff_hz": 200.0}, "half the sampling rate"),
    ("fit_impedance", {"cutoff_hz": 1e-9}, "raise the cutoff"),
    ("fit_impedance", {"order": 100}, "from 1 to 16"),
    ("fit_impedance", {"order": 4.0}, "a whole number"),
    ("fit_impedance", {"order": 3}, "even order"),
    ("fit_impedance", {"thesis": "yes"}, "True or False"),
    ("fit_impedance", {"block_s": NAN}, "block_s"),
    ("fit_impedance", {"perturbations": None, "block_s": 0.001}, "4 samples or more"),
    ("fit_impedance", {"perturbations": None, "block_s": 1000.0}, "at least 4 blocks"),
    ("fit_impedance", {"bootstrap_draws": 100.0}, "a whole number from 100"),
    ("fit_impedance", {"bootstrap_draws": NAN}, "found nan"),
    ("fit_impedance", {"bootstrap_draws": 10**9}, "to 100000"),
    ("fit_impedance", {"confidence": 95}, "give 0.95"),
    ("fit_impedance", {"confidence": None}, "found None"),
    ("fit_impedance", {"seed": -1}, "of at least 0, found -1"),
    ("fit_impedance", {"seed": 1.5}, "a whole number"),
    ("fit_impedance", {"seed": "today"}, "found 'today'"),
    # other fits
    ("fit_output_error", {"motion": None}, "make one with tepsipe.segment_motion"),
    ("fit_output_error", {"leg": 0.4}, "make one with tepsipe.Leg"),
    ("fit_output_error", {"foot_position": from_other("belt_velocity")}, "the same samples in both"),
    ("fit_output_error", {"belt_velocity": constant}, "throughout"),
    ("fit_output_error", {"belt_velocity": scaled(-1.0)}, "the opposite sign"),
    ("fit_output_error", {"belt_velocity": scaled(0.1)}, "another unit"),
    ("fit_output_error", {"foot_position": scaled(1000.0)}, "another unit"),
    ("fit_joint_likelihood", {"belt_velocity": scaled(3.0)}, "another unit"),
    ("fit_output_error", {"cutoff_hz": None}, "cutoff_hz"),
    ("fit_output_error", {"perturbations": None}, "a list of windows"),
    ("fit_joint_likelihood", {"labels": "heel"}, "a list of names"),
    ("fit_joint_likelihood", {"labels": ["heel", "toe"]}, "expected 5 names"),
    ("fit_joint_likelihood", {"belt_fixed": ["thumb"]}, "thumb"),
    ("fit_joint_likelihood", {"belt_fixed": [1, 2]}, "expected texts"),
    ("fit_joint_likelihood", {"positions": scaled(1000.0)}, "looks like mm"),
    ("fit_joint_likelihood", {"positions": lambda x: x[:, :, 0]}, "(n, markers, 2)"),
    ("fit_joint_likelihood", {"softening": 1}, "True or False"),
    ("fit_joint_likelihood", {"hidden": Unconvertible()}, "hidden: expected booleans of shape"),
    ("fit_joint_likelihood", {"hidden": [[1, 0], [1]]}, "hidden: expected booleans of shape"),
    ("fit_joint_likelihood", {"markers": ("ankle", "top")}, "tepsipe.SegmentMarkers"),
    ("fit_admittance", {"response": np.ones(5)}, "frequency_response"),
    ("fit_admittance", {"band_hz": 5.0}, "two numbers"),
    ("fit_admittance", {"band_hz": (5.0, 5.1)}, "at least 4 frequencies"),
    ("fit_admittance", {"start": (1.0, 2.0)}, "shape (3)"),
    ("fit_admittance", {"lower": (NAN, 0.0, 0.0)}, "missing, masked or infinite"),
    ("fit_admittance", {"upper": "wide"}, "array of numbers"),
    ("fit_parallel_cascade", {"training_fraction": 2.0}, "training_fraction"),
    ("fit_parallel_cascade", {"folds": 2.5}, "folds: expected a whole number"),
    ("fit_parallel_cascade", {"penalties": "small"}, "penalties"),
    ("fit_parallel_cascade", {"stop_radii_rad": (-0.1,)}, "at least 0"),
    ("fit_parallel_cascade", {"reflex_delay": 0.04}, "'reflex_delay'"),
    ("fit_parallel_cascade", {"resample_rate_hz": -250.0}, "resample_rate_hz"),
    # motions that determine nothing
    ("fit_parallel_cascade", {"angle": constant}, "angle: expected a signal that changes"),
    ("fit_parallel_cascade", {"torque": from_other("angle")}, "the same samples in both"),
    ("fit_parallel_cascade", {"angle": swung}, "found movement at one"),
    ("fit_parallel_cascade", {"relaxation_times_s": (0.0,)}, "expected a number above 0"),
    ("fit_parallel_cascade", {"penalties": (0.0,)}, "expected a number above 0"),
    (
        "fit_parallel_cascade",
        {"penalties": (1e-30,), "reflex_thresholds_rad_per_s": (8.0,)},
        "options that the record determines",
    ),
    ("fit_parallel_cascade", {"torque": scaled(-1.0)}, "reverse the sign of the torque"),
    (
        "fit_parallel_cascade",
        {"reflex_delays_s": (0.06, 0.03)},
        "two numbers that increase, found [0.06, 0.03]",
    ),
    ("fit_impedance", {"thesis": True, "uncertainty": {"torque_scale": 0.01}}, "no uncertainty with thesis"),
    ("fit_admittance", {"response": first_three}, "at least 4 frequencies, found 3"),
    ("fit_admittance", {"response": lambda x: replace(x, coherence=2.0 * x.coherence)}, "coherences above 0"),
    ("fit_admittance", {"start": (0.0, 0.0, 0.0)}, "a joint that resists"),
    (
        "frequency_response",
        {"averaged_bins": 1},
        "averaged_bins: expected a whole number of at least 2, found 1",
    ),
    ("frequency_response", {"averaged_bins": 1251}, "averaged_bins: expected 2 to"),
    ("frequency_response", {"period_s": 2.0, "band_hz": (0.6, 0.9)}, "multiples of 0.5 Hz"),
    (
        "frequency_response",
        {"averaged_bins": None} | dict.fromkeys(("time", "u", "y"), cut(40)),
        "4 bands of frequencies",
    ),
    (
        "fit_impedance",
        {"uncertainty": lambda x: tepsipe.LegUncertainty(**good("LegUncertainty")), "torque": scaled(3.0)},
        "whose leg and motion gave the torque",
    ),
    ("calibrate_treadmill", {"ripple": 5}, "ripple: expected RippleOptions, found 5"),
    ("simulate_joint", {"leg": 0.4}, "tepsipe.Leg"),
    ("simulate_joint", {"softening": (1.0, 0.1, 0.0)}, "half_softening_rad: expected more than 0"),
    ("fit_joint_likelihood", {"leg": 0.4}, "tepsipe.Leg"),
    (
        "fit_joint_likelihood",
        {
            "markers": tepsipe.SegmentMarkers(("ankle", "top"), LAYOUT[:2]),
            "positions": lambda x: x[:, 2:4],
            "labels": ["ankle", "top"],
            "belt_fixed": ["ankle"],
        },
        "at least three markers on foot and leg, found 2",
    ),
    ("fit_impedance", {"angle": Quantity}, "a unit that converts to rad, found 'furlong'"),
    # signals and mechanics
    ("lowpass", {"x": 5.0}, "array of shape"),
    ("lowpass", {"x": lambda x: np.arange(5.0), "rate_hz": from_other("x")}, "rate_hz: expected a number"),
    ("lowpass", {"rate_hz": lambda x: np.array([x, x])}, "rate_hz: expected a number"),
    ("lowpass", {"zero_lag": "no"}, "True or False"),
    ("find_perturbations", {"rest_before_s": NAN}, "rest_before_s"),
    ("find_perturbations", {"rest_before_s": 0.0}, "at least 0.1"),
    ("find_perturbations", {"rest_after_s": 1e9}, "less than the record"),
    ("find_perturbations", {"threshold_fraction": 5}, "threshold_fraction"),
    ("find_perturbations", {"belt_velocity": scaled(1e5)}, "mm/s"),
    ("find_perturbations", {"until": "still"}, "until: expected 'stop' or 'rest'"),
    ("find_perturbations", {"until": "rest"}, "until='rest' without an angle"),
    ("find_perturbations", {"angle": from_other("belt_velocity")}, "until='stop' with an angle"),
    ("frequency_response", {"averaged_bins": 2.5}, "averaged_bins"),
    ("frequency_response", {"period_s": 1e-9}, "at least 4 samples"),
    ("frequency_response", {"band_hz": (NAN, 5.0)}, "band_hz"),
    ("frequency_response", {"y": from_other("u")}, "the same samples in both"),
    ("frequency_response", {"u": constant}, "throughout"),
    ("vaf", {"measured": [1.0, "2"], "predicted": [1.0, 2.0]}, "measured: expected an array of numbers"),
    ("vaf", {"measured": scaled(0.0)}, "0 throughout"),
    ("vaf", {"predicted": cut(5)}, "same shape"),
    ("LegUncertainty", {"leg": 0.4}, "expected a Leg"),
    ("LegUncertainty", {"markers": ["ankle"]}, "expected a SegmentMarkers"),
    ("LegUncertainty", {"motion": None}, "expected a SegmentMotion"),
    ("fit_impedance", {"uncertainty": 0.1}, "expected a mapping"),
    ("fit_impedance", {"uncertainty": {"torque_scale": -0.01}}, "at least 0"),
    ("fit_output_error", {"uncertainty": {"leg_mass_kg": "0.01"}}, "at least 0"),
    ("fit_admittance", {"uncertainty": {"leg_mass_kg": 0.01}}, "expected a known source"),
    ("Leg", {"mass_kg": "0.4"}, "mass_kg"),
    ("Leg", {"mass_kg": 0.0}, "above 0"),
    ("Leg", {"com_m": 448.5}, "give metres"),
    ("Leg", {"gravity_m_per_s2": 981.0}, "gravity_m_per_s2"),
    ("SegmentMarkers", {"labels": "abc"}, "a list of names"),
    ("SegmentMarkers", {"layout_m": np.zeros((3, 2))}, "apart from each other"),
    ("segment_motion", {"com_m": NAN}, "com_m"),
    ("segment_motion", {"markers": None}, "SegmentMarkers"),
    ("joint_torque", {"thesis": None}, "True or False"),
    ("simulate_joint", {"K": INF}, "K: expected a number"),
    ("simulate_joint", {"engine": 1}, "engine: expected one of"),
    ("simulate_joint", {"softening": (1.0, 2.0)}, "shape (3)"),
    ("simulate_joint", {"step_s": 1e-12}, "step_s: expected at most"),
    ("simulate_joint", {"foot": 2.1}, "Foot"),
    ("belt_recording", {"unit": "kg"}, "Nm or N"),
    ("belt_recording", {"name": 5}, "name: expected a text"),
    ("belt_recording", {"load": constant}, "load: expected a signal that changes"),
    ("belt_recording", {"load": from_other("belt_velocity")}, "the same samples in both"),
    ("belt_recording", {"trimmed_s": 1e9}, "record longer"),
    ("calibrate_treadmill", {"train": []}, "found 'none'"),
    ("compensate_recording", {"strict": 0.5}, "strict: expected True or False"),
    ("compensate_recording", {"belt_markers": [3]}, "belt_markers"),
    ("calibrate_treadmill", {"models": "fir"}, "a list of names"),
    ("calibrate_treadmill", {"models": []}, "at least one"),
    ("calibrate_treadmill", {"output_error_order": 2.5}, "a whole number"),
    ("calibrate_treadmill", {"spectral_segment_s": 20.1}, "half a recording of 40 s, found 20.1 s"),
    ("read_trial", {"path": 5}, "path: expected the path of a file"),
    ("read_trial", {"path": "nowhere.h5"}, "nowhere.h5"),
    ("load_treadmill_models", {"path": b"models"}, "path: expected the path of a file"),
    ("load_treadmill_models", {"path": "nowhere.json"}, "nowhere.json"),
    ("lowpass", {"x": datetime.datetime(2026, 1, 1)}, "array of numbers"),
]

NOTED = [
    ("fit_impedance", {"torque": scaled(-1.0)}, "reversed"),
    ("fit_impedance", {"angle": scaled(-1.0)}, "reversed"),
    ("fit_impedance", {"torque": scaled(-1.0), "perturbations": None, "block_s": 0.5}, "reversed"),
    ("fit_impedance", {"angle": lambda x: np.degrees(x)}, "degrees"),
    ("fit_impedance", {"angle": lambda x: np.degrees(x), "perturbations": None, "block_s": 0.5}, "degrees"),
    ("fit_impedance", {"angle": from_other("torque"), "torque": from_other("angle")}, "exchanged"),
    ("fit_impedance", {"angle": series("angle_deg", 180.0 / math.pi)}, "converted from deg"),
    ("fit_impedance", {"torque": series("torque [Nmm]", 1e3)}, "converted from Nmm"),
    ("fit_impedance", {"torque": scaled(1e6)}, "more than a human joint"),
    ("fit_impedance", {"torque": lambda x: np.roll(x, 12)}, "synchronisation"),
    ("fit_impedance", {"torque": lambda x: np.random.default_rng(0).normal(size=x.size)}, "VAF"),
    ("fit_impedance", {"cutoff_hz": 80.0}, "is high for samples"),
    ("fit_impedance", {"cutoff_hz": 2.0}, "is low for perturbations"),
    ("fit_impedance", {"angle": copied, "torque": copied}, "the same samples"),
    ("fit_impedance", {"perturbations": lambda x: x[:1]}, "One perturbation"),
    ("fit_joint_likelihood", {"belt_velocity": scaled(0.7)}, "times as fast"),
    (
        "fit_admittance",
        {
            "response": lambda x: tepsipe.frequency_response(
                driven()[0], *driven()[:0:-1], band_hz=(0.5, 12.0)
            )
        },
        "needs the admittance",
    ),
    (
        "fit_admittance",
        {"response": lambda x: tepsipe.frequency_response(driven()[0], driven()[1], -driven()[2])},
        "reversed",
    ),
]

SAME = [
    ("fit_impedance", {"angle": of_type("f4")}),
    ("fit_impedance", {"angle": of_type(">f8"), "torque": of_type(">f4")}),
    ("fit_impedance", {"angle": lambda x: np.repeat(x, 2)[::2]}),
    ("fit_impedance", {"angle": lambda x: np.ma.masked_array(x)}),
    ("fit_impedance", {"angle": lambda x: list(x), "torque": lambda x: tuple(x)}),
    ("fit_impedance", {"angle": series("angle_rad"), "torque": series("torque_Nm")}),
    ("fit_impedance", {"angle": signal("deg", 180.0 / math.pi)}),
    ("fit_impedance", {"angle": described("degrees", 180.0 / math.pi)}),
    ("fit_impedance", {"time": signal("ms", 1e3), "torque": signal("N·mm", 1e3)}),
    ("fit_impedance", {"cutoff_hz": np.float32(20.0), "order": np.int64(4), "seed": np.uint8(0)}),
    ("fit_impedance", {"cutoff_hz": np.array(20), "confidence": np.float64(0.95)}),
    ("fit_impedance", {"perturbations": lambda x: np.array([(w.start, w.stop) for w in x])}),
    ("fit_impedance", {"perturbations": lambda x: iter(x[::-1])}),
    ("fit_impedance", {"thesis": np.False_}),
    ("fit_admittance", {"band_hz": np.array([0.5, 12.0])}),
]


def impedance():
    """Response from angle to torque, the wrong way round."""
    time, torque, angle = driven()
    return tepsipe.frequency_response(time, angle, torque, band_hz=(0.5, 12.0))


# how a trial's file is spoiled, and words of the sentence about it
FILES = [
    (lambda f: f.pop("time"), "no axis 'time'"),
    (lambda f: put_data(f, "angle", f["angle"][:-1]), "'angle' has the shape"),
    (lambda f: put_data(f, "angle", np.zeros((f["time"].size, 2))), "'angle' has the shape (500, 2)"),
    (lambda f: put_data(f, "angle", 0.5), "'angle' has the shape ()"),
    (lambda f: put_data(f, "angle", f["angle"][...] + 1j), "no real numbers"),
    (lambda f: put_data(f, "angle", [b"a"] * f["time"].size), "no real numbers"),
    (lambda f: put_data(f, "angle", put(NAN)(f["angle"][...])), "missing or infinite"),
    (lambda f: f["angle"].attrs.__setitem__("units", "furlong"), "'furlong'"),
    (lambda f: f["angle"].attrs.__setitem__("units", 5), "no text"),
    (lambda f: f["angle"].attrs.__delitem__("units"), "cannot be read"),
    (lambda f: relinked(f, h5py.ExternalLink("elsewhere.h5", "/angle")), "a link to another file"),
    (lambda f: relinked(f, h5py.SoftLink("/nothing")), "a link to nothing"),
    (lambda f: f.create_group("further"), "no dataset"),
    (lambda f: f.attrs.__delitem__("condition"), "no name of its condition"),
    (lambda f: f.attrs.__setitem__("rate_hz", 1.0), "its clock"),
    (lambda f: put_data(f, "time", f["time"][...][::-1], scale=True), "do not increase"),
    (lambda f: put_data(f, "time", 1000.0 * f["time"][...], scale=True), "its clock"),
    (lambda f: put_data(f, "time", put(NAN)(f["time"][...]), scale=True), "do not increase"),
    (lambda f: put_data(f, "time", 0.0 * f["time"][...], scale=True), "do not increase"),
    (lambda f: put_data(f, "time", f["time"][:0], scale=True), "no row of numbers"),
    (lambda f: put_data(f, "angle", f["angle"][:0]), "'angle' has the shape (0,)"),
    (lambda f: put_data(f, "angle", np.inf * f["angle"][...]), "missing or infinite"),
    (lambda f: f.attrs.__setitem__("rate_hz", NAN), "its clock"),
    (lambda f: f.attrs.__setitem__("rate_hz", -250.0), "its clock"),
    (lambda f: f.attrs.__setitem__("rate_hz", "fast"), "cannot be read"),
    (lambda f: f.attrs.__delitem__("rate_hz"), "cannot be read"),
    (lambda f: f.attrs.__setitem__("condition", 5), "no name of its condition"),
    (lambda f: f.attrs.__setitem__("sources", "{"), "cannot be read"),
    (lambda f: f["angle"].attrs.__setitem__("long_name", 5), "no text"),
    (lambda f: f["angle"].attrs.__setitem__("units", "rad\n"), "'angle' is in 'rad"),
    (lambda f: relinked(f, h5py.ExternalLink("/dev/zero", "/")), "a link to another file"),
    (lambda f: relinked(f, h5py.SoftLink("/angle")), "too many links"),
]


def put_data(file, name, values, scale=False):
    """Replace the samples of a dataset."""
    words = dict(file[name].attrs)
    del file[name]
    dataset = file.create_dataset(name, data=values)
    for key in ("units", "long_name", "processing"):
        if key in words:
            dataset.attrs[key] = words[key]
    if scale:
        dataset.make_scale(name)
    elif dataset.ndim:
        dataset.dims[0].attach_scale(file["time"])
        dataset.dims[0].label = "time"


def relinked(file, link):
    """Replace a dataset by a link."""
    del file["angle"]
    file["angle"] = link
