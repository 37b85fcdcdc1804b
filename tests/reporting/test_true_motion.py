"""The linear joint nearest to a true one: exact for a linear joint, between its ends for one that softens."""

import numpy as np
import pytest

from tepsipe.errors import InputError
from tepsipe.reporting.recovery import TrueMotion, linear_truth, read_true_motion
from tepsipe.virtual_lab import truth_file


def swinging(torque):
    t = np.arange(-0.5, 6.0, 0.002)
    moved = (np.sin(9.0 * t) + 0.5 * np.sin(31.0 * t) + 0.2 * np.sin(57.0 * t)) * np.exp(-0.3 * t)
    angle = 0.001 + 0.02 * np.where(t > 0.0, moved, 0.0)
    rate = np.gradient(angle, t)
    acceleration = np.gradient(rate, t)
    return TrueMotion(t, angle, rate, acceleration, torque(acceleration, rate, angle))


def test_a_linear_joint_is_found_whatever_the_window_and_the_torque_at_rest():
    motion = swinging(lambda a, w, th: 0.007 * a + 0.03 * w + 10.0 * th + 0.4)
    for windows in ([(0.1, 0.3)], [(0.1, 5.0)], [(1.0, 1.2), (2.0, 2.5)]):
        found = linear_truth(motion, windows)
        assert found == pytest.approx({"I": 0.007, "B": 0.03, "K": 10.0}, rel=1e-6)


def test_a_softening_joint_is_softer_where_it_moves_more():
    motion = swinging(lambda a, w, th: 10.0 * (th - 0.001) / (1.0 + ((th - 0.001) / 0.02) ** 2))
    early, late = (linear_truth(motion, [window])["K"] for window in ((0.05, 1.0), (4.5, 5.5)))
    assert 5.0 < early < late < 10.0


def test_a_window_without_motion_is_refused():
    with pytest.raises(InputError, match=r"expected motion from -0\.40 to -0\.20 s, found none"):
        linear_truth(swinging(lambda a, w, th: th), [(-0.4, -0.2)])


def test_the_file_holds_the_motion_from_the_trigger_on(tmp_path):
    motion = swinging(lambda a, w, th: 10.0 * th)
    truth_file.write_true_motion(
        tmp_path / "motion.h5",
        truth_file.TrueMotion(**{k: x for k, x in vars(motion).items() if k != "active"}),
    )
    read = read_true_motion(tmp_path / "motion.h5")
    kept = motion.time >= 0.0
    np.testing.assert_array_equal(read.angle, motion.angle[kept])
    assert linear_truth(read, [(0.1, 2.0)])["K"] == pytest.approx(10.0)
    (tmp_path / "motion.h5").write_bytes(b"no HDF5")
    with pytest.raises(InputError, match="expected the laboratory's motion"):
        read_true_motion(tmp_path / "motion.h5")
