"""Numbers and units as text: signs, digits, ranges, symbols of units."""

import math

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MINUS = "\N{MINUS SIGN}"
# rows of the tables of the thesis
LABELS = {
    "SEM_I": "SEM of I",
    "SEM_B": "SEM of B",
    "SEM_K": "SEM of K",
    "SE_I": "standard error of I",
    "SE_B": "standard error of B",
    "SE_K": "standard error of K",
    "error": "error",
    "VAF_trial": "VAF of the full dataset",
    "VAF_perturbation": "VAF of a perturbation",
    "VAF_cross_validated": "VAF, cross-validated",
    "VAF_theta_perturbation": "VAF of the angle, perturbation",
    "VAF_theta_trial": "VAF of the angle, full dataset",
}


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


def _cell(quantity: str, value: float | None) -> str:
    if value is None or not math.isfinite(value):
        return number(value)
    if quantity.startswith("VAF"):
        return percent(value, 2 if value > 99.0 else 1)
    if quantity in ("I", "B"):
        return fixed(value, 4)
    if quantity == "K":
        return fixed(value, 3)
    return number(value, 2)


def _printed(value: float | None) -> str:
    if value is None:
        return number(None)
    mantissa, _, exponent = f"{value:g}".partition("e")
    if exponent:
        mantissa += f"·10{str(int(exponent)).translate(SUPERSCRIPTS)}"
    return mantissa.replace("-", MINUS)
