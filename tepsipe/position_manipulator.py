"""Joint impedance in a position-controlled manipulator: angle imposed, torque measured.

    tau(t) = I theta'' + B theta' + K theta + offset

fitted by linear regression on the first part of a trial and tested on the rest.
"""

from dataclasses import dataclass

import numpy as np

from tepsipe.errors import InputError
from tepsipe.estimates import Estimate
from tepsipe.filters import butterworth_lowpass
from tepsipe.metrics import LinearFit, least_squares_line, vaf
from tepsipe.result_file import Result
from tepsipe.rigid_segments import derivative
from tepsipe.second_order import PARAMETERS, UNITS, admittance
from tepsipe.spectra import SpectralEstimate, frequency_averaged
from tepsipe.trial_file import Trial

PATHWAY = "impedance"
ESTIMATOR = "regression"


@dataclass(frozen=True)
class PositionManipulatorOptions:
    """Choices of the analysis.

    Attributes
    ----------
    lowpass_cutoff_hz, lowpass_order : float, int
        Bidirectional Butterworth filter (Hz, -).
    cut_s : float
        Time cut at both ends (s).
    training_fraction : float
        First part of the record that is fitted (-).
    averaged_bins : int
        Raw frequencies averaged into one (-).
    block_s : float
        Length of the blocks that are bootstrapped (s).
    bootstrap_draws : int
        Bootstrap samples of an interval (-).
    """

    lowpass_cutoff_hz: float
    lowpass_order: int
    cut_s: float
    training_fraction: float
    averaged_bins: int
    block_s: float
    bootstrap_draws: int


@dataclass(frozen=True)
class PositionManipulatorAnalysis:
    """What one trial gives.

    Attributes
    ----------
    time, angle, torque, predicted : ndarray, shape (n,)
        Filtered signals after both ends are cut (s, rad, Nm) and the torque predicted (Nm).
    training : int
        Number of samples that were fitted (samples).
    fit : LinearFit
        I (Nms2/rad), B (Nms/rad), K (Nm/rad), offset (Nm).
    bootstrap : ndarray, shape (draws, 4)
        The same for bootstrapped blocks.
    spectrum : SpectralEstimate
        Impedance tau/theta and coherence of the unfiltered record (Hz, Nm/rad).
    vaf_training, vaf_held_out : float
        VAF (%) about the mean torque of the fitted part.
    vaf_held_out_as_printed : float
        VAF (%) of the held-out part with that mean left in, thesis eq (3-1).
    """

    time: np.ndarray
    angle: np.ndarray
    torque: np.ndarray
    predicted: np.ndarray
    training: int
    fit: LinearFit
    bootstrap: np.ndarray
    spectrum: SpectralEstimate
    vaf_training: float
    vaf_held_out: float
    vaf_held_out_as_printed: float


def analyse_position_manipulator(
    trial: Trial, options: PositionManipulatorOptions, rng: np.random.Generator
) -> PositionManipulatorAnalysis:
    """Spectral estimate, coherence, and I, B, K by regression with a held-out test.

    Parameters
    ----------
    trial : Trial
        ``angle`` (rad) and ``torque`` (Nm).
    options : PositionManipulatorOptions
        Choices (units in their names).
    rng : numpy.random.Generator
        Draws blocks.

    Returns
    -------
    PositionManipulatorAnalysis
        Spectrum, fit and tests (rad, Nm, s).

    Raises
    ------
    InputError
        If the record is too short or the joint does not move.
    """
    rate = trial.rate_hz
    cut = round(options.cut_s * rate)
    kept = slice(cut, trial.time.size - cut)
    time = trial.time[kept]
    block = round(options.block_s * rate)
    training = int(options.training_fraction * time.size)
    if training < 4 * block or time.size - training < block:
        raise InputError(
            f"expected at least 4 blocks of {options.block_s:g} s to fit and one to test, found "
            f"{time.size / rate:.3g} s of record after cutting: shorten the blocks, cut less, or "
            "record longer"
        )

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
            f"expected a moving joint, found that {error}: check that the perturbation was applied"
        ) from error
    predicted = regressors @ fit.parameters
    level = torque[:training].mean()
    test = slice(training, None)
    raw_angle = trial.values("angle")[kept]
    raw_torque = trial.values("torque")[kept]
    return PositionManipulatorAnalysis(
        time=time,
        angle=angle,
        torque=torque,
        predicted=predicted,
        training=training,
        fit=fit,
        bootstrap=_bootstrap_blocks(
            regressors[:training], torque[:training], block, options.bootstrap_draws, rng
        ),
        spectrum=frequency_averaged(
            raw_angle - raw_angle.mean(), raw_torque - raw_torque.mean(), rate, options.averaged_bins
        ),
        vaf_training=vaf(torque[:training] - level, predicted[:training] - level),
        vaf_held_out=vaf(torque[test] - level, predicted[test] - level),
        vaf_held_out_as_printed=vaf(torque[test], predicted[test]),
    )


def _bootstrap_blocks(
    regressors: np.ndarray, y: np.ndarray, block: int, draws: int, rng: np.random.Generator
) -> np.ndarray:
    """Solutions for blocks drawn with replacement, from the blocks' normal equations."""
    blocks = y.size // block
    scale = np.linalg.norm(regressors, axis=0)
    j = (regressors / scale)[: blocks * block].reshape(blocks, block, -1)
    normal = np.einsum("bni,bnj->bij", j, j)
    right = np.einsum("bni,bn->bi", j, y[: blocks * block].reshape(blocks, block))
    drawn = rng.integers(0, blocks, (draws, blocks))
    solutions = np.linalg.solve(normal[drawn].sum(axis=1), right[drawn].sum(axis=1)[..., None])
    return solutions[..., 0] / scale


def position_manipulator_estimates(
    experiment: str, condition: str, analysis: PositionManipulatorAnalysis
) -> list[Estimate]:
    """Tidy rows of one trial: I, B, K and VAF (%) of the fitted and the held-out part."""
    names = (experiment, condition, PATHWAY, ESTIMATOR)
    low, high = np.percentile(analysis.bootstrap, [2.5, 97.5], axis=0)
    rows = [
        Estimate(
            *names,
            quantity,
            UNITS[quantity],
            float(analysis.fit.parameters[k]),
            float(analysis.bootstrap[:, k].std(ddof=1)),
            float(low[k]),
            float(high[k]),
            float(analysis.fit.sem_as_printed[k]),
        )
        for k, quantity in enumerate(PARAMETERS)
    ]
    rows.append(Estimate(*names, "VAF_training", "%", analysis.vaf_training))
    rows.append(Estimate(*names, "VAF_held_out", "%", analysis.vaf_held_out))
    rows.append(Estimate(*names, "VAF_held_out_as_printed", "%", analysis.vaf_held_out_as_printed))
    return rows


def position_manipulator_result(analysis: PositionManipulatorAnalysis) -> Result:
    """Arrays and facts of one trial, for the figures (units in the result)."""
    spectrum = analysis.spectrum
    model = 1.0 / admittance(analysis.fit.parameters[:3], spectrum.frequency_hz)
    arrays = {
        "time": analysis.time,
        "angle": analysis.angle,
        "torque": analysis.torque,
        "predicted_torque": analysis.predicted,
        "frequency": spectrum.frequency_hz,
        "impedance": spectrum.response,
        "impedance_model": model,
        "coherence": spectrum.coherence,
    }
    units = {
        "time": "s",
        "angle": "rad",
        "torque": "Nm",
        "predicted_torque": "Nm",
        "frequency": "Hz",
        "impedance": "Nm/rad",
        "impedance_model": "Nm/rad",
        "coherence": "1",
    }
    facts = {
        "training_s": float(analysis.time[analysis.training - 1] - analysis.time[0]),
        "held_out_from_s": float(analysis.time[analysis.training]),
        "vaf_held_out_percent": analysis.vaf_held_out,
        "offset_Nm": float(analysis.fit.parameters[3]),
    }
    return Result(arrays, units, facts)
