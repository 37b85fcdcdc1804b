"""Identifiability of parameters that are estimated with instruments.

Per band l, the regressors x have cross products A_l that are linear in the perturbation and C_l that are not;
by chance A_l contains m/(b - m) C_l of noise. With the noise s_l of the residual,

    N = sum_l 2 m/(b - m) C_l / s_l,     F = sum_l 2 A_l / s_l - N                                     (1)

F is the Fisher information of the parameters, N what noise alone would show as such. Directions w of the
parameters with F w = (r - 1) N w, w'N w = 1, have the strength r (Cragg and Donald 1993). With one
perturbation all angles are responses to one signal u: theta_j = H_j u, and any change of the impedance with

    sum_j dZ_ij(s) H_j(s) = 0                                                                         (2)

leaves the torque that u drives the same. In the mechanics of a body without delays, H_j = N_j(s)/D(s) with
polynomials N_j of second order, so dZ = c [N_2, -N_1] is such a change: a model of K and B alone excludes it,
one with terms of inertia or with a free delayed K and B for every angle does not. If joints move in
proportion, (2) holds for K and B, too. Directions of a strength below a limit are not determined, and neither
is a parameter to which they contribute.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

# signal-to-noise ratio assumed for a direction that is too weak
CONCEDED = 0.02


@dataclass(frozen=True)
class Directions:
    """Directions of the parameters and the information along each."""

    strength: Annotated[np.ndarray, "(q,)"]
    """Power in the bands with the perturbation over the power of noise alone, from weak to strong."""
    vectors: Annotated[np.ndarray, "(q, q)"]
    """Columns: one standard deviation of noise along each direction (units of the parameters)."""
    influence: Annotated[np.ndarray, "(L, q)"]
    """Change of the parameters without one band, along the directions that are determined (units of the
    parameters)."""
    limit: float
    """Least strength of a direction that is determined."""

    def in_units(self, factor: np.ndarray) -> "Directions":
        """The same for parameters multiplied by ``factor``, shape (q,) (unit of the result over its own)."""
        return Directions(
            self.strength,
            self.vectors * factor[:, None],
            self.influence * factor,
            self.limit,
        )

    def standard_error(self, combination: np.ndarray) -> float:
        """Standard error of a linear combination of the parameters, shape (q,): jackknife over the bands.

        Directions that are too weak count with a signal of 2 % of noise, so that a combination to which they
        contribute has a large standard error.
        """
        weak = self.strength < self.limit
        loads = combination @ self.vectors[:, weak]
        bands = self.influence.shape[0]
        chance = ((self.influence @ combination) ** 2).sum() * (bands - 1) / bands
        return float(np.sqrt(chance + (loads**2).sum() / CONCEDED))

    def weak_partners(self, combination: np.ndarray) -> np.ndarray:
        """Parameters that a weak direction of a combination also moves, shape (q,), relative."""
        loads = combination @ self.vectors
        weak = self.strength < self.limit
        if not weak.any():
            return np.zeros(combination.size)
        k = int(np.flatnonzero(weak)[np.abs(loads[weak]).argmax()])
        return np.abs(self.vectors[:, k])


def directions_by_strength(
    a: Annotated[np.ndarray, "(L, 1 + q, 1 + q)"],
    c: Annotated[np.ndarray, "(L, 1 + q, 1 + q)"],
    v: Annotated[np.ndarray, "(1 + q,)"],
    noise: Annotated[np.ndarray, "(L,)"],
    chance: float,
    limit: float,
) -> Directions:
    """Directions of the parameters by strength (1).

    a, c: cross products of response and regressors that are, and are not, linear in the perturbation
    (squared units of the columns).
    v: 1 and the negative parameters (units of the parameters).
    noise: power of the residual's noise in each band (squared unit of the response).
    chance: m/(b - m), fraction of C that A contains by chance.
    limit: least strength of a direction that is determined.
    """
    total = 2.0 * np.einsum("l,lij->ij", 1.0 / noise, a)[1:, 1:]
    alone = 2.0 * chance * np.einsum("l,lij->ij", 1.0 / noise, c)[1:, 1:]
    # without any noise, rounding errors take its place
    alone = alone + 1e-12 * np.trace(total) / total.shape[0] * np.eye(total.shape[0])
    strength, vectors = scipy.linalg.eigh(total, alone)
    strong = vectors[:, strength >= limit]
    signal = strength[strength >= limit] - 1.0
    # one Newton step from the estimate without a band: its gradient over the information of the others
    weighted = 2.0 * (a - chance * c) / noise[:, None, None]
    gradient = (weighted @ v)[:, 1:] @ strong
    others = np.diag(signal) - strong.T @ weighted[:, 1:, 1:] @ strong
    influence = np.linalg.solve(others, gradient[:, :, None])[:, :, 0] @ strong.T
    return Directions(strength, vectors, influence, limit)
