"""Linear least squares with the standard error and the SEM of the thesis in three readings (eqs 3-2, 3-9)."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np

# samples that are worked on at a time, which bounds the memory of long records
SPAN = 2**18
# readings of ||R|| in thesis eq (3-2)
SEM_READINGS = {
    "norm": "the Euclidean norm of the residuals",
    "count": "the number of residuals",
    "freedom": "the number of residuals less the number of parameters",
}


@dataclass(frozen=True)
class LinearFit:
    """Least-squares solution of ``J p = y`` with its measures of uncertainty.

    R are the residuals, N their number, p the number of parameters.
    """

    parameters: Annotated[np.ndarray, "(p,)"]
    """Solution (units of y over units of J's columns)."""
    residuals: Annotated[np.ndarray, "(N,)"]
    """y - J p (unit of y)."""
    sem: Annotated[np.ndarray, "(3, p)"]
    """`sems`, one row per reading."""
    condition_number: float
    """Ratio of the largest to the smallest singular value of J after scaling its columns to unit length."""

    @property
    def sem_as_printed(self) -> Annotated[np.ndarray, "(p,)"]:
        """Thesis eq (3-2) with the Euclidean norm."""
        return self.sem[0]

    @property
    def standard_error(self) -> Annotated[np.ndarray, "(p,)"]:
        """sqrt(R'R / (N - p) diag((J'J)^-1)), valid for white residuals only."""
        return self.sem[2]


def least_squares_line(
    jacobian: Annotated[np.ndarray, "(N, p)"], y: Annotated[np.ndarray, "(N,)"]
) -> LinearFit:
    """Solve a linear least-squares problem (thesis eq 3-9 solved per data segment).

    jacobian: regressors, one column per parameter.
    y: signal to explain.
    """
    scale = column_lengths(jacobian)
    if not (scale > 0.0).all():
        raise np.linalg.LinAlgError("a regressor is zero throughout")
    parts = list(spans(slice(0, y.size)))
    scaled, right = (jacobian / scale, y) if len(parts) == 1 else triangle(jacobian, y, scale)
    solution, _, rank, singular = np.linalg.lstsq(scaled, right, rcond=1e-12)
    if rank < jacobian.shape[1]:
        raise np.linalg.LinAlgError("the regressors are linearly dependent")
    residuals = np.concatenate([y[part] - (jacobian[part] / scale) @ solution for part in parts])
    inverse = np.diag(np.linalg.inv(scaled.T @ scaled)) / scale**2
    return LinearFit(
        parameters=solution / scale,
        residuals=residuals,
        sem=sems(float(np.linalg.norm(residuals)), residuals.size, inverse),
        condition_number=float(singular[0] / singular[-1]),
    )


def spans(rows: slice, longest: int | None = None) -> Iterator[slice]:
    """Parts of a range of samples, in their order, each of at most ``longest`` samples, by default `SPAN`."""
    longest = longest or SPAN
    for start in range(rows.start, rows.stop, longest):
        yield slice(start, min(start + longest, rows.stop))


def column_lengths(x: Annotated[np.ndarray, "(N, p)"]) -> Annotated[np.ndarray, "(p,)"]:
    """Euclidean length of every column (its unit)."""
    return np.sqrt(sum(np.add.reduce(np.square(x[part]), axis=0) for part in spans(slice(0, len(x)))))


def triangle(
    x: Annotated[np.ndarray, "(N, p)"], y: Annotated[np.ndarray, "(N,)"], scale: np.ndarray
) -> tuple[Annotated[np.ndarray, "(p, p)"], Annotated[np.ndarray, "(p,)"]]:
    """R and Q'y with the least-squares solution and the singular values of a long record, x / scale = QR.

    scale: divisor of every column.
    """
    stacked = np.empty((0, x.shape[1] + 1))
    for part in spans(slice(0, y.size)):
        rows = np.column_stack([x[part] / scale, y[part]])
        stacked = np.linalg.qr(np.concatenate([stacked, rows]), mode="r")
    return stacked[: x.shape[1], :-1], stacked[: x.shape[1], -1]


def sems(
    norm: float | Annotated[np.ndarray, "(...)"],
    count: int,
    inverse_diagonal: Annotated[np.ndarray, "(..., p)"],
) -> Annotated[np.ndarray, "(..., 3, p)"]:
    """Thesis eq (3-2), sqrt(R'R (J'J)^-1 / ||R||), by the three `SEM_READINGS` of its ||R||.

    With the Euclidean norm R'R / ||R|| = ||R||: this is no standard error, and its unit is that of the
    parameter over the square root of the unit of R. With the number N of residuals, or with N - p, it is the
    standard error for white residuals, with the variance of R divided by N or unbiased.

    norm: Euclidean norm of the residuals.
    count: N.
    inverse_diagonal: diagonal of (J'J)^-1.
    Returns: SEM of every parameter by every reading; the last one is infinite if N <= p.
    """
    norm = np.asarray(norm)[..., None]
    freedom = count - inverse_diagonal.shape[-1]
    squares = norm**2 * inverse_diagonal
    unbiased = squares / freedom if freedom > 0 else np.full_like(squares, np.inf)
    return np.sqrt(np.stack([norm * inverse_diagonal, squares / count, unbiased], axis=-2))
