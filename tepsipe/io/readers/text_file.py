"""Text files of any kind, refused in one sentence if they cannot be read."""

import gzip
import zlib
from pathlib import Path

from tepsipe.errors import InputError, quoted

# a compressed table is 3 to 30 times smaller than its text; a bomb is up to 1000 times smaller
MOST_PER_BYTE, ALWAYS_ALLOWED_BYTES, MOST_BYTES = 200, 20_000_000, 4_000_000_000
CHUNK_BYTES = 1 << 20


def read_text(path: str | Path, what: str, ended: bool = False) -> str:
    """Contents of a text file (no unit), with line feeds as its line breaks.

    Parameters
    ----------
    path : str or Path
        The file; a name that ends in ``.gz`` is decompressed. A byte order mark at its start is skipped.
    what : str
        What the file should be, for the message.
    ended : bool
        Refuse a file whose last line has no line break: where it is cut within its last number, what is left
        is a number, too.

    Raises
    ------
    InputError
        If there is no such file, it cannot be read, is not text or grows beyond all measure when it is
        decompressed, or its last line has no line break.
    """
    path = Path(path)
    try:
        content = _decompressed(path, what) if path.suffix.lower() == ".gz" else path.read_bytes()
        text = content.decode("utf-8-sig")
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError(f"{path}: expected {what}, found no file: correct its path") from None
    except UnicodeDecodeError:
        raise InputError(
            f"{path}: expected {what} as text, found binary data or another encoding than UTF-8: check "
            "which file is named, or save it as UTF-8"
        ) from None
    except (OSError, ValueError, EOFError, zlib.error) as error:
        raise InputError(
            f"{path}: expected {what}, found a file that cannot be read ({error}): it is truncated or "
            "damaged, copy it again"
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


def _decompressed(path: Path, what: str) -> bytes:
    """Contents of a gzip file, up to the size that an honest one could have."""
    most = min(MOST_BYTES, max(ALWAYS_ALLOWED_BYTES, MOST_PER_BYTE * path.stat().st_size))
    chunks, size = [], 0
    with gzip.open(path) as file:
        while chunk := file.read(CHUNK_BYTES):
            chunks.append(chunk)
            size += len(chunk)
            if size > most:
                raise InputError(
                    f"{path}: expected {what} of at most {most / 1e6:.0f} MB when decompressed, found more: "
                    "decompress it yourself if it is what it should be"
                )
    return b"".join(chunks)
