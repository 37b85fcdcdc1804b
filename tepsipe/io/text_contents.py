"""Contents of text files that are no plain tables: D-Flow, exports of Delsys, TRC."""

from pathlib import Path

import numpy as np

from tepsipe.io.described import Channel, Contents


def dflow_contents(path: Path) -> Contents:
    """Contents of a file of D-Flow's mocap or record module (units by the names of its columns)."""
    from tepsipe.io.readers.dflow import MARKER, marker_columns, plate_columns, read_dflow, unit_of

    table = read_dflow(path)
    steps = np.diff(table.time)
    rate = 1.0 / np.median(steps[steps > 0.0]) if (steps > 0.0).any() else None
    facts = {"duration": f"{np.ptp(table.time):.6g} s on D-Flow's clock"}
    if table.frames is not None and table.frames.size:
        jumps = np.diff(table.frames)
        facts["frames"] = (
            f"{table.frames[0]} to {table.frames[-1]}, {int((jumps == 0).sum())} repeated, "
            f"{int((jumps - 1)[jumps > 1].sum())} dropped"
        )
    markers = marker_columns(table)
    plates = plate_columns(table)
    if plates:
        facts["force plates"] = ", ".join(plates)
    if table.speeds:
        facts["belt speeds"] = ", ".join(table.speeds)
    channels = [Channel.of(label, "m", rate, position) for label, position in markers.items()]
    for name, values in table.columns.items():
        marker = MARKER.fullmatch(name)
        if marker is None or marker[1] not in markers:
            channels.append(Channel.of(name, unit_of(name), rate, values))
    kind = "mocap" if table.is_mocap else "record"
    loads = tuple(Channel.of(name, "N", rate, force[:, 1]) for name, (force, _) in plates.items())
    return Contents(f"D-Flow text, {kind} module", facts, channels, tuple(markers), loads, vertical=1)


def emg_table_contents(path: Path) -> Contents:
    """Contents of an export of Delsys (units as in the file)."""
    from tepsipe.io.readers.emg_table import read_emg_channels

    by_label = read_emg_channels(path)
    channels = [Channel.of(label, c.unit, c.rate_hz, c.values) for label, c in by_label.items()]
    lasts = max((c.values.size / c.rate_hz for c in by_label.values()), default=0.0)
    return Contents("Delsys export", {"duration": f"{lasts:.6g} s"}, channels)


def trc_contents(path: Path) -> Contents:
    """Contents of a TRC file (m)."""
    from tepsipe.io.readers.trc import read_trc

    markers = read_trc(path)
    frames = markers.positions.shape[0]
    facts = {"frames": str(frames), "duration": f"{frames / markers.rate_hz:.6g} s"}
    channels = [
        Channel.of(label, "m", markers.rate_hz, markers.positions[:, k])
        for k, label in enumerate(markers.labels)
    ]
    visible = markers.positions[:, np.isfinite(markers.positions).any(axis=(0, 2))]
    upright = 2
    if visible.size:  # markers differ most in height
        upright = int(np.argmax(np.std(np.nanmedian(visible, axis=0), axis=0)))
    return Contents("TRC", facts, channels, tuple(markers.labels), vertical=upright)
