"""Trials and results for the pages of trials, small and with recognisable numbers."""

import json
from html.parser import HTMLParser

import numpy as np

from tepsipe.io.estimates import Estimate
from tepsipe.io.result import Result
from tepsipe.io.trial import Signal, Trial

RATE_HZ = 250.0
NASTY = "</script><script>alert(1)</script><!-- & \"'\u2028{B} <b>"
VOID = {"meta", "line", "img", "br", "link", "input", "hr"}


class Reader(HTMLParser):
    """Checks that every element is closed in its order, and keeps what is inside scripts and attributes."""

    def __init__(self):
        super().__init__()
        self.open, self.scripts, self.links, self.ids, self.words = [], [], [], [], []

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.open.append(tag)
        if tag == "script":
            self.scripts.append("")
        self.links += [value for name, value in attrs if name in ("href", "src")]
        self.ids += [value for name, value in attrs if name == "id"]

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-1:]}"
        self.open.pop()

    def handle_data(self, data):
        if self.open and self.open[-1] == "script":
            self.scripts[-1] += data
        else:
            self.words.append(data)


def parsed(html):
    """A page, read by the standard parser; it must be well-formed."""
    reader = Reader()
    reader.feed(html)
    reader.close()
    assert reader.open == []
    assert len(reader.ids) == len(set(reader.ids))
    return reader


def page_data(html):
    """What the page gives to its script."""
    return json.loads(parsed(html).scripts[1])


def treadmill_trial(seconds=12.0, markers=("foot1", "leg1"), emg=False, name="a.mat"):
    rng = np.random.default_rng(1)
    time = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    size = time.size
    hidden = np.zeros((size, len(markers)), dtype=bool)
    hidden[500:510, 0] = True
    belt = np.where((time > 4.0) & (time < 4.1), 0.3, 0.0)
    signals = {
        "force": Signal(rng.normal(size=(size, 2, 3)), "N", ("time", "belt", "axis")),
        "belt_velocity": Signal(belt, "m/s", meaning="velocity", processing=("resampled",)),
        "belt_command": Signal(belt, "m/s"),
        "marker_position": Signal(rng.normal(size=(size, len(markers), 3)), "m", ("time", "marker", "axis")),
        "marker_hidden": Signal(hidden, "1", ("time", "marker")),
    }
    axes = {"time": time, "belt": np.array(["left", "right"]), "marker": np.array(markers)}
    if emg:
        axes |= {"emg_time": np.arange(round(seconds * 1000.0)) / 1000.0, "muscle": np.array(["SOL"])}
        signals["emg"] = Signal(rng.normal(size=(axes["emg_time"].size, 1)), "uV", ("emg_time", "muscle"))
    return Trial(RATE_HZ, axes, signals, attributes(name))


def attributes(name):
    return {"sources": json.dumps({"log": {"file": f"raw/{name}", "sha256": "ab" * 32}}), "options": "{}"}


def leg_result(size, pathways=("leg", "leg-thesis"), loads=False):
    rng = np.random.default_rng(2)
    windows = np.array([[1000, 1030], [2000, 2030]])
    arrays = {"windows": windows}
    for name in pathways:
        arrays |= {
            f"{name}/torque": rng.normal(size=size),
            f"{name}/predicted_torque": rng.normal(size=size),
            f"{name}/regressors": rng.normal(size=(size, 3)),
            f"{name}/vaf_per_perturbation": np.array([91.0, 93.0]),
        }
    if loads:
        for key in ("Fy/measured", "Fy/loaded-frame", "Mx/measured", "Mx/loaded-frame"):
            arrays[f"loads/{key}"] = rng.normal(size=size)
    facts = {"pathways": list(pathways), "marker_residual_rms_m": 1e-4}
    return Result(arrays, dict.fromkeys(arrays, "1"), facts)


def weight_results(count=2, length=75):
    rng = np.random.default_rng(3)
    arrays = {"masses": np.full(count, 20.0), "onsets": np.array([1000, 2000])[:count]}
    arrays |= {f"20 Hz/{key}": rng.normal(size=(count, length)) for key in ("added_force", "belt_velocity")}
    facts = {"filters": ["20 Hz"], "rate_hz": RATE_HZ, "carried_kg": 20.0, "perturbations": count}
    models = {f"minjerk-0.5/{name}": rng.normal(size=length) for name in ("measured", "fir", "loaded-frame")}
    plate = Result(
        models, dict.fromkeys(models, "N"), {"models": ["fir", "loaded-frame"], "rate_hz": RATE_HZ}
    )
    return Result(arrays, dict.fromkeys(arrays, "1"), facts), plate


def standing_results(trial, left_out):
    rng = np.random.default_rng(4)
    size, time = trial.time.size, np.arange(-75, 251) / RATE_HZ
    arrays = {"time": time, "onsets_s": np.array([4.0]), "processed/onsets_s": np.array([4.0, 8.0])}
    for key in ("ankle", "ankle_d", "y_cop", "torque_recommended", "torque_as_printed"):
        arrays[f"processed/{key}"] = rng.normal(size=size).astype(np.float32)
    arrays["processed/torque_as_printed"] = arrays["processed/torque_as_printed"][None]
    for key in ("belt_velocity", "ankle", "f_y", "shank", "thigh", "knee"):
        arrays[f"perturbed/{key}"] = rng.normal(size=(1, time.size))
    arrays["envelope"] = rng.normal(size=(1, time.size, 1))
    epochs = Result(
        arrays,
        dict.fromkeys(arrays, "1"),
        {
            "left_out": left_out,
            "fault": None,
            "torques": {"recommended": "ankle-compensated", "as_printed": ["ankle-thesis"]},
        },
    )
    curve = {
        f"curve/emg-driven/{part}": rng.normal(size=(1, 58)) for part in ("torque", "intrinsic", "active")
    }
    curve["curve/emg-driven/time"] = np.arange(58) / RATE_HZ
    facts = {
        "left_out": left_out,
        "perturbations": 2,
        "responses": 1,
        "muscles": ["SOL"],
        "critical_stiffness_Nm_per_rad": 554.8,
    }
    return Result(curve, dict.fromkeys(curve, "1"), facts), epochs


def estimates_of(experiment="dummy", condition="sine-0.3", flags=""):
    names = (experiment, condition, "leg", "windowed-least-squares")
    return [
        Estimate(*names, "K", "Nm/rad", 10.1272, 0.12, 9.8917, 10.3791, None, 14, flags=flags),
        Estimate(*names, "I", "Nms2/rad", 0.000123, 1e-4, -1e-9, 0.000301, None, 14),
        Estimate(*names, "VAF_trial", "%", 41.5),
    ]
