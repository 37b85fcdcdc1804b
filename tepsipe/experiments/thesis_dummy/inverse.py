"""Inverse problem: the dummy that returns the thesis's printed tables by its printed equations.

Constants of a rubber joint are fitted to the printed I, B, K of Tables 4-2 and 4-3, and the noise of the
markers to the VAF of the full dataset. To see what a law can predict, it is also fitted to each table alone,
from which it predicts the other; the null model copies the other table.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.experiments.thesis_dummy.printed_path import BeltMotion, PrintedPath, printed_fits, swings
from tepsipe.identification.regression.windows import WindowedFits
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.mechanics.rubber_joint import CONSTANTS, RubberJoint

# the printed numbers scatter by about the standard errors that the tables print; I is rounded
SCATTER = {"I": 0.0005, "B": 0.005, "K": 0.32}  # N·m·s²/rad, N·m·s/rad, N·m/rad
START = RubberJoint(
    stiffness_Nm_per_rad=10.0,
    half_softening_rad=0.03,
    damping_Nms_per_rad=0.05,
    softened_damping_Nms_per_rad=0.05,
    inertia_Nms2_per_rad=0.003,
)
LOWEST = dict(zip(CONSTANTS, (1.0, 0.003, 0.0, 0.0, 0.0), strict=True))
HIGHEST = dict(zip(CONSTANTS, (50.0, 1.0, 1.0, 1.0, 0.1), strict=True))
# simpler joints: constants held at fixed values; the others are fitted
LINEAR = {"half_softening_rad": math.inf, "softened_damping_Nms_per_rad": 0.0}
WITHOUT_LOSS = {"softened_damping_Nms_per_rad": 0.0}
JOINTS = {"linear": LINEAR, "softening": WITHOUT_LOSS, "softening with losses": {}}


@dataclass(frozen=True)
class Cell:
    """One printed number and its value for the fitted dummy."""

    condition: str
    quantity: str
    """Column and row of the thesis's table."""
    role: str
    """{"fitted", "predicted"}: Whether the number was used by the fit."""
    printed: float
    value: float
    """Printed, and by the fitted dummy (unit of the quantity)."""
    spread: float
    """Standard deviation of the value over repeated trials with other noise (unit of the quantity)."""


@dataclass(frozen=True)
class JointFit:
    """One law of the joint, fitted."""

    joint: RubberJoint
    """Fitted constants."""
    free: tuple[str, ...]
    """Names of the constants that were fitted."""
    low: dict[str, float]
    high: dict[str, float]
    """95 % interval of each free constant, Student's t, scatter from the residuals (unit of the constant)."""
    fitted_rms: float
    predicted_rms: float
    """Root mean square of (value - printed) / scatter over the fitted conditions, and over conditions that
    the fit did not use."""


def deviations(
    path: PrintedPath,
    belts: dict[str, BeltMotion],
    angles: dict[str, np.ndarray],
    printed: dict[str, dict[str, float]],
    names: list[str],
    lags_s: Sequence[float],
) -> np.ndarray:
    """(value - printed) / scatter of I, B, K of several joints, shape (joints, 3 conditions).

    path, belts: as `fit_joint`.
    angles: condition -> angle of the leg on every joint (rad). Shape (joints, n).
    printed: as `fit_joint`.
    lags_s: lag of the translation for every joint.
    """
    scatter = np.array([SCATTER[q] for q in PARAMETERS])
    targets = {name: np.array([printed[q][name] for q in PARAMETERS]) for name in names}
    rows = [
        [(printed_fits(path, belts[n], angles[n][k], lag_s=lag).mean - targets[n]) / scatter for n in names]
        for k, lag in enumerate(map(float, lags_s))
    ]
    return np.array(rows).reshape(len(rows), -1)


def fit_joint(
    path: PrintedPath,
    belts: dict[str, BeltMotion],
    printed: dict[str, dict[str, float]],
    fitted: list[str],
    fixed: dict[str, float],
    start: RubberJoint = START,
) -> JointFit:
    """Fit the free constants of a joint to printed I, B, K by weighted nonlinear least squares.

    belts: condition -> motion of the foot.
    printed: quantity -> condition -> printed number (N·m·s²/rad, N·m·s/rad, N·m/rad).
    fitted: conditions that are used.
    fixed: constants that are not fitted, and their values.
    start: constants from which the search starts.
    Returns: constants with intervals, and how well they return the printed numbers.
    """
    free = tuple(name for name in CONSTANTS if name not in fixed)
    if 3 * len(fitted) <= len(free):
        raise InputError(
            f"thesis dummy: expected more printed numbers than the {len(free)} constants, found "
            f"{3 * len(fitted)}: add conditions of Tables 4-2 and 4-3 to the trial sheet"
        )

    def joint_at(x: np.ndarray) -> RubberJoint:
        return RubberJoint(**fixed, **dict(zip(free, (float(v) for v in np.exp(x)), strict=True)))

    def deviations_of(joints: list[RubberJoint], names: list[str]) -> np.ndarray:
        angles = swings(path, joints, {name: belts[name] for name in names})
        return deviations(path, belts, angles, printed, names, np.zeros(len(joints)))

    step = 1e-3  # of the logarithm

    def residuals_and_slopes(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        tried = [joint_at(x), *(joint_at(x + step * row) for row in np.eye(x.size))]
        fit = deviations_of(tried, fitted)
        return fit[0], (fit[1:] - fit[0]).T / step

    cache: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

    def at(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        key = x.tobytes()
        if key not in cache:
            cache[key] = residuals_and_slopes(x)
        return cache[key]

    bounds = [[math.log(max(limit[name], 1e-6)) for name in free] for limit in (LOWEST, HIGHEST)]
    fit = scipy.optimize.least_squares(
        lambda x: at(x)[0],
        [math.log(max(getattr(start, name), 1e-4)) for name in free],
        jac=lambda x: at(x)[1],
        bounds=bounds,
        xtol=1e-3,
        ftol=1e-4,
        max_nfev=30,
    )
    joint = joint_at(fit.x)
    freedom = fit.fun.size - len(free)
    covariance = np.linalg.pinv(fit.jac.T @ fit.jac) * (2.0 * fit.cost / freedom)
    reach = scipy.special.stdtrit(freedom, 0.975) * np.sqrt(np.diag(covariance))
    others = [name for name in belts if name not in fitted]
    differences = deviations_of([joint], others)[0] if others else np.array([np.nan])
    return JointFit(
        joint=joint,
        free=free,
        low={name: float(np.exp(v - r)) for name, v, r in zip(free, fit.x, reach, strict=True)},
        high={name: float(np.exp(v + r)) for name, v, r in zip(free, fit.x, reach, strict=True)},
        fitted_rms=float(np.sqrt(np.mean(fit.fun**2))),
        predicted_rms=float(np.sqrt(np.mean(differences**2))),
    )


def fit_tables(
    path: PrintedPath,
    belts: dict[str, BeltMotion],
    printed: dict[str, dict[str, float]],
    tables: Sequence[Sequence[str]],
    fixed: dict[str, float],
) -> JointFit:
    """Fit a law to all tables, and score its prediction of each table from the others.

    path, belts, printed: as `fit_joint`.
    tables: conditions of each table.
    fixed: as `fit_joint`.
    Returns: constants fitted to all tables; ``predicted_rms`` is over the predictions of all tables, NaN if
    a table alone does not determine the constants.
    """
    belts = {name: belts[name] for table in tables for name in table}
    fit = fit_joint(path, belts, printed, list(belts), fixed)
    others = [[name for own in tables if own is not table for name in own] for table in tables]
    if min(3 * len(names) for names in others) <= len(fit.free):
        return fit
    squares = [
        len(table) * fit_joint(path, belts, printed, names, fixed, fit.joint).predicted_rms ** 2
        for table, names in zip(tables, others, strict=True)
    ]
    return replace(fit, predicted_rms=math.sqrt(sum(squares) / sum(map(len, tables))))


def copied_rms(printed: dict[str, dict[str, float]], tables: Sequence[Sequence[str]]) -> float:
    """Null model: root mean square of (printed - printed in the other table) / scatter over I, B and K.

    Conditions with the same name after their first hyphen belong together; NaN if there are none.
    """
    first, second = ({name.partition("-")[2]: name for name in table} for table in tables)
    pairs = [(first[key], second[key]) for key in first if key in second]
    if not pairs:
        return math.nan
    differences = [(printed[q][a] - printed[q][b]) / SCATTER[q] for q in PARAMETERS for a, b in pairs]
    return float(np.sqrt(np.mean(np.square(differences))))


def fit_marker_noise(
    path: PrintedPath,
    belts: dict[str, BeltMotion],
    angles: dict[str, np.ndarray],
    printed_vaf: dict[str, float],
    fitted: list[str],
    seed: int,
) -> Annotated[float, "m"]:
    """Standard deviation of the markers' noise (m) that gives the printed VAF of the full dataset.

    The unexplained part of the torque is d + e s^2, where s is the noise; d and e follow from one simulation
    without noise and one with noise. The logarithm of this part is fitted over the conditions.

    path, belts: as `fit_joint`.
    angles: condition -> angle of the leg on the fitted joint (rad).
    printed_vaf: condition -> printed VAF (%).
    seed: seed of the generator of the noise.
    Returns: noise per coordinate.
    """
    tried = 1e-5
    rng = np.random.default_rng([seed, 1])
    without = np.array([100.0 - printed_fits(path, belts[n], angles[n]).vaf_trial for n in fitted])
    with_noise = np.array(
        [100.0 - printed_fits(path, belts[n], angles[n], tried, rng).vaf_trial for n in fitted]
    )
    slope = np.maximum(with_noise - without, 1e-9) / tried**2
    wanted = np.log(100.0 - np.array([printed_vaf[n] for n in fitted]))

    def distance(log_noise: float) -> float:
        return float(np.sum((np.log(without + slope * math.exp(2.0 * log_noise)) - wanted) ** 2))

    minimum = scipy.optimize.minimize_scalar(
        distance, bounds=(math.log(1e-7), math.log(1e-3)), method="bounded", options={"xatol": 1e-4}
    )
    return math.exp(minimum.x)


def printed_quantities(fits: WindowedFits) -> dict[str, float]:
    """Rows of Tables 4-2 and 4-3: I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad), their SEM, and VAF (%).

    The SEM is the ordinary standard error of a perturbation's parameters, the mean over perturbations:
    eq (3-2) as printed would give numbers that are tens of times larger.
    """
    errors = np.mean([fit.standard_error for fit in fits.fits], axis=0)
    rows = dict(zip(PARAMETERS, map(float, fits.mean), strict=True))
    rows |= {f"SEM_{q}": float(e) for q, e in zip(PARAMETERS, errors, strict=True)}
    rows["VAF_perturbation"] = float(fits.vaf_per_perturbation.mean())
    return rows | {"VAF_trial": fits.vaf_trial}


def printed_and_predicted(
    path: PrintedPath,
    belts: dict[str, BeltMotion],
    angles: dict[str, np.ndarray],
    printed: dict[str, dict[str, float]],
    fitted: list[str],
    marker_noise_m: float,
    draws: int,
    seed: int,
) -> list[Cell]:
    """Every printed number of Tables 4-2 and 4-3 beside the fitted dummy's.

    path, belts, angles: as `fit_marker_noise`.
    printed: quantity -> condition -> printed number.
    fitted: conditions that the fit used.
    marker_noise_m: noise per coordinate.
    draws: trials with other noise that are averaged.
    seed: seed of the generator of the noise.
    """
    rng = np.random.default_rng([seed, 2])
    used = (*PARAMETERS, "VAF_trial")
    cells = []
    for name, belt in belts.items():
        drawn = [
            printed_quantities(printed_fits(path, belt, angles[name], marker_noise_m, rng))
            for _ in range(draws)
        ]
        for quantity in drawn[0]:
            if name not in printed.get(quantity, {}):
                continue
            values = np.array([row[quantity] for row in drawn])
            role = "fitted" if name in fitted and quantity in used else "predicted"
            cells.append(
                Cell(
                    name,
                    quantity,
                    role,
                    float(printed[quantity][name]),
                    float(values.mean()),
                    float(values.std(ddof=1)) if draws > 1 else math.nan,
                )
            )
    return cells


def constants_of(fit: JointFit) -> list[tuple[str, float, float | None, float | None]]:
    """Constants by name, with the limits of their intervals where they were fitted (unit in the name)."""
    return [(name, value, fit.low.get(name), fit.high.get(name)) for name, value in asdict(fit.joint).items()]
