"""Walks through the model: the kind of value in a place, and the paths of all keys."""

import types
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from tepsipe import quantities
from workflow.settings.section import Section

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
