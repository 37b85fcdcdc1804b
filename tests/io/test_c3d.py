"""A C3D file as a whole trial: plates of every type from a known force, channels, refusals, real files."""

import ezc3d
import numpy as np
import pytest
from builders import assert_one_sentence
from c3d_builders import Plate, write_c3d

from tepsipe.errors import InputError
from tepsipe.io.formats import contents_of, read_recording

# x of the plate is x of the laboratory, y backward, z down; its centre is at (1.0, 2.0, 0.1)
CORNERS = np.array([[1.3, 1.8, 0.1], [0.7, 1.8, 0.1], [0.7, 2.2, 0.1], [1.3, 2.2, 0.1]])
# 10 N in x, 20 N in -y and 100 N upward act at (1.1, 2.05, 0.1), 0.1 and 0.05 m from the centre, with a
# torque of 3 Nm about the vertical; in the axes of the plate F = (10, 20, -100), T = -3, at (0.1, -0.05)
FORCE = [10.0, -20.0, 100.0]
ABOUT_LAB = [2.05 * 100.0 - 0.1 * -20.0, 0.1 * 10.0 - 1.1 * 100.0, 1.1 * -20.0 - 2.05 * 10.0 + 3.0]
# about an origin 0.04 m below the surface the point is (0.1, -0.05, -0.04): M = p x F + T
TYPE_2 = [10.0, 20.0, -100.0, 5.0 + 0.8, -0.4 + 10.0, 2.0 + 0.5 - 3.0]
UNITS = ("N", "N", "N", "Nm", "Nm", "Nm")


def written(
    tmp_path,
    values,
    units,
    kind,
    origin=(0.0, 0.0, -0.04),
    matrix=None,
    corners=CORNERS,
    markers=None,
    **options,
):
    """A file with one plate whose channels are constant, and a marker at the origin or other ones."""
    labels = tuple(f"c{k}" for k in range(len(values)))
    channels = {
        label: (np.full(100, float(x)), unit) for label, x, unit in zip(labels, values, units, strict=True)
    }
    plate = Plate(corners, labels, kind, origin, np.eye(6) if matrix is None else matrix)
    markers = {"m": np.zeros((10, 3))} if markers is None else markers
    return write_c3d(tmp_path / "plate.c3d", 100.0, markers, channels, [plate], **options)


def expect(path, moment=ABOUT_LAB):
    recording = read_recording(path)
    (plate,) = recording.plates
    assert plate.force.shape == plate.moment.shape == (100, 3)
    assert plate.rate_hz == 1000.0
    np.testing.assert_allclose(plate.force, np.tile(FORCE, (100, 1)), rtol=1e-6)
    np.testing.assert_allclose(plate.moment, np.tile(moment, (100, 1)), rtol=1e-6, atol=1e-5)
    np.testing.assert_allclose(plate.corners, CORNERS, rtol=1e-6)


# ---- a known force and its point, by every type of plate -----------------------------------------


@pytest.mark.parametrize("unit", [(1.0, "mm"), (1e-3, "m")])
def test_type_1_centre_of_pressure(unit, tmp_path):
    scale, name = unit
    values = [*TYPE_2[:3], 100.0 * scale, -50.0 * scale, -3000.0]
    expect(written(tmp_path, values, ["N", "N", "N", name, name, "Nmm"], 1))


@pytest.mark.parametrize("unit", [(1.0, "Nm"), (1000.0, "Nmm"), (1000.0, "N.mm"), (1000.0, "")])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_type_2_forces_and_moments(unit, sign, tmp_path):
    """ORIGIN is also stored from the surface to the plate's origin, with a positive z."""
    scale, name = unit
    values = [*TYPE_2[:3], *(scale * np.array(TYPE_2[3:]))]
    forces = [name and "N"] * 3
    expect(written(tmp_path, values, [*forces, *[name] * 3], 2, (0.0, 0.0, sign * -0.04)))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_type_2_with_an_origin_beside_the_centre(sign, tmp_path):
    # the centre is at (0.02, -0.01, -0.04) of the plate's origin: the point at (0.12, -0.06, -0.04)
    moment = [6.0 + 0.8, -0.4 + 12.0, 2.4 + 0.6 - 3.0]
    origin = tuple(sign * np.array([0.02, -0.01, -0.04]))
    expect(written(tmp_path, [*TYPE_2[:3], *moment], ["N"] * 3 + ["Nm"] * 3, 2, origin))


@pytest.mark.parametrize("z", [-0.04, 0.04])
def test_type_3_eight_channels(z, tmp_path):
    """Sensors at (±0.2, ±0.15), 4 cm below the surface, whatever the sign of ORIGIN's z."""
    # Fz1 to Fz4 have the sum -100 and, about the sensors' plane, Mx = 5.8 and My = 9.6
    p, q = 5.8 / 0.15, 9.6 / 0.2
    fz = [(-100 + p - q) / 4, (-100 + p + q) / 4, (-100 - p + q) / 4, (-100 - p - q) / 4]
    # Mz = 0.15 (Fx34 - Fx12) + 0.2 (Fy14 - Fy23) = -0.5 with Fx12 = 4, Fx34 = 6, so Fy14 - Fy23 = -4
    values = [4.0, 6.0, 8.0, 12.0, *fz]
    expect(written(tmp_path, values, ["N"] * 8, 3, (0.2, 0.15, z)))


@pytest.mark.parametrize("store", [None, "BYROW"])
def test_type_4_calibration_matrix(store, tmp_path, rng):
    matrix = np.diag([100.0, 100.0, 200.0, 50000.0, 50000.0, 20000.0]) + rng.normal(0.0, 5.0, (6, 6))
    volts = np.linalg.solve(matrix, [*TYPE_2[:3], *(1000.0 * np.array(TYPE_2[3:]))])
    path = written(tmp_path, volts, ["V"] * 6, 4, matrix=matrix if store is None else matrix.T)
    if store:
        file = ezc3d.c3d(str(path))
        file.add_parameter("FORCE_PLATFORM", "MATRIX_STORE", [store])
        file.write(str(path))
    expect(path)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_type_4_with_an_origin_beside_the_centre(sign, tmp_path):
    moment = [6.0 + 0.8, -0.4 + 12.0, 2.4 + 0.6 - 3.0]
    values = [*TYPE_2[:3], *moment]
    origin = tuple(sign * np.array([0.02, -0.01, -0.04]))
    matrix = np.diag([1.0, 1.0, 1.0, 1000.0, 1000.0, 1000.0])
    expect(written(tmp_path, values, ["V"] * 6, 4, origin, matrix=matrix))


def test_baseline_frames_are_not_subtracted(tmp_path):
    values = [*TYPE_2[:3], *(1000.0 * np.array(TYPE_2[3:]))]
    expect(written(tmp_path, values, ["N"] * 3 + ["Nmm"] * 3, 2, zero=(1, 10)))


# ---- channels ------------------------------------------------------------------------------------


def test_channels_have_unit_and_rate(tmp_path):
    x = np.sin(np.arange(100.0))
    path = write_c3d(
        tmp_path / "a.c3d", 100.0, {"m": np.ones((10, 3))}, {"EMG TA": (x, "mV"), "Sync": (x, "V")}
    )
    recording = read_recording(path)
    assert recording.plates == ()
    assert recording.name == str(path)
    assert list(recording.channels) == ["EMG TA", "Sync"]
    channel = recording.channels["EMG TA"]
    assert (channel.unit, channel.rate_hz, channel.limits) == ("mV", 1000.0, None)
    np.testing.assert_allclose(channel.values, x, rtol=1e-6)
    np.testing.assert_allclose(recording.markers.positions, 1.0, rtol=1e-6)


def test_file_without_markers(tmp_path):
    path = write_c3d(tmp_path / "a.c3d", 100.0, {}, {"Belt": (np.arange(100.0), "V")})
    recording = read_recording(path)
    assert recording.markers is None
    np.testing.assert_allclose(recording.channels["Belt"].values, np.arange(100.0))


def test_channels_of_one_name_are_numbered(tmp_path):
    path = write_c3d(tmp_path / "a.c3d", 100.0, {}, {"a": (np.ones(100), "V"), "b": (np.zeros(100), "V")})
    file = ezc3d.c3d(str(path))
    file["parameters"]["ANALOG"]["LABELS"]["value"] = ["a", "a"]
    file.write(str(path))
    assert list(read_recording(path).channels) == ["a", "a (channel 2)"]


# ---- refusals ------------------------------------------------------------------------------------


def fault(path):
    """Why the only plate of a file cannot be used: it stops the trials that use it, not the reading."""
    (plate,) = read_recording(path).plates
    assert np.isnan(plate.force).all()
    assert np.isnan(plate.moment).all()
    assert (plate.force.shape, plate.rate_hz, plate.corners) == ((100, 3), 1000.0, None)
    return plate.fault


@pytest.mark.parametrize(
    ("units", "kind", "words"),
    [
        (["V"] * 3 + ["Nmm"] * 3, 2, ["force plate 1", "'c0'", "N, kN", "'V'"]),
        (["N"] * 3 + ["lbf ft"] * 3, 2, ["force plate 1", "'c3'", "Nmm", "lbf ft"]),
        (["N"] * 3 + ["Nmm"] * 3, 6, ["force plate 1", "type 1, 2, 3 or 4", "6"]),
    ],
)
def test_unknown_units_and_types_are_refused(units, kind, words, tmp_path):
    path = written(tmp_path, TYPE_2, units, kind)
    assert_one_sentence(fault(path), path, *words)


@pytest.mark.parametrize("parameter", ["TYPE", "CORNERS", "ORIGIN", "CHANNEL"])
def test_missing_parameters_of_a_plate_are_refused(parameter, tmp_path):
    path = written(tmp_path, TYPE_2, ["N"] * 3 + ["Nm"] * 3, 2)
    file = ezc3d.c3d(str(path))
    del file["parameters"]["FORCE_PLATFORM"][parameter]
    file.write(str(path))
    assert_one_sentence(fault(path), path, "force plate 1")


@pytest.mark.parametrize(
    ("group", "parameter", "value", "words"),
    [
        ("FORCE_PLATFORM", "CHANNEL", 7, "channels from 1 to 6 in FORCE_PLATFORM:CHANNEL, found 7"),
        ("FORCE_PLATFORM", "ORIGIN", np.nan, "numbers in FORCE_PLATFORM:ORIGIN"),
    ],
)
def test_impossible_parameters_of_a_plate_are_refused(group, parameter, value, words, tmp_path):
    path = written(tmp_path, TYPE_2, ["N"] * 3 + ["Nm"] * 3, 2)
    file = ezc3d.c3d(str(path))
    file["parameters"][group][parameter]["value"] = file["parameters"][group][parameter]["value"].copy()
    file["parameters"][group][parameter]["value"][-1] = value
    file.write(str(path))
    assert_one_sentence(fault(path), path, "force plate 1", words)


def test_damaged_files_are_refused(tmp_path):
    path = written(tmp_path, TYPE_2, ["N"] * 3 + ["Nm"] * 3, 2)
    content = path.read_bytes()
    start = 512 * (content[0] - 1)
    rate = content.index(np.float32(1000.0).tobytes()) + 1  # of the analog channels: its second byte
    for at, value, words in (
        (start + 3, 83, "found 83"),
        (start + 4, 255, "cannot be read"),
        (rate, 128, "at 10 times the 100 Hz of the frames, found 1002 Hz in ANALOG:RATE"),
    ):
        path.write_bytes(content[:at] + bytes([value]) + content[at + 1 :])
        with pytest.raises(InputError) as caught:
            read_recording(path)
        assert_one_sentence(caught.value, path, words)


def test_corners_on_one_line_are_refused(tmp_path):
    labels = tuple("abcdef")
    channels = {
        label: (np.ones(100), unit) for label, unit in zip(labels, ["N"] * 3 + ["Nm"] * 3, strict=True)
    }
    plate = Plate(np.zeros((4, 3)), labels)
    path = write_c3d(tmp_path / "a.c3d", 100.0, {"m": np.zeros((10, 3))}, channels, [plate])
    assert_one_sentence(fault(path), path, "corners", "CORNERS")


def test_info_says_why_a_plate_cannot_be_used(tmp_path):
    text = contents_of(written(tmp_path, TYPE_2, ["V"] * 6, 2)).summary()
    assert "type 2, cannot be used: expected the channel 'c0' in N, kN, found the unit 'V'" in text


def test_number_of_plates_of_a_damaged_file_is_refused(tmp_path):
    path = written(tmp_path, TYPE_2, ["N"] * 3 + ["Nm"] * 3, 2)
    file = ezc3d.c3d(str(path))
    file["parameters"]["FORCE_PLATFORM"]["USED"]["value"] = np.array([30000])
    file.write(str(path))
    with pytest.raises(InputError) as caught:
        read_recording(path)
    assert_one_sentence(caught.value, path, "100 force plates", "30000")


def test_another_kind_of_file_is_refused():
    with pytest.raises(InputError) as caught:
        read_recording("trial.docx")
    assert_one_sentence(caught.value, "trial.docx", ".c3d", "'.docx'")


# ---- recordings made by others ---------------------------------------------------------------------


def centre_of_pressure(plate, loaded):
    force, moment = plate.force[loaded], plate.moment[loaded]
    return np.column_stack([-moment[:, 1], moment[:, 0]]) / force[:, 2:]


@pytest.mark.parametrize(
    ("name", "peaks"),
    [("Gait", (799.0, 855.0)), ("HC002D06", (374.0, 394.0)), ("Qualisys", (808.0, 840.0))],
)
def test_walking_on_real_plates(name, peaks, real_data):
    """Plates of type 4 and 2: the force points up, and its point is on the plate."""
    recording = read_recording(real_data(f"c3d/{name}.c3d"))
    assert len(recording.plates) == 2
    for plate, heaviest in zip(recording.plates, peaks, strict=True):
        vertical = plate.force[:, 2]
        assert vertical.max() == pytest.approx(heaviest, rel=0.01)
        assert vertical.min() > -25.0
        place = centre_of_pressure(plate, vertical > 100.0)
        low, high = plate.corners[:, :2].min(axis=0), plate.corners[:, :2].max(axis=0)
        assert ((place >= low) & (place <= high)).all()


def test_standing_on_a_real_plate(real_data):
    """A child of 31 kg stands on the first plate, and nobody on the second."""
    recording = read_recording(real_data("c3d/HC002D02.c3d"))
    first, second = recording.plates
    assert first.force[:, 2].mean() / 9.81 == pytest.approx(31.07, abs=0.01)
    assert np.abs(first.force[:, :2]).max() < 2.0
    place = centre_of_pressure(first, slice(None)).mean(axis=0)
    np.testing.assert_allclose(place, [0.215, 0.322], atol=0.001)
    # between the ankles of the child, whose markers are in the same axes
    labels = recording.markers.labels
    ankles = recording.markers.positions[:, [labels.index("LANK"), labels.index("RANK")], :2]
    assert np.linalg.norm(np.nanmean(ankles, axis=(0, 1)) - place) < 0.1
    assert not second.force.any()
    assert recording.channels["Voltage.L Gast"].unit == "V"


def test_numbers_of_more_than_255_points(real_data):
    markers = read_recording(real_data("c3d/HC002D02.c3d")).markers
    assert len(markers.labels) == markers.positions.shape[1] == 311
    assert len(set(markers.labels)) == 311


def test_limits_of_a_converter(real_data):
    channel = read_recording(real_data("c3d/Gait.c3d")).channels["LTIB"]
    low, high = channel.limits
    assert (low, high) == pytest.approx((-2048 * 0.001221, 2047 * 0.001221), rel=1e-4)
    assert low <= channel.values.min() < channel.values.max() <= high


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Gait", "HC002D02", "Qualisys"])
def test_plates_of_types_2_and_4_are_those_of_ezc3d(name, real_data):
    path = real_data(f"c3d/{name}.c3d")
    others = ezc3d.c3d(str(path), extract_forceplat_data=True)["data"]["platform"]
    for plate, other in zip(read_recording(path).plates, others, strict=True):
        force, centre = other["force"].T, 1e-3 * other["corners"].mean(axis=1)
        np.testing.assert_allclose(plate.force, force, atol=1e-9)
        moment = 1e-3 * other["moment"].T + np.cross(centre, force)
        np.testing.assert_allclose(plate.moment, moment, atol=1e-9)


@pytest.mark.parametrize(
    ("kind", "values", "origin"),
    [
        (1, [*TYPE_2[:3], 100.0, -50.0, -3000.0], (0.0, 0.0, -0.04)),
        (3, [4.0, 6.0, 8.0, 12.0, -39.0, -1.0, -11.0, -49.0], (0.2, 0.15, 0.04)),
    ],
)
def test_ezc3d_turns_the_moment_of_other_types(kind, values, origin, tmp_path):
    """If this fails, ezc3d has changed: decision 43 gives its error as the reason for our own computation."""
    units = ["N"] * 8 if kind == 3 else ["N", "N", "N", "mm", "mm", "Nmm"]
    path = written(tmp_path, values, units, kind, origin)
    (other,) = ezc3d.c3d(str(path), extract_forceplat_data=True)["data"]["platform"]
    (plate,) = read_recording(path).plates
    about_centre = plate.moment[0] - np.cross(CORNERS.mean(axis=0), plate.force[0])
    assert 1e-3 * other["moment"][2, 0] == pytest.approx(-about_centre[2], rel=1e-5)
    assert abs(about_centre[2]) > 0.1


@pytest.mark.parametrize("upward", [np.eye(3), np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]])])
def test_a_level_plate_shows_the_vertical_whatever_the_screen_is(upward, tmp_path):
    corners = CORNERS @ upward.T
    above = corners.mean(axis=0) + upward @ [0.0, 0.0, 1.0]
    markers = {"m": np.tile(above, (10, 1))}
    path = written(tmp_path, np.zeros(6), UNITS, 2, corners=corners, markers=markers)
    file = ezc3d.c3d(str(path))
    file.add_parameter("POINT", "Y_SCREEN", ["+X"])
    file.write(str(path))
    assert read_recording(path).up == "+" + "xyz"[int(np.argmax(upward @ [0, 0, 1]))]


@pytest.mark.parametrize(("corners", "up"), [(CORNERS, "+z"), (CORNERS[::-1], "-z")])
def test_without_markers_the_order_of_the_corners_shows_the_upper_side(corners, up, tmp_path):
    path = written(tmp_path, np.zeros(6), UNITS, 2, corners=corners, markers={})
    assert read_recording(path).up == up
