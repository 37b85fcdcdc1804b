"""Frequency response with its coherence and confidence bands."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tepsipe.arguments import checked, pair
from tepsipe.errors import InputError
from tepsipe.signals.notebook_display import new_axes

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class FrequencyResponse:
    """Frequency response from u to y, with its coherence.

    Attributes
    ----------
    frequency_hz : ndarray, shape (n,)
        Frequencies (Hz).
    response : ndarray of complex, shape (n,)
        S_uy / S_uu (unit of y over unit of u).
    coherence : ndarray, shape (n,)
        |S_uy|^2 / (S_uu S_yy), 0 to 1.
    averages : float or ndarray, shape (n,)
        Number of independent raw spectra averaged into each value.
    error : ndarray, shape (n,), or None
        Standard error of the gain relative to the gain, and of the phase in rad, where the estimator
        does not leave it to the coherence.
    freedom : ndarray, shape (n,), or None
        Degrees of freedom of this error.
    resolution_hz : float
        Width of the band of frequencies that is averaged into each value (Hz); 0 if none are, or if the
        estimator allows for a response that varies within it.
    notes : tuple of str
        Caveats on the signals; none for valid ones.
    input_power : ndarray, shape (n,), or None
        Power of u at the lines of a periodic perturbation (arbitrary unit); None for others.
    """

    frequency_hz: np.ndarray
    response: np.ndarray
    coherence: np.ndarray
    averages: float | np.ndarray
    error: np.ndarray | None = None
    freedom: np.ndarray | None = None
    resolution_hz: float = 0.0
    input_power: np.ndarray | None = None
    notes: tuple[str, ...] = ()

    def band(self, low_hz: float, high_hz: float) -> "FrequencyResponse":
        """The part between two frequencies (Hz), both included.

        Raises
        ------
        InputError
            If fewer than four frequencies lie in the band.
        """
        low_hz, high_hz = pair((low_hz, high_hz), "band_hz")
        inside = (self.frequency_hz >= low_hz - 1e-9) & (self.frequency_hz <= high_hz + 1e-9)
        if inside.sum() < 4:
            raise InputError(
                f"expected at least 4 frequencies between {low_hz:g} and {high_hz:g} Hz, found "
                f"{inside.sum()}: average over fewer bins, widen the band, or record longer"
            )
        return FrequencyResponse(
            **{
                name: x[inside] if isinstance(x, np.ndarray) and x.ndim else x
                for name, x in vars(self).items()
            }
        )

    def __repr__(self) -> str:
        f, gamma = self.frequency_hz, float(np.median(self.coherence))
        ends = f"{f[0]:g} to {f[-1]:g} Hz, median coherence {gamma:.2f}" if f.size else "empty"
        return f"<FrequencyResponse: {f.size} frequencies, {ends}>"

    def to_frame(self) -> "pd.DataFrame":
        """The response as a pandas table: frequency (Hz), gain, phase (degrees), coherence."""
        import pandas as pd

        return pd.DataFrame(
            {
                "frequency_hz": self.frequency_hz,
                "gain": np.abs(self.response),
                "phase_deg": np.degrees(np.unwrap(np.angle(self.response))),
                "coherence": self.coherence,
            }
        )

    def plot(self, ax: "Sequence[Axes] | None" = None) -> "Figure":
        """Gain, phase and coherence as a matplotlib figure.

        Parameters
        ----------
        ax : sequence of 3 matplotlib Axes, optional
            Axes to draw on; by default a new figure (6.4 inches wide).

        Returns
        -------
        matplotlib Figure
            The figure of the axes (size in inches).
        """
        table, (factor, half) = self.to_frame(), self.confidence_band()
        figure, axes = new_axes(ax, 3, (6.4, 4.8))
        ends = [(table.gain / factor, table.gain * factor), (table.phase_deg - half, table.phase_deg + half)]
        for axis, (low, high) in zip(axes, ends, strict=False):
            axis.fill_between(table.frequency_hz, low, high, color="0.85", label="95 % confidence")
        axes[0].loglog(table.frequency_hz, table.gain, color="0.2")
        axes[1].semilogx(table.frequency_hz, table.phase_deg, color="0.2")
        axes[2].semilogx(table.frequency_hz, table.coherence, color="0.2")
        level = np.broadcast_to(self.coherence_threshold(), table.frequency_hz.shape)
        axes[2].semilogx(table.frequency_hz, level, color="#c8371b", linewidth=0.8, linestyle="--")
        axes[0].set(ylabel="Gain (output/input)")
        axes[1].set(ylabel="Phase (degrees)")
        axes[2].set(ylabel="Coherence (–)", xlabel="Frequency (Hz)", ylim=(0.0, 1.05))
        return figure

    def coherence_threshold(self, confidence: float = 0.95) -> float | np.ndarray:
        """Coherence that unrelated signals exceed with the probability 1 - ``confidence``.

        One number, or one per frequency where the number of averages differs; 1 for fewer than two.
        """
        (confidence,) = checked(confidence=confidence)
        others = np.maximum(np.asarray(self.averages, dtype=float) - 1.0, 1e-9)
        threshold = np.where(others < 1.0, 1.0, 1.0 - (1.0 - confidence) ** (1.0 / others))
        return threshold if threshold.ndim else float(threshold)

    def confidence_band(self, confidence: float = 0.95) -> tuple[np.ndarray, np.ndarray]:
        """Confidence bands of gain and phase at each frequency, by Student's t.

        Without an error of its own, the response is a regression of n averaged spectra, with the relative
        error sqrt((1 - coherence) / coherence / (2 n - 2)) of 2 n - 2 degrees of freedom (Bendat & Piersol
        2010, Random Data, 4th ed., ch. 9). Such bands include noise and distortion that is not coherent with
        the input; they do not include leakage, or errors of a resolution too coarse for the response.

        Parameters
        ----------
        confidence : float
            Probability of each band at each frequency.

        Returns
        -------
        factor, half_width_deg : ndarray, shape (n,)
            The band of the gain runs from gain / factor to gain x factor, the band of the phase is +-
            half_width_deg (degrees), 180 where the phase is unknown.
        """
        import scipy

        (confidence,) = checked(confidence=confidence)
        freedom, error = self.freedom, self.error
        if error is None:
            freedom = np.maximum(2.0 * np.asarray(self.averages, dtype=float) - 2.0, 1e-9)
            with np.errstate(divide="ignore"):
                error = np.sqrt((1.0 - self.coherence) / (self.coherence * freedom))
        half = scipy.stats.t.ppf(0.5 + 0.5 * confidence, np.maximum(freedom, 1.0)) * error
        with np.errstate(over="ignore"):
            return np.exp(half), np.minimum(180.0, np.degrees(half))
