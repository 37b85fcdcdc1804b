"""Report on walking: conditions of the sentences on each trial."""

import pandas as pd

from tepsipe.reporting.run import Run

SLOWEST_OF_A_PULSE_HZ = 15.0


def numbers(run: Run) -> dict:
    """Trial -> its conditions."""
    return {name: _conditions(run, name) for name in run.fits["walking"]}


def _conditions(run: Run, trial: str) -> dict[str, bool]:
    conditions = (moment_shows_pulses, control_without_pulses)
    return {condition.__name__: condition(run, trial) for condition in conditions}


def moment_shows_pulses(run: Run, trial: str) -> bool:
    """The supplied moment of the ankle has the bandwidth of a pulse."""
    bandwidth = run.fits["walking"][trial].facts["bandwidth_hz"]
    return bandwidth is not None and bandwidth >= SLOWEST_OF_A_PULSE_HZ


def control_without_pulses(run: Run, trial: str) -> bool:
    """The belt made no pulses, and the angle responds at no phase."""
    return not run.fits["walking"][trial].facts["pulses"] and bool(_silent(run, trial).all())


def _silent(run: Run, trial: str) -> pd.Series:
    return run.rows("walking", condition=trial, quantity="K")["flags"] == "no-response"
