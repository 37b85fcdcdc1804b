"""Bytes and text of a file, plain or compressed with gzip, which is recognised by the content.

A few kilobytes of gzip can hold terabytes, so the contents are unpacked piece by piece up to a limit.
"""

import errno
import gzip
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tepsipe.errors import InputError, quoted

MAGIC = b"\x1f\x8b"
# a compressed table is 3 to 30 times smaller than its text, a bomb up to 1000 times; a recording of ten
# minutes with 200 columns of text has about 150 MB
MOST_PER_BYTE, ALWAYS_ALLOWED_BYTES, LARGEST_BYTES = 200, 20_000_000, 400_000_000
# text of this size takes several times as much memory
LARGEST_PLAIN_BYTES = 1_000_000_000
PIECE_BYTES = 1 << 20


def is_gzip(path: Path) -> bool:
    """Test for a file compressed with gzip, by its first two bytes; False for pipes and devices."""
    try:
        if not path.is_file():
            return False
        with path.open("rb") as file:
            return file.read(2) == MAGIC
    except OSError:
        return False


def plain_bytes(path: Path, what: str, largest_bytes: int | None = None) -> bytes:
    """Contents of a file, unpacked if it is compressed with gzip.

    path: the file, under any name.
    what: expected kind of file, for the message.
    largest_bytes: size at which unpacking stops (bytes); by default 200 times the file's size, at least 20
    and at most 400 MB.
    """
    try:
        if path.exists() and not path.is_file():  # a pipe would be waited for, a device has no end
            found = "a folder" if path.is_dir() else "a pipe or a device"
            raise InputError(
                f"{path}: expected {what}, found {found}: name a file, into which the contents are written"
            )
        if not is_gzip(path):
            if path.exists() and path.stat().st_size > LARGEST_PLAIN_BYTES:
                raise InputError(
                    f"{path}: expected {what} of at most {LARGEST_PLAIN_BYTES / 1e6:g} MB, found "
                    f"{path.stat().st_size / 1e6:.0f} MB: check which file is named, or cut it into trials"
                )
            return path.read_bytes()
        if largest_bytes is None:
            largest_bytes = max(ALWAYS_ALLOWED_BYTES, MOST_PER_BYTE * path.stat().st_size)
            largest_bytes = min(LARGEST_BYTES, largest_bytes)
        pieces, size = [], 0
        with gzip.open(path, "rb") as file:
            while piece := file.read(PIECE_BYTES):
                size += len(piece)
                if size > largest_bytes:
                    raise InputError(
                        f"{path}: expected {what} of at most {largest_bytes / 1e6:g} MB when unpacked, found "
                        "more: unpack it yourself and look what it holds"
                    )
                pieces.append(piece)
        return b"".join(pieces)
    except FileNotFoundError:
        raise InputError(f"{path}: expected {what}, found no file: correct its path") from None
    except PermissionError:
        raise InputError(
            f"{path}: expected {what}, found a file that this user may not read: change its permissions"
        ) from None
    except InputError:
        raise
    except (OSError, ValueError, EOFError, zlib.error) as error:
        if isinstance(error, OSError) and error.errno == errno.ELOOP:
            raise InputError(
                f"{path}: expected {what}, found a symbolic link that leads back to itself: name the file"
            ) from None
        raise InputError(
            f"{path}: expected {what}, found a file that cannot be read ({quoted(error)}): it is truncated "
            "or damaged, copy it again"
        ) from None


def plain_name(path: Path) -> Path:
    """The path without a trailing ``.gz``."""
    return path.with_suffix("") if path.suffix.lower() == ".gz" else path


@contextmanager
def plain_file(path: Path, what: str) -> Iterator[Path]:
    """A file that is not compressed: the file itself, or an unpacked copy that is deleted afterwards.

    path: the file, under any name.
    what: expected kind of file, for the message.

    Yields
    ------
    Path
        A plain file for libraries that open files by name.
    """
    if not is_gzip(path):
        yield path
        return
    content = plain_bytes(path, what)
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / plain_name(path).name
        plain.write_bytes(content)
        del content
        yield plain


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


def without_comments(text: str) -> tuple[str, int]:
    """Text without the lines at its beginning that begin with ``#``, and their number."""
    count = 0
    while text.startswith("#"):
        text, count = text.partition("\n")[2], count + 1
    return text, count
