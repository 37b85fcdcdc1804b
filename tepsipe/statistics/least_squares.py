"""Linear least squares with the thesis's SEM and the standard error (thesis eqs 3-2 and 3-9)."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np

# samples that are worked on at a time, which bounds the memory of long records
SPAN = 2**18


@dataclass(frozen=True)
class LinearFit:
    """Least-squares solution of ``J p = y`` with its measures of uncertainty.

    R are the residuals, N their number, p the number of parameters.
    """

    parameters: Annotated[np.ndarray, "(p,)"]
    """Solution (units of y over units of J's columns)."""
    residuals: Annotated[np.ndarray, "(N,)"]
    """y - J p (unit of y)."""
    sem_as_printed: Annotated[np.ndarray, "(p,)"]
    """sqrt(R'R diag((J'J)^-1) / ||R||), thesis eq (3-2). It is neither dimensionless nor a standard error:
    R'R / ||R|| = ||R||."""
    standard_error: Annotated[np.ndarray, "(p,)"]
    """sqrt(R'R / (N - p) diag((J'J)^-1)), valid for white residuals only."""
    condition_number: float
    """Ratio of the largest to the smallest singular value of J after scaling its columns to unit length."""


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
        sem_as_printed=sem_as_printed(residuals, inverse),
        standard_error=standard_error(residuals, inverse),
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


def sem_as_printed(
    residuals: Annotated[np.ndarray, "(N,)"], inverse_diagonal: Annotated[np.ndarray, "(p,)"]
) -> Annotated[np.ndarray, "(p,)"]:
    """Thesis eq (3-2) as printed, sqrt(R'R (J'J)^-1 / ||R||).

    inverse_diagonal: diagonal of (J'J)^-1.
    Returns: as printed; its unit is the parameter's over the square root of the signal's.
    """
    return np.sqrt(np.linalg.norm(residuals) * inverse_diagonal)


def standard_error(
    residuals: Annotated[np.ndarray, "(N,)"], inverse_diagonal: Annotated[np.ndarray, "(p,)"]
) -> Annotated[np.ndarray, "(p,)"]:
    """Standard error for white residuals, sqrt(R'R / (N - p) diag((J'J)^-1)).

    inverse_diagonal: diagonal of (J'J)^-1.
    Returns: standard errors (units of the parameters); infinite if N <= p.
    """
    freedom = residuals.size - inverse_diagonal.size
    if freedom <= 0:
        return np.full(inverse_diagonal.size, np.inf)
    return np.sqrt(residuals @ residuals / freedom * inverse_diagonal)
