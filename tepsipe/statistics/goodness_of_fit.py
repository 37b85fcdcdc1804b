"""Goodness of fit: the uncentred VAF of the thesis and held-out VAFs (thesis section 3, eq 3-1)."""

from dataclasses import dataclass

import numpy as np

from tepsipe.arguments import checked, samples, unit_of
from tepsipe.errors import InputError


def vaf(measured: np.ndarray, predicted: np.ndarray, *, centred: bool = False) -> float:
    """Uncentred variance accounted for (VAF, %), thesis eq (3-1): means are removed only if ``centred``.

    Parameters
    ----------
    measured, predicted : ndarray, shape (n,)
        Signals in the same unit.
    centred : bool
        Whether the mean of either signal is removed first.

    Returns
    -------
    float
        100 % for a perfect prediction, 0 % for a prediction of zero, without lower bound.

    Raises
    ------
    InputError
        If the signals have not the same shape, hold no numbers, or the measured one is 0 throughout.

    Examples
    --------
    >>> import numpy as np
    >>> from tepsipe import vaf
    >>> measured = np.sin(np.linspace(0.0, 6.0, 100))
    >>> round(vaf(measured, 0.9 * measured), 6)
    99.0
    """
    unit = unit_of(measured, None, "measured")[0] or None
    measured, predicted = (
        samples(x, unit, name, shape=None) for x, name in ((measured, "measured"), (predicted, "predicted"))
    )
    (centred,) = checked(centred=centred)
    if measured.shape != predicted.shape:
        raise InputError(
            f"vaf: expected two signals of the same shape, found {measured.shape} and {predicted.shape}: "
            "cut one of the two"
        )
    if centred:
        measured, predicted = measured - np.mean(measured), predicted - np.mean(predicted)
    if not measured.any():
        raise InputError(
            "measured: expected a signal that differs from 0, found 0 throughout: the variance accounted for "
            "is relative to it, so check which signal was given"
        )
    return explained(measured, predicted)


def explained(measured: np.ndarray, predicted: np.ndarray) -> float:
    """VAF (%) of a prediction that may have diverged, which is NaN or far below 0 then.

    measured, predicted: signals in the same unit.
    Returns: as `vaf`, without its checks.
    """
    return float(100.0 * (1.0 - np.sum((measured - predicted) ** 2) / np.sum(measured**2)))


@dataclass(frozen=True)
class HeldOutVaf:
    """VAFs of a prediction on the fitted and on the held-out part."""

    training: float
    held_out: float
    """VAF (%) of each part about the mean of the fitted part."""
    held_out_any_offset: float
    """VAF (%) of the held-out part with measurement and prediction each about its own mean: insensitive to
    a drift of the offset."""
    held_out_as_printed: float
    """Uncentred VAF (%) of the held-out part, thesis eq (3-1)."""


def evaluate_held_out(measured: np.ndarray, predicted: np.ndarray, training: int) -> HeldOutVaf:
    """VAF (%) of a prediction before and after the end of the fitted part.

    measured, predicted: signals in the same unit.
    training: number of samples, from the first on, that were fitted (samples).
    """
    level = measured[:training].mean()
    test, guess = measured[training:], predicted[training:]
    return HeldOutVaf(
        training=vaf(measured[:training] - level, predicted[:training] - level),
        held_out=vaf(test - level, guess - level),
        held_out_any_offset=vaf(test - test.mean(), guess - guess.mean()),
        held_out_as_printed=vaf(test, guess),
    )
