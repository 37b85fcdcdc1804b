"""Files with corrected loads: what was known to be induced is removed, and nothing else changes."""

import json

import ezc3d
import numpy as np
import pytest
import scipy
from c3d_builders import Plate, plate_channels, plate_of, write_c3d

from tepsipe import InputError, belt_recording, calibrate_treadmill, compensate_recording
from tepsipe.cli import main
from tepsipe.experiments.belt.compensation import GROUP
from tepsipe.io.readers.c3d import read_c3d_recording
from tepsipe.io.readers.dflow import read_dflow
from tepsipe.treadmill.removal import removed_load
from tepsipe.treadmill.registry import save_models

RATE_HZ, FRAMES_HZ, LASTS_S = 500.0, 100.0, 40.0
TIME = np.arange(round(RATE_HZ * LASTS_S)) / RATE_HZ
# static response of each load to the acceleration of the belt (N, N·m over m/s²); Fx and Mz are not induced
INDUCED = np.array([0.0, 6.0, 1.5, 2.5, 0.3, 0.0])
NOISE = np.array([0.6, 0.8, 1.5, 0.3, 0.3, 0.2])


def belt(seed, size=0.06):
    """Velocity (m/s), shape (n,), of a belt that is accelerated at random below 5 Hz."""
    rng = np.random.default_rng(seed)
    sections = scipy.signal.butter(4, 5.0, fs=RATE_HZ, output="sos")
    noise = scipy.signal.sosfiltfilt(sections, rng.standard_normal(TIME.size))
    return 1.2 + size * noise / noise.std()


def induced(velocity):
    """Loads that a frame with a resonance at 12 Hz passes on, shape (n, 6)."""
    omega = 2.0 * np.pi * 12.0
    frame = scipy.signal.cont2discrete(([omega**2], [1.0, 0.6 * omega, omega**2]), 1.0 / RATE_HZ, "bilinear")
    acceleration = np.gradient(velocity, 1.0 / RATE_HZ)
    return np.outer(scipy.signal.lfilter(frame[0].ravel(), frame[1], acceleration), INDUCED)


def person():
    """Load of a person of 70 kg who sways (N, N·m about the laboratory's origin), shape (n, 6)."""
    sway = 0.02 * np.sin(2.0 * np.pi * 0.4 * TIME)
    force = np.column_stack([5.0 * np.sin(TIME), 8.0 * np.cos(0.7 * TIME), 687.0 + 12.0 * np.sin(3.0 * TIME)])
    point = np.column_stack([0.28 + 0.3 * sway, 0.1 + sway, np.zeros(TIME.size)])
    return np.hstack([force, np.cross(point, force)])


def wrench(seed, velocity, true=0.0):
    noise = NOISE * np.random.default_rng(seed).standard_normal((TIME.size, 6))
    return true + induced(velocity) + noise


def c3d(path, seed, true=0.0, size=0.06, channel=True):
    """A C3D of the right belt, whose plate is the second of two."""
    velocity = belt(seed, size)
    load, other = (
        wrench(seed, velocity, true),
        0.2 * np.random.default_rng(seed).standard_normal((TIME.size, 6)),
    )
    plates = [plate_of("left"), plate_of("right")]
    channels = plate_channels(plates[0], other[:, :3], other[:, 3:])
    channels |= plate_channels(plates[1], load[:, :3], load[:, 3:])
    channels["EMG"] = (np.random.default_rng(9).standard_normal(TIME.size), "mV")
    if channel:
        channels["Belt speed"] = (velocity / 0.5 + 0.5, "V")
    position = np.cumsum(velocity - 1.2)[:: round(RATE_HZ / FRAMES_HZ)] / RATE_HZ
    marker = np.column_stack([0.3 + 0.0 * position, position, 0.02 + 0.0 * position])
    return write_c3d(path, FRAMES_HZ, {"BELT": marker, "B2": marker + 0.1}, channels, plates, RATE_HZ), load


VELOCITY = ("--velocity", "Belt speed", "--velocity-scale", "0.5", "--velocity-offset", "0.5")


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory):
    """Folder with the models of the second plate, from two recordings of the empty belt."""
    folder = tmp_path_factory.mktemp("belt")
    for seed in (1, 2):
        c3d(folder / f"empty{seed}.c3d", seed)
    loads = [word for k in ("Fx", "Fy", "Fz", "Mx", "My", "Mz") for word in ("--load", f"plate 2 {k}")]
    files = [str(folder / f"empty{seed}.c3d") for seed in (1, 2)]
    assert main(["calibrate", *files, *loads, *VELOCITY, "--output", str(folder / "models")]) == 0
    return folder


def equal_but_for(before, after, labels):
    """Whether two C3D files, as ezc3d reads them, are equal but for some channels and the note."""
    first, second = ezc3d.c3d(str(before)), ezc3d.c3d(str(after))
    assert np.array_equal(first["data"]["points"], second["data"]["points"], equal_nan=True)
    names = first["parameters"]["ANALOG"]["LABELS"]["value"]
    others = [k for k, name in enumerate(names) if name not in labels]
    assert np.array_equal(first["data"]["analogs"][0, others], second["data"]["analogs"][0, others])
    assert set(second["parameters"]) - set(first["parameters"]) == {GROUP}
    for group, parameters in first["parameters"].items():
        for name, parameter in parameters.items():
            if name not in ("__METADATA__", "DATA_START"):
                assert np.array_equal(parameter["value"], second["parameters"][group][name]["value"]), name
    return second


def test_a_known_load_is_removed_from_a_c3d_and_nothing_else_changes(calibrated, capsys):
    path, _ = c3d(calibrated / "person.c3d", 3, person())
    output = calibrated / "corrected.c3d"
    arguments = [
        "compensate",
        str(path),
        "--models",
        str(calibrated / "models.json"),
        "--output",
        str(output),
    ]
    assert main([*arguments, *VELOCITY, "--strict", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    labels = {f"{kind}{axis}2" for kind in "FM" for axis in "xyz"}
    written = equal_but_for(path, output, labels)
    assert "plate 2 Fy: " in " ".join(written["parameters"][GROUP]["LOADS"]["value"])
    assert (calibrated / "corrected.c3d.png").read_bytes()[:4] == b"\x89PNG"
    assert all(row["within_percent"] > 95.0 for row in printed["loads"])
    # our reader: forces, moments, and the centre of pressure that follows from both
    plate = read_c3d_recording(output).plates[1]
    truth = person()
    before = read_c3d_recording(path).plates[1]
    for was, now, true in (
        (before.force[:, 1], plate.force[:, 1], truth[:, 1]),
        (before.moment[:, 0], plate.moment[:, 0], truth[:, 3]),
    ):
        assert np.std(now - true) < 0.35 * np.std(was - true)
    point, true_point = (-x[:, 3] / x[:, 2] for x in (np.hstack([before.force, before.moment]), truth))
    corrected = plate.moment[:, 0] / plate.force[:, 2]
    assert np.std(corrected + true_point) < 0.5 * np.std(-point + true_point)


def test_the_true_load_lies_within_the_stated_interval(calibrated):
    path, _ = c3d(calibrated / "again.c3d", 4, person())
    found = compensate_recording(
        path,
        calibrated / "models.json",
        velocity="Belt speed",
        velocity_scale=0.5,
        velocity_offset=0.5,
    )
    assert {"plate 2 Fy", "plate 2 Mx"} <= set(found.loads)
    for name, load in found.loads.items():
        true = person()[:, ["Fx", "Fy", "Fz", "Mx", "My", "Mz"].index(name.split()[-1])]
        inside = np.abs(load.after - true) <= load.half_width
        share = inside[load.within].mean()
        print(
            name,
            load.model.name,
            share,
            np.median(load.half_width),
            np.std(load.before - true),
            np.std(load.after - true),
        )
        assert 0.93 < share < 0.98, name
