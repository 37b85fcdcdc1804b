"""Places in a module where one small change makes a mutant.

Docstrings, type hints, messages of errors, decorators and defaults of arguments are left alone. A place is
known by its function, not by its line, so that it is found again after the function has moved.
"""

import ast
import hashlib
import re
from collections import Counter, defaultdict
from dataclasses import dataclass

OPERATORS = ("arithmetic", "comparison", "constant", "sign", "boundary", "dropped not")
OPERATORS += ("dropped refusal", "swapped arguments", "unit")
ARITHMETIC = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.FloorDiv: ("//", "*"),
    ast.Mod: ("%", "*"),
    ast.Pow: ("**", "*"),
}
OPPOSITE = {
    ast.Lt: ("<", ">="),
    ast.LtE: ("<=", ">"),
    ast.Gt: (">", "<="),
    ast.GtE: (">=", "<"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
    ast.Is: ("is", "is not"),
    ast.IsNot: ("is not", "is"),
    ast.In: ("in", "not in"),
    ast.NotIn: ("not in", "in"),
}
WITH_EQUALITY = {ast.Lt: ("<", "<="), ast.LtE: ("<=", "<"), ast.Gt: (">", ">="), ast.GtE: (">=", ">")}
UNIT_FACTORS = {1e-6, 1e-3, 1e-2, 10, 60, 100, 180, 360, 1e3, 3600, 1e6}
TOLERANCE = 1e-6  # smaller constants are tolerances of solvers
# calls whose first two arguments commute, or whose exchange is no fault that anyone makes
COMMUTATIVE = re.compile(
    "add|allclose|array_equal|getattr|hasattr|hypot|isclose|isinstance|issubclass|logical_and|logical_or|max|"
    "maximum|min|minimum|multiply|setattr|strict_zip|zip"
)
REFUSAL = re.compile(r"_?(check|refuse)(_|$)")


@dataclass(frozen=True)
class Site:
    """One small change of a module: bytes ``start`` to ``stop`` become ``new``.

    ``ordinal`` counts the places of one operator in one function: "2/5" is the second of five.
    ``fingerprint`` stands for the code of the function, without its name and docstring.
    """

    function: str
    operator: str
    ordinal: str
    fingerprint: str
    before: str
    after: str
    line: int
    start: int
    stop: int
    new: str


def mutated(source: str, site: Site) -> str:
    """Return the source with the change of one site."""
    code = source.encode()
    return (code[: site.start] + site.new.encode() + code[site.stop :]).decode()


def sites(source: str) -> list[Site]:
    """Return the places of a module where a mutant can be made, in the order of the source."""
    walk = _Walk(source)
    walk.visit(ast.parse(source))
    counts = Counter((name, print_, operator) for name, print_, operator, *_ in walk.places)
    seen = defaultdict(int)
    complete = []
    for name, print_, operator, *rest in walk.places:
        key = (name, print_, operator)
        seen[key] += 1
        complete.append(Site(name, operator, f"{seen[key]}/{counts[key]}", print_, *rest))
    return complete


def _fingerprint(node: ast.AST) -> str:
    parts = [node]
    if isinstance(node, ast.FunctionDef):
        parts = [node.args, *node.body[ast.get_docstring(node) is not None :]]
    return hashlib.sha256("".join(map(ast.dump, parts)).encode()).hexdigest()[:8]


def _number(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and type(node.value) in (int, float) and node.value != 0


def _counts(node: ast.AST) -> bool:
    """Recognise whole numbers, for which < and <= differ."""
    if isinstance(node, ast.Call):
        return isinstance(node.func, ast.Name) and node.func.id in ("len", "sum")
    if isinstance(node, ast.Subscript):
        return isinstance(node.value, ast.Attribute) and node.value.attr == "shape"
    if isinstance(node, ast.Attribute):
        return node.attr in ("size", "ndim", "start", "stop")
    return isinstance(node, ast.Constant) and type(node.value) is int


def _text_or_list(node: ast.AST) -> bool:
    literal = ast.JoinedStr | ast.List | ast.ListComp | ast.Tuple
    return isinstance(node, literal) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


class _Walk(ast.NodeVisitor):
    def __init__(self, source: str):
        self.code = source.encode()
        self.lines = [0]
        for line in self.code.splitlines(keepends=True):
            self.lines.append(self.lines[-1] + len(line))
        self.names: list[str] = []
        self.fingerprint = ""
        self.places: list[tuple] = []

    def _span(self, node: ast.AST) -> tuple[int, int]:
        start = self.lines[node.lineno - 1] + node.col_offset
        return start, self.lines[node.end_lineno - 1] + node.end_col_offset

    def _add(self, operator: str, shown: ast.AST, start: int, stop: int, new: str) -> None:
        """Note a change of bytes ``start`` to ``stop``; the expression ``shown`` is quoted in tables."""
        if not self.fingerprint:
            return
        first, last = self._span(shown)
        before = self.code[first:last].decode()
        after = (self.code[first:start] + new.encode() + self.code[stop:last]).decode()
        quoted = [" ".join(text.split()) for text in (before, after)]
        name = ".".join(self.names)
        self.places.append((name, self.fingerprint, operator, *quoted, shown.lineno, start, stop, new))

    def _between(self, operator: str, shown: ast.AST, left: ast.AST, right: ast.AST, signs: tuple) -> None:
        """Exchange the operator that stands between two expressions."""
        start, stop = self._span(left)[1], self._span(right)[0]
        gap = self.code[start:stop].decode()
        if signs[0] in gap and "#" not in gap:
            self._add(operator, shown, start, stop, gap.replace(*signs, 1))

    def _constant(self, shown: ast.AST, node: ast.AST, factor: bool = False) -> None:
        if not _number(node):
            return
        if factor and abs(node.value) in UNIT_FACTORS:
            self._add("unit", shown, *self._span(node), repr(node.value * 10))
        elif abs(node.value) > TOLERANCE:
            whole = type(node.value) is int
            self._add("constant", shown, *self._span(node), repr(node.value + 1 if whole else 2 * node.value))

    def _inside(self, name: str, node: ast.AST, parts: list[ast.AST]) -> None:
        outer, self.fingerprint = self.fingerprint, _fingerprint(node)
        self.names.append(name)
        for part in parts:
            self.visit(part)
        self.names.pop()
        self.fingerprint = outer

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        self._inside(node.name, node, node.body)

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        self.names.append(node.name)
        for part in node.body:
            self.visit(part)
        self.names.pop()

    def visit_Assign(self, node: ast.Assign) -> None:
        """Go on; a constant of the module counts as a function of its name."""
        target = node.targets[0]
        if self.fingerprint or not isinstance(target, ast.Name):
            self.generic_visit(node)
        elif target.id != "__all__":
            outer, self.fingerprint = self.fingerprint, _fingerprint(node.value)
            self.names.append(target.id)
            self._constant(node, node.value)
            self.visit(node.value)
            self.names.pop()
            self.fingerprint = outer

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """Leave texts alone."""

    def visit_Raise(self, node: ast.Raise) -> None:
        if node.exc is not None:
            self._add("dropped refusal", node, *self._span(node), "pass")

    def visit_Expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Call) and REFUSAL.match(_name(node.value)):
            self._add("dropped refusal", node, *self._span(node), "pass")
        self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        if not (_text_or_list(node.left) or _text_or_list(node.right)):
            signs = ARITHMETIC.get(type(node.op))
            if signs:
                self._between("arithmetic", node, node.left, node.right, signs)
                for side in (node.left, node.right):
                    self._constant(node, side, isinstance(node.op, ast.Mult | ast.Div))
        self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        signs = ARITHMETIC.get(type(node.op))
        if signs and not _text_or_list(node.value):
            self._between("arithmetic", node, node.target, node.value, signs)
            self._constant(node, node.value, isinstance(node.op, ast.Mult | ast.Div))
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        sides = [node.left, *node.comparators]
        for left, sign, right in zip(sides, node.ops, sides[1:], strict=False):
            self._between("comparison", node, left, right, OPPOSITE[type(sign)])
            if type(sign) in WITH_EQUALITY and (_counts(left) or _counts(right)):
                self._between("boundary", node, left, right, WITH_EQUALITY[type(sign)])
        for side in sides:
            self._constant(node, side)
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        start, stop = self._span(node)
        if isinstance(node.op, ast.Not):
            self._add("dropped not", node, start, stop, self.code[start + 3 : stop].decode().lstrip())
        elif isinstance(node.op, ast.USub):
            self._add("sign", node, start, stop, self.code[start + 1 : stop].decode().lstrip())
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        if len(node.args) > 1 and not COMMUTATIVE.fullmatch(_name(node)):
            first, second = node.args[:2]
            kinds = {type(first), type(second)}
            plain = kinds.isdisjoint({ast.Constant, ast.Starred, ast.JoinedStr})
            if plain and ast.dump(first) != ast.dump(second):
                (start, end), (begin, stop) = self._span(first), self._span(second)
                texts = (self.code[begin:stop], self.code[end:begin], self.code[start:end])
                self._add("swapped arguments", node, start, stop, b"".join(texts).decode())
        self.generic_visit(node)

    def visit_keyword(self, node: ast.keyword) -> None:
        if node.arg != "axis":  # of two axes, 1 and -1 are the same
            self.visit(node.value)

    def visit_Slice(self, node: ast.Slice) -> None:
        for limit in (node.lower, node.upper):
            number = limit.operand if isinstance(limit, ast.UnaryOp) else limit
            if number is not None and _number(number):
                self._add("boundary", node, *self._span(number), repr(number.value + 1))
        self.generic_visit(node)


def _name(call: ast.Call) -> str:
    return getattr(call.func, "attr", getattr(call.func, "id", ""))
