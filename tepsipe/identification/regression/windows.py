"""TEP-SIPE: I, B, K by windowed (per-perturbation) least squares (thesis section 3-1-2, eq 3-9).

    tau(t) = I theta'' + B theta' + K (theta - theta_ref)      over the samples of one perturbation

As printed, theta_ref is the angle at rest. At rest, however, the joint carries the weight of a leg that
is not exactly upright, tau_rest = K (theta_rest - theta_ref), so the printed regression is biased unless
theta_rest is 0. The recommended regression refers angle *and* torque to rest:
tau - tau_rest = I theta'' + B theta' + K (theta - theta_rest).

Noise of the markers is in the regressors, and attenuates I, B and K (errors in variables). Perturbations that
repeat each other have the same response and different noise. The recommended regression therefore multiplies
signals of different perturbations only: with X_i the regressors and y_i the torque of perturbation i,

    N p = b,     N = sum over i != j of X_i' X_j,     b = sum over i != j of X_i' y_j

so p is not biased by noise, even if angle and torque come from the same markers. Each perturbation is quoted
with its pseudo-value n p - (n - 1) p_(i), p_(i) being the solution without it (jackknife; Tukey 1958): their
mean is the estimate, and their scatter its standard error. Perturbations that do not repeat each other are
fitted one by one, as printed.

*Type A uncertainty.* The scatter of the perturbations, with n - 1 degrees of freedom, lacks what they share:
the error of torque and angle at rest, which acts as a constant torque c = d tau_rest - K d theta_rest in all
of them. The estimates are linear in the torque, so c shifts them by c times their response to a constant
torque of 1. The standard error of c comes from the residual of the torque at rest (`error_of_mean`).
"""

from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.mechanics.impedance_model import PARAMETERS, impedance_torque
from tepsipe.mechanics.inverse_dynamics import Leg, leg_pathway_torque
from tepsipe.mechanics.segment_kinematics import JointMotion, SegmentMotion
from tepsipe.signals.perturbations import Perturbation
from tepsipe.statistics.goodness_of_fit import vaf
from tepsipe.statistics.least_squares import LinearFit, least_squares_line
from tepsipe.statistics.uncertainty import error_of_mean, in_quadrature, scatter

# shift of the centre of mass's accelerations, in either direction, for the sensitivity to a delay (s)
LAG_S = 0.001
# fewest perturbations whose products are used, and smallest share of what they repeat in their regressors
FEWEST, REPEATED = 3, 0.1


@dataclass(frozen=True)
class WindowedFits:
    """I, B, K of one trial."""

    perturbations: list[Perturbation]
    """The windows (samples)."""
    fits: list[LinearFit]
    """One per perturbation; parameters in the order I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad)."""
    torque: np.ndarray
    predicted: np.ndarray
    """tau and its prediction from the mean parameters over the whole trial (N·m); the recommended
    regression refers both to rest."""
    regressors: Annotated[np.ndarray, "(n, 3)"]
    """theta'' (rad/s²), theta' (rad/s), theta - theta_ref (rad)."""
    theta_rest_rad: float
    torque_rest_Nm: float
    """Angle (rad) and torque (N·m) at rest."""
    crossed: bool = field(default=False, kw_only=True)
    """Whether only signals of different perturbations were multiplied, so noise does not bias the fits."""
    of_rest: Annotated[np.ndarray, "(3,)"] = field(default_factory=lambda: np.zeros(3), kw_only=True)
    """Change of the mean of I, B, K (their units) by one standard error of angle and torque at rest; 0
    where these are not subtracted, and for the thesis's regression."""
    rest_freedom: float = field(default=np.inf, kw_only=True)
    """Degrees of freedom of this standard error."""

    @property
    def parameters(self) -> np.ndarray:
        """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of every perturbation, shape (perturbations, 3)."""
        return np.array([fit.parameters for fit in self.fits])

    @property
    def mean(self) -> np.ndarray:
        """Mean of I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) over the perturbations, shape (3,)."""
        return self.parameters.mean(axis=0)

    @property
    def type_a(self) -> tuple[np.ndarray, float | np.ndarray]:
        """Type A uncertainty of `mean`, shape (3,), and its degrees of freedom."""
        own = scatter(self.parameters)
        return in_quadrature(own, (self.of_rest, self.rest_freedom)) if self.of_rest.any() else own

    @property
    def squared_rate(self) -> float:
        """Mean square of theta'' over the mean square of theta' in the windows (1/s²): w^2 of a sinusoid."""
        rows = np.concatenate([self.regressors[w.start : w.stop] for w in self.perturbations])
        return float(np.sum(rows[:, 0] ** 2) / np.sum(rows[:, 1] ** 2))

    @property
    def vaf_per_perturbation(self) -> np.ndarray:
        """VAF (%) of every perturbation with its own parameters, shape (perturbations,)."""
        return np.array(
            [
                vaf(self.torque[p.start : p.stop], self.torque[p.start : p.stop] - fit.residuals)
                for p, fit in zip(self.perturbations, self.fits, strict=True)
            ]
        )

    @property
    def vaf_trial(self) -> float:
        """VAF (%) of the whole trial with the mean parameters."""
        return vaf(self.torque, self.predicted)


def regress_perturbations(
    motion: SegmentMotion,
    leg: Leg,
    perturbations: list[Perturbation],
    at_rest: np.ndarray,
    torque_pathway: str,
    *,
    thesis: bool = False,
) -> WindowedFits:
    """Estimate I, B, K over every perturbation.

    leg: its mass, centre of mass and inertia.
    at_rest: samples at rest.
    torque_pathway: {"leg", "leg-thesis"}: Equation of the torque.
    thesis: whether the torque at rest is kept, as printed, or subtracted.
    Returns: parameters, predictions and measures of fit.
    """
    torque = leg_pathway_torque(torque_pathway, leg, motion)
    return regress_torque(motion, torque, perturbations, at_rest, thesis=thesis)


def regress_torque(
    motion: JointMotion,
    torque: Annotated[np.ndarray, "(n,)", "N·m"],
    perturbations: list[Perturbation],
    at_rest: np.ndarray,
    *,
    thesis: bool = False,
    own_zero: bool = False,
) -> WindowedFits:
    """Estimate I, B, K over every perturbation from a given torque.

    motion: angle of the joint with its derivatives.
    torque: torque of the joint.
    at_rest: samples at rest.
    thesis: whether the torque at rest is kept, as printed, or subtracted.
    own_zero: whether each window has a free constant torque beside I, B, K, because the zero of a force
    plate drifts, and friction of the belt leaves a force behind.
    Returns: parameters, predictions and measures of fit.
    """
    theta_rest = float(motion.theta[at_rest].mean())
    torque_rest = float(torque[at_rest].mean())
    regressors = np.column_stack([motion.theta_dd, motion.theta_d, motion.theta - theta_rest])
    if not thesis:
        # the equation also holds for differences from means of a joint that still swings at rest
        torque = torque - torque_rest
        regressors[:, :2] -= regressors[at_rest, :2].mean(axis=0)
    fits, windows = [], []
    for p in perturbations:
        rows, explained = regressors[p.start : p.stop], torque[p.start : p.stop]
        if own_zero:
            rows, explained = rows - rows.mean(axis=0), explained - explained.mean()
        windows.append((rows, explained))
        try:
            fits.append(least_squares_line(rows, explained))
        except np.linalg.LinAlgError as error:
            raise InputError(
                f"expected a perturbation at {motion.time[p.start]:.2f} s that determines "
                f"{', '.join(PARAMETERS)}, found {error}: check that the markers moved"
            ) from error
    pseudo_values = None if thesis else products_of_perturbations(windows)
    if pseudo_values is not None:
        fits = [
            replace(fit, parameters=p, residuals=explained - rows @ p)
            for fit, p, (rows, explained) in zip(fits, pseudo_values, windows, strict=True)
        ]
    mean = np.mean([fit.parameters for fit in fits], axis=0)
    of_rest, rest_freedom = np.zeros(3), np.inf
    if not (thesis or own_zero):
        error, rest_freedom = error_of_mean(torque[at_rest] - regressors[at_rest] @ mean)
        of_rest = error * of_constant_torque([rows for rows, _ in windows], pseudo_values is not None)
    predicted = impedance_torque(mean, regressors[:, 2], regressors[:, 1], regressors[:, 0])
    return WindowedFits(
        perturbations,
        fits,
        torque,
        predicted,
        regressors,
        theta_rest,
        torque_rest,
        crossed=pseudo_values is not None,
        of_rest=of_rest,
        rest_freedom=rest_freedom,
    )


def of_constant_torque(regressors: list[np.ndarray], crossed: bool) -> np.ndarray:
    """Mean parameters of the regressors, shape (p,), for a constant torque of 1 N·m in all windows."""
    windows = [(rows, np.ones(len(rows))) for rows in regressors]
    if crossed:
        return products_of_perturbations(windows).mean(axis=0)
    return np.mean([np.linalg.lstsq(*window)[0] for window in windows], axis=0)


def products_of_perturbations(windows: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray | None:
    """Pseudo-values of I, B, K from products of different perturbations, shape (perturbations, 3).

    ``windows`` are regressors and torque of each perturbation. None if there are fewer than `FEWEST`, or if
    they do not repeat each other.
    """
    n = len(windows)
    if n < FEWEST:
        return None
    length = min(len(rows) for rows, _ in windows)
    size = np.linalg.norm(np.concatenate([rows for rows, _ in windows]), axis=0)
    x = np.stack([rows[:length] / size for rows, _ in windows])
    y = np.stack([explained[:length] for _, explained in windows])
    # a perturbation in the opposite direction repeats the others with the opposite sign
    sign = np.where(np.einsum("nr,inr->i", x[0], x) < 0.0, -1.0, 1.0)
    x, y = sign[:, None, None] * x, sign[:, None] * y
    own_n, own_b = np.einsum("ina,inb->iab", x, x), np.einsum("ina,in->ia", x, y)

    def products(x: np.ndarray, y: np.ndarray, n: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """N and b of sums over some perturbations, less the products of each with itself."""
        return np.swapaxes(x, -1, -2) @ x - n, (np.swapaxes(x, -1, -2) @ y[..., None])[..., 0] - b

    sums = x.sum(axis=0), y.sum(axis=0), own_n.sum(axis=0), own_b.sum(axis=0)
    whole_n, whole_b = products(*sums)
    shares = np.linalg.eigvals(np.linalg.solve(sums[2], whole_n) / (n - 1.0))
    if shares.real.min() < REPEATED:
        return None
    left_n, left_b = products(*(total - own for total, own in zip(sums, (x, y, own_n, own_b), strict=True)))
    whole = np.linalg.solve(whole_n, whole_b)
    left_out = np.linalg.solve(left_n, left_b[..., None])[..., 0]
    return (n * whole - (n - 1.0) * left_out) / size


def damping_per_com_lag(
    motion: SegmentMotion,
    leg: Leg,
    perturbations: list[Perturbation],
    at_rest: np.ndarray,
    torque_pathway: str,
    *,
    thesis: bool = False,
) -> float:
    """Sensitivity of B to a lag of the centre of mass: recorded y(t - lag) beside the angle theta(t).

    motion, leg, perturbations, at_rest, torque_pathway, thesis: as for `regress_perturbations`.
    Returns: change of B per lag (N·m·s/rad per s); in a short pulse m r w^2 (l - r), which is positive.
    """
    instants = np.clip(motion.time[:, None] - [-LAG_S, LAG_S], motion.time[0], motion.time[-1])
    y_dd = scipy.interpolate.CubicSpline(motion.time, motion.y_dd)(instants)
    z_dd = scipy.interpolate.CubicSpline(motion.time, motion.z_dd)(instants)
    damping = [
        regress_perturbations(
            replace(motion, y_dd=y_dd[:, k], z_dd=z_dd[:, k]),
            leg,
            perturbations,
            at_rest,
            torque_pathway,
            thesis=thesis,
        ).mean[1]
        for k in (0, 1)
    ]
    return float((damping[1] - damping[0]) / (2.0 * LAG_S))


def undetermined(evidence: str) -> InputError:
    """Refusal of an angle that does not determine I, B and K; ``evidence`` completes the message."""
    return InputError(
        f"expected an angle that determines {', '.join(PARAMETERS)} by the foot's motion, found {evidence}: "
        "check that the markers and the belt moved, and the geometry"
    )
