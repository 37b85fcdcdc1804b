"""Kinds of values for sections that are not made from a dataclass of the library."""

from typing import Annotated, Any

from annotated_types import Len, MinLen
from pydantic import Field

from tepsipe import quantities
from tepsipe.quantities import (
    ASCENDING,
    DIFFERENT,
    Acceleration,
    Angle,
    AngleUnit,
    Damping,
    Delay,
    Delimiter,
    Direction,
    Distribution,
    Fraction,
    Frequency,
    Gravity,
    Height,
    Inertia,
    InnerFraction,
    Length,
    Mass,
    NotNegative,
    Offset,
    PartMass,
    Pause,
    Positive,
    Rate,
    Side,
    Stature,
    Stiffness,
    Time,
    Torque,
    Velocity,
)
from workflow.settings.section import modelled, number, whole

__all__ = [
    "Acceleration",
    "Angle",
    "AngleUnit",
    "Damping",
    "Delay",
    "Delimiter",
    "Direction",
    "Distribution",
    "Fraction",
    "Frequency",
    "Gravity",
    "Height",
    "Inertia",
    "InnerFraction",
    "Length",
    "Mass",
    "NotNegative",
    "Offset",
    "PartMass",
    "Pause",
    "Positive",
    "Rate",
    "Side",
    "Stature",
    "Stiffness",
    "Time",
    "Torque",
    "Velocity",
    "number",
    "whole",
]

# those that the model checks in its own way
FilterOrder, Sign, Scale = map(modelled, (quantities.FilterOrder, quantities.Sign, quantities.Scale))


def band(of: Any = NotNegative) -> Any:
    """Type of two numbers from low to high."""
    return modelled(Annotated[list[of], Len(2, 2), ASCENDING])


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
