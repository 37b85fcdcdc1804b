"""Linear least squares with the thesis's SEM and the standard error (thesis eqs 3-2 and 3-9)."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np


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
    scale = np.linalg.norm(jacobian, axis=0)
    if not (scale > 0.0).all():
        raise np.linalg.LinAlgError("a regressor is zero throughout")
    scaled = jacobian / scale
    solution, _, rank, singular = np.linalg.lstsq(scaled, y, rcond=1e-12)
    if rank < jacobian.shape[1]:
        raise np.linalg.LinAlgError("the regressors are linearly dependent")
    residuals = y - scaled @ solution
    inverse = np.diag(np.linalg.inv(scaled.T @ scaled)) / scale**2
    return LinearFit(
        parameters=solution / scale,
        residuals=residuals,
        sem_as_printed=sem_as_printed(residuals, inverse),
        standard_error=standard_error(residuals, inverse),
        condition_number=float(singular[0] / singular[-1]),
    )


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
