"""Electromyograms from text: an export of Delsys (EMGworks, Trigno Discover), or a plain table.

An export of Delsys may begin with one line per channel, ``Label: <name> Sampling frequency: <Hz> ...
Unit: V``. Its header names a column of the time, ``X[s]``, before each channel, or one for all of
them. Channels of a lower rate end earlier: their fields are empty, or hold zeros. (Layout as in the exports
that users of the system describe; Delsys publishes none.) A plain table has one column of the time and a
unit in the name of every channel, for example ``TA (uV)``.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.io.file_format import Channel, Contents, Format, Head
from tepsipe.io.readers.edf import UV_PER_UNIT, muscles_found
from tepsipe.io.readers.plain_table import PlainTable, read_plain_table
from tepsipe.io.readers.recording import EmgRecording
from tepsipe.io.readers.signal_table import SECONDS, TIME, split_unit

DELSYS_HEADER = re.compile(r'^"?X ?\[s\]"?[,;\t]', re.MULTILINE)
DELSYS_TIME = re.compile(r"X ?\[s\](\.\d+)?$")
DELSYS_LABEL = re.compile(r"Label:\s*(.+?)\s+Sampling frequency:\s*([\d.,]+).*?\bUnit:\s*(\S+)")
# sampling rates of the header and of the time stamps agree within this
RATES_WITHIN = 1e-2
# stamps stay within this many periods of a regular clock
WITHIN_PERIODS = 0.6


@dataclass(frozen=True)
class EmgChannel:
    """One column of electromyograms, or of another sensor."""

    unit: str
    """Unit as the file names it; V in an export of Delsys that names none."""
    rate_hz: float
    start_s: float
    """Time of the first sample."""
    values: np.ndarray
    """Samples in ``unit``."""


def read_emg_channels(path: str | Path) -> dict[str, EmgChannel]:
    """All channels of a text file of electromyograms by label, without the unit that may follow it.

    path: the file, plain or compressed with gzip.
    Returns: label -> samples in their unit, rate (Hz) and time of the first sample (s).
    """
    delsys = FORMAT.fits(Head.of(path))
    table = read_plain_table(path, "electromyograms", _is_delsys_header if delsys else None, ragged=delsys)
    described = {m[1].strip(): m for line in table.preamble if (m := DELSYS_LABEL.search(line))}
    times = _time_columns(table, delsys)
    clocks: dict[int, tuple[int, float, float]] = {}
    channels: dict[str, EmgChannel] = {}
    for k, name in enumerate(table.names):
        before = [t for t in times if t < k]
        if k in times or not name:
            continue
        at = before[-1] if before else times[0]
        if at not in clocks:
            clocks[at] = _clock(table, at)
        samples, rate, start = clocks[at]
        label, unit = split_unit(name)
        if label in described:
            unit = unit or described[label][3]
            rate = _exact_rate(table.name, label, described[label][2].replace(",", "."), rate)
        values = table.values[:samples, k]
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise InputError(
                f"{table.name}: expected a number in every row of {name!r}, found none on line "
                f"{table.lines[bad[0]]}: export the channel without gaps"
            )
        if label in channels:
            raise InputError(
                f"{table.name}: expected one channel named {label!r}, found two: rename one in the header"
            )
        channels[label] = EmgChannel(unit or ("V" if delsys else ""), rate, start, values)
    return channels


def read_emg_table(path: str | Path, wanted: dict[str, str], trigger_label: str | None) -> EmgRecording:
    """Read the wanted muscles and the trigger of a text file of electromyograms.

    A trigger of another rate is held from sample to sample at the instants of the electromyograms.

    path: the file, plain or compressed with gzip.
    wanted: label of the channel of each muscle. A muscle whose channel is missing is omitted and listed.
    trigger_label: label of the trigger's channel; None if the recorder was started by the trigger.
    Returns: rate, electromyograms and their extremes (uV), trigger (V, or as recorded).
    """
    recorded = read_emg_channels(path)
    wanted = {muscle: split_unit(label)[0] for muscle, label in wanted.items()}
    trigger_label = None if trigger_label is None else split_unit(trigger_label)[0]
    muscles = muscles_found(path, recorded, wanted, trigger_label)
    channels = [recorded[wanted[muscle]] for muscle in muscles]
    for muscle, channel in zip(muscles, channels, strict=True):
        if channel.unit not in UV_PER_UNIT:
            raise InputError(
                f"{path}: expected the channel {wanted[muscle]!r} in uV, mV or V, found the unit "
                f"{channel.unit!r}: name it in the header, for example '{wanted[muscle]} (uV)'"
            )
    rates = {channel.rate_hz for channel in channels}
    if len(rates) > 1:
        by_rate = ", ".join(
            f"{wanted[m]!r} at {c.rate_hz:g} Hz" for m, c in zip(muscles, channels, strict=True)
        )
        raise InputError(
            f"{path}: expected one sampling rate for all muscles, found {by_rate}: export them at one rate"
        )
    rate, n = channels[0].rate_hz, min(channel.values.size for channel in channels)
    return EmgRecording(
        rate_hz=rate,
        muscles=muscles,
        signals=np.column_stack([UV_PER_UNIT[c.unit] * c.values[:n] for c in channels]),
        trigger=None if trigger_label is None else _held(recorded[trigger_label], channels[0], n),
        # without the converter's limits, the extremes of the samples show where they were clipped
        limits=np.array([UV_PER_UNIT[c.unit] * np.array([c.values.min(), c.values.max()]) for c in channels]),
        missing=tuple(muscle for muscle in wanted if muscle not in muscles),
    )


def _held(trigger: EmgChannel, muscle: EmgChannel, n: int) -> np.ndarray:
    """Trigger (V, or as recorded) at the first n instants of a muscle, held from sample to sample."""
    at = muscle.start_s + np.arange(n) / muscle.rate_hz - trigger.start_s
    held = np.clip(np.floor(at * trigger.rate_hz + 1e-6).astype(np.int64), 0, trigger.values.size - 1)
    return 1e-6 * UV_PER_UNIT.get(trigger.unit, 1e6) * trigger.values[held]


def _is_delsys_header(line: str) -> bool:
    return DELSYS_TIME.match(re.split(r"[,;\t]", line)[0].strip().strip('"')) is not None


def _time_columns(table: PlainTable, delsys: bool) -> list[int]:
    """Places of the columns that hold the time."""
    if delsys:
        return [k for k, name in enumerate(table.names) if DELSYS_TIME.match(name)]
    times = [k for k, name in enumerate(table.names) if TIME.match(split_unit(name)[0])][:1]
    if not times:
        raise InputError(
            f"{table.name}: expected a column of the time, named 'time' or 'X[s]', found "
            f"{listed(table.names)}: name it in the header, with its unit, for example 'time (s)'"
        )
    return times


def _clock(table: PlainTable, column: int) -> tuple[int, float, float]:
    """Number of samples, rate (Hz) and first instant (s) of a column of the time."""
    name = table.names[column]
    unit = "s" if DELSYS_TIME.match(name) else split_unit(name)[1]
    if unit not in SECONDS:
        raise InputError(
            f"{table.name}: expected the time in s, ms or us, found the unit {unit!r} in {name!r}: convert "
            "the column"
        )
    time = SECONDS[unit] * table.values[:, column]
    falls = np.flatnonzero(~(np.diff(time) > 0.0))
    samples = int(falls[0]) + 1 if falls.size else time.size
    rest = time[samples:]
    if np.any(np.isfinite(rest) & (rest != 0.0)):
        raise InputError(
            f"{table.name}: expected time to increase in {name!r}, found {time[samples]:.6g} s after "
            f"{time[samples - 1]:.6g} s on line {table.lines[samples]}: export it with more decimals, or "
            "each part as a file of its own"
        )
    if samples < 20:
        raise InputError(
            f"{table.name}: expected at least 20 samples at different times, found {samples} in column "
            f"{column + 1}: record again, or export the time with more decimals"
        )
    period = (time[samples - 1] - time[0]) / (samples - 1)
    away = np.abs(time[:samples] - time[0] - period * np.arange(samples)).max() / period
    if away > WITHIN_PERIODS:
        raise InputError(
            f"{table.name}: expected samples at a regular rate, found stamps {away:.3g} periods away from "
            f"{1.0 / period:.6g} Hz in column {column + 1}: the recording has gaps, export it without pauses"
        )
    return samples, float(1.0 / period), float(time[0])


def _exact_rate(name: str, label: str, written: str, measured: float) -> float:
    """The rate of the header (Hz), which has more digits than the stamps, if the two agree."""
    try:
        stated = float(written)
    except ValueError:
        raise InputError(
            f"{name}: expected the sampling frequency of {label!r} as a number in the header, found "
            f"{written!r}: repair the line or export the file again"
        ) from None
    if not abs(stated - measured) <= RATES_WITHIN * measured:
        raise InputError(
            f"{name}: expected {label!r} at {stated:g} Hz as the header says, found {measured:.6g} Hz in its "
            "time stamps: export the file again"
        )
    return measured if abs(stated - measured) > 5e-4 * measured else stated


def emg_table_contents(path: Path) -> Contents:
    """Contents of an export of Delsys (units as in the file)."""
    by_label = read_emg_channels(path)
    channels = [Channel.of(label, c.unit, c.rate_hz, c.values) for label, c in by_label.items()]
    lasts = max((c.values.size / c.rate_hz for c in by_label.values()), default=0.0)
    return Contents("Delsys export", {"duration": f"{lasts:.6g} s"}, channels)


def _fits(head: Head) -> bool:
    first = head.first_line
    labelled = first.startswith("Label:") and "Sampling frequency" in first
    return labelled or bool(DELSYS_HEADER.search(head.text))


FORMAT = Format(
    name="Delsys", fits=_fits, contents=emg_table_contents, text=True, purpose="emg", read_emg=read_emg_table
)
