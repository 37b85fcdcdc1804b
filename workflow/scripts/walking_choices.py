"""From the section walking of the configuration to a trial: what several scripts need."""

from tepsipe.experiments.walking.files import read_events, read_recording
from tepsipe.experiments.walking.impedance import WalkingOptions
from tepsipe.experiments.walking.instruments import WalkingFiles, is_of_instruments, read_instruments
from tepsipe.experiments.walking.recording import WalkingRecording
from tepsipe.experiments.walking.strides import Strides, detect_events, segment_strides

# of the files that the virtual laboratory writes
MADE_AXES = {"c3d": ("+y", "+z"), "txt": ("-z", "+y")}
MADE_MARKERS = {"ankle": "LMAL", "knee": "LKNE", "heel": "LHEE", "toe": "LTOE"}
MADE_EVENTS = {"heel_strike": "heel_strike", "toe_off": "toe_off", "pulse": "pulse"}


def read_trial(files: dict, settings: dict, made: bool = False) -> tuple[WalkingRecording, Strides, dict]:
    """Recording, strides and events of a trial, from the files of instruments or from tables."""
    path = files["log"]
    if is_of_instruments(path):
        recording = read_instruments(
            path,
            _made_files(path) if made else _files(settings["recording"]),
            settings["rate_hz"],
            settings["max_gap_s"],
        )
    else:
        recording = read_recording(path, settings["columns"], settings["rate_hz"], settings["max_gap_s"])
    columns = MADE_EVENTS if made else settings["events"]
    events = read_events(files.get("events"), columns)
    for kind, found in zip(("heel_strike", "toe_off"), detect_events(recording), strict=True):
        if files.get("events") is None or columns[kind] is None:
            events[kind] = found
    first_s = 0.0 if made else settings["from_s"]
    name = files.get("events") or path
    strides = segment_strides(events["heel_strike"], events["toe_off"], name=name, from_s=first_s)
    return recording, strides, events


def read_walk(files: dict, settings: dict) -> tuple[WalkingRecording, Strides]:
    """Recording and usable strides of a trial without pulses."""
    recording, strides, _ = read_trial(files, settings)
    return recording, strides


def options_of(analysis: dict) -> WalkingOptions:
    """Choices of the analysis."""
    lists = ("phases_percent", "control_percent", "matched_by")
    return WalkingOptions(
        **analysis | {key: None if analysis[key] is None else tuple(analysis[key]) for key in lists}
    )


def _files(recording: dict) -> WalkingFiles:
    axes, plates = recording["axes"], recording["plates"]
    return WalkingFiles(
        axes["forward"],
        axes["up"],
        plates["own"],
        plates["other"],
        recording["force_sign"],
        recording["markers"],
        recording["surface_m"],
    )


def _made_files(path: str) -> WalkingFiles:
    return WalkingFiles(*MADE_AXES[path.rpartition(".")[2]], 1, 2, 1, MADE_MARKERS)
