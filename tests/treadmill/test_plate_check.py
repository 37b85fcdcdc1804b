"""Origin and scale of a force plate from weights at rest: what a plate with one known fault shows.

The plate stands on four vertical transducers; the forces on them follow from the balance of a rigid deck.
"""

from dataclasses import replace

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.experiments.weight.calibrate import with_recordings
from tepsipe.io.result import Result
from tepsipe.io.trial import Signal, Trial
from tepsipe.treadmill.options import Weight
from tepsipe.treadmill.plate_check import (
    PlateCheck,
    Resting,
    calibration_difference,
    calibration_fault,
    check_plate,
)

G, X_M, LENGTH_M, WIDTH_M = 9.81, 0.25, 1.6, 0.5
PLACES_M = np.array([0.02, 0.05, 0.09, 0.12])
# corners of the deck relative to its centre: forward, sideways (m)
CORNERS = np.array([(a * LENGTH_M / 2, b * WIDTH_M / 2) for a in (1, -1) for b in (1, -1)])


def corners(force, x, y):
    """Vertical forces in the corners below a weight at x, y, shape (n, 4): least norm with their balance."""
    rows = np.vstack([np.ones(4), CORNERS.T])
    return (np.linalg.pinv(rows) @ np.vstack([force, force * y, force * (x - X_M)])).T


def rest(kg, rng, *, origin_m=0.0, scale=1.0, gains=(1.0, 1.0, 1.0, 1.0), centre_m=0.0):
    """A weight that rests at several places; zero and noise of the transducers are drawn (N·m, N)."""
    count = PLACES_M.size
    y = PLACES_M + (0.03 if kg > 30.0 else 0.0) if kg else np.zeros(count)
    f = corners(np.full(count, kg * G), X_M, y) * gains
    f_z = f.sum(axis=1)
    m_x = scale * (f @ CORNERS[:, 0] - origin_m * f_z) + 0.5 * rng.standard_normal()
    m_y = -(f @ (CORNERS[:, 1] + X_M))
    noise = 0.03 * rng.standard_normal((3, count))
    place = np.column_stack([np.full(count, X_M), y]) if kg else np.zeros((count, 2))
    weight = (
        Weight(mass_kg=kg, com_height_m=0.1, gravity_m_per_s2=G, com_forward_of_markers_m=centre_m)
        if kg
        else None
    )
    return Resting(weight, place, f_z + noise[0], m_x + noise[1], m_y + noise[2])


def checked(**fault):
    rng = np.random.default_rng(5)
    return check_plate([rest(kg, rng, **fault) for kg in (0.0, 0.0, 0.0, 20.0, 20.0, 60.0, 60.0)], "plate")


def test_sound_plate_is_left_alone():
    found = checked()
    assert (found.corrected_scale, found.corrected_origin_m, found.flags) == (1.0, 0.0, ())
    assert found.moment_scale == pytest.approx(1.0, abs=3.0 * found.moment_scale_u)
    assert abs(found.origin_m) < 2.0 * found.origin_u_m < 0.006


@pytest.mark.parametrize("origin_m", [0.005, 0.02, 0.05, -0.05, 0.4])
def test_origin_that_is_off_is_found_and_corrected(origin_m):
    found = checked(origin_m=origin_m)
    assert found.corrected_origin_m == pytest.approx(origin_m, abs=2.0 * found.origin_u_m)
    assert found.corrected_origin_m != 0.0
    assert found.corrected_scale == 1.0
    assert found.flags == ()


@pytest.mark.parametrize("scale", [1.1, 0.8])
def test_scale_of_the_moment_is_found_and_corrected_together_with_the_origin(scale):
    found = checked(scale=scale, origin_m=0.03)
    assert found.corrected_scale == pytest.approx(scale, rel=0.02)
    assert found.corrected_origin_m == pytest.approx(0.03, abs=0.004)


def test_corrected_moment_is_that_about_the_origin_of_the_markers():
    """Worked by hand: 500 N at 0.1 m, on a plate whose origin is 0.02 m forward and whose scale is 1.1."""
    force, moment = np.zeros((4, 2, 3)), np.zeros((4, 2, 3))
    force[:, 1, 2], moment[:, 1, 0], moment[:, 0, 0] = 500.0, 1.1 * (0.1 - 0.02) * 500.0, 7.0
    axes = {"time": np.arange(4) / 100.0, "belt": np.array(["left", "right"])}
    signals = {
        "force": Signal(force, "N", ("time", "belt", "axis")),
        "moment": Signal(moment, "Nm", ("time", "belt", "axis")),
    }
    trial = Trial(100.0, axes, signals)
    assert PlateCheck(0.02, 0.004).origin_known
    for unsure in (PlateCheck(), PlateCheck(0.02, 0.006), PlateCheck(0.02, 0.001, flags=("plate-scale",))):
        assert not unsure.origin_known
    check = PlateCheck(0.02, 0.001, 1.1, 0.001, 1.0, 0.0)
    found = PlateCheck.from_result(Result({}, {}, {"plate": check.facts})).corrected(trial, "right")
    assert found.values("moment")[:, 1, 0] == pytest.approx(50.0)
    assert found.values("moment")[:, 0, 0] == pytest.approx(7.0)
    assert check.corrected(trial, "none") is trial
    assert replace(check, flags=("plate-scale",)).corrected(trial, "right") is trial


def test_reversed_moment_is_refused_by_its_name():
    with pytest.raises(InputError) as caught:
        checked(scale=-1.0)
    assert_one_sentence(caught.value, "plate", "turn the sign of M_x")


def test_one_transducer_at_half_gain_is_named_and_nothing_is_corrected():
    found = checked(gains=(0.5, 1.0, 1.0, 1.0))
    assert found.flags == ("plate-transducer",)
    assert (found.corrected_scale, found.corrected_origin_m) == (1.0, 0.0)
    assert found.force_scale == pytest.approx(0.875, abs=0.02)


def test_scale_of_the_vertical_force_is_named():
    assert checked(gains=(1.1,) * 4).flags == ("plate-scale",)


def test_centre_that_is_not_stated_shows_a_scale_but_no_origin():
    found = checked(origin_m=0.05, scale=1.1, centre_m=None)
    assert found.origin_m is None
    assert found.corrected_origin_m == 0.0
    assert found.corrected_scale == pytest.approx(1.1, rel=0.02)


def test_drift_of_the_zero_within_a_trial_is_no_scale():
    """20 kg that move by 8 mm change M_x by 1.6 N·m; the empty belt shows a drift of 0.4 N·m."""
    rng, course = np.random.default_rng(7), np.linspace(0.0, 1.0, PLACES_M.size)
    light = [rest(20.0, rng), rest(0.0, rng), rest(0.0, rng)]
    y = 0.02 + 0.008 * course
    place = np.column_stack([light[0].place[:, 0], y])
    slow = [replace(light[0], place=place, m_x=y * light[0].f_z - 0.4 * course)]
    slow += [replace(r, m_x=r.m_x + 0.4 * course) for r in light[1:]]
    found = check_plate(slow, "plate")
    assert found.corrected_scale == 1.0
    assert found.moment_scale_u > 0.05


def test_weights_at_one_place_show_an_origin_but_hardly_a_scale():
    r = rest(20.0, np.random.default_rng(6), origin_m=0.05)
    place = np.full((1, 2), [X_M, PLACES_M[1]])
    one = [replace(r, place=place, f_z=r.f_z[1:2], m_x=r.m_x[1:2], m_y=r.m_y[1:2])]
    found = check_plate(one, "plate")
    assert found.corrected_scale == 1.0
    assert found.moment_scale_u > 0.05
    assert found.origin_m == pytest.approx(0.05, abs=2.0 * found.origin_u_m)
    assert check_plate([], "plate") == PlateCheck()


# ---- one calibration for all recordings --------------------------------------------------------------


def matrix(rng, origin_m=(0.0, 0.0, 0.0), gains=(1.0,) * 6, channel=None):
    """Calibration of twelve transducers, with a shifted origin, other gains, or one channel at half gain."""
    f, m = rng.standard_normal((2, 3, 12)) * [[[400.0]], [[150.0]]]
    f, m = np.reshape(gains, (2, 3, 1)) * [f, m]
    found = np.vstack([f, m - np.cross(origin_m, f.T).T])
    if channel is not None:
        found[:, channel] *= 0.5
    return found


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"origin_m": (0.0, 0.017, 0.0)}, "origin moved by 17 mm along y"),
        ({"origin_m": (0.0, 0.0, -0.024)}, "origin moved by -24 mm along z"),
        ({"gains": (1.0, 0.88, 1.0, 1.0, 1.0, 1.0)}, "gain of F_y times 0.88"),
        (
            {"gains": (1.07,) * 6, "origin_m": (0.0, 0.009, 0.011)},
            "9 mm along y and 11 mm along z, gain",
        ),
        ({"channel": 5}, "other weights of the transducers"),
        ({}, ""),
        ({"origin_m": (0.0, 0.001, 0.0), "gains": (1.004,) * 6}, ""),
    ],
)
def test_difference_of_two_calibrations_is_told(changes, words):
    sound, other = (matrix(np.random.default_rng(8), **change) for change in ({}, changes))
    found, flag = calibration_difference(sound, other), calibration_fault(sound, other)
    assert words in found if words else found == ""
    assert flag == (("other-calibration",) if words else ())


@pytest.mark.parametrize(
    ("changes", "flag"),
    [
        ({"origin_m": (0.0, 0.0045, 0.0)}, "calibration-differs"),
        ({"origin_m": (0.0, 0.0055, 0.0)}, "other-calibration"),
        ({"gains": (1.0, 1.025, 1.0, 1.0, 1.0, 1.0)}, "calibration-differs"),
        ({"gains": (1.0, 1.0, 1.0, 0.965, 1.0, 1.0)}, "other-calibration"),
    ],
)
def test_a_large_difference_of_two_calibrations_has_another_flag(changes, flag):
    sound, other = (matrix(np.random.default_rng(8), **change) for change in ({}, changes))
    assert calibration_fault(sound, other) == (flag,)


def test_calibrations_are_compared_where_both_are_known():
    one = matrix(np.random.default_rng(3))
    assert calibration_difference(None, one) == calibration_difference(one, None) == ""
    assert calibration_difference(one, one[:, :6]) == "6 transducers instead of 12"
    assert calibration_fault(one, one[:, :6]) == ("other-calibration",)


def test_recordings_of_weights_keep_their_calibration_and_faults():
    rng = np.random.default_rng(12)
    one, other = matrix(rng), matrix(rng)
    trials = [
        Trial(250.0, {}, {}, {"calibration_right": x.tolist(), "faults": faults})
        for x, faults in ((one, "clipped"), (one, "other-amplitude"), (other, ""))
    ]
    found = with_recordings(checked(), trials[:2], "right")
    assert found.faults == ("clipped",)
    assert found.flags == ()
    back = PlateCheck.from_result(Result.of({}, {"plate": found.facts}))
    assert (back.calibration == one).all()
    assert back.faults == ("clipped",)
    assert with_recordings(checked(), trials, "right").faults == ("clipped", "other-calibration")
