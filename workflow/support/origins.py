"""Origins of the figures and tables of a report: rule, script, function and data, read from the sources.

Nothing is listed by hand: rules name the files that they make and the function ``draw_...`` that draws them,
which calls the function of every figure, and chapters name the tables that they read.
"""

import ast
import os
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path

from tepsipe.experiments.registry import EXPERIMENTS
from tepsipe.reporting.report_page import Origin
from workflow.support.captions import caption_of, group_of
from workflow.support.places import place_of

RULE = re.compile(r"^(?:use )?rule (\w+)(?: as (\w+) with)?:\n((?:[ \t#].*\n|\n)*)", re.MULTILINE)
LOOPED = re.compile(r"^    rule:\n((?:        .*\n|\n)*)", re.MULTILINE)
READS = re.compile(r'\b(?:where|rows-of|column|thesis-blocks)(?:\.with)?\(\s*"(\w+)"')
OF_ESTIMATES = re.compile(r"\b(estimates|recovery)\(")
EXPERIMENT = re.compile(r'\bexperiment: "(\w+)"|\bestimates(?:\.with)?\(\s*"(\w+)"')
FACTS = re.compile(r"\b(numbers-of|holds|data\.facts|data\.choices|data\.study)\b")
STRING_OR_BRACKET = re.compile(r'"(?:[^"\\]|\\.)*"|[([{)\]}\n]')
DEFINITION = re.compile(r"^[ \t]*#let (?:([\w-]+)|\(([\w, .-]+)\))", re.MULTILINE)
IMPORT = re.compile(r'^#import "([\w./]+)"(?: as (\w+))?', re.MULTILINE)


@dataclass(frozen=True)
class Rule:
    """A rule of the workflow: its name, ``place`` (path and line), ``script`` and text."""

    name: str
    place: str
    script: str
    text: str

    @property
    def outputs(self) -> str:
        """Text of its outputs."""
        return self.text.partition("output:")[2].partition("log:")[0]

    @cached_property
    def made(self) -> list[re.Pattern]:
        """Patterns of the files ``<results>/...`` that it makes."""
        named = re.findall(r'"(<results>/[^"]+)"', self.outputs)
        return [re.compile(re.sub(r"\\{\w+\\}", ".+", re.escape(name))) for name in named]

    @property
    def drawn_by(self) -> tuple[str, str] | None:
        """Module and function that draw the figures of a plotting rule."""
        drawn = re.search(r'drawn_by="([\w.]+):(\w+)"', self.text)
        return (f"tepsipe/{drawn[1].replace('.', '/')}.py", drawn[2]) if drawn else None


class Sources:
    """Sources of the project below a folder."""

    def __init__(self, root: str | Path, kind: str | None = None):
        """``kind`` is that of a study with rules of its own."""
        self.root = Path(root)
        files = sorted(self.root.glob("workflow/rules/*.smk"))
        if kind:
            files.insert(0, self.root / f"workflow/studies/{kind}.smk")
        self.rules = [rule for path in files for rule in self._rules_of(path)]
        self.looped, self.fits = (
            self._looped(self.root / "workflow/rules/experiments.smk", verb) for verb in ("plot", "fit")
        )

    def _rules_of(self, path: Path) -> list[Rule]:
        content = path.read_text(encoding="utf-8")
        found = []
        for match in RULE.finditer(content):
            script = re.search(r'script:\s*"([^"]+)"', match[3])
            place = f"{path.relative_to(self.root).as_posix()}:{content.count(chr(10), 0, match.start()) + 1}"
            name = match[2] or match[1]
            where = f"workflow/scripts/{script[1].rpartition('/')[2]}" if script else ""
            found.append(Rule(name, place, where, match[3]))
        return found

    def _looped(self, path: Path, verb: str) -> Rule | None:
        """The rule, ``plot`` or ``fit``, that a loop over experiments makes, with ``{_name}`` for theirs."""
        content = path.read_text(encoding="utf-8") if path.is_file() else ""
        for match in LOOPED.finditer(content):
            if f'"{verb}_{{_name}}"' in match[1]:
                line = content.count("\n", 0, match.start()) + 1
                place = f"{path.relative_to(self.root).as_posix()}:{line}"
                text = match[1].replace('f"', '"')
                return Rule(f"{verb}_{{_name}}", place, f"workflow/scripts/{verb}.py", text)
        return None

    def rule_of_figure(self, figure: str) -> Rule | None:
        """The rule that draws a figure: it names the figure, or the experiment or part with its caption."""
        for wanted in (f'"{figure}"', f'"{caption_of(figure)}"', f'figure_files("{group_of(figure)}")'):
            for rule in self.rules:
                if wanted in rule.text:
                    return rule
        name = group_of(figure)
        if self.looped and Path(place_of(f"tepsipe/experiments/{name}/figures.py", self.root)).is_file():
            filled = [text.replace("{_name}", name) for text in (self.looped.name, self.looped.text)]
            return replace(self.looped, name=filled[0], text=filled[1])
        return None

    def rule_of_table(self, table: str) -> Rule | None:
        """The rule that writes a table of the run."""
        for rule in self.rules:
            if f"/{table}.csv" in rule.outputs:
                return rule
            limits = re.search(r'wildcard_constraints:\s+table="([^"]+)"', rule.text)
            if "/{table}.csv" in rule.outputs and limits and re.fullmatch(limits[1], table):
                return rule
        return None

    def rule_of_rows(self, file: str) -> Rule | None:
        """The rule that makes a file of rows, ``<results>/...``, which other rules join into a table."""
        for rule in self.rules:
            if any(pattern.fullmatch(file) for pattern in rule.made):
                return rule
        name = file.split("/")[2]
        return replace(self.fits, name=f"fit_{name}") if self.fits and name in EXPERIMENTS else None

    def code_of_rows(self, files: Iterable[str]) -> list[tuple[str, str]]:
        """Rules of files of rows with their scripts and functions, each rule once."""
        code = []
        for rule in dict.fromkeys(filter(None, map(self.rule_of_rows, files))):
            if self.fits and rule.place == self.fits.place:
                module = EXPERIMENTS[rule.name.removeprefix("fit_")].module("fit")
                module = f"{module.replace('.', '/')}.py"
                code += [("Rule", f"{rule.name} ({rule.place})"), ("Script", rule.script)]
                code.append(("Function", self._place_of(module, "fit")))
            else:
                code += self.code_of_table(rule)
        return code

    def code_of_figure(self, figure: str, rule: Rule) -> list[tuple[str, str]]:
        """Rule, script and function of a figure, each with its place."""
        code = [("Rule", f"{rule.name} ({rule.place})"), ("Script", rule.script)]
        drawings = _read(self.root / "report/drawings.typ")
        drawing = re.search(rf"^#let {figure}\(", drawings, re.MULTILINE)
        module, draw = rule.drawn_by or ("", "")
        file = Path(place_of(module, self.root))
        function = _drawing_function(file, draw, caption_of(figure)) if draw else None
        if drawing:
            line = drawings.count("\n", 0, drawing.start()) + 1
            code.append(("Function", f"{figure} (report/drawings.typ:{line})"))
        elif function:
            code.append(("Function", self._place_of(module, function)))
        return code

    def code_of_table(self, rule: Rule) -> list[tuple[str, str]]:
        """Rule and script of a table, and the functions of the library that the script calls."""
        code = [("Rule", f"{rule.name} ({rule.place})"), ("Script", rule.script)]
        text = (self.root / rule.script).read_text(encoding="utf-8")
        for module, names in re.findall(r"^from (tepsipe[\w.]+) import (\([^)]*\)|.*)$", text, re.MULTILINE):
            if module.startswith("tepsipe.io."):
                continue
            for name in re.findall(r"\b[a-z]\w+", names):
                place = self._place_of(module.replace(".", "/") + ".py", name)
                if place and re.search(rf"(?<!import )\b{name}\(", text):
                    code.append(("Function", place))
        return code

    def functions(self, origins: Iterable[Origin]) -> dict[str, str]:
        """Place of every function that origins name -> its source."""
        places = dict.fromkeys(
            place for origin in origins for what, place in origin.code if what == "Function"
        )
        return {place: self._source_at(*re.search(r"\((.+):(\d+)\)$", place).groups()) for place in places}

    def _source_at(self, path: str, line: str) -> str:
        """Source of the function that begins at a line."""
        text = _read(Path(place_of(path, self.root)))
        start = sum(map(len, text.splitlines(keepends=True)[: int(line) - 1]))
        if path.endswith(".typ"):  # its other lines are indented, the last one closes its brackets
            return re.match(r"#let .*(?:\n(?:[ \t].*)?(?=\n))*(?:\n[)}\]].*)?", text[start:])[0].rstrip()
        node = next(node for node in ast.walk(_tree(text)) if getattr(node, "lineno", 0) == int(line))
        # as ast.get_source_segment, which splits the whole text for every function
        lines = text[start:].splitlines(keepends=True)[: node.end_lineno - node.lineno + 1]
        lines[-1] = lines[-1].encode()[: node.end_col_offset].decode()
        return "".join(lines)

    def _place_of(self, module: str, name: str) -> str:
        """Name of a function of a module, or of one that it imports from, with path and line."""
        file = Path(place_of(module, self.root))
        if not file.is_file():
            return ""
        text = file.read_text(encoding="utf-8")
        found = re.search(rf"^def {name}\(", text, re.MULTILINE)
        if found:
            return f"{name} ({module}:{text.count(chr(10), 0, found.start()) + 1})"
        source = re.search(
            rf"^from (tepsipe[\w.]+) import (?:\([^)]*\b{name}\b|.*\b{name}\b)", text, re.MULTILINE
        )
        return self._place_of(source[1].replace(".", "/") + ".py", name) if source else ""


@cache
def _tree(text: str) -> ast.Module:
    return ast.parse(text)


@cache
def function_of(module: Path, name: str) -> ast.FunctionDef:
    """A function of a module, as syntax."""
    tree = _tree(_read(module))
    return next(node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == name)


def _drawing_function(module: Path, name: str, figure: str) -> str | None:
    """Name of the function that the ``draw_...`` of a rule calls for a figure."""
    draw = function_of(module, name)
    assigned = {
        target.id: node.value
        for node in ast.walk(draw)
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    for node in ast.walk(draw):
        if (
            isinstance(node, ast.Yield)
            and isinstance(node.value, ast.Tuple)
            and _is_name(node.value.elts[0], figure)
        ):
            call = node.value.elts[1]
            call = assigned.get(call.id, call) if isinstance(call, ast.Name) else call
            if isinstance(call, ast.Call):
                return ast.unparse(call.func)
    return None


def _is_name(node: ast.expr, figure: str) -> bool:
    """A text, or a text with parts in braces, is the name of a figure."""
    if isinstance(node, ast.Constant):
        return node.value == figure
    if isinstance(node, ast.JoinedStr):
        parts = (re.escape(p.value) if isinstance(p, ast.Constant) else ".+" for p in node.values)
        return re.fullmatch("".join(parts), figure) is not None
    return False


def command(target: str, rules: Iterable[str], configfiles: Iterable[str]) -> str:
    """Command that makes a file again by these rules, although it is up to date."""
    own = " ".join(configfiles)
    return f"snakemake -c1 {target} --forcerun {' '.join(rules)}" + (f" --configfile {own}" if own else "")


def repository_at(root: str | Path, commit: str | None) -> str:
    """Address of the sources at a commit; empty without a commit, or while the project names none."""
    project = Path(root) / "pyproject.toml"
    if not commit or not project.is_file():
        return ""
    address = tomllib.loads(project.read_text(encoding="utf-8"))["project"].get("urls", {}).get("Repository")
    return f"{address}/blob/{commit}" if address else ""


def study_command(configfiles: Iterable[str]) -> str:
    """Command that runs a whole study."""
    return " ".join(["snakemake -c2", *(["--configfile", *configfiles] if configfiles else [])])


# ---- tables of the report


@dataclass(frozen=True)
class Chapter:
    """A source of the report: its path below ``report/``, and its text."""

    folder: Path
    name: str

    @property
    def text(self) -> str:
        """Text of the source."""
        return _read(self.folder / self.name)

    def tables_read(self, label: str | None = None) -> tuple[list[str], int]:
        """Tables that the source reads for what has a label, or at all; and the line of that in the source.

        Names that the part of the source uses are followed to their definitions, here and in what it imports.
        """
        found = self._figure_with(label) if label is not None else None
        start, stop = found or (0, len(self.text))
        definitions = self._definitions(start if found else stop)
        return _reads(self.text[start:stop], definitions), self.text.count("\n", 0, start) + 1

    def experiments_read(self, label: str | None = None) -> list[str]:
        """Experiments whose rows the source reads for what has a label, or at all, as `tables_read`."""
        start, stop = (self._figure_with(label) if label is not None else None) or (0, len(self.text))
        return _reads(self.text[start:stop], self._definitions(stop if label is None else start), 1)

    @property
    def labels(self) -> list[str]:
        """Labels that the source gives."""
        return re.findall(r"<([A-Za-z][\w-]*)>", self.text)

    def _figure_with(self, label: str) -> tuple[int, int] | None:
        end = self.text.find(f"<{label}>")
        start = self.text.rfind("#figure(", 0, end)
        if start < 0:
            start = self.text.rfind("figure(", 0, end)
        return (start, end) if 0 <= start < end else None

    def _definitions(self, before: int) -> dict[str, str]:
        found: dict[str, str] = {}
        for name, renamed in IMPORT.findall(self.text):
            if Path(name).stem not in ("data", "format", "style"):
                path = (self.folder / self.name).parent / name
                found |= {
                    (f"{renamed}.{own}" if renamed else own): t
                    for own, t in _definitions(_read(path)).items()
                }
        return found | _definitions(self.text, before)


@cache
def _read(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@cache
def _definitions(text: str, before: int | None = None) -> dict[str, str]:
    """Name of what a source defines, up to a place -> the text of its last definition."""
    found = {}
    for match in DEFINITION.finditer(text, 0, len(text) if before is None else before):
        found |= dict.fromkeys(re.findall(r"[\w-]+", match[1] or match[2]), _statement(text, match.start()))
    return found


def _statement(text: str, start: int) -> str:
    """Text of a statement: to the end of the line in which all brackets outside of strings are closed."""
    depth = 0
    for found in STRING_OR_BRACKET.finditer(text, start):
        depth += (found[0] in "([{") - (found[0] in ")]}")
        if depth <= 0 and found[0] == "\n":
            return text[start : found.start()]
    return text[start:]


def _reads(part: str, definitions: dict[str, str], what: int = 0) -> list[str]:
    """Tables, or experiments (``what`` of `_used`), of a part of a source and of what it uses."""
    waiting, seen, found = [part], set(), {}
    while waiting:
        *read, names = _used(waiting.pop(0))
        found |= read[what]
        for name in (name for both in names for name in both if name in definitions):
            if name not in seen:
                seen.add(name)
                waiting.append(definitions[name])
    return list(found)


@cache
def _used(text: str) -> tuple[dict[str, None], dict[str, None], list[set[str]]]:
    """Tables and experiments that a text reads, and its names, each also without what follows its dot."""
    tables = dict.fromkeys(READS.findall(text) + OF_ESTIMATES.findall(text))
    if FACTS.search(text):
        tables["report"] = None
    experiments = dict.fromkeys(one or other for one, other in EXPERIMENT.findall(text))
    return tables, experiments, [set(pair) for pair in re.findall(r"(([A-Za-z_][\w-]*)(?:\.[\w-]+)?)", text)]


def chapters_of(folder: str | Path, names: Iterable[str], main: str) -> list[Chapter]:
    """Chapters of a report among the names of its sources: those with figures or tables of their own."""
    own = (main, "several_joints.typ", "study_values.typ")
    return [Chapter(Path(folder), name) for name in names if name.startswith("chapters/") or name in own]


# ---- origins of a report


@dataclass(frozen=True)
class ReportOrigins:
    """Origins of all that a report shows.

    Attributes
    ----------
    sources : Sources
        Sources of the project.
    page : str
        File of the report's page, to whose folder links are relative.
    tables : mapping of str to str
        Name of a table that the report reads -> its file.
    data, written_by : str
        File with the numbers of the report, and the rule that writes it.
    configfiles : sequence of str
        Further configuration files of the run.
    joined : mapping of str to mapping
        Name of a table that joins rows -> experiment -> files of its rows.
    """

    sources: Sources
    page: str
    tables: Mapping[str, str]
    data: str
    written_by: str
    configfiles: Sequence[str] = ()
    joined: Mapping[str, Mapping[str, Sequence[str]]] = field(default_factory=dict)

    def beside(self, path: str | Path) -> str:
        """A file as seen from the folder of the page."""
        return Path(os.path.relpath(path, Path(self.page).parent)).as_posix()

    def of_report(
        self,
        figures: Mapping[str, str],
        chapters: Iterable[Chapter],
        parts: Mapping[str, tuple[str, Sequence[str]]],
    ) -> dict[str, Origin]:
        """Origins by anchor or source: of figures (drawing -> its numbers), of tables, of parts of the page.

        The rule of the page makes a part by a function from tables, which are given by their names.
        """
        found = {Path(path).stem: self._of_figure(path, numbers) for path, numbers in figures.items()}
        for chapter in chapters:
            found[chapter.name] = self._of_tables(chapter)
            for label in chapter.labels:
                if label not in found:
                    found[label] = self._of_tables(chapter, label)
        return found | {part: self._of_part(*given) for part, given in parts.items()}

    def _again(self, targets: Iterable[str], rules: Iterable[str]) -> str:
        return command(" ".join(targets), rules, self.configfiles)

    def _files(self, names: Iterable[str]) -> dict[str, str]:
        return {f"{name}.csv": self.beside(self.tables[name]) for name in names if self._made(name)}

    def _made(self, name: str) -> bool:
        """Whether a table is among the results, which may be moved; others are kept with the project."""
        return name in self.tables and not self.beside(self.tables[name]).startswith("../../")

    def _of_figure(self, path: str, numbers: str) -> Origin:
        """Files, code and command of a figure (SVG) with its numbers (CSV)."""
        name = Path(path).stem
        rule = self.sources.rule_of_figure(name)
        kinds = {f"{name}.{kind}": Path(path).with_suffix(f".{kind}") for kind in ("csv", "svg")}
        data = {words: self.beside(file) for words, file in kinds.items()}
        if Path(numbers).read_text(encoding="utf-8").count("\n") < 2:
            del data[f"{name}.csv"]  # a drawing without numbers, which rests on the settings
            data["config.yaml"] = "../config.yaml"
        return Origin(data, self.sources.code_of_figure(name, rule), self._again([path], [rule.name]))

    def _of_tables(self, chapter: Chapter, label: str | None = None) -> Origin:
        """Files, code and command of a table of the report, or of all tables of a chapter."""
        names, line = chapter.tables_read(label)
        names = names or chapter.tables_read()[0]
        found = {name: self.sources.rule_of_table(name) for name in names if name in self.tables}
        rules = {name: rule for name, rule in found.items() if rule}
        code = [("Typeset by", f"report/{chapter.name}:{line}")]
        shown = chapter.experiments_read(label)
        for rule, name in {rule: name for name, rule in rules.items()}.items():
            code += self._code_of(name, rule, shown)
        kept = [name for name in names if name in self.tables and not self._made(name)]
        code += [("Kept data", os.path.relpath(self.tables[name], self.sources.root)) for name in kept]
        data = self._files(names)
        targets = [self.tables[name] for name in rules]
        forced = [rule.name for rule in dict.fromkeys(rules.values())]
        if "report" in names or not data:
            data[Path(self.data).name] = self.beside(self.data)
            code.append(("Numbers filled in by", f"tepsipe/reporting/chapters/ ({self.written_by})"))
            targets, forced = [*targets, self.data], [*forced, self.written_by]
        return Origin(data, list(dict.fromkeys(code)), self._again(targets, forced))

    def _code_of(self, table: str, rule: Rule, experiments: Sequence[str]) -> list[tuple[str, str]]:
        """Code of a table; of one that joins rows, the code that makes the rows of the experiments shown."""
        rows = self.joined.get(table, {})
        shown = rows.keys() & {*experiments} or rows.keys()
        code = self.sources.code_of_rows(
            file for name, files in rows.items() if name in shown for file in files
        )
        joined = [*code, ("Joined by", f"{rule.name} ({rule.place})")]
        return joined if code else self.sources.code_of_table(rule)

    def _of_part(self, function: str, names: Sequence[str]) -> Origin:
        """Files, code and command of a part that only the page has."""
        rule = next(rule for rule in self.sources.rules if rule.name == "write_index")
        code = [
            (what, place)
            for what, place in self.sources.code_of_table(rule)
            if what != "Function" or place.startswith(f"{function} (")
        ]
        return Origin(self._files(names), code, self._again([self.page], [rule.name]))
