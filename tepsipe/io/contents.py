"""Contents of a file of any readable kind: channels, rates, units and gaps."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tepsipe.arguments import unit_in
from tepsipe.errors import InputError, quoted
from tepsipe.io.described import Channel, Contents
from tepsipe.io.readers import file_kind
from tepsipe.io.readers.file_kind import ending_of, kind_of

TABLES = (".csv", ".tsv", ".txt")
# the content takes precedence over the name
READ_AS = {
    file_kind.C3D: ".c3d",
    file_kind.EDF_FILE: ".edf",
    file_kind.BDF_FILE: ".bdf",
    file_kind.MAT: ".mat",
    file_kind.MAT73: ".mat",
    file_kind.HDF5_FILE: ".h5",
    file_kind.TRC: ".trc",
    file_kind.DFLOW: ".txt",
    file_kind.DELSYS: ".csv",
}


def contents_of(path: str | Path) -> Contents:
    """Contents of a file of any kind that the library reads, plain or compressed with gzip.

    These are text tables, D-Flow and Delsys text, TRC, C3D, EDF, BDF, MATLAB, HDF5 of the study, and
    treadmill models.

    path: the file; its kind follows from its content or, failing that, from the ending of its name.
    """
    path = Path(path)
    if not path.is_file():
        found = "a folder" if path.is_dir() else "a pipe or a device" if path.exists() else "none"
        raise InputError(f"{path}: expected a file, found {found}: correct its path")
    readers: dict[str, Callable[[Path], Contents]] = {
        ".c3d": _of_c3d,
        ".edf": _of_edf,
        ".bdf": _of_edf,
        ".mat": _of_mat,
        ".h5": _of_hdf5,
        ".hdf5": _of_hdf5,
        ".json": _of_models,
        ".trc": _of_trc,
        **dict.fromkeys(TABLES, _of_table),
    }
    kind, ending = kind_of(path), ending_of(path)
    # MATLAB 7.3 files written by other programs are plain HDF5
    if not (kind == file_kind.HDF5_FILE and ending == ".mat"):
        ending = READ_AS.get(kind) or ending
    if ending not in readers:
        raise InputError(
            f"{path}: expected a file that ends in {', '.join(readers)}, found {ending or 'no ending'!r}: "
            "export it as one of these kinds"
        )
    return readers[ending](path)


def commonest_delimiter(header: str) -> str:
    """Character between the columns of a table with this header: tab, semicolon or comma."""
    return max("\t;,", key=header.count)


def table_columns(path: Path) -> tuple[list[str], str]:
    """Names of a text table's columns, and the character between them."""
    from tepsipe.io.readers.plain_table import column_names
    from tepsipe.io.readers.text_file import read_text

    text = read_text(path, "a table of samples")
    header = text.partition("\n")[0].rstrip("\r")
    delimiter = commonest_delimiter(header)
    names = column_names(header, delimiter)
    numbers = sum(bool(re.fullmatch(r"[-+]?[\d.]+(e[-+]?\d+)?", name, re.IGNORECASE)) for name in names)
    if len(names) < 2 or numbers > len(names) // 2:
        raise InputError(
            f"{path}: expected a header that names at least two columns, found {quoted(header)}: add a "
            f"first line "
            "with a name for every column"
        )
    return names, delimiter


def _of_table(path: Path) -> Contents:
    if kind_of(path) in (file_kind.DFLOW, file_kind.DELSYS):
        from tepsipe.io.readers.dflow import dflow_contents
        from tepsipe.io.readers.emg_table import emg_table_contents

        return (dflow_contents if kind_of(path) == file_kind.DFLOW else emg_table_contents)(path)
    from tepsipe.io.readers.plain_table import DELIMITERS
    from tepsipe.io.readers.text_table import read_text_table

    names, delimiter = table_columns(path)
    unique = [name for name in names if name and names.count(name) == 1]
    columns, texts = {}, []
    try:
        columns = read_text_table(path, {name: name for name in unique}, delimiter)
    except InputError as error:
        if "expected a number" not in str(error):
            raise
        for name in unique:  # a column of text is skipped
            try:
                columns |= read_text_table(path, {name: name}, delimiter)
            except InputError:
                texts.append(name)
    time = next((name for name in columns if re.match(r"time|zeit|t\b|t_|t \(", name, re.IGNORECASE)), None)
    rate, facts = None, {"delimiter": next(name for name, d in DELIMITERS.items() if d == delimiter)}
    if time is not None:
        seconds = columns[time] * {"ms": 1e-3, "us": 1e-6}.get(unit_in(time), 1.0)
        steps = np.diff(seconds[np.isfinite(seconds)])
        if steps.size and np.median(steps) > 0.0:
            rate = float(1.0 / np.median(steps))
            facts["duration"] = f"{steps.sum():.6g} s"
            facts["steps of time"] = (
                f"{steps.min():.4g} to {steps.max():.4g} s, median {np.median(steps):.4g} s"
            )
    if texts:
        facts["columns of text"] = ", ".join(texts)
    return Contents(
        "text table", facts, [Channel.of(name, unit_in(name), rate, x) for name, x in columns.items()]
    )


def _of_c3d(path: Path) -> Contents:
    from tepsipe.io.readers.c3d import c3d_contents

    return c3d_contents(path)


def _of_edf(path: Path) -> Contents:
    from tepsipe.io.readers.edf import open_edf

    channels = [
        Channel.of(label, each.physical_dimension, float(each.sampling_frequency), np.asarray(each.data))
        for label, signals in open_edf(path).items()
        for each in signals
    ]
    lasts = max((c.shape[0] / c.rate_hz for c in channels if c.rate_hz), default=0.0)
    kind = "BDF" if kind_of(path) == file_kind.BDF_FILE else "EDF"
    return Contents(kind, {"duration": f"{lasts:.6g} s"}, channels)


def _of_trc(path: Path) -> Contents:
    from tepsipe.io.readers.trc import trc_contents

    return trc_contents(path)


def _of_mat(path: Path) -> Contents:
    from tepsipe.io.readers.mat_file import read_mat

    content = read_mat(path, "a MATLAB file", squeeze=True)
    variables = {name: np.asarray(x) for name, x in content.items()}
    rates = [float(x) for name, x in variables.items() if "rate" in name.lower() and x.size == 1]
    longest = max((x.shape[0] for x in variables.values() if x.ndim), default=0)
    channels = [
        Channel.of(name, unit_in(name), rates[0] if rates and x.shape[:1] == (longest,) else None, x)
        for name, x in variables.items()
    ]
    return Contents("MATLAB", {"variables": str(len(variables))}, channels)


def _of_hdf5(path: Path) -> Contents:
    from tepsipe.io.stored import read_stored
    from tepsipe.io.trial import Trial

    stored = read_stored(path)
    if isinstance(stored, Trial):
        facts = {key: str(stored.attributes[key]) for key in ("experiment", "condition")}
        facts["duration"] = f"{stored.time[-1] - stored.time[0]:.6g} s"
        channels = [
            Channel.of(name, s.unit, stored.rate_hz if s.axes[0] == "time" else None, s.values)
            for name, s in stored.signals.items()
        ]
        return Contents("trial of the study", facts, channels)
    channels = [Channel.of(name, stored.units[name], None, x) for name, x in stored.arrays.items()]
    return Contents("result of the study", {"facts": ", ".join(stored.facts)}, channels)


def _of_models(path: Path) -> Contents:
    import json

    from tepsipe.io.readers.text_file import read_text

    text = read_text(path, "a file of treadmill models")
    try:
        models = {str(m["name"]): m for m in json.loads(text)["models"]}
        facts = {
            name: f"predicts a load in {model['unit']}, fitted to {', '.join(map(str, model['trained_on']))}"
            for name, model in models.items()
        }
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError(
            f"{path}: expected a file of treadmill models, found other JSON: fit the models again"
        ) from error
    return Contents("treadmill models", facts, [])
