"""The operators of the mutants, their identity without lines, and the tests that they meet."""

import pytest

from benchmarks.mutants import run
from benchmarks.mutants.sites import mutated, sites

SOURCE = '''"""Gain 2 * 3."""

__all__ = ["gain" + "s"]
GRAVITY = 9.81


def gain(x: "2 * 3", limit=2 * 3) -> "2 * 3":
    """Gain 2 * 3."""
    if not x.size > 1 or limit is None:
        raise InputError(f"{2 * 3}" + str(2 * 3))
    _refuse_short(x)
    y: "2 * 3" = 1000.0 * mix(x, limit[1:], axis=-1)  # θ is not ASCII
    return -y + max(x, y)
'''
CHANGES = [
    ("GRAVITY", "constant", "GRAVITY = 9.81", "GRAVITY = 19.62"),
    ("gain", "dropped not", "not x.size > 1", "x.size > 1"),
    ("gain", "comparison", "x.size > 1", "x.size <= 1"),
    ("gain", "boundary", "x.size > 1", "x.size >= 1"),
    ("gain", "constant", "x.size > 1", "x.size > 2"),
    ("gain", "comparison", "limit is None", "limit is not None"),
    ("gain", "dropped refusal", 'raise InputError(f"{2 * 3}" + str(2 * 3))', "pass"),
    ("gain", "dropped refusal", "_refuse_short(x)", "pass"),
    (
        "gain",
        "arithmetic",
        "1000.0 * mix(x, limit[1:], axis=-1)",
        "1000.0 / mix(x, limit[1:], axis=-1)",
    ),
    ("gain", "unit", "1000.0 * mix(x, limit[1:], axis=-1)", "10000.0 * mix(x, limit[1:], axis=-1)"),
    ("gain", "swapped arguments", "mix(x, limit[1:], axis=-1)", "mix(limit[1:], x, axis=-1)"),
    ("gain", "boundary", "1:", "2:"),
    ("gain", "arithmetic", "-y + max(x, y)", "-y - max(x, y)"),
    ("gain", "sign", "-y", "y"),
]


def test_every_operator_changes_code_and_neither_texts_nor_hints_nor_messages():
    found = sites(SOURCE)
    assert [(site.function, site.operator, site.before, site.after) for site in found] == CHANGES
    assert {site.operator for site in found} == set(run.OPERATORS)


def test_a_mutant_is_the_source_with_one_place_changed():
    for site in sites(SOURCE):
        lines, changed = SOURCE.splitlines(), mutated(SOURCE, site).splitlines()
        differ = [k for k, (line, other) in enumerate(zip(lines, changed, strict=True)) if line != other]
        assert differ == [site.line - 1]


def library(folder, modules):
    for name, source in modules.items():
        path = folder / "tepsipe" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(source, encoding="utf-8")
    return run.all_mutants(folder)


def test_mutants_are_found_again_after_a_move_and_a_new_name(tmp_path):
    before = library(tmp_path / "before", {"signals/filters.py": SOURCE})
    code = SOURCE.replace("def gain(", "def amplification(").replace("GRAVITY", "\n\nGRAVITY")
    moved = library(tmp_path / "moved", {"signals/inner/other.py": code})
    for mutant in before:
        again = run.find(mutant.row(), moved)
        assert again.path == "tepsipe/signals/inner/other.py"
        assert (again.site.operator, again.site.ordinal) == (mutant.site.operator, mutant.site.ordinal)


def test_a_changed_function_is_found_by_its_name_and_a_lost_one_is_said(tmp_path):
    before = library(tmp_path / "before", {"signals/filters.py": SOURCE})
    (negative,) = [mutant for mutant in before if mutant.site.operator == "sign"]
    changed = library(tmp_path / "changed", {"signals/a.py": SOURCE.replace("x.size > 1", "x.size > 7")})
    assert run.find(negative.row(), changed).site.before == "-y"
    gone = library(
        tmp_path / "gone", {"signals/a.py": SOURCE.replace("def gain(", "def loss(").replace("-y", "y")}
    )
    assert run.find(negative.row(), gone) == "function not found"


def test_a_draw_is_repeated_by_its_seed_and_begins_a_longer_one(tmp_path):
    mutants = library(tmp_path, {f"{package}/a.py": SOURCE for package in run.PACKAGES})
    few, many = run.draw(mutants, 14, seed=1), run.draw(mutants, 28, seed=1)
    assert few == many[:14] != run.draw(mutants, 14, seed=2)
    assert len(set(many)) == 28
    assert {mutant.package for mutant in few} == set(run.PACKAGES)
    assert {mutant.site.operator for mutant in many} == set(run.OPERATORS)


@pytest.mark.parametrize("mirrored", [True, False])
def test_tests_of_the_mutated_module_come_first(tmp_path, mirrored):
    (tmp_path / "tepsipe").mkdir()
    (tmp_path / "tepsipe/__init__.py").write_text('_PUBLIC = {"lowpass": "tepsipe.signals.filters"}')
    folder = tmp_path / "tests" / ("signals" if mirrored else "")
    folder.mkdir(parents=True)
    (folder / "test_a.py").write_text("from tepsipe.signals import spectra")
    (folder / "test_b.py").write_text("from tepsipe import lowpass")
    (tmp_path / "tests/test_other.py").write_text("import tepsipe.signalling")
    names = [file.rsplit("/", 1)[1] for file in run.tests_of(tmp_path, "signals", "tepsipe.signals.filters")]
    assert names == ["test_b.py", "test_a.py"]
