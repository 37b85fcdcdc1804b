"""SIPE in the torque-controlled manipulator, from one trial to its parameters (thesis section 3-1-1)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.budgets import contributions_of, with_budget
from tepsipe.experiments.wristalyzer.budget import period_budget, spectral_budget
from tepsipe.identification.admittance_fit import (
    AdmittanceFit,
    Bounds,
    StiffnessProfile,
    fit_as_printed,
    fit_from_many_starts,
    fit_scaled,
    profile_stiffness,
)
from tepsipe.identification.regression.periods import PeriodFit, fit_periods
from tepsipe.io.budget_table import Contribution
from tepsipe.io.estimates import Estimate, flagged, recommended
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS, simulate_angle
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.signals.response import FrequencyResponse
from tepsipe.signals.spectra import frequency_averaged, period_averaged, power_at_lines
from tepsipe.statistics.goodness_of_fit import vaf
from tepsipe.statistics.uncertainty import Budget, Source

PATHWAY = "admittance"
REGRESSION = "period-regression"
# without a period no regression over periods
WITHOUT_PERIOD = "spectral-fit"


@dataclass(frozen=True)
class WristalyzerOptions:
    """Options of the thesis (section 3-1-1, Table 3-2) and of the tests of its choices.

    Attributes
    ----------
    lowpass_cutoff_hz, lowpass_order : float, int
        Zero-lag Butterworth filter (Hz, -).
    cut_s : float
        Time cut at both ends (s).
    averaged_bins : int
        Raw frequencies averaged into one (-).
    fit_band_hz : (float, float)
        Lowest and highest fitted frequency (Hz).
    perturbation_period_s : float or None
        Period of the multisine (s); None if the perturbation is not periodic.
    excited_band_hz : (float, float)
        Lowest and highest frequency of the perturbation (Hz).
    bounds : Bounds
        Starting values and bounds (N·m·s²/rad, N·m·s/rad, N·m/rad).
    random_starts : int
        Number of random starting values (-).
    tried_stiffness_Nm_per_rad : tuple of float
        Starting values of K tried with each type of residual (N·m/rad).
    profile_Nm_per_rad : (float, float, int)
        Lowest and highest K of the profile (N·m/rad) and number of points (-).
    """

    lowpass_cutoff_hz: float
    lowpass_order: int
    cut_s: float
    averaged_bins: int
    fit_band_hz: tuple[float, float]
    perturbation_period_s: float | None
    excited_band_hz: tuple[float, float]
    bounds: Bounds
    random_starts: int
    tried_stiffness_Nm_per_rad: tuple[float, ...]
    profile_Nm_per_rad: tuple[float, float, int]


@dataclass(frozen=True)
class PreparedTrial:
    """Filtered signals of a trial.

    Attributes
    ----------
    torque, angle : ndarray, shape (n,)
        Whole trial (N·m, rad).
    kept : slice
        Samples that remain after both ends are cut (samples).
    rate_hz : float
        Sampling rate (Hz).
    """

    torque: np.ndarray
    angle: np.ndarray
    kept: slice
    rate_hz: float

    def prediction_vaf(self, parameters: np.ndarray) -> float:
        """VAF (%) of the angle predicted from the torque alone, over the kept part (thesis eq 3-1).

        ``parameters`` are I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad).
        """
        predicted = simulate_angle(parameters, self.torque, self.rate_hz)
        return vaf(self.angle[self.kept], predicted[self.kept])


def prepare(trial: Trial, options: WristalyzerOptions) -> PreparedTrial:
    """Filter torque and angle identically, and cut both ends (N·m, rad, samples).

    Raises
    ------
    InputError
        If no samples remain.
    """
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


@dataclass(frozen=True)
class WristalyzerAnalysis:
    """Results of one trial.

    Attributes
    ----------
    prepared : PreparedTrial
        Filtered signals (N·m, rad).
    spectra : dict of str to FrequencyResponse
        Estimator -> spectral estimate over all frequencies (Hz, rad/(N·m)).
    tapered : FrequencyResponse
        The averaged estimate of the tapered record, for frequencies above the perturbation's band.
    fits : dict of str to AdmittanceFit
        Estimator -> fit.
    profile : StiffnessProfile
        Profile of K for the leakage-free estimate, or for the averaged one without a period (N·m/rad).
    many_starts : list of AdmittanceFit
        Fits from random starting values.
    tried : list of (float, AdmittanceFit, AdmittanceFit)
        Starting K (N·m/rad), fit with complex residuals, fit with the modulus.
    regression : PeriodFit or None
        The linear joint nearest to the trial (units there); None without a period.
    budgets : dict of str to Budget
        Estimator -> uncertainty of I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad), where there is one.
    """

    prepared: PreparedTrial
    spectra: dict[str, FrequencyResponse]
    tapered: FrequencyResponse
    fits: dict[str, AdmittanceFit]
    profile: StiffnessProfile
    many_starts: list[AdmittanceFit]
    tried: list[tuple[float, AdmittanceFit, AdmittanceFit]]
    regression: PeriodFit | None
    budgets: dict[str, Budget]


def analyse_wristalyzer(
    trial: Trial,
    options: WristalyzerOptions,
    rng: np.random.Generator,
    sources: Mapping[str, Source] | None = None,
) -> WristalyzerAnalysis:
    """Estimate the admittance of the joint and fit I, B, K by four estimators.

    ``spectral-fit`` averages raw spectra over neighbouring frequencies as the thesis does, and minimises
    its criterion (3-6). ``spectral-fit-modulus`` does the same with the modulus of the log ratio as
    residual, as (3-6) is printed. ``spectral-fit-periods`` averages over whole periods instead.
    ``period-regression`` is the linear joint nearest to the torque, from whole periods, too.

    Parameters
    ----------
    trial : Trial
        ``torque`` (N·m) and ``angle`` (rad).
    options : WristalyzerOptions
        Choices (units in their names).
    rng : numpy.random.Generator
        Draws starting values.
    sources : mapping of str to Source, optional
        What is not known exactly: torque_scale, angle_scale (-), torque_delay_s.

    Returns
    -------
    WristalyzerAnalysis
        Spectra, fits and their tests.

    Raises
    ------
    InputError
        If the record is too short or holds no perturbation.
    """
    prepared = prepare(trial, options)
    torque, angle = prepared.torque[prepared.kept], prepared.angle[prepared.kept]
    if not np.ptp(torque) > 0.0 or not np.ptp(angle) > 0.0:
        raise InputError(
            "expected a torque perturbation and a moving joint, found a constant signal: check that "
            "the perturbation was applied"
        )
    averaged = frequency_averaged(torque, angle, prepared.rate_hz, options.averaged_bins)
    band, bounds = averaged.band(*options.fit_band_hz), options.bounds
    spectra = {"spectral-fit": averaged, "spectral-fit-modulus": averaged}
    fits = {
        "spectral-fit": fit_scaled(band, bounds),
        "spectral-fit-modulus": fit_as_printed(band, bounds),
    }
    sources = sources or {}
    budgets = {WITHOUT_PERIOD: spectral_budget(fits["spectral-fit"], band, bounds, sources)}
    best_band, best, regression = band, fits["spectral-fit"], None
    period_s = options.perturbation_period_s
    if period_s is not None:
        periodic = period_averaged(torque, angle, prepared.rate_hz, period_s, options.excited_band_hz)
        best_band = periodic.band(*options.fit_band_hz)
        best = fit_scaled(best_band, bounds)
        spectra["spectral-fit-periods"], fits["spectral-fit-periods"] = periodic, best
        power = power_at_lines(torque, prepared.rate_hz, period_s, best_band.frequency_hz)
        budgets["spectral-fit-periods"] = spectral_budget(best, best_band, bounds, sources, power)
        # not filtered: its lines are far below half the rate
        recorded = [trial.values(name)[prepared.kept] for name in ("torque", "angle")]
        regression = fit_periods(*recorded, trial.rate_hz, period_s, options.excited_band_hz)
        budgets[REGRESSION] = period_budget(regression, sources)
    tried = []
    for stiffness in options.tried_stiffness_Nm_per_rad:
        start = Bounds(np.array([*bounds.start[:2], stiffness]), bounds.lower, bounds.upper)
        tried.append((stiffness, fit_scaled(band, start), fit_as_printed(band, start)))
    low, high, points = options.profile_Nm_per_rad
    return WristalyzerAnalysis(
        prepared=prepared,
        spectra=spectra,
        tapered=frequency_averaged(torque, angle, prepared.rate_hz, options.averaged_bins, taper=True),
        fits=fits,
        profile=profile_stiffness(best_band, bounds, best, np.linspace(low, high, points)),
        many_starts=fit_from_many_starts(band, bounds, options.random_starts, rng),
        tried=tried,
        regression=regression,
        budgets=budgets,
    )


def wristalyzer_estimates(condition: str, analysis: WristalyzerAnalysis) -> list[Estimate]:
    """Tidy rows of one trial: I, B, K, VAF over the trial (%), the fit's error (-), and its flags.

    The modulus as residual gives no interval: its sum of squares says nothing of the spread of a fit that
    ends where it began. The regression over periods is recommended; without a period ``spectral-fit`` is.
    """
    rows = []
    for estimator, fit in analysis.fits.items():
        flags = ["at-bound"] * fit.at_bound + ["not-converged"] * (not fit.converged)
        names = ("wristalyzer", condition, PATHWAY, estimator)
        own = [
            Estimate(*names, q, UNITS[q], float(value), sem_as_printed=float(printed))
            for q, value, printed in zip(PARAMETERS, fit.parameters, fit.sem_as_printed, strict=True)
        ]
        if estimator in analysis.budgets:
            own = with_budget(own, analysis.budgets[estimator], PARAMETERS)
        own.append(Estimate(*names, "error", "1", fit.cost))
        own.append(Estimate(*names, "VAF_trial", "%", analysis.prepared.prediction_vaf(fit.parameters)))
        rows += flagged(own, *flags)
    if analysis.regression is None:
        return recommended(rows, PATHWAY, WITHOUT_PERIOD)
    found, names = analysis.regression.parameters, ("wristalyzer", condition, PATHWAY, REGRESSION)
    own = [Estimate(*names, q, UNITS[q], float(x)) for q, x in zip(PARAMETERS, found, strict=True)]
    rows += with_budget(own, analysis.budgets[REGRESSION], PARAMETERS)
    rows.append(Estimate(*names, "VAF_trial", "%", analysis.prepared.prediction_vaf(found)))
    return recommended(rows, PATHWAY, REGRESSION)


def wristalyzer_contributions(rows: list[Estimate], budgets: Mapping[str, Budget]) -> list[Contribution]:
    """Rows of the table of budgets, for the rows of `wristalyzer_estimates` (units in them).

    ``budgets`` are those of the analysis: estimator -> uncertainty of I, B, K (their units).
    """
    return [
        contribution
        for estimator, budget in budgets.items()
        for contribution in contributions_of(
            [row for row in rows if row.estimator == estimator], budget, PARAMETERS
        )
    ]


def wristalyzer_result(analysis: WristalyzerAnalysis) -> Result:
    """Arrays and facts of one trial, for figures and for cross-validation (units in the result)."""
    arrays: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}

    def keep(name: str, values, unit: str) -> None:
        arrays[name], units[name] = np.asarray(values), unit

    prepared, fit = analysis.prepared, analysis.fits["spectral-fit"]
    keep("torque", prepared.torque, "Nm")
    keep("angle", prepared.angle, "rad")
    keep("predicted_angle", simulate_angle(fit.parameters, prepared.torque, prepared.rate_hz), "rad")
    for estimator, spectrum in analysis.spectra.items():
        keep(f"{estimator}/frequency", spectrum.frequency_hz, "Hz")
        keep(f"{estimator}/response", spectrum.response, "rad/Nm")
        keep(f"{estimator}/coherence", spectrum.coherence, "1")
        keep(f"{estimator}/parameters", analysis.fits[estimator].parameters, "Nms2/rad, Nms/rad, Nm/rad")
    keep("tapered/frequency", analysis.tapered.frequency_hz, "Hz")
    keep("tapered/response", analysis.tapered.response, "rad/Nm")
    keep("tapered/coherence", analysis.tapered.coherence, "1")
    keep("profile/stiffness", analysis.profile.stiffness, "Nm/rad")
    keep("profile/cost", analysis.profile.cost, "1")
    keep("tried/stiffness", [k for k, _, _ in analysis.tried], "Nm/rad")
    three = "Nms2/rad, Nms/rad, Nm/rad"
    keep("tried/smooth", [smooth.parameters for _, smooth, _ in analysis.tried], three)
    keep("tried/modulus", [modulus.parameters for _, _, modulus in analysis.tried], three)
    keep("many_starts/start", [f.start for f in analysis.many_starts], three)
    keep("many_starts/parameters", [f.parameters for f in analysis.many_starts], three)
    spread = np.ptp([f.parameters[2] for f in analysis.many_starts if f.converged])
    facts = {
        "rate_hz": prepared.rate_hz,
        "kept_samples": [prepared.kept.start, prepared.kept.stop],
        "profile_limit": analysis.profile.limit,
        "converged": {name: f.converged for name, f in analysis.fits.items()},
        "at_bound": {name: f.at_bound for name, f in analysis.fits.items()},
        "many_starts_converged": sum(f.converged for f in analysis.many_starts),
        "many_starts_stiffness_spread_Nm_per_rad": float(spread),
        "tried_modulus_converged": [m.converged for _, _, m in analysis.tried],
        "tried_modulus_cost": [m.cost for _, _, m in analysis.tried],
        "tried_smooth_cost": [s.cost for _, s, _ in analysis.tried],
        "tried_modulus_vaf_percent": [prepared.prediction_vaf(m.parameters) for _, _, m in analysis.tried],
    }
    return Result(arrays, units, facts)


def cross_validate_wristalyzer(results: dict[str, Result]) -> np.ndarray:
    """Predict every trial's angle with every trial's parameters (thesis section 3 and Figure 4-3).

    Parameters
    ----------
    results : dict of str to Result
        Condition -> `wristalyzer_result`.

    Returns
    -------
    ndarray, shape (conditions, conditions)
        VAF (%), parameters of the row's condition, angle and torque of the column's.
    """
    prepared = {
        name: PreparedTrial(
            result.arrays["torque"],
            result.arrays["angle"],
            slice(*result.facts["kept_samples"]),
            result.facts["rate_hz"],
        )
        for name, result in results.items()
    }
    return np.array(
        [
            [trial.prediction_vaf(result.arrays["spectral-fit/parameters"]) for trial in prepared.values()]
            for result in results.values()
        ]
    )


def cross_validation_estimates(conditions: list[str], matrix: np.ndarray) -> list[Estimate]:
    """Mean VAF (%) of each condition's parameters on the other conditions."""
    if len(conditions) < 2:
        return []
    others = ~np.eye(len(conditions), dtype=bool)
    return [
        Estimate(
            "wristalyzer",
            condition,
            PATHWAY,
            "spectral-fit",
            "VAF_cross_validated",
            "%",
            float(matrix[k][others[k]].mean()),
        )
        for k, condition in enumerate(conditions)
    ]
