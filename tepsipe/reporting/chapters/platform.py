"""Chapter on a person on a moving platform: coherence, slow mode, and a condition of its sentences."""

from tepsipe.io.result import Result
from tepsipe.reporting.run import Run


def numbers(run: Run) -> dict:
    """Share of bands coherent with the platform (%), and proportion of slow rotations, by trial."""
    return {condition: _trial(fit) for condition, fit in run.fits["platform"].items()}


def _trial(fit: Result) -> dict:
    significant = fit.arrays["coherence"] > fit.facts["coherence_threshold"]
    return {"significant_percent": 100.0 * significant.mean(axis=0), "mode": fit.arrays["mode"]}


# ---- conditions of sentences


def one_perturbation(run: Run) -> bool:
    """The platform was the only perturbation of every trial."""
    return all(fit.facts["perturbations"] == 1 for fit in run.fits["platform"].values())


PREDICATES = (one_perturbation,)
