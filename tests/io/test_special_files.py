"""Pipes, devices, streams and names that are none: one sentence, and no waiting."""

import io
import os
import subprocess
import sys

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.cli import main
from tepsipe.errors import InputError
from tepsipe.io.formats import contents_of, recognised
from tepsipe.io.opensim_export import Storage, write_storage
from tepsipe.io.readers.plain_file import read_text

COLUMNS = ["--time", "t", "--angle", "a", "--torque", "b"]


@pytest.fixture
def pipe(tmp_path):
    path = tmp_path / "pipe.csv"
    os.mkfifo(path)
    return path


@pytest.fixture
def refused(capsys):
    """Sentence of a command that is refused."""

    def run(*arguments):
        assert main(list(map(str, arguments))) == 2
        said = capsys.readouterr().err.removeprefix("tepsipe: ")
        assert said.count("\n") == 1
        return said.strip()

    return run


def test_a_pipe_is_refused_at_once(pipe, refused, tmp_path):
    assert recognised(pipe) is None
    for arguments in (["fit", pipe, *COLUMNS], ["info", pipe], ["calibrate", pipe, pipe], ["export", pipe]):
        extra = ["--to", "mat"] if arguments[0] == "export" else []
        assert_one_sentence(refused(*arguments, *extra), pipe)


@pytest.mark.parametrize("path", ["/dev/zero", "/dev/null", "/dev/random"])
def test_a_device_is_refused_at_once(path, refused):
    with pytest.raises(InputError, match="found a pipe or a device") as caught:
        read_text(path, "a configuration file")
    assert_one_sentence(caught.value, path)
    assert_one_sentence(refused("info", path), path)
    with pytest.raises(InputError, match=path):
        contents_of(path)


def test_links_that_lead_back_to_themselves_are_refused(refused, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop").symlink_to("loop")
    assert_one_sentence(refused("fit", "loop", *COLUMNS), "loop", "leads back to itself")
    assert_one_sentence(refused("info", "loop"), "loop")
    assert_one_sentence(refused("new-study", "loop"), "loop", "folder of recordings")


def test_text_beyond_any_recording_is_not_read(refused, tmp_path):
    path = tmp_path / "huge.csv"
    path.touch()
    os.truncate(path, 2_000_000_000)  # a hole that takes no place
    assert_one_sentence(refused("fit", path, *COLUMNS), "huge.csv", "at most 1000 MB, found 2000 MB")


def test_an_output_without_a_name_is_refused(refused, tmp_path):
    table = tmp_path / "t.csv"
    table.write_text("t,a,b\n0,0,0\n")
    assert "--output" in refused("fit", table, *COLUMNS, "--output", "")


def test_one_column_for_two_signals_is_refused(refused, tmp_path):
    table = tmp_path / "t.csv"
    table.write_text("t,a,b\n0,0,0\n")
    said = refused("fit", table, "--time", "t", "--angle", "a", "--torque", "a")
    assert_one_sentence(said, "t.csv", "'a' for angle and torque", "--torque")


def test_a_folder_is_no_file(tmp_path):
    with pytest.raises(InputError, match="found a folder") as caught:
        read_text(tmp_path, "a trial sheet")
    assert_one_sentence(caught.value, tmp_path)


@pytest.mark.parametrize("name", ["a\nb.csv", "a\rb.csv", "a\x1b[31mb.csv", "a\udcffb.csv"])
def test_a_name_of_several_lines_is_shown_on_one(name, tmp_path, refused):
    path = tmp_path / name
    path.write_bytes(b"t,a\n1,2\n")
    said = refused("fit", path, *COLUMNS)
    assert said.isprintable()
    assert_one_sentence(said, str(tmp_path))


def test_streams_without_the_characters_of_units(tmp_path, monkeypatch):
    ascii_only = [io.TextIOWrapper(io.BytesIO(), encoding="ascii") for _ in range(2)]
    for name, stream in zip(("stdout", "stderr"), ascii_only, strict=True):
        monkeypatch.setattr(sys, name, stream)
    (tmp_path / "übung.csv").write_text("time,Kraft (µN)\n" + "0.0,1\n0.1,2\n0.2,3\n" * 1)
    assert main(["info", str(tmp_path / "übung.csv")]) == 0
    ascii_only[0].flush()
    assert rb"\xfcbung.csv" in ascii_only[0].buffer.getvalue()


def test_a_working_directory_that_was_removed(tmp_path):
    folder = tmp_path / "gone"
    folder.mkdir()
    code = "import os, sys; os.rmdir(os.getcwd()); from tepsipe.cli import main; sys.exit(main(['check']))"
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.startswith("tepsipe: expected a working directory, found that it was removed")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("coordinate", ["", "a\nb", "a\tb", "a b", "a\x0bb"])
def test_a_coordinate_that_breaks_the_header_is_refused(coordinate, tmp_path):
    time = np.arange(3.0)
    path = tmp_path / "a.mot"
    with pytest.raises(InputError, match="names of columns without white space") as caught:
        write_storage(Storage("a.h5", time, {coordinate: time}, True), path)
    assert_one_sentence(caught.value, path)
    assert not path.exists()
    write_storage(Storage("a\nb.h5", time, {"ankle": time}, True), path)
    assert path.read_text().splitlines()[:2] == [r"a\nb.h5", "version=1"]
