"""Variables of MATLAB files of any version: up to 7.2 through scipy, 7.3 (which is HDF5) through h5py.

In version 7.3 arrays are stored with their dimensions reversed, text as 16-bit characters, cells as
references to other datasets, structures as groups; the attributes ``MATLAB_class`` and ``MATLAB_empty`` say
which is which (MathWorks, "MAT-File Versions").
"""

from pathlib import Path

import numpy as np
import scipy

from tepsipe.arguments import unit_in
from tepsipe.errors import InputError
from tepsipe.io.file_format import Channel, Contents, Format, Head
from tepsipe.io.readers.guarded import guarded
from tepsipe.io.readers.plain_file import plain_file

DEEPEST = 8
HDF5 = b"\x89HDF\r\n\x1a\n"
LOG_VARIABLES = {"transducers_V", "belt_velocity_m_per_s", "trigger_V"}


def read_mat(path: str | Path, what: str, squeeze: bool = False) -> dict[str, object]:
    """All variables of a MATLAB file, whatever its version.

    path: the file, plain or compressed with gzip.
    what: expected kind of file, for messages.
    squeeze: whether dimensions of length 1 are dropped.
    Returns: variable -> ndarray (units in the names, if at all); text is a str, a cell an array of objects,
    a structure a dict in version 7.3, an object of a class (a string array) None.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: expected {what}, found no file: correct its path in the trial sheet")
    import h5py  # noqa: F401 - here, not by every child

    load = scipy.io.loadmat

    def loaded(plain: Path) -> dict[str, object]:
        if _is_hdf5(Head.of(plain)):
            return _of_hdf5(plain, squeeze)
        return {k: v for k, v in load(plain, squeeze_me=squeeze).items() if not k.startswith("__")}

    with plain_file(path, what) as plain:
        try:
            return guarded(loaded, plain, what=path)
        except InputError:
            raise
        except Exception as error:  # scipy and h5py raise many kinds on damaged files
            raise InputError(
                f"{path}: expected a MATLAB file, found one that cannot be read ({type(error).__name__}): it "
                "is truncated or damaged, copy it again from the instrument"
            ) from error


def _of_hdf5(path: Path, squeeze: bool) -> dict[str, object]:
    import h5py

    with h5py.File(path, "r") as file:
        variables = {name: _value(file, file[name], 0) for name in file if not name.startswith("#")}
    return {k: np.squeeze(v) if squeeze and isinstance(v, np.ndarray) else v for k, v in variables.items()}


def _value(file, item, depth: int):
    """A variable of MATLAB 7.3, with the dimensions that it has in MATLAB."""
    import h5py

    if depth > DEEPEST:
        raise ValueError("cells within cells without end")
    if isinstance(item, h5py.Group):
        return {name: _value(file, item[name], depth + 1) for name in item}
    kind = item.attrs.get("MATLAB_class", b"")
    kind = kind.decode() if isinstance(kind, bytes) else str(kind)
    if item.attrs.get("MATLAB_empty", 0):
        shape = tuple(int(n) for n in np.ravel(item[()]))
        return "" if kind == "char" else np.empty(shape if 0 in shape else (0, 0))
    if item.attrs.get("MATLAB_object_decode", 0):
        return None  # an object of a class, such as a string array, which only MATLAB can read
    content = item[()]
    if h5py.check_ref_dtype(item.dtype) is not None:
        cells = np.empty(content.shape, dtype=object)
        for index, reference in np.ndenumerate(content):
            cells[index] = _value(file, file[reference], depth + 1)
        return cells.T
    # other programs leave the class out; 16-bit characters in a cell are text nevertheless
    if kind == "char" or (not kind and depth and content.dtype == np.uint16 and content.size):
        lines = ["".join(map(chr, row)) for row in np.atleast_2d(np.asarray(content).T)]
        return lines[0] if len(lines) == 1 else np.array(lines, dtype=object)
    values = np.asarray(content).T
    return values.astype(bool) if kind == "logical" else values


def mat_contents(path: Path) -> Contents:
    """Contents of a MATLAB file (units as in its names)."""
    content = read_mat(path, "a MATLAB file", squeeze=True)
    variables = {name: np.asarray(x) for name, x in content.items()}
    rates = [float(x) for name, x in variables.items() if "rate" in name.lower() and x.size == 1]
    longest = max((x.shape[0] for x in variables.values() if x.ndim), default=0)
    channels = [
        Channel.of(name, unit_in(name), rates[0] if rates and x.shape[:1] == (longest,) else None, x)
        for name, x in variables.items()
    ]
    return Contents("MATLAB", {"variables": str(len(variables))}, channels)


def _is_hdf5(head: Head) -> bool:
    content = head.content
    return content.startswith(b"MATLAB 7.3") or HDF5 in (content[:8], content[512:520])


def _fits(head: Head) -> bool:
    content = head.content
    if content[:8] == HDF5:  # files of version 7.3 that other programs write are plain HDF5
        return head.ending == ".mat"
    return _is_hdf5(head) or content.startswith(b"MATLAB 5.0") or content[126:128] in (b"IM", b"MI")


def _purpose(contents: Contents) -> tuple[str, str]:
    missing = sorted(LOG_VARIABLES - {channel.name for channel in contents.channels})
    if missing:
        return "other", f"a treadmill log also holds {', '.join(missing)}"
    return "treadmill log", ""


FORMAT = Format(name="MATLAB", fits=_fits, contents=mat_contents, endings=(".mat",), purpose=_purpose)
