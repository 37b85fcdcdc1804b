"""Every refusal has the same form: expected, found, what to do. Refusals that no test reads are found."""

import ast
import os
from pathlib import Path

import pytest
import refusals
from syntax import nodes

from tepsipe import InputError, load_example

ROOT = Path(__file__).parents[1]
MODULES = sorted(path for part in ("tepsipe", "workflow") for path in (ROOT / part).rglob("*.py"))
# "unknown column 'x': did you mean 'y'?" says the same in fewer words
SHORTER = "unknown "


def text_of(node):
    """A message with {...} for what is filled in; None if it is made elsewhere."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
    if isinstance(node, ast.BinOp):
        left, right = text_of(node.left), text_of(node.right)
        return None if left is None or right is None else left + right
    return None


def messages(path):
    """Line and text of every InputError that a module raises with a message of its own."""
    for node in nodes(path):
        call = node.exc if isinstance(node, ast.Raise) else None
        if isinstance(call, ast.Call) and getattr(call.func, "id", "") == "InputError":
            text = text_of(call.args[0])
            if text is not None and text.replace("{}", "").strip(": "):
                yield node.lineno, text


def test_a_refusal_says_expected_found_and_what_to_do():
    count = 0
    for path in MODULES:
        for line, text in messages(path):
            count += 1
            if SHORTER in text:
                continue
            where = f"{path.relative_to(ROOT)}, line {line}: {text}"
            before, _, after = text.rpartition("found")
            started = text.startswith("{}")  # the place, which may hold what was expected
            assert "expected" in before or started, where
            assert ": " in (after or text), where
            assert not text.endswith((".", "!")), where
    assert count > 300


def recorded():
    return Path(os.environ[refusals.FILE]).read_text(encoding="utf-8").splitlines()


def test_a_refusal_is_read_where_its_text_is_taken():
    wanted = "experiments/example.py load_example 1"
    assert wanted in refusals.unread([])
    with pytest.raises(InputError) as caught:
        load_example("dumy")
    assert "did you mean 'dummy'?" in str(caught.value)
    assert wanted not in refusals.unread(recorded())


def test_refusals_are_named_until_a_test_reads_them():
    every = list(refusals.faults([], ()))
    assert len(every) > 600
    assert not list(refusals.faults([], refusals.unread([])))
    assert any(
        "cascade/record.py make_record 2, line" in sentence for sentence in every
    )  # a call of a helper


def test_refusals_that_no_test_reads_are_refusals():
    assert set(refusals.UNREAD) <= refusals.unread([]).keys()
