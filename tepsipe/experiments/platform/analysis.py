"""A person on a moving platform: impedance of ankle and hip in closed loop, with refusals where needed.

The torques of both joints are fitted with several models of increasing freedom, with the motion of the
platform as instrument (`tepsipe.identification.several_joints.closed_loop`). The first model whose residual
is not coherent with the platform is recommended. Its quantities are quoted as far as the
perturbation identifies them (`tepsipe.identification.several_joints.quantities`). Every model is also fitted
to the first part of the trial and predicts the torque of the rest, beside ordinary regression, which the
feedback biases.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.experiments.budgets import rows_of
from tepsipe.experiments.platform.options import PlatformOptions
from tepsipe.identification.consistency import welch
from tepsipe.identification.result import Quantity, symbol_of
from tepsipe.identification.several_joints.closed_loop import (
    MultiJointOptions,
    RowFit,
    Spectra,
    banded_spectra,
    fit_row,
)
from tepsipe.identification.several_joints.quantities import (
    NAMES,
    driven_products,
    joint_quantities,
    slow_mode,
)
from tepsipe.io.estimates import Estimate
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.statistics.goodness_of_fit import HeldOutVaf, evaluate_held_out

PATHWAY = "closed-loop"
# ends of the record that a prediction cannot use (s)
CUT_S = 1.0
FILTER_ORDER = 4
# no hip assists the angle of the ankle by this part of its own stiffness
ASSISTING = 0.3


@dataclass(frozen=True)
class ModelFit:
    """One model of both joints."""

    rows: tuple[RowFit, ...]
    """Torque of each joint, fitted to the whole trial."""
    quantities: tuple[dict[str, Quantity], ...]
    """Quantities of each joint by name."""
    vaf: tuple[HeldOutVaf, ...]
    direct_vaf: tuple[HeldOutVaf, ...]
    """VAF of each joint, by the instrument and by ordinary regression of the first part (%)."""
    driven_vaf: tuple[float, ...]
    """VAF of the held-out torque that the platform drives (%)."""
    predicted: Annotated[np.ndarray, "(n, joints)", "N·m"]
    """Torque predicted from the angles by the fit to the first part."""

    def rejected(self, below: float) -> bool:
        """Test for residual torque that is coherent with the platform, at a probability ``below``."""
        return any(row.p_value < below for row in self.rows)


@dataclass(frozen=True)
class PlatformAnalysis:
    """Results of one trial."""

    joints: tuple[str, ...]
    """Names."""
    spectra: Spectra
    """Responses to the platform and coherence (Hz, rad, N·m)."""
    mode: Annotated[np.ndarray, "(joints,)"]
    """Slow motion of the joints with the platform."""
    models: dict[str, ModelFit]
    """In the order of the options."""
    chosen: str
    """First model that is not rejected, or the last one."""
    time: Annotated[np.ndarray, "(n,)", "s"]
    torque: Annotated[np.ndarray, "(n,)", "N·m"]
    """Filtered torque, without the ends."""
    training: int
    """Number of samples of the first part (samples)."""
    flags: tuple[str, ...] = ()
    """Failed checks of the trial, names in `tepsipe.flags.FLAGS`."""


def analyse_platform(trial: Trial, options: PlatformOptions) -> PlatformAnalysis:
    """Fit all models, test them, and predict the held-out part.

    trial: ``platform``, ``joint_angle``, ``joint_torque``, and ``second_perturbation``, if there is one.
    """
    signals = _signals(trial)
    spectra, first, rest = platform_spectra(trial, options)
    joints = tuple(trial.axes["joint"].tolist())
    mode = slow_mode(spectra, options.mode_below_hz)
    count = signals[0].shape[0]
    training = int(options.training_fraction * count)
    cut = round(CUT_S * trial.rate_hz)
    kept = slice(cut, count - cut)
    angle, torque = (
        butterworth_lowpass(x, trial.rate_hz, _cutoff(trial.rate_hz, options), FILTER_ORDER)
        for x in signals[1:]
    )
    models, first_fits = {}, {}
    for name in options.models:
        rows = tuple(fit_row(spectra, joint, name, options) for joint in range(len(joints)))
        fitted = first_fits[name] = [fit_row(first, joint, name, options) for joint in range(len(joints))]
        direct = [replace(row, parameters=row.direct) for row in fitted]
        by_instrument, by_regression = (
            np.column_stack([_predicted(row, trial.time, angle)[kept] for row in fits_of_model])
            for fits_of_model in (fitted, direct)
        )

        def vaf(predicted: np.ndarray, of=torque[kept], first_part=training - cut) -> tuple[HeldOutVaf, ...]:
            return tuple(_held_out(x, y, first_part) for x, y in zip(of.T, predicted.T, strict=True))

        models[name] = ModelFit(
            rows,
            tuple(
                joint_quantities(row, spectra, joint, joints, options.largest_share, options.mode_below_hz)
                for joint, row in enumerate(rows)
            ),
            vaf(by_instrument),
            vaf(by_regression),
            tuple(_driven_vaf(row, rest, joint) for joint, row in enumerate(fitted)),
            by_instrument,
        )
    accepted = [name for name, model in models.items() if not model.rejected(options.rejected_below)]
    chosen = accepted[0] if accepted else options.models[-1]
    last_fits = [fit_row(rest, joint, chosen, options) for joint in range(len(joints))]
    checks = {
        "joints-exchanged": _exchanged(spectra, models[chosen], joints, options.mode_below_hz),
        "halves-differ": any(map(_differ, first_fits[chosen], last_fits)),
    }
    return PlatformAnalysis(
        *(joints, spectra, mode, models, chosen, trial.time[kept], torque[kept], training - cut),
        tuple(flag for flag, fails in checks.items() if fails),
    )


def _exchanged(spectra: Spectra, model: ModelFit, joints: tuple[str, ...], below_hz: float) -> bool:
    """True if the slow torque of the hip exceeds the ankle's, or torques follow the other joint's angle.

    The ankle carries the trunk, too, and a joint resists its own angle. If the angle of the hip is that of
    the trunk from the vertical, the hip assists the angle of the ankle by as much as it resists its own.
    """
    low = spectra.frequency_hz.mean(axis=1) <= below_hz
    low[0] = True
    driven = np.diag(driven_products(spectra, spectra.torque)[low].sum(axis=0))
    names = [(f"K_{one}_{one}", f"K_{one}_{other}") for one, other in (joints, joints[::-1])]
    pairs = [[of[name] for name in pair] for of, pair in zip(model.quantities, names, strict=True)]
    crossed = all(own.identified and cross.identified and cross.low > own.high for own, cross in pairs)
    own, cross = pairs[1]
    from_vertical = own.identified and cross.identified and cross.high < -ASSISTING * own.value
    return bool(driven[1] > driven[0]) or crossed or from_vertical


def _differ(first: RowFit, last: RowFit) -> bool:
    """True if a determined K or B of the two parts of a trial differs by more than chance."""
    strong = [np.eye(len(row.terms) + (row.delay_s is not None))[: len(row.terms)] for row in (first, last)]
    errors = [
        (np.array([row.directions.standard_error(one) for one in axes]), len(row.directions.influence) - 1.0)
        for row, axes in zip((first, last), strong, strict=True)
    ]
    return bool(welch(first.parameters, last.parameters, *errors)[1].any())


def platform_spectra(trial: Trial, options: PlatformOptions) -> tuple[Spectra, Spectra, Spectra]:
    """Banded spectra (rad, N·m) of the whole trial, of its fitted part and of the rest."""
    signals = _signals(trial)
    spectra = banded_spectra(*signals, trial.rate_hz, options)
    _refuse_unmoved(spectra)
    _refuse_sign(spectra, options.mode_below_hz)
    training = int(options.training_fraction * signals[0].shape[0])
    first = banded_spectra(*(x[:training] for x in signals), trial.rate_hz, options)
    rest = banded_spectra(*(x[training:] for x in signals), trial.rate_hz, options)
    return spectra, first, rest


def _signals(trial: Trial) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Perturbations, angles (rad) and torques (N·m), one column each."""
    names = [name for name in ("platform", "second_perturbation") if name in trial.signals]
    perturbation = np.column_stack([trial.values(name) for name in names])
    return perturbation, trial.values("joint_angle"), trial.values("joint_torque")


def _cutoff(rate_hz: float, options: MultiJointOptions) -> float:
    """Upper end of the band (Hz), as cutoff of the signals whose prediction is scored."""
    return min(options.band_hz[1], 0.4 * rate_hz)


def _refuse_unmoved(spectra: Spectra) -> None:
    joints = spectra.angle.shape[2]
    significant = spectra.coherence[:, :joints] > spectra.coherence_threshold()
    bands, coherent = significant.shape[0], int(significant.any(axis=1).sum())
    if coherent < max(4, 0.2 * bands):
        raise InputError(
            f"expected angles that follow the platform, found significant coherence in {coherent} of "
            f"{bands} bands: check the platform's column, its clock, and that the platform moved"
        )


def _refuse_sign(spectra: Spectra, below_hz: float) -> None:
    """Refuse an ankle whose torque drives a slow fall instead of resisting it."""
    ankle = np.stack([spectra.angle[:, :, 0], spectra.torque[:, :, 0]], axis=2)
    low = spectra.frequency_hz.mean(axis=1) <= below_hz
    low[0] = True
    power = driven_products(spectra, ankle)[low].sum(axis=0)
    stiffness = power[0, 1] / power[0, 0]
    if power[0, 0] > 0.0 and stiffness < 0.0:
        raise InputError(
            f"expected an ankle torque that resists a slow lean, found {stiffness:.3g} N·m/rad: change "
            "torque_sign in the configuration or in the trial sheet, or the sign of the angles"
        )


def _predicted(row: RowFit, time: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Torque of one joint from the angles (rad) by its model (N·m), at time (s)."""
    rate = derivative(time, angle)
    total = np.zeros(time.size)
    late = None if row.delay_s is None else np.maximum(time - row.delay_s, time[0])
    for (kind, joint), value in zip(row.terms, row.parameters, strict=True):
        x = (angle if kind in "KD" else rate)[:, joint]
        if kind in "DE":
            x = scipy.interpolate.CubicSpline(time, x)(late)
        total += value * x
    return total


def _held_out(torque: np.ndarray, predicted: np.ndarray, training: int) -> HeldOutVaf:
    """VAFs of a prediction with the offset of the first part (%)."""
    offset = (torque[:training] - predicted[:training]).mean()
    return evaluate_held_out(torque, predicted + offset, training)


def _driven_vaf(row: RowFit, spectra: Spectra, joint: int) -> float:
    """VAF of the torque that the platform drives, in the held-out part of a trial (%)."""
    torque = spectra.torque[:, :, joint]
    frequency = spectra.frequency_hz
    impedance = row.impedance(frequency.ravel()).reshape(*frequency.shape, -1)
    residual = torque - (impedance * spectra.angle[:, :, : impedance.shape[2]]).sum(axis=2)
    driven = driven_products(spectra, np.stack([torque, residual], axis=2)).sum(axis=0)
    return float(100.0 * (1.0 - driven[1, 1] / driven[0, 0]))


# ---- rows and result -------------------------------------------------------------------------------


def platform_estimates(
    experiment: str, condition: str, analysis: PlatformAnalysis, options: PlatformOptions
) -> list[Estimate]:
    """Tidy rows of one trial: every model by the instrument and by ordinary regression.

    Unidentified quantities have a row without a value and the flag ``not-identified``; rows of a model whose
    residual is coherent with the platform have the flag ``coherent-residual``.
    """
    estimates = []
    for name, model in analysis.models.items():
        impossible = ("negative",) * _falls(analysis.joints, model.quantities)
        for joint, label in enumerate(analysis.joints):
            row, of_joint = model.rows[joint], model.quantities[joint]
            coherent = ("coherent-residual",) * (row.p_value < options.rejected_below)
            flags = coherent + impossible + analysis.flags
            quantities = {key: replace(q, flags=flags) for key, q in of_joint.items()}
            quantities[f"p_value_{label}"] = Quantity(row.p_value, "1")
            quantities[f"VAF_driven_held_out_{label}"] = Quantity(model.driven_vaf[joint], "%")
            quantities |= _vafs(label, model.vaf[joint])
            quotable = name == analysis.chosen and not impossible
            quoted = {key for key, q in of_joint.items() if q.identified and quotable}
            estimates += [
                replace(estimate, recommended=estimate.quantity in quoted)
                for estimate in rows_of((experiment, condition, PATHWAY, f"iv-{name}"), quantities)
            ]
            direct = {
                f"{NAMES[kind]}_{label}_{analysis.joints[j]}": Quantity(value, symbol_of(NAMES[kind]))
                for (kind, j), value in zip(row.terms, row.direct.tolist(), strict=True)
            }
            names = (experiment, condition, PATHWAY, f"direct-{name}")
            estimates += rows_of(names, direct | _vafs(label, model.direct_vaf[joint]))
    return estimates


def _falls(joints: Sequence[str], quantities: Sequence[Mapping[str, Quantity]]) -> bool:
    """True if the interval of a joint's own stiffness lies below 0, as with a torque of another sign."""
    own = [of_joint.get(f"K_{label}_{label}") for label, of_joint in zip(joints, quantities, strict=True)]
    return any(q is not None and q.identified and q.value < 0.0 and q.high < 0.0 for q in own)


def _vafs(joint: str, vaf: HeldOutVaf) -> dict[str, Quantity]:
    return {
        f"VAF_training_{joint}": Quantity(vaf.training, "%"),
        f"VAF_held_out_{joint}": Quantity(vaf.held_out, "%"),
    }


def platform_result(analysis: PlatformAnalysis, options: PlatformOptions, unit: str) -> Result:
    """Arrays and facts of one trial; ``unit`` is the unit of the platform's motion."""
    spectra, chosen = analysis.spectra, analysis.models[analysis.chosen]
    frequency = spectra.frequency_hz.mean(axis=1)
    joints = len(analysis.joints)
    impedance = np.stack([row.impedance(frequency) for row in chosen.rows], axis=1)
    response = spectra.response[:, 0]
    signals = {
        "frequency": (frequency, "Hz"),
        "angle_response": (response[:, :joints], f"rad/({unit})"),
        "torque_response": (response[:, joints:], f"Nm/({unit})"),
        "torque_response_model": (np.einsum("fij,fj->fi", impedance, response[:, :joints]), f"Nm/({unit})"),
        "coherence": (spectra.coherence, "1"),
        "mode": (analysis.mode, "1"),
        "time": (analysis.time, "s"),
        "torque": (analysis.torque, "Nm"),
        "predicted_torque": (chosen.predicted, "Nm"),
    }
    for name, model in analysis.models.items():
        for label, row in zip(analysis.joints, model.rows, strict=True):
            signals[f"{name}/{label}/strength"] = (row.directions.strength, "1")
            if row.delay_s is not None:
                signals[f"{name}/{label}/delay"] = (row.delays_s, "s")
                signals[f"{name}/{label}/delay_chi2"] = (row.delay_chi2, "1")
    facts = {
        "joints": list(analysis.joints),
        "chosen": analysis.chosen,
        "order": list(analysis.models),
        "rejected": chosen.rejected(options.rejected_below),
        "perturbations": spectra.perturbation.shape[2],
        "coherence_threshold": spectra.coherence_threshold(),
        "platform_unit": unit,
        "held_out_from_s": float(analysis.time[analysis.training]),
        "models": {
            name: {
                "rejected": model.rejected(options.rejected_below),
                "p_values": [row.p_value for row in model.rows],
                "chi2": [row.chi2 for row in model.rows],
                "freedom": [row.freedom for row in model.rows],
                "refusals": [
                    quantity.refusal
                    for of in model.quantities
                    for quantity in of.values()
                    if not quantity.identified
                ],
                "converged": all(row.converged for row in model.rows),
            }
            for name, model in analysis.models.items()
        },
    }
    return Result.of(signals, facts)
