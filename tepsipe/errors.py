"""What the library raises when its input cannot be used."""

import gzip
import zlib
from pathlib import Path


def quoted(text: object, length: int = 60) -> str:
    """``text`` as it is quoted in a message (no unit): in quotes and cut to ``length`` characters."""
    shown = repr(str(text)) if not isinstance(text, float | int) else repr(text)
    return shown if len(shown) <= length else f"{shown[:length]}..."


def listed(names, most: int = 20) -> str:
    """Some names as they are listed in a message (no unit), at most ``most`` of them."""
    names = list(names)
    shown = ", ".join(quoted(name) for name in names[:most]) or "nothing"
    return shown if len(names) <= most else f"{shown} and {len(names) - most} more"


def read_text(path: Path, what: str) -> str:
    """Contents of a text file (no unit), or one sentence about why it cannot be read.

    Parameters
    ----------
    path : Path
        The file; a name that ends in ``.gz`` is decompressed.
    what : str
        What the file should be, for the message.

    Raises
    ------
    InputError
        If there is no such file, it cannot be read, or it is not text.
    """
    try:
        if path.suffix == ".gz":
            with gzip.open(path, "rt", encoding="utf-8") as file:
                text = file.read()
        else:
            text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError(f"{path}: expected {what}, found no file: correct its path") from None
    except UnicodeDecodeError:
        raise InputError(
            f"{path}: expected {what} as text, found binary data or another encoding than UTF-8: check "
            "which file is named, or save it as UTF-8"
        ) from None
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(
            f"{path}: expected {what}, found that it cannot be read ({error}): the file is truncated or "
            "damaged, copy it again"
        ) from None
    if "\0" in text:
        raise InputError(f"{path}: expected {what} as text, found binary data: check which file is named")
    return text


class InputError(ValueError):
    """Input that cannot be used.

    The message is one sentence for the person who recorded the data: it names the file or the
    quantity, what was expected, what was found and what to do. No units; raised by every reader
    and by every step that could otherwise return a silent NaN.
    """
