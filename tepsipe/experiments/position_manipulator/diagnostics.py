"""Diagnostics of a recording of a position-controlled manipulator, and of the residuals of a model.

The deviation of the stiffness in a part of the record is estimated from the residual e = tau - tau_predicted,

    e(t) = dI theta'' + dB theta' + dK theta + level + trend t

so that the reflex and all other terms of the predicting model are accounted for, whatever they are.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.experiments.position_manipulator.analysis import PositionManipulatorAnalysis
from tepsipe.experiments.position_manipulator.options import PositionManipulatorOptions
from tepsipe.identification.cascade.fit import ParallelCascadeFit
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.response import FrequencyResponse
from tepsipe.signals.spectra import multitaper_response
from tepsipe.statistics.residuals import (
    cumulative_periodogram,
    equal_means_p,
    memory_s,
    share_below,
    solution_with_errors,
)

# number of parts of the record whose stiffness is compared, and segments of the power spectra (s)
PARTS = 3
SEGMENT_S = 4.0
# upper frequency of the slow part of the residual (Hz)
SLOW_HZ = 1.0
# the response is shown up to this multiple of the filter's cutoff
SHOWN = 1.25
# number of trials in the figure of the torque, which has two rows for each
SHOWN_TRIALS = 3


@dataclass(frozen=True)
class PartsOfRecord:
    """Intrinsic stiffness and level of the torque in equal parts of a record."""

    ends: Annotated[np.ndarray, "(k, 2)", "s"]
    """First and last instant of every part."""
    stiffness: Annotated[np.ndarray, "(k,)", "N·m/rad"]
    stiffness_error: Annotated[np.ndarray, "(k,)", "N·m/rad"]
    """K and its standard error."""
    level: Annotated[np.ndarray, "(k,)", "N·m"]
    level_error: Annotated[np.ndarray, "(k,)", "N·m"]
    """Torque at the mean angle of the record, and its standard error."""
    freedom: Annotated[np.ndarray, "(k,)"]
    """Degrees of freedom of the errors."""

    def half_widths(self) -> tuple[np.ndarray, np.ndarray]:
        """Half widths of the 95 % intervals of stiffness (N·m/rad) and level (N·m)."""
        t = scipy.stats.t.ppf(0.975, self.freedom)
        return t * self.stiffness_error, t * self.level_error


def parts_of_record(
    analysis: PositionManipulatorAnalysis,
    predicted: Annotated[np.ndarray, "(n,)", "N·m"],
    stiffness: Annotated[float, "N·m/rad"],
    block: int,
) -> PartsOfRecord:
    """Intrinsic stiffness and level of the torque in thirds of the record.

    predicted: torque by the model.
    stiffness: intrinsic stiffness of this model.
    block: length of the blocks within which residuals may be correlated (samples).
    """
    time, angle = analysis.time, analysis.angle - analysis.angle.mean()
    velocity = derivative(time, angle)
    motion = np.column_stack([derivative(time, velocity), velocity, angle, np.ones_like(angle), time])
    rows = []
    for part in np.array_split(np.arange(time.size), PARTS):
        columns = motion[part].copy()
        columns[:, 4] -= columns[:, 4].mean()
        residual = analysis.torque[part] - predicted[part]
        solution, error, freedom = solution_with_errors(columns, residual, block)
        stiffness_of_part = stiffness + solution[2]
        # level of the torque beside its response to the movement
        level = np.mean(analysis.torque[part] - stiffness_of_part * columns[:, 2])
        rows.append((time[part[0]], time[part[-1]], stiffness_of_part, error[2], level, error[3], freedom))
    columns = np.array(rows).T
    return PartsOfRecord(columns[:2].T, *columns[2:])


def recording_facts(
    trial: Trial, analysis: PositionManipulatorAnalysis, options: PositionManipulatorOptions
) -> dict:
    """Operating point and perturbation of the used part of a trial."""
    time, angle, torque = analysis.time, analysis.angle, analysis.torque
    rate = trial.rate_hz
    velocity = derivative(time, angle)
    kept = _kept(trial, analysis)
    frequency, power = _spectrum(derivative(time, trial.values("angle")[kept]), rate)
    summed = np.cumsum(power) / max(power.sum(), 1e-300)
    raw = trial.values("torque")[kept]
    return {
        "rate_hz": float(rate),
        "recorded_s": float(trial.time[-1] - trial.time[0]),
        "used_s": float(time.size / rate),
        "fitted_s": float(analysis.training / rate),
        "held_out_s": float((time.size - analysis.training) / rate),
        "mean_angle_rad": float(angle.mean()),
        "sd_angle_rad": float(angle.std()),
        "lowest_angle_rad": float(angle.min()),
        "highest_angle_rad": float(angle.max()),
        "rms_velocity_rad_per_s": float(np.sqrt(np.mean(velocity**2))),
        "peak_velocity_rad_per_s": float(np.abs(velocity).max()),
        "velocity_95_hz": float(frequency[np.argmax(summed >= 0.95)]),
        "half_power_hz": _half_power_hz(angle, rate),
        "mean_torque_Nm": float(torque.mean()),
        "sd_torque_Nm": float(torque.std()),
        "lowest_torque_Nm": float(torque.min()),
        "highest_torque_Nm": float(torque.max()),
        "cutoff_hz": float(options.lowpass_cutoff_hz),
        "above_cutoff_percent": 100.0
        * (1.0 - share_below(raw - raw.mean(), rate, options.lowpass_cutoff_hz)),
        "block_s": float(options.block_s),
    }


def _kept(trial: Trial, analysis: PositionManipulatorAnalysis) -> slice:
    """Samples of the trial that are analysed."""
    first = int(np.searchsorted(trial.time, analysis.time[0]))
    return slice(first, first + analysis.time.size)


def _spectrum(x: np.ndarray, rate_hz: float) -> tuple[np.ndarray, np.ndarray]:
    """Power spectral density by Welch's method: Hz, and unit of x squared per Hz."""
    length = min(x.size, round(SEGMENT_S * rate_hz))
    return scipy.signal.welch(x, rate_hz, nperseg=length, detrend="constant")


def _half_power_hz(angle: np.ndarray, rate_hz: float) -> float:
    """Frequency (Hz) above which the power spectral density of the angle is at most half its maximum."""
    frequency, power = _spectrum(angle, rate_hz)
    above = np.flatnonzero(power > 0.5 * power.max())
    return float(frequency[above[-1] + 1])


def responses(
    trial: Trial,
    analysis: PositionManipulatorAnalysis,
    predicted: Annotated[np.ndarray, "(n,)", "N·m"],
    cutoff_hz: float,
) -> tuple[FrequencyResponse, FrequencyResponse]:
    """Impedance of the measurement, and of the model by the same estimator.

    trial: ``angle`` and ``torque``, unfiltered.
    predicted: filtered torque by the model.
    cutoff_hz: cutoff of the filter (Hz): the model is shown below it only.
    Returns: from angle to torque (Hz, N·m/rad).
    """
    kept = _kept(trial, analysis)
    angle, torque = trial.values("angle")[kept], trial.values("torque")[kept]
    measured = multitaper_response(angle, torque, trial.rate_hz, SHOWN * cutoff_hz)
    modelled = multitaper_response(analysis.angle, predicted, trial.rate_hz, cutoff_hz)
    return measured, modelled


def residual_facts(torque: np.ndarray, residual: np.ndarray, rate_hz: float, cutoff_hz: float) -> dict:
    """Whiteness and slow share of the residual (N·m) of the held-out torque."""
    white = cumulative_periodogram(residual, rate_hz, cutoff_hz)
    return {
        "rms_Nm": float(np.sqrt(np.mean(residual**2))),
        "torque_rms_Nm": float(torque.std()),
        "below_1_hz_percent": 100.0 * share_below(residual, rate_hz, SLOW_HZ),
        "offset_percent": 100.0 * float(residual.mean() ** 2 / max(np.mean(residual**2), 1e-300)),
        "memory_s": memory_s(residual, rate_hz),
        "white_p": white.p_value,
        "white_distance": white.distance,
        "white_limit": white.limit,
    }


def diagnose(
    trial: Trial,
    options: PositionManipulatorOptions,
    analysis: PositionManipulatorAnalysis,
    fit: ParallelCascadeFit,
) -> Result:
    """Recording, impedance with confidence bands, parts of the record and residual of one trial.

    trial: ``angle`` and ``torque``.
    analysis: fit of I, B, K.
    Returns: arrays of the group ``diagnostics`` with their units, and facts ``diagnostics``.
    """
    rate, cutoff = trial.rate_hz, options.lowpass_cutoff_hz
    parts = parts_of_record(analysis, fit.predicted, float(fit.impedance[2]), round(options.block_s * rate))
    measured, modelled = responses(trial, analysis, fit.predicted, cutoff)
    factor, half_width = measured.confidence_band()
    held_out = slice(analysis.training, None)
    residual = (analysis.torque - fit.predicted)[held_out]
    white = cumulative_periodogram(residual, rate, cutoff)
    frequency, of_residual = _spectrum(residual, rate)
    of_torque = _spectrum(analysis.torque[held_out], rate)[1]
    stiffness_half, level_half = parts.half_widths()
    signals = {
        "frequency": (measured.frequency_hz, "Hz"),
        "impedance": (measured.response, "Nm/rad"),
        "gain_factor": (factor, "1"),
        "phase_half_width": (half_width, "deg"),
        "coherence": (measured.coherence, "1"),
        "coherence_level": (measured.coherence_threshold(), "1"),
        "model_frequency": (modelled.frequency_hz, "Hz"),
        "model_impedance": (modelled.response, "Nm/rad"),
        "part_ends": (parts.ends, "s"),
        "part_stiffness": (parts.stiffness, "Nm/rad"),
        "part_stiffness_half_width": (stiffness_half, "Nm/rad"),
        "part_level": (parts.level, "Nm"),
        "part_level_half_width": (level_half, "Nm"),
        "psd_frequency": (frequency, "Hz"),
        "psd_residual": (of_residual, "Nm2/Hz"),
        "psd_torque": (of_torque, "Nm2/Hz"),
        "white_frequency": (white.frequency_hz, "Hz"),
        "white_cumulative": (white.cumulative, "1"),
    }
    facts = {
        "recording": recording_facts(trial, analysis, options),
        "residual": residual_facts(analysis.torque[held_out], residual, rate, cutoff),
        "stiffness_Nm_per_rad": float(fit.impedance[2]),
        "stiffness_equal_p": equal_means_p(parts.stiffness, parts.stiffness_error, parts.freedom),
        "level_equal_p": equal_means_p(parts.level, parts.level_error, parts.freedom),
    }
    return Result.of({f"diagnostics/{name}": x for name, x in signals.items()}, {"diagnostics": facts})
