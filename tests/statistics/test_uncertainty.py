"""Budgets against the examples of the GUM, and against draws."""

import math

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.statistics.uncertainty import (
    Budget,
    Source,
    coverage_factor,
    error_of_mean,
    in_quadrature,
    linear_contributions,
    root_of_draws,
    scatter,
    sources_of,
    stated_sources,
)


def test_end_gauge_of_the_gum():
    # JCGM 100, example H.1: contributions of 25 (18), 9.7 (25.6), 2.9 (50) and 16.6 (2) nm give u_c = 32 nm,
    # 16 degrees of freedom, and with t_99(16) = 2.92 an expanded uncertainty of 93 nm
    budget = Budget(
        np.array([9.7]),
        25.6,
        {"standard": np.array([[25.0]]), "theta": np.array([[2.9]]), "alpha": np.array([[16.6]])},
        {"standard": 18.0, "theta": 50.0, "alpha": 2.0},
    )
    assert budget.combined[0] == pytest.approx(31.7, abs=0.05)
    assert int(budget.effective_freedom[0]) == 16
    low, high = budget.interval(np.array([0.0]), 0.99)
    # the GUM truncates to 16 degrees of freedom; 16.7 give t = 2.90
    assert high[0] == pytest.approx(92.0, abs=0.2)
    assert low[0] == -high[0]


def test_linear_contributions_agree_with_draws_of_a_product():
    def stiffness(deviation):
        mass, length = 0.4 + deviation.get("mass", 0.0), 0.45 + deviation.get("length", 0.0)
        return np.array([mass * length, 2.0 * mass])

    sources = [Source("mass", 0.004), Source("length", 0.002, "rectangular")]
    budget = Budget(np.zeros(2), np.inf, linear_contributions(stiffness, sources))
    rng = np.random.default_rng(2)
    masses = 0.004 * rng.standard_normal(20_000)
    lengths = 0.002 * np.sqrt(3.0) * rng.uniform(-1.0, 1.0, 20_000)
    drawn = np.array([stiffness({"mass": m, "length": x}) for m, x in zip(masses, lengths, strict=True)])
    np.testing.assert_allclose(budget.type_b, drawn.std(axis=0), rtol=0.02)
    assert budget.contributions["length"][0, 1] == 0.0


def test_common_source_cancels_in_a_difference():
    stiff = Budget(np.array([3.0]), 13.0, {"centre": np.array([[20.0]]), "foot": np.array([[1.0]])})
    relaxed = Budget(np.array([4.0]), 13.0, {"centre": np.array([[18.0]]), "skin": np.array([[2.0]])})
    difference = stiff.minus(relaxed)
    assert difference.type_a[0] == pytest.approx(5.0)
    assert difference.of_source("centre")[0] == pytest.approx(2.0)
    assert difference.type_b[0] == pytest.approx(3.0)
    assert difference.combined[0] < stiff.combined[0]
    # Welch and Satterthwaite of 3 and 4 with 13 degrees of freedom each
    assert difference.freedom_a == pytest.approx(13.0 * 625.0 / (81.0 + 256.0))


def test_draws_must_be_shared_in_a_difference():
    a = Budget(np.ones(1), 3.0, {"model": np.ones((10, 1))})
    with pytest.raises(ValueError, match="shared draws, found 10 and 12"):
        a.minus(Budget(np.ones(1), 3.0, {"model": np.ones((12, 1))}))


def test_root_of_draws_is_a_root_of_their_covariance():
    draws = np.random.default_rng(3).normal(size=(50, 3)) @ np.array([[1, 2, 0], [0, 1, 0], [1, 0, 3.0]])
    root = root_of_draws(draws)
    np.testing.assert_allclose(root.T @ root, np.cov(draws.T), rtol=1e-12)


def test_interval_of_a_mean_of_14_perturbations_covers_95_percent():
    rng = np.random.default_rng(4)
    held = []
    for _ in range(4000):
        values = rng.normal(10.0, 0.5, (14, 1))
        low, high = Budget(*scatter(values)).interval(values.mean(axis=0))
        held.append(low[0] <= 10.0 <= high[0])
    assert np.mean(held) == pytest.approx(0.95, abs=0.01)


def test_limits_of_the_coverage_factor():
    assert coverage_factor(np.array([np.inf]))[0] == pytest.approx(1.96, abs=1e-3)
    assert coverage_factor(np.array([13.0]))[0] == pytest.approx(2.160, abs=1e-3)


def test_one_perturbation_has_no_interval():
    u, freedom = scatter(np.ones((1, 2)))
    low, high = Budget(u, freedom).interval(np.ones(2))
    assert np.isneginf(low).all() and np.isposinf(high).all()


def test_scatter_of_two_estimates_is_that_of_their_mean():
    u, freedom = scatter(np.array([[1.0, 10.0], [3.0, 10.0]]))
    assert u == pytest.approx([1.0, 0.0])
    assert freedom == 1.0
    assert np.isinf(scatter(np.array([[1.0]]))[0]).all()


def test_error_of_a_mean_counts_the_slowest_cosines():
    n = 400
    for j in (1, 8):
        slow = np.cos(np.pi * j * (np.arange(n) + 0.5) / n)
        # c_j = sqrt(n / 2), the other seven are 0: u = sqrt(n / 2 / 8 / n)
        assert error_of_mean(5.0 + slow) == (pytest.approx(0.25), 8.0)
    assert error_of_mean(np.cos(np.pi * 9 * (np.arange(n) + 0.5) / n))[0] == pytest.approx(0.0, abs=1e-12)


def test_sources_of_the_settings_are_read_and_impossible_ones_refused():
    stated = {"standard_uncertainty": 0.1, "distribution": "normal", "source": "scale"}
    found = sources_of({"leg_mass_kg": stated, "leg_com_m": None})
    assert list(found) == ["leg_mass_kg"]
    assert found["leg_mass_kg"].standard_uncertainty == 0.1
    for change, words in (
        ({"standard_uncertainty": -0.1}, "leg_mass_kg: expected a number of at least 0"),
        ({"standard_uncertainty": math.nan}, "leg_mass_kg: expected a finite number"),
        ({"distribution": "gaussian"}, "distribution"),
    ):
        with pytest.raises(InputError) as caught:
            sources_of({"leg_mass_kg": stated | change})
        assert_one_sentence(caught.value, words)


def test_stated_sources_are_numbers_of_at_least_zero():
    found = stated_sources({"leg_mass_kg": 0.1}, ("leg_mass_kg",), "fit")
    assert found["leg_mass_kg"].standard_uncertainty == 0.1
    assert stated_sources(None, ("leg_mass_kg",), "fit") == {}
    for u in (-1.0, math.nan, math.inf, "0.1", True):
        with pytest.raises(InputError) as caught:
            stated_sources({"leg_mass_kg": u}, ("leg_mass_kg",), "fit")
        assert_one_sentence(caught.value, "at least 0 for leg_mass_kg")


def test_sum_in_quadrature_by_hand():
    u, freedom = in_quadrature((np.array([3.0, 0.0]), 5.0), (np.array([4.0, 0.0]), 10.0))
    assert u.tolist() == [5.0, 0.0]
    # Welch and Satterthwaite: 5^4 / (3^4 / 5 + 4^4 / 10)
    assert freedom == pytest.approx([625.0 / (81.0 / 5.0 + 25.6), 5.0])


def test_sources_that_are_no_mapping_or_unknown_are_refused():
    for stated, words in (([("leg_mass_kg", 0.1)], "a mapping"), ({"leg_mass": 0.1}, "a known source")):
        with pytest.raises(InputError) as caught:
            stated_sources(stated, ("leg_mass_kg",), "fit")
        assert_one_sentence(caught.value, "fit, uncertainty", words, "leg_mass_kg")
