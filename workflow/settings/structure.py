"""Walks through the model: the kind of value in a place, and the paths of all keys."""

import types
from typing import Annotated, Any, Literal, Union, get_args, get_origin

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


# ends of the keys' names, and units as they are typeset; the longest end counts
UNITS = {
    "_Nms2_per_rad": "N·m·s²/rad",
    "_Nms_per_rad": "N·m·s/rad",
    "_Nm_per_rad": "N·m/rad",
    "_rad_per_m_per_s2": "rad per m/s²",
    "_uV_per_m_per_s2": "µV per m/s²",
    "_rad_per_Nm": "rad/(N·m)",
    "_m_per_rad": "m/rad",
    "_rad_per_s": "rad/s",
    "_m_per_s2": "m/s²",
    "_m_per_s": "m/s",
    "_Ns_per_m": "N·s/m",
    "_V_per_N": "V/N",
    "_V_per_s": "V/s",
    "_kgm2": "kg·m²",
    "_kgm": "kg·m",
    "_kg": "kg",
    "_Nm": "N·m",
    "_N": "N",
    "_V": "V",
    "_uV": "µV",
    "_hz": "Hz",
    "_db": "dB",
    "_deg": "°",
    "_rad": "rad",
    "_percent": "%",
    "_m": "m",
    "_s": "s",
}


def unit_of(key: str, field: Any) -> str:
    """Unit of a setting, by the end of its key's name unless the setting gives another one."""
    unit = (field.json_schema_extra or {}).get("unit")
    if unit is None:
        ends = [end for end in UNITS if key.endswith(end)]
        unit = UNITS[max(ends, key=len)] if ends else ""
    return unit


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
