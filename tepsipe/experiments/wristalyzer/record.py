"""One trial in the torque-controlled manipulator as its estimators receive it (thesis section 3-1-1)."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.wristalyzer.options import WristalyzerOptions
from tepsipe.identification.regression.periods import (
    PeriodicRecord,
    filtered_angle,
    periods_differ,
    torque_delay,
)
from tepsipe.io.trial import Trial, recorded_faults
from tepsipe.mechanics.impedance_model import simulate_angle
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.signals.response import FrequencyResponse
from tepsipe.signals.spectra import frequency_averaged, period_averaged
from tepsipe.signals.time_alignment import advanced
from tepsipe.statistics.goodness_of_fit import explained
from tepsipe.statistics.uncertainty import Source

# the torque of a rig whose trigger works acts within this time of its record; errors of time stamps (standard
# deviation) up to the second one leave K within its interval (s)
LONGEST_DELAY_S, LARGEST_JITTER_S = 2e-3, 1.2e-3


def timed(
    trial: Trial, cut_s: float, period_s: float | None, band_hz: tuple[float, float]
) -> tuple[Trial, tuple[str, ...]]:
    """Trial whose torque stands at the instants at which it acts, and flags of its recording.

    The delay is measured where the perturbation is periodic, and corrected if it is longer than that of a
    drive: the trigger was late or early.

    trial: ``torque`` and ``angle``.
    cut_s, period_s: time cut at both ends, and period of the perturbation.
    band_hz: lowest and highest frequency of the perturbation.

    Returns:
        trial: the same if its timing is usual.
        flags: ``log-delay`` for a corrected delay, ``stamp-jitter``, faults of the samples, and, if periodic,
        ``filtered-signal`` and ``halves-differ``.
    """
    flags = ("stamp-jitter",) * (trial.attributes.get("stamp_jitter_s", 0.0) > LARGEST_JITTER_S)
    flags += recorded_faults(trial)
    cut = round(cut_s * trial.rate_hz)
    kept = slice(cut, trial.time.size - cut)
    if period_s is None:
        return trial, flags
    record = PeriodicRecord(
        trial.values("torque")[kept], trial.values("angle")[kept], trial.rate_hz, period_s, band_hz
    )
    delay = torque_delay(record)
    if abs(delay) > LONGEST_DELAY_S:
        torque = trial.signals["torque"]
        moved = replace(
            torque,
            values=advanced(trial.time, torque.values, -delay),
            processing=(*torque.processing, f"moved by {1e3 * delay:.3g} ms"),
        )
        trial, flags = replace(trial, signals=trial.signals | {"torque": moved}), (*flags, "log-delay")
        record = replace(record, torque=moved.values[kept])
    flags += ("filtered-signal",) * filtered_angle(record) + ("halves-differ",) * periods_differ(record)
    return trial, flags


@dataclass(frozen=True)
class PreparedTrial:
    """Filtered signals of a trial."""

    torque: Annotated[np.ndarray, "(n,)", "N·m"]
    angle: Annotated[np.ndarray, "(n,)", "rad"]
    """Whole trial."""
    kept: slice
    """Samples that remain after both ends are cut (samples)."""
    rate_hz: float

    def prediction_vaf(self, parameters: np.ndarray) -> float:
        """VAF (%) of the angle predicted from the torque alone, over the kept part (thesis eq 3-1).

        ``parameters`` are I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad).
        """
        predicted = simulate_angle(parameters, self.torque, self.rate_hz)
        return explained(self.angle[self.kept], predicted[self.kept])


def prepare(trial: Trial, options: WristalyzerOptions) -> PreparedTrial:
    """Filter torque and angle identically, and cut both ends (N·m, rad, samples)."""
    rate = trial.rate_hz

    def lowpass(x: np.ndarray) -> np.ndarray:
        return butterworth_lowpass(x, rate, options.lowpass_cutoff_hz, options.lowpass_order)

    cut = round(options.cut_s * rate)
    if trial.time.size <= 2 * cut + rate:
        raise InputError(
            f"expected more than {2 * options.cut_s + 1:g} s of record, found "
            f"{trial.time.size / rate:.3g} s: cut less at both ends, or record longer"
        )
    return PreparedTrial(
        torque=lowpass(trial.values("torque")),
        angle=lowpass(trial.values("angle")),
        kept=slice(cut, trial.time.size - cut),
        rate_hz=rate,
    )


def fitted_band(spectrum: FrequencyResponse, options: WristalyzerOptions) -> FrequencyResponse:
    """Frequencies of a spectrum that are fitted, with the coherence by which criterion (3-6) weights them.

    The equation prints sqrt(Gamma / f), and the text above it sqrt(1 / f) Gamma = sqrt(Gamma^2 / f).
    """
    band = spectrum.band(*options.fit_band_hz)
    return replace(band, coherence=band.coherence**2) if options.coherence_outside_root else band


@dataclass(frozen=True)
class WristalyzerRecord:
    """Signals of a trial, and their known uncertainties."""

    trial: Trial
    """``torque`` (N·m) and ``angle`` (rad)."""
    prepared: PreparedTrial
    """The same signals filtered (N·m, rad)."""
    options: WristalyzerOptions
    """Options of the analysis."""
    sources: Mapping[str, Source]
    """Uncertain constants: torque_scale, angle_scale, torque_delay_s."""

    def recorded(self, name: str) -> np.ndarray:
        """A signal of the kept part, unfiltered."""
        return self.trial.values(name)[self.prepared.kept]

    @cached_property
    def averaged(self) -> FrequencyResponse:
        """Response averaged over neighbouring frequencies, as in the thesis (Hz, rad/(N·m))."""
        return self._averaged(taper=False)

    @cached_property
    def tapered(self) -> FrequencyResponse:
        """The same with tapered ends (Hz, rad/(N·m))."""
        return self._averaged(taper=True)

    @cached_property
    def periodic(self) -> FrequencyResponse:
        """Response averaged over whole periods of the perturbation (Hz, rad/(N·m))."""
        period_s, band_hz = self.options.perturbation_period_s, self.options.excited_band_hz
        return period_averaged(*self._kept, self.prepared.rate_hz, period_s, band_hz)

    def _averaged(self, taper: bool) -> FrequencyResponse:
        return frequency_averaged(*self._kept, self.prepared.rate_hz, self.options.averaged_bins, taper=taper)

    @property
    def _kept(self) -> tuple[np.ndarray, np.ndarray]:
        kept = self.prepared.kept
        return self.prepared.torque[kept], self.prepared.angle[kept]
