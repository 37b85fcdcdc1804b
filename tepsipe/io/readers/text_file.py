"""Text files of any kind, refused in one sentence if they cannot be read."""

from pathlib import Path

from tepsipe.errors import InputError
from tepsipe.io.readers.gzip_file import plain_bytes


def read_text(path: Path, what: str) -> str:
    """Contents of a text file (no unit).

    Parameters
    ----------
    path : Path
        The file, plain or compressed with gzip. A byte order mark at its start is skipped.
    what : str
        What the file should be, for the message.

    Raises
    ------
    InputError
        If there is no such file, it cannot be read, is too large when unpacked, or is not text.
    """
    try:
        text = plain_bytes(path, what).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(
            f"{path}: expected {what} as text, found binary data or another encoding than UTF-8: check "
            "which file is named, or save it as UTF-8"
        ) from None
    if "\0" in text:
        raise InputError(f"{path}: expected {what} as text, found binary data: check which file is named")
    # line ends of Windows and of old Macs
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text
