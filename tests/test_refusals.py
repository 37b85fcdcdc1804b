"""Every refusal of the library and of the workflow has the same form: expected, found, what to do."""

import ast
from pathlib import Path

from syntax import nodes

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


def refusals(path):
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
        for line, text in refusals(path):
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
