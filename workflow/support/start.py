"""All checks of a study before its first job, for Snakemake and for ``tepsipe check``."""

import os
import re
from collections.abc import Iterable
from pathlib import Path

from tepsipe.errors import InputError
from tepsipe.virtual_lab.drawn import draw_laboratory, drawn_numbers
from workflow.settings.check import check_content
from workflow.settings.config import check_config
from workflow.settings.reported import Reported
from workflow.settings.virtual_lab import VirtualLab
from workflow.support.check import (
    check_calibration,
    check_one_treadmill,
    check_plate_models,
    check_recordings,
    check_standing_cutoffs,
)
from workflow.support.folders import check_folders, check_path, check_paths
from workflow.support.laboratories import Laboratories, constants_of, one_of_each_set
from workflow.support.people import read_participants
from workflow.support.placeholders import placeholders, refuse_placeholders
from workflow.support.study import Study
from workflow.support.trial_sheet import check_sources, read_trial_sheet
from workflow.support.walking import check_walking_trials
from workflow.support.yaml_file import override, read_constants, read_settings

ROOT = Path(__file__).parents[2]
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
    own = [str(path) for path in configfiles if placeholders(read_settings(path))]
    refuse_placeholders(config, " and ".join(own) or name)
    check_config(config, name)
    check_paths(config, name)
    study = config["study"]
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
    named = None
    keys = re.findall(r"[a-z_]+(?:\.[\w-]+)+", text)
    for key in keys + re.findall(r"(?:unknown key|the key|for) '([^']+)'", text):
        while "." in key and _value(config, key) is ABSENT:  # a key that lacks is missed in its section
            key = key.rpartition(".")[0]
        wanted = _value(config, key)
        for path in reversed(list(configfiles)):
            # by their text: not a number is not equal to itself
            if wanted is not ABSENT and repr(_value(read_settings(path), key)) == repr(wanted):
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
