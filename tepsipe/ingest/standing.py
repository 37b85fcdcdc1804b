"""From treadmill, markers and electromyograms of a standing person to one trial.

Time 0 is the trigger on every clock. Forces, belt and markers are on the clock of the motion capture, the
electromyograms on their recorder's own, at the full rate.
"""

from dataclasses import replace

import numpy as np

from tepsipe.ingest.plate_treadmill import TreadmillOptions, ingest_treadmill_files
from tepsipe.io.readers.edf import EmgRecording
from tepsipe.io.readers.emg import read_emg
from tepsipe.io.trial import Signal, Trial
from tepsipe.signals.resampling import refuse_short, rising_edge


def ingest_standing_files(
    files: dict[str, str],
    marker_labels: list[str],
    emg_channels: dict[str, str],
    emg_trigger: str,
    emg_trigger_threshold: float,
    options: TreadmillOptions,
    duration_s: float,
) -> Trial:
    """Read a standing person's files and make one trial of them.

    Parameters
    ----------
    files : dict of str to str
        Paths of ``log``, ``calibration``, ``markers`` and, if muscles were recorded, ``emg``.
    marker_labels : list of str
        Markers in the order of sequential sampling.
    emg_channels : dict of str to str
        Muscle -> label of its channel. A muscle without channel is named in ``emg_missing``.
    emg_trigger : str
        Label of the trigger in the electromyograms' file.
    emg_trigger_threshold : float
        Value above which it is high (V, or the unit of that channel).
    options : TreadmillOptions
        Rates (Hz), longest gap (s), trigger (V). Longer gaps are bridged and marked.
    duration_s : float
        Length of the trial by the protocol (s).

    Returns
    -------
    Trial
        Forces (N), moments (N·m), belt (m/s), markers (m) and, if muscles were recorded, ``emg`` (uV).

    Raises
    ------
    InputError
        If a file cannot be read, or as `ingest_treadmill` but for long gaps.
    """
    trial = ingest_treadmill_files(files, marker_labels, options, duration_s, bridge_long_gaps=True)
    if "emg" not in files:
        return trial
    recording = read_emg(files["emg"], emg_channels, emg_trigger)
    return with_emg(trial, recording, emg_trigger_threshold, duration_s, files["emg"])


def with_emg(
    trial: Trial, recording: EmgRecording, trigger_threshold: float, duration_s: float, name: str
) -> Trial:
    """The trial with electromyograms from the trigger's edge on.

    Parameters
    ----------
    trial : Trial
        Other signals of the same trial.
    recording : EmgRecording
        Raw electromyograms (uV) and their trigger (V).
    trigger_threshold : float
        Value above which the trigger line is high (V, or the unit of that channel).
    duration_s : float
        Length of the trial by the protocol (s).
    name : str
        Names the file in messages.

    Returns
    -------
    Trial
        With ``emg`` (uV), shape (k, muscles), its clock ``emg_time`` (s) and the attributes ``emg_rate_hz``,
        ``emg_limits_uV`` and ``emg_missing`` (names, separated by commas).

    Raises
    ------
    InputError
        If the trigger does not rise, or the recording ends early.
    """
    rate = recording.rate_hz
    edge = rising_edge(recording.trigger, trigger_threshold, name)
    refuse_short(float((recording.trigger >= trigger_threshold).sum()) / rate, duration_s, name)
    refuse_short((recording.trigger.size - edge) / rate, duration_s, name)
    # the trigger rose between the sample before the edge and the edge: half a sample on average
    time = (np.arange(recording.trigger.size) - edge + 0.5) / rate
    emg = Signal(
        recording.signals.astype(np.float32),
        "uV",
        ("emg_time", "muscle"),
        "raw electromyograms",
        ("clock moved to the trigger",),
    )
    return replace(
        trial,
        axes={**trial.axes, "emg_time": time, "muscle": np.array(recording.muscles)},
        signals={**trial.signals, "emg": emg},
        attributes={
            **trial.attributes,
            "emg_rate_hz": rate,
            "emg_limits_uV": recording.limits,
            "emg_missing": ", ".join(recording.missing),
        },
    )
