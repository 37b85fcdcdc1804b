"""Recordings of a study, read and compared with its settings as the jobs of a run do it."""

import hashlib
from pathlib import Path

from tepsipe.errors import InputError
from tepsipe.experiments.registry import EXPERIMENTS
from tepsipe.experiments.walking.trial import read_trial
from tepsipe.experiments.weight.calibrate import PlateTrial
from tepsipe.ingest.limits import Limits, Rig
from tepsipe.io.trial import Trial
from tepsipe.treadmill.calibration import group_of, plate_groups
from tepsipe.treadmill.options import Weight
from tepsipe.treadmill.plate_check import Resting, check_plate
from tepsipe.treadmill.recording import BeltRecording, check_recordings
from tepsipe.treadmill.trial_recordings import plate_filters
from workflow.settings.complete import without
from workflow.support.rigs import RIG_KEYS, rig_of
from workflow.support.study import Study
from workflow.support.to_record import Read


def refused_recordings(study: Study, read: Read | None = None) -> list[str]:
    """Read all recorded trials; one sentence for every one that would stop its job, or the calibration.

    read: what the recordings show, which is added.
    """
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
            if read is not None:
                read.add((experiment, condition), trial)
            if experiment in ("weight", "empty"):
                of_plates[experiment, condition] = _plate_trial(study, experiment, condition, trial)
            elif experiment == "belt":
                begin = EXPERIMENTS[experiment].part("fit").begin
                of_belts[condition] = begin(trial, study.settings["belt"], condition)
            else:
                section = study.of_trial(experiment, condition)
                with_foot = experiment == "dummy" and study.has("foot")
                for part in ("fit", "fit_foot") if with_foot else ("fit",):
                    begun = EXPERIMENTS[experiment].part(part).begin(trial, section, name)
                if experiment == "standing" and read is not None:
                    quiet_s = float(begun[0].unperturbed.sum()) / trial.rate_hz
                    read.quiet_s[row.participant] = read.quiet_s.get(row.participant, 0.0) + quiet_s
        except InputError as error:
            refused.append(str(error) if str(error).startswith(f"{name}: ") else f"{name}: {error}")
    if read is not None:
        read.plates |= {trial: recording for trial, (recording, _) in of_plates.items()}
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
    """Trial of a row, by the ingest of its experiment; simulated files lie below the results."""
    limits = Limits(**without(study.settings["plausible"], *RIG_KEYS))
    ingest = EXPERIMENTS[experiment].part("ingest").ingest
    trial, _ = ingest(
        study.raw_files(experiment, condition, results),
        study.for_ingest(experiment, condition),
        study.trials[experiment, condition].duration_s,
        study.named_by(experiment, condition),
        limits,
        Rig(
            **rig_of(
                study.settings_of(experiment, condition),
                experiment,
                study.trials[experiment, condition].amplitude,
            )
        ),
    )
    return trial


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
    begin = EXPERIMENTS["walking"].part("fit").begin
    begin(read_trial(files, settings), settings, study.config["study"]["seed"], lasts_s)
