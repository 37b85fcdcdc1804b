"""Files that the study makes: trials and results as HDF5, treadmill models as JSON."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

from tepsipe.errors import InputError
from tepsipe.io.file_format import Channel, Contents, Format
from tepsipe.io.readers.mat_file import HDF5
from tepsipe.io.readers.plain_file import read_text

if TYPE_CHECKING:
    from tepsipe.io.result import Result
    from tepsipe.io.trial import Trial


def read_stored(path: str | Path) -> "Trial | Result":
    """Read an HDF5 file of the study (arrays in the units that it names)."""
    from tepsipe.io.result import read_hdf5, read_result
    from tepsipe.io.trial import read_trial

    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: expected a file of the study, found none: correct its path")
    is_trial = read_hdf5(
        _is_trial,
        path,
        expected="an HDF5 file of the study (trials/ or fits/)",
        actual="another kind or a damaged one",
        advice="correct its path or make it again",
    )
    return read_trial(path) if is_trial else read_result(path)


def _is_trial(path: Path) -> bool:
    import h5py  # it takes longer to import than a trial takes to read

    with h5py.File(path, "r") as file:
        return "experiment" in file.attrs


def stored_contents(path: Path) -> Contents:
    """Contents of a trial or a result of the study (units as in the file)."""
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


def models_contents(path: Path) -> Contents:
    """Names of the treadmill models in a file, with what they predict (unit in the text)."""
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


FORMATS = (
    Format(
        name="HDF5",
        fits=lambda head: head.content[:8] == HDF5,
        contents=stored_contents,
        endings=(".h5", ".hdf5"),
    ),
    Format(
        name="JSON",
        fits=lambda head: head.text.lstrip()[:1] in ("{", "["),
        contents=models_contents,
        endings=(".json",),
        text=True,
        needs_ending=True,
    ),
)
