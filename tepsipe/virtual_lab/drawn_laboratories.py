"""Laboratories drawn at random around the constants of a configuration file.

A laboratory is measured with a ruler, a scale and clocks, so its true constants differ from the numbers that
the analysis uses. The section ``drawn`` gives constants, by their path, a distribution around the number in
the file. Each number has its own generator, seeded by the laboratory's seed and the path, so that a further
entry changes no other draw.

A mass, a share or a rate that is drawn relative to its number keeps the number's sign. An entry may require
its numbers to be positive, or below a limit such as 1 for a share: a draw beyond is repeated by the same
generator. The distribution is thus truncated, and other numbers, of this laboratory and of others, do not
change.
"""

import copy
import math
from dataclasses import dataclass, replace
from random import Random
from statistics import NormalDist, pstdev

DISTRIBUTIONS = ("normal", "rectangular", "student")
# distributions of a number itself, which has no nominal value
FREE = ("log_uniform", "one_of")
FURTHER = ("relative", "shift", "positive", "below")
# draws of one number until one has the right sign
TRIES = 1000


@dataclass(frozen=True)
class DrawnNumber:
    """One number of the laboratory and its drawn value."""

    path: str
    """Keys and, within lists, positions from 0, joined by dots."""
    nominal: float
    value: float
    """Number of the file, and of the laboratory (unit of the key)."""
    distribution: str
    """{"normal", "rectangular", "student", "log_uniform", "one_of"}: Its shape."""
    standard_deviation: float
    """Standard deviation of the distribution (unit of the key)."""


def draw_laboratory(constants: dict) -> dict:
    """Constants of one laboratory, drawn from the section ``drawn``.

    constants: the laboratory's configuration, with ``seed`` and ``drawn``: path of a number, or of a list
    of numbers, which are drawn one by one -> ``{"normal": standard deviation}``, ``{"rectangular": half
    width}`` or ``{"student": [standard deviation, degrees of freedom]}``, in the unit of the key, or with
    ``"relative": True`` as parts of the number, whose sign stays. ``"shift"`` moves the mean of each number
    by so many standard deviations up or, as likely, down. With ``"positive": True`` draws of 0 or less are
    repeated; with ``"below"``, draws at or above a limit (unit of the key). ``{"log_uniform": [least,
    most]}`` and ``{"one_of": [values]}`` replace the number by a draw that does not depend on it. None
    draws nothing.
    Returns: the constants after drawing, with None for ``drawn``: drawing them again changes nothing.
    """
    drawn = copy.deepcopy(constants)
    for number in drawn_numbers(constants):
        *holders, last = number.path.split(".")
        place = drawn
        for key in holders:
            place = place[int(key)] if isinstance(place, list) else place[key]
        place[int(last) if isinstance(place, list) else last] = number.value
    drawn["drawn"] = None
    return drawn


def drawn_numbers(constants: dict) -> list[DrawnNumber]:
    """List the numbers that `draw_laboratory` draws.

    constants: the laboratory's configuration, as for `draw_laboratory`.
    Returns: in the order of the section and, within it, of the lists (units of the keys).
    """
    numbers: dict[str, DrawnNumber] = {}
    for path, choice in (constants.get("drawn") or {}).items():
        shape, spread, freedom = _shape(path, choice)
        free = shape in FREE
        for where, nominal in _numbers(constants, path):
            if where in numbers:
                raise ValueError(
                    f"expected every number to be drawn once, found {where!r} twice in 'drawn', the second "
                    f"time as {path!r}: take one of the two out"
                )
            deviation = spread * abs(nominal) if choice.get("relative", False) else spread
            if deviation == 0.0 < spread:
                raise ValueError(
                    f"expected a number other than 0 for the relative entry {path!r} of 'drawn', found 0 for "
                    f"{where!r}: make it absolute"
                )
            random = Random(f"{constants['seed']}/{where}")
            entry = DrawnNumber(where, nominal, nominal, shape, deviation)
            value = _free_value(shape, choice, random) if free else _value(entry, freedom, choice, random)
            numbers[where] = replace(entry, value=value)
    return list(numbers.values())


def _value(number: DrawnNumber, freedom: float, choice: dict, random: Random) -> float:
    """A draw (unit of the number) within its limits."""
    first = _standardised(number.distribution, freedom, random)
    mean = 0.0
    if choice.get("shift"):
        mean = choice["shift"] * (1.0 if random.random() < 0.5 else -1.0)
    positive, below = choice.get("positive", False), choice.get("below", math.inf)
    if (positive and number.nominal <= 0.0) or number.nominal >= below:
        raise ValueError(
            f"expected {number.path!r} where its entry in 'drawn' says that it lies (positive, below), found "
            f"{number.nominal:g}: correct one of the two"
        )
    keeps = choice.get("relative", False) or positive
    for _ in range(TRIES):
        value = number.nominal + number.standard_deviation * first
        if mean:
            value += mean * number.standard_deviation
        if value < below and (not keeps or value * number.nominal > 0.0):
            return value
        first = _standardised(number.distribution, freedom, random)
    raise ValueError(
        f"expected a distribution of {number.path!r} in 'drawn' with the sign of {number.nominal:g} and "
        f"below its limit, found none of {TRIES} draws there: make it narrower, or its shift smaller"
    )


def _free_value(shape: str, choice: dict, random: Random) -> float:
    """A draw of a number without a nominal value (unit of the number)."""
    if shape == "one_of":
        return random.choice(choice[shape])
    low, high = choice[shape]
    return low * (high / low) ** random.random()


def _shape(path: str, choice: dict) -> tuple[str, float, float]:
    """Shape, standard deviation and degrees of freedom of an entry."""
    named = [name for name in (*DISTRIBUTIONS, *FREE) if name in choice]
    known = {*named} if named and named[0] in FREE else {*DISTRIBUTIONS, *FURTHER}
    if len(named) != 1 or set(choice) - known:
        raise ValueError(
            f"expected one of {', '.join((*DISTRIBUTIONS, *FREE))} for the entry {path!r} of 'drawn', the "
            f"first three with or without {', '.join(map(repr, FURTHER))}, found "
            f"{', '.join(map(str, choice)) or 'nothing'}: correct it"
        )
    shape = named[0]
    if shape in FREE:
        return shape, _free_deviation(path, shape, choice[shape]), math.inf
    width, freedom = choice[shape] if shape == "student" else (choice[shape], math.inf)
    if not width >= 0.0 or not freedom > 2.0:
        raise ValueError(
            f"expected a width of at least 0 and more than 2 degrees of freedom for the entry {path!r} of "
            f"'drawn', found {choice[shape]}: correct it"
        )
    return shape, (width / math.sqrt(3.0) if shape == "rectangular" else width), freedom


def _free_deviation(path: str, shape: str, values: list[float]) -> float:
    """Standard deviation of a distribution without a nominal value (unit of the number)."""
    if shape == "one_of":
        if not values:
            raise ValueError(f"expected values for the entry {path!r} of 'drawn', found none: name them")
        return pstdev(values)
    low, high = values
    if not 0.0 < low < high:
        raise ValueError(
            f"expected two ascending numbers above 0 for the entry {path!r} of 'drawn', found {values}: "
            "correct it"
        )
    span = math.log(high / low)
    mean = (high - low) / span
    return math.sqrt((high**2 - low**2) / (2.0 * span) - mean**2)


def _standardised(shape: str, freedom: float, random: Random) -> float:
    """A draw of the shape with mean 0 and standard deviation 1."""
    u = (int(random.random() * 2.0**52) + 0.5) / 2.0**52  # never 0 nor 1
    if shape == "rectangular":
        return math.sqrt(3.0) * (2.0 * u - 1.0)
    if shape == "normal":
        return NormalDist().inv_cdf(u)
    # R. W. Bailey (1994), Polar generation of random variates with the t-distribution, Mathematics of
    # Computation 62, 779-781
    t = math.sqrt(freedom * (u ** (-2.0 / freedom) - 1.0)) * math.cos(2.0 * math.pi * random.random())
    return t * math.sqrt((freedom - 2.0) / freedom)


def _numbers(constants: dict, path: str) -> list[tuple[str, float]]:
    """Full path and number of everything at a path."""
    place: object = constants
    for key in path.split("."):
        inside = range(len(place)) if isinstance(place, list) else place if isinstance(place, dict) else ()
        wanted = int(key) if isinstance(place, list) and key.isdigit() else key
        if wanted not in inside or wanted == "drawn":
            raise ValueError(
                f"expected every entry of 'drawn' to name a constant, found {path!r}: correct it, or take it "
                "out"
            )
        place = place[wanted]  # type: ignore[index]
    return _leaves(place, path, path)


def _leaves(place: object, path: str, entry: str) -> list[tuple[str, float]]:
    if isinstance(place, list):
        return [leaf for k, part in enumerate(place) for leaf in _leaves(part, f"{path}.{k}", entry)]
    if isinstance(place, bool) or not isinstance(place, float | int) or path == "seed":
        raise ValueError(
            f"expected the entry {entry!r} of 'drawn' to name a number or a list of numbers, found "
            f"{str(place)[:60]!r}: correct it"
        )
    return [(path, float(place))]
