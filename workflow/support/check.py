"""Checks of a configuration against the trials of its study; each raises one sentence."""

from tepsipe.errors import InputError, listed
from workflow.settings.complete import ON_THE_PLATE
from workflow.support.people import BELTS
from workflow.support.trial_sheet import TrialRow


def check_one_treadmill(config: dict, experiments, name: str, by_belt: bool = False) -> None:
    """Models of the treadmill hold for one belt, rate and filter; exceptions are refused with the weight.

    If the trial sheet names belts, each has models of its own (``by_belt``).
    """
    shared = config["plate_treadmill"]
    for experiment, own in shared["exceptions"].items():
        if not {experiment, "weight"} <= set(experiments):
            continue
        for key, value in own.items():
            if key != "recording" and value != shared[key] and not (by_belt and key == "belt"):
                column = ", or name the belt of every trial in the trial sheet" if key == "belt" else ""
                raise InputError(
                    f"{name}: expected plate_treadmill.{key} ({shared[key]}) for {experiment}, too, because "
                    "models of the treadmill, fitted to trials of weight and empty, hold for one belt, rate "
                    f"and filter, found {value} in plate_treadmill.exceptions.{experiment}: take "
                    f"it out{column}"
                )


def check_recordings(settings: dict, trials: dict[tuple, TrialRow], name: str) -> None:
    """Trials that are one file need to know the plates of the belt, and where its velocity is."""
    whole = {
        experiment
        for (experiment, _), row in trials.items()
        if experiment in ON_THE_PLATE and row.source == "recorded" and "calibration" not in row.files
    }
    for experiment in sorted(whole):
        section, here = settings[experiment]["recording"], f"{name}: expected plate_treadmill.recording"
        belts = {belt: section["plates"][belt] for belt in ("left", "right")}
        both = sorted(set(belts["left"]) & set(belts["right"]))
        if both:
            raise InputError(
                f"{here}.plates to give every force plate to one belt, found {both[0]} for both: correct "
                "one of the two"
            )
        belt = settings[experiment].get("belt", settings["plate_treadmill"]["belt"])
        for own in BELTS if belt == "both" else (belt,):
            if not belts[own] and not section["load_cells"][own]:
                raise InputError(
                    f"{here}.plates to number a force plate of the {own} belt, which is perturbed in the "
                    f"trials of {experiment}, found none: add its number, or correct plate_treadmill.belt"
                )
        if section["axes"]["forward"][1] == section["axes"]["up"][1]:
            raise InputError(
                f"{here}.axes to be two different axes, found {section['axes']['forward']!r} and "
                f"{section['axes']['up']!r}: correct one of the two"
            )
        velocity = section["belt_velocity"]
        if velocity["channel"] is None and not velocity["markers"]:
            raise InputError(
                f"{here}.belt_velocity to name a channel or belt-fixed markers for the trials of "
                f"{experiment}, found none of both: name one of them"
            )


def check_calibration(study, path: str) -> None:
    """Models of the treadmill need the usual weight in both roles, and the empty belt in its conditions.

    Raises
    ------
    InputError
        If trials are missing that a model of ``weight.models.family`` needs, belt by belt.
    """
    treadmill, usual = study.treadmill, study.treadmill.usual_weight()
    for belt in treadmill.belts():
        rows = [row for row in treadmill.plate_trials(belt) if row[0] == "empty" or row[1] in usual]
        roles = {(e, c): role for e, c, role in rows}
        on = f" on the {belt} belt" if study.by_belt else ""
        for role in ("calibrate", "validate"):
            if not any(e == "weight" and own == role for (e, _), own in roles.items()):
                raise InputError(
                    f"{path}: expected a trial with the usual weight{on} (weight.weight.mass_kg) and the "
                    f"role {role}, found none: set the role of one of its rows, or make the weight with "
                    "trials of both roles the usual one"
                )
        if "mean-subtraction" not in study.config["weight"]["models"]["family"]:
            continue
        for (experiment, condition), role in roles.items():
            if experiment == "weight" and role == "validate" and ("empty", condition) not in roles:
                found = [c for e, c in roles if e == "empty"]
                raise InputError(
                    f"{path}: expected a trial of the empty belt{on} with the condition of "
                    f"weight/{condition}, whose mean the model mean-subtraction subtracts, found "
                    f"{listed(found)}: give both the same name if the belt moved alike, or take "
                    "mean-subtraction out of weight.models.family"
                )


def check_standing_cutoffs(settings: dict, name: str) -> None:
    """Cutoffs of a standing person's signals must lie below half of their rate."""
    section = settings["standing"]
    half = 0.5 * section["ingest"]["resample_rate_hz"]
    for key, cutoff in (
        ("standing.analysis.stretch_cutoff_hz", section["analysis"]["stretch_cutoff_hz"]),
        ("standing.free_reflex.lowpass_cutoff_hz", section["free_reflex"]["lowpass_cutoff_hz"]),
    ):
        if cutoff >= half:
            raise InputError(
                f"{name}: expected {key} below half of plate_treadmill.resample_rate_hz ({half:g} Hz), found "
                f"{cutoff:g}: set it in the configuration of the study, for example to {0.8 * half:g}"
            )


def check_plate_models(config: dict, name: str) -> None:
    """Without weight and empty belt there are no models for the pathways of a standing person."""
    for pathway, choice in config["standing"]["pathways"].items():
        if choice["treadmill_model"] is not None:
            raise InputError(
                f"{name}: expected trials of weight and empty beside those of standing, because "
                f"standing.pathways.{pathway} takes the model {choice['treadmill_model']!r} of the "
                "treadmill, found none: add their rows to the trial sheet, or set its treadmill_model to null"
            )
