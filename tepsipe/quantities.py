"""Kinds of values with their physical ranges: wide enough for any rig, too narrow for a wrong unit.

The field of a dataclass of options has one of these types, and below it a text with its meaning. A range thus
stands once: the configuration is checked by it, and so are the arguments of functions and commands
(`tepsipe.arguments.check_options`). A unit is a text in ``Annotated``; most are the end of the field's name.
"""

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeVar

from annotated_types import Ge, Gt, Le, Len, Lt, MinLen

T = TypeVar("T")


@dataclass(frozen=True)
class Thesis:
    """Section, table or equation of the thesis with the default of a setting."""

    place: str


@dataclass(frozen=True, eq=False)
class Meanings:
    """Names, or kinds of values, to choose from, with the meaning of each."""

    of: dict[str, str]


@dataclass(frozen=True, eq=False)
class Must:
    """What a value must be beyond its type and limits."""

    expected: str
    holds: Callable[[Any], bool]
    advice: str = "correct it"


ASCENDING = Must("from low to high", lambda ends: ends[0] < ends[1], "turn it round")
DIFFERENT = Must("different items", lambda items: len({repr(item) for item in items}) == len(items))
NOT_ZERO = Must("other than 0", lambda value: value != 0.0, "state the unit of the channel")

Mass = Annotated[float, Gt(0), Le(500)]  # kg
PartMass = Annotated[float, Gt(0), Le(100)]  # kg, of a foot or a leg
Length = Annotated[float, Gt(0), Le(3)]  # m
Height = Annotated[float, Ge(0), Le(3)]  # m
Offset = Annotated[float, Ge(-3), Le(3)]  # m
Stature = Annotated[float, Ge(0.4), Le(2.6)]  # m
Gravity = Annotated[float, Ge(9.7), Le(9.9)]  # m/s²
Inertia = Annotated[float, Ge(0), Le(20)]  # kg·m² or N·m·s²/rad
Damping = Annotated[float, Ge(0), Le(1000)]  # N·m·s/rad
Stiffness = Annotated[float, Gt(0), Le(20000)]  # N·m/rad
AddedStiffness = Annotated[float, Ge(0), Le(20000)]  # N·m/rad, of a part that may be absent
Angle = Annotated[float, Ge(-3.2), Le(3.2)]  # rad
Velocity = Annotated[float, Gt(0), Le(10)]  # m/s
Acceleration = Annotated[float, Gt(0), Le(1000)]  # m/s²
Torque = Annotated[float, Gt(0), Le(5000)]  # N·m
Time = Annotated[float, Gt(0), Le(3600)]  # s
Pause = Annotated[float, Ge(0), Le(3600)]  # s
Delay = Annotated[float, Ge(0), Le(1)]  # s
Latency = Annotated[float, Gt(0), Le(1)]  # s, above 0
Rate = Annotated[float, Gt(0), Le(100000)]  # Hz, of sampling
Frequency = Annotated[float, Ge(0.01), Le(5000)]  # Hz
Positive = Annotated[float, Gt(0)]
NotNegative = Annotated[float, Ge(0)]
Fraction = Annotated[float, Ge(0), Le(1)]
Percent = Annotated[float, Ge(0), Le(100)]
InnerFraction = Annotated[float, Gt(0), Lt(1)]
Scale = Annotated[float, NOT_ZERO]  # per unit of a channel

Draws = Annotated[int, Ge(100), Le(100000)]  # of a bootstrap
Bins = Annotated[int, Ge(2)]  # raw frequencies averaged into one

FilterOrder = Literal[2, 4, 6, 8]
Side = Literal["left", "right"]
Direction = Literal["+x", "-x", "+y", "-y", "+z", "-z"]
Sign = Literal[1, -1]
AngleUnit = Literal["rad", "deg"]
Delimiter = Literal["comma", "tab", "semicolon"]
Distribution = Literal["normal", "rectangular", "triangular"]

Pair = Annotated[Sequence[T], Len(2, 2)]
Three = Annotated[Sequence[T], Len(3, 3)]
Some = Annotated[Sequence[T], MinLen(1)]
Several = Annotated[Sequence[T], MinLen(2)]
Different = Annotated[Sequence[T], MinLen(1), DIFFERENT]
Band = Annotated[Sequence[NotNegative], Len(2, 2), ASCENDING]
Point = Pair[Offset]

# what a limit expects, by its name
LIMITS = {
    "gt": "a number above {:g}",
    "ge": "a number of at least {:g}",
    "lt": "a number below {:g}",
    "le": "a number of at most {:g}",
    "multiple_of": "a multiple of {}",
    "min_length": "at least {} {}",
    "max_length": "at most {} items",
}
HOLDS: dict[str, Callable[[Any, Any], bool]] = {
    "gt": operator.gt,
    "ge": operator.ge,
    "lt": operator.lt,
    "le": operator.le,
    "multiple_of": lambda value, of: value % of == 0,
    "min_length": lambda items, least: len(items) >= least,
    "max_length": lambda items, most: most is None or len(items) <= most,
}

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
# units as tables and files write them -> as text and figures show them
UNIT_SYMBOLS = {
    "Nms2/rad": "N·m·s²/rad",
    "Nms/rad": "N·m·s/rad",
    "Nm/rad": "N·m/rad",
    "Nms/rad2": "N·m·s/rad²",
    "Nm/rad2": "N·m/rad²",
    "Nm/rad3": "N·m/rad³",
    "Nms": "N·m·s",
    "Nm": "N·m",
    "Nm/rad/kg": "N·m/rad/kg",
    "Nms/rad/kg": "N·m·s/rad/kg",
}
_PLAIN = str.maketrans({"·": "", "²": "2", "³": "3"})


def limit_in_words(name: str, limit: float, value: object) -> str:
    """What a limit, by its name in `LIMITS`, expects of a value."""
    return LIMITS[name].format(limit, "entry" if isinstance(value, Mapping) else "items")


def unit_of(name: str) -> str:
    """Unit at the end of a name; empty without one."""
    ends = [end for end in UNITS if name.endswith(end)]
    return UNITS[max(ends, key=len)] if ends else ""


def plain_unit(symbol: str) -> str:
    """A unit as tables and files write it, from its symbol; for example Nms2/rad for N·m·s²/rad."""
    return symbol.translate(_PLAIN)


def unit_symbol(unit: str) -> str:
    """A unit as text and figures show it, for example N·m·s²/rad for Nms2/rad."""
    return UNIT_SYMBOLS.get(unit, unit)
