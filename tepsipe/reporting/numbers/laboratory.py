"""Numbers of the report's section on the simulated laboratory."""

import math

from tepsipe.reporting.laboratory import DRAWN, MECHANISM, LaboratoryRow
from tepsipe.reporting.numbers.format import MINUS
from tepsipe.reporting.numbers.laboratory_words import MEASURES, section_of, unit_of, words_of

# last index of a coordinate's key -> its direction
DIRECTIONS = {"0": ", forwards", "1": ", upwards"}


def laboratory_data(rows: list[LaboratoryRow]) -> dict | None:
    """Mechanisms and drawn constants as text, in words and units.

    Numbers of one list of constants that were drawn alike, for example of the markers of the leg, are one
    row, with the largest deviation among them.

    Returns
    -------
    dict or None
        ``on``, ``off``: mechanisms with key, name, what measures them, magnitude and unit; ``drawn``: key,
        section, name, unit, count of numbers, nominal, value, largest deviation, standard deviation and
        distribution. None without rows.
    """
    if not rows:
        return None
    mechanisms = [row for row in rows if row.kind == MECHANISM]
    lists: dict[tuple, list[LaboratoryRow]] = {}
    for row in rows:
        if row.kind == DRAWN:
            key = ".".join(part for part in row.key.split(".") if not part.isdigit())
            lists.setdefault((key, row.distribution, row.standard_deviation), []).append(row)
    return {
        "on": [_mechanism(row) for row in mechanisms if any(row.value)],
        "off": [_mechanism(row) for row in mechanisms if not any(row.value)],
        "drawn": [_drawn(alike[0], own) for alike, own in lists.items()],
    }


def _mechanism(row: LaboratoryRow) -> dict[str, str]:
    measure = MEASURES.get(row.key, words_of(row.key))
    value = ", ".join(map(_short, row.value))
    return {"key": row.key, "name": row.name, "measure": measure, "value": value, "unit": unit_of(row.key)}


def _drawn(key: str, rows: list[LaboratoryRow]) -> dict[str, str]:
    first, alone = rows[0], len(rows) == 1
    largest = max((row.value[0] - (row.nominal or 0.0) for row in rows), key=abs)
    return {
        "key": key,
        "section": section_of(key),
        "name": words_of(key) + _direction(rows),
        "unit": unit_of(key),
        "count": str(len(rows)),
        "nominal": _short(first.nominal or 0.0) if alone else "",
        "value": _beside(first.value[0], first.standard_deviation or 0.0) if alone else "",
        "largest": _short(largest),
        "standard_deviation": _short(first.standard_deviation or 0.0),
        "distribution": first.distribution,
    }


def _direction(rows: list[LaboratoryRow]) -> str:
    """Direction of a coordinate that was drawn by itself (no unit)."""
    ends = {row.key.rpartition(".")[2] for row in rows}
    return DIRECTIONS.get(ends.pop(), "") if len(ends) == 1 else ""


def _beside(value: float, standard_deviation: float) -> str:
    """A drawn value (any unit) to two significant digits of its standard deviation."""
    if not standard_deviation > 0.0:
        return _short(value, 5)
    return _short(round(value, 1 - math.floor(math.log10(standard_deviation))), 12)


def _short(number: float, digits: int = 3) -> str:
    """Without exponents: 0.00008, 2650."""
    text = f"{float(f'{number:.{digits}g}'):.9f}".rstrip("0").rstrip(".")
    return text.replace("-", MINUS)
