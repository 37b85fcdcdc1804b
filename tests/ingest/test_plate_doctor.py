"""The plate doctor: a person who walks over two plates, and copies of the recording with one fault each."""

import json
import re
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy
from c3d_builders import Plate, plate_channels, write_c3d

from tepsipe import InputError
from tepsipe.cli import main
from tepsipe.ingest.plate_doctor import FINDINGS, examine_plates

RATE_HZ, FRAMES_HZ, LASTS_S, MASS_KG = 1000.0, 100.0, 5.0, 70.0
TIME = np.arange(round(RATE_HZ * LASTS_S)) / RATE_HZ
FRAMES = TIME[:: round(RATE_HZ / FRAMES_HZ)]
STANCE_S, HEEL_STRIKES_S = 0.7, (1.6, 2.15)
# heels of the left foot on the first plate and of the right one on the second (m), toes 0.2 m in front
HEELS_M = np.array([[-0.06, 0.12, 0.0], [0.08, 0.72, 0.0]])
LABELS = tuple(f"{kind}{axis}" for kind in "FM" for axis in "xyz")
WALKS = 1.1


def plate(number):
    """A plate of 0.5 by 0.5 m, the second in front of the first."""
    back = 0.5 * number
    corners = [[0.25, back, 0.0], [-0.25, back, 0.0], [-0.25, back + 0.5, 0.0], [0.25, back + 0.5, 0.0]]
    return Plate(np.array(corners), tuple(f"{label}{number + 1}" for label in LABELS))


def load(number):
    """Force (N) and moment about the laboratory's origin (N·m) of a stance, with noise."""
    share = (TIME - HEEL_STRIKES_S[number]) / STANCE_S
    on = (share > 0.0) & (share < 1.0)
    shape = np.where(on, np.sin(np.pi * np.clip(share, 0.0, 1.0)) ** 0.4, 0.0)
    force = np.zeros((TIME.size, 3))
    force[:, 2] = 9.81 * MASS_KG * shape * (1.0 + 0.15 * np.cos(4.0 * np.pi * share))
    force[:, 1] = -0.18 * force[:, 2] * np.cos(np.pi * np.clip(share, 0.0, 1.0))
    point = HEELS_M[number] + np.outer(np.clip(share, 0.0, 1.0), [0.0, 0.2, 0.0])
    rng = np.random.default_rng(number)
    noise = rng.standard_normal((TIME.size, 6)) * [0.3, 0.3, 0.8, 0.1, 0.1, 0.1]
    return force + noise[:, :3], np.cross(point, force) + noise[:, 3:]


def foot(number, side):
    """Markers of a foot that swings from 1.2 m behind its place to it, and on."""
    start, stop = HEEL_STRIKES_S[number] - 0.02, HEEL_STRIKES_S[number] + STANCE_S + 0.02
    knots = [0.0, start - 0.4, start, stop, stop + 0.4, LASTS_S]
    along = np.interp(FRAMES, knots, [-1.2, -1.2, 0.0, 0.0, 1.2, 1.2])
    lifted = np.where((start < FRAMES) & (stop > FRAMES), 0.0, 0.06)
    places = {
        "HEE": (0.0, 0.0, 0.03),
        "TOE": (0.0, 0.2, 0.03),
        "ANK": (0.04, 0.05, 0.08),
        "MT5": (-0.04, 0.15, 0.02),
    }
    rng = np.random.default_rng(10 + number)
    return {
        f"{side}{name}": HEELS_M[number]
        + place
        + np.column_stack([0.0 * along, along, lifted])
        + 1e-4 * rng.standard_normal((FRAMES.size, 3))
        for name, place in places.items()
    }


def walk():
    """Markers, channels and plates of the recording."""
    plates = [plate(0), plate(1)]
    channels = {}
    for number, each in enumerate(plates):
        channels |= plate_channels(each, *load(number))
    markers = foot(0, "L") | foot(1, "R")
    middle = np.interp(FRAMES, [0.0, LASTS_S], [-2.2, 3.3])
    markers["SACR"] = np.column_stack([0.0 * middle, middle, 1.0 + 0.0 * middle])
    return markers, channels, plates


def written(path, markers, channels, plates):
    return write_c3d(path, FRAMES_HZ, markers, channels, plates, RATE_HZ)


def of_first(channels, change, labels=LABELS):
    """Channels of which some of the first plate are changed."""
    return channels | {f"{k}1": (change(channels[f"{k}1"][0]), channels[f"{k}1"][1]) for k in labels}


def exchanged(channels, pairs):
    return channels | {a: channels[b] for pair in pairs for a, b in (pair, pair[::-1])}


def lowpassed(x):
    return scipy.signal.sosfiltfilt(scipy.signal.butter(2, 15.0, fs=RATE_HZ, output="sos"), x)


def shifted(markers, channels, plates):
    """The place of the first plate is wrong by 12 cm along x and 8 cm along y."""
    return (
        markers,
        channels,
        [replace(plates[0], corners_m=plates[0].corners_m + np.array([0.12, 0.08, 0.0])), plates[1]],
    )


def stored_origin(markers, channels, plates):
    """A plate whose origin lies beside it is described by the opposite vector."""
    origin = np.array([0.15, -0.1, -0.04])
    moved = replace(plates[0], origin_m=tuple(origin))
    channels = channels | plate_channels(moved, *load(0))
    return markers, channels, [replace(plates[0], origin_m=(-0.15, 0.1, -0.04)), plates[1]]


def relabelled(markers, channels, plates):
    other = {"L": "R", "R": "L"}
    return {other.get(k[0], k[0]) + k[1:]: x for k, x in markers.items()}, channels, plates


def held(x):
    """Samples that are lost in every tenth of a second, each time for 20 ms."""
    k = np.arange(x.size)
    return x[np.where(k % 100 < 20, k - k % 100, k)]


SPOILED = {
    "place": ("origin", shifted),
    "origin": ("origin", stored_origin),
    "sign of the force": ("sign", lambda m, c, p: (m, of_first(c, np.negative), p)),
    "sign of Mx": ("sign", lambda m, c, p: (m, of_first(c, np.negative, ("Mx",)), p)),
    "sign of Fy": ("sign", lambda m, c, p: (m, of_first(c, np.negative, ("Fy",)), p)),
    "axes": ("axes", lambda m, c, p: (m, exchanged(c, (("Fx1", "Fy1"), ("Mx1", "My1"))), p)),
    "moments in Nm": ("unit", lambda m, c, p: (m, of_first(c, lambda x: 1e-3 * x, LABELS[3:]), p)),
    "moments in 1e-6 Nm": ("unit", lambda m, c, p: (m, of_first(c, lambda x: 1e3 * x, LABELS[3:]), p)),
    "forces in mN": ("unit", lambda m, c, p: (m, of_first(c, lambda x: 1e3 * x), p)),
    "forces in kN": ("unit", lambda m, c, p: (m, of_first(c, lambda x: 1e-3 * x), p)),
    "lengths": ("unit", lambda m, c, p: ({k: 1e3 * x for k, x in m.items()}, c, p)),
    "unit": ("unit", lambda m, c, p: (m, c | {"Fx1": (c["Fx1"][0], "lbf")}, p)),
    "type": ("parameters", lambda m, c, p: (m, c, [replace(p[0], kind=7), p[1]])),
    "corners": (
        "axes",
        lambda m, c, p: (m, c, [replace(p[0], corners_m=p[0].corners_m[:, [2, 1, 0]]), p[1]]),
    ),
    "offset": ("offset", lambda m, c, p: (m, of_first(c, lambda x: x + 20.0, ("Fz",)), p)),
    "drift": ("drift", lambda m, c, p: (m, of_first(c, lambda x: x + 6.0 * TIME, ("Fz",)), p)),
    "clipping": ("clipped", lambda m, c, p: (m, of_first(c, lambda x: np.maximum(x, -500.0), ("Fz",)), p)),
    "spikes": (
        "spikes",
        lambda m, c, p: (m, of_first(c, lambda x: x + 300.0 * (np.arange(x.size) % 1000 == 500), ("Fz",)), p),
    ),
    "held": ("held-samples", lambda m, c, p: (m, of_first(c, held, ("Fz",)), p)),
    "missing": (
        "missing-samples",
        lambda m, c, p: (m, of_first(c, lambda x: np.where(TIME == 2.0, np.nan, x), ("Mx",)), p),
    ),
    "filter": ("filtered-signal", lambda m, c, p: (m, of_first(c, lowpassed), p)),
    "plates": (
        "plates-exchanged",
        lambda m, c, p: (m, exchanged(c, [(f"{k}1", f"{k}2") for k in LABELS]), p),
    ),
    "sides": ("sides-exchanged", relabelled),
    "gain": ("gain", lambda m, c, p: (m, of_first(c, lambda x: 1.5 * x), p)),
}


def test_a_good_recording_has_no_finding(tmp_path):
    assert examine_plates(written(tmp_path / "walk.c3d", *walk()), MASS_KG) == ()


@pytest.mark.parametrize("spoil", SPOILED)
def test_a_fault_is_named(spoil, tmp_path):
    fault, change = SPOILED[spoil]
    found = examine_plates(written(tmp_path / "walk.c3d", *change(*walk())))
    assert fault in {finding.fault for finding in found}, found
    assert fault == "plates-exchanged" or all(f.place != "force plate 2" for f in found), found


def test_another_mass_and_another_rate_are_named(tmp_path):
    path = written(tmp_path / "walk.c3d", *walk())
    (finding,) = examine_plates(path, 1.5 * MASS_KG)
    assert finding.fault == "weight"
    assert "105 kg" in finding.text
    content = bytearray(path.read_bytes())
    at = content.index(struct.pack("<f", RATE_HZ))  # ANALOG:RATE
    content[at : at + 4] = struct.pack("<f", 2.0 * RATE_HZ)
    path.write_bytes(content)
    (finding,) = examine_plates(path)
    assert finding.fault == "rate"
    assert "found 20 by ANALOG:RATE" in finding.text


@pytest.mark.parametrize(
    ("mass", "stated", "fault"), [(70.0, 70.0, None), (77.0, 70.0, "weight"), (70.0, None, None)]
)
def test_the_weight_of_a_person_who_stands(mass, stated, fault, tmp_path):
    rng = np.random.default_rng(3)
    force = np.column_stack([0.0 * TIME, 0.0 * TIME, 9.81 * mass + 0.0 * TIME]) + 0.5 * rng.standard_normal(
        (TIME.size, 3)
    )
    point = np.array([0.0, 0.25, 0.0]) + 0.005 * np.sin(TIME)[:, None] * [1.0, 1.0, 0.0]
    channels = plate_channels(plate(0), force, np.cross(point, force))
    markers = {
        k: np.tile(x[FRAMES.size // 2], (FRAMES.size, 1)) for k, x in (foot(0, "L") | foot(0, "R")).items()
    }
    path = written(tmp_path / "stand.c3d", markers, channels, [plate(0)])
    assert [finding.fault for finding in examine_plates(path, stated)] == ([fault] if fault else [])
    drifting = channels | {"Fz1": (channels["Fz1"][0] - 10.0 * TIME, "N")}
    path = written(tmp_path / "drift.c3d", markers, drifting, [plate(0)])
    assert "drift" in {finding.fault for finding in examine_plates(path)}


def test_a_file_without_plates_or_with_another_unit_of_length(tmp_path):
    markers, channels, plates = walk()
    (finding,) = examine_plates(written(tmp_path / "markers.c3d", markers, channels, []))
    assert finding.fault == "parameters"
    path = written(tmp_path / "walk.c3d", markers, channels, plates)
    content = path.read_bytes()
    at = content.index(b"mm", content.index(b"UNITS"))
    path.write_bytes(content[:at] + b"in" + content[at + 2 :])
    (finding,) = examine_plates(path)
    assert (finding.fault, finding.place) == ("unit", "file")


def test_the_command_prints_findings_and_its_code_is_1(tmp_path, capsys):
    good = written(tmp_path / "good.c3d", *walk())
    bad = written(tmp_path / "bad.c3d", *SPOILED["offset"][1](*walk()))
    assert main(["check", str(good), "--mass", "70"]) == 0
    assert "no fault" in capsys.readouterr().out
    assert main(["check", str(good), str(bad)]) == 1
    assert f"{bad}: offset: force plate 1: " in capsys.readouterr().out
    assert main(["check", str(bad), "--json"]) == 1
    printed = json.loads(capsys.readouterr().out)
    assert printed["files"][0]["findings"][0]["fault"] == "offset"
    for arguments, said in (
        ([str(good), "config.yaml"], "C3D files only"),
        ([str(good), "--mass", "0"], "--mass: expected a mass of 1 to 1000 kg, found 0"),
        (["--mass", "70"], "--mass: expected C3D files"),
        (["config.yaml", "--json"], "--json: expected C3D files"),
    ):
        assert main(["check", *arguments]) == 2
        assert said in capsys.readouterr().err
    (tmp_path / "cut.c3d").write_bytes(good.read_bytes()[:5000])
    with pytest.raises(InputError, match="truncated"):
        examine_plates(tmp_path / "cut.c3d")


def test_every_finding_is_explained():
    text = (Path(__file__).parents[2] / "docs/checks.md").read_text()
    rows = set(re.findall(r"^\| `([a-z-]+)` \|", text.partition("## Force plates")[2], re.MULTILINE))
    assert set(FINDINGS) <= rows


def test_public_recordings_have_no_other_fault_than_a_look_confirms(real_data):
    """The zero of both plates of Gait.c3d is off, by 11 N and 16 N, while nothing stands on them."""
    found = {
        name: examine_plates(real_data(f"c3d/{name}.c3d"))
        for name in ("Gait", "Qualisys", "HC002D02", "HC002D06")
    }
    assert {name: [f.fault for f in findings] for name, findings in found.items()} == {
        "Gait": ["offset", "offset"],
        "Qualisys": [],
        "HC002D02": [],
        "HC002D06": [],
    }
