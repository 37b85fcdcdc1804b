"""A walking trial from its files: recording, strides and events."""

from tepsipe.arguments import options_of
from tepsipe.experiments.walking.files import read_events, read_recording
from tepsipe.experiments.walking.instruments import is_of_instruments, read_instruments
from tepsipe.experiments.walking.options import WalkingAxes, WalkingFiles, WalkingPlates
from tepsipe.experiments.walking.strides import Strides, WalkingRecording, detect_events, segment_strides

# of files that were simulated
SIMULATED_AXES = {"c3d": ("+y", "+z"), "txt": ("-z", "+y")}
SIMULATED_EVENTS = {"heel_strike": "heel_strike", "toe_off": "toe_off", "pulse": "pulse"}


def read_trial(
    files: dict, settings: dict, simulated: bool = False
) -> tuple[WalkingRecording, Strides, dict]:
    """Recording, strides and events of a trial, from files of instruments or from tables.

    Parameters
    ----------
    files : dict
        Path of the ``log`` and, if there is one, of the table of ``events``.
    settings : dict
        ``recording`` and ``columns`` of the files, columns of ``events``, ``rate_hz`` (Hz), ``max_gap_s`` and
        ``from_s`` (s).
    simulated : bool
        True for simulated files, whose axes and events are known.

    Returns
    -------
    recording, strides, events
        Signals, strides, and instants of the events (s).
    """
    path = files["log"]
    if is_of_instruments(path):
        if simulated:
            of_files = WalkingFiles(
                WalkingAxes(*SIMULATED_AXES[path.rpartition(".")[2]]), WalkingPlates(1, 2)
            )
        else:
            of_files = options_of(WalkingFiles, settings["recording"])
        recording = read_instruments(path, of_files, settings["rate_hz"], settings["max_gap_s"])
    else:
        recording = read_recording(path, settings["columns"], settings["rate_hz"], settings["max_gap_s"])
    columns = SIMULATED_EVENTS if simulated else settings["events"]
    events = read_events(files.get("events"), columns)
    for kind, detected in zip(("heel_strike", "toe_off"), detect_events(recording), strict=True):
        if files.get("events") is None or columns[kind] is None:
            events[kind] = detected
    first_s = 0.0 if simulated else settings["from_s"]
    name = files.get("events") or path
    strides = segment_strides(events["heel_strike"], events["toe_off"], name=name, from_s=first_s)
    return recording, strides, events
