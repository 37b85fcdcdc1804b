"""Fit of one trial with a weight, or with the empty belt."""

from tepsipe.experiments.fitted import Fitted
from tepsipe.experiments.weight.analysis import analyse_weight, fitted_weight
from tepsipe.io.trial import Trial
from tepsipe.statistics.uncertainty import sources_of
from tepsipe.treadmill.options import Weight
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.trial_recordings import PlateOptions, marker_lag, plate_filters, plate_recordings


def begin(trial: Trial, section: dict, name: str) -> BeltRecording:
    """Fore-aft force of a trial behind the first filter (N)."""
    return _recording(trial, section, name, next(iter(_options(section).values())))


def fit(trial: Trial, section: dict, condition: str, uncertainty: dict) -> Fitted:
    """Mass of the weight, and belt-induced force; without a ``weight`` in the section, of the empty belt.

    uncertainty: sources, as `sources_of` takes them.
    """
    experiment = "empty" if section["weight"] is None else "weight"
    name, choices = f"{experiment}/{condition}", _options(section)
    recordings = {label: _recording(trial, section, name, options) for label, options in choices.items()}
    lag = None if section["weight"] is None else marker_lag(trial, name, choices["belt"])
    return fitted_weight(experiment, condition, analyse_weight(recordings, sources_of(uncertainty), lag))


def _recording(trial: Trial, section: dict, name: str, options: PlateOptions) -> BeltRecording:
    weight = None if section["weight"] is None else Weight(**section["weight"])
    return plate_recordings(trial, name, name.partition("/")[2], options, weight)["Fy"]


def _options(section: dict) -> dict[str, PlateOptions]:
    """Label of a recording -> its options: each filter; of a weight, also one that moves with the belt."""
    belt, analysis = section["belt"], section["analysis"]
    filters = plate_filters(analysis)
    options = {
        f"{lowpass.cutoff_hz:g} Hz": PlateOptions.from_settings(belt, analysis, lowpass, "markers")
        for lowpass in filters
    }
    if section["weight"] is not None:
        # the same force, with the inertia of a weight that moves exactly with the belt
        options["belt"] = PlateOptions.from_settings(belt, analysis, filters[0], "belt")
    return options
