"""Kinds of values with their physical ranges: wide enough for any rig, too narrow for a wrong unit."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from workflow.settings.section import UnfitError, number, whole

Mass = number(above=0, most=500)  # kg
PartMass = number(above=0, most=100)  # kg, of a foot or a leg
Length = number(above=0, most=3)  # m
Height = number(least=0, most=3)  # m
Offset = number(least=-3, most=3)  # m
Stature = number(least=0.4, most=2.6)  # m
Gravity = number(least=9.7, most=9.9)  # m/s²
Inertia = number(least=0, most=20)  # kg·m² or N·m·s²/rad
Damping = number(least=0, most=1000)  # N·m·s/rad
Stiffness = number(above=0, most=20000)  # N·m/rad
Angle = number(least=-3.2, most=3.2)  # rad
Velocity = number(above=0, most=10)  # m/s
Acceleration = number(above=0, most=1000)  # m/s²
Torque = number(above=0, most=5000)  # N·m
Time = number(above=0, most=3600)  # s
Pause = number(least=0, most=3600)  # s
Delay = number(least=0, most=1)  # s
Rate = number(above=0, most=100000)  # Hz, of sampling
Frequency = number(least=0.01, most=5000)  # Hz
Positive = number(above=0)
NotNegative = number(least=0)
Fraction = number(least=0, most=1)
InnerFraction = number(above=0, below=1)

FilterOrder = whole(2, 4, 6, 8)
Side = Literal["left", "right"]
Direction = Literal["+x", "-x", "+y", "-y", "+z", "-z"]
Sign = whole(1, -1)
AngleUnit = Literal["rad", "deg"]
Delimiter = Literal["comma", "tab", "semicolon"]
Distribution = Literal["normal", "rectangular", "triangular"]


def _ordered(values: list[float]) -> list[float]:
    if not values[0] < values[1]:
        raise UnfitError("from low to high", "turn it round")
    return values


def _different(values: list) -> list:
    if len({repr(value) for value in values}) < len(values):
        raise PydanticCustomError("different_items", "two items are the same")
    return values


def _not_zero(value: float) -> float:
    if value == 0.0:
        raise UnfitError("other than 0", "state the unit of the channel")
    return value


Scale = Annotated[float, AfterValidator(_not_zero)]  # per unit of a channel


def band(of: Any = NotNegative) -> Any:
    """Type of two numbers from low to high."""
    return Annotated[list[of], Field(min_length=2, max_length=2), AfterValidator(_ordered)]


def fixed(of: Any, count: int) -> Any:
    """Type of a list of so many values."""
    return Annotated[list[of], Field(min_length=count, max_length=count)]


def different(of: Any, least: int = 1) -> Any:
    """Type of a list of different values, at least so many."""
    return Annotated[list[of], Field(min_length=least), AfterValidator(_different)]


def some(of: Any, least: int = 1) -> Any:
    """Type of a list of at least so many values."""
    return Annotated[list[of], Field(min_length=least)]


def named(of: Any, pattern: str = ".") -> Any:
    """Type of a mapping of at least one entry, whose names have a pattern."""
    return Annotated[dict[Annotated[str, Field(pattern=pattern)], of], Field(min_length=1)]
