"""SIPE in the torque-controlled manipulator, from one trial to its parameters (thesis section 3-1-1).

Registry of the estimators of one trial in the torque-controlled manipulator.

To add one, write a function from a `WristalyzerRecord` to a `JointFit`, and enter it in `ESTIMATORS`. Tables,
budgets, the comparison with the truth and the pages then show it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.budgets import contributions_of, rows_of
from tepsipe.experiments.wristalyzer.names import AS_PRINTED, MODULUS, PATHWAY, PERIODS, REGRESSION
from tepsipe.experiments.wristalyzer.options import WristalyzerOptions
from tepsipe.experiments.wristalyzer.record import (
    PreparedTrial,
    WristalyzerRecord,
    fitted_band,
    prepare,
    timed,
)
from tepsipe.identification.admittance_fit import (
    AdmittanceFit,
    Bounds,
    StiffnessProfile,
    fit_as_printed,
    fit_from_many_starts,
    fit_scaled,
    fit_within_random_bounds,
    profile_stiffness,
)
from tepsipe.identification.budgets.manipulator import fit_response, period_budget
from tepsipe.identification.regression.periods import PeriodicRecord, fit_periods
from tepsipe.identification.result import Quantity, quantities_of
from tepsipe.io.estimates import Contribution, Estimate, flagged, recommended
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.mechanics.impedance_model import PARAMETER_UNITS, PARAMETERS, simulate_angle
from tepsipe.signals.response import FrequencyResponse
from tepsipe.statistics.uncertainty import Source

# the first of these that a trial allows is recommended
RECOMMENDED = (REGRESSION, AS_PRINTED)


@dataclass(frozen=True)
class JointFit:
    """What an estimator finds in one trial."""

    quantities: dict[str, Quantity]
    """I, B, K."""
    flags: tuple[str, ...] = ()
    """Failed checks, names in `tepsipe.flags.FLAGS`."""
    spectrum: FrequencyResponse | None = None
    """Response that was fitted, over all frequencies (Hz, rad/(N·m))."""
    search: AdmittanceFit | None = None
    """Search for the parameters; its error becomes a row."""

    @property
    def parameters(self) -> Annotated[np.ndarray, "(3,)"]:
        """I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad)."""
        return np.array([self.quantities[name].value for name in PARAMETERS])


@dataclass(frozen=True)
class Estimator:
    """An estimator of I, B, K from one trial."""

    meaning: str
    """Description in a few words."""
    function: Callable[[WristalyzerRecord], JointFit]
    needs_period: bool = False
    """True if the perturbation must be periodic; other trials do without the estimator."""


def _searched(record: WristalyzerRecord, spectrum: FrequencyResponse, as_printed: bool = False) -> JointFit:
    band = fitted_band(spectrum, record.options)
    search, quantities = fit_response(band, record.options.bounds, record.sources, as_printed)
    flags = ("at-bound",) * search.at_bound + ("not-converged",) * (not search.converged)
    return JointFit(quantities, flags, spectrum, search)


def _regression(record: WristalyzerRecord) -> JointFit:
    # not filtered: its lines are far below half the rate
    periods = record.trial.rate_hz, record.options.perturbation_period_s, record.options.excited_band_hz
    fit = fit_periods(PeriodicRecord(record.recorded("torque"), record.recorded("angle"), *periods))
    values = dict(zip(PARAMETERS, fit.parameters, strict=True))
    return JointFit(quantities_of(values, period_budget(fit, record.sources)))


ESTIMATORS = {
    AS_PRINTED: Estimator(
        "raw spectra averaged over neighbouring frequencies, smallest criterion (3-6)",
        lambda record: _searched(record, record.averaged),
    ),
    MODULUS: Estimator(
        "the same with the modulus of the log ratio as residual, as (3-6) is printed",
        lambda record: _searched(record, record.averaged, as_printed=True),
    ),
    PERIODS: Estimator(
        "spectra averaged over whole periods, same criterion",
        lambda record: _searched(record, record.periodic),
        needs_period=True,
    ),
    REGRESSION: Estimator(
        "linear joint nearest to the torque at the lines of the perturbation, other periods as instruments",
        _regression,
        needs_period=True,
    ),
}


# VAF (%) of the angle below which I, B, K do not describe the joint
LEAST_VAF = 80.0


@dataclass(frozen=True)
class WristalyzerAnalysis:
    """Results of one trial."""

    prepared: PreparedTrial
    """Filtered signals (N·m, rad)."""
    fitted: dict[str, JointFit]
    """Estimator -> its result."""
    tapered: FrequencyResponse
    """The averaged estimate of the tapered record, for frequencies above the perturbation's band."""
    profile: StiffnessProfile
    """Profile of K for the leakage-free estimate, or for the averaged one without a period (N·m/rad)."""
    many_starts: list[AdmittanceFit]
    """Fits from random starting values."""
    other_bounds: list[AdmittanceFit]
    """Fits within random bounds."""
    tried: list[tuple[float, AdmittanceFit, AdmittanceFit]]
    """Starting K (N·m/rad), fit with complex residuals, fit with the modulus."""
    flags: tuple[str, ...]
    """Failed checks of the trial, names in `tepsipe.flags.FLAGS`."""


def analyse_wristalyzer(
    trial: Trial,
    options: WristalyzerOptions,
    rng: np.random.Generator,
    sources: Mapping[str, Source] | None = None,
) -> WristalyzerAnalysis:
    """Estimate I, B, K by all estimators of the registry, and test the choices of the thesis.

    trial: ``torque`` and ``angle``.
    sources: uncertain constants: torque_scale, angle_scale, torque_delay_s.
    Returns: spectra, fits and their tests.
    """
    record, flags = wristalyzer_record(trial, options, sources)
    prepared, bounds = record.prepared, options.bounds
    fitted = {
        name: estimator.function(record)
        for name, estimator in ESTIMATORS.items()
        if options.perturbation_period_s is not None or not estimator.needs_period
    }
    band, tried = fitted_band(record.averaged, options), []
    for stiffness in options.tried_stiffness_Nm_per_rad:
        if stiffness == bounds.start[2]:  # the estimators have begun there
            tried.append((stiffness, fitted[AS_PRINTED].search, fitted[MODULUS].search))
            continue
        start = Bounds(np.array([*bounds.start[:2], stiffness]), bounds.lower, bounds.upper)
        tried.append((stiffness, fit_scaled(band, start), fit_as_printed(band, start)))
    (low, high), points = options.profile_stiffness_Nm_per_rad, options.profile_points
    best = fitted.get(PERIODS, fitted[AS_PRINTED])
    return WristalyzerAnalysis(
        prepared=prepared,
        fitted=fitted,
        tapered=record.tapered,
        profile=profile_stiffness(
            fitted_band(best.spectrum, options), bounds, best.search, np.linspace(low, high, points)
        ),
        many_starts=fit_from_many_starts(band, bounds, options.random_starts, rng),
        other_bounds=fit_within_random_bounds(band, bounds, options.random_starts, rng),
        tried=tried,
        flags=flags,
    )


def wristalyzer_record(
    trial: Trial, options: WristalyzerOptions, sources: Mapping[str, Source] | None = None
) -> tuple[WristalyzerRecord, tuple[str, ...]]:
    """Record that the estimators take (N·m, rad), with its timing corrected, and flags of the timing.

    Arguments are those of `analyse_wristalyzer`.
    """
    prepared = prepare(trial, options)
    torque, angle = prepared.torque[prepared.kept], prepared.angle[prepared.kept]
    if not np.ptp(torque) > 0.0 or not np.ptp(angle) > 0.0:
        raise InputError(
            "expected a torque perturbation and a moving joint, found a constant signal: check that "
            "the perturbation was applied"
        )
    timing = (options.cut_s, options.perturbation_period_s, options.excited_band_hz)
    on_time, flags = timed(trial, *timing)
    if on_time is not trial:
        trial, prepared = on_time, prepare(on_time, options)
    record = WristalyzerRecord(trial, prepared, options, sources or {})
    record.averaged.band(*options.fit_band_hz)
    if options.perturbation_period_s is not None:
        record.periodic.band(*options.fit_band_hz)
    return record, flags


def wristalyzer_rows(
    condition: str, analysis: WristalyzerAnalysis
) -> tuple[list[Estimate], list[Contribution]]:
    """Tidy rows of one trial.

    Returns:
        estimates: I, B, K, the error of a search, and VAF over the trial (%), with flags.
        contributions: budgets of I, B, K, source by source.
    """
    rows: list[Estimate] = []
    contributions: list[Contribution] = []
    for estimator, fit in analysis.fitted.items():
        names, quantities = ("wristalyzer", condition, PATHWAY, estimator), dict(fit.quantities)
        if fit.search is not None:
            quantities["error"] = Quantity(fit.search.cost, "1")
        score = analysis.prepared.prediction_vaf(fit.parameters)
        quantities["VAF_trial"] = Quantity(score, "%")
        misfit = () if score >= LEAST_VAF else ("lack-of-fit",)
        rows += flagged(rows_of(names, quantities), *fit.flags, *analysis.flags, *misfit)
        contributions += contributions_of(names, quantities)
    quoted = next(name for name in RECOMMENDED if name in analysis.fitted)
    return recommended(rows, PATHWAY, quoted), contributions


def wristalyzer_result(analysis: WristalyzerAnalysis) -> Result:
    """Arrays and facts of one trial, for figures and for cross-validation."""
    prepared, fit = analysis.prepared, analysis.fitted[AS_PRINTED]
    searches = {name: fitted.search for name, fitted in analysis.fitted.items() if fitted.search is not None}
    signals = {
        "torque": (prepared.torque, "Nm"),
        "angle": (prepared.angle, "rad"),
        "predicted_angle": (simulate_angle(fit.parameters, prepared.torque, prepared.rate_hz), "rad"),
    }
    for estimator, fitted in analysis.fitted.items():
        if fitted.spectrum is not None:
            signals |= _spectrum(estimator, fitted.spectrum)
            signals[f"{estimator}/parameters"] = (fitted.parameters, PARAMETER_UNITS)
            signals[f"{estimator}/sem"] = (fitted.search.sem[None], "as parameters")
    signals |= _spectrum("tapered", analysis.tapered)
    signals |= {
        "profile/stiffness": (analysis.profile.stiffness, "Nm/rad"),
        "profile/cost": (analysis.profile.cost, "1"),
        "tried/stiffness": ([k for k, _, _ in analysis.tried], "Nm/rad"),
        "tried/smooth": ([smooth.parameters for _, smooth, _ in analysis.tried], PARAMETER_UNITS),
        "tried/modulus": ([modulus.parameters for _, _, modulus in analysis.tried], PARAMETER_UNITS),
        "many_starts/start": ([f.start for f in analysis.many_starts], PARAMETER_UNITS),
        "many_starts/parameters": ([f.parameters for f in analysis.many_starts], PARAMETER_UNITS),
        "other_bounds/parameters": (
            np.reshape([f.parameters for f in analysis.other_bounds], (-1, 3)),
            PARAMETER_UNITS,
        ),
    }
    spread = np.ptp([f.parameters[2] for f in analysis.many_starts if f.converged])
    facts = {
        "rate_hz": prepared.rate_hz,
        "kept_samples": [prepared.kept.start, prepared.kept.stop],
        "profile_limit": analysis.profile.limit,
        "converged": {name: search.converged for name, search in searches.items()},
        "at_bound": {name: search.at_bound for name, search in searches.items()},
        "many_starts_converged": sum(f.converged for f in analysis.many_starts),
        "many_starts_stiffness_spread_Nm_per_rad": float(spread),
        "tried_modulus_cost": [m.cost for _, _, m in analysis.tried],
        "tried_smooth_cost": [s.cost for _, s, _ in analysis.tried],
        "tried_modulus_vaf_percent": [prepared.prediction_vaf(m.parameters) for _, _, m in analysis.tried],
    }
    return Result.of(signals, facts)


def _spectrum(name: str, estimate: FrequencyResponse) -> dict[str, tuple[np.ndarray, str]]:
    return {
        f"{name}/frequency": (estimate.frequency_hz, "Hz"),
        f"{name}/response": (estimate.response, "rad/Nm"),
        f"{name}/coherence": (estimate.coherence, "1"),
    }


def cross_validate_wristalyzer(
    results: dict[str, Result],
) -> Annotated[np.ndarray, "(conditions, conditions)"]:
    """Predict every trial's angle with every trial's parameters (thesis section 3 and Figure 4-3).

    results: condition -> `wristalyzer_result`.
    Returns: VAF (%), parameters of the row's condition, angle and torque of the column's.
    """
    trials = _prepared(results)
    return np.array(
        [
            [trial.prediction_vaf(result.arrays[f"{AS_PRINTED}/parameters"]) for trial in trials]
            for result in results.values()
        ]
    )


def validate_other_bounds(
    results: dict[str, Result], key: str = "other_bounds/parameters"
) -> Annotated[np.ndarray, "(fits, 3)", "%"]:
    """VAF of the angle by every fit within random bounds: in its own trial, mean and lowest in the others.

    results: condition -> `wristalyzer_result`.
    key: array of the fits' parameters; those within random bounds by default.
    Returns: 0 in place of a negative VAF, or of one that diverged.
    """
    trials, scores = _prepared(results), []
    with np.errstate(over="ignore", invalid="ignore"):
        for k, result in enumerate(results.values()):
            for parameters in np.reshape(result.arrays[key], (-1, 3)):
                vafs = np.fmax([trial.prediction_vaf(parameters) for trial in trials], 0.0)
                others = np.delete(vafs, k)
                scores.append((vafs[k], others.mean(), others.min()))
    return np.reshape(scores, (-1, 3))


def _prepared(results: dict[str, Result]) -> list[PreparedTrial]:
    return [
        PreparedTrial(
            result.arrays["torque"],
            result.arrays["angle"],
            slice(*result.facts["kept_samples"]),
            result.facts["rate_hz"],
        )
        for result in results.values()
    ]
