"""Markers of a segment, its pose, and its motion from them."""

import numpy as np
import pytest
from builders import assert_one_sentence, refused

from tepsipe.errors import InputError
from tepsipe.mechanics.segment_kinematics import (
    SegmentMarkers,
    fit_rigid_segment,
    joint_motion,
    refuse_loose,
    segment_motion,
)

LAYOUT = np.array([[0.0, 0.0], [-0.012, 0.87], [0.012, 0.63], [0.1, 0.39]])
CENTRE = np.array([0.0, 0.4485])


def place(points, angle, origin):
    """Turn points (across, along) by an angle towards +y and put their origin somewhere."""
    toppled = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return np.asarray(origin) + points @ toppled.T


@pytest.mark.parametrize("angle", [0.0, 0.01, -0.3, 1.5, np.pi - 0.01, -2.0])
def test_pose_of_a_turned_and_moved_segment_is_found(angle):
    markers = place(LAYOUT, angle, (0.3, -1.2))[None]
    pose = fit_rigid_segment(markers, LAYOUT, CENTRE)
    assert pose.angle == pytest.approx([angle], abs=1e-14)
    assert pose.point[0] == pytest.approx(place(CENTRE, angle, (0.3, -1.2)), abs=1e-14)
    assert pose.marker_residual_rms_m < 1e-14


def test_angle_is_positive_when_the_segment_tips_forward():
    tipped = np.array([[[0.0, 0.0], [0.1, 1.0]]])
    pose = fit_rigid_segment(tipped, np.array([[0.0, 0.0], [0.0, 1.0]]), CENTRE)
    assert pose.angle[0] == pytest.approx(np.arctan(0.1), rel=1e-12)


def test_angle_does_not_depend_on_where_the_segment_is(rng):
    markers = place(LAYOUT, 0.2, (0.0, 0.0)) + 1e-3 * rng.standard_normal((50, 4, 2))
    here = fit_rigid_segment(markers, LAYOUT, CENTRE)
    moved = np.array([5.0, -2.0])
    there = fit_rigid_segment(markers + moved, LAYOUT, CENTRE)
    assert there.angle == pytest.approx(here.angle, abs=1e-12)
    assert there.point == pytest.approx(here.point + moved, abs=1e-12)
    assert there.marker_residual_rms_m == pytest.approx(here.marker_residual_rms_m, rel=1e-9)


def test_stretched_segment_is_off_by_half_its_stretch_at_either_end():
    layout = np.array([[0.0, 0.0], [0.0, 1.0]])
    stretched = np.array([[[0.0, -0.003], [0.0, 1.003]]])
    pose = fit_rigid_segment(stretched, layout, np.array([0.0, 0.5]))
    assert pose.marker_residual_rms_m == pytest.approx(0.003, rel=1e-12)
    assert pose.point[0] == pytest.approx([0.0, 0.5], abs=1e-15)


def test_noise_of_the_angle_is_that_of_the_markers_over_their_spread(rng):
    markers = place(LAYOUT, 0.1, (0.0, 0.0)) + 1e-4 * rng.standard_normal((20000, 4, 2))
    pose = fit_rigid_segment(markers, LAYOUT, CENTRE)
    spread = np.sqrt(np.sum((LAYOUT - LAYOUT.mean(axis=0)) ** 2))
    assert pose.angle.mean() == pytest.approx(0.1, abs=1e-5)
    assert pose.angle.std() == pytest.approx(1e-4 / spread, rel=0.03)


def test_two_markers_determine_the_angle_and_one_is_refused():
    time = np.arange(0.0, 2.0, 0.004)
    angle = 0.05 * np.sin(6.0 * time)
    knee = 0.4 * np.column_stack([np.sin(angle), np.cos(angle)])
    positions = np.stack([np.zeros_like(knee), knee], axis=1)
    found = segment_motion(time, positions, SegmentMarkers(("ankle", "knee"), [[0.0, 0.0], [0.0, 0.4]]), 0.2)
    assert found.theta == pytest.approx(angle, abs=1e-4)
    with pytest.raises(InputError) as caught:
        SegmentMarkers(("ankle",), [[0.0, 0.0]])
    assert_one_sentence(caught.value, "at least two", "'ankle'", "1 rows")


def test_rate_and_acceleration_of_a_joint_are_those_of_its_angle():
    time = np.arange(0.0, 2.0, 0.004)
    found = joint_motion(time, np.sin(3.0 * time))
    inside = slice(10, -10)
    assert found.theta_d[inside] == pytest.approx(3.0 * np.cos(3.0 * time)[inside], abs=1e-4)
    assert found.theta_dd[inside] == pytest.approx(-9.0 * np.sin(3.0 * time)[inside], abs=1e-2)


def test_labels_name_all_markers_of_the_positions():
    markers = SegmentMarkers(("a", "b"), np.array([[0.0, 0.0], [0.0, 0.4]]))
    time = np.arange(100) / 100.0
    positions = np.zeros((100, 2, 3)) + np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.4]])
    with pytest.raises(InputError) as caught:
        segment_motion(time, positions, markers, 0.2, labels=("a", "b", "c"))
    assert_one_sentence(caught.value, "expected 2 names", "found 3")


def test_positions_in_millimetres_are_refused():
    time = np.arange(0.0, 2.0, 0.004)
    positions = np.zeros((time.size, 2, 2))
    positions[:, 1] = 400.0, 1.0
    markers = SegmentMarkers(("ankle", "knee"), [[0.0, 0.0], [0.0, 0.4]])
    with pytest.raises(InputError) as caught:
        segment_motion(time, positions, markers, 0.2)
    assert_one_sentence(caught.value, "positions", "metres", "found a range of 400", "mm")


FOOT = SegmentMarkers(("toe", "heel", "ankle"), [[0.14, -0.05], [-0.05, -0.05], [0.0, 0.0]])


@pytest.mark.parametrize(
    ("seen", "advice"),
    [
        (FOOT.layout_m * [-1.0, 1.0], "if the segment faces backward: reverse the forward axis"),
        (FOOT.layout_m[[1, 0, 2]], "if 'toe' and 'heel' are exchanged: correct their labels or places"),
        (FOOT.layout_m[[0, 2, 1]], "if 'heel' and 'ankle' are exchanged"),
        (FOOT.layout_m * [1.6, 1.0], "on average: check their layout and order"),
    ],
)
def test_markers_that_are_not_one_body_are_refused_with_the_layout_that_would_fit(seen, advice):
    seen = seen + 0.001 * np.random.default_rng(1).standard_normal((50, 3, 2))
    pose = fit_rigid_segment(seen, FOOT.layout_m, np.zeros(2))
    with pytest.raises(InputError) as caught:
        refuse_loose(pose, seen, FOOT, "foot")
    assert_one_sentence(caught.value, "markers of the foot", "one rigid body", advice)


def test_layout_that_determines_no_pose_is_refused():
    refused(lambda: SegmentMarkers(("a", "a"), [[0, 0], [0, 1]]), "different labels")
    refused(lambda: SegmentMarkers(("a", "b"), [[0, 0], [0, 870]]), "mm")
    refused(lambda: SegmentMarkers(("a", "b"), [0.0, 1.0]), "shape (n, 2)")
