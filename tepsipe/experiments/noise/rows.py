"""Rows of the noise study, and thesis Table 4-4 made of them."""

from collections.abc import Iterable
from dataclasses import dataclass

from tepsipe.experiments.noise.monte_carlo import NoiseCell
from tepsipe.io.tables import Table
from tepsipe.mechanics.impedance_model import PARAMETERS


@dataclass(frozen=True)
class NoiseRow:
    """Statistics of one quantity over the draws of one cell."""

    condition: str
    noise_on: str
    """{"none", "tau", "theta", "both", "belt"}: Signals with noise."""
    snr_db: float
    """Signal power over noise power."""
    estimator: str
    """Name of the processing (`tepsipe.experiments.noise.monte_carlo.PROCESSINGS`), or ``detection`` of
    perturbations."""
    quantity: str
    """I, B, K, a measure of fit, or `onsets_found` and `onset_error`."""
    mean: float
    sd: float
    bias: float | None
    """Over the draws (``unit``); the bias of I, B, K only."""
    n_draws: int
    unit: str
    """Unit of the quantity."""
    stiffness_Nm_per_rad: float
    """K of the simulated joint."""
    without_noise: float | None
    """Estimate by the same processing of the noise-free signals (``unit``); I, B, K only."""
    apparent: float | None
    """Apparent value by the printed equation of the foot (``unit``); I, B, K only."""


def _check(row: NoiseRow) -> None:
    blank = [name for name, value in vars(row).items() if value == ""]
    if blank:
        raise ValueError(f"no {blank[0]}")


NOISE_ROWS = Table(NoiseRow, "rows of the noise study", check=_check)


def noise_rows(cells: Iterable[NoiseCell]) -> list[NoiseRow]:
    """Rows of some cells (units in the column ``unit``)."""
    rows = []
    for cell in cells:
        stiffness = float(cell.truth[2])
        for row in cell.rows():
            k = PARAMETERS.index(row["quantity"]) if row["quantity"] in PARAMETERS else None
            rows.append(
                NoiseRow(
                    **row,
                    stiffness_Nm_per_rad=stiffness,
                    without_noise=None if k is None else float(cell.without_noise[k]),
                    apparent=None if k is None else float(cell.apparent[k]),
                )
            )
    return rows
