"""Fit of one trial of a person on a moving platform."""

from tepsipe.experiments.fitted import Fitted, checked
from tepsipe.experiments.platform.analysis import (
    analyse_platform,
    platform_estimates,
    platform_result,
    platform_spectra,
)
from tepsipe.experiments.platform.options import PlatformOptions
from tepsipe.identification.several_joints.closed_loop import Spectra
from tepsipe.io.trial import Trial


def begin(trial: Trial, section: dict, name: str) -> tuple[Spectra, Spectra, Spectra]:
    """Banded spectra of the trial and of its two parts, with which `analyse_platform` begins (rad, N·m)."""
    return platform_spectra(trial, PlatformOptions(**section["analysis"]))


def fit(trial: Trial, section: dict, condition: str) -> Fitted:
    """Impedance of ankle and hip by every model."""
    options = PlatformOptions(**section["analysis"])
    found = analyse_platform(trial, options)
    return Fitted(
        platform_result(found, options, trial.signals["platform"].unit),
        checked(trial, platform_estimates("platform", condition, found, options)),
    )
