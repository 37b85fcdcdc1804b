"""The toy format's markers come back in metres, and a damaged file is refused."""

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.io.formats import contents_of, read_markers


def good_files(folder):
    path = folder / "good.toy"
    path.write_text("TOY 100\nankle knee\n1 2 3 4 5 6\n7 8 9 nan 11 12\n")
    return [path]


def test_markers_come_back(tmp_path):
    (path,) = good_files(tmp_path)
    markers = read_markers(path, ["knee"])
    assert markers.rate_hz == 100.0
    np.testing.assert_allclose(markers.positions[:, 0], [[0.004, 0.005, 0.006], [np.nan] * 3])
    assert contents_of(path).markers == ("ankle", "knee")


def test_row_that_was_cut_is_refused(tmp_path):
    path = tmp_path / "cut.toy"
    path.write_text("TOY 100\nankle\n1 2 3\n4 5\n")
    with pytest.raises(InputError) as caught:
        read_markers(path, ["ankle"])
    assert_one_sentence(caught.value, path, "three numbers")
