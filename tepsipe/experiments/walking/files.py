"""Walking recordings and their events as tables of text."""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tepsipe.errors import InputError, listed, quoted
from tepsipe.experiments.walking.strides import SIGNALS, WalkingRecording
from tepsipe.io.formats import contents_of, recognised
from tepsipe.io.readers.plain_file import read_text
from tepsipe.io.readers.text_table import read_text_table

EVENTS = ("heel_strike", "toe_off", "pulse")


def read_recording(
    path: str | Path, columns: Mapping[str, str | None], rate_hz: float, max_gap_s: float
) -> WalkingRecording:
    """Read one leg of a walking trial and bring it to a regular clock.

    path: text table with a header; a name that ends in ``.gz`` is decompressed.
    columns: time (s), angle (rad, plantarflexion positive), vertical, anterior and other_vertical (N), cop,
    ankle_x and ankle_y (m), supplied_moment (N·m; None if there is none), and any others that may foretell
    a stride -> name in the header.
    max_gap_s: longest step between two time stamps.
    """
    table = read_text_table(path, dict(columns), ",")
    time = table.pop("time")
    steps = np.diff(time)
    if time.size < 2 or steps.min() < 0.0 or steps.max() > max_gap_s or not np.isfinite(time).all():
        state = "fewer than two" if time.size < 2 else f"steps from {steps.min():.3g} to {steps.max():.3g} s"
        raise InputError(
            f"{path}: expected time stamps that rise by at most {max_gap_s:g} s, found {state}: correct "
            "the column "
            f"{quoted(columns['time'])}, or cut the recording at the gap"
        )
    clock = (
        np.arange(math.ceil(time[0] * rate_hz - 1e-6), math.floor(time[-1] * rate_hz + 1e-6) + 1) / rate_hz
    )
    signals = {name: np.interp(clock, time, values) for name, values in table.items()}
    required = {name: signals.pop(name) for name in SIGNALS}
    supplied = signals.pop("supplied_moment", None)
    return WalkingRecording(str(path), rate_hz, clock, **required, state=signals, supplied_moment=supplied)


def read_events(path: str | Path | None, columns: Mapping[str, str | None]) -> dict[str, np.ndarray]:
    """Read heel strikes, toe-offs and onsets of pulses of one leg.

    path: text table with a header, one event per cell (s); empty cells are missing events. Or a C3D, whose
    events count from its first frame. None if there is none.
    columns: heel_strike, toe_off, pulse -> name in the header, or label of the events with its context
    before it, for example Left Foot Strike; None where there are none.
    Returns: heel_strike, toe_off, pulse (s), each in increasing order.
    """
    if path is None:
        return {kind: np.zeros(0) for kind in EVENTS}
    known = recognised(path)
    if known is not None and known.lists_events:
        return _listed_events(Path(path), columns)
    lines = [line.split(",") for line in read_text(path, "a table of events").splitlines() if line.strip()]
    names = [name.strip() for name in lines[0]] if lines else []
    events = {}
    for kind in EVENTS:
        name = columns.get(kind)
        if name is None:
            events[kind] = np.zeros(0)
            continue
        if name not in names:
            raise InputError(
                f"{path}: expected a column {quoted(name)} of events, found {', '.join(names) or 'nothing'}: "
                "correct the name in the configuration, or detect the events"
            )
        at = names.index(name)
        cells = [line[at].strip() for line in lines[1:] if at < len(line)]
        try:
            values = np.array([float(cell) for cell in cells if cell and cell.lower() != "nan"])
        except ValueError as error:
            raise InputError(
                f"{path}: expected events in s in the column {quoted(name)}, found {error}: correct the cell"
            ) from error
        events[kind] = np.sort(values[np.isfinite(values)])
    return events


def _listed_events(path: Path, labels: Mapping[str, str | None]) -> dict[str, np.ndarray]:
    """Events that a file lists (s from its first frame), each in increasing order."""
    events: dict[str, list[float]] = {}
    for label, instant in contents_of(path).events:
        events.setdefault(label, []).append(instant)
    for label in labels.values():
        if label is not None and label not in events:
            raise InputError(
                f"{path}: expected events labelled {quoted(label)}, found {listed(events)}: correct the "
                "label in walking.events, or mark them in the file"
            )
    return {kind: np.array(events.get(labels.get(kind), [])) for kind in EVENTS}
