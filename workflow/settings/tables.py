"""Tables of ``config/README.md``, generated from the model and the shipped configuration.

The page marks the place of every table by ``<!-- settings: NAME -->`` and ``<!-- end -->``; the names are
those of ``TABLES``.
"""

import inspect
import re
import textwrap
from collections.abc import Callable, Iterator
from itertools import groupby
from typing import Annotated, Any, get_args, get_origin

from pydantic.fields import FieldInfo

from tepsipe.quantities import Meanings
from workflow.settings.check import entries_of, names_of, section_of, unit_of, unwrapped
from workflow.settings.config import OF_FOLDERS, Config
from workflow.settings.dummy import PROCESSINGS
from workflow.settings.reported import Reported
from workflow.settings.section import Section, meaning_of
from workflow.settings.uncertainty import Source
from workflow.settings.virtual_lab import Distribution, VirtualLab
from workflow.settings.weight import MODELS
from workflow.support.places import ROOT
from workflow.support.yaml_file import read_settings

README = ROOT / "config" / "README.md"
MARK = re.compile(r"(<!-- settings: ([\w ]+) -->\n).*?(<!-- end -->)", re.DOTALL)
# before it stand further experiments
FURTHER = "### noise\n"
ABSENT = object()
MOST_SHOWN = 6


def updated(text: str) -> str:
    """The page with its tables as the model has them, and with a table for every experiment."""
    for name, section in OF_FOLDERS.items():
        if f"<!-- settings: {name} -->" not in text:
            added = f"### {name}\n\n{section.__doc__}\n\n<!-- settings: {name} -->\n<!-- end -->\n\n"
            text = text.replace(FURTHER, f"{added}{FURTHER}")
    return MARK.sub(lambda found: f"{found[1]}\n{TABLES[found[2]]()}\n{found[3]}", text)


# ---- rows of settings -----------------------------------------------------------------------------------


def _rows(
    section: type[Section], values: Any, where: str = "", done: frozenset = frozenset()
) -> Iterator[dict[str, str]]:
    """A row per setting; entries of lists and mappings are listed where they first occur."""
    for name, field in section.model_fields.items():
        key, kind = f"{where}{name}", field.annotation
        value = values.get(name, ABSENT) if isinstance(values, dict) else ABSENT
        inner, entry = section_of(kind), section_of(entries_of(kind))
        if meaning := meaning_of(section, name):
            yield from _row(key, field, value, meaning)
        if inner and inner.unfolded:
            yield from _rows(inner, value, f"{key}.", done)
        elif entry and entry.unfolded and entry not in done:
            yield from _rows(entry, ABSENT, f"{key}.*.", done)
            done |= {entry}


def _row(key: str, field: FieldInfo, value: Any, meaning: str) -> Iterator[dict[str, str]]:
    about = field.json_schema_extra
    meanings = about["values"] or {
        f"`{name}`": text
        for names in field.metadata + _metadata(entries_of(field.annotation))
        if isinstance(names, Meanings)
        for name, text in names.of.items()
    }
    yield {
        "Key": f"`{key}`",
        "Unit": unit_of(key, field),
        "Allowed": "" if meanings else _allowed(field.annotation, field.metadata),
        "Default": _shown(value),
        "Meaning": meaning + ("; optional" if not field.is_required() else ""),
        "Thesis": about["thesis"],
    }
    for name, text in meanings.items():
        yield {"Allowed": name, "Meaning": text}


def _metadata(kind: Any) -> list:
    """Limits that a type carries."""
    found = get_args(kind)[1:] if get_origin(kind) is Annotated else ()
    return [part for limit in found for part in (limit.metadata if isinstance(limit, FieldInfo) else [limit])]


def _allowed(kind: Any, limits: list, plural: str = "") -> str:
    """Values that a type allows."""
    names, alternatives = names_of(kind), unwrapped(kind)
    if names:
        words = ", ".join(f"`{name}`" if isinstance(name, str) else _number(name) for name in names)
    elif section_of(kind) or get_origin(alternatives[0]) is dict or alternatives[0] is dict:
        words = ""
    elif get_origin(alternatives[0]) is list:
        words = _list(alternatives[0], limits + _metadata(kind), plural)
    else:
        limits = limits + [found for part in (kind, *get_args(kind)) for found in _metadata(part)]
        word = {bool: "true, false", int: "whole number", float: "number", str: "text"}.get(alternatives[0])
        words = ", ".join(filter(None, (f"{word or 'any'}{plural}", _range(limits))))
        # most settings are single numbers
        words = words.removeprefix("number, ")
    return f"{words} or null" if words and type(None) in alternatives else words


def _list(kind: Any, limits: list, plural: str) -> str:
    (entry,) = get_args(kind)
    least, most = _limit(limits, "min_length"), _limit(limits, "max_length")
    inner = _allowed(entry, [], "s")
    if least is not None and least == most:
        return f"lists of {least} {inner}" if plural else f"{least} {inner}"
    return f"list{plural} of {inner}" if inner else f"list{plural}"


def _range(limits: list) -> str:
    above, least, below, most = (_limit(limits, name) for name in ("gt", "ge", "lt", "le"))
    if least is not None and most is not None:
        return f"{_number(least)} to {_number(most)}"
    bounds = {"above": above, "at least": least, "below": below, "at most": most}
    return ", ".join(f"{word} {_number(bound)}" for word, bound in bounds.items() if bound is not None)


def _limit(limits: list, name: str) -> Any:
    return next((value for limit in limits if (value := getattr(limit, name, None)) is not None), None)


def _number(value: float) -> str:
    return (str(value) if isinstance(value, int) else f"{value:.10g}").replace("-", "−")


def _shown(value: Any) -> str:
    """A default as the page shows it."""
    if value is ABSENT:
        return ""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, str):
        return f"`{value}`"
    if isinstance(value, int | float):
        return _number(value)
    if isinstance(value, dict) and "standard_uncertainty" in value:
        return f"{_number(value['standard_uncertainty'])}, {value['distribution']}"
    if isinstance(value, list) and any(isinstance(item, dict) for item in value):
        return f"{len(value)}"
    shown = [_shown(item) for item in value]
    if len(shown) > MOST_SHOWN:
        shown = [*shown[:2], "…", shown[-1]]
    return ", ".join(shown) or "none"


# ---- tables ---------------------------------------------------------------------------------------------


def _table(rows: list[dict[str, str]], columns: tuple[str, ...]) -> str:
    """Markdown of some columns; those that are empty in every row are left out."""
    columns = tuple(name for name in columns if any(row.get(name) for row in rows))
    lines = [columns, ["---"] * len(columns), *([row.get(name, "") for name in columns] for row in rows)]
    return (
        "".join(f"| {' | '.join(line)} |\n" for line in lines).replace("|  |", "| |").replace("|  |", "| |")
    )


SETTING = ("Key", "Unit", "Allowed", "Default", "Meaning", "Thesis")


def _section(name: str) -> str:
    section = section_of(Config.model_fields[name].annotation)
    return _table(list(_rows(section, read_settings(ROOT / "config/config.yaml")[name])), SETTING)


def _of(section: type[Section]) -> str:
    return _table(list(_rows(section, ABSENT)), SETTING)


def _laboratory() -> str:
    """A table of every section of the laboratory with constants of its own; equal sections share one."""
    found = []

    def walk(section: type[Section], path: str) -> None:
        inner = [(name, section_of(field.annotation)) for name, field in section.model_fields.items()]
        if not any(part for _, part in inner):
            found.append((section, path))
        for name, part in inner:
            if part:
                walk(part, f"{path}.{name}" if path else name)

    walk(VirtualLab, "")
    tables = []
    for section, group in groupby(found, key=lambda pair: pair[0]):
        names = ", ".join(f"`{path}`" for _, path in group)
        text = " ".join(inspect.cleandoc(section.__doc__).split())
        text = textwrap.fill(f"**{names}.** {text}", 100, break_long_words=False, break_on_hyphens=False)
        tables.append(f"{text}\n\n{_of(section)}")
    return "\n".join(tables)


def _names(columns: tuple[str, ...], meaning: dict[str, tuple[str, ...]]) -> str:
    rows = [dict(zip(columns, (f"`{name}`", *texts), strict=True)) for name, texts in meaning.items()]
    return _table(rows, columns)


TABLES: dict[str, Callable[[], str]] = {
    **{name: (lambda name=name: _section(name)) for name in Config.model_fields},
    "source": lambda: _of(Source),
    "treadmill models": lambda: _names(
        ("Model", "Description", "Size in the column `order`", "Lead"), MODELS
    ),
    "noise estimators": lambda: _names(("Estimator", "Torque", "Estimate", "Filtered", "Noise"), PROCESSINGS),
    "distribution": lambda: _of(Distribution),
    "virtual laboratory": _laboratory,
    "reported": lambda: _of(Reported),
}
