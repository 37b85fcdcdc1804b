"""Files with corrected loads: what was known to be induced is removed, and nothing else changes."""

import gzip
import json
import re
import struct
from dataclasses import replace

import ezc3d
import numpy as np
import pytest
import scipy
from builders import alike
from c3d_builders import plate_channels, plate_of, write_c3d

from tepsipe import (
    InputError,
    belt_recording,
    calibrate_treadmill,
    compensate_recording,
    load_treadmill_models,
)
from tepsipe.cli import main
from tepsipe.experiments.belt.files import GROUP
from tepsipe.io.corrected_copy import write_c3d_copy
from tepsipe.io.readers.c3d import open_c3d, read_c3d_recording
from tepsipe.treadmill.registry import read_models, save_models

RATE_HZ, FRAMES_HZ, LASTS_S = 500.0, 100.0, 40.0
TIME = np.arange(round(RATE_HZ * LASTS_S)) / RATE_HZ
# static response of each load to the acceleration of the belt (N, N·m over m/s²); Fx and Mz are not induced
INDUCED = np.array([0.0, 6.0, 1.5, 2.5, 0.3, 0.0])
LOADS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
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
    loads = [word for k in LOADS for word in ("--load", f"plate 2 {k}")]
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
        true = person()[:, LOADS.index(name.split()[-1])]
        inside = np.abs(load.after - true) <= load.half_width
        share = inside[load.within].mean()
        assert 0.93 < share < 0.98, name


@pytest.fixture(scope="module")
def models(tmp_path_factory):
    """File of models of the right plate in the axes of the laboratory, and of a single load."""
    folder = tmp_path_factory.mktemp("models")
    velocity, loads = (
        [belt(seed)[::5] for seed in (1, 2)],
        {"": 3, **{f"plate 1 {k}": j for j, k in enumerate(LOADS)}},
    )
    kept = []
    for name, j in loads.items():
        train, test = (
            belt_recording(
                TIME[::5],
                wrench(seed, belt(seed))[::5, j],
                velocity[seed - 1],
                unit="N" if 0 <= j < 3 else "Nm",
                name=f"empty {seed}",
            )
            for seed in (1, 2)
        )
        one = calibrate_treadmill(train, test, models=["fir-causal"])
        kept += [replace(model, load=name) for model in one.models.values()]
    save_models(folder / "plates.json", kept[1:])
    save_models(folder / "single.json", kept[:1])
    return folder


def table(path, columns, comments=()):
    header, body = "\t".join(columns), np.column_stack(list(columns.values()))
    lines = [*comments, header, *("\t".join(f"{x:.6f}" for x in row) for row in body)]
    path.write_text("\n".join(lines) + "\n")
    return path


def read(path):
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return lines[0].split("\t"), np.array([line.split("\t") for line in lines[1:]])


def test_dflow_is_corrected_with_its_centre_of_pressure_and_the_speed_of_its_record_file(models, tmp_path):
    """D-Flow's axes: x to the right, y up, z backward. Here the models' six loads are taken in these axes."""
    rng, velocity, load = (
        np.random.default_rng(5),
        belt(5)[::5],
        wrench(5, belt(5), person()[:, [0, 2, 1, 3, 5, 4]])[::5],
    )
    frames = np.arange(1000, 1000 + velocity.size)
    names = [f"FP1.{kind}{axis}" for kind in ("For", "Mom") for axis in "XYZ"]
    point = np.column_stack([load[:, 5] / load[:, 1], 0.0 * velocity, -load[:, 3] / load[:, 1]])
    clock = {"TimeStamp": 50.0 + TIME[::5], "FrameNumber": frames}
    columns = clock | {"M1.PosX": rng.random(frames.size), "M1.PosY": rng.random(frames.size)}
    columns |= {"M1.PosZ": rng.random(frames.size)} | dict(zip(names, load.T, strict=True))
    columns |= dict(zip(("FP1.CopX", "FP1.CopY", "FP1.CopZ"), point.T, strict=True))
    mocap = table(tmp_path / "mocap.txt", columns)
    record = {
        "Time": 50.0 + TIME[::5],
        "FrameNumber": frames,
        "LeftBeltSpeed": velocity,
        "RightBeltSpeed": velocity + 0.1,
    }
    table(tmp_path / "record.txt", record)
    speed, output = f"{tmp_path / 'record.txt'}:LeftBeltSpeed", tmp_path / "out.txt"
    done = compensate_recording(mocap, models / "plates.json", output, velocity=speed, model="fir-causal")
    header, before = read(mocap)
    assert read(output)[0] == header
    after = read(output)[1]
    changed = [
        name for name, was, now in zip(header, before.T, after.T, strict=True) if not np.array_equal(was, now)
    ]
    assert set(changed) <= {*names, "FP1.CopX", "FP1.CopZ"}
    assert {"FP1.ForY", "FP1.MomX", "FP1.CopX", "FP1.CopZ"} <= set(changed)
    six = after[:, [header.index(name) for name in names]].astype(float)
    assert six[:, 1] == pytest.approx(done.loads["plate 1 Fy"].after, abs=1e-6)
    cop = after[:, [header.index("FP1.CopX"), header.index("FP1.CopZ")]].astype(float)
    assert cop == pytest.approx(np.column_stack([six[:, 5], -six[:, 3]]) / six[:, 1:2], abs=1e-8)
    assert done.pressure["plate 1"][0] > 0.0
    with pytest.raises(InputError, match=r"expected one belt speed, found 'LeftBeltSpeed', 'RightBeltSpeed'"):
        compensate_recording(mocap, models / "plates.json", velocity=str(tmp_path / "record.txt"))
    assert GROUP in output.read_text()
    with pytest.raises(InputError, match=r"out\.txt: expected a recording as it was measured"):
        compensate_recording(output, models / "plates.json", velocity=speed)


def test_tables_are_corrected_in_their_units(models, tmp_path):
    velocity, load = belt(6)[::5], wrench(6, belt(6), person())[::5]
    columns = {"time": TIME[::5]} | {f"{k}_right (N)": x for k, x in zip(LOADS[:3], load.T, strict=False)}
    columns |= {f"{k}_right (Nmm)": 1e3 * x for k, x in zip(LOADS[3:], load[:, 3:].T, strict=True)}
    columns |= {"belt (mm/s)": 1e3 * velocity, "other": velocity**2}
    path, output = table(tmp_path / "trial.txt", columns), tmp_path / "out.txt"
    done = compensate_recording(path, models / "plates.json", output, velocity="belt", model="fir-causal")
    header, before = read(path)
    after = read(output)[1]
    for k, name in enumerate(header):
        load_name = f"plate 1 {name[:2]}"
        if load_name in done.loads:
            factor = 1e3 if "Nmm" in name else 1.0
            removed = before[:, k].astype(float) - after[:, k].astype(float)
            assert removed == pytest.approx(factor * done.loads[load_name].removed, abs=1e-4 * factor)
        else:
            assert np.array_equal(before[:, k], after[:, k])


def test_a_table_of_one_load_keeps_its_lines(models, tmp_path):
    """Empty fields, decimal commas and line breaks of Windows stay; the velocity may be in a file."""
    velocity, load = belt(7)[::5], wrench(7, belt(7))[::5, 3]
    rows = [
        f"{t:.2f};{x:.5f};{v:.6f}".replace(".", ",")
        for t, x, v in zip(TIME[::5], load, velocity, strict=True)
    ]
    rows[100] = rows[100].split(";")[0] + ";;" + rows[100].split(";")[2]
    path, output = tmp_path / "run.csv", tmp_path / "out.csv.gz"
    path.write_bytes("\r\n".join(["t;moment (Nm);belt (m/s)", *rows, ""]).encode())
    done = compensate_recording(path, models / "single.json", output, model="fir-causal")
    text = gzip.decompress(output.read_bytes()).decode()
    kept = [line for line in text.split("\r\n") if not line.startswith("#")]
    assert kept[0] == "t;moment (Nm);belt (m/s)"
    assert kept[101] == rows[100]
    for row, line in zip((0, 500, 2000), (kept[1], kept[501], kept[2001]), strict=True):
        first, moment, last = line.split(";")
        assert (first, last) == (rows[row].split(";")[0], rows[row].split(";")[2])
        (after,) = (one.after[row] for one in done.loads.values())
        assert float(moment.replace(",", ".")) == pytest.approx(after, abs=1e-4)
    assert next(iter(done.loads.values())).r2 > 0.9
    # the command reads the copy again, and finds the velocity in a file of its own
    table(tmp_path / "speed.txt", {"time": TIME[::5], "belt": velocity})
    table(tmp_path / "load.txt", {"time": TIME[::5], "moment": load, "nothing": 0.0 * load + velocity})
    again = compensate_recording(
        tmp_path / "load.txt",
        models / "single.json",
        velocity=str(tmp_path / "speed.txt"),
        model="fir-causal",
    )
    (one,) = again.loads.values()
    (other,) = done.loads.values()
    assert one.removed[1000:2000] == pytest.approx(other.removed[1000:2000], abs=1e-3)


def test_models_without_their_range_and_errors_state_neither(models, tmp_path):
    """A study's file of models has no second recording and no range."""
    fitted = load_treadmill_models(models / "single.json")["fir-causal"]
    save_models(tmp_path / "belt.json", [replace(fitted, calibrated=None, held_out=None, errors=None)])
    run = table(tmp_path / "run.txt", {"t": TIME[::5], "load": wrench(7, belt(7))[::5, 3], "v": belt(7)[::5]})
    done = compensate_recording(run, tmp_path / "belt.json", tmp_path / "out.txt", model="fir-causal")
    assert done.to_frame()[["within_percent", "held_out_r2", "half_width"]].isna().all(axis=None)
    assert done.summary().count("unknown") == 3
    note = (tmp_path / "out.txt").read_text().partition("LOADS")[2]
    assert "an unknown share of the samples" in note and "100.0 %" not in note


@pytest.mark.parametrize("kind", [1, 3, 4])
def test_plates_of_other_types_are_written_back(kind, models, tmp_path):
    """Force and moment of the copy, as our reader returns them, are the recorded ones less the correction."""
    path = other_plate(tmp_path / "in.c3d", kind)
    done = compensate_recording(
        path, models / "plates.json", tmp_path / "out.c3d", belt_markers=["BELT"], model="fir-causal"
    )
    before, after = (read_c3d_recording(p).plates[0] for p in (path, tmp_path / "out.c3d"))
    for j, k in enumerate(LOADS):
        was, now = (np.hstack([p.force, p.moment])[:, j] for p in (before, after))
        removed = done.loads[f"plate 1 {k}"].removed if f"plate 1 {k}" in done.loads else 0.0 * was
        assert alike(was - now, removed, abs=2e-3)
    equal_but_for(path, tmp_path / "out.c3d", {f"c{j}" for j in range(8)})


def other_plate(path, kind):
    """A C3D with a plate of type 1, 3 or 4 under a person, without a channel of the belt velocity."""
    velocity = belt(8)
    load = wrench(8, velocity, person())
    flat = replace(plate_of("right"), kind=kind, origin_m=(0.0, 0.0, -0.04))
    own = plate_channels(
        replace(flat, origin_m=(0.0, 0.0, 0.0) if kind == 1 else flat.origin_m), load[:, :3], load[:, 3:]
    )
    six = np.column_stack([x for x, _ in own.values()])
    if kind == 1:
        x, y = -six[:, 4] / six[:, 2], six[:, 3] / six[:, 2]  # mm
        samples = [*six[:, :3].T, x, y, six[:, 5] - (x * six[:, 1] - y * six[:, 0])]
        units = ("N", "N", "N", "mm", "mm", "Nmm")
    elif kind == 4:
        matrix = np.diag([1.1, 0.9, 1.2, 1.0, 1.3, 0.8]) + 0.02 * np.random.default_rng(2).standard_normal(
            (6, 6)
        )
        flat = replace(flat, matrix=matrix)
        samples, units = list(np.linalg.solve(matrix, six.T)), ("N", "N", "N", "Nmm", "Nmm", "Nmm")
    else:
        a, b = 200.0, 150.0  # mm
        quarter = six[:, 2] / 4.0
        about_x, about_y = six[:, 3] / (4.0 * b), six[:, 4] / (4.0 * a)
        samples = [
            *(six[:, 0] / 2.0 - sign * six[:, 5] / (2.0 * b) for sign in (1.0, -1.0)),
            *(six[:, 1] / 2.0 for _ in range(2)),
            quarter + about_x - about_y,
            quarter + about_x + about_y,
            quarter - about_x + about_y,
            quarter - about_x - about_y,
        ]
        flat = replace(flat, origin_m=(0.2, 0.15, -0.04))
        units = ("N",) * 8
    flat = replace(flat, channels=tuple(f"c{j}" for j in range(len(samples))))
    channels = {f"c{j}": (x, unit) for j, (x, unit) in enumerate(zip(samples, units, strict=True))}
    channels["EMG"] = (np.random.default_rng(4).standard_normal(TIME.size), "mV")
    position = np.cumsum(velocity - 1.2)[:: round(RATE_HZ / FRAMES_HZ)] / RATE_HZ
    marker = np.column_stack([0.3 + 0.0 * position, position, 0.02 + 0.0 * position])
    return write_c3d(path, FRAMES_HZ, {"BELT": marker}, channels, [flat], RATE_HZ)


def test_whole_numbers_keep_their_step(real_data, models, tmp_path):
    """Gait.c3d holds 16-bit numbers of a DEC processor, and plates with calibration matrices."""
    path = real_data("c3d/Gait.c3d")
    speed = table(tmp_path / "speed.txt", {"time": TIME, "belt": belt(9)})
    done = compensate_recording(
        path, models / "plates.json", tmp_path / "out.c3d", velocity=str(speed), model="fir-causal"
    )
    labels = {f"{kind}1{axis}" for kind in "FM" for axis in "XYZ"}
    equal_but_for(path, tmp_path / "out.c3d", labels)
    assert done.steps == pytest.approx(dict.fromkeys(labels, 0.1221), rel=1e-3)
    before, after = (read_c3d_recording(p).plates[0] for p in (path, tmp_path / "out.c3d"))
    calibration = np.abs(before.calibration)
    for j, k in enumerate(LOADS):
        was, now = (np.hstack([p.force, p.moment])[:, j] for p in (before, after))
        wanted = was - done.loads[f"plate 1 {k}"].removed if f"plate 1 {k}" in done.loads else was
        assert np.abs(now - wanted).max() <= 0.5 * 0.1222 * calibration[j].sum() + 1e-6
    assert "rounded to steps" in str(done)


def test_a_belt_outside_the_calibrated_range_is_told_and_refused_if_strict(calibrated, capsys, tmp_path):
    path, _ = c3d(tmp_path / "fast.c3d", 11, person(), size=0.25)
    arguments = ["compensate", str(path), "--models", str(calibrated / "models.json"), *VELOCITY]
    output = tmp_path / "out.c3d"
    assert main([*arguments, "--output", str(output), "--strict"]) == 1
    printed = capsys.readouterr()
    assert "% of its velocity outside" in printed.err
    assert "written: nothing" in printed.out
    assert not output.exists()
    assert not (tmp_path / "out.c3d.png").exists()
    assert main([*arguments, "--output", str(output)]) == 0
    assert output.exists()
    options = {"velocity": "Belt speed", "velocity_scale": 0.5, "velocity_offset": 0.5, "strict": True}
    with pytest.raises(InputError, match=r"fast\.c3d: expected the range of the calibration"):
        compensate_recording(path, calibrated / "models.json", **options)


def test_calibration_finds_the_known_loads_and_leaves_the_others(calibrated):
    found = compensate_recording(
        calibrated / "empty2.c3d",
        calibrated / "models.json",
        velocity="Belt speed",
        velocity_scale=0.5,
        velocity_offset=0.5,
    )
    assert found.loads["plate 2 Fy"].r2 > 0.99
    assert set(found.kept) == {"plate 2 Fx", "plate 2 Mz", *(f"plate 1 {k}" for k in LOADS)}
    assert set(found.kept.values()) == {"for which there is no model"}
    assert {model.load for model in read_models(calibrated / "models.json")} == set(found.loads)
    assert str(found).count("Left as they were: ") == 1
    frame = found.to_frame()
    assert set(frame["load"]) == {"plate 2 Fy", "plate 2 Fz", "plate 2 Mx", "plate 2 My"}
    assert (frame["half_width_below_cutoff"] < frame["half_width"]).all()
    assert len(found.plot().axes) == 4


def refusal(**arguments):
    with pytest.raises(InputError) as refused:
        compensate_recording(**arguments)
    return str(refused.value)


def test_what_cannot_be_compensated_is_refused(calibrated, models, tmp_path):
    path, kept = calibrated / "empty1.c3d", calibrated / "models.json"
    known = {"recording": path, "models": kept, "velocity": "Belt speed", "velocity_scale": 0.5}
    assert "expected a channel or a file 'Speed'" in refusal(**known | {"velocity": "Speed"})
    assert "found none named" in refusal(**known | {"velocity": None})
    for name, value, said in (
        ("velocity", 5, "velocity: expected a text"),
        ("velocity_scale", "5", "velocity_scale: expected a number"),
        ("velocity_offset", None, "velocity_offset: expected a number"),
        ("load_unit", "kN", "load_unit: expected"),
        ("load", "Fy", "load: expected several texts"),
        ("strict", 1, "strict: expected True or False"),
        ("recording", 5, "recording: expected the path of a file"),
    ):
        assert said in refusal(**known | {name: value})
    assert "found the unit 'V'" in refusal(**known | {"velocity_scale": None})
    assert "expected the model to be one of" in refusal(**known | {"model": "firr"})
    assert "expected a load named 'Fq'" in refusal(**known | {"load": ["Fq"]})
    assert "expected a file of its own to write to" in refusal(**known | {"output": path})
    single = refusal(**known | {"models": models / "single.json"})
    assert "expected a load that the models of single.json correct" in single
    none = {"recording": path, "models": kept, "belt_markers": ["NO"]}
    assert "expected a marker named 'NO'" in refusal(**none)
    speed = table(tmp_path / "short.txt", {"time": TIME[:5000], "belt": belt(1)[:5000]})
    assert "expected the belt velocity from 0 to" in refusal(**known | {"velocity": str(speed)})
    two = table(tmp_path / "two.txt", {"time": TIME, "a": belt(1), "b": belt(2)})
    assert "expected one column of the belt velocity" in refusal(**known | {"velocity": str(two)})
    gaps = tmp_path / "gaps.txt"
    gaps.write_text(
        re.sub(
            r"(?m)^(3\.\S+)\t.*$",
            r"\1\t",
            table(tmp_path / "g.txt", {"time": TIME, "a": belt(1)}).read_text(),
        )
    )
    assert "expected a belt velocity in every sample" in refusal(**known | {"velocity": str(gaps)})
    no_markers = write_c3d(tmp_path / "no.c3d", FRAMES_HZ, {}, *without_markers(), RATE_HZ)
    assert "found no markers" in refusal(recording=no_markers, models=kept, belt_markers=["BELT"])
    no_plate = write_c3d(tmp_path / "plain.c3d", FRAMES_HZ, {}, without_markers()[0], [], RATE_HZ)
    speed = table(tmp_path / "speed.txt", {"time": TIME, "belt": belt(1)})
    said = refusal(recording=no_plate, models=kept, velocity=str(speed))
    assert "plain.c3d: expected a force plate with forces and moments, found none" in said
    columns = {"time": TIME[::5], "load": belt(1)[::5] ** 2, "belt": belt(1)[::5], "more": TIME[::5]}
    four = table(tmp_path / "four.txt", columns)
    assert "expected three columns" in refusal(recording=four, models=models / "single.json")
    three = table(tmp_path / "three.txt", {"t": TIME[::5], "load": belt(1)[::5] ** 2, "belt": belt(1)[::5]})
    given = {"recording": three, "models": models / "single.json", "model": "fir-causal"}
    said = refusal(**given | {"load_unit": "N"})
    assert "single.json: expected a model of a load in N for load, found one in Nm" in said
    frame = replace(load_treadmill_models(models / "single.json")["fir-causal"], name="loaded-frame")
    save_models(tmp_path / "frame.json", [frame])
    given |= {"models": tmp_path / "frame.json", "model": "loaded-frame"}
    said = refusal(**given)
    assert "expected a model of the belt's motion alone, found loaded-frame" in said
    assert "the mass on the belt: make a study of the recording" in said
    with pytest.raises(InputError, match=r"expected load to be one of 'plate 1 Fx'.*found none"):
        load_treadmill_models(models / "plates.json")
    assert load_treadmill_models(models / "plates.json", "plate 1 Fy")["fir-causal"].unit == "N"


def test_a_plate_without_numbers_and_loads_that_are_constant_are_refused(models, capsys, tmp_path):
    channels, plates = without_markers()
    channels["Belt speed"] = (belt(1), "m/s")
    broken = channels | {"Fx1": (np.full(TIME.size, np.nan), "N")}
    path = write_c3d(tmp_path / "nan.c3d", FRAMES_HZ, {}, broken, plates, RATE_HZ)
    said = refusal(recording=path, models=models / "plates.json", velocity="Belt speed")
    assert "nan.c3d, force plate 1: expected a number in every sample, found none" in said
    huge = channels | {"Mx1": (np.where(TIME == 9.0, 1e30, channels["Mx1"][0]), "Nmm")}
    path = write_c3d(tmp_path / "huge.c3d", FRAMES_HZ, {}, huge, plates, RATE_HZ)
    said = refusal(recording=path, models=models / "plates.json", velocity="Belt speed", model="fir-causal")
    assert f"{path}, plate 1 Mx: load: expected values of at most 1e+12 Nm" in said
    columns = {"time": 1e6 * TIME[::5]} | {
        f"{k}_right": x[::5] for k, x in zip(LOADS, person().T, strict=True)
    }
    slow = table(tmp_path / "slow.txt", columns | {"belt (m/s)": belt(1)[::5]})
    said = refusal(recording=slow, models=models / "plates.json", velocity="belt", model="fir-causal")
    assert (
        f"{slow}, plate 1 Fy: expected at least 10 Hz, a tenth of the rate of the models, found 0.0001 Hz"
        in said
    )
    still = channels | {f"{k}1": (0.0 * TIME, channels[f"{k}1"][1]) for k in LOADS}
    path = write_c3d(tmp_path / "still.c3d", FRAMES_HZ, {}, still, plates, RATE_HZ)
    output = ["--velocity", "Belt speed", "--output", str(tmp_path / "m")]
    assert main(["calibrate", str(path), str(path), *output]) == 2
    assert "still.c3d: expected a load that changes with the belt" in capsys.readouterr().err
    noise = np.random.default_rng(7).standard_normal((6, TIME.size))
    apart = channels | {f"{k}1": (x, channels[f"{k}1"][1]) for k, x in zip(LOADS, noise, strict=True)}
    paths = [str(write_c3d(tmp_path / f"{k}.c3d", FRAMES_HZ, {}, apart, plates, RATE_HZ)) for k in "ab"]
    assert main(["calibrate", *paths, *output]) == 2
    assert "a.c3d: expected a load that follows the acceleration" in capsys.readouterr().err


def test_a_model_that_predicts_nothing_corrects_nothing(models, tmp_path):
    poor = [
        replace(m, held_out=0.005 if m.load == "plate 1 Fx" else m.held_out)
        for m in read_models(models / "plates.json")
    ]
    save_models(tmp_path / "poor.json", poor)
    channels, plates = without_markers()
    path = write_c3d(tmp_path / "empty.c3d", FRAMES_HZ, {}, channels, plates, RATE_HZ)
    speed = table(tmp_path / "speed.txt", {"time": TIME, "belt": belt(1)})
    found = compensate_recording(path, tmp_path / "poor.json", velocity=str(speed), model="fir-causal")
    assert found.kept["plate 1 Fx"] == "of which the model predicts nothing on the held-out recording"
    assert "plate 1 Fy" in found.loads


def without_markers():
    """Channels and plates of a C3D whose belt velocity is in no channel."""
    plates = [plate_of("left")]
    return plate_channels(plates[0], *np.hsplit(wrench(1, belt(1)), 2)), plates


def test_what_cannot_be_calibrated_is_refused(calibrated, capsys, tmp_path):
    first, second = str(calibrated / "empty1.c3d"), str(calibrated / "empty2.c3d")
    output = ["--output", str(tmp_path / "models")]
    assert main(["calibrate", first, second, *["--velocity", "a"] * 3, *output]) == 2
    assert "--velocity: expected it once or twice, found it 3 times" in capsys.readouterr().err
    three = table(tmp_path / "three.txt", {"t": TIME[::5], "load": belt(1)[::5] ** 2, "belt": belt(1)[::5]})
    other = table(tmp_path / "other.txt", {"t": TIME[::5], "moment": belt(2)[::5] ** 2, "belt": belt(2)[::5]})
    assert main(["calibrate", str(three), str(other), *output]) == 2
    assert "other.txt: expected the load 'load' of three.txt" in capsys.readouterr().err


def in_whole_numbers(path, step):
    """Rewrite a C3D of floating point with 16-bit numbers, analog samples in steps of their unit."""
    content, old = bytearray(path.read_bytes()), open_c3d(path)
    points, analogs = old["data"]["points"].copy(), old["data"]["analogs"][0]
    points[3] = 0.0
    for group, value in ((b"POINT", 0.1), (b"ANALOG", step)):
        # the group's record has its negative number before its name, and its parameters the positive one
        number = 256 - content[content.index(group) - 1]
        names = (bytes([length, number]) + b"SCALE" for length in (5, 256 - 5))  # locked or not
        at = max(content.find(name) for name in names) + 10
        count = int(np.prod(np.array(content[at + 1 : at + 1 + content[at]], dtype=int)))
        at += 1 + content[at]
        content[at : at + 4 * count] = struct.pack("<f", value) * count
    content[12:16] = struct.pack("<f", 0.1)
    data = 512 * (struct.unpack("<H", content[16:18])[0] - 1)
    frames = points.shape[2]
    columns = np.round(points / 0.1).transpose(2, 1, 0).reshape(frames, -1)
    rows = np.round(analogs / step).T.reshape(frames, -1)
    path.write_bytes(bytes(content[:data]) + np.hstack([columns, rows]).astype("<i2").tobytes())
    return path


def test_whole_numbers_are_rounded_to_their_step_and_must_suffice(models, tmp_path):
    path = in_whole_numbers(other_plate(tmp_path / "in.c3d", 4), 20.0)
    arguments = {"belt_markers": ["BELT"], "model": "fir-causal"}
    done = compensate_recording(path, models / "plates.json", tmp_path / "out.c3d", **arguments)
    equal_but_for(path, tmp_path / "out.c3d", {f"c{j}" for j in range(6)})
    assert done.steps == pytest.approx({f"c{j}": 20.0 for j in range(6)})
    assert "steps of up to 20 (channel c0" in str(done)
    samples = open_c3d(path)["data"]["analogs"][0]
    with pytest.raises(
        InputError, match=r"in\.c3d: expected corrected samples within the range of its 16-bit"
    ):
        write_c3d_copy(path, tmp_path / "out.c3d", {0: samples[0] + 1e6}, "NOTE", {})


def test_a_c3d_that_cannot_be_written_is_refused(calibrated, tmp_path, monkeypatch):
    path = calibrated / "empty1.c3d"
    samples = open_c3d(path)["data"]["analogs"][0]
    long = {f"P{k}": ["x" * 200] * 200 for k in range(5)}
    with pytest.raises(InputError, match=r"empty1\.c3d: .*found the parameter section full"):
        write_c3d_copy(path, tmp_path / "out.c3d", {0: samples[0]}, "NOTE", long)
    file = open_c3d(path)
    file["parameters"]["ANALOG"]["SCALE"]["value"] = 2.0 * np.ones(20)
    monkeypatch.setattr("tepsipe.io.corrected_copy.open_c3d", lambda _: file)
    with pytest.raises(InputError, match=r"empty1\.c3d: expected analog samples that ANALOG:SCALE"):
        write_c3d_copy(path, tmp_path / "out.c3d", {0: file["data"]["analogs"][0, 0]}, "NOTE", {})
