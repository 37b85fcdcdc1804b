"""Inverse problem: the dummy that returns the thesis's printed tables by its printed equations.

Constants of a rubber joint are fitted to the printed I, B, K of Tables 4-2 and 4-3, and the noise of the
markers to the VAF of the full dataset. To see what a law can predict, it is also fitted to each table alone,
from which it predicts the other; the null model copies the other table.

The thesis's path from a moving dummy to its printed numbers, without a laboratory.

A candidate joint is moved by the belt of a trial, its markers are sampled one after another, and the printed
equations are applied (thesis section 3-1-2, eqs 3-8 and 3-9), to find what the thesis would have printed.

Rows of the inverse problem: printed numbers beside the fitted dummy's, and its constants.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.identification.regression.windows import WindowedFits, regress_torque
from tepsipe.io.result import Result
from tepsipe.io.tables import Table
from tepsipe.io.trial import Trial
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS
from tepsipe.mechanics.inverse_dynamics import Leg, leg_pathway_torque, leg_torque_as_printed
from tepsipe.mechanics.rubber_joint import CONSTANTS, RubberJoint, swing
from tepsipe.mechanics.segment_kinematics import SegmentMarkers, fit_rigid_segment, segment_motion
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import Lowpass, butterworth_lowpass
from tepsipe.signals.perturbations import Perturbation, WindowOptions, rest_samples
from tepsipe.treadmill.prepared import prepare_trial

MEMORY = 2.0  # of the low-pass: periods of its cutoff after which it has forgotten the end of a record
RIPPLE = 8  # frames over which the spline through the belt's velocity rings after the end of a pulse
BEFORE_S, AFTER_S = 0.1, 0.3  # of the pulse that is averaged, around its onset and after its end


@dataclass(frozen=True)
class PrintedPath:
    """The thesis's processing of the dummy, and its constants of the dummy."""

    leg: Leg
    """Table 2-2 (kg, m, kg·m²)."""
    markers: SegmentMarkers
    """Markers on the leg and their offsets (m)."""
    sampled_after_s: Annotated[np.ndarray, "(markers,)"]
    """Sampling time of each marker within a frame (s); zeros if all are sampled at once."""
    rate_hz: float
    """Frames per second."""
    cutoff_hz: float
    order: int
    """Zero-lag Butterworth filter."""
    window: WindowOptions
    """Search for perturbations and rest (s)."""


@dataclass(frozen=True)
class BeltMotion:
    """Motion of the foot in one condition, with measurement noise reduced by averaging."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    """Frames."""
    position: "scipy.interpolate.PPoly"
    """Motion of the foot (m)."""
    clock: Annotated[np.ndarray, "(k + 1,)", "s"]
    """Frames between which the leg is simulated in one step."""
    acceleration: Annotated[np.ndarray, "(2 k + 1,)", "m/s²"]
    """At these frames and halfway between them."""
    perturbations: list[Perturbation]
    """Windows (samples)."""


def belt_motion(trial: Trial, path: PrintedPath, longest_s: float = np.inf, at_rest: int = 1) -> BeltMotion:
    """The mean pulse of a trial at each of its onsets; the belt rests in between.

    longest_s: pulses that begin later are left out, and the trial ends with their rest (s): mean parameters
    change little, and less is to be simulated.
    at_rest: frames per step of the simulation while the belt rests; while it moves, a step is a frame.
    Returns: with as many pulses as the trial, or as begin early enough.
    """
    rate, recorded = trial.rate_hz, trial.values("belt_velocity").astype(float)
    lowpass = Lowpass(path.cutoff_hz, path.order, True)
    perturbations = prepare_trial(trial, "belt velocity", lowpass, path.window).perturbations
    before = int(BEFORE_S * rate)
    length = before + max(p.stop - p.start for p in perturbations) + int(AFTER_S * rate)
    pulses = np.array([recorded[p.start - before : p.start - before + length] for p in perturbations])
    pulse = pulses.mean(axis=0)
    pulse -= np.linspace(pulse[:3].mean(), pulse[-3:].mean(), length)
    perturbations = [p for p in perturbations if p.start < longest_s * rate] or perturbations[:1]
    last = perturbations[-1].start - before + length + int(path.window.rest_after_s * rate)
    velocity = np.zeros(min(recorded.size, last))
    stepped = np.arange(velocity.size) % at_rest == 0
    stepped[-1] = True
    for p in perturbations:
        velocity[p.start - before : p.start - before + length] = pulse
        stepped[p.start - before - RIPPLE : p.start - before + length + RIPPLE] = True
    time = np.arange(velocity.size) / rate
    spline, clock = scipy.interpolate.CubicSpline(time, velocity), time[stepped]
    halves = np.interp(np.arange(2 * clock.size - 1), np.arange(0, 2 * clock.size, 2), clock)
    return BeltMotion(
        time=time,
        position=spline.antiderivative(),
        clock=clock,
        acceleration=spline(halves, 1),
        perturbations=perturbations,
    )


def swings(
    path: PrintedPath, joints: list[RubberJoint], belts: dict[str, BeltMotion]
) -> dict[str, "scipy.interpolate.PPoly"]:
    """Angle (rad) of the leg on every joint by condition, as a function of time (s), shape (joints,)."""
    longest = max(belt.clock.size for belt in belts.values())
    # trials may differ in length: a shorter one ends with steps of no length
    spare = {name: longest - belt.clock.size for name, belt in belts.items()}
    pushes = np.array([np.pad(belt.acceleration, (0, 2 * spare[name])) for name, belt in belts.items()])
    steps = np.array([np.pad(np.diff(belt.clock), (0, spare[name])) for name, belt in belts.items()])
    theta, rate = swing(path.leg, joints, pushes, steps)
    return {
        name: scipy.interpolate.CubicHermiteSpline(
            belt.clock, *(x[:, k, : belt.clock.size].T for x in (theta, rate))
        )
        for k, (name, belt) in enumerate(belts.items())
    }


def printed_fits(
    path: PrintedPath,
    belt: BeltMotion,
    theta: Annotated[np.ndarray, "(n,)", "rad"],
    marker_noise_m: float = 0.0,
    rng: np.random.Generator | None = None,
    lag_s: float = 0.0,
) -> WindowedFits:
    """I, B, K and their measures of fit by the thesis's method.

    theta: angle of the leg.
    marker_noise_m: standard deviation of white noise on each coordinate.
    lag_s: lag of the ankle: its recorded translation is y(t - lag) beside the rotation theta(t).
    Returns: as printed: torque with the thesis's signs, not referred to rest.
    """
    angle = scipy.interpolate.CubicSpline(belt.time, theta)
    frames = belt.time[1:-1]  # the last marker is sampled after its frame
    positions = np.empty((frames.size, len(path.markers.labels), 2))
    for k, (after, (anterior, longitudinal)) in enumerate(
        zip(path.sampled_after_s, path.markers.layout_m, strict=True)
    ):
        th = angle(frames + after)
        cosine, sine = np.cos(th), np.sin(th)
        positions[:, k, 0] = belt.position(frames + after - lag_s) + anterior * cosine + longitudinal * sine
        positions[:, k, 1] = longitudinal * cosine - anterior * sine
    if marker_noise_m:
        positions += marker_noise_m * rng.standard_normal(positions.shape)
    motion = segment_motion(
        frames, positions, path.markers, path.leg.com_m, cutoff_hz=path.cutoff_hz, order=path.order
    )
    torque = leg_pathway_torque("leg-thesis", path.leg, motion)
    windows = [Perturbation(p.start - 1, p.stop - 1, p.peak_m_per_s) for p in belt.perturbations]
    return regress_torque(motion, torque, windows, rest_samples(frames, path.window), thesis=True)


def printed_means(
    path: PrintedPath,
    belt: BeltMotion,
    angle: "scipy.interpolate.PPoly",
    lags_s: Annotated[np.ndarray, "(joints,) or (1,)"],
) -> Annotated[np.ndarray, "(joints, 3)"]:
    """Mean I, B, K by the thesis's method (their units), as `printed_fits`, of several joints.

    Only motion around the windows is evaluated, as far as the filter remembers, and the angle at rest.

    angle: angle of the leg on every joint (rad), of `swings`.
    lags_s: lag of the ankle for every joint, or for all, as in `printed_fits`.
    """
    leg, rate = path.leg, path.rate_hz
    margin = math.ceil(MEMORY * rate / path.cutoff_hz)
    sizes = np.array([p.stop - p.start for p in belt.perturbations])
    onsets = np.array([p.start for p in belt.perturbations])
    local = np.arange(-margin, sizes.max() + margin) / rate
    frames = local[:, None] + onsets / rate
    joints = angle.c.shape[-1]
    positions = np.empty((*frames.shape, joints, len(path.markers.labels), 2))
    for k, (after, (anterior, longitudinal)) in enumerate(
        zip(path.sampled_after_s, path.markers.layout_m, strict=True)
    ):
        th = angle(frames + after)
        cosine, sine = np.cos(th), np.sin(th)
        along_belt = belt.position(frames[..., None] + after - lags_s)
        positions[..., k, 0] = along_belt + anterior * cosine + longitudinal * sine
        positions[..., k, 1] = longitudinal * cosine - anterior * sine
    filtered = butterworth_lowpass(positions, rate, path.cutoff_hz, path.order)
    pose = fit_rigid_segment(
        filtered.reshape(-1, *filtered.shape[-2:]), path.markers.layout_m, np.array([0.0, leg.com_m])
    )
    theta = pose.angle.reshape(filtered.shape[:-2])
    theta_d = derivative(local, theta)
    theta_dd = derivative(local, theta_d)
    acceleration = derivative(local, derivative(local, pose.point.reshape(*theta.shape, 2)))
    torque = leg_torque_as_printed(leg, theta, theta_dd, acceleration[..., 0], acceleration[..., 1])
    within = belt.time[1:-1]
    resting = within[rest_samples(within, path.window)]
    at_rest = angle(resting + path.sampled_after_s.mean()).mean(axis=0)
    # normal equations in units of each regressor's size; windows may differ by a frame
    part = slice(margin, margin + sizes.max())
    inside = np.arange(sizes.max())[:, None, None, None] < sizes[:, None, None]
    rows = np.stack([theta_dd, theta_d, theta - at_rest], axis=-1)[part] * inside
    products = np.einsum("npja,npjb->pjab", rows, rows)
    explained = np.einsum("npja,npj->pja", rows, torque[part])
    size = np.sqrt(np.diagonal(products, axis1=-2, axis2=-1))
    scaled = products / (size[..., None] * size[..., None, :])
    return (np.linalg.solve(scaled, (explained / size)[..., None])[..., 0] / size).mean(axis=0)


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
class LawFit:
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
    angles: dict[str, "scipy.interpolate.PPoly"],
    printed: dict[str, dict[str, float]],
    names: list[str],
    lags_s: Sequence[float],
) -> np.ndarray:
    """(value - printed) / scatter of I, B, K of several joints, shape (joints, 3 conditions).

    path, belts: as `fit_joint`.
    angles: condition -> angle of the leg on every joint (rad), of `swings`.
    printed: as `fit_joint`.
    lags_s: lag of the ankle for every joint, or for all, as in `printed_fits`.
    """
    scatter = np.array([SCATTER[q] for q in PARAMETERS])
    lags = np.asarray(lags_s, dtype=float)
    return np.concatenate(
        [
            (printed_means(path, belts[n], angles[n], lags) - [printed[q][n] for q in PARAMETERS]) / scatter
            for n in names
        ],
        axis=1,
    )


def fit_joint(
    path: PrintedPath,
    belts: dict[str, BeltMotion],
    printed: dict[str, dict[str, float]],
    fitted: list[str],
    fixed: dict[str, float],
    start: RubberJoint = START,
) -> LawFit:
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
        return deviations(path, belts, angles, printed, names, [0.0])

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
    half_width = scipy.special.stdtrit(freedom, 0.975) * np.sqrt(np.diag(covariance))
    others = [name for name in belts if name not in fitted]
    differences = deviations_of([joint], others)[0] if others else np.array([np.nan])
    return LawFit(
        joint=joint,
        free=free,
        low={name: float(np.exp(v - r)) for name, v, r in zip(free, fit.x, half_width, strict=True)},
        high={name: float(np.exp(v + r)) for name, v, r in zip(free, fit.x, half_width, strict=True)},
        fitted_rms=float(np.sqrt(np.mean(fit.fun**2))),
        predicted_rms=float(np.sqrt(np.mean(differences**2))),
    )


def fit_tables(
    path: PrintedPath,
    belts: dict[str, BeltMotion],
    printed: dict[str, dict[str, float]],
    tables: Sequence[Sequence[str]],
    fixed: dict[str, float],
) -> LawFit:
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

    The SEM is that of one perturbation, the mean over perturbations, by eq (3-2) with the number of
    residuals less the number of parameters as its ||R||; the Euclidean norm gives tens of times as much.
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


def constants_of(fit: LawFit) -> list[tuple[str, float, float | None, float | None]]:
    """Constants by name, with the limits of their intervals where they were fitted (unit in the name)."""
    return [(name, value, fit.low.get(name), fit.high.get(name)) for name, value in asdict(fit.joint).items()]


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
        CellRow(c.condition, c.quantity, units.get(c.quantity, "%"), c.role, c.printed, c.value, c.spread)
        for c in cells
    ]


def fit_result(fits: dict[str, LawFit], marker_noise_m: float, null_rms: float, timing: dict) -> Result:
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
