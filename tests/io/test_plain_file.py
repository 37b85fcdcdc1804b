"""Files compressed with gzip are known by their content and stopped at a size."""

import gzip

import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.io.readers.plain_file import plain_bytes, plain_file, read_text

TEXT = "time,angle\n0,1\n"


@pytest.mark.parametrize("name", ["table.csv.gz", "table.csv"])
def test_compressed_text_is_read_under_any_name(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(gzip.compress(TEXT.encode()))
    assert read_text(path, "a table") == TEXT


def test_plain_text_whose_name_ends_in_gz_is_read(tmp_path):
    path = tmp_path / "table.csv.gz"
    path.write_text(TEXT)
    assert read_text(path, "a table") == TEXT


def test_bomb_is_stopped_at_the_limit(tmp_path):
    path = tmp_path / "bomb.csv.gz"
    path.write_bytes(gzip.compress(b"0" * 5_000_000))
    with pytest.raises(InputError, match="at most 2 MB when unpacked") as caught:
        plain_bytes(path, "a table", largest_bytes=2_000_000)
    assert_one_sentence(caught.value, path)


@pytest.mark.parametrize("keep", [3, 15, -4])
def test_truncated_gzip_is_refused(tmp_path, keep):
    path = tmp_path / "cut.csv.gz"
    path.write_bytes(gzip.compress(TEXT.encode())[:keep])
    with pytest.raises(InputError, match="truncated or damaged") as caught:
        plain_bytes(path, "a table")
    assert_one_sentence(caught.value, path)


def test_plain_file_is_itself_or_an_unpacked_copy_that_is_deleted(tmp_path):
    plain, packed = tmp_path / "x.mat", tmp_path / "x.mat.gz"
    plain.write_bytes(b"abc")
    packed.write_bytes(gzip.compress(b"abc"))
    with plain_file(plain, "a file") as found:
        assert found == plain
    with plain_file(packed, "a file") as found:
        assert found.name == "x.mat"
        assert found.read_bytes() == b"abc"
    assert not found.exists()
