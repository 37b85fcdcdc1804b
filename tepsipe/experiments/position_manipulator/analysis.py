"""Joint impedance in a position-controlled manipulator: angle imposed, torque measured.

    tau(t) = I theta'' + B theta' + K theta + offset

is fitted by linear regression to the first part of a trial and tested on the rest. The parallel-cascade
model, intrinsic stiffness and stretch reflex, is fitted to the same filtered torque (`parallel_cascade`).
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.budgets import rows_of
from tepsipe.experiments.position_manipulator.options import PositionManipulatorOptions
from tepsipe.identification.cascade.fit import ParallelCascadeFit
from tepsipe.identification.cascade.muscle import MUSCLE_BOUNDS
from tepsipe.identification.cascade.options import ParallelCascadeOptions
from tepsipe.identification.cascade.parallel_cascade import identify_cascade
from tepsipe.identification.cascade.record import CascadeRecord, fitted_part, make_record
from tepsipe.identification.result import Quantity, symbol_of
from tepsipe.io.estimates import Estimate, flagged, recommended
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.mechanics.impedance_model import PARAMETERS, admittance
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.signals.resampling import BAND_PER_RATE
from tepsipe.signals.response import FrequencyResponse
from tepsipe.signals.spectra import frequency_averaged
from tepsipe.statistics.bootstrap import bootstrap_blocks
from tepsipe.statistics.goodness_of_fit import HeldOutVaf, evaluate_held_out
from tepsipe.statistics.least_squares import LinearFit, least_squares_line

PATHWAY = "impedance"
ESTIMATOR = "regression"
REFLEX_ESTIMATOR = "parallel-cascade"
MUSCLE_ESTIMATOR = "parallel-cascade-muscle"
# terms of a structure, the columns of ``models_terms`` in a result
TERMS = ("direction", "stops", "stiffening", "gain_slope", "unloading", "relaxing")
# relative distance from a bound of its search at which a constant of the muscle counts as at the bound
AT_BOUND = 1e-3
# VAF (%) of the torque below which a model does not describe the joint; and frequency (Hz) of the slowest
# calf muscle: a slower response is no reflex, but voluntary torque
LEAST_VAF, SLOWEST_MUSCLE_HZ = 50.0, 1.9
REFLEX_QUANTITIES = ("reflex_gain", "reflex_gain_slope", "unloading_gain")
# what depends on the assumed time constants of a stiffness that relaxes
RELAXING_QUANTITIES = ("I", "B", "K_short_range", "K_relaxing", "relaxation_time")
MUSCLE_QUANTITIES = ("reflex_gain", "reflex_frequency", "reflex_damping")


@dataclass(frozen=True)
class PositionManipulatorAnalysis:
    """Results of one trial."""

    time: np.ndarray
    angle: np.ndarray
    torque: np.ndarray
    predicted: np.ndarray
    """Filtered signals after both ends are cut (s, rad, N·m) and the torque predicted (N·m)."""
    training: int
    """Number of samples that were fitted (samples)."""
    fit: LinearFit
    """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad), offset (N·m)."""
    bootstrap: Annotated[np.ndarray, "(draws, 4)"]
    """The same for bootstrapped blocks."""
    blocks: int
    """Number of blocks from which the bootstrap draws."""
    spectrum: FrequencyResponse
    """Impedance tau/theta and coherence of the unfiltered record (Hz, N·m/rad)."""
    vaf: HeldOutVaf
    """VAF of the prediction (%)."""


def _parts(trial: Trial, options: PositionManipulatorOptions) -> tuple[slice, int, int]:
    """Kept samples, number of fitted ones, and length of a block (samples)."""
    rate = trial.rate_hz
    highest = BAND_PER_RATE * rate
    if options.lowpass_cutoff_hz > highest:
        raise InputError(
            f"expected a low-pass of at most {highest:.3g} Hz at {rate:.4g} Hz, found "
            f"{options.lowpass_cutoff_hz:g} Hz: record faster, or lower "
            "position_manipulator.analysis.lowpass_cutoff_hz"
        )
    return fitted_part(trial.time.size, rate, options.cut_s, options.block_s, options.training_fraction)


def analyse_position_manipulator(
    trial: Trial, options: PositionManipulatorOptions, rng: np.random.Generator
) -> PositionManipulatorAnalysis:
    """Spectral estimate, coherence, and I, B, K by regression with held-out validation.

    trial: ``angle`` and ``torque``.
    """
    rate = trial.rate_hz
    kept, training, block = _parts(trial, options)

    def lowpass(x: np.ndarray) -> np.ndarray:
        return butterworth_lowpass(x, rate, options.lowpass_cutoff_hz, options.lowpass_order)

    angle, torque = lowpass(trial.values("angle")), lowpass(trial.values("torque"))
    rate_of_angle = derivative(trial.time, angle)
    regressors = np.column_stack(
        [derivative(trial.time, rate_of_angle), rate_of_angle, angle, np.ones_like(angle)]
    )[kept]
    angle, torque = angle[kept], torque[kept]
    try:
        fit = least_squares_line(regressors[:training], torque[:training])
    except np.linalg.LinAlgError as error:
        raise InputError(
            f"expected a moving joint, found one that does not determine I, B, K ({error}): check that the "
            "perturbation was applied"
        ) from error
    predicted = regressors @ fit.parameters
    raw_angle = trial.values("angle")[kept]
    raw_torque = trial.values("torque")[kept]
    return PositionManipulatorAnalysis(
        time=trial.time[kept],
        angle=angle,
        torque=torque,
        predicted=predicted,
        training=training,
        fit=fit,
        bootstrap=bootstrap_blocks(
            regressors[:training], torque[:training], block, options.bootstrap_draws, rng
        ),
        blocks=training // block,
        spectrum=frequency_averaged(
            raw_angle - raw_angle.mean(), raw_torque - raw_torque.mean(), rate, options.averaged_bins
        ),
        vaf=evaluate_held_out(torque, predicted, training),
    )


def analyse_parallel_cascade(
    trial: Trial,
    options: PositionManipulatorOptions,
    reflex: ParallelCascadeOptions,
    rng: np.random.Generator,
) -> ParallelCascadeFit:
    """Parallel-cascade model, fitted to and tested on the same torque as the regression.

    trial: ``angle`` and ``torque``.
    options: filter, fitted part and blocks, as for `analyse_position_manipulator`.
    Returns: both pathways and the prediction.
    """
    record, block = cascade_record(trial, options, reflex)
    return identify_cascade(record, block, options.bootstrap_draws, rng)


def cascade_record(
    trial: Trial, options: PositionManipulatorOptions, reflex: ParallelCascadeOptions
) -> tuple[CascadeRecord, int]:
    """Filtered record that `analyse_parallel_cascade` fits, and length of a block (rad, N·m, samples)."""
    kept, training, block = _parts(trial, options)
    record = make_record(
        trial.values("angle"),
        trial.values("torque"),
        trial.rate_hz,
        kept,
        training,
        lambda x: butterworth_lowpass(x, trial.rate_hz, options.lowpass_cutoff_hz, options.lowpass_order),
        reflex,
    )
    return record, block


def position_manipulator_estimates(
    experiment: str, condition: str, analysis: PositionManipulatorAnalysis
) -> list[Estimate]:
    """Tidy rows of one trial: I, B, K and VAF (%) of the fitted and the held-out part."""
    names = (experiment, condition, PATHWAY, ESTIMATOR)
    fit, draws, blocks = analysis.fit, analysis.bootstrap.T, analysis.blocks
    quantities = {
        name: replace(
            Quantity.drawn(fit.parameters[k], symbol_of(name), draws[k], 0.95, blocks),
            as_printed=float(fit.sem_as_printed[k]),
        )
        for k, name in enumerate(PARAMETERS)
    }
    return flagged(rows_of(names, quantities | _vafs(analysis.vaf)), *_misfit(analysis.vaf.training))


def _misfit(vaf: float) -> tuple[str, ...]:
    return () if vaf >= LEAST_VAF else ("lack-of-fit",)


def _vafs(vaf: HeldOutVaf) -> dict[str, Quantity]:
    return {
        "VAF_training": Quantity(vaf.training, "%"),
        "VAF_held_out": Quantity(vaf.held_out, "%"),
        "VAF_held_out_any_offset": Quantity(vaf.held_out_any_offset, "%"),
        "VAF_held_out_as_printed": Quantity(vaf.held_out_as_printed, "%"),
    }


def parallel_cascade_estimates(experiment: str, condition: str, fit: ParallelCascadeFit) -> list[Estimate]:
    """Tidy rows of one trial: intrinsic I, B, K, the reflex, VAF (%), and the muscle model.

    A structure without angle-dependent stiffness or reflex has no rows for their parameters, except for a
    reflex gain of 0 N·m·s/rad. Delay and threshold of a reflex are flagged where the record does not
    determine them, and where it prefers others than were searched; then the gain is flagged, too, and where
    the muscle is too slow.
    """
    # a reflex earlier than those that are tried is in the intrinsic response, as inertia and damping
    outside = any(not choice.low <= choice.value <= choice.high for choice in fit.assumptions)
    beyond = ("reflex-outside-search",) * outside
    too_slow = fit.muscle is not None and fit.muscle.constants[1] < SLOWEST_MUSCLE_HZ
    slow = ("slow-reflex",) if too_slow else ()
    flags = dict.fromkeys(("I", "B"), beyond) | dict.fromkeys(REFLEX_QUANTITIES, beyond + slow)
    if fit.structure.relaxing:
        flags |= {name: (*flags.get(name, ()), "relaxation-assumed") for name in RELAXING_QUANTITIES}
    quantities = {name: replace(q, flags=flags.get(name, ())) for name, q in fit.quantities().items()}
    for choice in fit.assumptions:
        why = "assumed" if choice.low <= choice.value <= choice.high else "reflex-outside-search"
        for end, value in (("", choice.value), ("_low", choice.low), ("_high", choice.high)):
            quantities[choice.quantity + end] = Quantity(
                value, choice.unit, flags=(why,) * (not choice.determined)
            )
    if fit.muscle is not None:
        quantities["reflex_peak_time"] = Quantity(fit.reflex_peak_s, "s")
        quantities["reflex_duration"] = Quantity(fit.reflex_duration_s, "s")
    quantities["reflex_share"] = Quantity(fit.reflex_share, "%")
    quantities["slow_torque_sd"] = Quantity(fit.slow.sd_Nm, "N·m")
    quantities["VAF_cross_validated"] = Quantity(fit.vaf_cross_validated, "%")
    quantities |= _vafs(fit.vaf)
    quantities["VAF_held_out_with_slow_torque"] = Quantity(fit.slow.vaf.held_out, "%")
    rows = rows_of((experiment, condition, PATHWAY, REFLEX_ESTIMATOR), quantities)
    rows = flagged(rows, *_misfit(fit.vaf_cross_validated))
    if fit.muscle is not None:
        of_muscle = rows_of((experiment, condition, PATHWAY, MUSCLE_ESTIMATOR), _muscle_quantities(fit))
        at_bound = any(
            np.isclose(constant, bounds, rtol=AT_BOUND).any()
            for constant, bounds in zip(fit.muscle.constants[1:], MUSCLE_BOUNDS, strict=True)
        )
        checks = (*("at-bound",) * at_bound, *slow, *_misfit(fit.muscle.vaf.training))
        rows += flagged(of_muscle, *checks)
    return recommended(rows, PATHWAY, REFLEX_ESTIMATOR)


def _muscle_quantities(fit: ParallelCascadeFit) -> dict[str, Quantity]:
    """Gain, frequency, damping, delay and VAFs of the muscle model."""
    muscle = fit.muscle
    quantities = {
        name: Quantity.drawn(muscle.constants[k], symbol_of(name), muscle.bootstrap[:, k], 0.95, fit.blocks)
        for k, name in enumerate(MUSCLE_QUANTITIES)
    }
    return quantities | {"reflex_delay": Quantity(fit.structure.delay_s, "s")} | _vafs(muscle.vaf)


def position_manipulator_result(analysis: PositionManipulatorAnalysis, fit: ParallelCascadeFit) -> Result:
    """Arrays and facts of one trial, with both pathways in the group ``reflex``."""
    spectrum = analysis.spectrum
    model = 1.0 / admittance(analysis.fit.parameters[:3], spectrum.frequency_hz)
    signals = {
        "time": (analysis.time, "s"),
        "angle": (analysis.angle, "rad"),
        "torque": (analysis.torque, "Nm"),
        "predicted_torque": (analysis.predicted, "Nm"),
        "frequency": (spectrum.frequency_hz, "Hz"),
        "impedance": (spectrum.response, "Nm/rad"),
        "impedance_model": (model, "Nm/rad"),
        "coherence": (spectrum.coherence, "1"),
    }
    signals |= {f"reflex/{name}": signal for name, signal in _paths(fit).items()}
    facts = {
        "training_s": float(analysis.time[analysis.training - 1] - analysis.time[0]),
        "held_out_from_s": float(analysis.time[analysis.training]),
        "vaf_held_out_percent": analysis.vaf.held_out,
        "offset_Nm": float(analysis.fit.parameters[3]),
    }
    facts["reflex"] = {
        "vaf_held_out_percent": fit.vaf.held_out,
        "direction": fit.structure.direction,
        "stiffening": fit.structure.stiffening,
        "delay_s": fit.structure.delay_s,
        "delay_range_s": list(fit.delay_range_s),
        "penalty": fit.structure.penalty,
        "short_range": fit.structure.stops,
        "gain_slope": fit.structure.gain_slope,
        "unloading": fit.structure.unloading,
        "relaxing": fit.structure.relaxing,
        "threshold_rad_per_s": fit.structure.threshold_rad_per_s,
        "pole_per_s": fit.structure.pole_per_s,
        "peak_s": fit.reflex_peak_s,
        "duration_s": fit.reflex_duration_s,
        "slow_corner_hz": fit.slow.model.corner_hz,
        "slow_crossover_hz": fit.slow.model.crossover_hz,
        "slow_horizon_s": fit.slow.horizon_s,
        "slow_vaf_held_out_percent": fit.slow.vaf.held_out,
        "assumed": [choice.quantity for choice in fit.assumptions if not choice.determined],
    }
    return Result.of(signals, facts)


def _paths(fit: ParallelCascadeFit) -> dict[str, tuple[np.ndarray, str]]:
    """Arrays of both pathways with their units."""
    arrays = {
        "predicted_torque": (fit.predicted, "Nm"),
        "reflex_torque": (fit.reflex_torque, "Nm"),
        "intrinsic_lag": (fit.intrinsic_time, "s"),
        "intrinsic_response": (fit.intrinsic_response, "Nm/rad/s"),
        "time": (fit.reflex_time, "s"),
        "response": (fit.reflex_response, "Nm/rad"),
        "response_low": (fit.reflex_low, "Nm/rad"),
        "response_high": (fit.reflex_high, "Nm/rad"),
        "delay": (fit.delays, "s"),
        "delay_vaf": (fit.delay_vaf, "%"),
        "stop_torque": (fit.stop_torque, "Nm"),
        "stop_radius": (fit.short_range.radii_rad, "rad"),
        "stop_stiffness": (fit.short_range.weights, "Nm/rad"),
        "slow_torque": (fit.slow.predicted, "Nm"),
        "slow_horizon": (fit.slow.horizons_s, "s"),
        "slow_vaf": (fit.slow.held_out_vaf, "%"),
        "models_terms": (_terms(fit), "1"),
        "models_error": (np.array([score.error for score in fit.models]), "%"),
        "models_error_se": (np.array([score.error_se for score in fit.models]), "%"),
        "models_vaf_cross_validated": (np.array([s.vaf_cross_validated for s in fit.models]), "%"),
        "models_vaf_held_out": (np.array([s.vaf_held_out for s in fit.models]), "%"),
        "models_coefficients": (np.array([s.coefficients for s in fit.models], dtype=float), "1"),
    }
    if fit.muscle is not None:
        arrays["muscle_response"] = (fit.muscle.response, "Nm/rad")
        arrays["muscle_predicted_torque"] = (fit.muscle.predicted, "Nm")
    return arrays


def _terms(fit: ParallelCascadeFit) -> np.ndarray:
    """Terms of the models that were compared, shape (models, 6): whether each of ``TERMS`` is present."""
    present = [[bool(getattr(s.structure, name)) for name in TERMS] for s in fit.models]
    return np.array(present, dtype=float)
