"""Chapter on a person on a moving platform: coherence and slow mode."""

from tepsipe.io.result import Result
from tepsipe.reporting.run import Run


def numbers(run: Run) -> dict:
    """Share of bands coherent with the platform (%), and proportion of slow rotations, by trial."""
    return {condition: _trial(fit) for condition, fit in run.fits["platform"].items()}


def _trial(fit: Result) -> dict:
    significant = fit.arrays["coherence"] > fit.facts["coherence_threshold"]
    return {"significant_percent": 100.0 * significant.mean(axis=0), "mode": fit.arrays["mode"]}
