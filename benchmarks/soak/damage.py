"""Random damage to the bytes of a file: what copying, disks, exports and editors do, and worse."""

import gzip
import re
import struct

import numpy as np

NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
INSTEAD_OF_A_NUMBER = (
    *(
        b"nan",
        b"NaN",
        b"inf",
        b"-inf",
        b"1e308",
        b"-1e308",
        b"1e-320",
        b"1e400",
        b"0",
        b"-0",
        b"-1",
        b"9999999",
    ),
    *(
        b"9" * 40,
        b"",
        b" ",
        b"abc",
        b"1,5",
        b"1_000",
        b"0x10",
        b"1e",
        b"--1",
        b"\xff",
        b'"',
        b"null",
        b"true",
    ),
)
DELIMITERS = (b"\t", b",", b";", b" ", b"\n", b".")
INSTEAD_OF_A_DELIMITER = (*DELIMITERS, b"\r\n", b"\r", b"\0", b'"', b"", b"\t\t", b"#", b"\xc2\xa0")
WORDS = ("<H", ">H", "<h", "<I", ">I", "<i", ">i", "<Q", ">Q", "<f", ">f", "<d", ">d")
EXTREMES = {
    "H": (0, 1, 2, 255, 256, 32767, 32768, 65534, 65535),
    "h": (-32768, -1, 0, 32767),
    "I": (0, 1, 65536, 2**31 - 1, 2**31, 2**32 - 1),
    "i": (-(2**31), -1, 2**31 - 1),
    "Q": (0, 1, 2**31, 2**32, 2**63 - 1, 2**63, 2**64 - 1),
    "f": (np.nan, np.inf, -np.inf, 3.4e38, -3.4e38, 1e-45, 0.0, -1.0),
    "d": (np.nan, np.inf, -np.inf, 1.7e308, -1.7e308, 5e-324, 0.0, -1.0),
}


def mutate(content: bytes, rng: np.random.Generator, text: bool) -> bytes:
    """Damage a file's bytes once or, less often, several times.

    Parameters
    ----------
    content : bytes
        Contents of a good file. If they are compressed with gzip, what is compressed is damaged as often as
        the file itself.
    rng : numpy.random.Generator
        The source of all chance.
    text : bool
        Whether the file is text: then numbers, delimiters and lines are damaged, too.
    """
    if content[:2] == b"\x1f\x8b" and rng.random() < 0.5:
        return gzip.compress(mutate(gzip.decompress(content), rng, text), 1, mtime=0)
    kinds = (TEXT_KINDS if text else BINARY_KINDS) + ANY_KINDS
    for _ in range(int(rng.geometric(0.7))):
        content = kinds[rng.integers(len(kinds))](content, rng)
    return content


def place(content: bytes, rng: np.random.Generator, step: int = 1) -> int:
    """A position: half of them anywhere, a quarter each in the first 512 and 8192 bytes."""
    ends = (len(content), len(content), 512, 8192)
    end = max(1, min(len(content), ends[rng.integers(4)]))
    return int(rng.integers(end)) // step * step


def _length(content: bytes, rng: np.random.Generator) -> int:
    """Length of a block: from one byte to a quarter of the file, short ones more often."""
    return int(np.exp(rng.uniform(0.0, np.log(max(2, len(content) // 4)))))


def flip_bits(content: bytes, rng: np.random.Generator) -> bytes:
    """Flip one to four bits."""
    changed = bytearray(content)
    for _ in range(rng.integers(1, 5)):
        if changed:
            changed[place(content, rng)] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def change_bytes(content: bytes, rng: np.random.Generator) -> bytes:
    """Replace one to eight bytes."""
    changed = bytearray(content)
    for _ in range(rng.integers(1, 9)):
        if changed:
            changed[place(content, rng)] = int(rng.choice([0, 1, 0x7F, 0x80, 0xFF, rng.integers(256)]))
    return bytes(changed)


def truncate(content: bytes, rng: np.random.Generator) -> bytes:
    """Cut the file anywhere, or just before its end."""
    if rng.random() < 0.3:
        return content[: max(0, len(content) - int(rng.integers(1, 40)))]
    return content[: place(content, rng)]


def insert(content: bytes, rng: np.random.Generator) -> bytes:
    """Insert random bytes, or equal ones."""
    at, length = place(content, rng), min(4096, _length(content, rng))
    new = (
        rng.bytes(length) if rng.random() < 0.5 else bytes([int(rng.choice([0, 0xFF, 0x20, 0x41]))]) * length
    )
    return content[:at] + new + content[at:]


def delete(content: bytes, rng: np.random.Generator) -> bytes:
    """Delete a block."""
    at = place(content, rng)
    return content[:at] + content[at + _length(content, rng) :]


def duplicate(content: bytes, rng: np.random.Generator) -> bytes:
    """Repeat a block where it stands, or write it over another place."""
    at, length = place(content, rng), _length(content, rng)
    block = content[at : at + length]
    to = at + length if rng.random() < 0.5 else place(content, rng)
    behind = to if rng.random() < 0.5 else to + len(block)
    return content[:to] + block + content[behind:]


def overwrite(content: bytes, rng: np.random.Generator) -> bytes:
    """Fill a block with zeros, ones or noise, as a broken disk does."""
    at = place(content, rng)
    length = min(_length(content, rng), len(content) - at)
    new = (bytes(length), b"\xff" * length, rng.bytes(length))[rng.integers(3)]
    return content[:at] + new + content[at + length :]


def append(content: bytes, rng: np.random.Generator) -> bytes:
    """Add something behind the end."""
    return content + (rng.bytes(int(rng.integers(1, 2000))), bytes(512), b"\n\n", content)[rng.integers(4)]


def set_word(content: bytes, rng: np.random.Generator) -> bytes:
    """Write an extreme number of 2, 4 or 8 bytes over a word, at a multiple of its size."""
    kind = WORDS[rng.integers(len(WORDS))]
    values = EXTREMES[kind[1]]
    new = struct.pack(kind, values[rng.integers(len(values))])
    at = place(content, rng, len(new))
    return content[:at] + new + content[at + len(new) :]


def set_header_number(content: bytes, rng: np.random.Generator) -> bytes:
    """Replace a number that is written as text in the first 4096 bytes, without moving what follows."""
    matches = list(NUMBER.finditer(content[:4096]))
    if not matches:
        return set_word(content, rng)
    match = matches[rng.integers(len(matches))]
    size = match.end() - match.start()
    new = INSTEAD_OF_A_NUMBER[rng.integers(len(INSTEAD_OF_A_NUMBER))][:size].ljust(size)
    return content[: match.start()] + new + content[match.end() :]


def set_number(content: bytes, rng: np.random.Generator) -> bytes:
    """Replace a number of a text."""
    spans = [m.span() for m in NUMBER.finditer(content, place(content, rng))][:50]
    if not spans:
        return truncate(content, rng)
    start, end = spans[rng.integers(len(spans))]
    return content[:start] + INSTEAD_OF_A_NUMBER[rng.integers(len(INSTEAD_OF_A_NUMBER))] + content[end:]


def set_delimiter(content: bytes, rng: np.random.Generator) -> bytes:
    """Replace a delimiter or a line break of a text, or all of one kind."""
    old = DELIMITERS[rng.integers(len(DELIMITERS))]
    new = INSTEAD_OF_A_DELIMITER[rng.integers(len(INSTEAD_OF_A_DELIMITER))]
    if rng.random() < 0.2:
        return content.replace(old, new)
    at = content.find(old, place(content, rng))
    return content if at < 0 else content[:at] + new + content[at + len(old) :]


def change_lines(content: bytes, rng: np.random.Generator) -> bytes:
    """Delete, repeat or exchange lines, or empty one."""
    lines = content.split(b"\n")
    first, second = (int(rng.integers(len(lines))) for _ in range(2))
    kind = rng.integers(4)
    if kind == 0:
        del lines[first : first + int(rng.geometric(0.5))]
    elif kind == 1:
        lines.insert(second, lines[first])
    elif kind == 2:
        lines[first], lines[second] = lines[second], lines[first]
    else:
        lines[first] = b""
    return b"\n".join(lines)


def recode(content: bytes, rng: np.random.Generator) -> bytes:
    """Save a text with another encoding or other line breaks."""
    try:
        words = content.decode("utf-8")
    except UnicodeDecodeError:
        return change_bytes(content, rng)
    return (
        words.encode("utf-16"),
        words.encode("utf-8-sig"),
        content.replace(b"\n", b"\r\n"),
        content.replace(b"\n", b"\r"),
        content.replace(b".", b","),
        content.upper(),
        content.strip(),
    )[rng.integers(7)]


ANY_KINDS = (flip_bits, change_bytes, truncate, insert, delete, duplicate, overwrite, append)
BINARY_KINDS = (set_word, set_word, set_word, set_header_number)
TEXT_KINDS = (set_number, set_number, set_number, set_delimiter, change_lines, recode)
