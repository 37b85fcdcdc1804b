"""Parts of the model: closed sections, settings with their documentation, and values that do not fit."""

import difflib
from collections.abc import Collection, Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, create_model
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from tepsipe.errors import quoted


class Section(BaseModel):
    """Section of a configuration file: every key is known, and no value is converted."""

    model_config = ConfigDict(extra="forbid", strict=True, defer_build=True)
    # whether the documentation lists its keys wherever it stands
    unfolded: ClassVar[bool] = True


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


def _no_truth(value: Any) -> Any:
    if isinstance(value, bool):
        raise PydanticCustomError("literal_error", "true and false are no numbers")
    return value


def whole(*values: int) -> Any:
    """Type of a whole number to choose from."""
    return Annotated[Literal[values], BeforeValidator(_no_truth)]


class Names:
    """Names to choose from, with their meaning."""

    def __init__(self, meaning: dict[str, str]) -> None:
        self.meaning = meaning


def one_of(meaning: dict[str, str]) -> Any:
    """Type of a name to choose from, with the meaning of each."""
    return Annotated[Literal[tuple(meaning)], Names(meaning)]


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
    model.unfolded = False
    return model


def _documentation(field: FieldInfo) -> FieldInfo:
    return Field(description=field.description, json_schema_extra=field.json_schema_extra)


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
