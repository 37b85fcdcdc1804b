"""Kind of a file by its content: what it is called does not matter, nor whether it is compressed."""

import gzip
import re
import zlib
from pathlib import Path

from tepsipe.io.readers.gzip_file import is_gzip

HDF5 = b"\x89HDF\r\n\x1a\n"
BDF = b"\xffBIOSEMI"
HEAD_BYTES = 8192

C3D, EDF_FILE, BDF_FILE, MAT, MAT73, HDF5_FILE = "C3D", "EDF", "BDF", "MATLAB", "MATLAB 7.3", "HDF5"
TRC, DFLOW, DELSYS, JSON, TABLE = "TRC", "D-Flow", "Delsys", "JSON", "text table"
TEXTS = (TRC, DFLOW, DELSYS, JSON, TABLE)

DFLOW_HEADER = re.compile(
    r"(TimeStamp|Time)\t(.*\t)?("
    r"FrameNumber|[^\t]+\.Pos[XYZ]|FP\d+\.(For|Mom|Cop)[XYZ]|[^\t]*(speed|velocity)[^\t]*)(\t|\r|\n|$)",
    re.IGNORECASE,
)
DELSYS_HEADER = re.compile(r'^"?X ?\[s\]"?[,;\t]', re.MULTILINE)
# voltages and calibrated signals of manipulators also come from D-Flow, but as plain tables
MANIPULATOR = re.compile(r"MotorAngle|TriggerTime")


def first_bytes(path: Path) -> bytes:
    """First bytes of a file, unpacked if it is compressed with gzip; empty if it cannot be read."""
    try:
        if not path.is_file():
            return b""
        if not is_gzip(path):
            with path.open("rb") as file:
                return file.read(HEAD_BYTES)
        with gzip.open(path, "rb") as file:
            return file.read(HEAD_BYTES)
    except (OSError, EOFError, ValueError, zlib.error):
        return b""


def kind_of(path: str | Path) -> str | None:
    """Kind of a file by its first bytes: one of the constants of this module, None if unknown."""
    head = first_bytes(Path(path))
    if head[:8] == BDF:
        return BDF_FILE
    if head[:8] == b"0       " and len(head) >= 256 and head[252:256].strip().isdigit():
        return EDF_FILE
    if head.startswith(b"MATLAB 7.3") or head[512:520] == HDF5:
        return MAT73
    if head.startswith(b"MATLAB 5.0") or (len(head) >= 128 and head[126:128] in (b"IM", b"MI")):
        return MAT
    if head[:8] == HDF5:
        return HDF5_FILE
    if len(head) >= 512 and head[1] == 0x50 and head[0] < 0x20:
        return C3D
    return _kind_of_text(head)


def _kind_of_text(head: bytes) -> str | None:
    if not head or b"\0" in head:
        return None
    text = head.decode("utf-8-sig", errors="replace")
    first = next((line for line in text.splitlines() if line.strip()), "")
    if first.startswith("PathFileType"):
        return TRC
    if DFLOW_HEADER.match(first) and not MANIPULATOR.search(first):
        return DFLOW
    if DELSYS_HEADER.search(text) or (first.startswith("Label:") and "Sampling frequency" in first):
        return DELSYS
    if text.lstrip()[:1] in ("{", "["):
        return JSON
    return TABLE if re.search(r"[\t;,]", first) else None


def ending_of(path: str | Path) -> str:
    """Ending of a file's name in lower case, without the ending of gzip."""
    suffixes = [suffix.lower() for suffix in Path(path).suffixes]
    return "".join((suffixes[:-1] if suffixes[-1:] == [".gz"] else suffixes)[-1:])
