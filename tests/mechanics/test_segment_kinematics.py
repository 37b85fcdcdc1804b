"""Markers of a segment, and its motion from them."""

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.mechanics.segment_kinematics import SegmentMarkers, segment_motion


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
