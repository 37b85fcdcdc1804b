"""Fit of one trial of the ankle dummy, by the torque of the foot and the force plate."""

from collections.abc import Sequence

from tepsipe.experiments.dummy.foot_pathways import FootOptions, analyse_foot, windows_from_onset
from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.dummy.options import FootPathway
from tepsipe.experiments.dummy.results import fitted_dummy
from tepsipe.experiments.fitted import Fitted
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.treadmill.held_out import read_held_out
from tepsipe.treadmill.plate_check import PlateCheck
from tepsipe.treadmill.prepared import PreparedTrial, prepare_trial
from tepsipe.treadmill.registry import FittedModel


def begin(trial: Trial, section: dict, name: str) -> PreparedTrial:
    """Perturbations and rest of a trial in which the windows of all pathways have room."""
    options = DummyOptions.from_settings(section["geometry"], section["analysis"])
    prepared = prepare_trial(trial, name, options.lowpass, options.window)
    for pathway in section["foot"]["pathways"].values():
        windows_from_onset(prepared, pathway["window_s"])
    return prepared


def fit(
    trial: Trial,
    section: dict,
    condition: str,
    seed: int,
    uncertainty: dict,
    models: Sequence[dict[str, FittedModel]],
    calibrations: Sequence[Result],
) -> Fitted:
    """I, B, K by every pathway with the force plate.

    uncertainty: sources, as `sources_of` takes them.
    models: name -> treadmill model, of Fy and of Mx.
    calibrations: check of the plate, and residuals of trials that the models have not seen, alone in a list.
    """
    (calibration,) = calibrations
    geometry, foot, belt = section["geometry"], section["foot"], section["belt"]
    found = analyse_foot(
        PlateCheck.from_result(calibration).corrected(trial, belt),
        f"dummy/{condition}",
        DummyOptions.from_settings(geometry, section["analysis"], (), uncertainty),
        FootOptions.from_settings(geometry, foot, belt, read_held_out(calibration)),
        {name: FootPathway(**pathway) for name, pathway in foot["pathways"].items()},
        dict(zip(("Fy", "Mx"), models, strict=True)),
    )
    return fitted_dummy(condition, found, section["analysis"]["bootstrap_draws"], seed)
