"""Checks of a file's content by the model; each raises one sentence."""

import difflib
import math

from pydantic import ValidationError

from tepsipe.errors import InputError, quoted
from tepsipe.quantities import DIFFERENT, LIMITS, limit_in_words
from workflow.settings.section import Section, UnfitError
from workflow.settings.structure import all_keys, described, kind_at, names_of, section_of, unit_at

# what the model expects, by pydantic's name of the fault; limits of the library have their words there
EXPECTED = {
    "string_too_short": "a text",
    "string_pattern_mismatch": "a value of the pattern {pattern}",
    "multiple_of": "a multiple of {multiple_of}",
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
