"""Laboratories drawn around the constants of the file, and what their offsets do to the recordings."""

import copy
import math
from dataclasses import replace

import ezc3d
import h5py
import numpy as np
import pytest
from plate_builders import plate_voltages, pressed
from scipy import stats

from tepsipe.errors import InputError
from tepsipe.virtual_lab.belt import DriveTruth
from tepsipe.virtual_lab.drawn_laboratories import draw_laboratory, drawn_numbers
from tepsipe.virtual_lab.dummy import DummyMarkers, DummyTruth, dummy_marker_paths, move_dummy
from tepsipe.virtual_lab.dummy_trial import make_dummy_trial
from tepsipe.virtual_lab.force_plate import PlateTruth, plate_electronics
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_trial import CaptureTruth, Protocol, record_markers
from workflow.support.checked_study import checked_sections
from workflow.support.yaml_file import read_settings

SMALL = {
    "seed": 1,
    "rod": {"mass_kg": 0.4, "points_m": [[1.0, 2.0], [3.0, 0.0]], "name": "ash"},
    "scale": 2.0,
}


def drawn(entries, **changes):
    return draw_laboratory(SMALL | changes | {"drawn": entries})


# ---- drawing -----------------------------------------------------------------------------------


def test_same_seed_draws_the_same_numbers_and_another_seed_others():
    entries = {"rod.mass_kg": {"normal": 0.01}}
    assert drawn(entries) == drawn(entries)
    assert drawn(entries)["rod"]["mass_kg"] != drawn(entries, seed=2)["rod"]["mass_kg"]


def test_an_entry_changes_no_other_draw():
    alone = drawn({"rod.mass_kg": {"normal": 0.01}})
    both = drawn({"scale": {"rectangular": 0.1}, "rod.mass_kg": {"normal": 0.01}})
    assert both["rod"] == alone["rod"] != SMALL["rod"]
    assert alone["scale"] == 2.0 != both["scale"]


@pytest.mark.parametrize("entries", [None, {}])
def test_nothing_is_drawn_without_entries(entries):
    assert drawn(entries) == SMALL | {"drawn": None}
    assert draw_laboratory(SMALL) == SMALL | {"drawn": None}


def test_drawing_twice_changes_nothing_and_the_file_keeps_its_numbers():
    constants = SMALL | {"drawn": {"rod.points_m": {"normal": 0.01}}}
    before = copy.deepcopy(constants)
    once = draw_laboratory(constants)
    assert draw_laboratory(once) == once
    assert constants == before


def test_every_number_of_a_list_is_drawn_for_itself():
    numbers = drawn_numbers(SMALL | {"drawn": {"rod.points_m": {"normal": 0.01}}})
    assert [number.path for number in numbers] == [f"rod.points_m.{i}.{j}" for i in (0, 1) for j in (0, 1)]
    moved = [number.value - number.nominal for number in numbers]
    assert len(set(moved)) == 4
    points = drawn({"rod.points_m": {"normal": 0.01}})["rod"]["points_m"]
    assert points == [[n.value for n in numbers[:2]], [n.value for n in numbers[2:]]]
    # one of them by its position, with the same number
    assert drawn({"rod.points_m.1.0": {"normal": 0.01}})["rod"]["points_m"] == [
        [1.0, 2.0],
        [points[1][0], 0.0],
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("entry", "deviation", "shape"),
    [
        ({"normal": 0.5}, 0.5, stats.norm()),
        ({"rectangular": 0.5}, 0.5 / math.sqrt(3.0), stats.uniform(-math.sqrt(3.0), 2.0 * math.sqrt(3.0))),
        ({"normal": 0.25, "relative": True}, 0.5, stats.norm()),
        ({"student": [0.5, 3.0]}, 0.5, stats.t(3.0, scale=1.0 / math.sqrt(3.0))),
    ],
)
def test_distributions_have_the_mean_the_spread_and_the_tails_asked_for(entry, deviation, shape):
    values = np.array([drawn({"scale": entry}, seed=seed)["scale"] for seed in range(4000)])
    z = (values - 2.0) / deviation
    assert shape.std() == pytest.approx(1.0)
    assert stats.kstest(z, shape.cdf).pvalue > 0.01
    assert stats.kstest(0.9 * z, shape.cdf).pvalue < 0.01
    (number,) = drawn_numbers(SMALL | {"drawn": {"scale": entry}})
    assert number.standard_deviation == pytest.approx(deviation)
    if "rectangular" in entry:
        assert np.abs(values - 2.0).max() < 0.5


def test_free_distributions_replace_the_number():
    spread = {"scale": {"log_uniform": [1e-5, 5e-4]}}
    values = np.array([drawn(spread, seed=seed)["scale"] for seed in range(4000)])
    assert stats.kstest(np.log(values), stats.uniform(np.log(1e-5), np.log(50.0)).cdf).pvalue > 0.01
    (number,) = drawn_numbers(SMALL | {"drawn": spread})
    assert number.standard_deviation == pytest.approx(values.std(), rel=0.1)
    chosen = {"scale": {"one_of": [1.0, 3.0]}}
    values = [drawn(chosen, seed=seed)["scale"] for seed in range(200)]
    assert set(values) == {1.0, 3.0}
    assert 70 < values.count(1.0) < 130
    (number,) = drawn_numbers(SMALL | {"drawn": chosen})
    assert number.standard_deviation == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("entries", "part"),
    [
        ({"scale": {"log_uniform": [2.0, 1.0]}}, "two ascending numbers above 0"),
        ({"scale": {"one_of": []}}, "expected values for the entry 'scale'"),
        ({"scale": {"one_of": [1.0], "shift": 1.0}}, "found one_of, shift"),
        ({"rod.weight": {"normal": 1.0}}, "to name a constant, found 'rod.weight'"),
        ({"rod.points_m.2": {"normal": 1.0}}, "to name a constant, found 'rod.points_m.2'"),
        ({"rod.mass_kg.0": {"normal": 1.0}}, "to name a constant, found 'rod.mass_kg.0'"),
        ({"rod": {"normal": 1.0}}, "entry 'rod' of 'drawn' to name a number or a list"),
        ({"rod.name": {"normal": 1.0}}, "found 'ash'"),
        ({"seed": {"normal": 1.0}}, "entry 'seed' of 'drawn' to name a number"),
        ({"scale": {}}, "found nothing"),
        ({"scale": {"normal": 1.0, "rectangular": 1.0}}, "found normal, rectangular"),
        ({"scale": {"student": [1.0, 2.0]}}, "more than 2 degrees of freedom"),
        ({"rod.points_m": {"normal": 0.1, "relative": True}}, "found 0 for 'rod.points_m.1.1'"),
        (
            {"rod.points_m": {"normal": 0.1}, "rod.points_m.0.0": {"normal": 0.2}},
            "found 'rod.points_m.0.0' twice",
        ),
    ],
)
def test_unusable_entries_are_refused_in_one_sentence(entries, part):
    with pytest.raises(ValueError, match=r"^expected") as caught:
        drawn(entries)
    text = str(caught.value)
    assert part in text
    assert "\n" not in text


def test_study_is_given_the_drawn_constants_and_refuses_an_unknown_one(root, tmp_path):
    text = (root / "config/virtual_lab.yaml").read_text(encoding="utf-8")
    path = tmp_path / "lab.yaml"
    config = {"study": {"virtual_lab": str(path)}}
    path.write_text(text)
    found, shipped = checked_sections(config, "virtual_lab"), read_settings(path)
    assert found == draw_laboratory(shipped) | {"drawn_numbers": [vars(n) for n in drawn_numbers(shipped)]}
    assert found["dummy"]["subject"]["leg_mass_kg"] != shipped["dummy"]["subject"]["leg_mass_kg"] == 0.4
    for entry, part in (
        ("  dummy.subject.leg_weight_kg: {normal: 0.1}", f"{path}: expected every entry of 'drawn'"),
        ("  weight.height_m: {normal: 1000.0}", f"{path}, after drawing: expected a number above 0"),
        ("  weight.height_m: {normal: -1.0}", f"{path}: expected a number of at least 0"),
        ("  weight.height_m: {gaussian: 1.0}", f"{path}: unknown key 'drawn.weight.height_m.gaussian'"),
    ):
        path.write_text(f"{text}{entry}\n".replace("seed: 20140612", "seed: 4"))
        with pytest.raises(InputError) as caught:
            checked_sections(config, "virtual_lab")
        assert str(caught.value).startswith(part), caught.value
        assert "\n" not in str(caught.value)


# ---- what is drawn, in the recordings ------------------------------------------------------------


def test_rod_with_a_centre_of_mass_of_its_own_swings_as_such(shipped_truth):
    subject = shipped_truth["dummy"]["subject"] | {"leg_com_m": 0.41, "joint_inertia_kgm2": 0.0}
    stiff_belt = DriveTruth(**shipped_truth["treadmill"]["drive"] | {"belt_mass_kg": 1e9})
    heavy = replace(stiff_belt, force_limit_N=1e9, bandwidth_hz=1e-12, integral_time_s=1e12, delay_s=0.0)
    rubber = Rubber(10.0, 0.0, 0.0, 0.05, 0.0)
    start = DummyTruth(**subject)
    motion = move_dummy(start, rubber, heavy, lambda t: np.where(t < 0.05, 1e30, 0.0), 4.0, 2000.0)
    after = motion.time > 0.1
    time, swing = motion.time[after], motion.angle[after] - start.rest_angle_rad
    up = np.flatnonzero((swing[:-1] < 0.0) & (swing[1:] >= 0.0))
    crossing = time[up] - swing[up] * (time[up + 1] - time[up]) / (swing[up + 1] - swing[up])
    frequency = (crossing.size - 1) / (crossing[-1] - crossing[0])
    expected = math.sqrt((10.0 - 0.4 * 9.81 * 0.41) / (0.027 + 0.4 * 0.41**2)) / (2.0 * math.pi)
    assert np.abs(swing).max() < 0.02
    assert frequency == pytest.approx(expected, rel=3e-4)


def test_markers_turn_about_the_joint_and_not_about_the_point_they_are_measured_from(shipped_truth):
    subject = DummyTruth(**shipped_truth["dummy"]["subject"] | {"joint_offset_m": [0.003, 0.002]})
    layout = shipped_truth["dummy"]["markers"]
    motion = type("Motion", (), {})()
    motion.time = np.linspace(0.0, 1.0, 50)
    motion.position, motion.tilt, motion.angle = np.zeros(50), np.zeros(50), 0.2 * motion.time
    paths = dummy_marker_paths(DummyMarkers(**layout), subject, motion)
    # upright, every marker is where it was measured
    upright = np.array([path(np.array([0.0]))[0, 1:] for path in paths])
    foot, leg = np.array(layout["foot_m"]), np.array([layout["ankle_m"], *layout["leg_m"]])
    placed = np.vstack([np.add(foot, [0.05, 0.0]), np.add(leg, [0.05, 0.055])])
    assert upright == pytest.approx(placed, abs=1e-12)
    # the axis stays: distances of leg markers from it are kept, and the ankle marker moves a little
    axis = np.array([0.053, 0.057])
    for path in paths[3:]:
        seen = path(motion.time)[:, 1:] - axis
        assert np.linalg.norm(seen, axis=1) == pytest.approx(np.linalg.norm(seen[0]), abs=1e-12)
    moved = paths[3](np.array([1.0]))[0, 1:] - upright[3]
    assert moved == pytest.approx(
        [
            -0.002 * math.sin(0.2) - 0.003 * (math.cos(0.2) - 1.0),
            0.003 * math.sin(0.2) - 0.002 * (math.cos(0.2) - 1.0),
        ],
        abs=1e-12,
    )


def test_offset_joint_loads_the_plate_where_the_leg_stands(shipped_truth):
    own = {"joint_offset_m": [0.004, 0.0], "foot_com_m": [-0.01, 0.03], "rest_angle_rad": 0.0}
    subject = DummyTruth(**shipped_truth["dummy"]["subject"] | own)
    drive = DriveTruth(**shipped_truth["treadmill"]["drive"])
    rubber = Rubber(**shipped_truth["dummy"]["rubber"])
    motion = move_dummy(subject, rubber, drive, np.zeros_like, 0.05, 2000.0)
    _, _, fz, mx, _, _ = motion.reaction[0]
    assert fz == pytest.approx(2.5 * 9.81)
    assert mx / fz == pytest.approx(0.05 + (0.4 * 0.004 - 2.1 * 0.01) / 2.5, abs=1e-9)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, [0.0, 10.0, 200.0, 6.0]),
        # the fore-aft transducer lies 0.12 m below the belt: its moment goes with its force
        ({"force_scale": [1.01, 1.0]}, [0.0, 10.1, 200.0, 6.0 + 0.12 * 0.1]),
        ({"force_scale": [1.0, 1.02]}, [0.0, 10.0, 204.0, 6.0 + 0.02 * (6.0 - 0.12 * 10.0)]),
        ({"vertical_leak": 0.01}, [0.0, 12.0, 200.0, 6.0 + 0.12 * 2.0]),
        ({"origin_height_m": 0.002}, [0.0, 10.0, 200.0, 6.02]),
    ],
)
def test_plate_that_has_drifted_from_its_calibration_shows_it(shipped_truth, changes, expected):
    off = ("sensitivity_spread", "cross_talk", "calibration_error", "noise_V", "drift_V_per_s", "mount_share")
    quiet = shipped_truth["treadmill"]["plate"] | dict.fromkeys((*off, "floor_m_per_s2"), 0.0)
    plate = PlateTruth(**quiet | changes)
    n = 400
    reaction = np.tile([0.0, 10.0, 200.0, 6.0, 0.0, 0.0], (n, 1))
    volts, matrix = plate_electronics(plate, generator(1, "plate"))
    motion = pressed(reaction, 2000.0)
    seen = plate_voltages(plate, volts, motion, np.arange(0, n, 2), generator(1, "trial"))
    assert (seen @ matrix.T)[-1, 6:10] == pytest.approx(expected, abs=1e-9)


def test_fast_clock_takes_its_frames_early(shipped_truth):
    own = {"noise_m": 0.0, "occlusions_per_minute": 0.0, "latency_s": 0.0, "clock_ppm": 100.0}
    capture = CaptureTruth(**shipped_truth["treadmill"]["capture"] | own)
    clock = [lambda instant: np.column_stack([instant] * 3)]
    seen = record_markers(capture, clock, 2.0, 2501, np.random.default_rng(1))[:, 0, 0]
    assert seen[0] == 2.0
    assert seen[-1] == pytest.approx(12.0 - 0.001, abs=1e-6)  # 100 ppm of 10 s


def test_tilted_axes_and_a_wrong_scale_move_markers_as_such(shipped_truth):
    own = {"noise_m": 0.0, "occlusions_per_minute": 0.0, "vertical_rad": 0.01, "length_scale": 1.001}
    capture = CaptureTruth(**shipped_truth["treadmill"]["capture"] | own)
    point = [lambda instant: np.tile([0.3, 0.1, 0.9], (instant.size, 1))]
    seen = record_markers(capture, point, 0.0, 3, np.random.default_rng(1))[0, 0]
    # an upright rod leans by the angle: its upper end goes forwards
    s, c = math.sin(0.01), math.cos(0.01)
    assert seen == pytest.approx([0.3003, 1.001 * (0.1 * c + 0.9 * s), 1.001 * (0.9 * c - 0.1 * s)])


def test_rod_is_set_upright_by_what_the_motion_capture_shows(short_truth, tmp_path):
    truth = copy.deepcopy(short_truth)
    truth["dummy"]["subject"]["rest_angle_rad"] = 0.0001
    truth["treadmill"]["capture"] |= {"vertical_rad": 0.01, "noise_m": 0.0, "occlusions_per_minute": 0.0}
    names = {"log": "log.mat", "calibration": "calibration.csv", "markers": "markers.c3d"}
    files = {kind: tmp_path / name for kind, name in names.items()}
    made = files | {"motion": tmp_path / "motion.h5"}
    make_dummy_trial(truth, "sine-0.5", Protocol("sine", 0.5, 2.0, 5.5), made)
    ankle, top = ezc3d.c3d(str(files["markers"]))["data"]["points"][1:3, 3:5, 0].T / 1000.0
    layout = truth["dummy"]["markers"]["leg_m"][0]
    seen = math.atan2(*(top - ankle)) - math.atan2(*layout)
    assert seen == pytest.approx(truth["dummy"]["subject"]["rest_angle_rad"], abs=1e-6)
    with h5py.File(tmp_path / "motion.h5") as file:
        assert file["angle"][0] == pytest.approx(0.0001 - 0.01, abs=1e-6)
