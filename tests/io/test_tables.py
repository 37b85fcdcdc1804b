"""Typed tables: every kind of column comes back, and what no table holds is refused in one sentence."""

import math
from dataclasses import dataclass, field

import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.io.formats import read_all_markers
from tepsipe.io.tables import NO_COLUMN, Table, Undefinable, write_records


@dataclass(frozen=True)
class Thing:
    name: str
    count: int
    length_m: float
    width_m: Undefinable
    sound: bool
    numbers: tuple[float, ...]
    mass_kg: float | None = None
    heavy: bool | None = None
    about: dict = field(default_factory=dict, metadata=NO_COLUMN)


def refuse_negative(thing):
    if thing.count < 0:
        raise ValueError("fewer than nothing")


THINGS = Table(Thing, "things", check=refuse_negative, further=("place",))
ROWS = [
    Thing('a, "b"', 3, 1.0 / 3.0, 2.0, True, (1.0, -math.inf), 1e12, False),
    Thing("0.20", 0, math.inf, math.nan, False, (), about={"not": "a column"}),
]
TEXT = (
    "name,count,length_m,width_m,sound,numbers,mass_kg,heavy\n"
    '"a, ""b""",3,0.3333333333,2,true,1 -inf,1e+12,false\n'
    "0.20,0,inf,,false,,,\n"
)


def test_every_kind_of_column_comes_back(tmp_path):
    path = tmp_path / "things.csv"
    THINGS.write(path, ROWS)
    assert path.read_bytes() == TEXT.encode()
    first, second = THINGS.read(path)
    assert first == Thing('a, "b"', 3, 0.3333333333, 2.0, True, (1.0, -math.inf), 1e12, False)
    assert (second.name, second.length_m, second.mass_kg, second.heavy) == ("0.20", math.inf, None, None)
    assert math.isnan(second.width_m) and second.numbers == () and second.about == {}
    assert len(THINGS.read(path, path)) == 4 and THINGS.read() == []


def test_columns_may_be_left_out_or_follow(tmp_path):
    path = tmp_path / "things.csv"
    THINGS.write(path, ROWS, without=("mass_kg", "heavy"), further={"place": ["here", "there"]})
    head, first, second = path.read_text().splitlines()
    assert head == "name,count,length_m,width_m,sound,numbers,place"
    assert first.endswith(",here") and second.endswith(",there")
    THINGS.write(path, ROWS, further={"place": ["here", "there"]})
    assert [thing.name for thing in THINGS.read(path)] == ['a, "b"', "0.20"]


def test_rows_are_completed_before_they_are_written(tmp_path):
    path = tmp_path / "things.csv"
    renamed = Table(Thing, "things", complete=lambda thing: Thing("x", *list(vars(thing).values())[1:]))
    renamed.write(path, ROWS)
    assert [thing.name for thing in THINGS.read(path)] == ["x", "x"]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (",3,", ",3.5,", "3.5"),
        (",3,", ",,", "damaged row"),
        (",3,", ",-1,", "fewer than nothing"),
        ("0.3333333333", "", "damaged row"),
        (",true,", ",yes,", "'yes' in the column sound"),
        (",1e+12,false", ",1e+12,no", "'no' in the column heavy"),
        ("1 -inf", "1 and 2", "and"),
        (",1e+12,false", ",1e+12", "too many or too few cells"),
        (",1e+12,false", ",1e+12,false,5", "too many or too few cells"),
        ("mass_kg,heavy", "heavy,mass_kg", "expected the columns name, count"),
        ("mass_kg,heavy", "mass_kg,heavy,colour", "'colour'"),
        ("0.20,0,inf,,false,,,\n", "0.20,0,inf,,false,,,", "truncated"),
    ],
)
def test_damaged_table_is_refused_in_one_sentence(old, new, words, tmp_path):
    path = tmp_path / "things.csv"
    assert old in TEXT
    path.write_text(TEXT.replace(old, new))
    with pytest.raises(InputError) as caught:
        THINGS.read(path)
    assert_one_sentence(caught.value, path, words)


def test_records_are_written_below_their_keys(tmp_path):
    path = tmp_path / "records.csv"
    write_records(path, [{"a": 1.0 / 3.0, "b": None}, {"b": "x", "a": 2}])
    assert path.read_text() == "a,b\n0.3333333333,\n2,x\n"


def test_a_table_without_markers_cannot_give_them(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time (s),belt (m/s)\n" + "".join(f"{k / 100:.2f},0.{k % 10}\n" for k in range(50)))
    with pytest.raises(InputError) as caught:
        read_all_markers(path)
    assert_one_sentence(caught.value, path, "columns of markers", "belt")
