"""Residuals of the joint likelihood at one point, with their derivatives and the information in them.

Symbols are those of `tepsipe.identification.joint_likelihood`.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Residuals:
    """Likelihood at one point.

    Attributes
    ----------
    foot : ndarray of complex, shape (m,)
        Estimated spectrum of the foot (m times samples).
    left : ndarray of complex, shape (c, m)
        P W (z - m), with unit variance (-).
    columns : ndarray of complex, shape (p, c, m)
        u (1 over the units of the parameters).
    by_noise : ndarray of complex, shape (p, c, m)
        P W dh / |W h|, what noise in Y adds to u (1 over the units of the parameters).
    direction : ndarray of complex, shape (c, m)
        W h / |W h| (-).
    """

    foot: np.ndarray
    left: np.ndarray
    columns: np.ndarray
    by_noise: np.ndarray
    direction: np.ndarray

    @property
    def deviance(self) -> float:
        """Twice the sum of squares (-)."""
        return 2.0 * float(np.sum(np.abs(self.left) ** 2))

    @property
    def information(self) -> np.ndarray:
        """F_0, shape (p, p) (1 over the units of the parameters, squared)."""
        return _products(self.columns)

    @property
    def excess(self) -> np.ndarray:
        """What noise in Y adds to F_0, shape (p, p) (units as F_0)."""
        return _products(self.by_noise)

    @property
    def gradient(self) -> np.ndarray:
        """2 Re sum u^H P W (z - m), shape (p,) (1 over the units of the parameters)."""
        left = self.left.ravel()
        columns = self.columns.reshape(len(self.columns), -1)
        return 2.0 * (columns.real @ left.real + columns.imag @ left.imag)


def _products(columns: np.ndarray) -> np.ndarray:
    """2 Re sum of u_i^H u_j, shape (p, p)."""
    flat = columns.reshape(len(columns), -1)
    return 2.0 * (flat.real @ flat.real.T + flat.imag @ flat.imag.T)
