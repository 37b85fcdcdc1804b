"""Conversion of units, both ways, and options of a file that an annotated dataclass describes."""

import math
from dataclasses import dataclass, make_dataclass
from typing import Annotated, Literal, get_args, get_origin

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe import Signal, load_example, quantities
from tepsipe.arguments import (
    OPTIONS,
    Range,
    check_options,
    checked,
    factor,
    read_options,
    regular_rate,
    samples,
    within,
)
from tepsipe.errors import InputError
from tepsipe.signals.resampling import resample

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


@dataclass(frozen=True)
class Limit:
    """A limit as the annotations of types have it."""

    gt: float | None = None
    ge: float | None = None
    lt: float | None = None
    le: float | None = None


@dataclass(frozen=True)
class Inner:
    size_m: Annotated[float, Limit(gt=0, le=3)] = 1.0


@dataclass(frozen=True, kw_only=True)
class Outer:
    count: Annotated[int, Limit(ge=1)]
    share: Annotated[float, Limit(ge=0), Limit(lt=1)] | None = None
    kind: Literal["a", "b"] = "a"
    open: bool = False
    inner: Inner = Inner()


def test_options_of_a_file_are_read_as_their_dataclass_is_annotated():
    found = read_options(Outer, {"count": 2, "share": 0, "inner": {"size_m": 3}}, "here")
    assert Outer(**found) == Outer(count=2, share=0.0, inner=Inner(3.0))
    assert read_options(Outer, {"count": 1, "share": None}, "here")["share"] is None
    assert read_options(Outer, {}, "here", ["kind"]) == {}


@pytest.mark.parametrize(
    ("mapping", "words"),
    [
        ({}, "here: expected the key count, found none: add it"),
        ([], "here: expected keys and values"),
        ({"coun": 1}, "here: expected a known key, found 'coun': did you mean 'count'?"),
        ({"count": 0}, "here: expected a number of at least 1 for 'count', found 0"),
        ({"count": 1.0}, "here: expected a value of type integer for 'count', found 1.0"),
        ({"count": True}, "here: expected a value of type integer for 'count', found True"),
        ({"count": None}, "here: expected a value of type integer for 'count', found None"),
        ({"count": 1, "share": 1}, "here: expected a number below 1 for 'share', found 1"),
        ({"count": 1, "share": math.nan}, "here: expected a finite number for 'share'"),
        ({"count": 1, "kind": "c"}, "here: expected one of 'a', 'b' for 'kind', found 'c'"),
        ({"count": 1, "open": "yes"}, "here: expected a value of type boolean for 'open', found 'yes'"),
        ({"count": 1, "inner": {"size_m": 0}}, "here.inner: expected a number above 0 for 'size_m', found 0"),
        ({"count": 1, "inner": {"size_m": 3.1}}, "here.inner: expected a number of at most 3 for 'size_m'"),
    ],
)
def test_options_of_a_file_are_refused_in_one_sentence(mapping, words):
    with pytest.raises(InputError) as refused:
        read_options(Outer, mapping, "here")
    assert str(refused.value).startswith(words)


def ends(wanted):
    """At each end of a range, a number that it takes and the next one, which it refuses."""
    for end, allowed, step in ((wanted.low, wanted.low_allowed, -1), (wanted.high, wanted.high_allowed, 1)):
        if math.isfinite(end):
            end, step = (int(end), step) if wanted.whole else (end, 1e-9 * step)
            yield (end, end + step) if allowed else (end - step, end)


RANGES = {name: wanted for name, wanted in OPTIONS.items() if isinstance(wanted, Range)}
KINDS = {
    name: kind
    for name, kind in vars(quantities).items()
    if get_origin(kind) is Annotated and get_args(kind)[0] in (float, int) and list(ends(within(kind)))
}


@pytest.mark.parametrize("name", RANGES)
def test_an_option_is_taken_up_to_its_ends(name):
    for taken, refused in ends(RANGES[name]):
        assert checked(**{name: taken}) == (taken,)
        with pytest.raises(InputError) as caught:
            checked(**{name: refused})
        assert_one_sentence(caught.value, f"{name}: expected ")


@pytest.mark.parametrize("name", KINDS)
def test_a_setting_is_taken_up_to_its_ends(name):
    options = make_dataclass("Options", [("setting", KINDS[name])])
    for taken, refused in ends(within(KINDS[name])):
        check_options(options, {"setting": taken}, "here")
        with pytest.raises(InputError) as caught:
            check_options(options, {"setting": refused}, "here")
        assert_one_sentence(caught.value, "here: expected ", "'setting'")


@pytest.mark.parametrize("name", RANGES)
@pytest.mark.parametrize("value", [1e308, 1e13, 1e-320, 1e-13])
def test_an_option_whose_products_or_quotients_may_overflow_is_refused(name, value):
    with pytest.raises(InputError) as caught:
        checked(**{name: value})
    assert_one_sentence(caught.value, name)


def test_other_extremes_are_refused_by_a_sentence():
    time = np.arange(2000.0)
    signal = np.sin(time)
    for step in (1e-312, 1e-9, 1.0, 1e300):
        with pytest.raises(InputError, match=r"expected seconds|at most 1e") as caught:
            regular_rate(step * time)
        assert_one_sentence(caught.value, "time")
    with pytest.raises(InputError, match="for a low-pass at 1e-12 Hz, found 20 s"):
        resample(0.01 * time, signal, 0.01 * time[:5], band_hz=1e-12)
    for name in (np.array([1.0, 2.0]), ["dummy"], None, {}):
        with pytest.raises(InputError, match="expected the name of an example"):
            load_example(name)
