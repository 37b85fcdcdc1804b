"""Covariance of a fit to clusters: known where the errors are."""

import numpy as np
import pytest

from tepsipe.statistics.clusters import bias_reduced_share, errors_over_blocks


def covariances(seed: int = 3, times: int = 600) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Variances of three parameters: true, mean of the bias-reduced ones, mean of the jackknife's."""
    rng = np.random.default_rng(seed)
    designs = [rng.standard_normal((12, 3)) for _ in range(4)]
    for design in designs[1:]:
        design[:, 2] *= 0.2  # the first cluster shows the third parameter, the others hardly
    normals = [x.T @ x for x in designs]
    normal = sum(normals)
    reduced, jackknife = np.zeros((2, 3))
    for _ in range(times):
        errors = [rng.standard_normal(12) for _ in designs]
        fitted = np.linalg.solve(normal, sum(x.T @ e for x, e in zip(designs, errors, strict=True)))
        moments = [x.T @ (e - x @ fitted) for x, e in zip(designs, errors, strict=True)]
        for own, moment in zip(normals, moments, strict=True):
            reduced += bias_reduced_share(normal, own, moment) ** 2 / times
            jackknife += np.linalg.solve(normal - own, moment) ** 2 / times
    return np.diag(np.linalg.inv(normal)), reduced, 0.75 * jackknife


def test_variance_is_unbiased_where_the_jackknife_is_several_times_too_large():
    true, reduced, jackknife = covariances()
    assert reduced == pytest.approx(true, rel=0.15)
    assert jackknife[2] > 3.0 * true[2]


def test_scaled_parameters_have_scaled_shares(rng):
    design, units = rng.standard_normal((10, 3)), np.array([1.0, 1e3, 1e-3])
    other = rng.standard_normal((20, 3))
    error = rng.standard_normal(10)

    def share(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return bias_reduced_share(x.T @ x + y.T @ y, x.T @ x, x.T @ error)

    assert share(design * units, other * units) * units == pytest.approx(share(design, other))


def test_what_one_cluster_determines_alone_has_no_share():
    alone, common = np.diag([1.0, 1.0]), np.diag([0.0, 1.0])
    found = bias_reduced_share(alone + common, alone, np.array([0.3, 0.5]))
    # of the second parameter half is its own: (1 - 1/2)^-1/2 / 2 of its moment
    assert found == pytest.approx([0.0, 0.5 * np.sqrt(2.0) / 2.0])


def test_errors_over_blocks_are_those_of_white_noise_in_any_unit(rng):
    x = rng.standard_normal((4000, 2)) * [1.0, 1e3]
    found, freedom, shares = errors_over_blocks(x, rng.standard_normal(4000), 40)
    assert found == pytest.approx([1.0 / np.sqrt(4000.0), 1e-3 / np.sqrt(4000.0)], rel=0.25)
    assert np.sqrt(np.sum(shares**2, axis=0)) == pytest.approx(found, rel=0.25)
    assert np.all((freedom > 60.0) & (freedom < 110.0))
