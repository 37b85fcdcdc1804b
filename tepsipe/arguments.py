"""Arguments of the public functions: samples in SI units, numbers within their range, names.

Every public function reads its arguments here, so that a wrong type, shape, unit or value raises one
`InputError` that names the argument. `OPTIONS` lists the range of every option by its name.
"""

import math
import re
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from functools import cache
from itertools import combinations
from numbers import Integral, Real
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from tepsipe.errors import InputError, listed, nearest, quoted
from tepsipe.quantities import (
    HOLDS,
    LIMITS,
    Bins,
    Draws,
    InnerFraction,
    Length,
    Must,
    NotNegative,
    Positive,
    limit_in_words,
)
from tepsipe.quantities import unit_of as unit_at_end

T = TypeVar("T")
# conversion of units: (from, to) -> factor
FACTORS = {
    ("ms", "s"): 1e-3,
    ("us", "s"): 1e-6,
    ("mm", "m"): 1e-3,
    ("cm", "m"): 1e-2,
    ("mm/s", "m/s"): 1e-3,
    ("cm/s", "m/s"): 1e-2,
    ("km/h", "m/s"): 1.0 / 3.6,
    ("deg", "rad"): math.pi / 180.0,
    ("mrad", "rad"): 1e-3,
    ("deg/s", "rad/s"): math.pi / 180.0,
    ("Nmm", "Nm"): 1e-3,
    ("mNm", "Nm"): 1e-3,
    ("kNm", "Nm"): 1e3,
    ("mN", "N"): 1e-3,
    ("kN", "N"): 1e3,
    ("mV", "V"): 1e-3,
    ("uV", "V"): 1e-6,
}
SPELLINGS = {
    "N m": "Nm",
    "N*m": "Nm",
    "N·m": "Nm",
    "N mm": "Nmm",
    "N·mm": "Nmm",
    "degree": "deg",
    "degrees": "deg",
    "°": "deg",
    "Grad": "deg",
    "radian": "rad",
    "radians": "rad",
    "sec": "s",
    "seconds": "s",
    "m s-1": "m/s",
    "m·s-1": "m/s",
    "µV": "uV",
    "\N{GREEK SMALL LETTER MU}V": "uV",
    "milliseconds": "ms",
    "newton meter": "Nm",
}
# symbols of units in the end of a name, where "/" is written "_per_" or "_"
IN_NAMES = (
    r"_(s|ms|us|mrad|rad|degrees|deg|Nmm|mNm|kNm|Nm|kN|mN|N|mm|cm|m|mV|uV|V|(?:mm|cm|m|rad|deg)_(?:per_)?s)$"
)
# larger numbers have no unit of a joint, and their squares no floating-point number (any unit)
LARGEST = 1e12
# options of a model may differ from their default by this factor; these tuples may be empty
LARGEST_CHANGE = 20
MAY_BE_EMPTY = ("stop_radii_rad", "relaxation_times_s")
# longest step of a clock (s): movements of a joint need more samples than two in a second; and the shortest,
# faster than any converter
LONGEST_STEP_S = 0.5
SHORTEST_STEP_S = 1e-7


@dataclass(frozen=True)
class Range:
    """Numbers that an option can have."""

    low: float = -math.inf
    high: float = math.inf
    """Ends of the range (unit of the option)."""
    low_allowed: bool = True
    high_allowed: bool = True
    """Whether the ends belong to it."""
    whole: bool = False
    """Whether the number must be whole."""
    advice: str = "correct it"
    """Instruction at the end of the refusal."""

    def holds(self, x: float) -> bool:
        """Whether a number (unit of the option) lies within the range."""
        above = x >= self.low if self.low_allowed else x > self.low
        return math.isfinite(x) and above and (x <= self.high if self.high_allowed else x < self.high)

    def __str__(self) -> str:
        kind = "a whole number" if self.whole else "a number"
        first = f"{'from' if self.low_allowed else 'above'} {self.low:g}"
        last = f"{'to' if self.high_allowed else 'to below'} {self.high:g}"
        if not self.low_allowed and math.isfinite(self.high):
            last = f"and {'at most' if self.high_allowed else 'below'} {self.high:g}"
        parts = [kind, first if math.isfinite(self.low) else "", last if math.isfinite(self.high) else ""]
        if math.isfinite(self.low) and self.low_allowed and not math.isfinite(self.high):
            parts[1] = f"of at least {self.low:g}"
        return " ".join(part for part in parts if part)


def within(kind: Any, advice: str = "correct it") -> Range:
    """Range of a kind of `tepsipe.quantities`."""
    of, *marks = get_args(kind)
    limits = {name: getattr(mark, name) for mark in marks for name in LIMITS if hasattr(mark, name)}
    return Range(
        limits.get("gt", limits.get("ge", -math.inf)),
        limits.get("lt", limits.get("le", math.inf)),
        "gt" not in limits,
        "lt" not in limits,
        of is int,
        advice,
    )


POSITIVE, NOT_NEGATIVE, SHARE = within(Positive), within(NotNegative), within(InnerFraction)
# option -> its range; a type stands for any value of it
OPTIONS: dict[str, Range | type] = {
    "confidence": Range(0.5, 1.0, high_allowed=False, advice="give 0.95 for 95 %"),
    "bootstrap_draws": within(Draws, "give 2000"),
    "seed": Range(0, whole=True, advice="give any such number, for example 0"),
    "cutoff_hz": POSITIVE,
    "order": Range(1, 16, whole=True, advice="give 4"),
    "rate_hz": POSITIVE,
    "block_s": POSITIVE,
    "cut_s": NOT_NEGATIVE,
    "training_fraction": SHARE,
    "resample_rate_hz": POSITIVE,
    "rest_before_s": Range(0.1, advice="the noise of the belt is measured there"),
    "rest_after_s": NOT_NEGATIVE,
    "threshold_fraction": SHARE,
    "signal_to_noise": POSITIVE,
    "merge_s": Range(0.0, 10.0),
    "averaged_bins": within(Bins, "coherence needs averages"),
    "period_s": POSITIVE,
    "low_hz": NOT_NEGATIVE,
    "high_hz": NOT_NEGATIVE,
    "trimmed_s": NOT_NEGATIVE,
    "com_m": within(Length, "give metres"),
    "step_s": POSITIVE,
    "I": Range(-1e6, 1e6),
    "B": Range(-1e6, 1e6),
    "K": Range(-1e6, 1e6),
    "rest_angle_rad": Range(-0.5 * math.pi, 0.5 * math.pi, advice="give radians"),
    "velocity_scale": Range(-1e6, 1e6),
    "velocity_offset": Range(-1e6, 1e6),
    "thesis": bool,
    "softening": bool,
    "zero_lag": bool,
    "taper": bool,
    "centred": bool,
    "strict": bool,
    "name": str,
    "velocity": str,
    "time_column": str,
    "model": str,
}


def checked(optional: Sequence[str] = (), /, **options: object) -> tuple[Any, ...]:
    """Options of a public function as numbers of Python, in the order given; see `OPTIONS`.

    optional: names of options that may be None.
    Returns: int, float, bool or str, or None where it is optional (units in their names).
    """
    return tuple(
        None if value is None and name in optional else _option(name, value)
        for name, value in options.items()
    )


def _option(name: str, value: object) -> Any:
    wanted = OPTIONS[name]
    if not isinstance(wanted, type):
        return number(value, name, wanted)
    if wanted is bool and isinstance(value, bool | np.bool_):
        return bool(value)
    if wanted is str and isinstance(value, str):
        return str(value)
    kind = "True or False" if wanted is bool else "a text"
    raise InputError(f"{name}: expected {kind}, found {described(value)}: correct it")


def number(value: object, name: str, within: Range) -> float | int:
    """A single number as float or int of Python (unit of the argument).

    value: A number of Python or NumPy, also as an array without axes.
    name: names the argument in messages.
    """
    given = value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value
    try:
        # a duration of NumPy passes for an integer
        number = isinstance(given, Real) and not isinstance(given, bool | np.bool_ | np.timedelta64)
        x = float(given) if number else math.nan
    except OverflowError:
        x = math.inf
    if within.holds(x) and not within.whole and not (x == 0.0 or 1.0 / LARGEST <= abs(x) <= LARGEST):
        raise InputError(  # its product or quotient with another number may be infinite
            f"{name}: expected {within}, and zero or a size from {1.0 / LARGEST:g} to {LARGEST:g}, found "
            f"{described(value)}: correct its unit"
        )
    if not within.holds(x) or (within.whole and not isinstance(given, Integral)):
        raise InputError(f"{name}: expected {within}, found {described(value)}: {within.advice}")
    return int(given) if within.whole else x


def limits(values: object, name: str, size: int) -> np.ndarray:
    """Ends of ranges, shape (size,), which may be infinite (unit of the argument)."""
    if isinstance(values, Sequence) and all(isinstance(x, Real) for x in values):
        values = np.array([float(x) for x in values])
    infinite = np.isinf(values) if isinstance(values, np.ndarray) and values.dtype.kind == "f" else None
    if infinite is None:
        return samples(values, "", name, shape=(size,))
    finite = samples(np.where(infinite, 0.0, values), "", name, shape=(size,))
    return np.where(infinite, values, finite)


def described(value: object) -> str:
    """A value for a message: itself if it is short, otherwise its type, and its shape if it has one."""
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | float | str):
        return quoted(value)
    shape = getattr(value, "shape", None)
    kind = type(value).__name__
    if isinstance(shape, tuple):
        return f"{kind} of shape {tuple(int(n) if isinstance(n, int) else n for n in shape)}"
    return quoted(value) if isinstance(value, tuple | list) and len(str(value)) < 60 else quoted(kind)


def several(values: object) -> list | None:
    """Elements of a sequence or another iterable; None for a text, a mapping, or one value."""
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        return None
    try:
        return None if getattr(values, "ndim", 1) == 0 else list(values)
    except TypeError:  # a sparse matrix, for example
        return None


def texts(values: object, name: str) -> list[str]:
    """Several texts, such as labels of markers."""
    found = several(values)
    if found is None:
        raise InputError(f"{name}: expected several texts, found {described(values)}: give a list of names")
    for each in found:
        if not isinstance(each, str):
            raise InputError(f"{name}: expected texts, found {described(each)} among them: give names")
    return [str(each) for each in found]


def one_of(value: object, name: str, choices: Iterable[str]) -> str:
    """One of several names."""
    known = list(choices)
    if not isinstance(value, str) or value not in known:
        end = nearest(value, known) if isinstance(value, str) else "correct it"
        raise InputError(f"{name}: expected one of {listed(known)}, found {described(value)}: {end}")
    return str(value)


def pair(values: object, name: str, within: Range = NOT_NEGATIVE) -> tuple[float, float]:
    """Two numbers (unit of the argument), such as the ends of a band; infinity is allowed for the second."""
    try:
        first, second = values  # type: ignore[misc]
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{name}: expected two numbers, found {described(values)}: give a first and a second one"
        ) from error
    endless = isinstance(second, Real) and second == math.inf and math.isinf(within.high)
    return number(first, name, within), math.inf if endless else number(second, name, within)


def changed_options(kind: type[T], options: Mapping[str, object], function: str) -> T:
    """A dataclass of options, from those that differ from its defaults (units in the names of its fields).

    kind: the dataclass; every field has a default.
    options: fields that differ. Numbers must be of the kind of the default, and within the field's range.
    function: names the public function in messages.
    """
    defaults = {name: getattr(kind(), name) for name in kind.__dataclass_fields__}
    found = {}
    for name, value in options.items():
        if name not in defaults:
            raise InputError(
                f"{function}: expected an option of {kind.__name__}, found {quoted(name)}: "
                f"{nearest(name, defaults)}"
            )
        default = defaults[name]
        if isinstance(default, int | float):
            found[name] = number(value, name, _around(default))
        elif isinstance(default, tuple):
            found[name] = _numbers_like(default, value, name)
        elif value is None or isinstance(value, type(default)):
            found[name] = value
        else:
            raise InputError(
                f"{name}: expected {type(default or 0).__name__ if default else 'None'}, found "
                f"{described(value)}: leave it out"
            )
    check_options(kind, found, function)
    return kind(**found)


def _around(default: float) -> Range:
    """Numbers up to 20 times as large or small as a default: others are in another unit, or never end."""
    whole = isinstance(default, int)
    low = 1 if whole else default / LARGEST_CHANGE
    return Range(low, LARGEST_CHANGE * default, whole=whole, advice=f"the default is {default:g}")


def _numbers_like(default: tuple, value: object, name: str) -> tuple[float, ...]:
    """Several numbers of at least 0 (unit in the name); two where the default is the ends of a range."""
    if isinstance(value, Sequence | np.ndarray) and not len(value) and name in MAY_BE_EMPTY:
        return ()
    x = samples(value, "", name, shape=(2 if len(default) == 2 and name.endswith("delays_s") else None,))
    most = LARGEST_CHANGE * max(default)
    if (x < 0.0).any() or (x > most).any():
        raise InputError(
            f"{name}: expected numbers of at least 0 and at most {most:g}, found {x.min():g} to {x.max():g}: "
            "correct them"
        )
    if "delays" in name and not x[0] < x[1]:
        raise InputError(f"{name}: expected two numbers that increase, found {x.tolist()}: correct them")
    return tuple(x.tolist())


def path_of(value: object, name: str = "path") -> Path:
    """Path of a file, from a text or a path."""
    if isinstance(value, str | Path) and str(value) and "\0" not in str(value):
        return Path(value)
    raise InputError(f"{name}: expected the path of a file, found {described(value)}: give it as text")


# ---- options with their ranges in the types of a dataclass ---------------------------------------

PLAIN: dict[type, tuple[Any, str]] = {
    float: (Real, "number"),
    int: (Integral, "integer"),
    str: (str, "string"),
    bool: ((bool, np.bool_), "boolean"),
}


def check_options(kind: type, values: object, place: str) -> None:
    """Refuse values outside the types and ranges of a dataclass's fields (see `tepsipe.quantities`).

    values: an instance, or a mapping of some or all of its fields.
    place: names the values in messages.
    """
    for name, value in (values if isinstance(values, Mapping) else vars(values)).items():
        if name not in _hints(kind):
            raise InputError(f"{place}: unknown key {quoted(name, 120)}: {nearest(name, _hints(kind))}")
        _Place(place, name).check(_hints(kind)[name], value)


def read_options(
    kind: Callable[..., Any], values: object, place: str, keys: Iterable[str] | None = None
) -> dict[str, Any]:
    """Checked options of a dataclass or function from keys and values of a file.

    keys: those that may be given; by default all fields of a dataclass, of which some must be.
    """
    if not isinstance(values, Mapping):
        raise InputError(f"{place}: expected keys and values, found {described(values)}: correct it")
    kinds = get_type_hints(kind, include_extras=True)
    known = list(kinds if keys is None else keys)
    for name in values:
        if name not in known:
            raise InputError(f"{place}: expected a known key, found {quoted(name)}: {nearest(name, known)}")
    for field in fields(kind) if keys is None else ():  # type: ignore[arg-type]
        if field.name not in values and field.default is MISSING and field.default_factory is MISSING:
            raise InputError(f"{place}: expected the key {field.name}, found none: add it")
    for name, value in values.items():
        _Place(place, name).check(kinds[name], value)
    return {name: _value_of(kinds[name], value) for name, value in values.items()}


def options_of(kind: type[T], section: Mapping[str, Any]) -> T:
    """A dataclass of options from a section: sections within it become dataclasses, lists become tuples."""
    return kind(**{name: _value_of(_hints(kind)[name], value) for name, value in section.items()})


def _value_of(kind: Any, value: Any) -> Any:
    parts = get_args(kind)
    if get_origin(kind) in (Annotated, Union, types.UnionType):
        return _value_of(next(part for part in parts if part is not type(None)), value)
    if isinstance(value, Mapping):
        if is_dataclass(kind):
            return options_of(kind, value)  # type: ignore[arg-type]
        return {name: _value_of(parts[-1] if parts else Any, item) for name, item in value.items()}
    if isinstance(value, list):
        return tuple(_value_of(parts[0] if parts else Any, item) for item in value)
    return value


@cache
def _hints(kind: type) -> dict[str, Any]:
    hints = get_type_hints(kind, include_extras=True)
    return {field.name: hints[field.name] for field in fields(kind)}


@dataclass(frozen=True)
class _Place:
    """Place of a value that is checked."""

    place: str
    key: str
    unit: str = ""
    otherwise: str = ""
    """What the value may be besides."""

    def check(self, kind: Any, value: Any) -> None:
        """Refuse a value that is not of a kind, or beyond its limits."""
        origin, parts = get_origin(kind), get_args(kind)
        if origin is Annotated:
            here = replace(self, unit=next((mark for mark in parts if isinstance(mark, str)), self.unit))
            here.check(parts[0], value)
            for mark in parts[1:]:
                here._check_limit(mark, value)
        elif origin in (Union, types.UnionType):
            empty = type(None) in parts
            if value is not None or not empty:
                here = replace(self, otherwise=" or null" if empty else "")
                here.check(next(part for part in parts if part is not type(None)), value)
        elif origin is Literal:
            if not any(value == name and isinstance(value, bool) == isinstance(name, bool) for name in parts):
                self._refuse(f"one of {', '.join(map(repr, parts))}", value)
        elif origin in (Sequence, list, tuple, Mapping, dict):
            mapping, items = origin in (Mapping, dict), several(value)
            if mapping != isinstance(value, Mapping) or (not mapping and items is None):
                self._refuse(f"a value of type {'object' if mapping else 'array'}", value)
            for name, item in value.items() if mapping else enumerate(items or ()):
                replace(self, key=f"{self.key}.{name}").check(parts[1 if mapping else 0], item)
        elif is_dataclass(kind):
            if not isinstance(value, (Mapping, kind)):
                self._refuse("a value of type object", value)
            check_options(kind, value, f"{self.place}.{self.key}")
        elif kind in PLAIN:
            wanted, word = PLAIN[kind]
            given = value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value
            if not isinstance(given, wanted) or isinstance(given, bool | np.bool_) != (kind is bool):
                self._refuse(f"a value of type {word}{self.otherwise}", value)
            if kind is float and not math.isfinite(given):
                self._refuse("a finite number", value)

    def _check_limit(self, mark: object, value: Any) -> None:
        if isinstance(mark, Must) and not mark.holds(value):
            self._refuse(mark.expected, value, mark.advice)
        for name, holds in HOLDS.items():
            limit = getattr(mark, name, None)
            if limit is not None and not holds(value, limit):
                unit = self.unit or unit_at_end(self.key.split(".")[0])
                number = isinstance(value, Real) and unit
                advice = f"correct it; its unit is {unit}" if number else "correct it"
                self._refuse(limit_in_words(name, limit, value), value, advice)

    def _refuse(self, expected: str, value: object, advice: str = "correct it") -> NoReturn:
        key = quoted(self.key, 120)
        raise InputError(f"{self.place}: expected {expected} for {key}, found {described(value)}: {advice}")


# ---- samples -------------------------------------------------------------------------------------


def factor(unit: str, wanted: str, name: str) -> float:
    """Factor that converts samples from ``unit`` to ``wanted`` (unit of ``wanted`` over ``unit``).

    name: names the signal in messages.
    Returns: the factor (unit of ``wanted`` over ``unit``).
    """
    unit = unit.strip().replace(" / ", "/")
    unit = SPELLINGS.get(unit, unit)
    if unit == wanted:
        return 1.0
    if (unit, wanted) in FACTORS:
        return FACTORS[unit, wanted]
    if (wanted, unit) in FACTORS:
        return 1.0 / FACTORS[wanted, unit]
    known = sorted({wanted, *(a for a, b in FACTORS if b == wanted)})
    raise InputError(
        f"{name}: expected a unit of {', '.join(known)}, found {quoted(unit)}: convert the signal, or "
        "correct its unit"
    )


def unit_in(name: str) -> str:
    """Unit at the end of a column's name, as in ``Torque (Nm)``, ``angle [rad]`` or ``time_s``; or empty."""
    bracketed = re.search(r"[(\[]([^()\[\]]+)[)\]]\s*$", name)
    if bracketed:
        unit = bracketed.group(1).strip()
        return SPELLINGS.get(unit, unit)
    ending = re.search(IN_NAMES, name)
    return ending.group(1).replace("_per_", "/").replace("_", "/") if ending else ""


def unit_of(values: object, unit: str | None, name: str) -> tuple[str, bool]:
    """Unit in which samples are given, and whether only their own name shows it.

    values: Samples: a `Signal`, a quantity of pint or astropy, an xarray with the attribute ``units``, a
    pandas column whose name ends in a unit, or numbers.
    unit: unit in which plain numbers are given; None for any.
    name: names the argument in messages.

    Returns:
        unit: the unit; empty where there is none.
        by_name: whether the name of the samples shows it.
    """
    attributes = getattr(values, "attrs", None)
    for place, key in ((attributes, "units"), (attributes, "unit")):
        if isinstance(place, dict) and place.get(key) is not None:
            return str(place[key]), False
    if hasattr(values, "unit") and (hasattr(values, "values") or hasattr(values, "value")):
        return str(values.unit), False
    label = getattr(values, "name", None)
    if unit is None or not isinstance(label, str) or not hasattr(values, "dtype"):
        return unit or "", False
    return unit_by_name(label, unit, name)


def unit_by_name(label: str, unit: str, name: str) -> tuple[str, bool]:
    """Unit in which a name ends, if samples in ``unit`` can have it, and whether it differs from ``unit``."""
    found = unit_in(label)
    found = SPELLINGS.get(found, found)
    if (found, unit) in FACTORS:
        return found, True
    # one letter at the end of a name may be an index
    if found != unit and len(found) > 1 and any(found in pair for pair in FACTORS):
        raise InputError(
            f"{name}: expected samples in {unit}, found the name {quoted(label)}, which ends in {found}: "
            "check that the columns are not exchanged, or rename it"
        )
    return unit, False


def samples(
    values: object, unit: str | None, name: str, *, shape: Sequence[int | None] | None = (None,)
) -> np.ndarray:
    """Samples as floating-point numbers in ``unit``.

    values: samples in ``unit``. They are converted if they name another one: a `Signal`, a quantity of pint
    or astropy, an xarray with the attribute ``units``, a pandas column such as ``angle_deg``.
    unit: required unit; None for any.
    name: names the argument in messages.
    shape: required shape, None for any length; None for any shape with at least one axis.
    Returns: the samples (``unit``).
    """
    x = _converted(values, unit, name)
    if shape is None:
        shape = (None,) * max(1, x.ndim)
    if len(x.shape) != len(shape) or any(
        wanted not in (None, n) for wanted, n in zip(shape, x.shape, strict=True)
    ):
        wanted_shape = ", ".join("n" if n is None else str(n) for n in shape)
        raise InputError(
            f"{name}: expected an array of shape ({wanted_shape}), found {tuple(map(int, x.shape))}: "
            "select or transpose its axes"
        )
    if not x.size:
        raise InputError(f"{name}: expected samples, found an empty array: check what was read")
    bad = int(np.count_nonzero(~np.isfinite(x)))
    if bad:
        first = int(np.argmax(~np.isfinite(x).reshape(x.shape[0], -1).all(axis=1)))
        raise InputError(
            f"{name}: expected a number for every sample, found {bad} of {x.size} missing, masked or "
            f"infinite, the first at sample {first}: fill or cut the gaps first"
        )
    if np.abs(x).max() > LARGEST:
        raise InputError(
            f"{name}: expected values of at most {LARGEST:g} {unit or ''}".rstrip()
            + f", found {np.abs(x).max():.3g}: correct its unit"
        )
    return x


def _converted(values: object, unit: str | None, name: str) -> np.ndarray:
    """Numbers in ``unit``, NaN where one is masked or missing."""
    if hasattr(values, "m_as") and hasattr(values, "units"):  # pint
        try:
            values = values.magnitude if unit is None else values.m_as(_spelt_out(unit))
        except Exception as error:  # pint's own, which need not be installed
            raise InputError(
                f"{name}: expected a unit that converts to {unit or 1}, found {quoted(values.units)}: "
                "correct it"
            ) from error
        return _numbers(values, name)
    given = unit_of(values, unit, name)[0]
    samples_only = values
    if hasattr(values, "unit") and (hasattr(values, "values") or hasattr(values, "value")):
        samples_only = values.values if hasattr(values, "values") else values.value
    x = _numbers(samples_only, name)
    scale = 1.0 if unit is None or (not given and not unit) else factor(given, unit, name)
    return scale * x


def _spelt_out(unit: str) -> str:
    """A unit as pint knows it: N*m for Nm."""
    return {"Nm": "N*m", "": "dimensionless"}.get(unit, unit)


def _numbers(values: object, name: str) -> np.ndarray:
    """Floating-point numbers, NaN where one is masked or missing."""
    try:
        if isinstance(values, np.ma.MaskedArray):
            x = np.ma.getdata(values)
            hidden = np.ma.getmaskarray(values)
        else:
            if hasattr(values, "isna") and hasattr(values, "to_numpy") and np.ndim(values) == 1:
                # pandas has numbers whose missing ones are no NaN
                gaps = np.asarray(values.isna(), dtype=bool)
                values = values.to_numpy(dtype=float, na_value=np.nan) if gaps.any() else values.to_numpy()
            x, hidden = np.asarray(values), None
        if x.dtype.kind not in "fiu":
            raise TypeError(f"{x.dtype} is no real number")
        x = x.astype(float)
    except Exception as error:  # an object of another package may raise anything when it is converted
        raise InputError(
            f"{name}: expected an array of numbers, found {_kind(values, error)}: correct it"
        ) from error
    if hidden is not None and hidden.any():
        x = np.where(hidden, np.nan, x)
    return x


def _kind(values: object, error: Exception) -> str:
    """Reason why something is no array of numbers."""
    if "setting an array element" in str(error):
        return "rows of different lengths or parts that are no numbers"
    kind = getattr(getattr(values, "dtype", None), "kind", "")
    if kind and kind in "Mm":
        return "dates or durations, where seconds are needed"
    return (
        described(values)
        if values is None or isinstance(values, str | bool | int | float)
        else quoted(f"{type(values).__name__}: {error}", 80)
    )


def regular_rate(time: object, name: str = "time") -> tuple[np.ndarray, float]:
    """Instants on a regular clock, and their rate.

    name: names the argument in messages.

    Returns:
        time: the instants (s).
        rate_hz: sampling rate (Hz).
    """
    t = samples(time, "s", name)
    if t.size < 8:
        raise InputError(f"{name}: expected at least 8 instants, found {t.size}: record longer")
    step = np.diff(t)
    mean = float((t[-1] - t[0]) / (t.size - 1))
    if not mean > 0.0 or not (step > 0.0).all():
        at = int(np.argmax(step <= 0.0))
        raise InputError(
            f"{name}: expected instants that increase, found {t[at + 1]:.6g} s after {t[at]:.6g} s: sort the "
            "samples, and drop repeated ones"
        )
    worst = int(np.argmax(np.abs(step - mean)))
    if mean < SHORTEST_STEP_S:
        raise InputError(
            f"{name}: expected seconds, found steps of {mean:.6g} s: convert the instants to seconds"
        )
    if mean > LONGEST_STEP_S:
        raise InputError(
            f"{name}: expected seconds, found steps of {mean:.6g}, which look like milliseconds or numbers "
            f'of samples: give Signal({name}, "ms"), or divide by the sampling rate'
        )
    if abs(step[worst] - mean) > 0.01 * mean:
        raise InputError(
            f"{name}: expected a regular clock, found steps of {step[worst]:.6g} s and {mean:.6g} s on "
            "average: resample all signals to a regular clock first"
        )
    return t, float(f"{1.0 / mean:.12g}")  # 250 Hz, not 250.00000000000003 Hz


def same_length(time: np.ndarray, **signals: np.ndarray) -> None:
    """Refuse signals that have not one sample per instant (s); the names of the arguments name them."""
    for name, x in signals.items():
        if x.shape[0] != time.size:
            raise InputError(
                f"{name}: expected {time.size} samples, as many as instants, found {x.shape[0]}: cut or "
                "resample one of the two"
            )


def refuse_constant(**signals: np.ndarray) -> None:
    """Refuse signals that do not change beyond rounding; the names of the arguments name them."""
    for name, x in signals.items():
        if np.ptp(x) <= 1e-12 * max(1e-6, float(np.abs(x).max())):
            raise InputError(
                f"{name}: expected a signal that changes, found {x.flat[0]:.6g} throughout: check that the "
                "joint was perturbed and the right column chosen"
            )


def refuse_same(**signals: np.ndarray) -> None:
    """Refuse two signals (any unit) that are the same samples; the names of the arguments name them."""
    for (first, x), (second, y) in combinations(signals.items(), 2):
        if x.shape == y.shape and np.array_equal(x, y):
            raise InputError(
                f"{second}: expected another signal than {first}, found the same samples in both: check "
                "which columns were chosen"
            )


def plausible_angle(angle: np.ndarray) -> np.ndarray:
    """The angle (rad), shape (n,), refused where it looks like degrees."""
    largest = float(np.abs(angle).max())
    if largest > 4.0 * math.pi:
        raise InputError(
            f"angle: expected radians, found {largest:.3g}, which looks like degrees: give "
            'Signal(angle, "deg")'
        )
    return angle
