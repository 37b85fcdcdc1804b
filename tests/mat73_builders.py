"""MATLAB 7.3 files as MATLAB writes them: HDF5 behind a text header, dimensions reversed."""

import h5py
import numpy as np


def write_mat73(path, variables):
    """Numbers, text, lists (cells) and dicts (structures), each written as MATLAB 7.3 does."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in variables.items():
            _write(file, file, name, value)
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 .".ljust(124) + b"\0\2IM")


def _write(file, group, name, value):
    if isinstance(value, dict):
        item = group.create_group(name)
        item.attrs["MATLAB_class"] = np.bytes_("struct")
        for key, field in value.items():
            _write(file, item, key, field)
    elif isinstance(value, str):
        characters = np.array([[ord(c)] for c in value] or [0, 0], dtype="u2" if value else "u8")
        item = group.create_dataset(name, data=characters)
        item.attrs["MATLAB_class"] = np.bytes_("char")
        item.attrs["MATLAB_int_decode"] = np.int32(2)
        if not value:
            item.attrs["MATLAB_empty"] = np.uint8(1)
    elif isinstance(value, list):
        cells = np.empty((len(value), 1), dtype=h5py.ref_dtype)  # a row of cells, reversed
        for k, cell in enumerate(value):
            _write(file, file.require_group("#refs#"), f"{name}_{k}", cell)
            cells[k, 0] = file[f"#refs#/{name}_{k}"].ref
        item = group.create_dataset(name, data=cells, dtype=h5py.ref_dtype)
        item.attrs["MATLAB_class"] = np.bytes_("cell")
    else:
        values = np.atleast_2d(value)
        stored = values.astype(np.uint8) if values.dtype == bool else values
        item = group.create_dataset(name, data=stored.T)
        kinds = {"f8": "double", "f4": "single", "b1": "logical", "i4": "int32"}
        item.attrs["MATLAB_class"] = np.bytes_(kinds[values.dtype.str[1:]])
