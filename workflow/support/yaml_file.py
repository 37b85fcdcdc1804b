"""YAML and JSON files of settings, read strictly: a mistake, a repeated key or code in them is refused."""

import json
import re
from pathlib import Path

import yaml

from tepsipe.errors import InputError, quoted
from tepsipe.io.readers.plain_file import read_text

# sections within sections, and settings when every alias is written out: far beyond any configuration
DEEPEST, MOST_SETTINGS = 100, 100_000
CODE = "__use_yte__"  # the key by which Snakemake runs expressions in a configuration


def read_settings(path: str | Path) -> dict:
    """Read a YAML or JSON file; refuse one that is missing, damaged, holds a key twice or holds code."""
    text = read_text(Path(path), "a configuration file")
    _refuse_depth(text, path)
    content = _json(text, path) if text.lstrip().startswith("{") else None
    content = _yaml(text, path) if content is None else content
    if content is None:
        return {}
    if not isinstance(content, dict):
        raise InputError(f"{path}: expected keys and values, found {quoted(content)}: write 'key: value'")
    if _settings_in(content, {}) > MOST_SETTINGS:
        raise InputError(
            f"{path}: expected at most {MOST_SETTINGS} settings, found more when aliases are written out: "
            "write the settings without aliases"
        )
    if CODE in content:
        raise InputError(
            f"{path}: expected settings only, found the key {CODE!r}, with which Snakemake runs code from a "
            "configuration: remove it and write the values out"
        )
    return content


def override(settings: dict, changes: dict) -> None:
    """Change settings in place, key by key; lists and single values are replaced."""
    for key, value in changes.items():
        if isinstance(value, dict) and isinstance(settings.get(key), dict):
            override(settings[key], value)
        else:
            settings[key] = value


def base_of(path: str | Path | None) -> str | None:
    """Path of the file whose constants a file of the virtual laboratory overrides; None without one."""
    return None if path is None else _base(read_settings(path), path)


def _base(content: dict, path: str | Path) -> str | None:
    base = content.get("base")
    if base is not None and not isinstance(base, str):
        raise InputError(f"{path}: expected the path of a file for 'base', found {quoted(base)}: correct it")
    return base


def read_constants(path: str | Path) -> dict:
    """Read constants of the virtual laboratory: a file, or those of its `base` with its own instead."""
    own = read_settings(path)
    base = _base(own, path)
    if base is None:
        return own
    constants = read_settings(base)
    override(constants, {key: value for key, value in own.items() if key != "base"})
    return constants


def _refuse_depth(text: str, path: str | Path) -> None:
    """Refuse brackets within brackets without end, on which the parser crashes."""
    depth = 0
    for bracket in re.findall(r"[\[{\]}]", text):
        depth += 1 if bracket in "[{" else -1
        if depth > DEEPEST:
            raise InputError(
                f"{path}: expected at most {DEEPEST} brackets within each other, found more: check the file"
            )


def _settings_in(content: object, known: dict[int, int]) -> int:
    """Number of settings; what several aliases name is counted once for each."""
    if not isinstance(content, dict | list):
        return 1
    if id(content) not in known:
        known[id(content)] = MOST_SETTINGS + 1  # what holds itself has no end
        parts = content.values() if isinstance(content, dict) else content
        known[id(content)] = 1 + sum(_settings_in(part, known) for part in parts)
    return known[id(content)]


def _json(text: str, path: str | Path) -> dict | None:
    """A JSON object, or None where the text is no JSON."""

    def unique(pairs: list[tuple]) -> dict:
        content = dict(pairs)
        if len(content) < len(pairs):
            keys = [key for key, _ in pairs]
            twice = next(key for key in keys if keys.count(key) > 1)
            raise InputError(
                f"{path}: expected every key once, found {quoted(twice)} twice in one section: remove one"
            )
        return content

    try:
        return json.loads(text, object_pairs_hook=unique)
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        return None


def _yaml(text: str, path: str | Path) -> object:
    try:
        return yaml.load(text, Loader=_UniqueKeys)
    except yaml.YAMLError as error:
        place = getattr(error, "problem_mark", None)
        line = f" on line {place.line + 1}" if place else ""
        problem = " ".join(str(getattr(error, "problem", None) or error).split())
        raise InputError(f"{path}: expected YAML, found a mistake{line} ({problem}): correct it") from None
    except ValueError as error:  # for example a date that does not exist
        raise InputError(f"{path}: expected YAML, found a value that is none ({error}): correct it") from None
    except RecursionError:
        raise InputError(f"{path}: expected YAML, found sections without end: check the file") from None


class _UniqueKeys(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
    """A loader that refuses a repeated key, which YAML readers otherwise accept."""


def _mapping(loader: yaml.SafeLoader, node: yaml.MappingNode) -> dict:
    seen = set()
    for key_node, _ in node.value:
        if key_node.tag == "tag:yaml.org,2002:merge":
            continue
        if not isinstance(key_node, yaml.ScalarNode):
            raise yaml.constructor.ConstructorError(
                None, None, "a key that is not a word", key_node.start_mark
            )
        key = loader.construct_object(key_node, deep=True)
        if not isinstance(key, str | int | float) or isinstance(key, bool):
            raise yaml.constructor.ConstructorError(
                None, None, f"the key {key_node.value!r} is no word: put it into quotes", key_node.start_mark
            )
        if key in seen:
            raise yaml.constructor.ConstructorError(
                None, None, f"the key {key!r} stands twice", key_node.start_mark
            )
        seen.add(key)
    loader.flatten_mapping(node)
    return loader.construct_mapping(node, deep=True)


_UniqueKeys.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _mapping)


def _number(loader: yaml.SafeLoader, node: yaml.ScalarNode) -> int | float:
    """A number without colons, which YAML takes for minutes and seconds, and without underscores."""
    if set(":_") & set(node.value):
        raise yaml.constructor.ConstructorError(
            None, None, f"{node.value!r} is read as a number: write its digits, or quotes", node.start_mark
        )
    whole = node.tag == "tag:yaml.org,2002:int"
    return (loader.construct_yaml_int if whole else loader.construct_yaml_float)(node)


for kind in ("int", "float"):
    _UniqueKeys.add_constructor(f"tag:yaml.org,2002:{kind}", _number)
