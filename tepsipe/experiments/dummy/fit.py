"""Fit of one trial of the ankle dummy, by the torque of the leg's equation of motion."""

from dataclasses import replace

from tepsipe.experiments.dummy.checks import check_dummy, check_facts, flag_rows, known_inertia, quoted_rows
from tepsipe.experiments.dummy.leg_pathways import DummyOptions, analyse_dummy, leg_motion, prepare_dummy
from tepsipe.experiments.dummy.options import Pathway
from tepsipe.experiments.dummy.results import fitted_dummy
from tepsipe.experiments.fitted import Fitted
from tepsipe.io.trial import Trial
from tepsipe.treadmill.prepared import PreparedTrial


def _options(section: dict, uncertainty: dict | None = None) -> DummyOptions:
    labels = section["foot"]["belt_fixed_labels"]
    return DummyOptions.from_settings(section["geometry"], section["analysis"], labels, uncertainty)


def begin(trial: Trial, section: dict, name: str) -> PreparedTrial:
    """Perturbations and rest of a trial whose leg's motion can be computed."""
    options = _options(section)
    prepared, _ = prepare_dummy(trial, options, name)
    leg_motion(prepared, options, "aligned")
    return prepared


def fit(trial: Trial, section: dict, condition: str, seed: int, uncertainty: dict) -> Fitted:
    """I, B, K by every pathway, with the checks of the trial.

    uncertainty: sources, as `sources_of` takes them.
    """
    options = _options(section, uncertainty)
    pathways = {name: Pathway(**choice) for name, choice in section["pathways"].items()}
    found = analyse_dummy(trial, options, pathways)
    verdict = check_dummy(
        trial, options, found, (section["quoted"], section["recommended"]), known_inertia(section["checks"])
    )
    fitted = fitted_dummy(condition, found, section["analysis"]["bootstrap_draws"], seed)
    fitted.result.facts.update(check_facts(verdict))
    return replace(fitted, estimates=quoted_rows(flag_rows(fitted.estimates, verdict), verdict))
