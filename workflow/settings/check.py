"""Checks of a file's content by the model, each of which raises one sentence, and walks through the model."""

import difflib
import math
import types
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import ValidationError

from tepsipe import quantities
from tepsipe.errors import InputError, quoted
from tepsipe.quantities import DIFFERENT, LIMITS, limit_in_words
from workflow.settings.section import Section, UnfitError

# what the model expects, by pydantic's name of the fault; limits of the library have their words there
EXPECTED = {
    "string_too_short": "a text",
    "string_pattern_mismatch": "a value of the pattern {pattern}",
    "different_items": DIFFERENT.expected,
}


def check_content(content: dict, model: type[Section], name: str) -> None:
    """Raise one sentence for the first part of ``content`` that the model refuses."""
    _refuse_unusable(content, name)
    try:
        model.model_validate(content)
    except ValidationError as error:
        faults = sorted(error.errors(include_url=False), key=_order)
        raise InputError(f"{name}: {_sentence(faults[0], model, content)}") from None


def _refuse_unusable(content, name: str, where: str = "") -> None:
    """Refuse infinite numbers, and keys with braces, which Snakemake would fill in."""
    if isinstance(content, float) and not math.isfinite(content):
        raise InputError(f"{name}: expected a finite number for {where!r}, found {content}: correct it")
    if isinstance(content, dict | list):
        for key, value in content.items() if isinstance(content, dict) else enumerate(content):
            if set("{}") & set(str(key)):
                raise InputError(f"{name}: expected a key without braces, found {quoted(key)}: rename it")
            _refuse_unusable(value, name, f"{where}.{key}" if where else str(key))


def _order(fault: dict) -> tuple:
    """A misspelt key also counts as a missing one: unknown keys first; values that do not fit last."""
    missing = fault["type"] == "missing"
    rank = {"extra_forbidden": 0, "invalid_key": 0, "value_error": 2}.get(fault["type"], 1)
    return rank, list(map(str, fault["loc"][:-1] if missing else fault["loc"]))


def _sentence(fault: dict, model: type[Section], content: dict) -> str:
    kind, path = fault["type"], _path(fault["loc"], content)
    if kind in ("extra_forbidden", "invalid_key"):
        return _unknown_key(path, model)
    if kind == "missing":
        missing = quoted(".".join(map(str, (*path, fault["loc"][-1]))), 120)
        return f"expected the key {missing}, found none: add it (config/README.md describes it)"
    error = fault.get("ctx", {}).get("error")
    if isinstance(error, InputError):
        return str(error)
    where, found = ".".join(map(str, path)), f"found {quoted(fault['input'])}"
    if isinstance(error, UnfitError):
        return error.sentence(where, fault["input"])
    if fault["loc"][-1] == "[key]" and kind == "string_type":
        return f"expected a text as key for {where!r}, {found}: put it into quotes"
    allowed = kind_at(model, path)
    if kind == "literal_error":
        names = names_of(allowed)
        return f"expected one of {', '.join(map(repr, names))} for {where!r}, {found}: correct it"
    limits = fault.get("ctx", {})
    wanted = next((limit_in_words(n, limits[n], fault["input"]) for n in LIMITS if n in limits), None)
    if kind in EXPECTED:
        wanted = EXPECTED[kind].format(**limits)
    if wanted:
        unit = unit_at(model, path) if isinstance(fault["input"], int | float) else ""
        advice = f"correct it; its unit is {unit}" if unit else "correct it"
        return f"expected {wanted} for {quoted(where, 120)}, {found}: {advice}"
    return f"expected a value of type {described(allowed)} for {quoted(where, 120)}, {found}: correct it"


def _path(loc: tuple, content) -> tuple:
    """The part of pydantic's place that exists in the content: without marks such as ``[key]``."""
    path = []
    for step in loc:
        if (isinstance(content, dict) and step in content) or (
            isinstance(content, list) and isinstance(step, int) and step < len(content)
        ):
            content = content[step]
        else:
            break
        path.append(step)
    return tuple(path)


def _unknown_key(path: tuple, model: type[Section]) -> str:
    where, unknown = ".".join(map(str, path[:-1])), str(path[-1])
    key = f"{where}.{unknown}" if where else unknown
    known, everywhere = list(section_of(kind_at(model, path[:-1])).model_fields), all_keys(model)
    elsewhere = [other for other in everywhere if other.rpartition(".")[2] == unknown]
    close = difflib.get_close_matches(unknown, known, n=1, cutoff=0.5)
    if elsewhere:
        # the sections whose names are most like the one where the key stands
        nearest = difflib.get_close_matches(key, elsewhere, n=3, cutoff=0.0)
        more = f", or one of {len(elsewhere) - 3} more" if len(elsewhere) > 3 else ""
        answer = f"did you mean {' or '.join(map(repr, nearest))}{more}?"
    elif close:
        answer = f"did you mean {close[0]!r}?"
    else:
        answer = f"known here: {', '.join(known)}"
    if where.startswith("uncertainty.") and not answer.startswith("known here"):
        answer += f" (known here: {', '.join(known)})"
    return f"unknown key {quoted(key, 120)}: {answer}"


# ---- the model at a place ------------------------------------------------------------------------------

NAMES = {float: "number", int: "integer", str: "string", bool: "boolean", type(None): "null"}


def unwrapped(kind: Any) -> list[Any]:
    """Alternatives of a type, without limits."""
    if get_origin(kind) is Annotated:
        return unwrapped(get_args(kind)[0])
    if get_origin(kind) in (Union, types.UnionType):
        return [found for part in get_args(kind) for found in unwrapped(part)]
    return [kind]


def section_of(kind: Any) -> type[Section] | None:
    """Section that a value of a type is, or None."""
    found = [part for part in unwrapped(kind) if isinstance(part, type) and issubclass(part, Section)]
    return found[0] if found else None


def entries_of(kind: Any) -> Any | None:
    """Type of the entries, if a value of a type is a list or mapping, or None."""
    for part in unwrapped(kind):
        if get_origin(part) in (list, dict):
            return get_args(part)[-1]
    return None


def kind_at(kind: Any, path: tuple) -> Any:
    """Type of the value at a path below a value of a type; None if the model knows no such place."""
    for step in path:
        section = section_of(kind)
        if section is None:
            kind = entries_of(kind)
        elif step in section.model_fields:
            kind = section.model_fields[step].annotation
        else:
            kind = section.__annotations__.get("__pydantic_extra__")
            kind = None if kind is None else get_args(kind)[-1]
        if kind is None:
            return None
    return kind


def names_of(kind: Any) -> list:
    """Values to choose from, if a type lists them."""
    return [value for part in unwrapped(kind) if get_origin(part) is Literal for value in get_args(part)]


def described(kind: Any) -> str:
    """Types of values that a type allows, in the words of JSON."""
    words = []
    for part in unwrapped(kind):
        if get_origin(part) is Literal:
            words += [repr(value) for value in get_args(part)]
        elif section_of(part) or get_origin(part) is dict or part is dict:
            words.append("object")
        else:
            words.append("array" if get_origin(part) is list else NAMES.get(part, "any"))
    return " or ".join(words)


def unit_of(key: str, field: Any) -> str:
    """Unit of a setting, by the end of its key's name unless the setting gives another one."""
    unit = (field.json_schema_extra or {}).get("unit")
    return quantities.unit_of(key) if unit is None else unit


def unit_at(kind: Any, path: tuple) -> str:
    """Unit of the setting at a path, or of the list there; empty without one."""
    steps = list(path)
    while steps and isinstance(steps[-1], int):
        steps.pop()
    section = section_of(kind_at(kind, tuple(steps[:-1]))) if steps else None
    field = None if section is None else section.model_fields.get(steps[-1])
    return "" if field is None else unit_of(steps[-1], field)


def all_keys(section: type[Section], where: str = "") -> list[str]:
    """Paths of all keys, dots in between; entries of lists and mappings are not followed."""
    keys: list[str] = []
    for name, field in section.model_fields.items():
        path, inner = f"{where}{name}", section_of(field.annotation)
        keys += [path, *(all_keys(inner, f"{path}.") if inner else [])]
    return keys
