"""Numbers that are positive by definition are drawn from a distribution that is cut off at 0."""

import numpy as np
import pytest
from scipy import stats

from tepsipe.virtual_lab.drawn_laboratories import draw_laboratory, drawn_numbers
from workflow.support.yaml_file import read_settings


def values(entry, nominal=1.0, seeds=3000):
    made = ({"seed": seed, "share": nominal, "drawn": {"share": entry}} for seed in range(seeds))
    return np.array([draw_laboratory(constants)["share"] for constants in made])


@pytest.mark.parametrize(
    ("entry", "nominal"),
    [
        ({"normal": 0.8, "relative": True}, 1.0),
        ({"normal": 0.8, "positive": True}, 1.0),
        ({"normal": 0.8, "relative": True}, -1.0),
    ],
)
def test_wide_distribution_is_cut_off_at_zero_and_keeps_its_shape_elsewhere(entry, nominal):
    found = values(entry, nominal) * np.sign(nominal)
    assert (found > 0.0).all()
    expected = stats.truncnorm(-1.0 / 0.8, np.inf, loc=1.0, scale=0.8)
    assert stats.kstest(found, expected.cdf).pvalue > 0.01


def test_share_stays_between_its_limits():
    found = values({"normal": 0.5, "relative": True, "below": 1.0}, 0.6)
    assert (found > 0.0).all()
    assert 0.95 < found.max() < 1.0
    expected = stats.truncnorm(-2.0, 4.0 / 3.0, loc=0.6, scale=0.3)
    assert stats.kstest(found, expected.cdf).pvalue > 0.01


def test_only_draws_beyond_zero_change():
    free, kept = values({"normal": 0.8}), values({"normal": 0.8, "positive": True})
    beyond = free <= 0.0
    assert 0.05 < beyond.mean() < 0.15
    np.testing.assert_array_equal(kept[~beyond], free[~beyond])


def test_signed_offset_may_still_fall_on_either_side():
    assert 0.1 < (values({"normal": 1.0}) < 0.0).mean() < 0.2


@pytest.mark.slow
@pytest.mark.parametrize("change", [{"shift": 1.0}, {"student": 3}])
def test_shipped_constants_stay_physical_in_shifted_and_heavy_tailed_laboratories(root, change):
    constants = read_settings(root / "config/virtual_lab.yaml")
    signed = [path for path, entry in constants["drawn"].items() if not {"relative", "positive"} & set(entry)]
    for entry in constants["drawn"].values():
        if "shift" in change:
            entry["shift"] = change["shift"]
        elif "normal" in entry:
            entry["student"] = [entry.pop("normal"), change["student"]]
    for seed in range(300):
        for number in drawn_numbers(constants | {"seed": seed}):
            if not any(number.path == path or number.path.startswith(f"{path}.") for path in signed):
                assert number.value > 0.0


@pytest.mark.parametrize(
    ("entry", "nominal", "part"),
    [
        ({"rectangular": 0.1, "positive": True}, -1.0, "says that it lies (positive, below), found -1"),
        ({"rectangular": 0.1, "below": 1.0}, 2.0, "found 2: correct"),
        ({"rectangular": 0.1, "relative": True, "shift": 1e6}, 1.0, "with the sign of 1 and below its limit"),
    ],
)
def test_impossible_signs_are_refused_in_one_sentence(entry, nominal, part):
    with pytest.raises(ValueError, match=r"^expected") as caught:
        values(entry, nominal, seeds=20)
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)
