"""Promises that the code keeps everywhere: who imports whom, units in docstrings, params of scripts."""

import ast
import re
import sys
import textwrap
import tomllib
from functools import cache
from itertools import takewhile
from pathlib import Path

import pytest
from syntax import imports, nodes, syntax

import tepsipe
from tepsipe.experiments.registry import EXPERIMENTS
from tepsipe.io.formats import MODULES as READERS
from tepsipe.io.formats import modules_for
from tepsipe.virtual_lab.registry import RIGS
from workflow.support.imported_files import reached_by

ROOT = Path(__file__).parents[1]
MODULES = sorted((ROOT / "tepsipe").rglob("*.py"))
# what several scripts import: the start of every job, and what reports are made of
SHARED = {"job.py", "typeset.py"}
SCRIPTS = sorted((ROOT / "workflow/scripts").glob("*.py"))
RULE_FILES = sorted([*(ROOT / "workflow/rules").glob("*.smk"), *(ROOT / "workflow/studies").glob("*.smk")])
LABORATORY = "tepsipe.virtual_lab"


def module_name(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def imported(path):
    """Full names of what a module imports, anywhere in it."""
    names = set()
    for node in imports(path):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        else:
            assert not node.level, f"{path} imports relatively"
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names


def within(name, package):
    return name == package or name.startswith(f"{package}.")


# ---- who imports whom --------------------------------------------------------------------------


def test_laboratory_imports_nothing_from_the_analysis():
    laboratory = [path for path in MODULES if within(module_name(path), LABORATORY)]
    assert len(laboratory) > 5
    for path in laboratory:
        for name in imported(path):
            foreign = within(name, "tepsipe") and not within(name, LABORATORY)
            # ranges of values, which say nothing about how they act
            shared = name == "tepsipe" or within(name, "tepsipe.quantities")
            assert not foreign or shared, f"{path} imports {name}"
    assert not any(within(name, "tepsipe") for name in imported(ROOT / "tepsipe/quantities.py"))


def test_analysis_imports_nothing_from_the_laboratory():
    analysis = [path for path in MODULES if not within(module_name(path), LABORATORY)]
    assert len(analysis) > 20
    for path in analysis:
        for name in imported(path):
            assert not within(name, LABORATORY), f"{path} imports {name}"


def test_library_knows_neither_snakemake_nor_the_configuration():
    for path in MODULES:
        for name in imported(path):
            for package in ("snakemake", "yaml", "workflow", "pydantic"):
                assert not within(name, package), f"{path} imports {name}"
        assert "config/" not in path.read_text(encoding="utf-8"), f"{path} names a configuration file"


def test_what_the_library_imports_is_what_it_declares(root):
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]

    def named(requirements):
        return {re.match(r"[\w-]+", name).group().replace("-", "_") for name in requirements}

    extras = project["optional-dependencies"]
    engines = named(extras["pybullet"]) | named(extras["mujoco"])
    packages = {name.partition(".")[0] for path in MODULES for name in imported(path)}
    foreign = packages - set(sys.stdlib_module_names) - {"tepsipe"}
    # imported where they are asked for, with a sentence that says how to install them
    optional = named(extras["notebook"]) | named(extras["completion"])
    assert foreign == named(project["dependencies"]) | engines | optional
    assert engines == {"pybullet", "mujoco"}


# ---- docstrings --------------------------------------------------------------------------------

UNIT = re.compile(
    r"""
    \( (?: [^()]*,\s* )? (?:
        -|%|s|ms|min|Hz|m|mm|m/s2?|rad|rad/s2?|rad/Nm|kg|kg\ ?m2|kgm2|N|Nm|N/V|Nm/V|V|V/s|V/N|Ns/m|s/m
        |s3|1/m|rad2|Nm/rad3?|Nms/rad|Nms2/rad|N/N|1/min|px|dpi
    ) (?: [\s,;:/][^()]* )? \)
    | \b(?: parts\ per\ million | unit | units | unitless | dimensionless | samples? | pixels? | inches | inch
        | radians? | metres? | seconds? | hexadecimal | SHA-256 | normalised )\b
    | \b\d*\s?(?: Hz | Nm/rad | Nms/rad | m/s | N/V | Nm/V )\b
    | \bin\ (?: s | m | mm | V | Hz | rad | Nm ) \b
    """,
    re.VERBOSE,
)


def names_unit(text):
    """Whether a docstring names a unit, typeset (N·m·s²/rad) or as files write it (Nms2/rad)."""
    return UNIT.search(text.translate(str.maketrans({"·": "", "²": "2", "³": "3"})))


@cache
def public_definitions():
    """Name, node and own docstring of every public class, function, method and property."""
    found = []

    def walk(node, prefix):
        for child in node.body:
            if not isinstance(child, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                continue
            if child.name.startswith("_") or "overload" in map(ast.unparse, child.decorator_list):
                continue
            name = f"{prefix}.{child.name}"
            found.append((name, child, ast.get_docstring(child)))
            if isinstance(child, ast.ClassDef):
                walk(child, name)

    for path in MODULES:
        walk(syntax(path), module_name(path))
    return found


def test_every_module_says_what_it_is():
    silent = [str(path) for path in MODULES if not ast.get_docstring(syntax(path))]
    assert silent == []


def test_every_public_name_has_a_docstring():
    definitions = public_definitions()
    assert len(definitions) > 120
    assert [name for name, _, text in definitions if not text] == []


PUBLIC = {f"{module}.{name}" for name, module in tepsipe._PUBLIC.items()}


def test_docstrings_of_the_public_functions_name_units():
    asked = [
        (name, text) for name, node, text in public_definitions() if name in PUBLIC and has_numbers(node)
    ]
    assert len(asked) > 15
    assert [name for name, text in asked if not names_unit(text)] == []


def has_numbers(node):
    """A class with fields or methods, or a function with an argument or a result that may be a number."""
    if isinstance(node, ast.ClassDef):
        return len(node.body) > 1
    return "ndarray" in ast.unparse(node.args) or "float" in ast.unparse(node)


def test_pattern_of_a_unit_finds_units_and_does_not_find_words():
    for text in ("Angle (rad).", "VAF (%).", "Count (-).", "Torque (Nm, read).", "B (N·m·s/rad).", "no unit"):
        assert names_unit(text), text
    for text in ("Angle of the leg.", "Names (see below).", "One of (a, b)."):
        assert not names_unit(text), text


def raises_input_error(node):
    """Whether a function itself, not a function inside it, raises InputError."""
    return any(
        isinstance(part, ast.Raise)
        and isinstance(part.exc, ast.Call)
        and getattr(part.exc.func, "id", "") == "InputError"
        for part in ast.walk(node)
    )


def test_public_functions_that_refuse_their_input_say_so():
    refusing = [
        (name, text)
        for name, node, text in public_definitions()
        if name in PUBLIC and not isinstance(node, ast.ClassDef) and raises_input_error(node)
    ]
    assert len(refusing) > 5
    silent = [
        name for name, text in refusing if "\nInputError\n" not in (text or "").partition("Raises\n------")[2]
    ]
    assert silent == []


def test_documented_parameters_are_those_of_the_function():
    wrong = []
    for name, node, text in public_definitions():
        if isinstance(node, ast.ClassDef) or "\nParameters\n---" not in (text or ""):
            continue
        section = re.split(r"\n\w[\w ]*\n-{3,}\n", text.split("\nParameters\n")[1].split("\n", 1)[1])[0]
        headings = re.findall(r"^(\S[^\n:]*?)(?: :[^\n]*)?$", section, re.MULTILINE)
        documented = [part.strip().lstrip("*") for line in headings for part in line.split(",")]
        arguments = node.args
        given = [a.arg for a in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)]
        given += [a.arg for a in (arguments.vararg, arguments.kwarg) if a]
        given = [a for a in given if a not in ("self", "cls")]
        if documented != given:
            wrong.append((name, documented, given))
    assert wrong == []


def test_lines_on_parameters_name_parameters_of_the_function():
    """Docstrings of internal functions explain some parameters, in lines that begin with their names."""
    explained, wrong = 0, []
    for name, node, text in public_definitions():
        if isinstance(node, ast.ClassDef):
            continue
        arguments = node.args
        given = {a.arg for a in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)}
        given |= {a.arg for a in (arguments.vararg, arguments.kwarg) if a}
        paragraph = next((p for p in text.split("\n\n") if re.match(r"\*{0,2}[a-z]\w*(, [*\w]+)*: ", p)), "")
        names = re.findall(r"^(\*{0,2}[a-zA-Z]\w*(?:, [*\w]+)*): ", paragraph, re.MULTILINE)
        named = {part.lstrip("*") for line in names for part in line.split(", ")} - {"Returns"}
        if named & given:
            explained += len(named)
            wrong += [(name, sorted(named - given))] if named - given else []
    assert explained > 100
    assert wrong == []


def annotated_with_text(node):
    """Texts of every ``Annotated[type, text, ...]`` below a node of the syntax."""
    for part in ast.walk(node):
        if isinstance(part, ast.Subscript) and getattr(part.value, "id", "") == "Annotated":
            texts = [e.value for e in part.slice.elts[1:] if isinstance(e, ast.Constant)]
            if texts:
                yield ast.unparse(part.slice.elts[0]), texts


def test_annotations_of_arrays_and_numbers_are_a_shape_and_a_unit():
    """``Annotated[np.ndarray, "(n, 2)", "N·m"]``: the shape in parentheses, then the unit."""
    seen, wrong = 0, []
    for path in MODULES:
        for kind, texts in annotated_with_text(syntax(path)):
            seen += 1
            shape = [t for t in texts[:1] if t.startswith("(") and t.endswith(")")]
            units = [text for text in texts[len(shape) :] if text != "an empty cell is NaN"]  # Undefinable
            known = all(names_unit(f"({unit})") for unit in units)
            if len(units) > 1 or not known or (kind == "float" and shape):
                wrong.append((path.name, kind, texts))
    assert seen > 300
    assert wrong == []


def test_fields_that_are_arrays_have_a_shape_a_unit_or_a_text():
    silent = []
    for path in MODULES:
        for node in nodes(path):
            if not isinstance(node, ast.ClassDef) or node.name.startswith("_"):
                continue
            if "\nAttributes\n---" in (ast.get_docstring(node) or ""):
                continue
            below = [isinstance(after, ast.Expr) for after in node.body[1:]]
            for place, field in enumerate(node.body):
                if isinstance(field, ast.AnnAssign) and ast.unparse(field.annotation) == "np.ndarray":
                    texts = below[place:]
                    # one text may stand below several fields
                    described = any(
                        text and all(isinstance(f, ast.AnnAssign) for f in node.body[place : place + k + 1])
                        for k, text in enumerate(texts)
                    )
                    silent += [] if described else [f"{path.name}: {node.name}.{field.target.id}"]
    assert silent == []


def test_documented_attributes_are_those_of_the_class():
    wrong = []
    for name, node, text in public_definitions():
        if not isinstance(node, ast.ClassDef) or "\nAttributes\n---" not in (text or ""):
            continue
        section = re.split(r"\n\w[\w ]*\n-{3,}\n", text.split("\nAttributes\n")[1].split("\n", 1)[1])[0]
        headings = re.findall(r"^(\S[^\n:]*?)(?: :[^\n]*)?$", section, re.MULTILINE)
        documented = {part.strip() for line in headings for part in line.split(",")}
        fields = {part.target.id for part in node.body if isinstance(part, ast.AnnAssign)}
        if documented != fields:
            wrong.append((name, sorted(documented ^ fields)))
    assert wrong == []


# ---- rules and scripts -------------------------------------------------------------------------


def rules():
    """Rule -> keyword (input, params, ...) -> its text, from every rule file."""
    found = {}
    for path in RULE_FILES:
        text = path.read_text(encoding="utf-8")
        for block in re.split(r"^(?=rule |checkpoint |use rule )", text, flags=re.MULTILINE)[1:]:
            base, name = re.match(r"(?:use rule (\w+) as|\w+) (\w+)(?: with)?:", block).groups()
            # what follows a rule at the margin is not part of it
            block = re.split(r"^(?=\S)", block, flags=re.MULTILINE)[1]
            parts = re.split(r"^    (\w+):\n", block, flags=re.MULTILINE)
            found[name] = found.get(base, LOOPED.get(base, {})) | dict(
                zip(parts[1::2], parts[2::2], strict=True)
            )
    return found | rules_of_pages() | LOOPED


def rules_of_pages():
    """The rules that a loop makes of the table of pages, written out."""
    text = (ROOT / "workflow/rules/pages.smk").read_text(encoding="utf-8")
    table, loop = re.search(r"^PAGES = (\{\n.*?^\})\n.*?^    rule:\n(.*?)^(?=\S)", text, re.M | re.S).groups()
    found, table = {}, ast.parse(table, mode="eval").body
    rows = {key.value: row.elts[1:] for key, row in zip(table.keys, table.values, strict=True)}
    assert rows.keys() <= EXPERIMENTS.keys()
    for experiment in (name for name, known in EXPERIMENTS.items() if known.ingest_reads):
        further = [[k.value for k in part.keys] for part in rows.get(experiment, ())] or [[], []]
        fitted = ["fit", "estimates"] if EXPERIMENTS[experiment].fitted else []
        names = dict(zip(("_files", "_params"), further, strict=True))
        block = textwrap.dedent(loop).replace("**(_fitted if _experiment.fitted else {}),", "**_fitted,")
        for table_of, given in (names | {"_fitted": fitted}).items():
            assert f"**{table_of}," in block
            block = block.replace(f"    **{table_of},\n", "".join(f"    {name}=...,\n" for name in given))
        module = "weight" if experiment == "empty" else experiment
        block = block.replace("{_module}", module)
        parts = re.split(r"^(\w+):\n", block.replace('f"', '"'), flags=re.MULTILINE)
        sections = {k: textwrap.indent(v, "    ") for k, v in zip(parts[1::2], parts[2::2], strict=True)}
        found[f"write_{experiment}_pages"] = sections
    return found


def loop_of(file, script):
    """The rule with a script that a loop makes, as it stands there."""
    text = (ROOT / "workflow/rules" / file).read_text(encoding="utf-8")
    blocks = re.findall(r"^    rule:\n((?:        .*\n|\n)+)", text, re.MULTILINE)
    (block,) = (textwrap.dedent(block) for block in blocks if f"scripts/{script}.py" in block)
    return block


def written_out(block, names, lines):
    """Sections of a rule in a loop for one experiment.

    names: variable of the loop -> its value. lines: begin of a line that gives several names -> these.
    """
    for begin, given in lines.items():
        (line,) = re.findall(rf"^    {re.escape(begin)}.*\n", block, re.MULTILINE)
        path = re.search(r'f("<results>.*?")', line)
        block = block.replace(line, "".join(f"    {name}={path[1] if path else ...},\n" for name in given))
    for variable, value in names.items():
        block = block.replace(f"{{{variable}}}", value)
        block = re.sub(rf"(?<![\w{{]){re.escape(variable)}(?!\w)", f'"{value}"', block)
    block = re.sub(r'\*files_of\("([\w.]+)"\)', lambda m: f'"{m[1].replace(".", "/")}.py"', block)
    parts = re.split(r"^(\w+):\n", block.replace('f"', '"'), flags=re.MULTILINE)
    return {k: textwrap.indent(v, "    ") for k, v in zip(parts[1::2], parts[2::2], strict=True)}


# what loops make of an experiment, each by a module of its folder
PARTS = ("ingest", "fit", "figures")


def looped():
    """Rules that loops over the experiments, and over the rigs of the laboratory, make."""
    found, blocks = {}, {script: loop_of("experiments.smk", script) for script in ("ingest", "fit", "plot")}
    for name, known in EXPERIMENTS.items():
        names = {f'_experiment.module("{part}")': known.module(part) for part in PARTS} | {"_name": name}
        takes = set(known.fit_takes)
        several = {
            "**{key: files": sorted(takes & {"models", "calibrations"}),
            "**{key: f": known.further,
            "**{table: f": ["estimates", *(takes & {"uncertainty"})],
        }
        if known.ingest_reads:
            found[f"ingest_{name}"] = written_out(blocks["ingest"], names, {})
        if known.fitted:
            found[f"fit_{name}"] = written_out(blocks["fit"], names, several)
        if known.drawn_of:
            found[f"plot_{name}"] = written_out(blocks["plot"], names, {"**pick(_results": known.drawn_of})
    for name, rig in RIGS.items():
        several = {"**{kind: f": EXPERIMENTS[name].raw_files, "**_motion": ["motion"] if rig.motion else []}
        block = loop_of("virtual_lab.smk", "make_trial")
        found[f"make_{name}_trial"] = written_out(block, {"_rig.module": rig.module, "_name": name}, several)
    return found


LOOPED = looped()
RULES = rules()


def names_in(section):
    """Names given in a section of a rule, at its own depth of indentation."""
    return set(re.findall(r"^ {8}(\w+)=", section, re.MULTILINE))


def scripted():
    """(rule, its script's syntax) of every rule that has a script."""
    for name, sections in RULES.items():
        if "script" in sections:
            path = re.search(r'"\.\./scripts/(\w+\.py)"', sections["script"]).group(1)
            yield name, ROOT / "workflow/scripts" / path


@cache
def used(path, kind):
    """Names that a script takes from snakemake.<kind>, and whether it takes others by subscript or get.

    A script may give snakemake.<kind> a name of its own, in an assignment. A name that it takes by getattr,
    because not every rule that shares the script has it, is among the names, with a question mark.
    """

    def of_snakemake(node):
        return (
            isinstance(node, ast.Attribute)
            and node.attr == kind
            and isinstance(node.value, ast.Name)
            and node.value.id == "snakemake"
        )

    own_names = set()
    for node in nodes(path):
        if isinstance(node, ast.Assign):
            target, value = node.targets[0], node.value
            several = isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple)
            pairs = zip(target.elts, value.elts, strict=True) if several else [(target, value)]
            own_names |= {t.id for t, v in pairs if of_snakemake(v) and isinstance(t, ast.Name)}
    names, computed = set(), False
    for node in nodes(path):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "getattr":
            if of_snakemake(node.args[0]):
                names.add(f"{node.args[1].value}?")
        elif isinstance(node, ast.Attribute | ast.Subscript):
            owner = node.value
            if not of_snakemake(owner) and not (isinstance(owner, ast.Name) and owner.id in own_names):
                continue
            if isinstance(node, ast.Attribute) and node.attr in ("get", "items"):
                computed = True
            elif isinstance(node, ast.Attribute):
                names.add(node.attr)
            elif isinstance(node.slice, ast.Constant):
                names.add(node.slice.value)
            else:
                computed = True
    return names, computed


# of the scripts that many rules share: param that names the module of a rule, some with its function, and
# where the module is
LOADED = {
    "plot": ("drawn_by", "tepsipe/{}.py"),
    "write_pages": ("composed_by", "tepsipe/{}.py"),
    "ingest": ("module", "{}.py"),
    "fit": ("module", "{}.py"),
    "make_trial": ("made_by", "tepsipe/virtual_lab/{}.py"),
}
# whose functions take inputs and params of the rule themselves
DRAWING = ("plot", "write_pages")


def loaded_by(rule, path):
    """Module and function that a script loads because a param of the rule names them, if it does."""
    if path.stem not in LOADED:
        return None, None
    param, place = LOADED[path.stem]
    module, function = re.search(rf'{param}="([\w.]+):?(\w*)"', RULES[rule]["params"]).groups()
    return place.format(module.replace(".", "/")), function or None


def part_with(module, function):
    """Syntax of a function of a module, and of those to which it hands its files and params on."""
    functions = {node.name: node for node in syntax(ROOT / module).body if isinstance(node, ast.FunctionDef)}
    waiting, found = [function], {}
    while waiting:
        name = waiting.pop()
        found[name] = functions[name]
        for node in ast.walk(functions[name]):
            if isinstance(node, ast.Call) and {"files", "chosen"} & {getattr(a, "id", "") for a in node.args}:
                waiting += {getattr(node.func, "id", "")} & (functions.keys() - found.keys())
    return [node for function in found.values() for node in ast.walk(function)]


def reached(rule, path):
    """Files that the script of a rule reaches, itself or by the module that it loads."""
    starts = [str(path.relative_to(ROOT)), *filter(None, loaded_by(rule, path)[:1])]
    return {*starts[1:], *(file for start in starts for file in reached_by(start, str(ROOT)))}


def read_by(rule, path, kind):
    """Names that the script of a rule reads, itself or by the module that it loads; whether by subscript."""
    names, computed = used(path, kind)
    if path.stem in DRAWING:
        module, function = loaded_by(rule, path)
        of = {"input": "files", "params": "chosen"}[kind]
        found = [node for node in part_with(module, function) if isinstance(node, ast.Attribute)]
        names = names | {node.attr for node in found if getattr(node.value, "id", "") == of}
        if any(node.attr == "choices_of_trial" for node in found):
            names |= {"params": {"title", "trial", "neutral"}, "input": {"truth"}}[kind]
    return names, computed


CASES = [pytest.param(name, path, id=name) for name, path in scripted()]


def test_every_rule_file_was_understood():
    assert len(RULES) >= 15
    for path in RULE_FILES:
        text = path.read_text(encoding="utf-8")
        in_text = len(re.findall(r"^(?:use )?rule ", text, re.MULTILINE))
        own = [name for name in RULES if f"rule {name}:" in text or f" as {name} with:" in text]
        assert len(own) == in_text, path
    for name, sections in RULES.items():
        assert {"input", "output", "log", "script"} <= set(sections), name


def test_every_script_belongs_to_the_rule_of_its_name():
    used_again = {
        name: base
        for path in RULE_FILES
        for base, name in re.findall(r"^use rule (\w+) as (\w+) with:", path.read_text(), re.MULTILINE)
    }
    used_again |= {"write_empty_pages": "write_weight_pages", "fit_foot": "fit"}
    # one rule per experiment, or rig
    for name in LOOPED:
        used_again[name] = re.sub(r"^(make)_\w+(_trial)$|^(ingest|fit)_\w+$", r"\1\2\3", name)
    used_again = {name: used_again.get(base, base) for name, base in used_again.items()}
    for name, path in scripted():
        wanted = used_again.get(name, name)
        if path.stem == "write_report":
            wanted = re.sub(r"^write_\w+$", "write_report", wanted)
        if path.stem in DRAWING:
            wanted = re.sub(r"^plot_\w+", "plot", re.sub(r"^write_\w+_pages$", "write_pages", wanted))
            module, function = loaded_by(name, path)
            own = Path(module).parent.name if function == "page" else function.removeprefix("draw_")
            assert used_again.get(name, name) in (f"plot_{own}", f"write_{own}_pages")
        assert path.stem == wanted
    assert {path.name for _, path in scripted()} == {p.name for p in SCRIPTS} - SHARED


@pytest.mark.parametrize(("rule", "path"), CASES)
def test_script_reads_exactly_the_params_that_its_rule_gives(rule, path):
    names, computed = read_by(rule, path, "params")
    # contents of recordings are there for Snakemake, which runs the rule again if they change
    assert names == names_in(RULES[rule].get("params", "")) - {"contents"}
    assert not computed


def keys_of_section(module):
    """Keys, joined by dots, that a module takes from ``section``; a computed key ends them."""
    found, inner = set(), set()
    for node in nodes(module):
        keys, part = [], node
        while isinstance(part, ast.Subscript) and id(node) not in inner:
            keys.insert(0, part.slice)
            part = part.value
            inner.add(id(part))
        if getattr(part, "id", "") == "section" and keys:
            constant = takewhile(lambda key: isinstance(key, ast.Constant), keys)
            found.add(".".join(key.value for key in constant))
    return found


def overlap(path, other):
    """Whether two paths of keys are the same as far as both go; * stands for any key."""
    pairs = zip(path.split("."), other.split("."), strict=False)
    return all(key == own or "*" in (key, own) for key, own in pairs)


def picked_sections():
    """(paths of a section, module of the library that takes it): of every ingest and every fit."""
    declared: dict[str, list[str]] = {}
    for known in EXPERIMENTS.values():
        for part, paths in (("ingest", known.ingest_reads), ("fit", known.fit_reads)):
            declared.setdefault(known.module(part), []).extend(paths)
    for name, path in scripted():
        given = re.search(r"^ {8}section=(.*?)(?=^ {8}\w+=|\Z)", RULES[name].get("params", ""), re.M | re.S)
        call = given and re.match(r"(?:lambda w: )?(section_of|pick)\([^,]+,(.*)", given[1], re.S)
        if call and name not in LOOPED:
            own = filter(None, loaded_by(name, path)[:1])
            modules = {*(n for n in imported(path)), *(m.removesuffix(".py").replace("/", ".") for m in own)}
            (module,) = (n for n in modules if re.fullmatch(r"tepsipe\.experiments\.\w+\.fit\w*", n))
            declared.setdefault(module, []).extend(re.findall(r'"([^"]+)"', call[2]))
    for module, paths in declared.items():
        if paths:
            yield pytest.param(paths, ROOT / f"{module.replace('.', '/')}.py", id=module)


SECTIONS = list(picked_sections())


def test_every_ingest_and_every_fit_is_given_a_section():
    parts = {path for path in MODULES if re.fullmatch(r"ingest|fit(_foot|_task)?", path.stem)}
    of_experiments = {path for path in parts if path.parent.parent == ROOT / "tepsipe/experiments"}
    walking = ROOT / "tepsipe/experiments/walking/fit.py"
    assert {case.values[1] for case in SECTIONS} == of_experiments - {walking}


@pytest.mark.parametrize(("paths", "module"), SECTIONS)
def test_ingest_and_fit_read_exactly_the_settings_that_their_rules_pick(paths, module):
    read = keys_of_section(module)
    left_out = {path[1:] for path in paths if path.startswith("-")}
    picked = {path for path in paths if not path.startswith("-")}
    assert not [path for path in read if not any(overlap(path, given) for given in picked)]
    assert not [given for given in picked if not any(overlap(path, given) for path in read)]
    assert not left_out & read


@pytest.mark.parametrize(("rule", "path"), CASES)
def test_script_reads_only_inputs_that_its_rule_names(rule, path):
    names, computed = read_by(rule, path, "input")
    named = names_in(RULES[rule]["input"])
    assert {name for name in names if not name.endswith("?")} <= named
    assert not computed
    names = {name.removesuffix("?") for name in names}
    # what is not read is there to re-run the rule: raw files are named by a param
    assert named - names <= {"library", "raw", "source", "config", "outputs"}


@pytest.mark.parametrize(("rule", "path"), CASES)
def test_script_writes_exactly_the_outputs_that_its_rule_names(rule, path):
    names, computed = used(path, "output")
    section = RULES[rule]["output"]
    if path.stem == "plot":
        assert "**" in section
        assert computed
        assert names_in(section) == names == set()
    elif path.stem == "make_trial":
        experiment = "dummy" if rule in UNDER_LAWS else rule.removeprefix("make_").removesuffix("_trial")
        assert computed
        assert names_in(section) - {"motion"} == set(EXPERIMENTS[experiment].raw_files)
    elif path.stem == "fit":
        known = EXPERIMENTS.get(rule.removeprefix("fit_"))
        assert computed
        assert {name for name in names if not name.endswith("?")} <= names_in(section)
        further = names_in(section) - {name.removesuffix("?") for name in names}
        assert further == set(known.further if known else ())
    else:
        optional = {name.removesuffix("?") for name in names if name.endswith("?")}
        certain = {name for name in names if not name.endswith("?")}
        assert certain == names_in(section) - optional
        assert not computed


@pytest.mark.parametrize(("rule", "path"), CASES)
def test_rule_is_run_again_when_a_module_that_its_script_reaches_changes(rule, path):
    module, _ = loaded_by(rule, path)
    modules = rf', "{module}"[),]' if module else "[),]"
    assert re.search(rf'library=library_of\(\s*"{path.stem}"{modules}', RULES[rule]["input"])
    assert path.is_file() and (module is None or (ROOT / module).is_file())


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_parts_of_an_experiment_take_what_a_rule_gives_them(name):
    known = EXPERIMENTS[name]

    def arguments(part):
        file = ROOT / f"{known.module(part).replace('.', '/')}.py"
        (function,) = (n for n in syntax(file).body if isinstance(n, ast.FunctionDef) and n.name == part)
        return [argument.arg for argument in function.args.args]

    if known.ingest_reads:
        given = ["files", "section", "duration_s", "named_by", "limits", "rig"]
        assert arguments("ingest") == given
    if known.fitted:
        assert arguments("fit") == ["trial", "section", "condition", *known.fit_takes]
        # the script reads models for it by a module that the fit itself must reach
        library = reached(f"fit_{name}", ROOT / "workflow/scripts/fit.py")
        assert "models" not in known.fit_takes or "tepsipe/treadmill/registry.py" in library


@pytest.mark.parametrize("name", [name for name in EXPERIMENTS if f"ingest_{name}" in RULES])
def test_an_ingest_depends_on_the_readers_of_its_raw_files_and_on_no_others(name):
    assert "*readers_of(_experiment)" in RULES[f"ingest_{name}"]["input"]
    own = [f"{module.replace('.', '/')}.py" for module in modules_for(*EXPERIMENTS[name].purposes)]
    others = {f"{module.replace('.', '/')}.py" for module, kinds in READERS.items() if kinds} - {*own}
    library = reached(f"ingest_{name}", ROOT / "workflow/scripts/ingest.py")
    assert not library.union(*(reached_by(reader, str(ROOT)) for reader in own)) & others


@pytest.mark.parametrize(("rule", "path"), CASES)
def test_only_the_rules_that_make_trials_reach_the_laboratory(rule, path):
    known = {name for name in reached(rule, path) if name.startswith("tepsipe/virtual_lab/")}
    # the table of what both share reads the laboratory's declarations, which hold no constant
    known -= {"tepsipe/virtual_lab/__init__.py", "tepsipe/virtual_lab/forms.py"}
    assert bool(known) == rule.startswith("make_")


@pytest.mark.parametrize(("rule", "path"), CASES)
def test_wildcards_of_a_script_are_in_the_outputs_of_its_rule(rule, path):
    names, _ = used(path, "wildcards")
    assert names <= set(re.findall(r"\{(\w+)\}", RULES[rule]["output"]))


@pytest.mark.parametrize("path", [p for p in SCRIPTS if p.name not in SHARED], ids=lambda p: p.stem)
def test_script_starts_its_job_first_and_does_not_look_into_the_configuration(path):
    statements = syntax(path).body[1:]
    assert ast.unparse(statements[0]) == "import job"
    assert ast.unparse(statements[1]) == "job.start(snakemake)"
    assert "snakemake.config" not in path.read_text(encoding="utf-8")


# ---- the hidden truth --------------------------------------------------------------------------

# the person that a plan expects is a setting of the plan, and no hidden truth
PLANNED = {"make_several_joints"}
# other laws of the dummy's joint: the only rules that are given the truth by another function
UNDER_LAWS = {"make_trial_of_law", "compare_law_with_truth"}
MAKERS = {
    name: path
    for name, path in scripted()
    if path.stem.startswith("make_") and name not in PLANNED | UNDER_LAWS
}
# the table of the laboratory lists its constants, and is given no result
MAY_KNOW_THE_TRUTH = {*MAKERS, "compare_with_truth", "tabulate_laboratory"}


def rules_with(word):
    return {name for name, sections in RULES.items() if any(word in text for text in sections.values())}


def test_truth_meets_estimates_in_the_comparison_alone():
    for name in MAY_KNOW_THE_TRUTH - {"compare_with_truth"}:
        assert (
            names_in(RULES[name]["input"]) <= {"library", "raw"} and "<results>" not in RULES[name]["input"]
        )
    # what it found is read by the table of all comparisons, and by the page of the trial
    found = {name for name, sections in RULES.items() if "<results>/recovery/" in sections.get("input", "")}
    pages = {name for name, sections in RULES.items() if "outputs.comparison_of" in sections.get("input", "")}
    assert found == {"collect_recovery", "collect_other_laws"}
    assert pages == {name for name in RULES if re.fullmatch(r"write_\w+_pages", name)}


def test_only_the_laboratory_and_the_comparison_are_given_the_truth():
    assert len(MAKERS) >= 5
    assert rules_with("truth_of(") == MAY_KNOW_THE_TRUTH
    for name in MAY_KNOW_THE_TRUTH:
        assert len(re.findall(r"truth_of\(", "".join(RULES[name].values()))) == 1
        assert "truth" in names_in(RULES[name]["params"])
    # nobody else takes it in the rule's stead: it is called nowhere but in those rules
    by_hand = [text for name in RULES.keys() - LOOPED.keys() for text in RULES[name].values()]
    in_rules = sum(text.count("truth_of") for text in [*by_hand, loop_of("virtual_lab.smk", "make_trial")])
    shared = [path for path in [*RULE_FILES, ROOT / "Snakefile"] if path.name != "common.smk"]
    # but for the names of other laws, and their constants for the two rules that may know them
    (laws,) = (path.read_text(encoding="utf-8") for path in shared if path.name == "virtual_lab.smk")
    own = re.findall(r"^(?:OTHER_LAWS = |    found = ).*truth_of\(.*$", laws, re.MULTILINE)
    assert len(own) == 2 and rules_with("under_law(") == UNDER_LAWS
    assert sum(path.read_text(encoding="utf-8").count("truth_of(") for path in shared) == in_rules + 2
    assert not any("sections_of" in path.read_text(encoding="utf-8") for path in shared)
    common = (ROOT / "workflow/rules/common.smk").read_text(encoding="utf-8")
    assert re.findall(r"^.*truth_of.*$", common, re.MULTILINE) == [
        "    # make raw files, compare with the truth, or list the laboratory's constants may call truth_of",
        '    truth_of, reported_of = sections_of("virtual_lab"), sections_of("reported")',
    ]


def test_a_rule_that_makes_trials_is_given_the_constants_of_its_own_experiment():
    own = {name for name, experiment in EXPERIMENTS.items() if experiment.profiles}
    assert {name.removeprefix("make_").removesuffix("_trial") for name in MAKERS} == own
    for name in MAKERS:
        experiment, text = name.removeprefix("make_").removesuffix("_trial"), RULES[name]["params"]
        if experiment in RIGS:
            assert f'truth=of_trial(lambda e, c: truth_of(*constants_of(e, c)), "{experiment}"),' in text
            constants = [path.replace("{weight}", "heavy_weight") for path in RIGS[experiment].constants]
        else:
            constants = re.findall(r'"([\w.]+)"', re.search(r"truth=truth_of\((.*)\)", text)[1])
        assert "seed" in constants
        for other in own - {experiment}:
            # but for the rubber, which is the dummy's in both rigs
            given = {path.removeprefix("heavy_") for path in constants} - {"dummy.rubber"}
            assert not [path for path in given if path.startswith(other)], name
        assert ("treadmill" in constants) == (experiment not in ("wristalyzer", "walking"))
    # of the person's tasks, the one of the trial
    assert [path for path in RIGS["standing"].constants if "tasks" in path] == ["standing.tasks.{task}"]


def test_constants_of_a_trial_are_those_that_its_rig_lists():
    text = (ROOT / "workflow/rules/virtual_lab.smk").read_text(encoding="utf-8")
    function = re.search(r"^def constants_of.*?^(?=\S)", text, re.M | re.S).group()
    (returned,) = re.findall(r"^    return (.*)$", function, re.MULTILINE)
    assert returned == "[path.format(weight=weight, task=row.task) for path in RIGS[experiment].constants]"


def test_the_provenance_alone_is_given_the_file_of_the_truth():
    # the file, not a module of the laboratory that makes trials
    named = {
        name
        for name, sections in RULES.items()
        if "virtual_lab" in "".join(sections.values()).replace("tepsipe/virtual_lab/", "")
    }
    assert named == {"record_provenance"}
    text = "".join(path.read_text(encoding="utf-8") for path in RULE_FILES if path.name != "common.smk")
    assert len(re.findall(r"study\W+virtual_lab", text)) == len(
        re.findall(r"study\W+virtual_lab", "".join(RULES["record_provenance"].values()))
    )


def test_common_smk_is_short():
    assert len((ROOT / "workflow/rules/common.smk").read_text(encoding="utf-8").splitlines()) < 200


def test_provenance_takes_the_truth_for_its_checksum_only():
    given = RULES["record_provenance"]
    assert "virtual_lab" not in given["input"]
    assert re.search(r"files=as_it_is\(\s+checksums\(", given["params"])
    text = (ROOT / "workflow/scripts/record_provenance.py").read_text(encoding="utf-8")
    assert len(re.findall(r"params\.files", text)) == 1 and "virtual_lab" not in text
    for name in imported(ROOT / "workflow/scripts/record_provenance.py"):
        assert not within(name, LABORATORY)


def test_no_script_opens_the_truth_by_its_name():
    for path in [*SCRIPTS, *MODULES]:
        assert "virtual_lab.yaml" not in path.read_text(encoding="utf-8"), path


def test_conda_environment_names_the_locked_versions(root):
    locked = dict(re.findall(r"^([\w-]+)==([\w.]+)", (root / "requirements.txt").read_text(), re.M))
    named = re.findall(r"- ([\w-]+)==([\w.]+)", (root / "workflow/envs/tepsipe.yaml").read_text())
    assert len(named) > 5
    assert [(name, version) for name, version in named if locked[name] != version] == []


def test_lock_file_names_no_registry(root):
    assert "http" not in (root / "requirements.txt").read_text()
