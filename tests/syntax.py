"""Syntax of the project's modules, parsed once for all tests of a process."""

import ast
from functools import cache


@cache
def syntax(path):
    return ast.parse(path.read_text(encoding="utf-8"), str(path))


@cache
def nodes(path):
    """All nodes of a module."""
    return tuple(ast.walk(syntax(path)))


@cache
def imports(path, at_import_only=False):
    """Import statements of a module; those inside functions run later, those for type checkers never."""
    if not at_import_only:
        return tuple(node for node in nodes(path) if isinstance(node, ast.Import | ast.ImportFrom))
    found, waiting = [], list(syntax(path).body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Import | ast.ImportFrom):
            found.append(node)
        elif isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            waiting += node.orelse
        elif not isinstance(node, ast.expr | ast.FunctionDef | ast.AsyncFunctionDef):
            waiting += ast.iter_child_nodes(node)
    return tuple(found)
