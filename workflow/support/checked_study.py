"""All checks of a study before its first job, for Snakemake and for ``tepsipe check``."""

import os
import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from tepsipe.errors import InputError, listed
from tepsipe.virtual_lab.drawn_laboratories import draw_laboratory, drawn_numbers
from workflow.settings.check import check_content
from workflow.settings.complete import ON_THE_PLATE
from workflow.settings.config import check_config
from workflow.settings.reported import Reported
from workflow.settings.virtual_lab import VirtualLab
from workflow.support.folders import check_folders, check_path, check_paths
from workflow.support.laboratories import Laboratories, constants_of, one_of_each_set
from workflow.support.people import BELTS, read_participants
from workflow.support.placeholders import placeholders, refuse_placeholders
from workflow.support.places import ROOT
from workflow.support.study import Study
from workflow.support.trial_sheet import TrialRow, check_sources, read_trial_sheet
from workflow.support.yaml_file import override, read_constants, read_settings

NAME = "configuration"  # where messages begin, until their file is known
ABSENT = object()  # of a key that a configuration does not have


def shipped() -> str:
    """Path of the shipped configuration, as seen from this folder."""
    return os.path.relpath(ROOT / "config/config.yaml")


def merged_settings(configfiles: Iterable[str | Path]) -> dict:
    """Read configuration files; later ones override earlier ones key by key, as Snakemake does it."""
    config: dict = {}
    for path in configfiles:
        override(config, read_settings(path))
    return config


def checked_study(config: dict, configfiles: Iterable[str | Path], name: str = NAME) -> Study:
    """Check the configuration, read the trial sheet, and check the folders that the study writes to."""
    if placeholders(config):
        own = [str(path) for path in configfiles if placeholders(read_settings(path))]
        refuse_placeholders(config, " and ".join(own) or name)
    check_config(config, name)
    check_paths(config, name)
    study = config["study"]
    _own_title(study)
    trials = read_trial_sheet(study["trial_sheet"], study["recordings_folder"])
    check_sources(trials, study["trial_sheet"], study["virtual_lab"])
    check_walking_trials(config, trials, study["trial_sheet"])
    recordings = sorted({path for row in trials.values() for path in row.files.values()})
    for recording in recordings:
        check_path(study["trial_sheet"], recording, "a recording")
    check_folders(config, configfiles, recordings, ROOT, name)
    people = None if study["participants"] is None else read_participants(study["participants"])
    found = Study(config, trials, people)
    found.check(study["trial_sheet"])
    check_one_treadmill(config, found.experiments, name, found.by_belt)
    for trial, row in trials.items():
        check_recordings(found.settings_of(*trial), {trial: row}, name)
    if found.has("weight"):
        check_calibration(found, study["trial_sheet"])
    if found.has("standing"):
        check_standing_cutoffs(found.settings, name)
    if found.has("standing") and not found.has("weight"):
        check_plate_models(config, name)
    if config["coverage"] is not None:
        _check_laboratories(config, found, name)
    return found


def _own_title(study: dict) -> None:
    """Name a study of other recordings by its trial sheet, if it still has the shipped study's title."""
    if study["reported"] is None and study["title"] == read_settings(shipped())["study"]["title"]:
        study["title"] = f"Study of {study['trial_sheet']}"


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


def check_walking_trials(config: dict, trials: dict[tuple, TrialRow], path: str) -> None:
    """A study of walking has the section walking, trials of walking only, and pulses for simulated ones."""
    walking, rows = config["walking"], {c: row for (e, c), row in trials.items() if e == "walking"}
    if not rows and walking is None:
        return
    others = [f"{e}/{c}" for e, c in trials if e != "walking"]
    if walking is None:
        raise InputError(
            f"{path}: expected the section walking in the configuration for trials of walking, found null: "
            "copy config/walking/config.yaml"
        )
    if others or not rows:
        raise InputError(
            f"{path}: expected trials of walking only, because a study of walking has a report of its own, "
            f"found {others[0] if others else 'none of walking'}: give the other trials a study of their own"
        )
    made = [c for c, row in rows.items() if row.source == "virtual_lab"]
    simulated = walking["simulated"] or {"of": None, "trials": {}}
    for condition in made:
        if condition not in simulated["trials"]:
            raise InputError(
                f"{path}: expected the pulses of walking/{condition} in walking.simulated.trials, found "
                f"{listed(simulated['trials'])}: add it"
            )
    recorded = [c for c, row in rows.items() if row.source == "recorded"]
    if made and simulated["of"] not in recorded:
        raise InputError(
            f"{path}: expected walking.simulated.of to be a recorded trial whose strides are resampled "
            f"({listed(recorded)}), found {simulated['of']!r}: correct it"
        )


def _check_laboratories(config: dict, study: Study, name: str) -> None:
    """A coverage study makes all of its trials, and every set can be drawn."""
    path, recorded = config["study"]["virtual_lab"], [t for e in study.experiments for t in study.recorded(e)]
    if path is None or recorded:
        found = "study.virtual_lab null" if path is None else f"the recorded trial {recorded[0]}"
        raise InputError(
            f"{name}: expected a coverage study of simulated trials, whose truth is known, found {found}: "
            "correct it, or set coverage to null"
        )
    if config["study"]["participants"] is not None:
        raise InputError(
            f"{name}: expected a coverage study without participants, found study.participants "
            f"{config['study']['participants']}: set it to null"
        )
    check_config(Laboratories(config).own_config, name)  # without what coverage.left_out names
    constants = checked_constants(path)
    for number in one_of_each_set(config["coverage"]):
        _drawn(constants_of(constants, config["coverage"], number), path)


def checked_constants(path: str) -> dict:
    """Constants of a file of the virtual laboratory, before drawing."""
    content = read_constants(path)
    check_content(content, VirtualLab, path)
    return content


def checked_sections(config: dict, key: str) -> dict | None:
    """Contents of the file that study.<key> names, checked; None where it names none.

    Of the virtual laboratory, the constants after drawing; ``drawn_numbers`` says what was drawn.
    """
    path = config["study"][key]
    if path is None:
        return None
    if key == "virtual_lab":
        return _drawn(checked_constants(path), path)
    content = read_settings(path)
    check_content(content, Reported, path)
    return content


def _drawn(content: dict, path: str) -> dict:
    """The constants of the laboratory after drawing, within the same limits."""
    try:
        drawn, numbers = draw_laboratory(content), drawn_numbers(content)
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None
    check_content(drawn, VirtualLab, f"{path}, after drawing")
    return drawn | {"drawn_numbers": [vars(number) for number in numbers]}


def with_its_file(error: InputError, config: dict, configfiles: Iterable[str | Path]) -> str:
    """The message, with a file that holds a key it names instead of 'configuration': rather the user's."""
    text = str(error)
    if not text.startswith(f"{NAME}: "):
        return text
    named, content_of = None, cache(read_settings)
    keys = re.findall(r"[a-z_]+(?:\.[\w-]+)+", text)
    for key in keys + re.findall(r"(?:unknown key|the key|for) '([^']+)'", text):
        while "." in key and _value(config, key) is ABSENT:  # a key that lacks is missed in its section
            key = key.rpartition(".")[0]
        wanted = _value(config, key)
        for path in reversed(list(configfiles)):
            # by their text: not a number is not equal to itself
            if wanted is not ABSENT and repr(_value(content_of(path), key)) == repr(wanted):
                named = named or path
                if str(path) != shipped():
                    return f"{path}{text.removeprefix(NAME)}"
                break
    return text if named is None else f"{named}{text.removeprefix(NAME)}"


def _value(config: object, key: str) -> object:
    for name in key.split("."):
        if isinstance(config, list) and name.isdecimal() and int(name) < len(config):
            config = config[int(name)]
        elif isinstance(config, dict) and name in config:
            config = config[name]
        else:
            return ABSENT
    return config
