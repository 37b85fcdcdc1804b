"""tepsipe new-study: what it sees in a folder, what it writes, and that it touches nothing else."""

import gzip
import hashlib
import shutil

import numpy as np
import pytest
import yaml
from c3d_builders import Plate, plate_channels, plate_of, single_c3d, write_c3d
from dflow_builders import write_mocap, write_record

from tepsipe import __version__
from tepsipe.cli import main
from tepsipe.errors import InputError
from tepsipe.io.readers.c3d import read_c3d_recording
from tepsipe.new_study.files import columns_by_role, look_at
from tepsipe.new_study.measures import (
    follows,
    is_two_levels,
    moves_with,
    period_s,
    pulses_of,
    resisting_sign,
    rests,
    scale_of,
    smooth_velocity,
)
from tepsipe.new_study.pairing import experiment_by_name, group_files, key_of
from tepsipe.new_study.plan import Plan, flow, yaml_text
from tepsipe.new_study.start import REQUIRED, version_of
from tepsipe.new_study.study import FILES, PROFILE, RULES, new_study
from tepsipe.new_study.treadmill_trials import muscles_of
from workflow.settings.config import check_config
from workflow.support.people import read_participants
from workflow.support.placeholders import refuse_placeholders
from workflow.support.trial_sheet import read_trial_sheet
from workflow.support.yaml_file import read_settings


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def digests(folder):
    return {p: hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.rglob("*") if p.is_file()}


def merged(base, other):
    for key, value in other.items():
        base[key] = merged(dict(base.get(key) or {}), value) if isinstance(value, dict) else value
    return base


def settings(config, folder):
    """The shipped configuration under what new-study wrote."""
    return merged(config, read_settings(folder / "config.yaml"))


def filled(content):
    """The same with a number for every placeholder."""
    if isinstance(content, dict):
        return {key: filled(value) for key, value in content.items()}
    if isinstance(content, list):
        return [filled(value) for value in content]
    return 0.1 if content == "MISSING" else content


# ---- a dummy in the instruments' own files, and in one C3D ---------------------------------------


def test_dummy_of_the_instruments_files(dummy_files, tmp_path, config, root):
    here = tmp_path / "lab" / "dummy" / "sine-0.5"
    here.mkdir(parents=True)
    for path in dummy_files.values():
        shutil.copy(path, here)
    before = digests(tmp_path / "lab")
    made = new_study("lab")
    assert made.trials == {"dummy": 1}
    assert digests(tmp_path / "lab") == before
    own = read_settings(tmp_path / "lab-study" / "config.yaml") if (tmp_path / "lab-study").exists() else None
    assert own is not None  # the folder of the recordings is not written to
    assert own["plate_treadmill"] == {"belt": "right", "resample_rate_hz": 250.0}
    assert own["dummy"]["foot"]["belt_fixed_labels"] == ["foot1", "foot2", "foot3", "ankle"]
    labels = [m["label"] for m in own["dummy"]["geometry"]["leg_markers"]]
    assert labels == ["ankle", "leg1", "leg2", "leg3", "leg4"]
    # the laboratory of the tests rests for 2 s before and 3 s after
    assert 1.5 < own["dummy"]["analysis"]["rest_before_s"] <= 2.0
    whole = settings(config, tmp_path / "lab-study")
    with pytest.raises(ValueError, match=r"leg_mass_kg.*MISSING"):
        refuse_placeholders(whole, "configuration")
    check_config(filled(whole), "configuration")
    (row,) = read_trial_sheet(tmp_path / "lab-study" / "trials.tsv", "lab").values()
    assert (row.experiment, row.condition) == ("dummy", "sine-0.5")
    assert set(row.files) == {"log", "calibration", "markers"}
    missing = (tmp_path / "lab-study" / "MISSING.md").read_text()
    for key in ("leg_mass_kg", "leg_inertia_kgm2", "foot_height_m", "leg_markers", "marker_sampling_hz"):
        assert key in missing


def test_single_c3d_of_the_dummy(dummy_files, tmp_path, config, root):
    (tmp_path / "mine").mkdir()
    single_c3d(dummy_files, tmp_path / "mine" / "trial_07.c3d")
    assert new_study("mine", output="study").trials == {"dummy": 1}
    own = read_settings(tmp_path / "study" / "config.yaml")["plate_treadmill"]
    recording = own["recording"]
    assert recording["plates"] == {"left": [1], "right": [2]}
    assert own["belt"] == "right"
    assert recording["axes"]["forward"] == "+y"
    assert recording["belt_velocity"]["channel"] == "Belt speed"
    assert recording["belt_velocity"]["m_per_s_per_unit"] == pytest.approx(0.5, rel=0.01)
    assert recording["belt_velocity"]["offset"] == pytest.approx(2.5, abs=0.01)
    text = (tmp_path / "study" / "config.yaml").read_text()
    assert "trial_07.c3d that follows a low marker" in text
    whole = filled(settings(config, tmp_path / "study"))
    check_config(whole, "configuration")
    (row,) = read_trial_sheet(tmp_path / "study" / "trials.tsv", "mine").values()
    assert set(row.files) == {"log"}
    assert "taken for dummy by its content" in (tmp_path / "study" / "trials.tsv").read_text()


def test_c3d_without_a_channel_of_the_belt_takes_belt_fixed_markers(dummy_files, tmp_path):
    (tmp_path / "mine").mkdir()
    single_c3d(dummy_files, tmp_path / "mine" / "dummy.c3d", belt_velocity=False)
    new_study("mine", output="study")
    velocity = read_settings(tmp_path / "study" / "config.yaml")["plate_treadmill"]["recording"][
        "belt_velocity"
    ]
    assert velocity["channel"] is None
    assert velocity["markers"] == ["foot1", "foot2", "foot3"]


@pytest.mark.slow
def test_dflow_text_and_a_table_with_its_markers(dummy_files, tmp_path, root):
    (tmp_path / "flow").mkdir()
    (tmp_path / "tables").mkdir()
    file = single_c3d(dummy_files, tmp_path / "x.c3d")
    recording = read_c3d_recording(file)
    markers, plate = recording.markers, recording.plates[1]
    n = markers.positions.shape[0]
    six = np.hstack([plate.force, plate.moment])[::4][:n]
    turned = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # x right, y up, z backward
    points = {m: markers.positions[:, k] @ turned.T for k, m in enumerate(markers.labels)}
    loads = np.hstack([six[:, :3] @ turned.T, six[:, 3:] @ turned.T])
    write_mocap(tmp_path / "flow" / "Mocap0001.txt", 250.0, points, {1: 0.0 * loads, 2: loads})
    speed = -recording.channels["Belt speed"].values[::4][:n] * 0.5 + 1.25
    speeds = {"LeftBeltSpeed": 0.0 * speed, "RightBeltSpeed": speed}
    write_record(tmp_path / "flow" / "Record0001.txt", 208.0 + np.arange(n) / 250.0, speeds)
    assert new_study("flow", output="f").trials == {"dummy": 1}
    own = read_settings(tmp_path / "f" / "config.yaml")["plate_treadmill"]["recording"]
    assert own["axes"] == {"forward": "-z", "up": "+y"}
    assert own["plates"] == {"left": [1], "right": [2]}
    velocity = own["belt_velocity"]
    assert (velocity["channel"], velocity["m_per_s_per_unit"]) == ("RightBeltSpeed", -1.0)
    assert set(velocity["markers"]) <= {"foot1", "foot2", "foot3", "ankle"}
    (row,) = read_trial_sheet(tmp_path / "f" / "trials.tsv", "flow").values()
    assert row.files["log"].endswith("Record0001.txt")
    assert row.files["markers"].endswith("Mocap0001.txt")
    assert "`dflow.md`" in (tmp_path / "f" / "MISSING.md").read_text()

    header = "time (s),belt (m/s)," + ",".join(f"{c}_right" for c in ("Fx", "Fy", "Fz", "Mx", "My", "Mz"))
    table = np.column_stack([np.arange(n) / 250.0, -speed, six])
    np.savetxt(tmp_path / "tables" / "s3.csv", table, delimiter=",", header=header, comments="", fmt="%.5f")
    shutil.copy(dummy_files["markers"], tmp_path / "tables" / "s3.c3d")
    assert new_study("tables", output="t").trials == {"dummy": 1}
    own = read_settings(tmp_path / "t" / "config.yaml")["plate_treadmill"]["recording"]
    assert own["belt_velocity"]["channel"] == "belt"
    assert own["belt_velocity"]["m_per_s_per_unit"] == 1.0
    (row,) = read_trial_sheet(tmp_path / "t" / "trials.tsv", "tables").values()
    assert row.files["markers"].endswith("s3.c3d")


# ---- tables --------------------------------------------------------------------------------------


def test_wristalyzer_is_ready_to_run(wristalyzer_files, tmp_path, config, root):
    (tmp_path / "lab").mkdir()
    shutil.copy(wristalyzer_files["log"], tmp_path / "lab" / "s01_16.txt")
    shutil.copy(wristalyzer_files["command"], tmp_path / "lab" / "s01_16_cmd.txt")
    assert new_study("lab", name="wrist").missing == 0
    own = read_settings(tmp_path / "wrist" / "config.yaml")
    assert own["wristalyzer"]["analysis"]["perturbation_period_s"] == pytest.approx(10.0)
    assert own["wristalyzer"]["files"]["angle_unit"] == "rad"
    assert own["pathvars"]["results"] == "results"
    whole = settings(config, tmp_path / "wrist")
    refuse_placeholders(whole, "configuration")
    check_config(whole, "configuration")
    (row,) = read_trial_sheet(tmp_path / "wrist" / "trials.tsv", "lab").values()
    assert row.condition == "s01-16"
    assert row.files["command"].endswith("s01_16_cmd.txt")


def joint(path, sign, opened=open):
    rng = np.random.default_rng(5)
    time = np.arange(0.0, 20.0, 0.01)
    angle = 0.02 * np.convolve(rng.standard_normal(time.size), np.hanning(30) / 5.5, mode="same")
    torque = sign * (1.2 * np.gradient(angle, time) + 70.0 * angle)
    lines = ["Time (s)\tAnkle Angle [deg]\tAnkle Torque [Nm]"]
    lines += [f"{t:.3f}\t{x:.7g}\t{m:.7g}" for t, x, m in zip(time, np.degrees(angle), torque, strict=True)]
    with opened(path, "wt") as file:
        file.write("\n".join(lines) + "\n")


@pytest.mark.parametrize("sign", [1, -1])
def test_position_manipulator_in_other_units_and_signs(sign, tmp_path):
    (tmp_path / "lab").mkdir()
    joint(tmp_path / "lab" / "relaxed 1.tsv.gz", sign, gzip.open)
    assert new_study("lab", output="s").missing == 0
    own = read_settings(tmp_path / "s" / "config.yaml")["position_manipulator"]
    assert own["files"]["torque_sign"] == sign
    assert own["files"]["angle_unit"] == "deg"
    assert own["files"]["delimiter"] == "tab"
    assert own["files"]["columns"]["angle"] == "Ankle Angle [deg]"
    assert own["ingest"]["resample_rate_hz"] == pytest.approx(99.0)
    (row,) = read_trial_sheet(tmp_path / "s" / "trials.tsv", "lab").values()
    assert (row.condition, row.duration_s) == ("relaxed-1", 20.0)


def test_belt_tables_and_other_files(tmp_path):
    (tmp_path / "lab").mkdir()
    time = np.arange(0.0, 30.0, 0.01)
    for name in ("slow1", "slow2"):
        values = np.column_stack([time, np.sin(time), 1.0 + 0.1 * np.cos(time)])
        header = "Timestamp (s)\tPitch Moment (Nm)\tBelt Velocity (m/s)"
        np.savetxt(
            tmp_path / f"lab/{name}.txt", values, delimiter="\t", header=header, comments="", fmt="%.6f"
        )
    (tmp_path / "lab/notes.txt").write_text("recorded on Monday\n")
    made = new_study("lab", output="s")
    assert made.trials == {"belt": 2}
    assert [f.name for f in made.left] == ["notes.txt"]
    assert "notes.txt" in (tmp_path / "s" / "MISSING.md").read_text()
    rows = read_trial_sheet(tmp_path / "s" / "trials.tsv", "lab").values()
    assert [row.role for row in rows] == ["calibrate", "validate"]


def test_people_get_a_table_of_their_own(tmp_path):
    people = {f"{name}/relax.c3d": None for name in ("P01", "P-02")}
    rng = np.random.default_rng(3)
    n, plate = 1000, plate_of("right")
    for file in people:
        path = tmp_path / "lab" / file
        path.parent.mkdir(parents=True)
        moved = np.cumsum(0.001 * (np.arange(n) % 250 < 20))
        heights = {"TOE": 0.02, "HEEL": 0.03, "ANK": 0.08, "SHA1": 0.3, "SHA2": 0.4, "THI1": 0.6, "THI2": 0.8}
        markers = {
            label: np.column_stack([np.zeros(n), moved, np.full(n, z)]) + 1e-4 * rng.standard_normal((n, 3))
            for label, z in heights.items()
        }
        force = np.array([0.0, 0.0, 700.0]) + rng.standard_normal((4 * n, 3))
        write_c3d(path, 100.0, markers, plate_channels(plate, force, np.zeros((4 * n, 3))), [plate], 400.0)
    made = new_study("lab", output="s")
    assert made.trials == {"standing": 2}
    assert made.files == (*FILES, "participants.tsv", RULES, PROFILE, REQUIRED)
    assert read_settings(tmp_path / "s" / "config.yaml")["study"]["participants"] == "participants.tsv"
    rows = read_trial_sheet(tmp_path / "s" / "trials.tsv", "lab")
    assert [(row.condition, row.participant, row.task) for row in rows.values()] == [
        ("P-02-relax", "P02", "relax"),
        ("P01-relax-1", "P01", "relax"),
    ]
    with pytest.raises(
        ValueError, match=r"participants.tsv: line 2: expected a value for 'mass_kg'.*MISSING"
    ):
        read_participants(tmp_path / "s" / "participants.tsv")
    text = (tmp_path / "s" / "participants.tsv").read_text()
    assert text.startswith("participant\tmass_kg\tstature_m")
    assert "the plates show 71.4 kg" in (tmp_path / "s" / "MISSING.md").read_text()
    assert "mass_kg" not in (tmp_path / "s" / "config.yaml").read_text()


@pytest.mark.slow
def test_recordings_made_by_others(real_data, tmp_path):
    (tmp_path / "ankle").mkdir()
    shutil.copy(real_data("human-ankle/ankle_trial1.csv.gz"), tmp_path / "ankle")
    assert new_study("ankle", output="a").missing == 0
    files = read_settings(tmp_path / "a" / "config.yaml")["position_manipulator"]["files"]
    assert (files["torque_sign"], files["angle_unit"]) == (-1, "rad")
    (row,) = read_trial_sheet(tmp_path / "a" / "trials.tsv", "ankle").values()
    assert row.duration_s == 60.0
    for name, words in (
        ("HC002D02", "no pulses of the belt"),
        ("HC002D06", "by the events Left Foot Strike, Left Foot Off"),
        ("Qualisys", "by the events LHS, LTO"),
        ("Gait", "by the name"),
    ):
        (tmp_path / name).mkdir()
        shutil.copy(real_data(f"c3d/{name}.c3d"), tmp_path / name)
        with pytest.raises(InputError, match=words):
            new_study(name, output="w")


# ---- nothing is overwritten ----------------------------------------------------------------------


def test_nothing_is_overwritten(tmp_path, capsys):
    (tmp_path / "lab").mkdir()
    joint(tmp_path / "lab" / "a.tsv", 1)
    (tmp_path / "s").mkdir()
    (tmp_path / "s" / "MISSING.md").write_text("mine")
    before = digests(tmp_path)
    assert main(["new-study", "lab", "--output", "s"]) == 2
    said = capsys.readouterr().err
    assert "MISSING.md: expected no such file" in said
    assert said.count("\n") == 1
    assert digests(tmp_path) == before
    assert main(["new-study", "lab", "--name", "two words"]) == 2
    assert main(["new-study", "nowhere"]) == 2
    (tmp_path / "empty").mkdir()
    assert main(["new-study", "empty"]) == 2
    (tmp_path / "empty" / "a.docx").write_text("x")
    assert main(["new-study", "empty"]) == 2
    assert "a.docx" in capsys.readouterr().err
    assert digests(tmp_path).keys() - before.keys() == {tmp_path / "empty" / "a.docx"}
    assert main(["new-study", "lab"]) == 0
    said = capsys.readouterr().out
    assert "  cd lab-study\n" in said and "tepsipe run\n" in said
    written = {p.relative_to(tmp_path / "lab-study").as_posix() for p in digests(tmp_path / "lab-study")}
    assert written == {*FILES, RULES, PROFILE, REQUIRED}


def test_a_study_elsewhere_names_its_own_files_and_no_place_of_the_rules(tmp_path, root):
    folder = tmp_path / "lab & (co)"
    folder.mkdir()
    joint(folder / "joint.tsv", 1)
    for output in (tmp_path / 'a "b" $(c)', tmp_path / "lab & (co)/deep/er"):
        new_study(folder, "knee", output)
        assert not any(str(root) in path.read_text() for path in digests(output))
        assert version_of(output / REQUIRED) == __version__
        own = read_settings(output / "config.yaml")
        assert own["pathvars"] == {"results": "results", "logs": "results/logs"}
        assert (output / own["study"]["recordings_folder"]).resolve() == folder
        assert (output / own["study"]["trial_sheet"]).is_file()
        assert read_settings(output / PROFILE) == read_settings(root / PROFILE) | {
            "configfile": ["config.yaml"]
        }


@pytest.mark.parametrize("name", ["a\nb.tsv", "a\tb.tsv", "a\x1b[31m.tsv"])
def test_a_file_whose_name_breaks_the_sheet_is_left_out(name, tmp_path):
    (tmp_path / "lab").mkdir()
    joint(tmp_path / "lab" / name, 1)
    joint(tmp_path / "lab/good.tsv", 1)
    made = new_study("lab", output="s")
    assert made.trials == {"position_manipulator": 1}
    (left,) = made.left
    assert left.name.isprintable() and "rename it" in left.why
    assert len((tmp_path / "s/trials.tsv").read_text().splitlines()) == 2


def test_unusable_files_are_listed_and_do_not_stop_it(dummy_files, tmp_path, recwarn):
    folder = tmp_path / "lab"
    folder.mkdir()
    whole = single_c3d(dummy_files, tmp_path / "whole.c3d")
    (folder / "cut.c3d").write_bytes(whole.read_bytes()[:40_000])
    (folder / "log.mat").write_bytes(dummy_files["log"].read_bytes()[:5000])
    (folder / "short.csv").write_text("time_s,angle_rad,torque_Nm\n0,1,2\n1,2,3\n")
    (folder / "empty.csv").write_text("")
    (folder / "noise.edf").write_bytes(bytes(range(256)) * 20)
    hidden = {"foot": np.full((100, 3), np.nan), "leg": np.full((100, 3), np.nan)}
    hidden["leg"][40] = [0.1, 0.2, 0.9]
    loads = {f"F{k}": (np.full(400, 10.0), "N" if k < 3 else "Nmm") for k in range(6)}
    write_c3d(
        folder / "hidden.c3d", 100.0, hidden, loads, [Plate(plate_of("left").corners_m, tuple(loads))], 400.0
    )
    joint(folder / "joint.tsv", 1)
    made = new_study("lab", output="s")
    assert made.trials["position_manipulator"] == 1
    unusable = {"cut.c3d", "log.mat", "short.csv", "empty.csv", "noise.edf", "hidden.c3d"}
    assert {f.name for f in made.left} == unusable
    missing = (tmp_path / "s" / "MISSING.md").read_text()
    assert "`cut.c3d`: expected" in missing
    assert "`short.csv`: a recording has at least 20 samples" in missing
    assert not [w for w in recwarn if "tepsipe" in str(w.filename)]


def test_placeholders_and_comments_of_the_sheet(tmp_path):
    header = "experiment\tcondition\tsource\tprofile\tamplitude\tinterval_s\tduration_s\tlog\tcommand"
    header += "\tcalibration\tmarkers\n"
    row = "position_manipulator\ta\trecorded\t-\t-\t-\t{}\ta.csv\t-\t-\t-\n"
    sheet = tmp_path / "trials.tsv"
    sheet.write_text(header + "# a guess: with\ttabs\n" + row.format("60"))
    assert len(read_trial_sheet(sheet, ".")) == 1
    sheet.write_text(header + "# a guess\n" + row.format("MISSING"))
    with pytest.raises(ValueError, match=r"line 3.*'duration_s'.*MISSING"):
        read_trial_sheet(sheet, ".")


# ---- parts ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "key"),
    [
        ("dummy/sine-0.3/log.mat", "sine-0.3"),
        ("P01_relax_markers.c3d", "P01-relax"),
        ("s01_16_cmd.txt.gz", "s01-16"),
        ("log.mat", "trial"),
        ("Müde Probe groß 1.csv", "Mude-Probe-gross-1"),
        ("Weight_sine_mocap0003.txt", "Weight-sine-0003"),
    ],
)
def test_name_of_a_trial(name, key):
    assert key_of(name) == key


def test_columns_and_experiments_by_name():
    found = columns_by_role(["Timestamp (s)", "Pitch Moment (Nm)", "Belt Velocity (m/s)", "Fy"])
    assert found == {
        "time": "Timestamp (s)",
        "torque": "Pitch Moment (Nm)",
        "velocity": "Belt Velocity (m/s)",
        "force": "Fy",
    }
    assert experiment_by_name("data/Empty belt/run_1.mat") == "empty"
    assert experiment_by_name("data/run_1.mat") is None
    muscles, others = muscles_of(["Voltage.L Tib Ant", "L Sol", "MG", "Biceps fem", "RF", "Trapezius"])
    assert list(muscles) == ["TA", "SOL", "GAS", "BF", "RF"]
    assert others == ["Trapezius"]


def test_files_of_other_names_are_paired_by_length(dummy_files, tmp_path):
    (tmp_path / "lab").mkdir()
    for kind, path in dummy_files.items():
        shutil.copy(
            path,
            tmp_path / "lab" / f"{ {'log': 'run7', 'markers': 'capture 3'}.get(kind, kind) }{path.suffix}",
        )
    groups, left = group_files(look_at(tmp_path / "lab"))
    (group,) = groups
    assert set(group.partners) == {"calibration", "markers"}
    assert "capture 3.c3d taken as its markers file by name and length" in group.notes
    assert left == []


def test_pulses_and_rests():
    velocity = np.zeros(4000)
    for start in (500, 1300, 2100):
        velocity[start : start + 40] = 0.3
    pulses = pulses_of(velocity, 200.0)
    assert (pulses.count, pulses.shortest_s) == (3, 4.0)
    assert pulses.first_s == pytest.approx(2.5, abs=0.02)  # half of the average over 0.04 s
    before, after = rests(pulses, 20.0)
    assert before == pytest.approx(2.4, abs=0.11)
    assert after == pytest.approx(20.0 - 10.695 - 4.0, abs=0.11)
    assert pulses_of(np.sin(np.arange(4000) / 50.0), 200.0) is None
    assert pulses_of(np.zeros(100), 200.0) is None


def test_noise_of_slow_cameras_hides_neither_pulses_nor_the_markers_on_the_belt(rng):
    """Noise of 0.3 mm at 100 Hz exceeds a fifth of pulses of 0.15 m/s in the velocity of a marker."""
    time = np.arange(0.0, 40.0, 0.01)
    velocity = sum(0.15 * np.exp(-(((time - t) / 0.06) ** 2)) for t in np.arange(5.0, 35.0, 3.0))
    path = np.cumsum(velocity) * 0.01

    def noisy(x):
        return x + 0.0003 * rng.standard_normal(x.size)

    found = pulses_of(smooth_velocity(noisy(path), 100.0), 100.0)
    assert (found.count, rests(found, 40.0)[0]) == (10, pytest.approx(4.8, abs=0.11))
    for share, low, high in ((1.0, 0.95, 1.05), (0.7, 0.65, 0.75)):
        r, scale = moves_with(noisy(share * path), velocity, 100.0, found)
        assert r > 0.99 and low < scale < high
    assert moves_with(noisy(np.zeros(time.size)), velocity, 100.0, found)[0] < 0.5
    assert pulses_of(smooth_velocity(noisy(np.zeros(time.size)), 100.0), 100.0) is None
    few = pulses_of(velocity, 100.0)
    assert (few.count, few.shortest_s) == (found.count, pytest.approx(found.shortest_s, abs=0.1))


def test_scale_of_a_noisy_and_delayed_channel(rng):
    time = np.arange(0.0, 20.0, 0.004)
    motion = sum(0.4 * np.exp(-(((time - t) / 0.03) ** 2)) for t in (2.0, 7.0, 13.0))
    channel = np.interp(time - 0.0033, time, motion) / 0.8 + 2.5 + 0.005 * rng.standard_normal(time.size)
    assert follows(motion, channel)[0] > 0.98
    assert scale_of(motion, channel, 250.0) == pytest.approx(0.8, rel=0.005)


def test_period_sign_and_levels(rng):
    period = rng.standard_normal(512)
    assert period_s(np.tile(period, 5), 256.0) == 2.0
    assert period_s(rng.standard_normal(2560), 256.0) is None
    angle = np.convolve(rng.standard_normal(5000), np.hanning(40), mode="same")
    assert resisting_sign(angle, -3.0 * angle, 100.0) == -1
    assert is_two_levels(np.repeat([0.0, 5.0, 0.0], 500))
    assert not is_two_levels(rng.standard_normal(1500))


def test_text_of_settings_is_read_back():
    plan = Plan()
    values = {
        "a": "Time",
        "b": "yes",
        "c": "x: y # z",
        "d": 0.1,
        "e": None,
        "f": [1, "+y"],
        "g": -1,
        "h": "1e3",
    }
    for key, value in values.items():
        plan.put(f"s.t.{key}", value, "found in a file: #1")
    plan.put("s.markers", [({"label": "A 1", "x_m": "MISSING"}, "why"), {"label": "B", "x_m": 0.0}])
    found = yaml.safe_load("\n".join(yaml_text(plan.tree)))
    assert found["s"]["t"] == values
    assert found["s"]["markers"] == [{"label": "A 1", "x_m": "MISSING"}, {"label": "B", "x_m": 0.0}]
    assert flow({"k": [True, "no"]}) == '{k: [true, "no"]}'
    for number in (1e-5, -2.5e-7, 2e20, 0.1):  # YAML takes 1e-05 for a text
        assert yaml.safe_load(flow(number)) == number
