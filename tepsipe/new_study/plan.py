"""Settings of a study as text with the reason beside each, and the list of those that are missing."""

import json
import math
import re
from dataclasses import dataclass, field

PLACEHOLDER = "MISSING"  # the study refuses a configuration or a sheet with it
PLAIN = re.compile(r"[A-Za-z][\w./ -]*")
WORDS = {"null", "true", "false", "yes", "no", "on", "off", "y", "n"}


@dataclass(frozen=True)
class Setting:
    """One value of the configuration."""

    value: object
    """What is written (unit in its key)."""
    note: str
    """Where it comes from."""


@dataclass(frozen=True)
class Missing:
    """An item that no file provides."""

    where: str
    """Key of the configuration, or column of the sheet."""
    meaning: str
    """What it is (with its unit)."""
    how: str
    """How to measure it."""


@dataclass
class Plan:
    """Settings of a study, and what is missing."""

    tree: dict = field(default_factory=dict)
    """Settings by section, as nested dicts with a `Setting` at each end."""
    missing: list[Missing] = field(default_factory=list)
    """What must be filled in."""
    check: list[Missing] = field(default_factory=list)
    """What was assumed, and should be checked."""

    def put(self, key: str, value: object, note: str = "") -> None:
        """Set a key with dots between its sections (unit in the key)."""
        *sections, last = key.split(".")
        place = self.tree
        for section in sections:
            place = place.setdefault(section, {})
        place[last] = Setting(value, note)

    def ask(self, key: str, meaning: str, how: str, note: str = "") -> None:
        """Set a key to the placeholder and list it (unit in the key)."""
        self.put(key, PLACEHOLDER, note)
        self.missing.append(Missing(key, meaning, how))

    def assume(self, key: str, value: object, note: str, how: str) -> None:
        """Set a key to a likely value (unit in the key) that should be checked."""
        self.put(key, value, note)
        self.check.append(Missing(key, f"{flow(value)} was assumed: {note}", how))


def flow(value: object) -> str:
    """A value as YAML on one line (unit in its key)."""
    if value is None:
        return "null"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{flow(k)}: {flow(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(flow, value)) + "]"
    if isinstance(value, float) and math.isfinite(value):
        mantissa, power, exponent = repr(float(f"{value:.10g}")).partition("e")
        # YAML reads 1e-05 as a text, 1.0e-05 as a number
        return mantissa + (".0" if power and "." not in mantissa else "") + power + exponent
    if isinstance(value, str):
        plain = PLAIN.fullmatch(value) and value.lower() not in WORDS and value == value.strip()
        return value if plain else json.dumps(value, ensure_ascii=False)
    return json.dumps(value)


def yaml_text(tree: dict, indent: int = 0) -> list[str]:
    """Lines of a configuration, a comment beside each value that has a note."""
    lines = []
    for key, entry in tree.items():
        start = " " * indent + f"{flow(key)}:"
        if isinstance(entry, dict):
            lines += [start, *yaml_text(entry, indent + 2)]
        elif isinstance(entry.value, list) and any(isinstance(v, dict | tuple) for v in entry.value):
            lines.append(f"{start}{_comment(entry.note)}")
            for item in entry.value:
                item, note = item if isinstance(item, tuple) else (item, "")
                lines.append(" " * (indent + 2) + f"- {flow(item)}{_comment(note)}")
        else:
            lines.append(f"{start} {flow(entry.value)}{_comment(entry.note)}")
    return lines


def _comment(note: str) -> str:
    return f" # {note}" if note else ""
