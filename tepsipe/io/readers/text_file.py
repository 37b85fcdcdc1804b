"""Text files of any kind, refused in one sentence if they cannot be read."""

from pathlib import Path

from tepsipe.errors import InputError, quoted
from tepsipe.io.readers.gzip_file import plain_bytes

TEXT_ENDINGS = (".csv", ".tsv", ".txt")


def read_text(path: str | Path, what: str, ended: bool = False) -> str:
    """Contents of a text file, with line feeds as its line breaks.

    path: the file, plain or compressed with gzip. A byte order mark at its start is skipped.
    what: expected kind of file, for the message.
    ended: refuse a file whose last line has no line break: where it is cut within its last number, the rest
    is a number, too.
    """
    path = Path(path)
    try:
        text = plain_bytes(path, what).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(
            f"{path}: expected {what} as text, found binary data or another encoding than UTF-8: check "
            "which file is named, or save it as UTF-8"
        ) from None
    if "\0" in text:
        raise InputError(f"{path}: expected {what} as text, found binary data: check which file is named")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if ended and text and not text.endswith("\n"):
        raise InputError(
            f"{path}: expected a line break at the end of {what}, found none after "
            f"{quoted(text.rpartition(chr(10))[2][-20:])}: the file may be truncated, copy it again, or "
            "check its last line and end it with a line break"
        )
    return text
