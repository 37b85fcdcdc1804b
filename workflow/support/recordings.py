"""Recordings of a study, read and compared with its settings as the jobs of a run do it."""

import hashlib
from pathlib import Path

import numpy as np

from tepsipe.arguments import options_of
from tepsipe.errors import InputError
from tepsipe.experiments.dummy.foot_pathways import windows_from_onset
from tepsipe.experiments.dummy.leg_pathways import DummyOptions, leg_motion
from tepsipe.experiments.platform.analysis import PlatformOptions, platform_spectra
from tepsipe.experiments.position_manipulator.analysis import PositionManipulatorOptions, cascade_record
from tepsipe.experiments.registry import EXPERIMENTS
from tepsipe.experiments.standing.epochs import EpochOptions, cut_standing_epochs
from tepsipe.experiments.standing.joint_torque import process_standing
from tepsipe.experiments.standing.options import StandingOptions
from tepsipe.experiments.walking.analysis import place_pulses, without_pulses
from tepsipe.experiments.walking.impedance import WalkingOptions
from tepsipe.experiments.walking.trial import read_trial
from tepsipe.experiments.wristalyzer.analysis import wristalyzer_record
from tepsipe.experiments.wristalyzer.record import WristalyzerOptions
from tepsipe.identification.cascade.fit import ParallelCascadeOptions
from tepsipe.ingest.limits import Limits, Rig
from tepsipe.io.trial import Trial
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.signals.resampling import refuse_short
from tepsipe.treadmill.calibration import group_of, plate_groups
from tepsipe.treadmill.plate_check import Resting, check_plate, resting
from tepsipe.treadmill.prepared import prepare_trial
from tepsipe.treadmill.recording import BeltRecording, check_recordings
from tepsipe.treadmill.trial_recordings import PlateOptions, Weight, plate_recordings, table_recording
from workflow.settings.complete import without
from workflow.support.rigs import RIG_KEYS, rig_of
from workflow.support.study import Study


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
            elif EXPERIMENTS[experiment].on_plate:
                _prepare(study, experiment, condition, trial)
            elif experiment == "belt":
                trimmed_s = study.settings["belt"]["analysis"]["trimmed_s"]
                of_belts[condition] = table_recording(trial, condition, trimmed_s)
            else:
                _begin_analysis(study, experiment, trial)
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
    """Trial of a row, by the ingest of its experiment; simulated files lie below the results."""
    limits = Limits(**without(study.settings["plausible"], *RIG_KEYS))
    trial, _ = (
        EXPERIMENTS[experiment]
        .part("ingest")
        .ingest(
            study.raw_files(experiment, condition, results),
            study.for_ingest(experiment, condition),
            study.trials[experiment, condition].duration_s,
            study.named_by(experiment, condition),
            limits,
            Rig(**rig_of(study.settings_of(experiment, condition), experiment)),
        )
    )
    return trial


def _prepare(study: Study, experiment: str, condition: str, trial: Trial) -> None:
    """Perturbations, rest, leg and windows of a dummy; joint angles, stance, mass and muscles of a person."""
    section, name = study.of_trial(experiment, condition), f"{experiment}/{condition}"
    analysis = section["analysis"]
    if experiment == "standing":
        options = StandingOptions.from_settings(
            section["person"], section["belt"], without(analysis, "tried_windows_s"), section["stance"]
        )
        cutting = EpochOptions.from_settings(analysis, section["emg"], section["ingest"]["max_gap_s"])
        cut_standing_epochs(process_standing(trial, name, options, {}, {}), cutting)
        return
    lowpass = {key: analysis[key] for key in ("lowpass_cutoff_hz", "lowpass_order")}
    fixed = section["foot"]["belt_fixed_labels"]
    dummy = DummyOptions.from_settings(section["geometry"], lowpass | vars(_window(analysis)), fixed)
    prepared = prepare_trial(trial, name, dummy.lowpass, dummy.window)
    leg_motion(prepared, dummy, "aligned")
    for pathway in study.estimators.foot_pathways():
        windows_from_onset(prepared, section["foot"]["pathways"][pathway]["window_s"])


def _begin_analysis(study: Study, experiment: str, trial: Trial) -> None:
    """Record with which the analysis of a manipulator's or a platform's trial begins."""
    analysis = study.settings[experiment]["analysis"]
    if experiment == "wristalyzer":
        wristalyzer_record(trial, options_of(WristalyzerOptions, without(analysis, "swept_bins")))
    elif experiment == "platform":
        platform_spectra(trial, PlatformOptions(**analysis))
    elif experiment == "position_manipulator":
        options = PositionManipulatorOptions(**without(analysis, "parallel_cascade"))
        cascade_record(trial, options, ParallelCascadeOptions(**analysis["parallel_cascade"]))


def _window(settings: dict) -> WindowOptions:
    return WindowOptions(**{key: settings[key] for key in WindowOptions.__dataclass_fields__})


def _plate_trial(
    study: Study, experiment: str, condition: str, trial: Trial
) -> tuple[BeltRecording, Resting]:
    """Fore-aft load of a weight or the empty belt (N), and the loads at rest, for the calibration."""
    analysis, name = study.settings["weight"]["analysis"], f"{experiment}/{condition}"
    lowpass = Lowpass(analysis["cutoffs_hz"][0], analysis["lowpass_order"], True)
    belt, window = study.treadmill.belt_of(experiment, condition), _window(analysis["window"])
    stated = study.treadmill.weight_of(experiment, condition)
    weight = None if stated is None else Weight(**stated)
    options = PlateOptions(belt, lowpass, lowpass, window, analysis["segment_s"])
    recording = plate_recordings(trial, name, condition, options, weight)["Fy"]
    return recording, resting(prepare_trial(trial, name, lowpass, window), belt, weight)


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
    """Recording, events and strides of a walk, as its job reads them."""
    files = study.raw_files("walking", condition, "")
    recording, strides, events = read_trial(files, study.config["walking"])
    length_s = float(recording.time[-1] - recording.time[0])
    refuse_short(length_s, study.trials["walking", condition].duration_s, recording.name)
    options = WalkingOptions(**study.config["walking"]["analysis"])
    onsets = events["pulse"]
    if not onsets.size:
        onsets, options = without_pulses(
            strides, options, np.random.default_rng(study.config["study"]["seed"])
        )
    place_pulses(recording, strides, onsets, options)
