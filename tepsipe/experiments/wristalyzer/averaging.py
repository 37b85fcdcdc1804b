"""Fit of the Wristalyzer against the number of averaged frequencies, which the thesis does not state.

The spectra of one record are averaged over n neighbouring frequencies (thesis eqs 3-3 and 3-4). The phase of
a resonance turns within a band of n frequencies, so the coherence dips there even if joint and record are
perfect. The coherence of a linear joint without noise, driven by the same torque, shows this part of the dip.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.wristalyzer.options import WristalyzerOptions
from tepsipe.experiments.wristalyzer.record import fitted_band, prepare
from tepsipe.identification.admittance_fit import fit_scaled
from tepsipe.io.tables import Table, Undefinable
from tepsipe.io.trial import Trial
from tepsipe.mechanics.impedance_model import simulate_angle
from tepsipe.signals.spectra import frequency_averaged


@dataclass(frozen=True)
class AveragedFit:
    """Fit to spectra averaged over a number of frequencies."""

    condition: str
    averaged_bins: int
    frequencies: int
    """Raw frequencies averaged into one, and averaged frequencies in the fitted band."""
    I_Nms2_per_rad: float
    B_Nms_per_rad: float
    K_Nm_per_rad: float
    """Estimates."""
    K_sem_as_printed: float
    """SEM of K by thesis eq (3-2) as printed."""
    error: float
    """Sum of squares of thesis eq (3-6)."""
    lowest_coherence: float
    lowest_coherence_Hz: Undefinable
    """Lowest coherence in the fitted band, and its frequency (Hz), which single frequencies do not have."""
    linear_coherence: float
    """Coherence at that frequency of the fitted joint without noise, driven by the torque of the trial."""


AVERAGED_FITS = Table(AveragedFit, "fits by number of averaged frequencies")


def sweep_averaging(
    trial: Trial, condition: str, options: WristalyzerOptions, numbers: Sequence[int]
) -> Iterator[AveragedFit]:
    """Fit a trial for every number of averaged frequencies that leaves enough of them in the band.

    trial: ``torque`` and ``angle``.
    options: options of the analysis; its own number of averaged frequencies is not used.

    Yields
    ------
    AveragedFit
        Result for one number, in the order of ``numbers``.
    """
    prepared = prepare(trial, options)
    torque, angle = prepared.torque[prepared.kept], prepared.angle[prepared.kept]
    for bins in numbers:
        spectrum = frequency_averaged(torque, angle, prepared.rate_hz, bins)
        try:
            band = spectrum.band(*options.fit_band_hz)
        except InputError:  # too few frequencies are left
            continue
        fit = fit_scaled(fitted_band(spectrum, options), options.bounds)
        linear = simulate_angle(fit.parameters, prepared.torque, prepared.rate_hz)[prepared.kept]
        of_linear = frequency_averaged(torque, linear, prepared.rate_hz, bins).band(*options.fit_band_hz)
        lowest = int(np.argmin(band.coherence))
        yield AveragedFit(
            condition,
            bins,
            band.frequency_hz.size,
            *map(float, fit.parameters),
            K_sem_as_printed=float(fit.sem_as_printed[2]),
            error=fit.cost,
            lowest_coherence=float(band.coherence[lowest]),
            # without averaging the coherence is 1 at every frequency
            lowest_coherence_Hz=float(band.frequency_hz[lowest]) if bins > 1 else math.nan,
            linear_coherence=float(of_linear.coherence[lowest]),
        )
