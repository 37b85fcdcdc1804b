"""Numbers as text, of reports that do not read tables themselves."""

import math

from tepsipe.reporting.format import MINUS, SUPERSCRIPTS, by_uncertainty, number

__all__ = ["MINUS", "SUPERSCRIPTS", "by_uncertainty", "fixed", "number", "percent", "span"]


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
