"""The report says which mechanisms of the laboratory are on and what was drawn."""

import copy
import re

import pytest
import yaml
from typst_builders import REPORT, evaluated

from tepsipe.reporting.laboratory import INFERRED_CONSTANTS, LABORATORY_ROWS, MECHANISMS, laboratory_rows
from workflow.support.checked_study import checked_sections

EVERYTHING = ["wristalyzer", "dummy", "weight", "standing"]


@pytest.fixture(scope="module")
def truth(root):
    return checked_sections({"study": {"virtual_lab": str(root / "config/virtual_lab.yaml")}}, "virtual_lab")


@pytest.fixture
def told(tmp_path):
    """Mechanisms that are on and off, and drawn constants, as the report shows them."""

    def rows(truth):
        LABORATORY_ROWS.write(tmp_path / "laboratory.csv", laboratory_rows(truth, EVERYTHING))
        asked = ["mechanisms()", "mechanisms(on: false)", "drawn-constants()"]
        found = evaluated(asked, "laboratory_values.typ", {}, {"laboratory": tmp_path / "laboratory.csv"})
        return dict(zip(("on", "off", "drawn"), found, strict=True))

    return rows


def test_every_mechanism_is_a_constant_of_the_shipped_laboratory(truth):
    rows = [row for row in laboratory_rows(truth, EVERYTHING) if row.kind == "mechanism"]
    assert [row.key for row in rows] == [mechanism.key for mechanism in MECHANISMS]
    assert len({row.name for row in rows}) == len(rows)


def test_table_returns_what_was_written(truth, tmp_path):
    rows = laboratory_rows(truth, EVERYTHING)
    LABORATORY_ROWS.write(tmp_path / "laboratory.csv", rows)
    found = LABORATORY_ROWS.read(tmp_path / "laboratory.csv")
    assert [(row.kind, row.key, row.name, row.distribution) for row in found] == [
        (row.kind, row.key, row.name, row.distribution) for row in rows
    ]
    for row, written in zip(found, rows, strict=True):
        assert row.value == pytest.approx(written.value, rel=1e-9)
        assert row.nominal == (None if written.nominal is None else pytest.approx(written.nominal, rel=1e-9))


def test_report_tells_what_is_on_from_what_is_off(truth, told):
    changed = copy.deepcopy(truth)
    changed["treadmill"]["plate"] |= {"friction_lever_m": 0.0, "second_share": [0.0, 0.3]}
    changed["dummy"]["slip"]["foot_m"] = 0.001
    found = told(changed)
    off = {row["key"] for row in found["off"]}
    on = {row["key"]: row["value"] for row in found["on"]}
    assert "treadmill.plate.friction_lever_m" in off
    assert on["treadmill.plate.second_share"] == "0, 0.3"
    assert on["dummy.slip.foot_m"] == "0.001"


def test_numbers_of_one_list_are_one_row_with_the_largest_deviation(truth, told):
    rows = told(truth)["drawn"]
    leg = [row for row in rows if row["key"] == "dummy.markers.leg_m"]
    alike = [(row["count"], row["nominal"], row["standard-deviation"]) for row in leg]
    assert alike == [(4, "", "0.0001"), (4, "", "0.0005")]
    own = [n for n in truth["drawn_numbers"] if n["path"].startswith("dummy.markers.leg_m.")]
    largest = max((n["value"] - n["nominal"] for n in own[1::2]), key=abs)
    assert float(leg[1]["largest"].replace("\N{MINUS SIGN}", "-")) == pytest.approx(largest, rel=5e-3)
    found = {row["key"]: row for row in rows}
    mass = found["dummy.subject.leg_mass_kg"]
    assert mass["nominal"] == "0.4"
    # digits by the standard deviation of the draw, 4.3 g
    assert mass["value"] == f"{truth['dummy']['subject']['leg_mass_kg']:.4f}"


def test_constants_are_told_in_words_and_units(truth, told):
    found = told(truth)
    rows = [*found["on"], *found["off"], *found["drawn"]]
    named = [(row.get("measure", row["name"]), row["unit"]) for row in rows]
    assert all("_" not in word + unit and word for word, unit in named)
    # every constant that may be drawn or switched has its own words
    words = yaml.safe_load((REPORT / "laboratory.yaml").read_text(encoding="utf-8"))
    told_apart = [row for row in laboratory_rows(truth, EVERYTHING) if row.kind not in ("inferred", "true")]
    keys = {re.sub(r"(\.\d+)+$", "", row.key) for row in told_apart}
    assert keys <= {*words["measures"], *words["drawn"]}
    by_key = {row["key"]: row for row in rows}
    assert by_key["dummy.subject.leg_inertia_kgm2"]["unit"] == "kg·m²"
    assert by_key["standing.skin.slip_m_per_rad"]["unit"] == "m/rad"
    axis = [row["name"] for row in found["drawn"] if row["key"] == "standing.markers.joint_centre_m"]
    assert [name.rpartition(", ")[2] for name in axis] == ["forwards", "upwards"]


def test_every_drawn_number_is_in_the_table_of_a_whole_study(truth):
    found = [row.key for row in laboratory_rows(truth, EVERYTHING) if row.kind == "drawn"]
    assert found == [number["path"] for number in truth["drawn_numbers"]]


def test_a_study_of_the_manipulator_says_nothing_of_the_treadmill(truth):
    own = {key: truth[key] for key in ("wristalyzer", "drawn_numbers")}
    keys = [row.key for row in laboratory_rows(own, ["wristalyzer"])]
    assert keys
    assert all(key.startswith("wristalyzer.") for key in keys)
    assert evaluated(["mechanisms()", "drawn-constants()"], "laboratory_values.typ") == [[], []]


def test_inferred_constants_are_told_with_their_values_and_counted_in_the_decision(truth, root, tmp_path):
    LABORATORY_ROWS.write(tmp_path / "laboratory.csv", laboratory_rows(truth, EVERYTHING))
    tables = {"laboratory": tmp_path / "laboratory.csv"}
    (rows,) = evaluated(["inferred-constants()"], "laboratory_values.typ", {}, tables)
    words = yaml.safe_load((REPORT / "laboratory.yaml").read_text(encoding="utf-8"))["inferred"]
    assert [row["key"] for row in rows] == list(INFERRED_CONSTANTS)
    assert set(words) == set(INFERRED_CONSTANTS)
    values = {row["key"]: (row["value"], row["unit"]) for row in rows}
    rubber = truth["dummy"]["rubber"]
    assert values["dummy.rubber.damping_Nms_per_rad"] == (str(rubber["damping_Nms_per_rad"]), "N·m·s/rad")
    # heights of the markers, without what was drawn
    assert values["dummy.markers.leg_m"] == ("0.60, 0.50, 0.40, 0.30", "m")
    decision = (root / "docs/decisions/0046-dummy-of-the-thesis.md").read_text(encoding="utf-8")
    (before, now) = re.search(r"\| all \| (\d+) \| (\d+) \|", decision).groups()
    assert sum(row["free"] for row in rows) == int(now) <= int(before)
