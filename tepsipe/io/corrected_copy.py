"""Copies of recordings in which only some samples differ, with a note of what was changed.

A C3D file is copied byte by byte: the samples of the named analog channels are replaced in the format of the
file, and a parameter group with the note is appended, for which blocks are inserted before the data if
necessary. In a text table the fields of the named columns are replaced, and the note stands above the header,
on lines that begin with ``#``. All else remains as it was.

C3D (The C3D File Format, User Guide): a stored number r stands for (r - OFFSET) * SCALE * GEN_SCALE.
"""

import gzip
import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tepsipe.errors import InputError
from tepsipe.io.readers.c3d import WORDS, open_c3d
from tepsipe.io.readers.plain_file import plain_bytes, read_text

BLOCK = 512
MOST_BLOCKS = 255
# longest line of a note in a parameter of characters, whose length is one byte
LINE = 200
# relative error of a sample that is read and written back
READ_BACK = 1e-4
DIGITS = 10
DEC, MIPS = 85, 86


@dataclass(frozen=True)
class _Numbers:
    """Stored numbers of a C3D file."""

    floating: bool
    processor: int
    unsigned: bool

    @property
    def size(self) -> int:
        """Bytes of a number."""
        return 4 if self.floating else 2

    def read(self, raw: np.ndarray) -> np.ndarray:
        """Numbers from bytes of shape (..., size)."""
        if self.floating and self.processor == DEC:
            return 0.25 * self._view(raw[..., [2, 3, 0, 1]], "<f4")
        return self._view(raw, self._kind)

    def written(self, numbers: np.ndarray) -> np.ndarray:
        """Bytes of numbers (n,), shape (n, size); whole numbers must be in range."""
        scaled = 4.0 * numbers if self.floating and self.processor == DEC else numbers
        raw = np.ascontiguousarray(scaled.astype(self._kind)).view(np.uint8).reshape(-1, self.size)
        return raw[:, [2, 3, 0, 1]] if self.floating and self.processor == DEC else raw

    @property
    def _kind(self) -> str:
        order = ">" if self.processor == MIPS else "<"
        return order + ("f4" if self.floating else "u2" if self.unsigned else "i2")

    @staticmethod
    def _view(raw: np.ndarray, kind: str) -> np.ndarray:
        return np.ascontiguousarray(raw).view(kind)[..., 0].astype(float)


def write_c3d_copy(
    path: Path,
    output: Path,
    channels: Mapping[int, np.ndarray],
    group: str,
    note: Mapping[str, Sequence[str]],
) -> dict[int, float]:
    """Copy a C3D file with other samples in some analog channels.

    path: the file, plain or compressed with gzip; ``output`` is compressed if its name ends in ``.gz``.
    channels: number of the channel, from 0 -> its samples, shape (n,), in the unit of the file.
    group: name of the new parameter group; ``note`` has its parameters, each with lines of text.
    Returns: number of the channel -> difference of two neighbouring stored numbers (unit of the file), 0 for
    floating point.
    """
    file = open_c3d(path)
    content = bytearray(plain_bytes(path, "a C3D file"))
    start, processor = BLOCK * (content[0] - 1), content[BLOCK * (content[0] - 1) + 3]
    word, sign_byte = WORDS[processor]
    points, per_frame = (int(x) for x in np.frombuffer(bytes(content[2:6]), word))
    data = BLOCK * (int(np.frombuffer(bytes(content[16:18]), word)[0]) - 1)
    parameters, analogs = file["parameters"]["ANALOG"], file["data"]["analogs"][0]
    unsigned = [str(x).strip().upper() for x in parameters.get("FORMAT", {}).get("value", [])] == ["UNSIGNED"]
    numbers = _Numbers(bool(content[sign_byte] & 0x80), processor, unsigned)
    frames = file["data"]["points"].shape[2]
    row = numbers.size * (4 * points + per_frame)
    body = np.frombuffer(bytes(content[data : data + frames * row]), np.uint8).reshape(
        frames, -1, numbers.size
    )
    stored = body[:, 4 * points :].reshape(analogs.shape[1], analogs.shape[0], numbers.size).copy()
    steps = {}
    for k, wanted in channels.items():
        scale, offset = _scale(parameters, k)
        before, after = numbers.read(stored[:, k]), wanted / scale + offset
        size = np.abs(analogs[k]).max(initial=0.0) + abs(scale)
        if not np.allclose(scale * (before - offset), analogs[k], rtol=0.0, atol=READ_BACK * size):
            raise InputError(
                f"{path}: expected analog samples that ANALOG:SCALE and OFFSET describe, found others in "
                f"channel {k + 1}: export the file again as floating point"
            )
        if not numbers.floating:
            low, high = (0, 65535) if unsigned else (-32768, 32767)
            after = np.round(after)
            if after.min() < low or after.max() > high:
                raise InputError(
                    f"{path}: expected corrected samples within the range of its 16-bit numbers, found "
                    f"channel {k + 1} beyond it: export the file as floating point"
                )
        stored[:, k] = numbers.written(after)
        steps[k] = 0.0 if numbers.floating else abs(scale)
    body = np.concatenate([body[:, : 4 * points], stored.reshape(frames, per_frame, numbers.size)], axis=1)
    content[data : data + frames * row] = body.tobytes()
    _save(output, _with_group(content, start, data, word, group, note, path))
    return steps


def _scale(parameters: dict, k: int) -> tuple[float, float]:
    """Unit of the channel per stored number, and stored number of 0."""

    def value(name: str, default: float) -> float:
        values = np.ravel(parameters[name]["value"]) if name in parameters else np.empty(0)
        return float(values[k]) if values.size > k else default

    general = np.ravel(parameters["GEN_SCALE"]["value"]) if "GEN_SCALE" in parameters else np.empty(0)
    return (float(general[0]) if general.size else 1.0) * value("SCALE", 1.0), value("OFFSET", 0.0)


def _with_group(
    content: bytearray,
    start: int,
    data: int,
    word: str,
    group: str,
    note: Mapping[str, Sequence[str]],
    path: Path,
) -> bytes:
    """File with another parameter group after the others."""
    order = word[0]
    place, numbers, data_start = start + 4, [], None
    names: dict[int, str] = {}
    while True:
        length, number = struct.unpack_from("bb", content, place)
        if length == 0:
            end, last = place, None
            break
        pointer = place + 2 + abs(length)
        name = bytes(content[place + 2 : pointer]).decode("latin-1").upper()
        numbers.append(abs(number))
        if number < 0:
            names[-number] = name
        elif name == "DATA_START":
            data_start = (number, pointer + 4)
        (offset,) = struct.unpack_from(f"{order}H", content, pointer)
        if offset == 0:
            end, last = _end_of(content, pointer, number), pointer
            break
        place = pointer + offset
    own = next(k for k in range(1, 128) if k not in numbers)
    records = _records(own, group, note, order)
    if last is not None:
        struct.pack_into(f"{order}H", content, last, end - last)
    blocks = max(0, -(-(end + len(records) - data) // BLOCK))
    if (data - start) // BLOCK + blocks > MOST_BLOCKS:
        raise InputError(
            f"{path}: expected room for a parameter group of {len(records)} bytes, found the parameter "
            "section full: export the file with fewer parameters"
        )
    content[data:data] = bytes(BLOCK * blocks)
    data += BLOCK * blocks
    content[end:data] = records + bytes(data - end - len(records))
    content[start + 2] = (data - start) // BLOCK
    struct.pack_into(f"{order}H", content, 16, data // BLOCK + 1)
    if data_start is not None and names.get(data_start[0]) == "POINT":
        struct.pack_into(f"{order}H", content, data_start[1], data // BLOCK + 1)
    return bytes(content)


def _end_of(content: bytearray, pointer: int, number: int) -> int:
    """Byte after the last record, whose offset is 0."""
    place = pointer + 2
    if number > 0:
        size, dimensions = struct.unpack_from("bb", content, place)
        lengths = content[place + 2 : place + 2 + dimensions]
        place += 2 + dimensions + abs(size) * int(np.prod(np.array(lengths, dtype=int)))
    return place + 1 + content[place]


def _records(own: int, group: str, note: Mapping[str, Sequence[str]], order: str) -> bytes:
    """Group and its parameters of text; the offset of the last is 0."""
    bodies = [(-own, group, b"\0")]
    for name, lines in note.items():
        pieces = [piece for line in lines for piece in _wrapped(line)] or [""]
        width = max(map(len, pieces))
        text = "".join(piece.ljust(width) for piece in pieces).encode("ascii", "replace")
        bodies.append((own, name, struct.pack("bbBB", -1, 2, width, len(pieces)) + text + b"\0"))
    out = b""
    for k, (number, name, body) in enumerate(bodies):
        offset = 2 + len(body) if k + 1 < len(bodies) else 0
        out += (
            struct.pack("bb", len(name), number)
            + name.encode("ascii")
            + struct.pack(f"{order}H", offset)
            + body
        )
    return out + b"\0\0"


def _wrapped(line: str) -> list[str]:
    return [line[k : k + LINE] for k in range(0, len(line), LINE)] or [""]


def write_text_copy(
    path: Path,
    output: Path,
    delimiter: str,
    lines: np.ndarray,
    columns: Mapping[int, np.ndarray],
    note: Sequence[str],
) -> None:
    """Copy a text table with other numbers in some columns.

    path: the file, plain or compressed with gzip; ``output`` is compressed if its name ends in ``.gz``.
    delimiter: character between columns.
    lines: line of the file on which each row stands, counted from 1, shape (n,).
    columns: place of the column, from 0 -> its numbers, shape (n,), in the unit of the file. A field that is
    empty, or whose number is NaN, is left as it is.
    note: lines of text that are written above all others.
    """
    text = read_text(path, "a table of samples").split("\n")
    decimal_comma = delimiter != "," and any(
        re.fullmatch(r"[-+]?\d+,\d+", field.strip()) for field in text[lines[0] - 1].split(delimiter)
    )
    for row, number in enumerate(lines):
        fields = text[number - 1].split(delimiter)
        for place, values in columns.items():
            if fields[place].strip() and np.isfinite(values[row]):
                written = f"{values[row]:.{DIGITS}g}"
                fields[place] = written.replace(".", ",") if decimal_comma else written
        text[number - 1] = delimiter.join(fields)
    ending = "\r\n" if b"\r\n" in plain_bytes(path, "a table of samples")[:100_000] else "\n"
    _save(output, ending.join([*(f"# {line}" for line in note), *text]).encode("utf-8"))


def _save(output: Path, content: bytes) -> None:
    if output.suffix.lower() == ".gz":
        content = gzip.compress(content, mtime=0)
    output.write_bytes(content)
