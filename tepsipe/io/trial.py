"""One self-describing HDF5 file per trial.

Every signal is a dataset at the root, with its unit, meaning, rate and processing as attributes and
its axes as dimension scales, so the file opens in h5py and, through the scales, in xarray. The root
attributes hold the trial's names, the source files with their checksums, and the options used.
"""

import hashlib
import json
from dataclasses import dataclass, field, replace
from pathlib import Path

import h5py
import numpy as np

from tepsipe.arguments import FACTORS, OPTIONS, described, number, path_of
from tepsipe.errors import InputError, listed
from tepsipe.io.result import new_hdf5, read_hdf5, write_array

# units that a signal can have
UNITS = {"1", "Hz", "kg", "m/s2", *(unit for pair in FACTORS for unit in pair)}


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

    Examples
    --------
    >>> import numpy as np
    >>> from tepsipe import Signal, fit_impedance, load_example
    >>> dummy = load_example("dummy")
    >>> degrees = Signal(np.rad2deg(dummy.angle), "deg")
    >>> fit_impedance(dummy.time, degrees, dummy.torque, perturbations=dummy.perturbations).quantities["K"]
    <10.014 [9.820, 10.208] N·m/rad>
    """

    values: np.ndarray
    unit: str
    axes: tuple[str, ...] = ("time",)
    meaning: str = ""
    processing: tuple[str, ...] = ()

    def __post_init__(self):
        """Refuse a unit that is no text.

        Raises
        ------
        InputError
            If it is something else.
        """
        if not isinstance(self.unit, str):
            raise InputError(
                f"Signal: expected a unit as text, found {described(self.unit)}: give, for example, 'Nm', or "
                "'1' for numbers without a unit"
            )


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

    Examples
    --------
    >>> import numpy as np
    >>> from tepsipe import Signal, Trial
    >>> time = np.arange(100) / 250.0
    >>> angle = Signal(np.zeros(100), "rad", meaning="angle of the leg")
    >>> trial = Trial(rate_hz=250.0, axes={"time": time}, signals={"theta": angle})
    >>> trial.signals["theta"].unit
    'rad'
    """

    rate_hz: float
    axes: dict[str, np.ndarray]
    signals: dict[str, Signal]
    attributes: dict = field(default_factory=dict)

    def __post_init__(self):
        """Refuse what is no trial.

        Raises
        ------
        InputError
            If the rate is no positive number, or axes and signals are not given by name.
        """
        number(self.rate_hz, "Trial: rate_hz", OPTIONS["rate_hz"])
        for name in ("axes", "signals", "attributes"):
            if not isinstance(getattr(self, name), dict):
                raise InputError(
                    f"Trial: expected {name} by name, found {described(getattr(self, name))}: give a dict"
                )

    def __repr__(self) -> str:
        signals = ", ".join(f"{name} ({signal.unit})" for name, signal in self.signals.items())
        return f"<Trial: {self.time.size} samples at {self.rate_hz:g} Hz, {signals}>"

    @property
    def time(self) -> np.ndarray:
        """Instants of the samples (s), shape (n,).

        Raises
        ------
        InputError
            If the trial has no such axis.
        """
        if "time" not in self.axes:
            raise InputError(f"trial: expected the axis 'time', found {listed(self.axes)}: add it")
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
                f"trial: expected the signal {name!r}, found {listed(self.signals)}: make the "
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


def calibration_key(belt: str) -> str:
    """Attribute with the calibration of a belt's force plate, shape (6, channels) (N/V, N·m/V)."""
    return f"calibration_{belt}"


def faults_attribute(*faults: str) -> dict[str, str]:
    """Attribute of a trial that `recorded_faults` reads, without repeated names."""
    return {"faults": ";".join(dict.fromkeys(faults))}


def recorded_faults(trial: Trial) -> tuple[str, ...]:
    """Faults of a trial's signals as recorded, names in `tepsipe.flags.FLAGS`."""
    return tuple(filter(None, trial.attributes.get("faults", "").split(";")))


def with_faults(trial: Trial, *further: str) -> Trial:
    """The trial with further faults of its signals, none of which is repeated."""
    faults = faults_attribute(*recorded_faults(trial), *further)
    return replace(trial, attributes=trial.attributes | faults)


def write_trial(
    path: str | Path,
    trial: Trial,
    experiment: str,
    condition: str,
    sources: dict[str, str | Path],
    options: dict,
) -> None:
    """Write a trial.

    trial: signals, each in its unit.
    sources: kind of each source file -> the file; their SHA-256 is recorded.
    options: processing options, recorded as they are.
    """
    with new_hdf5(path) as file:
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

    Examples
    --------
    >>> from tepsipe import read_trial
    >>> trial = read_trial("results/trials/dummy/sine-0.3.h5")  # doctest: +SKIP
    >>> trial.signals["belt_velocity"].unit  # doctest: +SKIP
    """
    return read_hdf5(_read, path_of(path), "a trial's HDF5 file")


def _read(path: str | Path) -> Trial:
    axes, signals = {}, {}
    with h5py.File(path, "r") as file:
        for name in file:
            dataset = _dataset(file, name)
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
                dataset[...], unit, labels, meaning, tuple(filter(None, processing.split("; ")))
            )
        attributes = {key: getattr(value, "tolist", lambda v=value: v)() for key, value in file.attrs.items()}
        if not all(isinstance(name, str) for name in (*axes, *attributes)):
            raise ValueError("names that are no text")
        rate = float(file.attrs["rate_hz"])
        for name in ("sources", "options"):
            json.loads(attributes.get(name, "{}"))
    for name in ("experiment", "condition"):
        if not isinstance(attributes.get(name), str):
            raise ValueError(f"no name of its {name}")
    _check_axes(axes, rate)
    for name, signal in signals.items():
        _check_signal(name, signal, axes)
    return Trial(rate, axes, signals, attributes)


def _dataset(file: h5py.File, name: object) -> h5py.Dataset:
    """A dataset of the file itself; a link to another file is refused, and so is a group."""
    link = file.get(name, getlink=True) if isinstance(name, str) else None
    if isinstance(link, h5py.ExternalLink):
        raise ValueError(f"{name!r} is a link to another file")
    if not isinstance(link, h5py.HardLink | h5py.SoftLink) or not isinstance(file.get(name), h5py.Dataset):
        raise ValueError(f"{name!r} is no dataset or a link to nothing")
    dataset = file[name]
    if dataset.external or dataset.is_virtual:
        raise ValueError(f"the samples of {name!r} are in another file")
    return dataset


def _check_axes(axes: dict[str, np.ndarray], rate_hz: float) -> None:
    """Refuse axes without a clock that increases at the rate (Hz)."""
    time = axes.get("time")
    if time is None:
        raise ValueError("no axis 'time'")
    for name, values in axes.items():
        text = values.dtype.kind == "U"
        if values.ndim != 1 or not values.size or not (text or values.dtype.kind in "fiu"):
            raise ValueError(f"axis {name!r} is no row of numbers or names")
        if not text and not (np.isfinite(values).all() and (np.diff(values) > 0.0).all()):
            raise ValueError(f"instants of {name!r} that do not increase")
    span_s = float(time[-1] - time[0])
    if not 0.0 < rate_hz < np.inf or time.dtype.kind == "U" or abs(span_s * rate_hz - time.size + 1) > 0.5:
        raise ValueError(f"its clock of {rate_hz:g} Hz is damaged: {time.size} instants over {span_s:g} s")


def _check_signal(name: str, signal: Signal, axes: dict[str, np.ndarray]) -> None:
    """Refuse samples that are no numbers, do not fit their axes, or have a unit that the study has not."""
    values = signal.values
    if values.dtype.kind not in "fiub":
        raise ValueError(f"samples of {name!r} are {values.dtype}, no real numbers")
    if not np.isfinite(values).all():
        raise ValueError(
            f"{np.count_nonzero(~np.isfinite(values))} samples of {name!r} are missing or infinite"
        )
    missing = [axis for axis in signal.axes if axis and axis not in axes]
    if missing:
        raise ValueError(f"no axis {missing[0]!r} for {name!r}")
    shape = tuple(axes[axis].size if axis else 1 for axis in signal.axes)
    if values.shape != shape or not shape:
        raise ValueError(f"{name!r} has the shape {values.shape}, its axes {shape}")
    if signal.unit not in UNITS:
        raise ValueError(f"{name!r} is in {signal.unit!r}, none of {', '.join(sorted(UNITS))}")


def read_sources(path: str | Path) -> tuple[str, dict[str, dict[str, str]]]:
    """Name ``experiment/condition`` of a trial's file, and its sources: kind -> file and SHA-256."""

    def named(path: str | Path) -> tuple[str, dict]:
        with h5py.File(path, "r") as file:
            return f"{file.attrs['experiment']}/{file.attrs['condition']}", json.loads(file.attrs["sources"])

    return read_hdf5(named, path, "a trial's HDF5 file")
