"""Penalised least squares from the normal equations of blocks, some coefficients not negative.

Normal equations of disjoint blocks add up: folds of a cross-validation and draws of a bootstrap are sums of
the same matrices, computed once. Coefficients that must not be negative are found by non-negative least
squares (Lawson & Hanson 1974) after the others are eliminated.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.statistics.least_squares import spans

# number of draws solved together, which bounds the memory
BATCH = 200
# samples whose regressors are made at a time, fewer than of signals because there are many regressors
SPAN = 2**16
# condition number, with columns of unit length, above which rounding leaves less than one digit of a solution
LARGEST_CONDITION = 0.1 / np.finfo(float).eps


def row_spans(rows: slice) -> Iterator[slice]:
    """Parts of a range of samples, in their order, of which regressors are made at a time."""
    return spans(rows, SPAN)


@dataclass(frozen=True)
class BlockSums:
    """Normal equations of blocks of samples."""

    normal: Annotated[np.ndarray, "(blocks, p, p)"]
    """X'X, of scaled columns."""
    right: Annotated[np.ndarray, "(blocks, p)"]
    """X'y (unit of y)."""
    power: Annotated[np.ndarray, "(blocks,)"]
    """y'y (unit of y, squared)."""
    size: Annotated[np.ndarray, "(blocks,)"]
    """Samples of each block."""

    def of(self, columns: np.ndarray) -> "BlockSums":
        """The same for a selection of the columns (indices)."""
        return BlockSums(
            self.normal[:, columns[:, None], columns], self.right[:, columns], self.power, self.size
        )

    def errors(self, solutions: np.ndarray) -> np.ndarray:
        """Mean squared error of each block with its own solution, shape (blocks,) (unit of y, squared)."""
        product = np.einsum("fi,fij,fj->f", solutions, self.normal, solutions)
        return (self.power + product - 2.0 * np.einsum("fi,fi->f", solutions, self.right)) / self.size

    def levelled(self, solutions: Annotated[np.ndarray, "(k, p)"], times: np.ndarray) -> np.ndarray:
        """Solutions, each with the last coefficient, of a constant column, that removes the mean residual.

        times: multiplicity of each block in this mean, shape (k, blocks).
        """
        left = self.right[:, -1] - solutions @ self.normal[:, -1].T
        constant = np.sum(times * left, axis=1) / (times @ self.normal[:, -1, -1])
        return np.column_stack([solutions[:, :-1], solutions[:, -1] + constant])

    def vaf(self, solutions: np.ndarray) -> Annotated[float, "%"]:
        """VAF (%) of all blocks, each with its own solution."""
        return float(100.0 * (1.0 - self.errors(solutions) @ self.size / self.power.sum()))


def block_sums(x: Callable[[slice], np.ndarray], y: np.ndarray, blocks: list[slice]) -> BlockSums:
    """Normal equations of every block.

    x: makes scaled regressors of a range of samples, shape (n, p).
    y: signal to explain.
    blocks: samples of each block.
    """
    normal, right, power = zip(*(_sums(x, y, block) for block in blocks), strict=True)
    size = np.array([block.stop - block.start for block in blocks], dtype=float)
    return BlockSums(np.array(normal), np.array(right), np.array(power), size)


def _sums(x: Callable[[slice], np.ndarray], y: np.ndarray, block: slice) -> tuple:
    """X'X, X'y and y'y of one block, added up in the order of time."""
    normal = right = power = 0.0
    for part in row_spans(block):
        of_x, of_y = x(part), y[part]
        normal, right, power = normal + of_x.T @ of_x, right + of_x.T @ of_y, power + of_y @ of_y
    return normal, right, power


def solve_bounded(
    normal: Annotated[np.ndarray, "(k, p, p)"],
    right: Annotated[np.ndarray, "(k, p)"],
    bounded: Annotated[np.ndarray, "(p,)"],
) -> Annotated[np.ndarray, "(k, p)"]:
    """Solutions of normal equations with coefficients that must not be negative.

    normal: normal matrices, penalty included.
    right: right-hand sides.
    bounded: whether a coefficient must not be negative.
    Returns: coefficients (unit of ``right``).
    """
    if not bounded.any():
        return np.linalg.solve(normal, right[..., None])[..., 0]
    free, held = np.flatnonzero(~bounded), np.flatnonzero(bounded)
    cross = normal[:, free[:, None], held]
    through = np.linalg.solve(
        normal[:, free[:, None], free], np.concatenate([right[:, free, None], cross], axis=2)
    )
    reduced = normal[:, held[:, None], held] - np.swapaxes(cross, 1, 2) @ through[..., 1:]
    target = right[:, held] - np.einsum("kij,ki->kj", cross, through[..., 0])
    trace = np.trace(reduced, axis1=1, axis2=2) + np.finfo(float).tiny
    root = np.linalg.cholesky(reduced + 1e-10 * trace[:, None, None] * np.eye(held.size))
    goal = np.linalg.solve(root, target[..., None])[..., 0]
    solution = np.empty_like(right)
    solution[:, held] = [scipy.optimize.nnls(a.T, b)[0] for a, b in zip(root, goal, strict=True)]
    solution[:, free] = through[..., 0] - np.einsum("kij,kj->ki", through[..., 1:], solution[:, held])
    return solution


def require_determined(
    normal: Annotated[np.ndarray, "(p, p)"], bounded: Annotated[np.ndarray, "(p,)"]
) -> None:
    """Refuse normal equations that rounding alone decides, which a solver may or may not notice.

    Raises `numpy.linalg.LinAlgError`.
    """
    free = normal[np.ix_(~bounded, ~bounded)]
    size = np.sqrt(np.diag(free))
    size[size == 0.0] = 1.0
    condition = np.linalg.cond(free / np.outer(size, size))
    if not condition < LARGEST_CONDITION:
        raise np.linalg.LinAlgError(f"normal equations with a condition number of {condition:.1g}")


def solve_without_each(
    sums: BlockSums, penalty: Annotated[np.ndarray, "(..., p, p)"], bounded: Annotated[np.ndarray, "(p,)"]
) -> Annotated[np.ndarray, "(..., blocks, p)"]:
    """Solutions from all blocks but one, shape (blocks, p), for every penalty.

    sums: normal equations of the blocks.
    penalty: penalty per sample; several, which are solved together, along leading axes.
    bounded: whether a coefficient must not be negative.
    Returns: coefficients, row by row without this block (unit of y).
    """
    others = sums.normal.sum(axis=0) - sums.normal
    right = sums.right.sum(axis=0) - sums.right
    weight = sums.size.sum() - sums.size
    normal = others + weight[:, None, None] * penalty[..., None, :, :]
    right = np.broadcast_to(right, normal.shape[:-1])
    flat = solve_bounded(normal.reshape(-1, *normal.shape[-2:]), right.reshape(-1, right.shape[-1]), bounded)
    return flat.reshape(right.shape)


def solve_drawn(
    sums: BlockSums,
    times: Annotated[np.ndarray, "(draws, blocks)"],
    penalty: Annotated[np.ndarray, "(p, p)"],
    bounded: Annotated[np.ndarray, "(p,)"],
) -> Annotated[np.ndarray, "(draws, p)"]:
    """Solutions for blocks with multiplicities, as a bootstrap draws them.

    sums: normal equations of the blocks.
    times: multiplicity of each block.
    bounded: whether a coefficient must not be negative.
    Returns: coefficients (unit of y).
    """
    solutions = [np.empty((0, sums.right.shape[1]))]
    for start in range(0, times.shape[0], BATCH):
        part = times[start : start + BATCH]
        weight = part @ sums.size
        normal = np.tensordot(part, sums.normal, 1) + weight[:, None, None] * penalty
        solutions.append(solve_bounded(normal, part @ sums.right, bounded))
    return np.concatenate(solutions)
