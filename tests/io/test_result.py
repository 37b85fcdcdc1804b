"""Results of an analysis survive their file, and a damaged file is refused."""

import copy
import os
import pickle

import h5py
import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.io.readers.guarded import FORKS
from tepsipe.io.result import Result, read_hdf5, read_result, write_result


def test_result_comes_back_from_its_file_with_units_and_facts(tmp_path, rng):
    arrays = {"leg/torque": rng.standard_normal(500), "matrix": rng.standard_normal((3, 3)) + 1j}
    facts = {"converged": True, "names": ["a", "b"], "spread_Nm": 0.25}
    write_result(tmp_path / "r.h5", Result(arrays, {"leg/torque": "Nm", "matrix": "rad/Nm"}, facts))
    read = read_result(tmp_path / "r.h5")
    assert set(read.arrays) == set(arrays)
    for name, values in arrays.items():
        assert (read.arrays[name] == values).all()
    assert read.units == {"leg/torque": "Nm", "matrix": "rad/Nm"}
    assert read.facts == facts


def test_equal_arrays_are_stored_once_and_read_by_every_name(tmp_path, rng):
    values, units = rng.standard_normal((2000, 3)), {"a/x": "m", "b/x": "m", "c/x": "rad", "d/x": "m"}
    arrays = {"a/x": values, "b/x": values.copy(), "c/x": values, "d/x": values + 1e-15}
    write_result(tmp_path / "r.h5", Result(arrays, units, {}))
    with h5py.File(tmp_path / "r.h5") as file:
        assert file["a/x"] == file["b/x"]  # the same dataset; units or values of the others differ
        assert len({file[name].id.__hash__() for name in arrays}) == 3
    read = read_result(tmp_path / "r.h5")
    assert read.units == units
    assert all((read.arrays[name] == array).all() for name, array in arrays.items())


def test_a_result_is_that_of_its_file_when_it_was_read_and_can_be_altered_and_copied(tmp_path):
    path = tmp_path / "r.h5"
    written = {"a/x": np.arange(3.0), "a/b/y": np.ones(2), "z": np.zeros(1)}
    write_result(path, Result(written, dict.fromkeys(written, "s"), {}))
    read = read_result(path)
    path.write_bytes(b"another file")
    read.arrays["a/x"][0] = 7.0
    read.arrays["new"] = read.arrays.pop("z")
    for own in (read, pickle.loads(pickle.dumps(read)), copy.deepcopy(read)):
        assert list(own.arrays) == ["a/b/y", "a/x", "new"] and "z" not in own.arrays
        assert [values.tolist() for values in own.arrays.values()] == [[1.0, 1.0], [7.0, 1.0, 2.0], [0.0]]


def test_result_file_that_is_damaged_is_refused(tmp_path):
    write_result(tmp_path / "r.h5", Result({"x": np.ones(500)}, {"x": "s"}, {}))
    content = (tmp_path / "r.h5").read_bytes()
    for part in (0.0, 0.3, 0.9):
        (tmp_path / "cut.h5").write_bytes(content[: int(part * len(content))])
        with pytest.raises(InputError) as caught:
            read_result(tmp_path / "cut.h5")
        assert_one_sentence(caught.value, tmp_path / "cut.h5")


def flipped(path, place):
    content = bytearray(path.read_bytes())
    content[place] ^= 1
    path.write_bytes(content)


def copied(path):
    with h5py.File(path) as old, h5py.File(path.with_name("new.h5"), "w") as new:
        old.copy("x", new)
    path.with_name("new.h5").replace(path)


def marked(path):
    with h5py.File(path, "a") as file:
        file.attrs["facts"] = "[]"


@pytest.mark.skipif(not FORKS, reason="files are read directly on this system")
@pytest.mark.parametrize(
    "change",
    [
        *(lambda path, place=place: flipped(path, place) for place in (0, 2000, -49, -48, -32, -1)),
        *(lambda path, end=end: path.write_bytes(path.read_bytes()[:end]) for end in (0, 20, -48, -1)),
        lambda path: path.write_bytes(path.read_bytes() + b"\0"),
        copied,
        marked,
    ],
)
def test_only_a_file_that_is_as_it_was_written_is_read_in_this_process(tmp_path, change):
    path = tmp_path / "r.h5"
    write_result(path, Result({"x": np.ones(500)}, {"x": "s"}, {}))
    for wanted in (True, False):
        assert (read_hdf5(lambda path: os.getpid(), path, "a file") == os.getpid()) is wanted
        change(path)
