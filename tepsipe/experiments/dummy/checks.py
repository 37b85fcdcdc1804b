"""Checks of a dummy trial that give warnings, from markers, log and two estimators against each other.

Every check has a size in its own unit, a tolerance below which it does not matter (K changes by about
a quarter of a per cent, less than the uncertainty of the leg's mass), and the probability of so large
a size in a laboratory without the fault. It fails if the size exceeds the tolerance and the
probability is below 0.05 / n, with n the number of checks of the trial (Bonferroni). All checks
together give false alarms in at most 5 % of the trials.

leg-disagrees
    K of the windowed fit against its expected value. Noise-free markers that move like the fitted
    joint pass through filter, pose, derivatives and regression; the bias by errors in variables is
    added. The null distribution includes the effect of Type B sources on the difference: a rod that
    bends within its stated uncertainty is no fault.
foot-leg-delay
    Delay of the angle after the foot: sampling instants, or a marker that slips. It is a parameter of the
    joint likelihood, and says nothing if that does not fit (lack-of-fit).
joint-inertia
    I against the known inertia of the joint: mass, centre of mass or inertia of the leg are wrong.
camera-scale
    Size of the leg's markers over the size of their layout: cameras that are calibrated with a wrong length.
foot-markers-apart
    Markers on the foot alone against each other, at rest between perturbations and locked to them.
markers-slip
    Residuals of the rigid leg on the foot: their means between perturbations.
markers-pulse-locked
    The same residuals averaged over the perturbations: a leg that bends or wobbles.
lack-of-fit
    Residuals of the joint likelihood: their power, and their average over the perturbations. A joint with
    hysteresis fails it.

`noise_bias` is not a test: it predicts the bias of a windowed fit from the measured noise. Perturbations that
repeat each other are fitted by products of different ones, which noise does not bias.

Failed checks flag the rows of the pathways that they concern. Faults of the rig that one trial shows flag all
trials (`tepsipe.experiments.dummy.rig`):

    a windowed fit of the consistent torque    leg-disagrees, foot-leg-delay, joint-inertia, camera-scale,
                                               markers-slip, markers-pulse-locked; noise-biased
    output error and joint likelihood          the same but noise-biased; foot-markers-apart, lack-of-fit

The pathway of the configuration is quoted. If it is a joint likelihood whose model does not fit the trial
(lack-of-fit), while the recommended windowed fit passes its own checks, the windowed fit is quoted.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.experiments.dummy.leg_pathways import DummyAnalysis, DummyOptions, trial_markers
from tepsipe.experiments.dummy.rig import LACK_OF_FIT
from tepsipe.identification.estimators import LEAST_SQUARES
from tepsipe.identification.likelihood.checks import Check, failed, of_likelihood, two_sided
from tepsipe.identification.likelihood.likelihood import LikelihoodFit
from tepsipe.identification.likelihood.result import LikelihoodEstimates, estimated_angle, estimated_foot
from tepsipe.identification.regression.windows import WindowedFits, regress_perturbations
from tepsipe.io.estimates import Estimate, flagged
from tepsipe.io.trial import Trial
from tepsipe.mechanics.impedance_model import PARAMETERS, SMALL
from tepsipe.mechanics.segment_kinematics import SegmentMarkers, motion_of_markers
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.signals.perturbations import rest_samples

UNITS = {
    "leg-disagrees": "1",
    "foot-leg-delay": "s",
    "joint-inertia": "Nms2/rad",
    "foot-markers-apart": "m",
    "markers-slip": "m",
    "markers-pulse-locked": "m",
    "lack-of-fit": "1",
    "camera-scale": "1",
}


def inertia_check(
    fit: LikelihoodEstimates, known_kgm2: float, known_uncertainty_kgm2: float, type_b_kgm2: float = 0.0
) -> Check:
    """Compare I of small movements with the known inertia of the joint.

    known_kgm2, known_uncertainty_kgm2: inertia of the joint and its standard uncertainty.
    type_b_kgm2: type B standard uncertainty of the estimate.
    Returns: its size is the difference.
    """
    difference = float(fit.small[0]) - known_kgm2
    statistical = float(np.sqrt(fit.small_covariance[0, 0]))
    error = float(np.sqrt(statistical**2 + known_uncertainty_kgm2**2 + type_b_kgm2**2))
    return Check("joint-inertia", abs(difference), two_sided(difference / error))


def leg_check(
    of_leg: WindowedFits,
    fit: LikelihoodEstimates,
    leg_markers: SegmentMarkers,
    lowpass: tuple[float, int],
    at_rest: np.ndarray,
    of_k: Annotated[float, "N·m/rad"] = 0.0,
    of_difference: Annotated[float, "N·m/rad"] = 0.0,
) -> Check:
    """Compare K of the windowed fit with its expected value for the fitted joint.

    of_leg: from the torque of the leg.
    fit: estimates of the same trial.
    lowpass: cutoff (Hz) and order of the filter of ``of_leg``.
    at_rest: samples at rest.
    of_k: combined standard uncertainty of K; a smaller difference does not matter.
    of_difference: type B standard uncertainty of the difference of both K: what acts on one of them alone,
    such as a rod that bends; what both share cancels.
    Returns: its size is the difference over K.
    """
    expected = expected_of_leg(of_leg, fit, leg_markers, lowpass, at_rest)
    expected = expected + noise_bias(of_leg, expected, fit.fit, leg_markers, lowpass)
    each = of_leg.parameters[:, 2]
    scatter = float(each.std(ddof=1)) / np.sqrt(each.size) if each.size > 1 else np.inf
    error = float(np.linalg.norm([scatter, fit.interval().standard_error[2], of_difference]))
    difference = float(of_leg.mean[2] - expected[2])
    # Welch and Satterthwaite: only the scatter has few degrees of freedom
    share = scatter / error if np.isfinite(scatter) else 1.0
    freedom = max(1, each.size - 1) / share**4 if share > 0.0 else np.inf
    chance = 2.0 * float(scipy.stats.t.sf(abs(difference) / error, freedom))
    matters = of_k / abs(expected[2])
    return Check("leg-disagrees", abs(difference / expected[2]), chance, float(matters))


def expected_of_leg(
    of_leg: WindowedFits,
    fit: LikelihoodEstimates,
    leg_markers: SegmentMarkers,
    lowpass: tuple[float, int],
    at_rest: np.ndarray,
) -> np.ndarray:
    """Expected I, B, K of the windowed fit, from noise-free markers that move like the fitted joint.

    Takes the arguments of `leg_check`. Shape (3,), in N·m·s²/rad, N·m·s/rad and N·m/rad.
    """
    channels = fit.fit.channels
    theta = estimated_angle(fit.fit) + channels.theta_0_rad
    foot = estimated_foot(fit.fit)
    across, along = leg_markers.layout_m.T
    y = foot[:, None] + np.outer(np.cos(theta), across) + np.outer(np.sin(theta), along)
    z = np.outer(np.cos(theta), along) - np.outer(np.sin(theta), across)
    markers = butterworth_lowpass(np.stack([y, z], axis=2), channels.rate_hz, *lowpass)
    time = np.arange(theta.size) / channels.rate_hz
    motion = motion_of_markers(time, markers, leg_markers, fit.fit.model.leg.com_m)
    return regress_perturbations(motion, fit.fit.model.leg, of_leg.perturbations, at_rest, "leg").mean


def noise_bias(
    of_leg: WindowedFits,
    parameters: Annotated[np.ndarray, "(3,)"],
    fit: LikelihoodFit,
    leg_markers: SegmentMarkers,
    lowpass: tuple[float, int],
) -> Annotated[np.ndarray, "(3,)"]:
    """Bias of a windowed fit due to noise in its regressors (errors in variables), to first order.

    It is 0 for products of different perturbations. Otherwise noise of the angle enters theta'', theta',
    theta and the torque; noise of the markers' mean enters the torque alone. With A the regressors of a
    window of N samples and C the covariances of their noise,

        bias = (A'A)^-1 N (C_Atau - C_AA x)

    parameters: I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) without noise.
    fit: for the noise of the markers and the leg.
    lowpass: cutoff (Hz) and order of the filter.
    """
    if of_leg.crossed:
        return np.zeros(3)
    rate_hz, leg = fit.channels.rate_hz, fit.model.leg
    impulse = np.zeros(4096)
    impulse[2048] = 1.0
    gain = np.abs(np.fft.rfft(butterworth_lowpass(impulse, rate_hz, *lowpass))) ** 2
    omega = 2.0 * np.pi * np.fft.rfftfreq(impulse.size, 1.0 / rate_hz)
    along = leg_markers.layout_m[:, 1]
    of_angle = fit.channels.marker_noise_m**2 / np.sum((along - along.mean()) ** 2)
    zeroth, second, fourth = (of_angle * 2.0 * np.sum(gain * omega**k) / impulse.size for k in (0, 2, 4))
    p = leg.mass_kg * leg.com_m
    turned = leg.inertia_kgm2 + p * (leg.com_m - along.mean())
    covariance = np.array([[fourth, 0.0, -second], [0.0, second, 0.0], [-second, 0.0, zeroth]])
    with_torque = covariance @ [-turned, 0.0, p * leg.gravity_m_per_s2]
    shift = with_torque - covariance @ parameters
    biases = []
    for window in of_leg.perturbations:
        columns = of_leg.regressors[window.start : window.stop]
        scale = np.linalg.norm(columns, axis=0)
        normal = (columns / scale).T @ (columns / scale)
        biases.append(np.linalg.solve(normal, len(columns) * shift / scale) / scale)
    return np.mean(biases, axis=0)


NOISE_BIASED = "noise-biased"
# ratio of noise bias to combined standard uncertainty above which a windowed fit is flagged
LARGEST_BIAS = 0.5
OF_TORQUE = (
    "leg-disagrees",
    "foot-leg-delay",
    "joint-inertia",
    "camera-scale",
    "markers-slip",
    "markers-pulse-locked",
)
OF_ANGLE = (*OF_TORQUE, "foot-markers-apart", "lack-of-fit")


@dataclass(frozen=True)
class Verdict:
    """Outcome of the checks of one trial."""

    checks: list[Check]
    """All that could be made (sizes in their units)."""
    flags: dict[str, list[str]]
    """Pathway -> flags of its I, B, K."""
    quoted: str
    """The pathway to quote."""
    concerned: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Pathway -> checks that flag its I, B, K if they fail."""


def known_inertia(checks: dict) -> tuple[float, float] | None:
    """Inertia of the joint and its standard uncertainty (N·m·s²/rad) in a study; None if unknown."""
    known = checks["joint_inertia_Nms2_per_rad"]
    return None if known is None else (known, checks["joint_inertia_uncertainty_Nms2_per_rad"])


def check_dummy(
    trial: Trial,
    options: DummyOptions,
    analysis: DummyAnalysis,
    quoted: tuple[str, str],
    joint_inertia: tuple[float, float] | None = None,
) -> Verdict:
    """Check one trial.

    analysis: output of `analyse_dummy`.
    quoted: the pathway to quote, and the recommended one with windows.
    joint_inertia: the joint's own inertia and its standard uncertainty (N·m·s²/rad), if they are known.
    Returns: without a joint likelihood among the pathways there are no checks.
    """
    fits = {
        name: fit
        for name, fit in analysis.likelihood_estimates.items()
        if analysis.pathways[name].marker_instants == "aligned"
    }
    first, recommended = quoted
    if not fits:
        return Verdict([], {}, first)
    name, fit = next(iter(fits.items()))
    of_leg = analysis.regressions.get(recommended) if _windowed(analysis, recommended) else None
    own = analysis.quantities[name]
    relevant = [own["K"].standard_error, own["I_small"].u_type_b or 0.0]
    if of_leg is not None:
        relevant.append(analysis.budgets[recommended].minus(analysis.budgets[name]).type_b[2])
    checks = _checks(trial, options, fit, of_leg, relevant, joint_inertia, analysis.layout_scale)
    names = failed(checks)
    concerned = {
        name: OF_ANGLE if name in analysis.simulating_fits else OF_TORQUE
        for name, pathway in analysis.pathways.items()
        if (pathway.torque, pathway.marker_instants) == ("leg", "aligned")
    }
    flags = {name: [n for n in names if n in relevant] for name, relevant in concerned.items()}
    if of_leg is not None:
        if _biased(of_leg, fit, options, analysis, recommended):
            flags[recommended].append(NOISE_BIASED)
        if first in fits and "lack-of-fit" in names and not flags[recommended]:
            first = recommended
    return Verdict(checks, flags, first, concerned)


def flag_rows(rows: Sequence[Estimate], verdict: Verdict) -> list[Estimate]:
    """Rows of I, B, K, also of small movements, with the flags of their pathway; of a misfit all rows."""
    out = []
    for row in rows:
        flags = verdict.flags.get(row.pathway, ())
        others = [name for name in flags if name == LACK_OF_FIT]
        out += flagged([row], *(flags if row.quantity in (*PARAMETERS, *SMALL) else others))
    return out


def check_facts(verdict: Verdict) -> dict[str, dict]:
    """Facts of a fit: ``checks``, their numbers, and ``concerned``, pathway -> checks that flag it."""
    numbers = {
        c.name: {"size": float(c.size), "probability": float(c.probability), "tolerance": float(c.tolerance)}
        for c in verdict.checks
    }
    return {"checks": numbers, "concerned": {name: list(n) for name, n in verdict.concerned.items()}}


def _windowed(analysis: DummyAnalysis, name: str) -> bool:
    """Test for a pathway that fits the consistent torque of aligned markers in windows."""
    pathway = analysis.pathways.get(name)
    wanted = ("leg", "aligned", LEAST_SQUARES)
    return pathway is not None and (pathway.torque, pathway.marker_instants, pathway.estimator) == wanted


def _checks(
    trial: Trial,
    options: DummyOptions,
    fit: LikelihoodEstimates,
    of_leg,
    uncertainties: Sequence[float],
    joint_inertia: tuple[float, float] | None,
    layout_scale: float,
) -> list[Check]:
    markers, perturbations = trial_markers(trial, options, "aligned"), fit.perturbations
    lowpass = (options.lowpass_cutoff_hz, options.lowpass_order)
    labels, sampling = trial.axes["marker"].tolist(), options.sources.get("marker_sampling_s")
    places = _order(labels, options.leg_markers.labels) - _order(labels, options.belt_fixed_labels)
    later = 0.0 if sampling is None else sampling.standard_uncertainty * places
    foot = markers.positions[:, markers.on_foot & ~markers.on_leg]
    checks = of_likelihood(fit, foot, perturbations, trial.rate_hz, layout_scale, later)
    if of_leg is not None:
        at_rest = rest_samples(trial.time, options.window)
        of_k = uncertainties[0::2]
        checks.append(leg_check(of_leg, fit, options.leg_markers, lowpass, at_rest, *of_k))
    if joint_inertia is not None:
        checks.append(inertia_check(fit, *joint_inertia, uncertainties[1]))
    return checks


def _order(labels: list[str], wanted: Sequence[str]) -> float:
    """Mean position in the order of sampling."""
    return float(np.mean([labels.index(label) for label in wanted]))


def _biased(of_leg, fit, options: DummyOptions, analysis: DummyAnalysis, name: str) -> bool:
    """Test for a noise bias of K or B that exceeds `LARGEST_BIAS` of its combined uncertainty."""
    lowpass = (options.lowpass_cutoff_hz, options.lowpass_order)
    at_rest = rest_samples(analysis.time, options.window)
    expected = expected_of_leg(of_leg, fit, options.leg_markers, lowpass, at_rest)
    bias = noise_bias(of_leg, expected, fit.fit, options.leg_markers, lowpass)
    return bool((np.abs(bias) > LARGEST_BIAS * analysis.budgets[name].combined)[1:].any())


def quoted_rows(rows: Sequence[Estimate], verdict: Verdict) -> list[Estimate]:
    """Mark the I, B, K rows of the quoted pathway as recommended."""
    return [
        replace(row, recommended=row.quantity in PARAMETERS and row.pathway == verdict.quoted) for row in rows
    ]
