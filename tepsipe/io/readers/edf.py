"""Electromyograms and their trigger from EDF, EDF+ and BDF files (16 and 24 bits).

In BDF files of BioSemi the channel ``Status`` holds 16 trigger lines in the lowest bits of its 24-bit
samples, and the state of the amplifier above them (biosemi.com, "BDF file format"); the trigger is the
number that the 16 lines make.
"""

import contextlib
import io
import warnings
from collections.abc import Collection
from pathlib import Path
from typing import BinaryIO

import numpy as np

from tepsipe.errors import InputError, listed, quoted
from tepsipe.io.file_format import Channel, Contents, Format, Head
from tepsipe.io.readers.plain_file import is_gzip, plain_bytes
from tepsipe.io.readers.recording import EmgRecording

# spelling of a physical dimension, at most 8 characters -> uV
UV_PER_UNIT = {
    "nV": 1e-3,
    **dict.fromkeys(
        ("uV", "uv", "UV", "\u00b5V", "\u00b5v", "\u03bcV", "\u03bcv", "microV", "microvol"), 1.0
    ),
    **dict.fromkeys(("mV", "mv", "milliV", "millivol"), 1e3),
    **dict.fromkeys(("V", "v", "volt", "Volt"), 1e6),
}
BDF = b"\xffBIOSEMI"
STATUS, TRIGGER_BITS = "Status", 0xFFFF
# fields of a signal in the header and their lengths (bytes), up to the number of samples in a record
BYTES_BEFORE_SAMPLES = 16 + 80 + 8 + 8 + 8 + 8 + 8 + 80


def read_emg(path: str | Path, channels: dict[str, str], trigger_label: str | None) -> EmgRecording:
    """Read the wanted muscles and the trigger of an EDF, EDF+ or BDF file.

    path: EDF, EDF+ or BDF file, plain or compressed with gzip, under any name.
    channels: label of the channel of each muscle. A muscle whose channel is missing is omitted and listed.
    trigger_label: label of the trigger's channel; None if the recorder was started by the trigger.
    Returns: rate, electromyograms and their limits (uV), trigger (V; for a channel ``Status`` of a BDF file
    the number that its trigger lines make).
    """
    path = Path(path)
    signals = open_edf(path)
    triggers = [] if trigger_label is None else [trigger_label]
    muscles = muscles_found(path, signals, channels, trigger_label)
    labels = [channels[muscle] for muscle in muscles]
    for label in (*labels, *triggers):
        if len(signals[label]) > 1:
            raise InputError(
                f"{path}: expected one channel named {label!r}, found {len(signals[label])}: rename them "
                "when exporting"
            )
    rates = {label: signals[label][0].sampling_frequency for label in (*labels, *triggers)}
    if len(set(rates.values())) > 1:
        by_rate = ", ".join(f"{label!r} at {rate:g} Hz" for label, rate in rates.items())
        raise InputError(
            f"{path}: expected one sampling rate for all channels, found {by_rate}: export them at one rate"
        )
    scaled = [_physical(path, label, signals[label][0]) for label in labels]
    for label, (unit, _, _) in zip(labels, scaled, strict=True):
        if unit not in UV_PER_UNIT:
            raise InputError(
                f"{path}: expected the channel {label!r} in uV, mV or V, found the unit {quoted(unit)}: set "
                "its physical dimension when exporting"
            )
    in_uv = [UV_PER_UNIT[unit] for unit, _, _ in scaled]
    trigger = None
    if triggers:
        unit, trigger, _ = _physical(path, trigger_label, signals[trigger_label][0])
        trigger = 1e-6 * UV_PER_UNIT[unit] * trigger if unit in UV_PER_UNIT else trigger
    return EmgRecording(
        rate_hz=float(rates[labels[0]]),
        muscles=muscles,
        signals=np.column_stack([s * x for s, (_, x, _) in zip(in_uv, scaled, strict=True)]),
        trigger=trigger,
        limits=np.array([np.sort(s * ends) for s, (_, _, ends) in zip(in_uv, scaled, strict=True)]),
        missing=tuple(muscle for muscle in channels if muscle not in muscles),
    )


def muscles_found(
    path: str | Path, available: Collection[str], channels: dict[str, str], trigger_label: str | None
) -> tuple[str, ...]:
    """Muscles whose channel is in a file, in the wanted order.

    path: the file, for messages.
    available: labels of the channels in it.
    channels: label of the channel of each muscle.
    trigger_label: label of the trigger's channel; None if the recorder was started by the trigger.
    """
    if trigger_label is not None and trigger_label not in available:
        raise InputError(
            f"{path}: expected a trigger channel named {trigger_label!r}, found {listed(available)}: "
            "correct standing.files.emg_trigger"
        )
    muscles = tuple(muscle for muscle, label in channels.items() if label in available)
    if not muscles:
        raise InputError(
            f"{path}: expected at least one of the channels {listed(channels.values())}, found "
            f"{listed(available)}: correct the channels in standing.muscles"
        )
    return muscles


def open_edf(path: Path) -> dict[str, list]:
    """Channels of an EDF, EDF+ or BDF file by label, as edfio reads them (units as their headers say)."""
    import edfio  # it takes as long to import as a recording takes to read

    if not path.is_file():
        raise InputError(f"{path}: expected an EDF file, found no file: correct its path in the trial sheet")
    packed = plain_bytes(path, "an EDF file") if is_gzip(path) else None
    with path.open("rb") if packed is None else io.BytesIO(packed) as header:
        is_bdf = _refuse_truncated(path, header)
    content = path if packed is None else io.BytesIO(packed)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what edfio would mend is refused here
            if is_bdf:
                file = edfio.read_bdf(content, header_encoding="latin-1")
            else:
                file = edfio.read_edf(content, lazy_load_data=packed is None, header_encoding="latin-1")
            continuous = file.is_continuous
            signals: dict[str, list] = {}
            for signal in file.signals:
                signals.setdefault(signal.label.strip(), []).append(signal)
    except Exception as error:  # edfio raises many kinds on damaged files
        raise InputError(
            f"{path}: expected an EDF file, found one that cannot be read ({type(error).__name__}): "
            "it is damaged, export it again"
        ) from error
    if not continuous:
        raise InputError(
            f"{path}: expected one continuous recording, found gaps between its records (EDF+D): export it "
            "without pauses, or each part as a trial of its own"
        )
    return signals


def is_status(label: str, channel) -> bool:
    """Test for a channel of edfio's that holds the trigger lines of a BDF file."""
    return label == STATUS and type(channel).__name__ == "BdfSignal"


def _physical(path: Path, label: str, channel) -> tuple[str, np.ndarray, np.ndarray]:
    """Unit of a channel, its samples and its limits in this unit."""
    try:
        ends = np.array([channel.physical_min, channel.physical_max], dtype=float)
        steps = channel.digital_max - channel.digital_min
    except ValueError:
        ends, steps = np.full(2, np.nan), 0
    if steps <= 0 or not np.isfinite(ends).all() or ends[0] == ends[1]:
        raise InputError(
            f"{path}: expected a physical and a digital range of the channel {label!r}, found none that can "
            "be used in the header: calibrate the channel and export it again"
        )
    if is_status(label, channel):
        return "", (channel.digital & TRIGGER_BITS).astype(float), np.array([0.0, TRIGGER_BITS])
    unit = channel.physical_dimension
    with contextlib.suppress(UnicodeError):  # it was Latin-1
        unit = unit.encode("latin-1").decode("utf-8")
    return unit.strip(), np.asarray(channel.data), ends


def _refuse_truncated(path: Path, file: BinaryIO) -> bool:
    """Compare the size of the file with the size given by its header; whether it is BDF."""
    head = file.read(256)
    size = file.seek(0, 2)
    is_bdf = head[:8] == BDF
    if len(head) < 256 or not (is_bdf or head[:8].strip() == b"0"):
        raise InputError(
            f"{path}: expected an EDF file, found {size} bytes without its header: check "
            "which file the trial sheet names"
        )
    try:
        header, records, signals = int(head[184:192]), int(head[236:244]), int(head[252:256])
        if signals < 1:
            raise ValueError("no signals")
        file.seek(256 + signals * BYTES_BEFORE_SAMPLES)
        samples = sum(int(file.read(8)) for _ in range(signals))
        lasts_s = float(head[244:252])
    except ValueError as error:
        raise InputError(
            f"{path}: expected numbers in the header of an EDF file, found one that cannot be read: the "
            "file is truncated or damaged, copy it again from the recorder"
        ) from error
    if records < 1 or samples < 1 or not lasts_s > 0.0 or header != 256 * (signals + 1):
        raise InputError(
            f"{path}: expected records of samples, found {records} records of {samples} samples and "
            f"{lasts_s:g} s in the header: the recorder did not close the file, export it again"
        )
    expected = header + (3 if is_bdf else 2) * records * samples
    if size != expected:
        raise InputError(
            f"{path}: expected {records} records ({expected} bytes), found {size} bytes: the file is "
            f"{'truncated' if size < expected else 'damaged'}, copy it again from the recorder"
        )
    return is_bdf


def edf_contents(path: Path) -> Contents:
    """Contents of an EDF, EDF+ or BDF file (units as in the file)."""
    channels = [
        Channel.of(label, each.physical_dimension, float(each.sampling_frequency), np.asarray(each.data))
        for label, signals in open_edf(path).items()
        for each in signals
    ]
    lasts = max((c.shape[0] / c.rate_hz for c in channels if c.rate_hz), default=0.0)
    kind = "BDF" if Head.of(path).content[:8] == BDF else "EDF"
    return Contents(kind, {"duration": f"{lasts:.6g} s"}, channels)


def _fits(head: Head) -> bool:
    start, signals = head.content[:8], head.content[252:256]
    return start == BDF or (start == b"0       " and len(signals) == 4 and signals.strip().isdigit())


FORMAT = Format(
    name="EDF", fits=_fits, contents=edf_contents, endings=(".edf", ".bdf"), purpose="emg", read_emg=read_emg
)
