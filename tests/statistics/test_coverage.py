"""Shares of estimates that are clustered by laboratory, and their intervals."""

import math

import pytest
import scipy

from tepsipe.statistics.coverage import clopper_pearson, share_of


def test_interval_of_a_share_is_that_of_clopper_and_pearson():
    # all of ten: low = 0.025^(1/10); none of ten: high = 1 - 0.025^(1/10)
    assert clopper_pearson(10, 10) == pytest.approx((0.025**0.1, 1.0))
    assert clopper_pearson(0, 10) == pytest.approx((0.0, 1.0 - 0.025**0.1))
    # tables of the binomial distribution: 0.443905 to 0.974789 for 8 of 10
    assert clopper_pearson(8, 10) == pytest.approx((0.443905, 0.974789), abs=1e-6)
    low, _ = clopper_pearson(8, 10)
    assert scipy.stats.binom.sf(7, 10, low) == pytest.approx(0.025)


def test_independent_estimates_have_the_binomial_interval():
    share = share_of([True] * 8 + [False] * 2, list(range(10)))
    # one estimate per laboratory: var = 10/9 (8 0.2^2 + 2 0.8^2) / 100, n_eff = 0.16 / var = 9
    assert (share.n, share.held, share.clusters, share.value) == (10, 8, 10, 0.8)
    # not fewer than there are laboratories
    assert (share.low, share.high) == pytest.approx(clopper_pearson(8, 10))


def test_estimates_of_a_laboratory_count_together_when_they_agree():
    held = [True, True] * 8 + [False, False] * 2
    whole = share_of(held, [k // 2 for k in range(20)])
    assert (whole.n, whole.clusters) == (20, 10)
    # each laboratory wholly covered or not: as ten, not as twenty
    assert (whole.low, whole.high) == pytest.approx(clopper_pearson(8, 10))
    # x = 2, 1, 1, 0 of 2 each: p = 0.5, var = 4/3 (1 + 0 + 0 + 1) / 64 = 1/24, n_eff = 0.25 24 = 6
    mixed = share_of([True, True, True, False, True, False, False, False], [0, 0, 1, 1, 2, 2, 3, 3])
    assert (mixed.low, mixed.high) == pytest.approx(clopper_pearson(3, 6))


def test_share_of_all_counts_laboratories_and_of_none_is_not_a_number():
    all_held = share_of([True] * 20, [k // 4 for k in range(20)])
    assert (all_held.low, all_held.high) == pytest.approx((0.025**0.2, 1.0))
    nothing = share_of([], [])
    assert nothing.n == 0 and math.isnan(nothing.value) and math.isnan(nothing.low)
