"""Recordings of a study, read and compared with its settings as the jobs of a run do it."""

import hashlib
from pathlib import Path

from tepsipe.arguments import options_of
from tepsipe.errors import InputError
from tepsipe.experiments.belt.fit import begin as begin_belt
from tepsipe.experiments.dummy.fit import begin as begin_dummy
from tepsipe.experiments.dummy.fit_foot import begin as begin_foot
from tepsipe.experiments.platform.fit import begin as begin_platform
from tepsipe.experiments.position_manipulator.fit import begin as begin_position_manipulator
from tepsipe.experiments.standing.fit import begin as begin_standing
from tepsipe.experiments.walking.fit import begin as begin_walking
from tepsipe.experiments.walking.trial import read_trial
from tepsipe.experiments.weight.calibrate import PlateTrial
from tepsipe.experiments.wristalyzer.fit import begin as begin_wristalyzer
from tepsipe.ingest.belt_table import BeltTableOptions, ingest_belt_table
from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.manipulators import (
    ManipulatorOptions,
    TableOptions,
    ingest_position_manipulator,
    ingest_torque_manipulator,
)
from tepsipe.ingest.plate_treadmill import TreadmillOptions, ingest_treadmill_files
from tepsipe.ingest.platform import PlatformTableOptions, ingest_platform
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.ingest.standing import ingest_standing_files
from tepsipe.ingest.whole_trial import RecordingOptions, ingest_recording_files
from tepsipe.io.readers.plain_table import DELIMITERS
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.trial import Trial
from tepsipe.treadmill.calibration import group_of, plate_groups
from tepsipe.treadmill.plate_check import Resting, check_plate
from tepsipe.treadmill.recording import BeltRecording, check_recordings
from tepsipe.treadmill.trial_recordings import Weight, plate_filters
from workflow.settings.complete import without
from workflow.support.rigs import RIG_KEYS, rig_of
from workflow.support.study import Study

ON_PLATE = ("dummy", "weight", "empty", "standing")
BEGINS = {
    "dummy": begin_dummy,
    "standing": begin_standing,
    "wristalyzer": begin_wristalyzer,
    "position_manipulator": begin_position_manipulator,
    "platform": begin_platform,
}


def refused_recordings(study: Study) -> list[str]:
    """Read all recorded trials; one sentence for every one that would stop its job, or the calibration."""
    refused, of_plates, of_belts = _copies(study), {}, {}
    for (experiment, condition), row in study.trials.items():
        if row.source != "recorded":
            continue
        name = f"{experiment}/{condition}"
        try:
            if experiment == "walking":
                _read_walk(study, condition)
                continue
            trial = ingested(study, experiment, condition)
            if experiment in ("weight", "empty"):
                of_plates[experiment, condition] = _plate_trial(study, experiment, condition, trial)
            elif experiment == "belt":
                of_belts[condition] = begin_belt(trial, study.settings["belt"], condition)
            else:
                section = study.of_trial(experiment, condition)
                BEGINS[experiment](trial, section, name)
                if experiment == "dummy" and study.has("foot"):
                    begin_foot(trial, section, name)
        except InputError as error:
            refused.append(str(error) if str(error).startswith(f"{name}: ") else f"{name}: {error}")
    return refused + _refused_calibrations(study, of_plates) + _refused_belt(study, of_belts)


def _copies(study: Study) -> list[str]:
    """One sentence for every recording that is a copy of another trial's; an empty belt may be shared."""
    refused, known = [], {}
    for (experiment, condition), row in study.trials.items():
        log = Path(row.files.get("log", ""))
        if experiment == "empty" or not log.is_file():
            continue
        content = hashlib.sha256(log.read_bytes()).hexdigest()
        other, path = known.setdefault(content, (f"{experiment}/{condition}", log))
        if path != log:
            refused.append(
                f"{experiment}/{condition}: expected a recording of its own, found {log} to be a copy of "
                f"{path}, the recording of {other}: remove one of the two rows"
            )
    return refused


def ingested(study: Study, experiment: str, condition: str, results: str = "") -> Trial:
    """Trial of a row, by the calls of workflow/scripts/ingest_*.py; simulated files lie below the results.

    Raises
    ------
    InputError
        As its job would.
    """
    settings = study.settings_of(experiment, condition)
    section, files = settings[experiment], study.raw_files(experiment, condition, results)
    lasts = study.trials[experiment, condition].duration_s
    limits = Limits(**without(settings["plausible"], *RIG_KEYS))
    if experiment in ON_PLATE:
        rig = Rig(**rig_of(settings, experiment))
        trial = _on_plate(experiment, files, section, lasts, study.recording(experiment, condition))
        return plausible_trial(trial, limits, rig, files)
    trial = _of_tables(study, experiment, condition, files, section)
    return plausible_trial(trial, limits, Rig(), files)


def _on_plate(experiment: str, files: dict, section: dict, lasts: float, recording: dict | None) -> Trial:
    """Trial on the treadmill (s), of several files or of one."""
    options, of_files = TreadmillOptions(**section["ingest"]), section.get("files", {})
    labels, use = of_files.get("marker_labels"), options_of(RecordingOptions, recording or {})
    if experiment == "standing":
        channels = {muscle: choice["channel"] for muscle, choice in section["muscles"].items()}
        trigger = of_files["emg_trigger"], of_files["emg_trigger_threshold"]
        return ingest_standing_files(files, labels, channels, *trigger, options, lasts, use)
    if "calibration" in files:
        return ingest_treadmill_files(files, labels, options, lasts)
    return ingest_recording_files(files, labels, options, use, lasts)


def _of_tables(study: Study, experiment: str, condition: str, files: dict, section: dict) -> Trial:
    """Trial of a manipulator, a platform or a belt."""
    of_files, lasts = section["files"], study.trials[experiment, condition].duration_s

    def table(kind: str, columns: str, delimiter: str, units: dict[str, str] | None = None) -> dict:
        named_by = study.named_by(experiment, condition, columns)
        return read_text_table(files[kind], of_files[columns], DELIMITERS[delimiter], named_by, units)

    if experiment == "wristalyzer":
        options = ManipulatorOptions(angle_unit=of_files["angle_unit"], **section["ingest"])
        log = table("log", "log_columns", "tab", options.units)
        command = table("command", "command_columns", "tab", options.units)
        return ingest_torque_manipulator(log, command, options, lasts, files["log"], files["command"])
    if experiment == "belt":
        log = table("log", "columns", of_files["delimiter"])
        options = BeltTableOptions(load_unit=of_files["load_unit"], **section["ingest"])
        return ingest_belt_table(log, of_files["columns"], options, lasts, files["log"])
    units = {key: of_files[key] for key in ("angle_unit", "torque_sign") if key in of_files}
    if experiment == "platform":
        options = PlatformTableOptions(platform_unit=of_files["platform_unit"], **units, **section["ingest"])
        log = table("log", "columns", of_files["delimiter"], options.units)
        return ingest_platform(log, options, lasts, files["log"])
    if experiment == "position_manipulator":
        options = TableOptions(**units, **section["ingest"])
        log = table("log", "columns", of_files["delimiter"], options.units)
        return ingest_position_manipulator(log, options, lasts, files["log"])
    raise NotImplementedError(f"{experiment}: `tepsipe check` cannot read its recordings, add a branch here")


def _plate_trial(
    study: Study, experiment: str, condition: str, trial: Trial
) -> tuple[BeltRecording, Resting]:
    """Fore-aft load of a weight or the empty belt (N), and the loads at rest, for the calibration."""
    section = study.of_trial(experiment, condition)
    belt, analysis = section["belt"], section["analysis"]
    weight = None if section["weight"] is None else Weight(**section["weight"])
    plate_trial = PlateTrial(experiment, condition, "calibrate", weight, trial)
    recordings = plate_trial.recordings(belt, analysis, plate_filters(analysis)[0])
    return recordings["Fy"], plate_trial.at_rest(belt, analysis)


def _refused_calibrations(study: Study, of_plates: dict[tuple, tuple[BeltRecording, Resting]]) -> list[str]:
    """One sentence for every belt whose models of the treadmill cannot be fitted to its trials."""
    refused, usual_kg = [], study.settings["weight"]["weight"]["mass_kg"]
    for belt in study.treadmill.belts():
        trials = study.treadmill.plate_trials(belt)
        if not all((e, c) in of_plates for e, c, _ in trials):
            continue
        found = [(e, role, *of_plates[e, c]) for e, c, role in trials]
        try:
            check_plate([rest for *_, rest in found], study.treadmill.plate_of(belt))
            groups = [(group_of(e, r.carried_kg, usual_kg), role, r) for e, role, r, _ in found]
            for part in plate_groups(groups):
                for recordings in part.values():
                    check_recordings(recordings, study.config["weight"]["models"]["shortest_s"])
        except InputError as error:
            refused.append(f"models of the treadmill: {error}")
    return refused


def _refused_belt(study: Study, recordings: dict[str, BeltRecording]) -> list[str]:
    """One sentence if models of a recorded treadmill cannot be fitted to its recordings, or evaluated."""
    roles = study.roles("belt")
    if not roles or not roles.keys() <= recordings.keys():
        return []
    calibration = [recordings[c] for c, role in roles.items() if role == "calibrate"]
    try:
        for part in (calibration, *([recordings[c]] for c, role in roles.items() if role != "calibrate")):
            check_recordings(part, study.settings["belt"]["models"]["shortest_s"])
    except InputError as error:
        return [f"models of the belt: {error}"]
    return []


def _read_walk(study: Study, condition: str) -> None:
    """Recording, events and strides of a walk, and the beginning of its analysis."""
    settings, files = study.config["walking"], study.raw_files("walking", condition, "")
    lasts_s = study.trials["walking", condition].duration_s
    begin_walking(read_trial(files, settings), settings, study.config["study"]["seed"], lasts_s)
