"""Rows of the inverse problem: printed numbers beside the fitted dummy's, and its constants."""

import math
from dataclasses import asdict, dataclass

from tepsipe.experiments.thesis_dummy.inverse import SCATTER, Cell, JointFit, constants_of
from tepsipe.io.result import Result
from tepsipe.io.tables import Table
from tepsipe.mechanics.impedance_model import UNITS

# tolerances of the fitted dummy: half the last printed digit, and the scatter of the printed numbers
INERTIA_SHARE = 0.02  # of I, which is rounded to 0.001 N·m·s²/rad
STIFFNESS_SHARE = 0.1  # of K, the range of the boxes of Figure 4-4
DAMPING = 0.012  # of B (N·m·s/rad): 2.4 printed standard errors
SEM_FACTOR = 2.0  # printed SEMs of neighbouring amplitudes differ by up to this factor
UNEXPLAINED_FACTOR = 3.0  # of 100 - VAF: of two trials of 0.5 m/s the thesis prints 0.02 and 0.01
LAST_DIGIT = 0.01  # of a printed VAF (%)


@dataclass(frozen=True)
class CellRow:
    """One row of ``thesis_dummy.csv``.

    Attributes
    ----------
    condition, quantity, unit : str
        Column, row and unit of the thesis's table.
    role : {"fitted", "predicted"}
        Whether the fit used the printed number.
    printed, value, spread : float
        Printed, by the fitted dummy, and its standard deviation over repeated trials (unit of the row).
    within : bool
        Whether the value lies within the tolerance.
    """

    condition: str
    quantity: str
    unit: str
    role: str
    printed: float
    value: float
    spread: float
    within: bool


CELL_ROWS = Table(CellRow, "the inverse problem")


def within_tolerance(quantity: str, printed: float, value: float) -> bool:
    """Test for agreement of the fitted dummy with a printed number (unit of the quantity)."""
    if quantity.startswith("SEM"):
        return 1.0 / SEM_FACTOR <= value / printed <= SEM_FACTOR
    if quantity.startswith("VAF"):
        missing, unexplained = 100.0 - printed, 100.0 - value
        low = max(0.0, missing - 0.5 * LAST_DIGIT) / UNEXPLAINED_FACTOR
        return low <= unexplained <= UNEXPLAINED_FACTOR * (missing + 0.5 * LAST_DIGIT)
    allowed = {"I": INERTIA_SHARE * printed, "B": DAMPING, "K": STIFFNESS_SHARE * printed}[quantity]
    return abs(value - printed) <= allowed


def cell_rows(cells: list[Cell]) -> list[CellRow]:
    """Cells (unit of each quantity) as rows of the table."""
    units = UNITS | {f"SEM_{quantity}": unit for quantity, unit in UNITS.items()}
    return [
        CellRow(
            c.condition,
            c.quantity,
            units.get(c.quantity, "%"),
            c.role,
            c.printed,
            c.value,
            c.spread,
            within_tolerance(c.quantity, c.printed, c.value),
        )
        for c in cells
    ]


def fit_result(fits: dict[str, JointFit], marker_noise_m: float, null_rms: float, timing: dict) -> Result:
    """Constants of every law with their intervals, as facts.

    ``null_rms`` is that of `copied_rms`; ``timing`` has the shift of B by the sampling times and the fits
    by lag (units in the keys).
    """
    laws = {
        law: {
            "constants": {name: None if math.isinf(v) else v for name, v in asdict(fit.joint).items()},
            "intervals": {n: [low, high] for n, _, low, high in constants_of(fit) if low is not None},
            "fitted_rms": fit.fitted_rms,
            "predicted_rms": fit.predicted_rms,
        }
        for law, fit in fits.items()
    }
    facts = {"laws": laws, "marker_noise_m": marker_noise_m, "scatter": SCATTER}
    return Result({}, {}, facts | {"null_rms": null_rms, "timing": timing})
