"""What laboratory and analysis share: declarations of both sides, bound to their sources, and compared."""

import ast
import re

import numpy as np
import pytest
from typst_builders import chapter_words

from tepsipe.identification.likelihood.likelihood import softening_forces
from tepsipe.reporting.forms import (
    DIFFERENT,
    FORMS,
    NONE,
    SAME,
    SHARED,
    SPECIAL,
    WITHOUT,
    how_shared,
    shared_rows,
)
from tepsipe.reporting.laboratory import MECHANISMS
from tepsipe.treadmill.pulse_windows import Bristles, bent
from tepsipe.virtual_lab import forms as laboratory
from tepsipe.virtual_lab.force_plate import bristle_deflection
from tepsipe.virtual_lab.rubber import Rubber

# modules of the laboratory whose equations are no mechanism: a rule of integration
NO_MECHANISM = {"integrate"}


def words(path):
    return " ".join(path.read_text(encoding="utf-8").split())


def test_every_mechanism_of_the_laboratory_has_a_counterpart_or_is_said_to_have_none():
    assert set(laboratory.FORMS) == set(FORMS) | set(WITHOUT)
    assert not set(FORMS) & set(WITHOUT)


@pytest.mark.parametrize("name", laboratory.FORMS)
def test_declared_forms_are_written_in_their_modules(name, root):
    own = laboratory.FORMS[name]
    assert " ".join(own.written.split()) in words(root / f"tepsipe/virtual_lab/{own.module}.py")
    if name in FORMS:
        theirs = FORMS[name]
        path = root / f"{theirs.module.replace('.', '/')}.py"
        assert " ".join(theirs.written.split()) in words(path)


def test_every_module_of_the_laboratory_with_an_equation_declares_a_mechanism(root):
    declared = {form.module for form in laboratory.FORMS.values()}
    for path in (root / "tepsipe/virtual_lab").glob("*.py"):
        head = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        if re.search(r"^ {4}.* = ", head, re.MULTILINE) and path.stem not in NO_MECHANISM:
            assert path.stem in declared, f"{path.stem} states an equation and declares no form"


def test_every_constant_and_mechanism_of_the_laboratory_is_declared(shipped_truth):
    starts = [path for form in laboratory.FORMS.values() for path in form.constants]
    for path in starts:
        place = shipped_truth
        for key in path.split("."):
            assert key in place, path
            place = place[key]
    for mechanism in MECHANISMS:
        assert any(f"{mechanism.key}.".startswith(f"{start}.") for start in starts), mechanism.key


@pytest.mark.parametrize(
    ("ours", "theirs", "expected"),
    [
        (("a", "b"), ("a",), SAME),
        (("a", "b"), ("b",), SPECIAL),
        (("a",), ("c", "a"), SPECIAL),
        (("a", "b"), ("c", "b"), SPECIAL),
        (("a",), ("c",), DIFFERENT),
        (("a",), (), NONE),
    ],
)
def test_forms_are_compared_by_their_equations(ours, theirs, expected):
    assert how_shared(ours, theirs) == expected


def test_table_counts_what_was_drawn_and_keeps_the_sections_of_the_study(tmp_path):
    drawn = ["treadmill.plate.mount_share", "dummy.subject.leg_mass_kg", "dummy.subject.joint_offset_m.0"]
    drawn += ["standing.skin.frequency_hz", "treadmill.plate.mount_share_of_another"]
    rows = shared_rows(laboratory.FORMS, drawn, ["dummy", "treadmill"], 3)
    assert [row.section for row in rows] == sorted(row.section for row in rows)
    found = {row.mechanism: row for row in rows}
    assert set(found) == {n for n, f in laboratory.FORMS.items() if f.section in ("dummy", "treadmill")}
    assert (found["mounts of the deck"].drawn, found["motion of the leg"].drawn) == (1, 2)
    assert found["law of the dummy's joint"].other_forms == 3
    assert sum(row.other_forms for row in rows) == 3
    assert found["vibration of the floor"].analysis == ""
    SHARED.write(tmp_path / "shared.csv", rows)
    assert SHARED.read(tmp_path / "shared.csv") == rows


def test_report_tells_what_is_shared_from_the_declarations(tmp_path):
    rows = shared_rows(laboratory.FORMS, ["treadmill.plate.mount_share"], ["dummy", "treadmill"], 2)
    SHARED.write(tmp_path / "shared.csv", rows)
    tables = {"shared": tmp_path / "shared.csv", "other_laws": "estimator\njoint-likelihood\n"}
    words = chapter_words("laboratory", {}, tables, cells=";")
    counts = [sum(row.shared == how for row in rows) for how in (SAME, SPECIAL, DIFFERENT, NONE)]
    assert f"lists, for each of the {len(rows)} mechanisms, its form in the laboratory" in words
    listed = re.findall(r"(?:equal|both|forms|analysis), (\d+) mechanisms: (.*?)\.", words)
    same, *_, none = listed
    assert [int(n) for n, _ in listed] == counts
    assert "law of the dummy's joint (2 forms)" in same[1] and "mounts of the deck (1 constant)" in same[1]
    assert none[1].endswith("drive of the belt") and "vibration of the floor;" in none[1]
    assert "joints of the dummy with other laws" in words
    alone = chapter_words("laboratory", {}, {"shared": tmp_path / "shared.csv"})
    assert "The same form in both" in alone and "other laws" not in alone


# ---- the same numbers from both codes ------------------------------------------------------------


def shared(name):
    return how_shared(laboratory.FORMS[name].equations, FORMS[name].equations)


def test_the_likelihood_fits_the_very_law_of_the_rubber(shipped_truth):
    assert shared("law of the dummy's joint") == SAME
    law = Rubber(**shipped_truth["dummy"]["rubber"])
    phi, rate = np.linspace(-0.1, 0.1, 41), np.linspace(2.0, -3.0, 41)
    forces = softening_forces(phi, rate, 0.0, law.softening_angle_rad)
    stiffness = law.stiffness_Nm_per_rad
    fitted = stiffness * phi + law.damping_Nms_per_rad * rate
    fitted -= law.softening * stiffness * forces["C"] + law.softened_damping_Nms_per_rad * forces["B_s"]
    assert fitted == pytest.approx(law.moment(phi, rate), abs=1e-15)


def test_bristles_of_both_are_the_same_where_friction_at_rest_has_no_excess():
    assert shared("bristles of the belt") == SPECIAL
    rng = np.random.default_rng(3)
    velocity = np.repeat(rng.normal(0.0, 0.2, 30), 10)
    path = np.concatenate([[0.0], np.cumsum(velocity) / 1000.0])
    ours = bristle_deflection(path, 0.0005)[1:]
    (theirs,) = bent(velocity[None], Bristles(0.0005, 0.0, 1.0), 1000.0)[1]
    assert theirs == pytest.approx(ours, abs=1e-12)
    (excess,) = bent(velocity[None], Bristles(0.0005, 0.5, 0.3), 1000.0)[1]
    assert np.abs(excess - ours).max() > 0.05
