"""Kinds of files by their first bytes, whatever the file is called."""

import gzip

import pytest

from tepsipe.io.readers import file_kind
from tepsipe.io.readers.file_kind import ending_of, kind_of

EDF_HEAD = b"0       " + b" " * 244 + b"1   "
HEADS = [
    (b"\xffBIOSEMI", file_kind.BDF_FILE),
    (EDF_HEAD, file_kind.EDF_FILE),
    (EDF_HEAD[:-1], None),
    (b"0       " + b" " * 248, None),
    (b"MATLAB 7.3 MAT-file", file_kind.MAT73),
    (b" " * 512 + b"\x89HDF\r\n\x1a\n", file_kind.MAT73),
    (b"MATLAB 5.0 MAT-file", file_kind.MAT),
    (b"M" * 126 + b"IM", file_kind.MAT),
    (b"M" * 126 + b"I", None),
    (b"\x89HDF\r\n\x1a\n", file_kind.HDF5_FILE),
    (b"\x02\x50" + bytes(510), file_kind.C3D),
    (b"\x02\x50" + bytes(509), None),
    (b"\x20\x50" + bytes(510), None),
    (b"PathFileType\t4", file_kind.TRC),
    (b"TimeStamp\tFrameNumber\tFP1.ForX\n", file_kind.DFLOW),
    (b"Time\tFrameNumber\tMotorAngle\n", file_kind.TABLE),
    (b"X[s],EMG\n", file_kind.DELSYS),
    (b"Label: a Sampling frequency: 2000\n", file_kind.DELSYS),
    (b'\n {"rate": 1}', file_kind.JSON),
    (b"time;force\n", file_kind.TABLE),
    (b"time force\n", None),
    (b"time,\0force\n", None),
    (b"", None),
]


@pytest.mark.parametrize(("head", "kind"), HEADS)
def test_kind_is_known_by_the_first_bytes_also_of_a_compressed_file(head, kind, tmp_path):
    (tmp_path / "plain").write_bytes(head)
    assert kind_of(tmp_path / "plain") == kind
    (tmp_path / "packed").write_bytes(gzip.compress(head))
    assert kind_of(tmp_path / "packed") == kind


@pytest.mark.parametrize(
    ("name", "ending"),
    [
        ("a.C3D", ".c3d"),
        ("a.c3d.gz", ".c3d"),
        ("walk.2024.txt", ".txt"),
        ("walk.2024.txt.GZ", ".txt"),
        ("a", ""),
    ],
)
def test_ending_is_that_before_gzip(name, ending):
    assert ending_of(name) == ending
