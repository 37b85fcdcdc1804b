"""From the checks of a dummy trial to its rows: flags, and the pathway to quote.

Which check concerns which pathway:

    a windowed fit of the consistent torque    leg-disagrees, foot-leg-delay, joint-inertia, markers-slip,
                                               markers-pulse-locked; noise-biased
    output error and joint likelihood          the same but noise-biased; foot-markers-apart, lack-of-fit

The pathway of the configuration is quoted. If it is a joint likelihood whose model does not fit the trial
(lack-of-fit), while the recommended windowed fit passes its own checks, that is quoted.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tepsipe.experiments.dummy.checks import (
    Check,
    delay_check,
    expected_of_leg,
    failed,
    fit_check,
    foot_check,
    inertia_check,
    leg_check,
    noise_bias,
    residual_checks,
)
from tepsipe.experiments.dummy.leg_pathways import DummyAnalysis, DummyOptions, markers_of
from tepsipe.identification.estimators import LEAST_SQUARES
from tepsipe.identification.joint_result import JointLikelihood
from tepsipe.io.estimates import Estimate, flagged
from tepsipe.io.trial import Trial
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.signals.perturbations import rest_samples

NOISE_BIASED = "noise-biased"
# bias by noise over the combined standard uncertainty, from which a windowed fit is flagged (-)
LARGEST_BIAS = 0.5
OF_TORQUE = ("leg-disagrees", "foot-leg-delay", "joint-inertia", "markers-slip", "markers-pulse-locked")
OF_ANGLE = (*OF_TORQUE, "foot-markers-apart", "lack-of-fit")


@dataclass(frozen=True)
class Verdict:
    """What the checks of one trial say.

    Attributes
    ----------
    checks : list of Check
        All that could be made (sizes in their units).
    flags : dict of str to list of str
        Pathway -> flags of its I, B, K.
    quoted : str
        The pathway to quote.
    """

    checks: list[Check]
    flags: dict[str, list[str]]
    quoted: str


def check_dummy(
    trial: Trial,
    options: DummyOptions,
    analysis: DummyAnalysis,
    quoted: tuple[str, str],
    joint_inertia: tuple[float, float] | None = None,
) -> Verdict:
    """Check one trial.

    Parameters
    ----------
    trial : Trial
        Markers (m).
    options : DummyOptions
        Those of the analysis (units in their names).
    analysis : DummyAnalysis
        Output of `analyse_dummy`.
    quoted : tuple of (str, str)
        The pathway to quote, and the recommended one with windows.
    joint_inertia : tuple of (float, float), optional
        The joint's own inertia and its standard uncertainty (N·m·s²/rad), if they are known.

    Returns
    -------
    Verdict
        Without a joint likelihood among the pathways there are no checks.
    """
    fits = {
        name: found
        for name, found in analysis.joint_likelihoods.items()
        if analysis.pathways[name].marker_instants == "aligned"
    }
    first, recommended = quoted
    if not fits:
        return Verdict([], {}, first)
    name, found = next(iter(fits.items()))
    of_leg = analysis.regressions.get(recommended) if _windowed(analysis, recommended) else None
    own = [analysis.budgets[name].combined[2], analysis.small_budgets[name].type_b[0]]
    if of_leg is not None:
        own.append(analysis.budgets[recommended].minus(analysis.budgets[name]).type_b[2])
    checks = _checks(trial, options, found, of_leg, own, joint_inertia)
    names = failed(checks)
    flags = {}
    for name, pathway in analysis.pathways.items():
        if pathway.torque != "leg" or pathway.marker_instants != "aligned":
            continue
        own = OF_ANGLE if name in analysis.output_errors else OF_TORQUE
        flags[name] = [n for n in names if n in own]
    if of_leg is not None:
        if _biased(of_leg, found, options, analysis, recommended):
            flags[recommended].append(NOISE_BIASED)
        if first in fits and "lack-of-fit" in names and not flags[recommended]:
            first = recommended
    return Verdict(checks, flags, first)


def flag_rows(rows: Sequence[Estimate], verdict: Verdict) -> list[Estimate]:
    """Rows of I, B, K, also of small movements, with the flags of their pathway (units in them)."""
    joint = {*PARAMETERS, *(f"{quantity}_small" for quantity in PARAMETERS)}
    return [
        flagged([row], *verdict.flags.get(row.pathway, ()))[0] if row.quantity in joint else row
        for row in rows
    ]


def check_facts(verdict: Verdict) -> dict[str, dict[str, float]]:
    """Check -> size (its unit) and probability (-), as plain numbers."""
    return {c.name: {"size": float(c.size), "probability": float(c.probability)} for c in verdict.checks}


def _windowed(analysis: DummyAnalysis, name: str) -> bool:
    """Whether a pathway fits the consistent torque of aligned markers in windows."""
    pathway = analysis.pathways.get(name)
    wanted = ("leg", "aligned", LEAST_SQUARES)
    return pathway is not None and (pathway.torque, pathway.marker_instants, pathway.estimator) == wanted


def _checks(
    trial: Trial,
    options: DummyOptions,
    found: JointLikelihood,
    of_leg,
    uncertainties: Sequence[float],
    joint_inertia: tuple[float, float] | None,
) -> list[Check]:
    markers, perturbations = markers_of(trial, options, "aligned"), found.perturbations
    lowpass = (options.lowpass_cutoff_hz, options.lowpass_order)
    labels, sampling = trial.axes["marker"].tolist(), options.sources.get("marker_sampling_s")
    apart = _order(labels, options.leg_markers.labels) - _order(labels, options.belt_fixed_labels)
    later = 0.0 if sampling is None else sampling.standard_uncertainty * apart
    foot = markers.positions[:, markers.on_foot & ~markers.on_leg]
    checks = [delay_check(found, later), *residual_checks(found.fit, perturbations)]
    checks += [fit_check(found.fit, perturbations), foot_check(foot, perturbations, trial.rate_hz)]
    if of_leg is not None:
        at_rest = rest_samples(trial.time, options.window)
        of_k = uncertainties[0::2]
        checks.append(leg_check(of_leg, found, options.leg_markers, lowpass, at_rest, *of_k))
    if joint_inertia is not None:
        checks.append(inertia_check(found, *joint_inertia, uncertainties[1]))
    return [check for check in checks if check is not None]


def _order(labels: list[str], wanted: Sequence[str]) -> float:
    """Mean place in the order of sampling."""
    return float(np.mean([labels.index(label) for label in wanted]))


def _biased(of_leg, found, options: DummyOptions, analysis: DummyAnalysis, name: str) -> bool:
    """Whether noise moves K or B of a windowed fit by a good part of its combined uncertainty."""
    lowpass = (options.lowpass_cutoff_hz, options.lowpass_order)
    at_rest = rest_samples(analysis.time, options.window)
    expected = expected_of_leg(of_leg, found, options.leg_markers, lowpass, at_rest)
    bias = noise_bias(of_leg, expected, found.fit, options.leg_markers, lowpass)
    return bool((np.abs(bias) > LARGEST_BIAS * analysis.budgets[name].combined)[1:].any())


def quoted_rows(rows: Sequence[Estimate], verdict: Verdict) -> list[Estimate]:
    """Rows with those of I, B, K of the quoted pathway marked as recommended (units in them)."""
    return [
        replace(row, recommended=row.quantity in PARAMETERS and row.pathway == verdict.quoted) for row in rows
    ]
