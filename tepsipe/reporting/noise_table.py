"""Thesis Table 4-4 from the rows of the noise study."""

import numpy as np

from tepsipe.experiments.noise.rows import NoiseRow
from tepsipe.reporting.thesis_tables import PARAMETER_ROWS, TABLE_COLUMNS, TableRow, printed_row

TABLE_4_4 = (
    *PARAMETER_ROWS,
    "VAF_perturbation",
    "VAF_trial",
    "VAF_cross_validated",
    "VAF_theta_perturbation",
    "VAF_theta_trial",
)


def table_4_4(
    rows: list[NoiseRow], reported: dict[str, dict[str, float]], conditions: list[str], snr_db: float
) -> list[TableRow]:
    """Thesis Table 4-4: means over conditions, for every processing and simulated stiffness.

    reported: quantity -> noise target -> value in the thesis (unit of the quantity).
    conditions: trials that are averaged.
    snr_db: signal power over noise power of the table (dB); noise-free results are included.
    Returns: one per processing, stiffness and quantity, with the columns of TABLE_COLUMNS.
    """
    found: dict[tuple, list[NoiseRow]] = {}
    for row in rows:
        if row.condition in conditions and (row.noise_on == "none" or row.snr_db == snr_db):
            key = (row.estimator, row.stiffness_Nm_per_rad, row.quantity, row.noise_on)
            found.setdefault(key, []).append(row)
    laid_out = []
    for estimator, stiffness in dict.fromkeys((e, k) for e, k, _, _ in found):
        for quantity in TABLE_4_4:
            cells = [found.get((estimator, stiffness, quantity, target)) for target in TABLE_COLUMNS]
            if not any(cells):
                continue
            unit = next(group[0].unit for group in cells if group)
            laid_out.append(
                TableRow(
                    estimator,
                    f"K = {stiffness:g} Nm/rad",
                    quantity,
                    unit,
                    [None if group is None else float(np.mean([r.mean for r in group])) for group in cells],
                    [reported.get(printed_row(quantity), {}).get(target) for target in TABLE_COLUMNS],
                )
            )
    return laid_out
