"""Results of one trial of the ankle dummy: rows, arrays, facts, and cross-validation."""

import zlib
from dataclasses import astuple, replace
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.budgets import contributions_of, rows_of
from tepsipe.experiments.dummy.foot_treadmill import TreadmillCheck
from tepsipe.experiments.dummy.leg_pathways import DummyAnalysis
from tepsipe.experiments.fitted import Fitted
from tepsipe.identification.likelihood.result import LikelihoodEstimates
from tepsipe.identification.result import Quantity
from tepsipe.io.result import Result
from tepsipe.mechanics.impedance_model import PARAMETER_UNITS, PARAMETERS, impedance_torque
from tepsipe.statistics.bootstrap import bootstrap_mean
from tepsipe.statistics.goodness_of_fit import vaf

LOAD_UNITS = {"Fy": "N", "Mx": "Nm"}


def fitted_dummy(condition: str, analysis: DummyAnalysis, draws: int, seed: int) -> Fitted:
    """I, B, K, and VAF (%) per perturbation and over the trial, by every pathway.

    Output error and joint likelihood add the VAF (%) of the angle, VAF_theta_trial; the joint likelihood also
    adds its other quantities. The output error has no SEM as printed.

    draws: bootstrapped mean VAFs of a pathway; VAF ends at 100 % and its interval is not symmetric.
    seed: seed of the generators that draw perturbations, one per pathway: intervals do not depend on the
    other pathways.
    """
    rows, contributions = [], []
    for name, regression in analysis.regressions.items():
        names = ("dummy", condition, name, analysis.pathways[name].estimator)
        printed = np.mean([fit.sem_as_printed for fit in regression.fits], axis=0)
        failed = (*analysis.flags, *(analysis.checks[name].flags if name in analysis.checks else ()))
        further = dict(analysis.quantities[name])
        joint = {
            p: replace(further.pop(p), as_printed=sem if np.isfinite(sem) else None, flags=failed)
            for p, sem in zip(PARAMETERS, printed.tolist(), strict=True)
        }
        vafs = regression.vaf_per_perturbation
        rng = np.random.default_rng([seed, zlib.crc32(name.encode())])
        error, low, high = (float(x[0]) for x in astuple(bootstrap_mean(vafs[:, None], draws, rng)))
        explained = {
            "VAF_perturbation": Quantity(float(vafs.mean()), "%", error, low, high, error),
            "VAF_trial": Quantity(regression.vaf_trial, "%"),
        }
        if name in analysis.simulating_fits:
            further["VAF_theta_trial"] = Quantity(analysis.simulating_fits[name].vaf_angle, "%")
        rows += rows_of(names, joint | explained | further, len(regression.fits))
        contributions += contributions_of(names, joint)
    return Fitted(dummy_result(analysis), rows, contributions)


def dummy_result(analysis: DummyAnalysis) -> Result:
    """Arrays and facts of one trial, for figures and for cross-validation."""
    first = next(iter(analysis.regressions.values()))
    windows = np.array([[p.start, p.stop] for p in first.perturbations])
    signals = {
        "time": (analysis.time, "s"),
        "belt_velocity": (analysis.belt_velocity, "m/s"),
        "windows": (windows, "samples"),
    }
    if analysis.belt_command is not None:
        signals["belt_command"] = (analysis.belt_command, "m/s")
    for name, regression in analysis.regressions.items():
        signals |= {
            f"{name}/torque": (regression.torque, "Nm"),
            f"{name}/predicted_torque": (regression.predicted, "Nm"),
            f"{name}/regressors": (regression.regressors, "rad/s2, rad/s, rad"),
            f"{name}/parameters": (regression.parameters, PARAMETER_UNITS),
            f"{name}/mean_and_interval": (
                # rows mean, low, high
                [regression.mean, *analysis.budgets[name].interval(regression.mean)],
                "as parameters",
            ),
            f"{name}/vaf_per_perturbation": (regression.vaf_per_perturbation, "%"),
            # by perturbation, reading of eq (3-2) and parameter
            f"{name}/sem": ([fit.sem for fit in regression.fits], "as parameters"),
        }
    for name, fit in analysis.simulating_fits.items():
        signals[f"{name}/angle"] = (fit.angle, "rad")
        signals[f"{name}/simulated_angle"] = (fit.simulated, "rad")
    for name, load in analysis.loads.items():
        signals[f"loads/{name}"] = (load.astype(np.float32), LOAD_UNITS[name.partition("/")[0]])
    lengths = np.diff(windows, axis=1) * (analysis.time[1] - analysis.time[0])
    facts = {
        "pathways": list(analysis.regressions),
        "marker_residual_rms_m": analysis.marker_residual_rms_m,
        "marker_noise_m": analysis.marker_noise_m,
        "theta_rest_rad": first.theta_rest_rad,
        "mean_window_s": float(lengths.mean()),
        "damping_per_com_lag_Nms_per_rad_per_s": analysis.damping_per_com_lag,
        "output_error_delay_s": {name: fit.delay_s for name, fit in analysis.simulating_fits.items()},
        "treadmill_errors": {
            name: _treadmill_error(check) for name, check in analysis.checks.items() if check.error
        },
        "joint_likelihood": {name: likelihood_facts(f) for name, f in analysis.likelihood_estimates.items()},
        "estimators": {name: pathway.estimator for name, pathway in analysis.pathways.items()},
        "condition_numbers": {
            name: float(np.mean([fit.condition_number for fit in regression.fits]))
            for name, regression in analysis.regressions.items()
        },
    }
    return Result.of(signals, facts)


def likelihood_facts(estimates: LikelihoodEstimates) -> dict:
    """Noise levels, timing and softening of a fit, as plain numbers."""
    fit = estimates.fit
    facts = {
        "delay_s": fit.value("delay"),
        "delay_standard_error_s": fit.standard_error("delay"),
        "marker_noise_m": fit.channels.marker_noise_m,
        "log_noise_m_per_s": fit.log_noise_m_per_s,
    }
    if fit.log_noise_m_per_s is not None:
        facts |= {"log_lag_s": fit.value("lag"), "log_gain": fit.value("gain")}
    if estimates.softening is not None:
        softening, damping, half = estimates.softening
        facts |= {
            "softening_Nm_per_rad": softening,
            "softened_damping_Nms_per_rad": damping,
            "half_softening_rad": half,
        }
    return facts


def _treadmill_error(check: TreadmillCheck) -> dict:
    """Errors of I, B, K predicted by held-out trials of the treadmill (units of I, B, K)."""
    error = check.error
    return {
        "parameters": error.parameters.tolist(),
        "standard_error": error.standard_error.tolist(),
        "trials": list(error.trials),
        "difference": error.difference,
    }


def cross_validate_dummy(
    results: dict[str, Result], pathway: str
) -> Annotated[np.ndarray, "(conditions, conditions)"]:
    """Predict every trial's torque with every trial's mean parameters (thesis section 3-1-2).

    results: condition -> `dummy_result`.
    Returns: VAF (%) over the whole trial, parameters of the row's condition, trial of the column's.
    """
    for condition, result in results.items():
        if f"{pathway}/parameters" not in result.arrays:
            raise InputError(f"{condition}: expected the pathway {pathway!r}, found none: fit it again")
    matrix = np.empty((len(results), len(results)))
    for i, reference in enumerate(results.values()):
        mean = reference.arrays[f"{pathway}/parameters"].mean(axis=0)
        for j, trial in enumerate(results.values()):
            theta_dd, theta_d, theta = trial.arrays[f"{pathway}/regressors"].T
            predicted = impedance_torque(mean, theta, theta_d, theta_dd)
            matrix[i, j] = vaf(trial.arrays[f"{pathway}/torque"], predicted)
    return matrix


def without_own(
    matrix: Annotated[np.ndarray, "(trials, trials)"],
) -> Annotated[np.ndarray, "(trials, trials - 1)"]:
    """VAF (%) by predicted trial and by the other trials whose parameters predict it.

    matrix: VAF (%) as `cross_validate_dummy` returns it.
    """
    return np.array([np.delete(vafs, k) for k, vafs in enumerate(matrix.T)]).reshape(len(matrix), -1)
