"""Trials and results of the study as MATLAB files (version 5, for MATLAB and Octave)."""

import json
import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import scipy

from tepsipe.io.result import Result
from tepsipe.io.trial import Trial

# longest name that MATLAB accepts (characters)
LONGEST = 63
# the header of a MATLAB file holds its date of writing: the same data must give the same bytes
HEADER = b"MATLAB 5.0 MAT-file, tepsipe".ljust(116)
RESERVED = (
    *("break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for", "function", "global"),
    *("if", "otherwise", "parfor", "persistent", "return", "spmd", "switch", "try", "while"),
)


def export_mat(content: Trial | Result, path: str | Path) -> None:
    """Write a trial or a result as MATLAB variables.

    Groups become structures, text becomes cells. Characters that MATLAB does not allow become underscores
    (``leg-thesis`` becomes ``leg_thesis``, ``10 Hz`` becomes ``x10_Hz``). The structure ``units`` gives the
    unit of each variable; ``axes`` of a trial names the axes of each signal.

    content: trial or result, as `tepsipe.io.stored.read_stored` returns it.
    """
    variables = _of_trial(content) if isinstance(content, Trial) else _of_result(content)
    scipy.io.savemat(path, variables, long_field_names=True, oned_as="column", do_compression=True)
    with open(path, "r+b") as file:
        file.write(HEADER)


def valid_name(name: str, taken: Iterable[str] = ()) -> str:
    """Unused name that MATLAB accepts for a variable or a field.

    name: any text.
    """
    valid = re.sub(r"\W", "_", name, flags=re.ASCII) or "x"
    if not valid[0].isalpha() or valid in RESERVED:
        valid = f"x{valid}"
    valid = valid[:LONGEST]
    candidate, number, used = valid, 1, set(taken)
    while candidate in used:
        number += 1
        candidate = f"{valid[: LONGEST - len(str(number)) - 1]}_{number}"
    return candidate


def _of_trial(trial: Trial) -> dict:
    variables: dict = {}
    units: dict = {}
    axes: dict = {}
    for name, values in trial.axes.items():
        key = valid_name(name, variables)
        variables[key] = _cells(values) if values.dtype.kind in "US" else values
        if values.dtype.kind not in "US":
            units[key] = "s"
    for name, signal in trial.signals.items():
        key = valid_name(name, variables)
        variables[key], units[key] = signal.values, signal.unit
        axes[key] = _cells(signal.axes)
    attributes = {"rate_hz": trial.rate_hz, **trial.attributes}
    for name in ("sources", "options"):  # kept as JSON in the file
        if isinstance(attributes.get(name), str):
            attributes[name] = json.loads(attributes[name])
    extra = {"units": units, "axes": axes, "attributes": _structure(attributes)}
    return variables | {valid_name(key, variables): value for key, value in extra.items()}


def _of_result(result: Result) -> dict:
    variables: dict = {}
    units: dict = {}
    names: dict[tuple[str, ...], str] = {}
    for name, values in result.arrays.items():
        inside, of_units = variables, units
        parts = tuple(name.split("/"))
        for depth in range(1, len(parts)):
            key = names.setdefault(parts[:depth], "") or valid_name(parts[depth - 1], inside)
            names[parts[:depth]] = key
            inside, of_units = inside.setdefault(key, {}), of_units.setdefault(key, {})
        key = valid_name(parts[-1], inside)
        inside[key], of_units[key] = values, result.units[name]
    extra = {"units": units, "facts": _structure(result.facts)}
    return variables | {valid_name(key, variables): value for key, value in extra.items()}


def _structure(facts: dict) -> dict:
    """Facts as a structure: dicts as structures, lists of numbers as arrays, other lists as cells."""
    fields: dict = {}
    for name, value in facts.items():
        fields[valid_name(str(name), fields)] = _value(value)
    return fields


def _value(value):
    if isinstance(value, dict):
        return _structure(value)
    if value is None:
        return np.empty((0, 0))
    if isinstance(value, list | tuple):
        try:
            numbers = np.asarray(value)
        except ValueError:  # ragged
            return _cells(value)
        return numbers if numbers.dtype.kind in "fiub" and numbers.size else _cells(value)
    return value


def _cells(values) -> np.ndarray:
    """A column of cells."""
    cells = np.empty((len(values), 1), dtype=object)
    for k, value in enumerate(values):
        cells[k, 0] = str(value) if isinstance(value, str) else _value(value)
    return cells
