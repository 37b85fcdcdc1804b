"""Parts of the model: closed sections, settings with their documentation, and values that do not fit."""

import ast
import difflib
import inspect
import sys
import types
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Union, get_args, get_origin, get_type_hints

from annotated_types import Len, MinLen
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, create_model
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from tepsipe.errors import quoted
from tepsipe.quantities import DIFFERENT, Meanings, Must, Thesis


class Section(BaseModel):
    """Section of a configuration file: every key is known, and no value is converted."""

    model_config = ConfigDict(extra="forbid", strict=True, defer_build=True)
    # whether the documentation lists its keys wherever it stands
    unfolded: ClassVar[bool] = True
    # the dataclass that it is made from, and the section with the same keys that documents it
    options: ClassVar[type | None] = None
    like: ClassVar["type[Section] | None"] = None


def setting(
    text: str, *, thesis: str = "", unit: str | None = None, values: dict[str, str] | None = None, **limits
) -> Any:
    """Documentation of a setting, and limits of a number or list.

    Parameters
    ----------
    text : str
        Meaning, a row of ``config/README.md``.
    thesis : str
        Section, table or equation of the thesis with its default.
    unit : str, optional
        Unit, if the name of the key does not end with it.
    values : dict, optional
        Meaning of kinds of values; of names to choose from, `one_of` has it.
    **limits
        ``above``, ``least``, ``most`` and ``below`` of a number; ``default`` of a key that may be absent, and
        other arguments of pydantic's ``Field``.
    """
    limits = {LIMITS.get(name, name): value for name, value in limits.items()}
    about = {"thesis": thesis, "unit": unit, "values": values or {}}
    return Field(description=text, json_schema_extra=about, **limits)


def optional(text: str, **about) -> Any:
    """A setting that may be absent."""
    return setting(text, default=None, **about)


LIMITS = {"above": "gt", "least": "ge", "most": "le", "below": "lt"}


def number(**limits: float) -> Any:
    """Type of a number with limits: ``above``, ``least``, ``most``, ``below``."""
    return Annotated[float, Field(**{LIMITS[name]: value for name, value in limits.items()})]


def fixed(of: Any, count: int) -> Any:
    """Type of a list of so many values."""
    return Annotated[list[of], Len(count, count)]


def different(of: Any, least: int = 1) -> Any:
    """Type of a list of different values, at least so many."""
    return modelled(Annotated[list[of], MinLen(least), DIFFERENT])


def some(of: Any, least: int = 1) -> Any:
    """Type of a list of at least so many values."""
    return Annotated[list[of], MinLen(least)]


def named(of: Any, pattern: str = ".") -> Any:
    """Type of a mapping of at least one entry, whose names have a pattern."""
    return Annotated[dict[Annotated[str, Field(pattern=pattern)], of], Field(min_length=1)]


def _no_truth(value: Any) -> Any:
    if isinstance(value, bool):
        raise PydanticCustomError("literal_error", "true and false are no numbers")
    return value


def whole(*values: int) -> Any:
    """Type of a whole number to choose from."""
    return Annotated[Literal[values], BeforeValidator(_no_truth)]


def one_of(meaning: dict[str, str]) -> Any:
    """Type of a name to choose from, with the meaning of each."""
    return Annotated[Literal[tuple(meaning)], Meanings(meaning)]


def meanings(registry: Mapping[str, Any], about: Mapping[str, str]) -> dict[str, str]:
    """Meaning of every name in a registry of the library, and what the configuration adds to it."""
    return {
        name: f"{entry.meaning}; {about[name]}" if name in about else entry.meaning
        for name, entry in registry.items()
    }


def partial(section: type[Section]) -> type[Section]:
    """Section with the same keys, each of which may be absent."""
    fields = {
        name: (Annotated[field.annotation, *field.metadata, _documentation(field)], None)
        for name, field in section.model_fields.items()
    }
    model = create_model(f"Partial{section.__name__}", __base__=Section, __doc__=section.__doc__, **fields)
    model.unfolded, model.like = False, section
    return model


def _documentation(field: FieldInfo) -> FieldInfo:
    return Field(description=field.description, json_schema_extra=field.json_schema_extra)


# ---- sections made from dataclasses of the library -------------------------------------------------------

# words that keep their capital within a sentence
PROPER = ("Butterworth", "Coulomb")


@cache
def made_from(
    kind: type,
    about: str = "",
    *,
    without: tuple[str, ...] = (),
    needed: tuple[str, ...] = (),
    absent: tuple[str, ...] = (),
) -> type[Section]:
    """Section with the fields of a dataclass, which has types, limits and meanings; every key is needed.

    about: documentation of the section, if it is another one than that of the dataclass.
    without: fields that the configuration does not set.
    needed: fields that the library can do without, and the configuration cannot.
    absent: keys that may be absent.
    """
    hints = get_type_hints(kind, include_extras=True)
    model = {}
    for name in (field.name for field in fields(kind) if field.name not in without):
        marks = get_args(hints[name])[1:] if get_origin(hints[name]) is Annotated else ()
        documented: dict[str, Any] = {"default": None} if name in absent else {}
        for mark in marks:
            if isinstance(mark, str):
                documented["unit"] = mark
            elif isinstance(mark, Thesis):
                documented["thesis"] = mark.place
            elif isinstance(mark, Meanings) and get_origin(get_args(hints[name])[0]) is not Literal:
                documented["values"] = mark.of
        of = modelled(_needed(hints[name]) if name in needed else hints[name])
        model[name] = (of, setting("", **documented))
    made = create_model(kind.__name__, __base__=Section, __doc__=about or kind.__doc__, **model)
    made.options = kind
    return made


def _needed(kind: Any) -> Any:
    """A type without None."""
    if get_origin(kind) is Annotated:
        return Annotated[_needed(get_args(kind)[0]), *get_args(kind)[1:]]
    return Union[tuple(part for part in get_args(kind) if part is not type(None))]  # noqa: UP007


def modelled(kind: Any) -> Any:
    """Type of the model for one of the library: sections for dataclasses, lists for sequences."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return _limited(modelled(parts[0]), parts[1:])
    if origin in (Union, types.UnionType):
        return Union[tuple(map(modelled, parts))]  # noqa: UP007, the types are known when it runs
    if origin is Literal:
        return whole(*parts) if isinstance(parts[0], int) else kind
    if origin in (Sequence, list):
        return list[modelled(parts[0])]
    if origin in (Mapping, dict):
        return dict[parts[0], modelled(parts[1])]
    return made_from(kind) if is_dataclass(kind) else kind


def _limited(kind: Any, marks: tuple) -> Any:
    for mark in marks:
        if isinstance(mark, Must):
            kind = Annotated[kind, AfterValidator(_checker(mark))]
        elif not isinstance(mark, str | Thesis):
            kind = Annotated[kind, mark]
    return kind


def _checker(must: Must) -> Callable[[Any], Any]:
    def check(value: Any) -> Any:
        if not must.holds(value):
            if must is DIFFERENT:
                raise PydanticCustomError("different_items", "two items are the same")
            raise UnfitError(must.expected, must.advice)
        return value

    return check


def meaning_of(section: type[Section], name: str) -> str:
    """Meaning of a key: of the setting itself, or the text below the field of the library."""
    field = section.model_fields[name]
    # a section within another one is documented by its own settings
    if field.description or field.json_schema_extra is None:
        return field.description or ""
    kinds = [vars(base)["options"] for base in (section.like or section).__mro__ if "options" in vars(base)]
    return next((_texts(kind)[name] for kind in kinds if kind and name in _texts(kind)), "")


@cache
def _texts(kind: type) -> dict[str, str]:
    """Text below each field of a dataclass, as part of a table: without capital and full stop."""
    found: dict[str, str] = {}
    for one in reversed(kind.__mro__[:-1]):
        body = _classes(sys.modules[one.__module__].__file__)[one.__name__].body
        for field, text in pairwise(body):
            if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr):
                found[field.target.id] = _cell(" ".join(inspect.cleandoc(text.value.value).split()))
    return found


@cache
def _classes(path: str) -> dict[str, ast.ClassDef]:
    tree = ast.parse(Path(path).read_text(encoding="utf-8"))
    return {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}


def _cell(text: str) -> str:
    first = text.split(maxsplit=1)[0]
    lowered = first == "A" or (first[1:].islower() and first not in PROPER)
    return (text[0].lower() + text[1:] if lowered else text).removesuffix(".")


class UnfitError(ValueError):
    """A value that does not fit others of its section, or its own kind.

    Attributes
    ----------
    expected, advice : str
        Parts of the sentence "expected PLACE ..., found ...: ...".
    key : str
        Place within the section or value that is checked; empty for the whole of it.
    found : str, optional
        What was found; by default the value that is checked.
    """

    def __init__(self, expected: str, advice: str = "correct it", key: str = "", found: str | None = None):
        super().__init__(expected)
        self.expected, self.advice, self.key, self.found = expected, advice, key, found

    def sentence(self, where: str = "", value: object = None) -> str:
        """Message about ``value``, which stands at ``where``."""
        place = ".".join(part for part in (where, self.key) if part)
        found = value if self.found is None else self.found
        return f"expected {place} {self.expected}, found {found}: {self.advice}"


def refuse_unknown(key: str, found: str | None, section: str, known: Collection[str]) -> None:
    """Refuse a name that is looked up in a section, or list, and not found."""
    if found in known:
        return
    close = difflib.get_close_matches(str(found), known, n=1)
    advice = f"did you mean {close[0]!r}?" if close else "correct one of the two"
    raise UnfitError(f"to name one of {section} ({', '.join(map(str, known))})", advice, key, quoted(found))
