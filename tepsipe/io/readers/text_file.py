"""Text files of any kind, refused in one sentence if they cannot be read."""

import gzip
import zlib
from pathlib import Path

from tepsipe.errors import InputError


def read_text(path: Path, what: str) -> str:
    """Contents of a text file (no unit).

    Parameters
    ----------
    path : Path
        The file; a name that ends in ``.gz`` is decompressed. A byte order mark at its start is skipped.
    what : str
        What the file should be, for the message.

    Raises
    ------
    InputError
        If there is no such file, it cannot be read, or it is not text.
    """
    try:
        if path.suffix == ".gz":
            with gzip.open(path, "rt", encoding="utf-8-sig") as file:
                text = file.read()
        else:
            text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{path}: expected {what}, found no file: correct its path") from None
    except UnicodeDecodeError:
        raise InputError(
            f"{path}: expected {what} as text, found binary data or another encoding than UTF-8: check "
            "which file is named, or save it as UTF-8"
        ) from None
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(
            f"{path}: expected {what}, found a file that cannot be read ({error}): it is truncated or "
            "damaged, copy it again"
        ) from None
    if "\0" in text:
        raise InputError(f"{path}: expected {what} as text, found binary data: check which file is named")
    return text
