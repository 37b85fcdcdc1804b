"""HDF5 files of the study: named arrays with units and named facts of an analysis, and how files are read.

A damaged file is refused in one sentence. A file that the study has written ends with a seal, the SHA-256 of
its content, which HDF5 ignores. Where the seal fits, every byte is as it was written, so the file is read
directly; any other file is read in a child process. Arrays of a sealed result are decompressed when they are
asked for, from the bytes whose seal fits: most jobs use a few of a file's many arrays.
"""

import hashlib
import io
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, MutableMapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import h5py
import numpy as np
from numpy.typing import ArrayLike

from tepsipe.errors import InputError, quoted
from tepsipe.io.readers.guarded import guarded

# compression would enlarge an array smaller than this (bytes)
LARGE_BYTES = 4096
# a seal: these bytes, then the digest of all that is before them
SEAL, DIGEST_BYTES = b"\ntepsipe sha256 ", 32


@contextmanager
def new_hdf5(path: str | Path) -> Iterator[h5py.File]:
    """A new HDF5 file to write to, which is sealed when it is closed."""
    with h5py.File(path, "w") as file:
        yield file
    seal(path)


def seal(path: str | Path) -> None:
    """Seal a file that has just been written."""
    with open(path, "rb+") as file:
        file.write(SEAL + hashlib.sha256(file.read()).digest())


def _sealed_content(path: str | Path) -> bytes | None:
    """Content of a file of which every byte is as it was when it was sealed; None of any other."""
    with suppress(OSError):  # the reader refuses it
        if Path(path).is_file():  # no pipe, which could make it wait
            with open(path, "rb") as file:
                length = file.seek(0, os.SEEK_END) - len(SEAL) - DIGEST_BYTES
                file.seek(max(0, length))
                if file.read(len(SEAL)) == SEAL:
                    digest = file.read()
                    file.seek(0)
                    content = file.read(length)
                    return content if hashlib.sha256(content).digest() == digest else None
    return None


def write_array(group: h5py.Group, name: str, values: np.ndarray) -> h5py.Dataset:
    """Write an array and return its dataset; a large one is compressed, without loss."""
    values = np.asarray(values)
    if values.nbytes < LARGE_BYTES:
        return group.create_dataset(name, data=values)
    return group.create_dataset(name, data=values, compression="gzip", compression_opts=1, shuffle=True)


def read_hdf5(
    read: Callable,
    path: str | Path,
    expected: str,
    actual: str = "one that cannot be read",
    advice: str = "make it again",
    sealed: Callable[[bytes], object] | None = None,
):
    """Read an HDF5 file with ``read``: directly if its seal fits, or else in a child process (`guarded`).

    read: takes the path; its result can be pickled.
    sealed: takes the content of a file whose seal fits, which is read by ``read`` without it.
    expected, actual, advice: parts of the message: what the file should be, what one is that cannot be
    read, what to do about it.

    Returns
    -------
    object
        The function's result.
    """
    try:
        content = _sealed_content(path)
        if content is None:
            return guarded(read, path, what=path)
        return sealed(content) if sealed else read(path)
    except InputError:
        raise
    except Exception as error:  # h5py raises many kinds on damaged files
        raise InputError(
            f"{path}: expected {expected}, found {actual} ({quoted(error)}): {advice}"
        ) from error


@dataclass(frozen=True)
class Result:
    """Named arrays and facts."""

    arrays: MutableMapping[str, np.ndarray]
    """Name, with ``/`` between groups, -> values (units in ``units``)."""
    units: MutableMapping[str, str]
    """Name -> unit."""
    facts: dict
    """Anything that JSON can represent."""

    @classmethod
    def of(cls, signals: Mapping[str, tuple[ArrayLike, str]], facts: dict) -> Self:
        """A result of signals with their units, by name."""
        arrays = {name: np.asarray(values) for name, (values, _) in signals.items()}
        return cls(arrays, {name: unit for name, (_, unit) in signals.items()}, facts)


def write_result(path: str | Path, result: Result) -> None:
    """Write arrays with their unit as attribute ``units``, and the facts as one JSON attribute.

    Large arrays that are equal are stored once and have several names.
    """
    stored: dict[tuple, h5py.Dataset] = {}
    with new_hdf5(path) as file:
        file.attrs["facts"] = json.dumps(result.facts, sort_keys=True)
        for name, values in result.arrays.items():
            content = np.ascontiguousarray(values)
            key = (result.units[name], content.dtype.str, content.shape, content.tobytes())
            if content.nbytes >= LARGE_BYTES and key in stored:
                file[name] = stored[key]
                continue
            stored[key] = write_array(file, name, values)
            stored[key].attrs["units"] = result.units[name]


def joined(*results: Result) -> Result:
    """One result with the arrays and facts of several results that share no name."""
    return Result(
        {name: x for result in results for name, x in result.arrays.items()},
        {name: unit for result in results for name, unit in result.units.items()},
        {name: fact for result in results for name, fact in result.facts.items()},
    )


def read_result(path: str | Path) -> Result:
    """Read a file written by `write_result` (arrays in the units that it names)."""
    return read_hdf5(_read, path, "a result's HDF5 file", sealed=_on_demand)


def read_facts(path: str | Path) -> dict:
    """Facts of a file written by `write_result`, without its arrays."""
    return read_hdf5(_read_facts, path, "a result's HDF5 file")


def _read_facts(path: str | Path) -> dict:
    with h5py.File(path, "r") as file:
        return _facts(file)


def _facts(file: h5py.File) -> dict:
    facts = json.loads(file.attrs["facts"])
    if not isinstance(facts, dict):
        raise ValueError("facts without names")
    return facts


def _read(path: str | Path) -> Result:
    arrays, units = {}, {}
    with h5py.File(path, "r") as file:
        for name, dataset in _datasets(file):
            arrays[name] = dataset[...]
            units[name] = dataset.attrs["units"]
            if not isinstance(units[name], str):
                raise ValueError(f"a unit of {name!r} that is no text")
        return Result(arrays, units, _facts(file))


class _OnDemand(MutableMapping):
    """What ``read`` finds for every name, when it is first asked for; a copy is an ordinary dictionary."""

    def __init__(self, names: Iterable[str], read: Callable[[str], object]):
        self._found, self._read = dict.fromkeys(names), read

    def __getitem__(self, name):
        if self._found[name] is None:
            self._found[name] = self._read(name)
        return self._found[name]

    def __setitem__(self, name, value):
        self._found[name] = value

    def __delitem__(self, name):
        del self._found[name]

    def __iter__(self):
        return iter(self._found)

    def __len__(self):
        return len(self._found)

    def __reduce__(self):
        return dict, (dict(self),)


def _on_demand(content: bytes) -> Result:
    """Result in the content of a file."""
    file, links = h5py.File(io.BytesIO(content), "r"), []
    file.visit_links(links.append)
    groups = {name.rpartition("/")[0] for name in links}
    names = [name for name in links if name not in groups]
    arrays = _OnDemand(names, lambda name: file[name][...])
    return Result(arrays, _OnDemand(names, lambda name: file[name].attrs["units"]), _facts(file))


def _datasets(group: h5py.Group, before: str = "") -> Iterator[tuple[str, h5py.Dataset]]:
    """Names and datasets, including all names of one dataset."""
    for name in group:
        if not isinstance(name, str):
            raise ValueError(f"a name {name!r} that is no text")
        item = group[name]
        if isinstance(item, h5py.Dataset):
            yield before + name, item
        else:
            yield from _datasets(item, f"{before}{name}/")
