"""Folders as other laboratories have them: axes, labels, gait, and what can be no trial."""

import re

import ezc3d
import numpy as np
import pytest
from c3d_builders import plate_channels, plate_of, write_c3d
from laboratory_folders import Y_UP, laboratory, mark, trial_of

from tepsipe.errors import InputError
from tepsipe.experiments.walking.files import read_events
from tepsipe.io.formats import contents_of
from tepsipe.io.readers.c3d import read_c3d_recording
from tepsipe.io.readers.recording import Markers, select_markers
from tepsipe.new_study.study import new_study
from tepsipe.new_study.treadmill_trials import contacts_of, leg_of, loaded_mean, muscles_of, side_of
from tepsipe.virtual_lab.dummy_trial import make_dummy_trial
from tepsipe.virtual_lab.treadmill_trial import Protocol
from tepsipe.virtual_lab.weight_trial import make_weight_trial
from workflow.support.yaml_file import read_settings

RATE_HZ, SECONDS = 100.0, 20.0
# forward and up (m) of the markers of plug-in-gait, without the leg
PLUG_IN_GAIT = {"TOE": (0.18, 0.03), "HEE": (-0.06, 0.03), "ANK": (0.0, 0.08), "TIB": (0.02, 0.3)}
PLUG_IN_GAIT |= {"KNE": (0.0, 0.48), "THI": (0.02, 0.65), "ASI": (0.05, 0.95), "PSI": (-0.1, 0.95)}


def person(
    path,
    axes=None,
    emg=(),
    labels="LR",
    pulses=4,
    begins=None,
    load=700.0,
    events=(),
    facing=1.0,
    belts=("right",),
    subject="",
    on=("right",),
    speed=False,
):
    """A C3D of a person on the right belt, as plug-in-gait labels markers; ``axes`` are those of the file."""
    axes, n = np.eye(3) if axes is None else axes, round(RATE_HZ * SECONDS)
    rng, time = np.random.default_rng(3), np.arange(n) / RATE_HZ
    begins = np.arange(4.0, 16.0, 3.0)[:pulses] if begins is None else begins
    belt = sum((0.02 * np.clip((time - t) / 0.1, 0.0, 1.0) for t in begins), np.zeros(n))
    markers = {}
    for side in labels:
        for name, (forward, up) in PLUG_IN_GAIT.items():
            moved = belt * max(0.0, 1.0 - up)
            place = np.column_stack(
                [np.full(n, 0.1 * (side == "R")), facing * forward + moved, np.full(n, up)]
            )
            markers[subject + side + name] = (place + 1e-4 * rng.standard_normal((n, 3))) @ axes.T
    plates, channels = [], {}
    for belt in belts:
        plate = plate_of(belt)
        force = rng.standard_normal((4 * n, 3))
        force[:, 2] += load / len(on) * (belt in on)
        channels |= plate_channels(plate, force, np.zeros_like(force))
        plates.append(type(plate)(plate.corners_m @ axes.T, plate.channels, plate.kind, plate.origin_m))
    channels |= {label: (1e-3 * rng.standard_normal(4 * n), "V") for label in emg}
    if speed:
        moving = np.subtract.outer(np.arange(4 * n) / (4 * RATE_HZ), begins)
        velocity = 0.2 * ((moving > 0.0) & (moving < 0.1)).any(axis=1)
        channels["Belt speed"] = (velocity + 1e-3 * rng.standard_normal(4 * n), "m/s")
    write_c3d(path, RATE_HZ, markers, channels, plates, 4 * RATE_HZ)
    if events:
        mark(path, events)
    return path


def settings_of(folder):
    return read_settings(folder / "config.yaml")


def test_a_file_with_y_up_and_the_left_leg(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    person(tmp_path / "lab/relax_1.c3d", Y_UP, emg=("EMG.L_TA", "EMG.L_SOL", "EMG.L_GM"))
    facts = contents_of(tmp_path / "lab/relax_1.c3d").facts
    assert facts["upward"] == "+y"
    assert "mean vertical force 700.0 N" in facts["force plate 1"]
    assert new_study("lab", output="s").trials == {"standing": 1}
    own = settings_of(tmp_path / "s")
    assert own["plate_treadmill"]["recording"]["axes"] == {"forward": "-z", "up": "+y"}
    standing = own["standing"]
    assert {m: c["channel"] for m, c in standing["muscles"].items()} == {
        "TA": "EMG.L_TA",
        "SOL": "EMG.L_SOL",
        "GAS": "EMG.L_GM",
    }
    assert standing["emg"]["band_hz"] == [20.0, 180.0]
    segments = {
        part: [m["label"] for m in standing["person"][f"{part}_markers"]]
        for part in ("foot", "shank", "thigh")
    }
    assert segments == {
        "foot": ["LTOE", "LHEE", "LANK"],
        "shank": ["LANK", "LTIB"],
        "thigh": ["LKNE", "LTHI"],
    }
    missing = (tmp_path / "s/MISSING.md").read_text()
    assert "the plates show 71.4 kg" in (tmp_path / "s/config.yaml").read_text()
    assert "the left leg was assumed: the only leg of the electromyograms" in missing


@pytest.mark.parametrize("axes", [np.eye(3), Y_UP, np.roll(np.eye(3), 1, axis=0), np.diag([1.0, -1.0, -1.0])])
def test_upward_direction_of_a_file(axes, tmp_path):
    recording = read_c3d_recording(person(tmp_path / "a.c3d", axes))
    up = axes @ [0.0, 0.0, 1.0]
    axis = int(np.argmax(np.abs(up)))
    assert recording.up == f"{'+' if up[axis] > 0.0 else '-'}{'xyz'[axis]}"


def test_without_plates_the_screen_shows_the_vertical(tmp_path):
    marker = np.abs(np.random.default_rng(1).normal(size=(50, 3)))
    path = write_c3d(tmp_path / "a.c3d", 100.0, {"A": marker}, {})
    file = ezc3d.c3d(str(path))
    file.add_parameter("POINT", "Y_SCREEN", ["+Y"])
    file.write(str(path))
    assert read_c3d_recording(path).up == "+y"


GAIT = [
    (side, label, 0.5 + k * 0.7 + 0.35 * (side == "Right") + 0.45 * (label == "Foot Off"))
    for k in range(26)
    for side in ("Left", "Right")
    for label in ("Foot Strike", "Foot Off")
]


def test_gait_by_its_events(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    person(tmp_path / "lab/subject_1.c3d", emg=("EMG.L_TA",), events=GAIT)
    assert new_study("lab", output="s").trials == {"walking": 1}
    walking = settings_of(tmp_path / "s")["walking"]
    assert walking["events"] == {"heel_strike": "Left Foot Strike", "toe_off": "Left Foot Off", "pulse": None}
    assert walking["recording"]["markers"] == {"ankle": "LANK", "knee": "LKNE", "heel": "LHEE", "toe": "LTOE"}
    assert (tmp_path / "s/trials.tsv").read_text().count(
        "subject_1.c3d"
    ) == 2  # the log holds the events, too
    with pytest.raises(InputError, match=r"subject_1\.c3d: expected events labelled 'Left Foot'"):
        read_events("lab/subject_1.c3d", {"heel_strike": "Left Foot"})
    events = [event for event in GAIT if event[2] < 5.0]
    person(tmp_path / "lab/subject_1.c3d", events=events)
    with pytest.raises(InputError, match=r"who walks \(by the events Left Foot Strike, .*\), found 6: "):
        new_study("lab", output="t")
    (tmp_path / "t").write_text("mine")
    with pytest.raises(InputError, match="t: expected a folder to write to, found a file"):
        new_study("lab", output="t")


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("quiet.c3d", {"pulses": 0}, "no pulses of the belt with rests between them"),
        ("relax_aborted.c3d", {"pulses": 1}, "expected at least 4 pulses of the belt, found 1 in 20 s"),
        ("relax.c3d", {"labels": ""}, "are in its channels, and it holds no markers"),
        (
            "relax.c3d",
            {"labels": "", "speed": True},
            "but it holds no markers: export the file with its points",
        ),
        ("walking_1.c3d", {}, r"walks \(by the name\), found 0: "),
    ],
)
def test_what_can_be_no_trial_is_said_before_any_question(name, options, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    person(tmp_path / "lab" / name, **options)
    with pytest.raises(InputError, match=words) as caught:
        new_study("lab", output="s")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "s").exists()


@pytest.mark.parametrize(
    ("label", "side"),
    [
        ("LKNE", "left"),
        ("R_FCC", "right"),
        ("Anna:RTOE", "right"),
        ("EMG.L_TA", "left"),
        ("Voltage.R Tib Ant", "right"),
        ("knee_left", "left"),
        ("RGM", "right"),
        ("leg1", ""),
        ("RF", ""),
        ("LOAD", ""),
        ("SACR", ""),
    ],
)
def test_side_of_a_label(label, side):
    assert side_of(label) == side


def test_muscles_of_the_recorded_leg():
    labels = ["EMG.R_TA", "EMG.L_TA", "EMG.L_GM", "Sync_1"]
    assert muscles_of(labels, "left") == ({"TA": "EMG.L_TA", "GAS": "EMG.L_GM"}, ["EMG.R_TA", "Sync_1"])
    assert leg_of(labels, ["LANK"]) == ("left", "the only leg of the markers")
    delsys = ["L TIB ANT: EMG 1", "L TIB ANT: ACC.X 1", "Soleus_L: EMG 1", "GM left: EMG 1"]
    assert list(muscles_of(delsys, "left")[0].values()) == [delsys[0], *delsys[2:]]
    assert leg_of(delsys, [])[0] == "left"
    assert leg_of(labels, ["LANK", "RANK"])[0] == "right"


def test_loads_and_steps_of_a_plate(rng):
    force = np.repeat([0.0, 600.0, 0.0, 650.0, 0.0], 200) + rng.standard_normal(1000)
    assert loaded_mean(force) == pytest.approx(625.0, abs=1.0)
    assert contacts_of(force) == 2
    assert contacts_of(np.full(1000, 700.0)) == 0
    assert contacts_of(rng.standard_normal(1000)) == 0


# ---- weights, belts and slow cameras -----------------------------------------------------------------


def loaded_belt(
    path,
    kg,
    belt="right",
    peak=0.3,
    markers=("W1", "W2", "W3"),
    channels_of_belts=False,
    channel=True,
    every_s=3.0,
):
    """A C3D of a weight on one of two belts, or of the empty belt, with a channel of the belt's speed."""
    n, rng = round(RATE_HZ * SECONDS), np.random.default_rng(4)
    fast = np.arange(4 * n) / (4 * RATE_HZ)
    speed = sum(peak * np.exp(-(((fast - t) / 0.03) ** 2)) for t in np.arange(4.0, 16.0, every_s))
    moved = np.cumsum(speed)[::4] / (4 * RATE_HZ)
    places = {m: 0.05 * k for k, m in enumerate(markers)}
    positions = {
        label: np.column_stack([np.full(n, x), moved, np.full(n, 0.1 + x)])
        + 1e-4 * rng.standard_normal((n, 3))
        for label, x in places.items()
    }
    plates, channels = [plate_of("left"), plate_of("right")], {}
    if channel:
        channels = {"Belt speed": (speed / 0.5 + 2.5, "V")}
    if channels_of_belts:
        noise = 1e-3 * rng.standard_normal(4 * n)
        channels = {f"Speed {b}": ((speed if b == belt else noise) / 0.5, "V") for b in ("left", "right")}
    for plate, own in zip(plates, ("left", "right"), strict=True):
        force = rng.standard_normal((4 * n, 3))
        force[:, 2] += 9.81 * kg * (own == belt)
        channels |= plate_channels(plate, force, np.zeros_like(force))
    return write_c3d(path, RATE_HZ, positions, channels, plates, 4 * RATE_HZ)


def sheet_of(folder):
    header, *lines = [
        line.split("\t") for line in (folder / "trials.tsv").read_text().splitlines() if line[0] != "#"
    ]
    return [dict(zip(header, line, strict=True)) for line in lines]


def test_two_weights_have_masses_roles_and_conditions_of_their_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    for name, kg in (("weight20kg", 20.0), ("weight75kg", 75.0), ("empty", 0.0)):
        for number in ("01", "02"):
            loaded_belt(tmp_path / f"lab/{name}_{number}.c3d", kg, markers=("W1", "W2") if kg else ())
    assert new_study("lab", output="s").trials == {"weight": 4, "empty": 2}
    rows = {
        (row["experiment"], row["condition"]): (row["role"], row["mass_kg"])
        for row in sheet_of(tmp_path / "s")
    }
    assert rows == {
        ("weight", "01"): ("calibrate", "-"),
        ("weight", "02"): ("validate", "-"),
        ("weight", "01-75kg"): ("calibrate", "MISSING"),
        ("weight", "02-75kg"): ("validate", "MISSING"),
        ("empty", "01"): ("calibrate", "-"),
        ("empty", "02"): ("validate", "-"),
    }
    weight = settings_of(tmp_path / "s")["weight"]
    assert weight["further_weights"] == [
        {"mass_kg": "MISSING", "com_height_m": "MISSING", "com_forward_of_markers_m": None}
    ]
    assert "family" not in weight.get("models", {})
    config, missing = ((tmp_path / "s" / name).read_text() for name in ("config.yaml", "MISSING.md"))
    assert "mass_kg: MISSING # the plate shows 20.0 kg: 01, 02" in config
    assert "the plate shows 75.0 kg: 01-75kg, 02-75kg" in config
    assert "`trials.tsv, weight/01-75kg, mass_kg`" in missing


def test_motions_that_differ_are_not_subtracted(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    for number, peak in (("01", 0.3), ("02", 0.3)):
        loaded_belt(tmp_path / f"lab/weight_{number}.c3d", 20.0, peak=peak)
        loaded_belt(tmp_path / f"lab/empty_{number}.c3d", 0.0, peak=2.0 * peak, markers=())
    new_study("lab", output="s")
    assert "mean-subtraction" not in settings_of(tmp_path / "s")["weight"]["models"]["family"]
    assert "the empty belt moves at 0.6 m/s, not 0.3 m/s" in (tmp_path / "s/MISSING.md").read_text()


def test_a_weight_without_the_empty_belt_is_left_out(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    loaded_belt(tmp_path / "lab/weight_01.c3d", 20.0)
    person(tmp_path / "lab/relax_01.c3d")
    assert new_study("lab", output="s").trials == {"standing": 1}
    assert "found 0 of the empty belt and 1 of one weight" in (tmp_path / "s/MISSING.md").read_text()


def test_a_weight_on_another_belt_than_the_person_is_left_out(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    for number in ("01", "02"):
        loaded_belt(tmp_path / f"lab/weight_{number}.c3d", 20.0, "left")
        loaded_belt(tmp_path / f"lab/empty_{number}.c3d", 0.0, "left", markers=())
    person(tmp_path / "lab/relax_01.c3d", belts=("left", "right"))
    assert new_study("lab", output="s").trials == {"standing": 1}
    assert settings_of(tmp_path / "s")["standing"]["recommended"]["pathway"] == "ankle"
    why = "the weight was on the left belt, and relax_01.c3d is on the right one"
    assert (tmp_path / "s/MISSING.md").read_text().count(why) == 4


def test_each_experiment_has_its_own_belt_fixed_markers(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    for number in ("01", "02"):
        for name, kg, labels in (("weight", 20.0, "WX"), ("empty", 0.0, "EF")):
            path = tmp_path / f"lab/{name}_{number}.c3d"
            loaded_belt(path, kg, markers=[f"{label}1" for label in labels], channel=False)
    new_study("lab", output="s")
    plate = settings_of(tmp_path / "s")["plate_treadmill"]
    assert plate["recording"]["belt_velocity"] == {"channel": None, "markers": ["W1", "X1"]}
    whole = {"channel": None, "m_per_s_per_unit": None, "offset": 0.0, "markers": ["E1", "F1"]}
    assert plate["exceptions"] == {"empty": {"recording": {"belt_velocity": whole}}}


def test_one_reversed_channel_does_not_decide_the_scale_of_all(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    for number in range(1, 5):
        loaded_belt(tmp_path / f"lab/dummy_{number}.c3d", 3.0)
    file = ezc3d.c3d("lab/dummy_1.c3d")
    labels = file["parameters"]["ANALOG"]["LABELS"]["value"]
    file["data"]["analogs"][0, labels.index("Belt speed")] *= -1.0
    file.write("lab/dummy_1.c3d")
    new_study("lab", output="s")
    velocity = settings_of(tmp_path / "s")["plate_treadmill"]["recording"]["belt_velocity"]
    assert velocity["m_per_s_per_unit"] == pytest.approx(0.5, rel=0.05)
    missing = (tmp_path / "s/MISSING.md").read_text()
    assert "this scale was assumed for 'dummy_1.c3d', too, whose markers deny it" in missing


def test_windows_of_the_foot_end_before_the_next_pulse(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    loaded_belt(tmp_path / "lab/dummy_slow.c3d", 3.0)
    new_study("lab", output="slow")
    assert "pathways" not in settings_of(tmp_path / "slow")["dummy"]["foot"]
    loaded_belt(tmp_path / "lab/dummy_fast.c3d", 3.0, every_s=1.5)
    new_study("lab", output="fast")
    pathways = settings_of(tmp_path / "fast")["dummy"]["foot"]["pathways"]
    assert pathways == {name: {"window_s": 1.4} for name in ("foot-long", "foot-compensated")}


def test_belts_are_named_where_trials_are_on_both(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    for belt in ("left", "right"):
        for number in ("01", "02"):
            loaded_belt(tmp_path / f"lab/weight_{belt}_{number}.c3d", 20.0, belt)
            loaded_belt(tmp_path / f"lab/empty_{belt}_{number}.c3d", 0.0, belt, markers=())
    new_study("lab", output="s")
    rows = sheet_of(tmp_path / "s")
    assert [row["belt"] for row in rows] == ["left", "left", "right", "right"] * 2
    # each belt is calibrated and validated, whatever the names of the files begin with
    assert [row["role"] for row in rows] == ["calibrate", "validate"] * 4


def test_weights_of_one_belt_are_kept_for_a_person_on_both(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    for number in ("01", "02"):
        loaded_belt(tmp_path / f"lab/weight_{number}.c3d", 20.0, "left")
        loaded_belt(tmp_path / f"lab/empty_left_{number}.c3d", 0.0, "left", markers=())
    person(tmp_path / "lab/relax_01.c3d", belts=("left", "right"), on=("left", "right"))
    assert new_study("lab", output="s").trials == {"weight": 2, "empty": 2, "standing": 1}
    assert [row["belt"] for row in sheet_of(tmp_path / "s")] == ["left"] * 4 + ["both"]


def test_belts_of_logs_are_told_by_loads_and_names(shipped_truth, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    truth, folders = laboratory(shipped_truth), []
    for belt in ("left", "right"):
        for number in ("1", "2"):
            for name in ("weight", "empty"):
                folder = tmp_path / "lab" / f"{name}-{belt}{number}"
                folder.mkdir(parents=True)
                folders.append(folder)
                files = {"log": folder / "log.mat", "calibration": folder / "calibration.csv"}
                files |= {"markers": folder / "markers.c3d"} if name == "weight" else {}
                make_weight_trial(truth, folder.name, Protocol("sine", 0.4, 2.0, 10.0), files, belt)
    for study, of_empty in (("named", ["left", "left", "right", "right"]), ("unnamed", ["MISSING"] * 4)):
        assert new_study("lab", output=study).trials == {"weight": 4, "empty": 4}
        rows = sheet_of(tmp_path / study)
        assert [row["belt"] for row in rows[:4]] == ["left", "left", "right", "right"]
        assert [row["role"] for row in rows[:4]] == ["calibrate", "validate"] * 2
        assert [row["belt"] for row in rows[4:]] == of_empty
        for folder in folders:  # a name that tells no belt
            if folder.exists():
                folder.rename(folder.with_name(re.sub(r"(left|right)", lambda m: m[0][0], folder.name)))


def test_forward_is_where_the_toes_of_a_person_are_though_a_weight_comes_first(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    for name in ("empty_01", "weight_01", "weight_02"):
        loaded_belt(
            tmp_path / f"lab/{name}.c3d", 20.0 * (name[0] == "w"), markers=("W1", "W2") * (name[0] == "w")
        )
    person(tmp_path / "lab/relax_01.c3d", facing=-1.0, belts=("left", "right"))
    new_study("lab", output="s")
    own = settings_of(tmp_path / "s")
    assert own["plate_treadmill"]["recording"]["axes"]["forward"] == "-y"
    assert own["standing"]["free_reflex"]["lowpass_cutoff_hz"] == 40.0
    assert own["standing"]["analysis"]["stretch_cutoff_hz"] == 40.0


def test_each_belt_has_its_own_channel_of_the_velocity(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    for belt in ("left", "right"):
        for number in ("01", "02"):
            for name, kg, markers in (("weight", 20.0, ("W1", "W2")), ("empty", 0.0, ())):
                path = tmp_path / f"lab/{name}_{belt}_{number}.c3d"
                loaded_belt(path, kg, belt, markers=markers, channels_of_belts=True)
    new_study("lab", output="s")
    recording = settings_of(tmp_path / "s")["plate_treadmill"]["recording"]
    usual = recording["belt_velocity"]["channel"]
    assert recording["belt_velocity"]["m_per_s_per_unit"] == pytest.approx(0.5, rel=0.01)
    channels = {row["belt"]: set() for row in sheet_of(tmp_path / "s")}
    for row in sheet_of(tmp_path / "s"):
        channels[row["belt"]].add(usual if row["velocity_column"] == "-" else row["velocity_column"])
    assert channels == {"left": {"Speed left"}, "right": {"Speed right"}}
    missing = (tmp_path / "s/MISSING.md").read_text()
    assert "`weight.weight.com_forward_of_markers_m` | null was assumed" in missing


def test_tables_of_a_german_spreadsheet(tmp_path, monkeypatch):
    """Semicolons, decimal commas, degrees by their sign, seconds of the computer's clock."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    rng, time = np.random.default_rng(1), np.arange(0.0, 30.0, 0.005)
    angle = 0.5 * np.convolve(rng.standard_normal(time.size), np.hanning(40) / 6.0, mode="same")
    velocity = np.gradient(angle, time)
    torque = np.radians(0.01 * np.gradient(velocity, time) + velocity + 60.0 * angle)
    rows = np.column_stack([1.7e9 + time, angle, torque + 0.01 * rng.standard_normal(time.size)])
    text = "\n".join(";".join(f"{x:.7f}" for x in row) for row in rows).replace(".", ",")
    (tmp_path / "lab/Versuch 1.csv").write_text(
        f"Zeit [s];Winkel [°];Drehmoment [Nm]\r\n{text}\n", "utf-8-sig"
    )
    (tmp_path / "lab/~$Protokoll.xlsx").write_bytes(b"\5")
    new_study("lab", output="s")
    files = settings_of(tmp_path / "s")["position_manipulator"]["files"]
    assert files["columns"] == {"time": "Zeit [s]", "angle": "Winkel [°]", "torque": "Drehmoment [Nm]"}
    assert (files["delimiter"], files["angle_unit"], files["torque_sign"]) == ("semicolon", "deg", 1)


def joint(path, columns, seconds=20.0):
    """A table of a joint: time, angle, torque, and an angle of what moves it."""
    time = np.arange(0.0, seconds, 0.01)
    angle = np.convolve(np.random.default_rng(5).standard_normal(time.size), np.hanning(30), mode="same")
    values = (time, 1.1 * angle, angle, 1.2 * np.gradient(angle, time) + 70.0 * angle)
    text = "\n".join(",".join(f"{x:.5f}" for x in row) for row in zip(*values, strict=True))
    path.write_text(f"{','.join(columns)}\n{text}\n")


def test_the_angle_of_the_joint_is_taken_not_that_of_the_platform(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    joint(tmp_path / "lab/1.csv", ["Time (s)", "Platform angle (deg)", "Ankle angle (deg)", "Torque (Nm)"])
    new_study("lab", output="s")
    files = settings_of(tmp_path / "s")["position_manipulator"]["files"]
    assert files["columns"]["angle"] == "Ankle angle (deg)"
    assert (
        "Ankle angle (deg) was assumed, not Platform angle (deg)" in (tmp_path / "s/MISSING.md").read_text()
    )


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        (["t (s)", "x", "Angle (deg)", "Torque (Ncm)"], "expected the torque in Nm, found 'Ncm'"),
        (["time (ms)", "x", "Angle (deg)", "Torque (Nm)"], "expected the time in s, found 'ms'"),
        (["t (s)", "x", "Angle (mrad)", "Torque (Nm)"], "expected the angle in .*, found 'mrad'"),
    ],
)
def test_units_that_no_reader_converts_are_said_before_any_question(columns, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    joint(tmp_path / "lab/1.csv", columns)
    with pytest.raises(InputError, match=words):
        new_study("lab", output="s")


def test_trials_share_the_command_of_their_length(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab/signals").mkdir(parents=True)

    def write(name, header, *columns):
        text = "\n".join("\t".join(f"{x:.4f}" for x in row) for row in zip(*columns, strict=True))
        (tmp_path / "lab" / name).write_text(f"{header}\n{text}\n")

    for seconds, command in ((30.0, "long"), (10.0, "short")):
        time = np.arange(0.0, seconds, 0.02)
        write(f"signals/{command}.txt", "t\tMotor torque (Nm)", time, np.sin(time))
    for name, seconds in (("Monday", 30.0), ("Tuesday", 30.0), ("Friday", 10.0)):
        time = np.arange(0.0, seconds + 2.0, 0.02)
        write(f"{name}.txt", "Time\tAngle\tTrig", time, np.sin(time), 2.0 * (time >= 2.0))
    made = new_study("lab", output="s")
    assert made.trials == {"wristalyzer": 3} and not made.left
    commands = {row["condition"]: row["command"] for row in sheet_of(tmp_path / "s")}
    long, short = "signals/long.txt", "signals/short.txt"
    assert commands == {"Friday": short, "Monday": long, "Tuesday": long}
    missing = (tmp_path / "s/MISSING.md").read_text()
    assert f"| `trials.tsv, wristalyzer/Monday, command` | {long} was assumed, by its length |" in missing


def dflow(folder, name, shared):
    """D-Flow's files of an empty belt, whose clocks agree only if both hold a ``shared`` column."""
    time, rng = np.arange(0.0, 20.0, 0.01), np.random.default_rng(6)
    speed = sum(0.3 * np.exp(-(((time - t) / 0.03) ** 2)) for t in np.arange(4.0, 16.0, 3.0))
    force = rng.standard_normal((time.size, 6))
    plates = [f"FP1.{kind}{axis}" for kind in ("For", "Mom") for axis in "XYZ"]
    columns = {
        "mocap": (["TimeStamp", "FrameNumber", *plates], [time, np.arange(time.size), *force.T]),
        "treadmill": (["Time", "RightBelt.Speed"], [time + 0.4, speed]),
    }
    if shared:
        columns["treadmill"][0].append("FP1.ForY")
        columns["treadmill"][1].append(force[:, 1])
    for kind, (names, values) in columns.items():
        text = "\n".join("\t".join(f"{x:.6g}" for x in row) for row in zip(*values, strict=True))
        (folder / f"{name}_{kind}.txt").write_text("\t".join(names) + f"\n{text}\n")


def test_files_of_dflow_that_cannot_be_aligned_are_left_out_both(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    dflow(tmp_path / "lab", "empty_01", shared=False)
    with pytest.raises(InputError, match="expected a signal that the mocap file holds, too") as caught:
        new_study("lab", output="s")
    assert "empty_01_treadmill.txt: the trial that it belongs to is not used" in str(caught.value)
    joint(tmp_path / "lab/1.csv", ["t (s)", "x", "Angle (deg)", "Torque (Nm)"])
    dflow(tmp_path / "lab", "empty_02", shared=True)
    left = {f.name: f.why for f in new_study("lab", output="s").left}
    assert "models of the treadmill need a trial" in left["empty_02_mocap.txt"]
    assert {f"empty_0{n}_treadmill.txt" for n in (1, 2)} < set(left)


@pytest.mark.slow
def test_noise_of_slow_cameras_does_not_decide_what_a_marker_is_on(shipped_truth, tmp_path, monkeypatch):
    """A dummy at 100 Hz and 0.3 mm, whose belt is seen by its markers only."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    truth = laboratory(shipped_truth, 100.0)
    truth["treadmill"]["capture"]["noise_m"] = 3e-4
    path = tmp_path / "lab/dummy_01.c3d"
    trial_of(make_dummy_trial, truth, path, "dummy-01", Protocol("sine", 0.2, 2.0, 30.0))
    file = ezc3d.c3d(str(path))
    labels = file["parameters"]["ANALOG"]["LABELS"]["value"]
    file["data"]["analogs"][0, labels.index("Belt speed")] = 0.0
    file.write(str(path))
    told = []
    new_study("lab", output="s", tell=told.append)
    assert told[0] == ", file 1 of 1" and ", trial 1 of 1" in told
    dummy = settings_of(tmp_path / "s")["dummy"]
    assert dummy["foot"]["belt_fixed_labels"] == ["foot1", "foot2", "foot3", "ankle"]
    leg = [marker["label"] for marker in dummy["geometry"]["leg_markers"]]
    assert leg == ["ankle", "leg1", "leg2", "leg3", "leg4"]
    assert dummy["analysis"]["rest_before_s"] == pytest.approx(1.9, abs=0.11)


def test_a_rest_that_no_analysis_can_use_is_left_open(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    person(tmp_path / "lab/relax_1.c3d", begins=np.arange(0.5, 16.0, 3.0))
    new_study("lab", output="s")
    assert settings_of(tmp_path / "s")["standing"]["analysis"]["window"]["rest_before_s"] == "MISSING"
    missing = (tmp_path / "s/MISSING.md").read_text()
    assert re.search(r"first perturbation \(s\), more than 0.5, found 0.[34] and 6 pulses", missing)


def test_trials_in_subfolders_of_conditions_are_named_by_both(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for folder in ("S01/soft", "S01/hard", "S02/soft"):
        (tmp_path / f"lab/{folder}").mkdir(parents=True)
        joint(tmp_path / f"lab/{folder}/01.csv", ["t (s)", "x", "Angle (deg)", "Torque (Nm)"])
    new_study("lab", output="s")
    assert [row["condition"] for row in sheet_of(tmp_path / "s")] == [
        "S01-hard-01",
        "S01-soft-01",
        "S02-soft-01",
    ]


def test_conditions_of_weights_named_with_a_mass_or_a_counter(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    for number, (motion, name) in enumerate(
        [("sine", "weight 20 kg"), ("step", "weight 20 kg"), ("sine", "empty"), ("step", "empty")], 1
    ):
        kg = 20.0 * name.startswith("weight")
        loaded_belt(
            tmp_path / f"lab/{name} {motion} {number:04d}.c3d", kg, markers=("W1", "W2") if kg else ()
        )
    new_study("lab", output="s")
    assert [row["condition"] for row in sheet_of(tmp_path / "s")] == ["sine", "step"] * 2


def test_markers_in_a_table_beside_the_forces(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    recording = read_c3d_recording(loaded_belt(tmp_path / "a.c3d", 20.0))
    n, rng = round(RATE_HZ * SECONDS), np.random.default_rng(5)

    def write(name, columns):
        text = "\n".join(";".join(f"{x:.5f}" for x in row) for row in np.column_stack(list(columns.values())))
        (tmp_path / "lab" / name).write_text(f"{';'.join(columns)}\n{text}\n".replace(".", ","))

    time = {"Zeit [s]": np.arange(n) / RATE_HZ}
    markers = {
        f"W{k + 1}_{axis} [mm]": 1e3 * recording.markers.positions[:, k, j]
        for k in range(3)
        for j, axis in enumerate("xyz")
    }
    forces = {f"{kind}{axis}_right": rng.standard_normal(n) for kind in "FM" for axis in "xyz"}
    forces["Fz_right"] += 20.0 * 9.81
    forces["Bandgeschwindigkeit"] = recording.channels["Belt speed"].values[::4]
    for number in ("01", "02"):
        write(f"Gewicht {number} Kraft.csv", time | forces)
        write(f"Gewicht {number} Marker.csv", time | markers)
        write(f"empty {number}.csv", time | forces | {"Fz_right": rng.standard_normal(n)})
    made = new_study("lab", output="s")
    assert made.trials == {"weight": 2, "empty": 2} and not made.left
    rows = {row["log"]: row["markers"] for row in sheet_of(tmp_path / "s")}
    assert rows["Gewicht 01 Kraft.csv"] == "Gewicht 01 Marker.csv"
    velocity = settings_of(tmp_path / "s")["plate_treadmill"]["recording"]["belt_velocity"]
    assert velocity["channel"] == "Bandgeschwindigkeit"


def test_labels_of_several_subjects_are_named_without_them(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for subject in ("S01", "S02"):
        (tmp_path / f"lab/{subject}").mkdir(parents=True)
        person(tmp_path / f"lab/{subject}/relax_1.c3d", subject=f"{subject}:")
    assert new_study("lab", output="s").trials == {"standing": 2}
    labels = settings_of(tmp_path / "s")["standing"]["files"]["marker_labels"]
    assert {"RTOE", "RANK", "RKNE"} <= set(labels) and not any(":" in label for label in labels)
    assert {row["participant"] for row in sheet_of(tmp_path / "s")} == {"S01", "S02"}
    markers = read_c3d_recording(tmp_path / "lab/S02/relax_1.c3d").markers
    found = select_markers(markers, ["RTOE", "S02:RANK"], "a.c3d")
    assert found.labels == ("RTOE", "S02:RANK")
    np.testing.assert_array_equal(
        found.positions[:, 0], markers.positions[:, markers.labels.index("S02:RTOE")]
    )
    both = Markers(100.0, ("S01:RTOE", "S02:RTOE"), markers.positions[:, :2])
    with pytest.raises(InputError, match="expected one marker named 'RTOE', found 2"):
        select_markers(both, ["RTOE"], "a.c3d")
