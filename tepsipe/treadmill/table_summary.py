"""Summary of a recorded treadmill besides scores: coefficients, validity, cross-prediction."""

import numpy as np
import scipy

from tepsipe.statistics.residuals import solution_with_errors
from tepsipe.treadmill.black_box_models import DiscreteTransfer
from tepsipe.treadmill.mass_models import MassSpringDamper, motion_regressors
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.registry import (
    MOTION,
    FamilyOptions,
    FittedModel,
    calibrated_range,
    evaluate,
    fit_model,
)

# coefficients of the mass-spring-damper, in the order of its regressors
TERMS = ("m", "c", "k")
BLOCKS = 20
# models that are quick enough to be refitted to every recording
CROSSED = ("mass-spring-damper", "output-error", "fir", "fir-causal")


def model_coefficients(models: list[FittedModel], recordings: list[BeltRecording]) -> dict[str, dict]:
    """Coefficients of models that have few, with 95 % intervals where the fit is linear.

    Intervals are by a delete-one-block jackknife over `BLOCKS` stretches of the calibration, which
    holds for residuals that are correlated in time (Kunsch 1989, Annals of Statistics 17,
    1217-1241), with Student's t.

    recordings: their calibration, filtered as they are.
    Returns: mass-spring-damper -> m, c, k -> [value, low, high] (unit of the load over m/s², m/s, m);
    discrete models -> ``numerator`` (unit of the load over m/s²) and ``denominator``.
    """
    coefficients: dict[str, dict] = {}
    for fitted in models:
        if isinstance(fitted.model, MassSpringDamper):
            rows = np.concatenate([motion_regressors(r)[r.evaluated] for r in recordings])
            load = np.concatenate([r.load[r.evaluated] for r in recordings])
            _, error, freedom = solution_with_errors(rows, load, max(1, load.size // BLOCKS))
            width = scipy.stats.t.ppf(0.975, freedom) * error
            coefficients[fitted.name] = {
                term: [float(c), float(c - w), float(c + w)]
                for term, c, w in zip(TERMS, fitted.model.coefficients, width, strict=False)
            }
        elif isinstance(fitted.model, DiscreteTransfer):
            coefficients[fitted.name] = {
                "numerator": fitted.model.numerator.tolist(),
                "denominator": fitted.model.denominator.tolist(),
            }
    return coefficients


def range_of_validity(recordings: list[BeltRecording]) -> dict[str, list[float]]:
    """Range of the calibration: ``velocity`` (m/s), ``acceleration`` (m/s²), both from lowest to highest."""
    ranges = calibrated_range(recordings)
    return {name: list(ranges[name]) for name in MOTION}


def beyond(recording: BeltRecording, ranges: dict[str, list[float]]) -> float:
    """Share of a recording's samples whose velocity or acceleration lies outside the calibrated range."""
    outside = np.zeros(int(recording.evaluated.sum()), dtype=bool)
    for name, (low, high) in ranges.items():
        values = getattr(recording, name)[recording.evaluated]
        outside |= (values < low) | (values > high)
    return float(outside.mean())


def cross_prediction(
    recordings: dict[str, BeltRecording], family: list[str], options: FamilyOptions
) -> dict[str, dict[str, dict[str, float]]]:
    """R² of every quick model, fitted to one recording and evaluated on each: model -> fitted to -> on.

    ``recordings`` have the same filter; with fewer than two the result is empty.
    """
    if len(recordings) < 2:
        return {}
    scores: dict[str, dict[str, dict[str, float]]] = {}
    for name in (model for model in family if model in CROSSED):
        fits = {train: fit_model(name, [r], options) for train, r in recordings.items()}
        scores[name] = {
            train: {test: evaluate(fitted, [r]).r2 for test, r in recordings.items()}
            for train, fitted in fits.items()
        }
    return scores


def table_facts(
    models: list[FittedModel],
    calibration: list[BeltRecording],
    recordings: dict[str, BeltRecording],
    family: list[str],
    options: FamilyOptions,
) -> dict:
    """Facts of a calibration for its report: ``coefficients``, ``calibrated``, ``beyond`` and ``crossed``.

    calibration: recordings with the role calibrate, filtered as the models'.
    recordings: all recordings by name, filtered alike; those outside the calibration are compared with its
    range.
    family: names of the models.
    """
    ranges, used = range_of_validity(calibration), {r.name for r in calibration}
    return {
        "coefficients": model_coefficients(models, calibration),
        "calibrated": ranges,
        "beyond": {name: beyond(r, ranges) for name, r in recordings.items() if r.name not in used},
        "crossed": cross_prediction(recordings, family, options),
    }
