"""Numbers as text: signs, digits, intervals. Typst has the same rules in report/format.typ."""

import math

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MINUS = "\N{MINUS SIGN}"


def number(value: float | int | None, digits: int = 3) -> str:
    """A number (any unit) as text with ``digits`` significant digits; a dash for None."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "\N{EN DASH}"
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    if value != 0.0 and not 1e-3 <= abs(value) < 1e5:
        mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
        text = f"{mantissa}·10{str(int(exponent)).translate(SUPERSCRIPTS)}"
    elif value == 0.0:
        text = "0"
    elif isinstance(value, int):
        text = str(value)
    else:
        decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
        text = f"{value:.{decimals}f}"
    return text.replace("-", MINUS)


def by_uncertainty(value: float, low: float | None, high: float | None) -> tuple[str, str]:
    """A value and its 95 % interval (any unit) as text, to two significant digits of the half-width.

    The second is empty where there is no interval; the value then has three significant digits.
    """
    if low is None or high is None or not math.isfinite(value) or not high - low > 0.0:
        return number(value), ""
    if not math.isfinite(high - low):
        return number(value), f"{number(low)} to {number(high)}"
    decimals = 1 - math.floor(math.log10(0.5 * (high - low)))
    # beyond 1e-9 the numbers would be longer than they are readable
    if decimals > 9:
        return number(value), f"{number(low)} to {number(high)}"
    # the sum with 0.0 turns a rounded -0.0 into 0.0
    rounded = [f"{round(x, decimals) + 0.0:.{max(0, decimals)}f}" for x in (value, low, high)]
    texts = [text.replace("-", MINUS) for text in rounded]
    return texts[0], f"{texts[1]} to {texts[2]}"
