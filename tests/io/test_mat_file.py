"""MATLAB files of version 7.3 are read as those of version 5."""

import gzip
import shutil

import h5py
import numpy as np
import pytest
from builders import assert_one_sentence
from mat73_builders import write_mat73
from scipy.io import loadmat, savemat

from tepsipe.errors import InputError
from tepsipe.io.formats import contents_of
from tepsipe.io.readers.mat_file import read_mat
from tepsipe.io.readers.treadmill_log import read_treadmill_log


@pytest.fixture(scope="module")
def same_log(dummy_files, tmp_path_factory):
    """The dummy's log as MATLAB 7.3."""
    content = loadmat(dummy_files["log"])
    names = [str(np.squeeze(name)) for name in np.ravel(content["channel_names"])]
    variables = {k: v for k, v in content.items() if not k.startswith("__")} | {"channel_names": names}
    path = tmp_path_factory.mktemp("mat73") / "log.mat"
    write_mat73(path, variables)
    return path


def test_same_log_is_identical_in_both_versions(dummy_files, same_log):
    old, new = read_treadmill_log(dummy_files["log"]), read_treadmill_log(same_log)
    assert (old.rate_hz, old.channels) == (new.rate_hz, new.channels)
    for name in ("voltages", "belt_velocity", "command", "trigger"):
        a, b = getattr(old, name), getattr(new, name)
        assert a.dtype == b.dtype
        assert np.array_equal(a, b), name


def test_compressed_log_is_identical(dummy_files, same_log, tmp_path):
    for path in (dummy_files["log"], same_log):
        packed = tmp_path / f"{path.stem}.mat.gz"
        packed.write_bytes(gzip.compress(path.read_bytes(), compresslevel=1))
        assert np.array_equal(read_treadmill_log(packed).voltages, read_treadmill_log(path).voltages)


def test_text_cells_structures_and_empty_variables(tmp_path):
    path = tmp_path / "x.mat"
    write_mat73(
        path,
        {
            "matrix": np.arange(6.0).reshape(2, 3),
            "text": "belt",
            "nothing": "",
            "cells": ["a", np.array([1.0, 2.0]), ["b"]],
            "structure": {"mass_kg": 70.0, "name": "P1"},
            "flags": np.array([[True, False]]),
        },
    )
    found = read_mat(path, "a file")
    assert np.array_equal(found["matrix"], [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]])
    assert (found["text"], found["nothing"]) == ("belt", "")
    assert found["cells"].shape == (1, 3)
    assert found["cells"][0, 0] == "a"
    assert found["cells"][0, 1].tolist() == [[1.0, 2.0]]
    assert found["cells"][0, 2][0, 0] == "b"
    assert found["structure"]["name"] == "P1"
    assert found["structure"]["mass_kg"].item() == 70.0
    assert found["flags"].dtype == bool


def test_info_knows_both_versions(dummy_files, same_log):
    old, new = contents_of(dummy_files["log"]), contents_of(same_log)
    assert old.kind == new.kind == "MATLAB"
    shown = {c.name: (c.shape, c.rate_hz, c.low, c.high) for c in new.channels if "names" not in c.name}
    assert shown == {
        c.name: (c.shape, c.rate_hz, c.low, c.high) for c in old.channels if "names" not in c.name
    }


def test_log_in_a_structure(dummy_files, same_log, tmp_path):
    content = {k: v for k, v in loadmat(dummy_files["log"]).items() if not k.startswith("__")}
    names = [str(np.squeeze(name)) for name in np.ravel(content["channel_names"])]
    savemat(tmp_path / "old.mat", {"run": content})
    write_mat73(tmp_path / "new.mat", {"run": content | {"channel_names": names}})
    expected = read_treadmill_log(same_log)
    for name in ("old.mat", "new.mat"):
        found = read_treadmill_log(tmp_path / name)
        assert found.channels == expected.channels
        assert np.array_equal(found.voltages, expected.voltages)
        assert found.rate_hz == expected.rate_hz


def test_files_of_other_programs_without_matlabs_attributes(same_log, tmp_path):
    path = tmp_path / "plain.mat"
    with h5py.File(same_log, "r") as old, h5py.File(path, "w") as new:
        for name in old:
            old.copy(name, new, expand_refs=True)
        cells = new["channel_names"]
        for row in range(cells.shape[0]):
            cells[row, 0] = new[f"#refs#/channel_names_{row}"].ref
        new.visititems(lambda _, item: [item.attrs.__delitem__(key) for key in list(item.attrs)] and None)
    found = read_treadmill_log(path)
    assert found.channels == read_treadmill_log(same_log).channels
    assert contents_of(path).kind == "MATLAB"


def test_string_array_is_refused_with_what_to_do(same_log, tmp_path):
    path = tmp_path / "log.mat"
    shutil.copy(same_log, path)
    with h5py.File(path, "r+") as file:
        del file["channel_names"]
        strings = file.create_dataset("channel_names", data=np.zeros((6, 1), dtype="u4"))
        strings.attrs["MATLAB_class"] = np.bytes_("string")
        strings.attrs["MATLAB_object_decode"] = np.int32(3)
    with pytest.raises(InputError, match="save cellstr") as caught:
        read_treadmill_log(path)
    assert_one_sentence(caught.value, path)


@pytest.mark.parametrize("keep", [400, 600, 5000, -200])
def test_truncated_file_is_refused(same_log, tmp_path, keep):
    path = tmp_path / "cut.mat"
    path.write_bytes(same_log.read_bytes()[:keep])
    with pytest.raises(InputError) as caught:
        read_treadmill_log(path)
    assert_one_sentence(caught.value, path)


def test_missing_variable_is_named(same_log, tmp_path):
    path = tmp_path / "log.mat"
    write_mat73(path, {"sample_rate_hz": 1000.0, "transducers_V": np.ones((5, 2))})
    with pytest.raises(InputError, match=r"found 'sample_rate_hz', 'transducers_V'") as caught:
        read_treadmill_log(path)
    assert_one_sentence(caught.value, path)


def test_structures_within_structures_without_end_are_refused(same_log, tmp_path):
    path = tmp_path / "deep.mat"
    shutil.copy(same_log, path)
    with h5py.File(path, "r+") as file:
        file.create_group("/".join("a" * 20))
    with pytest.raises(InputError) as caught:
        read_mat(path, "a log")
    assert_one_sentence(caught.value, path)
