"""Formats of files by their first bytes, whatever the file is called."""

import gzip
import subprocess
import sys

import pytest

from tepsipe.io.file_format import ending_of
from tepsipe.io.formats import MODULES, PURPOSES, formats, modules_for, recognised

EDF_HEAD = b"0       " + b" " * 244 + b"1   "
HEADS = [
    (b"\xffBIOSEMI", "EDF"),
    (EDF_HEAD, "EDF"),
    (EDF_HEAD[:-1], None),
    (b"0       " + b" " * 248, None),
    (b"MATLAB 7.3 MAT-file", "MATLAB"),
    (b" " * 512 + b"\x89HDF\r\n\x1a\n", "MATLAB"),
    (b"MATLAB 5.0 MAT-file", "MATLAB"),
    (b"M" * 126 + b"IM", "MATLAB"),
    (b"M" * 126 + b"I", None),
    (b"\x89HDF\r\n\x1a\n", "HDF5"),
    (b"\x02\x50" + bytes(510), "C3D"),
    (b"\x02\x50" + bytes(509), None),
    (b"\x20\x50" + bytes(510), None),
    (b"PathFileType\t4", "TRC"),
    (b"TimeStamp\tFrameNumber\tFP1.ForX\n", "D-Flow"),
    (b"Time\tFrameNumber\tMotorAngle\n", "a text table"),
    (b"X[s],EMG\n", "Delsys"),
    (b"Label: a Sampling frequency: 2000\n", "Delsys"),
    (b'\n {"rate": 1}', "JSON"),
    (b"time;force\n", "a text table"),
    (b"time force\n", None),
    (b"time,\0force\n", None),
    (b"", None),
]


@pytest.mark.parametrize(("head", "name"), HEADS)
def test_format_is_known_by_the_first_bytes_also_of_a_compressed_file(head, name, tmp_path):
    for file, content in (("plain", head), ("packed", gzip.compress(head))):
        (tmp_path / file).write_bytes(content)
        found = recognised(tmp_path / file)
        assert (found and found.name) == name


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


def test_registry_imports_none_of_the_libraries_that_parse():
    code = "import sys; from tepsipe.io.formats import formats; formats(); print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert not {"ezc3d", "edfio", "h5py", "scipy.io"} & set(loaded.split())


def test_registry_lists_each_module_with_the_purposes_of_its_readers():
    assert {known.contents.__module__ for known in formats()} == set(MODULES)
    for reader, purpose in PURPOSES.items():
        reading = {known.contents.__module__ for known in formats() if getattr(known, reader)}
        assert reading == set(modules_for(purpose))
        assert all(getattr(known, reader) for known in formats(purpose))


def test_reading_markers_of_a_c3d_imports_no_reader_of_electromyograms(tmp_path):
    path = tmp_path / "markers.c3d"
    path.write_bytes(b"\x02\x50" + bytes(510))
    code = f"import sys; from tepsipe.io import formats; formats._recognised_for('markers', {str(path)!r})"
    code += "; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "tepsipe.io.readers.c3d" in loaded.split()
    assert not {"tepsipe.io.readers.edf", "tepsipe.io.readers.emg_table"} & set(loaded.split())
