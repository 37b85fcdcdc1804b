"""How good a fit is, as printed in the thesis and as it should be (thesis section 3, eqs 3-1, 3-2)."""

from dataclasses import dataclass

import numpy as np

from tepsipe.errors import InputError


def vaf(measured: np.ndarray, predicted: np.ndarray, *, centred: bool = False) -> float:
    """Variance accounted for (%), thesis eq (3-1): means are *not* removed unless ``centred``.

    Parameters
    ----------
    measured, predicted : ndarray, shape (n,)
        Signals in the same unit.
    centred : bool
        Whether the mean of either signal is removed first (-).

    Returns
    -------
    float
        100 % for a perfect prediction, 0 % for a prediction of zero, without lower bound.

    Raises
    ------
    InputError
        If the signals have not the same shape.
    """
    if np.shape(measured) != np.shape(predicted):
        raise InputError(
            f"vaf: expected two signals of the same shape, found {np.shape(measured)} and "
            f"{np.shape(predicted)}: cut one of the two"
        )
    if centred:
        measured, predicted = measured - np.mean(measured), predicted - np.mean(predicted)
    return float(100.0 * (1.0 - np.sum((measured - predicted) ** 2) / np.sum(measured**2)))


@dataclass(frozen=True)
class HeldOutVaf:
    """How good a prediction is on the part that was fitted and on the part that was not.

    Attributes
    ----------
    training, held_out : float
        VAF (%) of either part about the mean of the fitted part.
    held_out_any_offset : float
        VAF (%) of the held-out part, of measurement and prediction about their own means: blind to a level
        that has drifted.
    held_out_as_printed : float
        VAF (%) of the held-out part with the mean left in, thesis eq (3-1).
    """

    training: float
    held_out: float
    held_out_any_offset: float
    held_out_as_printed: float


def evaluate_held_out(measured: np.ndarray, predicted: np.ndarray, training: int) -> HeldOutVaf:
    """VAF (%) of a prediction before and after the end of the fitted part.

    Parameters
    ----------
    measured, predicted : ndarray, shape (n,)
        Signals in the same unit.
    training : int
        Number of samples, from the first on, that were fitted (samples).

    Returns
    -------
    HeldOutVaf
        The measures (%).
    """
    level = measured[:training].mean()
    test, guess = measured[training:], predicted[training:]
    return HeldOutVaf(
        training=vaf(measured[:training] - level, predicted[:training] - level),
        held_out=vaf(test - level, guess - level),
        held_out_any_offset=vaf(test - test.mean(), guess - guess.mean()),
        held_out_as_printed=vaf(test, guess),
    )
