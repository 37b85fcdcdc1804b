"""Text files of D-Flow made from known signals: mocap and record module, with the faults of real ones."""

import numpy as np

AXES = "XYZ"


def write_rows(path, names, columns):
    """Tab-separated text with six decimals, as D-Flow writes it; whole columns of the frame counter."""
    lines = ["\t".join(names)]
    whole = [name == "FrameNumber" for name in names]
    for row in zip(*columns, strict=True):
        cells = [str(int(x)) if is_whole else f"{x:.6f}" for x, is_whole in zip(row, whole, strict=True)]
        lines.append("\t".join(cells))
    path.write_text("\n".join(lines) + "\n")
    return path


def write_mocap(path, rate_hz, markers, plates, rows=None, first_frame=7001, stamps=None, first_s=208.0):
    """Mocap file of markers (m), label -> (n, 3), and of plates (N, Nm), number -> (n, 6).

    ``rows`` names the frame of every row: one that is missing was dropped, one named twice repeated.
    """
    n = len(next(iter(markers.values())))
    rows = np.arange(n) if rows is None else np.asarray(rows)
    time = first_s + np.arange(n) / rate_hz if stamps is None else stamps
    names, columns = ["TimeStamp", "FrameNumber"], [time[rows], first_frame + rows]
    for label, position in markers.items():
        names += [f"{label}.Pos{axis}" for axis in AXES]
        columns += list(np.where(np.isfinite(position), position, 0.0)[rows].T)
    for number, six in plates.items():
        names += [f"FP{number}.{kind}{axis}" for kind in ("For", "Mom") for axis in AXES]
        columns += list(six[rows].T)
    return write_rows(path, names, columns)


def write_record(path, time, speeds, frames=None):
    """Record file of belt speeds (m/s), name -> (n,), with an event between its rows."""
    names, columns = ["Time", *speeds], [time, *speeds.values()]
    if frames is not None:
        names.insert(1, "FrameNumber")
        columns.insert(1, frames)
    write_rows(path, names, columns)
    lines = path.read_text().splitlines(keepends=True)
    lines.insert(5, "#\n# EVENT A - COUNT 1\n#\n")
    path.write_text("".join([*lines, "# EVENT A occured 1 time\n"]))
    return path
