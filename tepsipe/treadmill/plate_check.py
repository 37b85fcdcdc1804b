"""Origin and scale of the force plate from weights that rest on it, and the correction of other trials.

A weight M whose centre of mass lies at y, known from its markers, presses on the belt with the force M g, and
causes the moment M g y about the x axis through the markers' origin. A plate whose origin lies forward by o,
and whose moment has the scale s, shows

    M_x = s (y - o) F_z + m,    F_z = f M g,    M_y = -x F_z

with a zero m of the transducers that drifts, between trials and within them. The weight moves with the belt,
so it rests at another place after every perturbation: s and o follow from all places and weights by least
squares, with the prior of m that the trials of the empty belt show, and a weak one of s, without which
weights at one place would not show o.

A calibration maps the voltages of the plate's transducers to forces F and moments M about the markers'
origin. Another calibration of the same plate, whose gains are g and h and whose origin is shifted by o, maps
them to

    F' = diag(g) F,    M' = diag(h) M - o x F'

g, h and o are found by least squares over the rows of both matrices.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Annotated, Self

import numpy as np

from tepsipe.errors import InputError
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial, calibration_key
from tepsipe.treadmill.options import Weight
from tepsipe.treadmill.prepared import PreparedTrial
from tepsipe.treadmill.trial_recordings import ZERO_BEFORE_S, ZERO_GAP_S

# standard uncertainty of a stated centre of mass relative to the markers (m)
CENTRE_KNOWN_M = 0.002
# standard deviation of the zero of M_x, and of its drift in a trial, where no empty belt shows it, and the
# least one where it does (N·m)
ZERO_UNKNOWN_NM, ZERO_LEAST_NM = 2.0, 0.2
# deviations that are corrected exceed this and `CLEAR` standard uncertainties: of the origin (m), of M_x
SMALL_M, SMALL_SCALE, CLEAR = 0.003, 0.03, 2.0
# standard deviation of the prior of s
SCALE_SD = 0.1
# standard uncertainties by which the scale must be below 0 to be refused
SURELY = 5.0
# an origin that is less well known than this is not corrected (m); up to the other, it counts as known
UNKNOWN_M, WELL_KNOWN_M = 0.01, 2.0 * CENTRE_KNOWN_M
# least relative deviation of the vertical force from the weight that shows a faulty plate
FORCE_WITHIN = 0.03
# calibrations of one plate agree up to a shift of the origin (m) and a difference of the gains
SAME_M, SAME_SCALE = 0.002, 0.01
# beyond these, K of a standing person is wrong by more than 5 %, and nothing is recommended
FAR_M, FAR_SCALE = 0.005, 0.03
COMPONENTS = ("F_x", "F_y", "F_z", "M_x", "M_y", "M_z")
# deviation of the centre of pressure that shows one faulty transducer (m)
MOVED_M = 0.02


@dataclass(frozen=True)
class Resting:
    """A weight at rest between the perturbations of one trial, or the empty belt."""

    weight: Weight | None
    """The weight; None for the empty belt."""
    place: Annotated[np.ndarray, "(n, 2)"]
    """x and y of its centre of mass at every rest (m), of the markers' mean where the centre is not stated;
    0 for the empty belt."""
    f_z: np.ndarray
    m_x: np.ndarray
    m_y: np.ndarray
    """Load of the plate (N, N·m)."""


@dataclass(frozen=True)
class PlateCheck:
    """What resting weights show of a plate."""

    origin_m: float | None = None
    origin_u_m: float | None = None
    """Position of the plate's origin along the belt, forward of the markers' origin, and its standard
    uncertainty (m); None where no weight's centre of mass is stated."""
    moment_scale: float | None = None
    moment_scale_u: float | None = None
    """Scale s of M_x, and its standard uncertainty; None without weights."""
    force_scale: float | None = None
    """Vertical force over the weight, f."""
    sideways_m: float | None = None
    """Centre of pressure less markers across the belt."""
    flags: tuple[str, ...] = ()
    """Names in `tepsipe.flags.FLAGS` of faults that are not corrected."""
    faults: tuple[str, ...] = ()
    """Names of faults of the recordings, which do not concern origin and scale."""
    calibration: Annotated[np.ndarray, "(6, channels)"] | None = None
    """Forces and moments per voltage by which the recordings were calibrated; None if they do not hold it."""

    @classmethod
    def from_result(cls, result: Result) -> Self:
        """Read the check from a result whose facts hold it as ``plate`` (m)."""
        plate = dict(result.facts.get("plate", {}))
        named = {key: tuple(plate.get(key, ())) for key in ("flags", "faults")}
        matrix = plate.get("calibration")
        return cls(**{**plate, **named, "calibration": None if matrix is None else np.array(matrix)})

    @classmethod
    def of_several(cls, checks: Sequence[Self]) -> Self:
        """What is known of the sum of plates, each of which is corrected by itself: the worst of them (m)."""
        if len(checks) == 1:
            return checks[0]
        unknown = any(check.origin_m is None for check in checks)
        return cls(
            origin_m=None if unknown else 0.0,
            origin_u_m=None if unknown else max(check.origin_u_m for check in checks),
            flags=tuple(dict.fromkeys(flag for check in checks for flag in check.flags)),
            faults=tuple(dict.fromkeys(fault for check in checks for fault in check.faults)),
        )

    @property
    def facts(self) -> dict:
        """The check as facts of a result (m)."""
        matrix = None if self.calibration is None else self.calibration.tolist()
        return asdict(self) | {"flags": list(self.flags), "faults": list(self.faults), "calibration": matrix}

    @property
    def corrected_scale(self) -> float:
        """Scale by which M_x is divided; 1 where its deviation is small, or not clear."""
        if self.moment_scale is None or self.flags:
            return 1.0
        off = abs(self.moment_scale - 1.0)
        return self.moment_scale if off > max(SMALL_SCALE, CLEAR * self.moment_scale_u) else 1.0

    @property
    def origin_known(self) -> bool:
        """Test for an origin that weights show to `WELL_KNOWN_M`, so that hardly any error of it is left."""
        return self.origin_m is not None and not self.flags and self.origin_u_m <= WELL_KNOWN_M

    @property
    def corrected_origin_m(self) -> float:
        """Origin that is corrected (m); 0 where it is small, not clear, or not known well enough."""
        if self.origin_m is None or self.flags or self.origin_u_m > UNKNOWN_M:
            return 0.0
        return self.origin_m if abs(self.origin_m) > max(SMALL_M, CLEAR * self.origin_u_m) else 0.0

    def corrected(self, trial: Trial, belt: str) -> Trial:
        """The trial with the moment M_x of a belt (N·m) about the markers' origin, and of scale 1.

        The trial itself, if nothing is to be corrected or it has no such belt.
        """
        scale, origin_m = self.corrected_scale, self.corrected_origin_m
        belts = trial.axes["belt"].tolist() if "belt" in trial.axes else []
        if (scale, origin_m) == (1.0, 0.0) or belt not in belts:
            return trial
        column = belts.index(belt)
        moment = trial.values("moment").astype(float)
        moment[:, column, 0] = moment[:, column, 0] / scale + origin_m * trial.values("force")[:, column, 2]
        signal = replace(trial.signals["moment"], values=moment)
        return replace(trial, signals=trial.signals | {"moment": signal})


def calibration_of(trial: Trial, belt: str) -> np.ndarray | None:
    """Calibration of the force plate of a belt in a recording, shape (6, channels); None if unknown."""
    matrix = trial.attributes.get(calibration_key(belt))
    return None if matrix is None else np.asarray(matrix, dtype=float)


def calibration_difference(
    one: Annotated[np.ndarray, "(6, channels)"] | None, other: Annotated[np.ndarray, "(6, channels)"] | None
) -> str:
    """Difference of the calibrations of a plate in two recordings, in words; empty if they agree.

    one: calibration, forces and moments per voltage (N/V, N·m/V).
    other: the calibration that is compared with it.
    """
    return _compared(one, other)[0]


def calibration_fault(
    one: Annotated[np.ndarray, "(6, channels)"] | None, other: Annotated[np.ndarray, "(6, channels)"] | None
) -> tuple[str, ...]:
    """Flag of a plate with two calibrations: the same difference, small or large; none if they agree."""
    found, far = _compared(one, other)
    return ("other-calibration" if far else "calibration-differs",) * bool(found)


def _compared(one: np.ndarray | None, other: np.ndarray | None) -> tuple[str, bool]:
    """Difference in words, and whether it is larger than `FAR_M` or `FAR_SCALE`."""
    if one is None or other is None or np.array_equal(one, other):
        return "", False
    if one.shape != other.shape:
        return f"{other.shape[1]} transducers instead of {one.shape[1]}", True
    f = other[:3]
    of_force = [
        np.linalg.lstsq(row[:, None], new, rcond=None)[0] for row, new in zip(one[:3], f, strict=True)
    ]
    nothing = np.zeros(one.shape[1])
    by_origin = np.array([[nothing, f[2], -f[1]], [-f[2], nothing, f[0]], [f[1], -f[0], nothing]])
    by_gain = [[row if k == j else nothing for j in range(3)] for k, row in enumerate(one[3:])]
    columns = np.concatenate([-by_origin, np.array(by_gain)], axis=1)
    columns = np.moveaxis(columns, 1, 2).reshape(-1, 6)
    size = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    of_moment = np.linalg.lstsq(columns / size, other[3:].ravel(), rcond=1e-9)[0] / size
    gains = np.concatenate([*of_force, of_moment[3:]])
    moved = [
        f"{1e3 * x:.3g} mm along {axis}"
        for x, axis in zip(of_moment[:3], "xyz", strict=True)
        if abs(x) > SAME_M
    ]
    scaled = [
        f"{name} times {gain:.3g}"
        for name, gain, row in zip(COMPONENTS, gains, one, strict=True)
        if row.any() and abs(gain - 1.0) > SAME_SCALE
    ]
    found = [f"origin moved by {' and '.join(moved)}"] * bool(moved)
    found += [f"gain of {' and '.join(scaled)}"] * bool(scaled)
    rest = other - np.vstack([np.array(of_force) * one[:3], (columns @ of_moment).reshape(3, -1)])
    weights = np.linalg.norm(rest, axis=1) / np.maximum(np.linalg.norm(one, axis=1), 1e-300)
    if (weights > SAME_SCALE).any():
        found.append("other weights of the transducers")
    off = np.where(one.any(axis=1), np.abs(gains - 1.0), 0.0)
    far = np.abs(of_moment[:3]).max() > FAR_M or max(off.max(), weights.max()) > FAR_SCALE
    return ", ".join(found), bool(far)


def resting(prepared: PreparedTrial, belt: str, weight: Weight | None) -> Resting:
    """Loads and places at rest, before every perturbation and at the end of a trial (N, N·m, m)."""
    rate = prepared.rate_hz
    gap = round(ZERO_GAP_S * rate)
    starts, stops = [0, *(p.stop for p in prepared.perturbations)], [*prepared.onsets, prepared.time.size]
    parts = []
    for start, stop in zip(starts, stops, strict=True):
        longest = min(round(ZERO_BEFORE_S * rate), (stop - start) // 2)
        parts.append(slice(max(0, stop - gap - longest), max(1, stop - gap)))
    load = prepared.load(belt)
    column = prepared.trial.axes["belt"].tolist().index(belt)
    load["My"] = prepared.trial.values("moment")[:, column, 1]
    f_z, m_x, m_y = (np.array([load[key][part].mean() for part in parts]) for key in ("Fz", "Mx", "My"))
    place = np.zeros((len(parts), 2))
    if weight is not None:
        markers = prepared.trial.values("marker_position")[:, :, :2].astype(float).mean(axis=1)
        place = np.array([markers[part].mean(axis=0) for part in parts])
        place[:, 1] += weight.com_forward_of_markers_m or 0.0
    return Resting(weight, place, f_z, m_x, m_y)


def check_plate(trials: Sequence[Resting], name: str) -> PlateCheck:
    """Compare the plate with weights at rest.

    trials: trials of weights and of the empty belt.
    name: names the plate in messages.
    Returns: origin and scales, with what is not corrected.
    """
    loaded = [r for r in trials if r.weight is not None]
    if not loaded:
        return PlateCheck()
    stated = all(r.weight.com_forward_of_markers_m is not None for r in loaded)
    (scale, u_scale), (origin_m, u_origin_m) = _moment(trials, loaded)
    if scale + SURELY * u_scale < 0.0:
        raise InputError(
            f"{name}: expected the moment M_x to grow by the weight times its way where the weight moves "
            f"forward, found {scale:.2g} times that: turn the sign of M_x in the calibration of the plate, "
            "or of the markers' axis along the belt"
        )
    empty = [r for r in trials if r.weight is None]
    zero_f, zero_y = (
        float(np.mean([getattr(r, key).mean() for r in empty])) if empty else 0.0 for key in ("f_z", "m_y")
    )
    expected = [r.weight.mass_kg * r.weight.gravity_m_per_s2 for r in loaded]
    force = np.array([(r.f_z.mean() - zero_f) / w for r, w in zip(loaded, expected, strict=True)])
    across = np.array(
        [-(r.m_y - zero_y).mean() / (r.f_z - zero_f).mean() - r.place[:, 0].mean() for r in loaded]
    )
    share = np.array(expected) ** 2 / np.sum(np.square(expected))
    f, sideways_m = float(force @ share), float(across @ share)
    flags = ()
    if abs(f - 1.0) > FORCE_WITHIN:
        # with one scale for all transducers the centre of pressure stays where it is
        moved_m = max(abs(sideways_m), abs(origin_m) if stated else 0.0)
        flags = ("plate-transducer",) if moved_m > MOVED_M else ("plate-scale",)
    return PlateCheck(
        origin_m=origin_m if stated else None,
        origin_u_m=float(np.hypot(u_origin_m, CENTRE_KNOWN_M)) if stated else None,
        moment_scale=scale,
        moment_scale_u=u_scale,
        force_scale=f,
        sideways_m=sideways_m,
        flags=flags,
    )


def _moment(trials: Sequence[Resting], loaded: Sequence[Resting]) -> tuple[tuple[float, float], ...]:
    """Scale of M_x and origin (m), each with its standard uncertainty."""
    empty = [r.m_x for r in trials if r.weight is None]
    zero_sd, drift_sd = (
        max(float(np.sqrt(np.mean(np.square(found)))), ZERO_LEAST_NM) if empty else ZERO_UNKNOWN_NM
        for found in ([m.mean() for m in empty], [m[-1] - m[0] for m in empty])
    )
    count = len(loaded)
    trial = np.repeat(np.arange(count), [r.m_x.size for r in loaded])
    f_z, m_x = (np.concatenate([getattr(r, key) for r in loaded]) for key in ("f_z", "m_x"))
    y = np.concatenate([r.place[:, 1] for r in loaded])
    course = np.concatenate([np.linspace(-0.5, 0.5, r.m_x.size) if r.m_x.size > 1 else [0.0] for r in loaded])
    of_trial = (trial[:, None] == np.arange(count)).astype(float)
    drift = np.column_stack([of_trial, of_trial * course[:, None]])
    # noise of one rest: what remains within the trials
    within = np.column_stack([y * f_z, drift])
    left = m_x - within @ np.linalg.lstsq(within, m_x)[0]
    noise = max(float(np.sqrt(left @ left / max(left.size - 2 * count - 1, 1))), 0.1 * ZERO_LEAST_NM)
    rows = np.column_stack([y * f_z, -f_z, drift]) / noise
    held = np.zeros((2 * count + 1, 2 * count + 2))
    held[0, 0] = 1.0 / SCALE_SD
    held[1:, 2:] = np.diag(np.repeat([1.0 / zero_sd, 1.0 / drift_sd], count))
    known = np.append(1.0 / SCALE_SD, np.zeros(2 * count))
    stacked, right = np.concatenate([rows, held]), np.concatenate([m_x / noise, known])
    size = np.linalg.norm(stacked, axis=0)
    (scale, moved), covariance = _solved(stacked / size, right, size)
    origin_m = moved / scale
    slope = np.array([-origin_m, 1.0]) / scale
    return (
        (float(scale), float(np.sqrt(covariance[0, 0]))),
        (float(origin_m), float(np.sqrt(slope @ covariance @ slope))),
    )


def _solved(rows: np.ndarray, right: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First two coefficients of a least-squares fit with noise of 1 or more, and their covariance."""
    solution = np.linalg.lstsq(rows, right)[0]
    left = right - rows @ solution
    excess = max(1.0, float(left @ left) / max(left.size - solution.size, 1))
    inverse = np.linalg.pinv(rows.T @ rows) * excess / np.outer(size, size)
    return (solution / size)[:2], inverse[:2, :2]
