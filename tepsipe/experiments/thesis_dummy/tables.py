"""Rows of the inverse problem: printed numbers beside the fitted dummy's, and its constants."""

import math
from dataclasses import asdict, dataclass

from tepsipe.experiments.thesis_dummy.inverse import SCATTER, Cell, JointFit, constants_of
from tepsipe.io.result import Result
from tepsipe.io.tables import Table
from tepsipe.mechanics.impedance_model import UNITS


@dataclass(frozen=True)
class CellRow:
    """One row of ``thesis_dummy.csv``. Verdicts are those of the whole laboratory only, in ``cells.csv``."""

    condition: str
    quantity: str
    unit: str
    """Column, row and unit of the thesis's table."""
    role: str
    """{"fitted", "predicted"}: Whether the fit used the printed number."""
    printed: float
    value: float
    spread: float
    """Printed, by the fitted dummy, and its standard deviation over repeated trials (unit of the row)."""


CELL_ROWS = Table(CellRow, "the inverse problem")


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
