"""Conversion of treadmill, markers and electromyograms of a standing person to one trial.

Time 0 is the trigger on every clock. Forces, belt and markers are on the clock of the motion capture, the
electromyograms on their recorder's own, at the full rate. A file that holds all of them has one clock, which
needs no trigger.
"""

from dataclasses import replace

import numpy as np

from tepsipe.errors import InputError, listed, quoted
from tepsipe.ingest.plate_treadmill import ingest_treadmill_files
from tepsipe.ingest.treadmill_options import RecordingOptions, TreadmillOptions
from tepsipe.ingest.whole_trial import ingest_recording, read_recording_files
from tepsipe.io.formats import read_emg
from tepsipe.io.readers.edf import UV_PER_UNIT
from tepsipe.io.readers.recording import EmgRecording, Recording
from tepsipe.io.trial import Signal, Trial
from tepsipe.signals.resampling import BAND_PER_RATE, refuse_short, regular_time, resample, rising_edge


def ingest_standing_files(
    files: dict[str, str],
    marker_labels: list[str],
    emg_channels: dict[str, str],
    emg_trigger: str | None,
    emg_trigger_threshold: float,
    options: TreadmillOptions,
    duration_s: float,
    recording: RecordingOptions | None = None,
) -> Trial:
    """Read a standing person's files and make one trial of them.

    files: paths of ``log``, ``calibration``, ``markers`` and, if muscles were recorded, ``emg``; or as
    `read_recording_files`, with ``emg`` if muscles were recorded in a file of their own.
    marker_labels: markers in the order of sequential sampling.
    emg_channels: muscle -> label of its channel. A muscle without channel is named in ``emg_missing``.
    emg_trigger: label of the trigger in the electromyograms' file; None if it started their recorder.
    emg_trigger_threshold: value above which it is high (V, or the unit of that channel).
    options: rates, longest gap, trigger. Longer gaps are bridged and marked.
    duration_s: length of the trial by the protocol.
    recording: plates and channels of a file that holds a whole trial.
    Returns: forces, moments, belt, markers and, if muscles were recorded, ``emg`` (uV).
    """
    if "calibration" in files:
        trial = ingest_treadmill_files(files, marker_labels, options, duration_s, bridge_long_gaps=True)
    else:
        recording = recording or RecordingOptions()
        whole = read_recording_files(files, recording.belt_velocity.markers)
        trial = ingest_recording(whole, marker_labels, options, recording, duration_s, bridge_long_gaps=True)
        if "emg" not in files:
            return with_recorded_emg(trial, whole, emg_channels)
    if "emg" not in files:
        return trial
    emg = read_emg(files["emg"], emg_channels, emg_trigger)
    return with_emg(trial, emg, emg_trigger_threshold, duration_s, files["emg"])


def with_recorded_emg(trial: Trial, recording: Recording, channels: dict[str, str]) -> Trial:
    """The trial with electromyograms from analog channels of its own recording.

    trial: other signals of the same recording.
    channels: muscle -> label of its channel. A muscle without channel is named in ``emg_missing``.
    Returns: as `with_emg`. Without any of the channels, the trial itself, with the reason in ``no_emg``.
    """
    name = recording.name
    muscles = tuple(muscle for muscle, label in channels.items() if label in recording.channels)
    if not muscles:
        reason = (
            f"expected at least one of the channels {listed(channels.values())} in the recording, found "
            f"{listed(recording.channels)}: name its channels in standing.muscles of the configuration"
        )
        return replace(trial, attributes={**trial.attributes, "no_emg": reason})
    recorded = [recording.channels[channels[muscle]] for muscle in muscles]
    for muscle, channel in zip(muscles, recorded, strict=True):
        if channel.unit.strip() not in UV_PER_UNIT:
            raise InputError(
                f"{name}: expected the channel {channels[muscle]!r} in uV, mV or V, found the unit "
                f"{quoted(channel.unit)}: set its unit (ANALOG:UNITS) when exporting"
            )
    rates = {channel.rate_hz for channel in recorded}
    if len(rates) > 1:
        in_hz = ", ".join(f"{rate:g}" for rate in sorted(rates))
        raise InputError(
            f"{name}: expected one sampling rate for all electromyograms, found {in_hz} Hz: export them "
            "at one rate"
        )
    per_unit = [UV_PER_UNIT[channel.unit.strip()] for channel in recorded]
    # without the converter's limits, the extremes of the samples show where they were clipped
    ends = [c.limits or _extremes(c.values) for c in recorded]
    emg = EmgRecording(
        rate_hz=recorded[0].rate_hz,
        muscles=muscles,
        signals=np.column_stack([s * c.values for s, c in zip(per_unit, recorded, strict=True)]),
        trigger=np.zeros(recorded[0].values.size),
        limits=np.array([np.multiply(s, both) for s, both in zip(per_unit, ends, strict=True)]),
        missing=tuple(muscle for muscle in channels if muscle not in muscles),
    )
    time = np.arange(emg.trigger.size) / emg.rate_hz - float(trial.attributes["start_s"])
    return _with_emg(trial, emg, time, ("clock of the recording",))


def _extremes(x: np.ndarray) -> tuple[float, float]:
    """Smallest and largest sample (unit of ``x``)."""
    finite = x[np.isfinite(x)]
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)


def with_emg(
    trial: Trial, recording: EmgRecording, trigger_threshold: float, duration_s: float, name: str
) -> Trial:
    """The trial with electromyograms from the trigger's edge on.

    trial: other signals of the same trial.
    recording: raw electromyograms (uV) and their trigger, or none: they start with the trial.
    trigger_threshold: value above which the trigger line is high (V, or the unit of that channel).
    duration_s: length of the trial by the protocol.
    name: names the file in messages.
    Returns: with ``emg`` (uV), shape (k, muscles), its clock ``emg_time`` and the attributes
    ``emg_rate_hz``, ``emg_limits_uV`` and ``emg_missing`` (names, separated by commas).
    """
    rate, samples = recording.rate_hz, recording.signals.shape[0]
    if recording.trigger is None:
        refuse_short(samples / rate, duration_s, name)
        return _with_emg(trial, recording, np.arange(samples) / rate, ("started by the trigger",))
    edge = rising_edge(recording.trigger, trigger_threshold, name)
    refuse_short(float((recording.trigger >= trigger_threshold).sum()) / rate, duration_s, name)
    # the trigger rose between the sample before the edge and the edge: half a sample on average
    time = (np.arange(recording.trigger.size) - edge + 0.5) / rate
    return _with_emg(trial, recording, time, ("time zero set to the trigger",))


def _multiple(rate_hz: float, of_hz: float) -> float:
    """The rate (Hz) if it is a multiple of ``of_hz``; else the next lower multiple."""
    nearest = round(rate_hz / of_hz) * of_hz
    if rate_hz < of_hz or abs(nearest - rate_hz) <= 1e-6 * rate_hz:
        return rate_hz
    return nearest if abs(nearest - rate_hz) <= 1e-3 * rate_hz else np.floor(rate_hz / of_hz) * of_hz


def _with_emg(trial: Trial, recording: EmgRecording, time: np.ndarray, done: tuple[str, ...]) -> Trial:
    """The trial with electromyograms (uV) at given instants (s), at a multiple of the trial's rate."""
    rate = _multiple(recording.rate_hz, trial.rate_hz)
    signals = recording.signals
    if abs(rate - recording.rate_hz) > 1e-6 * rate:
        grid = regular_time(time[0], time[-1], rate)
        signals = resample(time, signals, grid, BAND_PER_RATE * rate)
        time, done = grid, (*done, f"resampled from {recording.rate_hz:g} to {rate:g} Hz")
    emg = Signal(signals.astype(np.float32), "uV", ("emg_time", "muscle"), "raw electromyograms", done)
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
