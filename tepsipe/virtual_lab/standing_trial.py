"""One trial of a person standing on the treadmill, from protocol and truth to raw files."""

from pathlib import Path

from tepsipe.virtual_lab.belt import DriveTruth
from tepsipe.virtual_lab.electromyography import CHANNELS, EmgTruth, record_emg, sample_trigger, write_emg
from tepsipe.virtual_lab.person import loads_of_legs, move_person, true_ankles
from tepsipe.virtual_lab.person_constants import (
    MARKERS,
    MUSCLES,
    MuscleTruth,
    NervesTruth,
    PersonMarkers,
    PersonTruth,
    SkinTruth,
    Subject,
    TaskTruth,
)
from tepsipe.virtual_lab.person_markers import person_marker_paths
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_trial import Protocol, record_capture, record_log, schedule_at_random
from tepsipe.virtual_lab.truth_file import write_true_motion

# the body is slower than the dummy: half as many steps as for the other rigs are enough
INTEGRATION_RATE_HZ = 1000.0


def make_standing_trial(
    truth: dict, condition: str, task: str, protocol: Protocol, files: dict[str, Path], belt: str = "right"
) -> None:
    """Make one trial of a person standing on the treadmill.

    truth: the laboratory's constants, as its configuration file holds them.
    condition: name of the condition: it seeds the trial's noise and intervals.
    task: {"relax", "stiff"}: Task of the person.
    files: files to write: ``log``, ``calibration``, ``markers`` and ``emg``, and ``motion``, the hidden
    motion of the ankles, if it is wanted.
    belt: {"right", "both"}: Both feet on the right belt, or each foot on the belt of its side.
    """
    seed, rig, standing = truth["seed"], truth["treadmill"], truth["standing"]
    rng = generator(seed, "standing", condition)
    of_nerves, of_emg = rng.spawn(2)
    schedule = schedule_at_random(rig, protocol, rng)
    person, doing = PersonTruth(**standing["person"]), TaskTruth(**standing["tasks"][task])
    muscles = {name: MuscleTruth(**standing["muscles"][name]) for name in MUSCLES}
    motion = move_person(
        Subject(person, muscles, doing, NervesTruth(**standing["nerves"])),
        DriveTruth(**rig["drive"]),
        schedule.command,
        schedule.ends_s,
        INTEGRATION_RATE_HZ,
        of_nerves,
    )
    loads = loads_of_legs(person, motion) if belt == "both" else {"right": (motion, person.mass_kg)}
    record_log(rig, seed, schedule, loads, rng, files)
    skin = SkinTruth(**standing["skin"])
    paths = person_marker_paths(PersonMarkers(**standing["markers"]), person, skin, motion)
    record_capture(rig, schedule, MARKERS, paths, rng, files["markers"])
    recorder = EmgTruth(**standing["emg"])
    voltages, instants = record_emg(
        recorder, motion.time, motion.drive, motion.belt_acceleration, schedule.ends_s, of_emg
    )
    trigger = sample_trigger(instants, schedule.trigger_s, schedule.duration_s)
    write_emg(files["emg"], CHANNELS, voltages, trigger, recorder.rate_hz, recorder.limit_uV)
    if "motion" in files:
        write_true_motion(files["motion"], true_ankles(person, doing, motion, schedule.trigger_s))
