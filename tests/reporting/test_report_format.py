"""Numbers as the report prints them: Typst's helpers agree with Python's rounding, character by character."""

import csv
import io
import math
import random
import re

import pytest
from typst_builders import evaluated

from tepsipe.drawing.names import MINUS, SUPERSCRIPTS, by_uncertainty, number

QUANTITIES = ("VAF_trial", "I", "B", "K", "SEM_K", "error")


# ---- the rules in Python


def percent(value: float, decimals: int = 1) -> str:
    """A percentage (%) as text; a dash for NaN, powers of ten for what is far from one."""
    if not math.isfinite(value) or abs(value) >= 1e7:
        return number(value, 2)
    return fixed(value, decimals)


def fixed(value: float, decimals: int) -> str:
    """A number (any unit) as text with ``decimals`` decimals; never a negative zero."""
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}".replace("-", MINUS)


def span(values, digits: int = 3) -> str:
    """Lowest to highest of some numbers (any unit) as text."""
    low, high = number(min(values), digits), number(max(values), digits)
    return low if low == high else f"{low} to {high}"


def span_of_decimals(values, decimals: int) -> str:
    """Lowest to highest of some numbers (any unit) as text, with ``decimals`` decimals."""
    low, high = (fixed(x, decimals) for x in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def cell(quantity: str, value: float | None) -> str:
    if value is None or not math.isfinite(value):
        return number(value)
    if quantity.startswith("VAF"):
        return percent(value, 2 if value > 99.0 else 1)
    if quantity in ("I", "B"):
        return fixed(value, 4)
    if quantity == "K":
        return fixed(value, 3)
    return number(value, 2)


def printed(value: float | None) -> str:
    if value is None:
        return number(None)
    mantissa, _, exponent = f"{value:g}".partition("e")
    if exponent:
        mantissa += f"·10{str(int(exponent)).translate(SUPERSCRIPTS)}"
    return mantissa.replace("-", MINUS)


def plain(value: float, digits: int = 3) -> str:
    """A number (any unit) without powers of ten: 0.00008, 2650."""
    text = f"{float(f'{value:.{digits}g}'):.9f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text.replace("-", MINUS)


def beside(value: float, deviation: float) -> str:
    """A value (any unit) to two significant digits of its standard deviation."""
    if not deviation > 0.0:
        return plain(value, 5)
    return plain(round(value, 1 - math.floor(math.log10(deviation))), 12)


# ---- cases


def values() -> list[float]:
    """Random values of all magnitudes, ties of the printed digits, powers of ten and their neighbours."""
    draw = random.Random(23)
    found = [0.0, -0.0, math.inf, -math.inf, math.nan, 1e-300, 1e300, 0.1 + 0.2]
    found += [draw.choice((-1, 1)) * 10.0 ** draw.uniform(-12, 12) for _ in range(600)]
    found += [draw.choice((-1, 1)) * 10.0 ** draw.uniform(-4, 6) for _ in range(600)]
    # as tables are written
    found += [float(f"{draw.uniform(-100, 100):.10g}") for _ in range(200)]
    # one digit more than is printed, and that is a five: the binary value decides, or the even digit
    for _ in range(800):
        found.append(float(f"{draw.randint(0, 9999)}5e{draw.randint(-9, 5)}"))
    found += [n + half for n in range(-40, 40) for half in (0.5, 0.25, 0.125, 0.375, 0.625, 0.0625)]
    for exponent in range(-12, 13):
        for factor in (1.0, 9.995, 9.5, 99.5, 0.9999999, 9.9999999):
            x = factor * 10.0**exponent
            found += [x, math.nextafter(x, 0.0), math.nextafter(x, math.inf), -x]
    return found


def rows() -> list[tuple[list, list[str]]]:
    """A case (function and arguments, as the cells of a table) and the text that Python makes of it."""
    found = []
    for x in values():
        found += [(["num", x, digits], number(x, digits)) for digits in (2, 3, 4)]
        found.append((["percent", x, 1], percent(x, 1)))
        if math.isfinite(x):
            found += [(["fixed", x, decimals], fixed(x, decimals)) for decimals in (0, 1, 2, 4)]
        if not math.isinf(x):
            found.append((["short", x, 0], number(None) if math.isnan(x) else printed(x + 0.0)))
    draw = random.Random(7)
    plain_values = [x for x in values() if not math.isnan(x)]
    for _ in range(800):
        x, half = draw.choice(plain_values), abs(draw.choice(plain_values))
        low, high = x - half, x + draw.choice((0.0, 0.3, 1.0)) * half
        if not (math.isnan(low) or math.isnan(high)):
            value, interval = by_uncertainty(x, low, high)
            found.append((["interval", x, low, high], f"{value}|{interval}"))
        pair = [draw.choice(plain_values) for _ in range(3)]
        found.append((["span", *pair], span(pair)))
        if all(map(math.isfinite, pair)):
            found.append((["decimals", *pair], span_of_decimals(pair, 2)))
    for x in (x for x in plain_values if math.isfinite(x) and 1e-4 < abs(x) < 1e6):
        found.append((["plain", x], plain(x)))
        deviation = abs(x) * 10.0 ** draw.uniform(-3, 1)
        found.append((["beside", x, deviation], beside(x, deviation)))
    for quantity in QUANTITIES:
        found += [(["cell", x, quantity], cell(quantity, x)) for x in draw.sample(values(), 400)]
    return found


# a loop, because Typst would remember every row
DISPATCH = """
let different = ()
for (name, x, y, z, told) in csv("cases.csv") {
  let text = if name == "num" { num(x, digits: int(y)) } else if name == "percent" { percent(x) }
    else if name == "fixed" { fixed(x, int(y)) } else if name == "short" { short(x) }
    else if name == "interval" { interval(x, y, z).join("|") } else if name == "span" { span((x, y, z)) }
    else if name == "plain" { plain-number(x) } else if name == "beside" { beside(x, y) }
    else if name == "decimals" { span-of-decimals((x, y, z), 2) } else { cell-of(y, x) }
  if text != told { different.push((name, x, y, z, told)) }
}
different
"""


@pytest.mark.slow
def test_helpers_of_the_report_round_as_python_does():
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    cases = rows()
    assert len(cases) > 20_000
    for case, told in cases:
        if re.search(r"[\d.]{17,}", told):  # more digits than a number has
            continue
        padded = [repr(c) if isinstance(c, float) else c for c in case] + ["", ""]
        writer.writerow([*padded[:4], told])
    (different,) = evaluated([DISPATCH.strip()], "format.typ", files={"cases.csv": text.getvalue()})
    assert different == []


@pytest.mark.parametrize(
    ("expression", "told"),
    [
        ("num(9.9664)", "9.97"),
        ("num(0.015043)", "0.0150"),
        ("num(123.4)", "123"),
        ("num(-0.25, digits: 2)", "\N{MINUS SIGN}0.25"),
        ("num(0.0)", "0"),
        ("num(0.0002, digits: 2)", "2.0·10⁻⁴"),
        ("num(-1.5e7, digits: 2)", "\N{MINUS SIGN}1.5·10⁷"),
        ("num(float.inf) + num(-float.inf)", "∞\N{MINUS SIGN}∞"),
        ("num(float.nan) + num(none)", "\N{EN DASH}\N{EN DASH}"),
        ("percent(-3.25)", "\N{MINUS SIGN}3.2"),
        ("span((6.9, 6.1, 6.5))", "6.10 to 6.90"),
        ("span((2.0001, 2.0002))", "2.00"),
        # zero is never negative
        ("fixed(-0.001, 2)", "0.00"),
        ("fixed(-0.006, 2)", "\N{MINUS SIGN}0.01"),
        ("fixed(0.0, 2)", "0.00"),
        ("num(12)", "12"),
        ("num(-3)", "\N{MINUS SIGN}3"),
        ("num(123456)", "1.23·10⁵"),
        ('num("")', "\N{EN DASH}"),
        ('interval("1.0", "", "")', ["1.00", ""]),
        ('span(("", "2.0", "nan", "1.0"))', "1.00 to 2.00"),
        ("count(0) + count(3)", "none3"),
        ("(mean((1, 2.0, \"6\")), median((3, 1, 2)), median((4.0, 1.0)))", [3.0, 2, 2.5]),
    ],
)  # fmt: skip
def test_cells_of_tables_and_whole_numbers_are_values(expression, told):
    assert evaluated([expression], "format.typ") == [told]
