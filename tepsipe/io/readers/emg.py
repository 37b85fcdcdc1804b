"""Electromyograms and their trigger from a file of any kind that holds them."""

from pathlib import Path

from tepsipe.io.readers import edf
from tepsipe.io.readers.edf import EmgRecording
from tepsipe.io.readers.file_kind import TEXTS, kind_of


def read_emg(path: str | Path, channels: dict[str, str], trigger_label: str | None) -> EmgRecording:
    """Read the wanted muscles and the trigger of an EDF, EDF+ or BDF file, an export of Delsys, or a table.

    path: the file, plain or compressed with gzip; its kind follows from its content.
    channels: label of the channel of each muscle. A muscle whose channel is missing is omitted and listed.
    trigger_label: label of the trigger's channel; None if the recorder was started by the trigger.
    Returns: rate, electromyograms and their limits (uV), trigger (V, or as recorded).
    """
    if kind_of(path) in TEXTS:
        from tepsipe.io.readers.emg_table import read_emg_table

        return read_emg_table(path, channels, trigger_label)
    return edf.read_emg(path, channels, trigger_label)
