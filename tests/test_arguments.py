"""Conversion of units: the factor of every pair, both ways, and what has none."""

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe import Signal
from tepsipe.arguments import factor, samples
from tepsipe.errors import InputError

# what one unit is in the other
DEGREE = 0.017453292519943295
KNOWN = [
    *[("ms", "s", 0.001), ("us", "s", 0.000001), ("mm", "m", 0.001), ("cm", "m", 0.01)],
    *[("mm/s", "m/s", 0.001), ("cm/s", "m/s", 0.01), ("km/h", "m/s", 1000.0 / 3600.0)],
    *[("deg", "rad", DEGREE), ("°", "rad", DEGREE), ("mrad", "rad", 0.001), ("deg/s", "rad/s", DEGREE)],
    *[("Nmm", "Nm", 0.001), ("N·mm", "Nm", 0.001), ("mNm", "Nm", 0.001), ("kNm", "Nm", 1000.0)],
    *[("mN", "N", 0.001), ("kN", "N", 1000.0), ("mV", "V", 0.001), ("uV", "V", 0.000001)],
]


@pytest.mark.parametrize(("unit", "wanted", "expected"), KNOWN)
def test_units_are_converted_both_ways(unit, wanted, expected):
    assert factor(unit, wanted, "x") == pytest.approx(expected)
    assert factor(f" {unit} ", wanted, "x") == pytest.approx(expected)
    if unit.isascii():
        assert factor(wanted, unit, "x") == pytest.approx(1.0 / expected)
    assert samples(Signal(np.array([3.0]), unit), wanted, "x") == pytest.approx([3.0 * expected])


def test_units_of_another_quantity_are_refused():
    with pytest.raises(InputError) as caught:
        factor("mm", "rad", "angle")
    assert_one_sentence(caught.value, "angle", "deg, mrad, rad", "'mm'")
