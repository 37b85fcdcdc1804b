"""Penalised least squares from the normal equations of blocks, some coefficients not negative.

Normal equations of disjoint blocks add up: folds of a cross-validation and draws of a bootstrap are sums of
the same matrices, computed once. Coefficients that must not be negative are found by non-negative least
squares (Lawson & Hanson 1974) after the others are eliminated.
"""

from dataclasses import dataclass

import numpy as np
import scipy

# number of draws solved together, which bounds the memory
BATCH = 200


@dataclass(frozen=True)
class BlockSums:
    """Normal equations of blocks of samples.

    Attributes
    ----------
    normal : ndarray, shape (blocks, p, p)
        X'X, of scaled columns.
    right : ndarray, shape (blocks, p)
        X'y (unit of y).
    power : ndarray, shape (blocks,)
        y'y (unit of y, squared).
    size : ndarray, shape (blocks,)
        Samples of each block.
    """

    normal: np.ndarray
    right: np.ndarray
    power: np.ndarray
    size: np.ndarray

    def of(self, columns: np.ndarray) -> "BlockSums":
        """The same for a selection of the columns (indices)."""
        return BlockSums(
            self.normal[:, columns[:, None], columns], self.right[:, columns], self.power, self.size
        )

    def errors(self, solutions: np.ndarray) -> np.ndarray:
        """Mean squared error of each block with its own solution, shape (blocks,) (unit of y, squared)."""
        product = np.einsum("fi,fij,fj->f", solutions, self.normal, solutions)
        return (self.power + product - 2.0 * np.einsum("fi,fi->f", solutions, self.right)) / self.size


def block_sums(x: np.ndarray, y: np.ndarray, blocks: list[slice]) -> BlockSums:
    """Normal equations of every block.

    Parameters
    ----------
    x : ndarray, shape (n, p)
        Scaled regressors.
    y : ndarray, shape (n,)
        Signal to explain.
    blocks : list of slice
        Samples of each block.

    Returns
    -------
    BlockSums
        The sums (units of x and y).
    """
    return BlockSums(
        normal=np.array([x[block].T @ x[block] for block in blocks]),
        right=np.array([x[block].T @ y[block] for block in blocks]),
        power=np.array([y[block] @ y[block] for block in blocks]),
        size=np.array([y[block].size for block in blocks], dtype=float),
    )


def solve_bounded(normal: np.ndarray, right: np.ndarray, bounded: np.ndarray) -> np.ndarray:
    """Solutions of normal equations with coefficients that must not be negative.

    Parameters
    ----------
    normal : ndarray, shape (k, p, p)
        Normal matrices, penalty included.
    right : ndarray, shape (k, p)
        Right-hand sides.
    bounded : ndarray of bool, shape (p,)
        Whether a coefficient must not be negative.

    Returns
    -------
    ndarray, shape (k, p)
        Coefficients (unit of ``right``).
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


def solve_without_each(sums: BlockSums, penalty: np.ndarray, bounded: np.ndarray) -> np.ndarray:
    """Solutions from all blocks but one, shape (blocks, p).

    Parameters
    ----------
    sums : BlockSums
        Normal equations of the blocks.
    penalty : ndarray, shape (p, p)
        Penalty per sample.
    bounded : ndarray of bool, shape (p,)
        Whether a coefficient must not be negative.

    Returns
    -------
    ndarray, shape (blocks, p)
        Coefficients, row by row without this block (unit of y).
    """
    others = sums.normal.sum(axis=0) - sums.normal
    right = sums.right.sum(axis=0) - sums.right
    weight = sums.size.sum() - sums.size
    return solve_bounded(others + weight[:, None, None] * penalty, right, bounded)


def solve_drawn(sums: BlockSums, times: np.ndarray, penalty: np.ndarray, bounded: np.ndarray) -> np.ndarray:
    """Solutions for blocks with multiplicities, as a bootstrap draws them.

    Parameters
    ----------
    sums : BlockSums
        Normal equations of the blocks.
    times : ndarray, shape (draws, blocks)
        Multiplicity of each block.
    penalty : ndarray, shape (p, p)
        Penalty per sample.
    bounded : ndarray of bool, shape (p,)
        Whether a coefficient must not be negative.

    Returns
    -------
    ndarray, shape (draws, p)
        Coefficients (unit of y).
    """
    solutions = [np.empty((0, sums.right.shape[1]))]
    for start in range(0, times.shape[0], BATCH):
        part = times[start : start + BATCH]
        weight = part @ sums.size
        normal = np.tensordot(part, sums.normal, 1) + weight[:, None, None] * penalty
        solutions.append(solve_bounded(normal, part @ sums.right, bounded))
    return np.concatenate(solutions)
