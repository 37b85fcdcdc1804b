"""One self-describing HDF5 file per trial.

Every signal is a dataset at the root, with its unit, meaning, rate and processing as attributes and
its axes as dimension scales, so the file opens in h5py and, through the scales, in xarray. The root
attributes hold the trial's names, the source files with their checksums, and the options used.
"""

import hashlib
import json
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

from tepsipe.errors import InputError
from tepsipe.io.hdf5_file import read_hdf5, write_array


@dataclass(frozen=True)
class Signal:
    """One signal of a trial.

    Attributes
    ----------
    values : ndarray
        Samples in ``unit``.
    unit : str
        Unit, for example ``Nm``; ``1`` for numbers without one.
    axes : tuple of str
        Name of each axis, for example ``("time", "marker", "axis")``; ``("time",)`` if left out.
    meaning : str
        Meaning of the signal, in a few words.
    processing : tuple of str
        Processing steps, with units.
    """

    values: np.ndarray
    unit: str
    axes: tuple[str, ...] = ("time",)
    meaning: str = ""
    processing: tuple[str, ...] = ()


@dataclass(frozen=True, repr=False)
class Trial:
    """A trial's signals on one common clock.

    Attributes
    ----------
    rate_hz : float
        Rate of the axis ``time`` (Hz).
    axes : dict of str to ndarray
        Coordinates: ``time`` (s), and names of markers, belts and spatial axes.
    signals : dict of str to Signal
        The signals (each with its unit).
    attributes : dict
        Further facts, for example how many samples were repaired.
    """

    rate_hz: float
    axes: dict[str, np.ndarray]
    signals: dict[str, Signal]
    attributes: dict = field(default_factory=dict)

    def __repr__(self) -> str:
        signals = ", ".join(f"{name} ({signal.unit})" for name, signal in self.signals.items())
        return f"<Trial: {self.time.size} samples at {self.rate_hz:g} Hz, {signals}>"

    @property
    def time(self) -> np.ndarray:
        """Instants of the samples (s), shape (n,)."""
        return self.axes["time"]

    def values(self, name: str) -> np.ndarray:
        """Samples of one signal, in the unit that its attribute names.

        Raises
        ------
        InputError
            If the trial has no such signal.
        """
        if name not in self.signals:
            raise InputError(
                f"trial: expected the signal {name!r}, found {', '.join(self.signals)}: make the "
                "trial's file again"
            )
        return self.signals[name].values

    def optional(self, name: str) -> np.ndarray | None:
        """Samples of one signal, in the unit that its attribute names; None where it was not recorded."""
        return self.signals[name].values if name in self.signals else None


def checksum(path: str | Path) -> str:
    """SHA-256 of a file (hexadecimal digits)."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def write_trial(
    path: str | Path,
    trial: Trial,
    experiment: str,
    condition: str,
    sources: dict[str, str | Path],
    options: dict,
) -> None:
    """Write a trial.

    Parameters
    ----------
    path : str or Path
        File to write.
    trial : Trial
        Signals, each in its unit.
    experiment, condition : str
        Names of the trial.
    sources : dict of str to path
        Kind of each source file -> the file; their SHA-256 is recorded.
    options : dict
        Processing options, recorded as they are.
    """
    with h5py.File(path, "w") as file:
        file.attrs["experiment"] = experiment
        file.attrs["condition"] = condition
        file.attrs["rate_hz"] = trial.rate_hz
        file.attrs["sources"] = json.dumps(
            {kind: {"file": str(f), "sha256": checksum(f)} for kind, f in sources.items()}
        )
        file.attrs["options"] = json.dumps(options, sort_keys=True)
        for name, value in trial.attributes.items():
            file.attrs[name] = value
        for name, values in trial.axes.items():
            if values.dtype.kind in "US":
                scale = file.create_dataset(name, data=values.astype(object), dtype=h5py.string_dtype())
            else:
                scale = write_array(file, name, values)
                scale.attrs["units"] = "s"
            scale.make_scale(name)
        for name, signal in trial.signals.items():
            dataset = write_array(file, name, signal.values)
            dataset.attrs["units"] = signal.unit
            dataset.attrs["long_name"] = signal.meaning
            dataset.attrs["rate_hz"] = _rate(trial, signal)
            dataset.attrs["processing"] = "; ".join(signal.processing)
            for number, axis in enumerate(signal.axes):
                dataset.dims[number].attach_scale(file[axis])
                dataset.dims[number].label = axis


def _rate(trial: Trial, signal: Signal) -> float:
    """Rate of a signal (Hz), which may have a clock of its own."""
    clock = trial.axes[signal.axes[0]]
    return trial.rate_hz if signal.axes[0] == "time" else float((clock.size - 1) / (clock[-1] - clock[0]))


def read_trial(path: str | Path) -> Trial:
    """Read a trial written by `write_trial`.

    Parameters
    ----------
    path : str or Path
        HDF5 file.

    Returns
    -------
    Trial
        Signals in the units that their attributes name.

    Raises
    ------
    InputError
        If the file is not such a file.
    """
    return read_hdf5(_read, path, "a trial's HDF5 file")


def _read(path: str | Path) -> Trial:
    axes, signals = {}, {}
    with h5py.File(path, "r") as file:
        for name, dataset in file.items():
            if dataset.is_scale:
                text = h5py.check_string_dtype(dataset.dtype) is not None
                axes[name] = dataset.asstr()[...].astype(str) if text else dataset[...]
                continue
            words = [dataset.attrs[word] for word in ("units", "long_name", "processing")]
            labels = tuple(dimension.label for dimension in dataset.dims)
            if not all(isinstance(word, str) for word in (name, *words, *labels)):
                raise ValueError(f"attributes of {name!r} that are no text")
            unit, meaning, processing = words
            signals[name] = Signal(
                dataset[...],
                unit,
                labels,
                meaning,
                tuple(filter(None, processing.split("; "))),
            )
        attributes = {key: getattr(value, "tolist", lambda v=value: v)() for key, value in file.attrs.items()}
        if not all(isinstance(name, str) for name in (*axes, *attributes)):
            raise ValueError("names that are no text")
        rate = float(file.attrs["rate_hz"])
        for name in ("sources", "options"):
            json.loads(attributes.get(name, "{}"))
    if not 0.0 < rate < np.inf or axes["time"].ndim != 1 or not np.isfinite(axes["time"]).all():
        raise ValueError(f"its clock of {rate:g} Hz is damaged")
    return Trial(rate, axes, signals, attributes)


def read_sources(path: str | Path) -> tuple[str, dict[str, dict[str, str]]]:
    """Name ``experiment/condition`` of a trial's file, and its sources: kind -> file and SHA-256.

    Raises
    ------
    InputError
        If the file is not a trial's.
    """

    def named(path: str | Path) -> tuple[str, dict]:
        with h5py.File(path, "r") as file:
            return f"{file.attrs['experiment']}/{file.attrs['condition']}", json.loads(file.attrs["sources"])

    return read_hdf5(named, path, "a trial's HDF5 file")
