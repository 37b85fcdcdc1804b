"""Penalised least squares from the normal equations of blocks, some coefficients not negative.

Normal equations of disjoint blocks add up: folds of a cross-validation and draws of a bootstrap are sums of
the same matrices, computed once. Coefficients that must not be negative are found by non-negative least
squares (Lawson & Hanson 1974) after the others are eliminated.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

# number of draws solved together, which bounds the memory
BATCH = 200


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


def block_sums(x: Annotated[np.ndarray, "(n, p)"], y: np.ndarray, blocks: list[slice]) -> BlockSums:
    """Normal equations of every block.

    x: scaled regressors.
    y: signal to explain.
    blocks: samples of each block.
    """
    return BlockSums(
        normal=np.array([x[block].T @ x[block] for block in blocks]),
        right=np.array([x[block].T @ y[block] for block in blocks]),
        power=np.array([y[block] @ y[block] for block in blocks]),
        size=np.array([y[block].size for block in blocks], dtype=float),
    )


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


def solve_without_each(
    sums: BlockSums, penalty: Annotated[np.ndarray, "(p, p)"], bounded: Annotated[np.ndarray, "(p,)"]
) -> Annotated[np.ndarray, "(blocks, p)"]:
    """Solutions from all blocks but one, shape (blocks, p).

    sums: normal equations of the blocks.
    penalty: penalty per sample.
    bounded: whether a coefficient must not be negative.
    Returns: coefficients, row by row without this block (unit of y).
    """
    others = sums.normal.sum(axis=0) - sums.normal
    right = sums.right.sum(axis=0) - sums.right
    weight = sums.size.sum() - sums.size
    return solve_bounded(others + weight[:, None, None] * penalty, right, bounded)


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
