"""Elements of stiffness and damping matrices that perturbations determine; the others are refused.

The Fisher information F of `tepsipe.identification.several_joints.matrices`, with every parameter in parts
of its natural size sqrt(K_ii K_jj), sqrt(B_ii B_jj), is examined three ways: directions of all parameters
whose standard error is below a limit (rank), standard errors of single elements, and movements v of the
joints for which the torques K v are known although the elements of K are not. With m perturbations the
joints are moved along about m movements only, and others are known from the shape of the responses in time
alone, if at all.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Annotated

import numpy as np
import scipy

from tepsipe.identification.several_joints.matrices import MatrixFit, Setting
from tepsipe.quantities import Positive


@dataclass(frozen=True)
class Limits:
    """Largest error of a parameter that counts as determined; the constants of inertia have that of B."""

    stiffness_percent: Positive = 15.0
    """Half width of a 95 % interval of *K*<sub>ij</sub> in per cent of √(*K*<sub>ii</sub> *K*<sub>jj</sub>),
    and standard error of every direction of the unknowns."""
    damping_percent: Positive = 50.0
    """The same of *B*."""

    @property
    def stiffness(self) -> float:
        """Limit of K_ij in parts of sqrt(K_ii K_jj)."""
        return 0.01 * self.stiffness_percent

    def of(self, setting: Setting, q: int) -> np.ndarray:
        """Limit of every parameter, shape (q,)."""
        pairs = len(setting.pairs)
        return np.r_[np.full(pairs, self.stiffness), np.full(q - pairs, 0.01 * self.damping_percent)]


@dataclass(frozen=True)
class Determined:
    """Directions and parameters determined by a Fisher information."""

    rank: int
    """Directions of the parameters, in parts of their limits, with a standard error below 1."""
    unknowns: int
    """Number of parameters."""
    condition: float
    """Condition of the information of the scaled parameters: largest over smallest eigenvalue."""
    errors: Annotated[np.ndarray, "(q,)"]
    """Standard errors in parts of the scale."""
    entries: Annotated[np.ndarray, "(q,)"]
    """Whether the 95 % interval of a parameter is within its limit."""
    directions: Annotated[np.ndarray, "(n, n)"]
    """Rows: movements of the joints, in parts of 1/sqrt(K_ii), from the best to the least determined."""
    direction_errors: np.ndarray
    """Largest standard error of the torque of a joint against each movement, in parts of the scale."""

    @property
    def all(self) -> bool:
        """True if every direction and every parameter is determined."""
        return self.rank == self.unknowns and bool(self.entries.all())


def determined(
    setting: Setting,
    information_: Annotated[np.ndarray, "(q, q)"],
    scale: Annotated[np.ndarray, "(q,)"],
    limits: Limits,
) -> Determined:
    """Find the directions and parameters that a Fisher information determines within limits.

    scale: natural size of the parameters (units of the parameters).
    limits: in parts of the scale.
    Returns: rank, condition, errors and movements.
    """
    q, limit = scale.size, limits.of(setting, scale.size)
    natural = information_ * np.outer(scale, scale)
    values, vectors = scipy.linalg.eigh(natural)
    # below this, only rounding errors remain
    values = np.maximum(values, 1e-15 * values[-1])
    covariance = (vectors / values) @ vectors.T
    errors = np.sqrt(np.diag(covariance))
    strengths = scipy.linalg.eigvalsh(natural * np.outer(limit, limit))
    n = setting.joints
    where = np.zeros((n, n), int)
    for k, (i, j) in enumerate(setting.pairs):
        where[i, j] = k
        if setting.symmetric:
            where[j, i] = k
    blocks = np.array([covariance[np.ix_(row, row)] for row in where])
    spread, movements = scipy.linalg.eigh(blocks.sum(axis=0))
    movements = movements.T[np.argsort(spread)]
    largest = np.array([max(np.sqrt(v @ block @ v) for block in blocks) for v in movements])
    return Determined(
        int((strengths > 1.0).sum()),
        q,
        float(values[-1] / values[0]),
        errors,
        1.96 * errors <= limit,
        movements * np.sign(movements[np.arange(n), np.abs(movements).argmax(axis=1)])[:, None],
        largest,
    )


@dataclass(frozen=True)
class Entry:
    """One element of a matrix, or the reason why it has no value."""

    name: str
    """For example K_ankle_knee."""
    value: Annotated[float, "N·m/rad"]
    half_width: Annotated[float, "N·m·s/rad"]
    """Estimate and half width of its 95 % interval; NaN if refused."""
    refusal: str = ""
    """One sentence; empty if there is a value."""


def entries(fit: MatrixFit, names: Sequence[str], limits: Limits, known: Determined) -> list[Entry]:
    """Elements of K and B with their 95 % intervals (N·m/rad, N·m·s/rad), or refused.

    If a direction of the parameters is undetermined, the estimate along it is arbitrary. Intervals of
    elements that seem independent of it would rest on slopes at an arbitrary point, so all elements are
    refused.

    names: names of the joints.
    limits: largest half width of an interval in parts of sqrt(K_ii K_jj), sqrt(B_ii B_jj).
    known: directions determined by the information at the estimate.
    Returns: elements of K, then of B, by rows.
    """
    pairs = fit.setting.pairs
    limit = limits.of(fit.setting, fit.parameters.size)
    elements = []
    for kind, (i, row), (j, column) in product("KB", enumerate(names), enumerate(names)):
        place = pairs.index((i, j) if (i, j) in pairs else (j, i))
        k = place if kind == "K" else len(pairs) + place
        elements.append(_entry(fit, f"{kind}_{row}_{column}", k, limit[k], known))
    return elements


def _entry(fit: MatrixFit, name: str, k: int, limit: float, known: Determined) -> Entry:
    """One element of K or B, the parameter at place ``k``, with its interval or the reason of its refusal."""
    value, half = fit.interval(np.eye(fit.parameters.size)[k])
    share = max(half / fit.scale[k], 1.96 * known.errors[k])
    if known.rank < known.unknowns:
        return _refused(
            name,
            f"the perturbations determine {known.rank} of {known.unknowns} directions of the unknowns",
        )
    if share > limit:
        return _refused(
            name,
            f"its 95 % interval is ±{100.0 * share:.2g} % of sqrt({name[0]}_ii {name[0]}_jj), more than "
            f"{100.0 * limit:g} %",
        )
    return Entry(name, value, half)


def _refused(name: str, reason: str) -> Entry:
    return Entry(name, float("nan"), float("nan"), f"{name} is not determined: {reason}")
