"""Stiffness and damping matrices of several joints from their responses to known perturbations.

About a posture, the deviations q of the joint angles from unperturbed behaviour obey

    M q'' + B q' + (K + G) q = b u(t)                                                                 (1)

with the inertia M and the stiffness of gravity G of the body, the measured force or belt acceleration u,
and b of its point of action. The mean response y_k to perturbation k, over n_k epochs of which each is
multiplied by the direction of its pulse, is h_k(p) + e; h_k solves (1), and e has the covariance C / n_k of
unperturbed behaviour over an equal time (`unperturbed_covariance`). The epochs begin before the onset,
where h_k = 0, so that C predicts from there how the person would have gone on. Maximum likelihood minimises

    chi2(p) = sum_k n_k (y_k - h_k)' C^-1 (y_k - h_k),     F = sum_k n_k S_k' C^-1 S_k,   S_k = dh_k/dp   (2)

with the Fisher information F. u is measured with little noise, so there is no noise in the regressors.
Standard errors do not come from F but from the scatter of the epochs e about their mean, by their influence
F^-1 S_k' C^-1 (y_ke - y_k), so that C is only a weight. Where F leaves a direction of the parameters
undetermined, p stays near its start there, and is refused.

K and B may be symmetric (6 unknowns each) or not (9). The inertia is exact, or its 2 n constants J, S
(`tepsipe.mechanics.segment_chain`) are unknowns, too. Scales and tables may give values a0 for them, with the
covariance A: (2) gains (a - a0)' A^-1 (a - a0), F gains A^-1, and the intervals include the uncertainty of
a0. If nothing is known of them, the belt alone leaves the scale of all parameters open, however many epochs
there are: (1) with b = -(S ...) is homogeneous in M, B, K and S.

Elements of stiffness and damping matrices that perturbations determine; the others are refused.

The Fisher information F of (2), with every parameter in parts
of its natural size sqrt(K_ii K_jj), sqrt(B_ii B_jj), is examined three ways: directions of all parameters
whose standard error is below a limit (rank), standard errors of single elements, and movements v of the
joints for which the torques K v are known although the elements of K are not. With m perturbations the
joints are moved along about m movements only, and others are known from the shape of the responses in time
alone, if at all.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.identification.one_thread import one_thread
from tepsipe.mechanics.segment_chain import LinearChain
from tepsipe.quantities import Positive

# weight of the start in (2), in 1 per parameter squared, in parts of its scale
RIDGE = 1e-2
ITERATIONS, SETTLED = 30, 1e-3
# a row of the scale is at most so many times its starting value
LARGEST_SCALE = 5.0


@dataclass(frozen=True)
class Perturbation:
    """Epochs of one perturbation.

    Attributes
    ----------
    drive : ndarray, shape (u,)
        Mean force (N) or acceleration of the belt (m/s²) from the onset on, in the direction of the pulses.
    response : ndarray, shape (epochs, samples, n)
        Deviations of the joint angles from unperturbed behaviour (rad), times the direction of the pulse.
    push : ndarray, shape (n,) or None
        b of (1) (m); None for the belt.
    """

    drive: np.ndarray
    response: np.ndarray
    push: np.ndarray | None


@dataclass(frozen=True)
class Setting:
    """Quantities common to all perturbations."""

    body: LinearChain
    """Inertia and gravity about the posture (kg m², N·m/rad)."""
    weight: Annotated[np.ndarray, "(samples n, samples n)"]
    """C^-1 of (2), sample by sample (1/rad²)."""
    before: int
    """Samples of an epoch before the onset."""
    step_s: float
    """Between samples."""
    substeps: int
    """Steps of the drives per sample."""
    symmetric: bool = False
    """Whether K and B are taken as symmetric."""
    inertia_known: bool = True
    """Whether J and S are taken as exact."""
    inertia_covariance: Annotated[np.ndarray, "(2 n, 2 n)"] | None = None
    """Covariance of J and S over their values, if they are unknowns; None if nothing is known of them."""

    @property
    def joints(self) -> int:
        """Number of joints, n."""
        return self.body.posture.size

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Row and column of every unknown of a matrix."""
        n = self.joints
        return [(i, j) for i in range(n) for j in range(i if self.symmetric else 0, n)]

    def start(self) -> np.ndarray:
        """Starting parameters: joints of 1.5 times the critical stiffness (N·m/rad, N·m·s/rad, -)."""
        diagonal = 1.5 * np.abs(np.diag(self.body.gravity))
        k = [diagonal[i] if i == j else 0.0 for i, j in self.pairs]
        inertia = [] if self.inertia_known else [1.0] * len(self.body.inertia_parts)
        return np.array([*k, *(0.04 * x for x in k), *inertia])

    def prior(self) -> np.ndarray:
        """Prior information on the parameters, shape (q, q)."""
        pairs = 2 * len(self.pairs)
        if self.inertia_known or self.inertia_covariance is None:
            return np.zeros((self.start().size,) * 2)
        return scipy.linalg.block_diag(np.zeros((pairs, pairs)), np.linalg.inv(self.inertia_covariance))

    def matrices(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """K (N·m/rad) and B (N·m·s/rad), each of shape (n, n), of parameters."""
        matrices = np.zeros((2, self.joints, self.joints))
        for matrix, values in zip(matrices, np.split(p[: 2 * len(self.pairs)], 2), strict=True):
            for (i, j), value in zip(self.pairs, values, strict=True):
                matrix[i, j] = value
                if self.symmetric:
                    matrix[j, i] = value
        return matrices[0], matrices[1]

    def scale(self, p: np.ndarray) -> np.ndarray:
        """Natural size of every parameter: sqrt(K_ii K_jj), sqrt(B_ii B_jj), J, S (units of the parameters).

        A diagonal element outside the range of (0, 5] times its start counts as the end of the range.
        """
        start, parts = self.start(), []
        for matrix, first in zip(self.matrices(p), self.matrices(start), strict=True):
            diagonal = np.clip(np.diag(matrix), 1e-2 * np.diag(first), LARGEST_SCALE * np.diag(first))
            parts += [np.sqrt(diagonal[i] * diagonal[j]) for i, j in self.pairs]
        return np.array([*parts, *np.ones(p.size - len(parts))])


@dataclass(frozen=True)
class MatrixFit:
    """Estimated parameters and their uncertainty."""

    parameters: Annotated[np.ndarray, "(q,)"]
    """K, then B, by rows (upper triangle if symmetric), then the constants J, S over their nominal values
    (N·m/rad, N·m·s/rad, -)."""
    information: Annotated[np.ndarray, "(q, q)"]
    """F of (2) (1 over the units of the parameters)."""
    covariance: Annotated[np.ndarray, "(q, q)"]
    """By the scatter of the epochs (units of the parameters)."""
    parts: Annotated[np.ndarray, "(perturbations + 1, q, q)"]
    """Contribution of each perturbation, and of the inertia, to it."""
    epochs: tuple[float, ...]
    """Number of epochs of each perturbation, and infinity for the inertia."""
    scale: Annotated[np.ndarray, "(q,)"]
    """Natural size of the parameters (units of the parameters)."""
    chi2: float
    """(2) at the estimate, over what the scatter of single epochs makes of C: 1 per sample if C is right."""
    freedom: int
    """Samples less parameters."""
    setting: Setting

    @property
    def p_value(self) -> float:
        """Probability of a larger chi2 if the model is right."""
        return float(scipy.special.chdtrc(self.freedom, self.chi2))

    def interval(self, combination: np.ndarray, confidence: float = 0.95) -> tuple[float, float]:
        """Value and half width of the interval of a linear combination, with Student's quantile.

        ``combination`` has the shape (q,); degrees of freedom by Welch and Satterthwaite.
        """
        variances = np.array([combination @ part @ combination for part in self.parts])
        freedom = variances.sum() ** 2 / (variances**2 / (np.array(self.epochs) - 1.0)).sum()
        t = scipy.special.stdtrit(freedom, 0.5 + 0.5 * confidence)
        return float(combination @ self.parameters), float(t * np.sqrt(variances.sum()))


def unperturbed_covariance(
    record: Annotated[np.ndarray, "(m, n)", "rad"], samples: int
) -> Annotated[np.ndarray, "(samples n, samples n)", "rad²"]:
    """Covariance of an epoch of unperturbed behaviour, from all epochs that a record holds.

    All overlapping epochs count. (Lagged products divided by their number, which depend on the lag only,
    are not positive definite; divided by the length of the record, they add a random walk to slow sway.)

    record: unperturbed joint angles.
    Returns: C, sample by sample.
    """
    m, n = record.shape
    least = 20 * samples
    if m < least:
        raise InputError(
            f"unperturbed behaviour: expected at least {least} samples, 20 epochs, found {m}: record the "
            "person for longer before or between the perturbations"
        )
    x = record - record.mean(axis=0)
    if not x.any(axis=0).all():
        raise InputError(
            "unperturbed behaviour: expected every joint angle to vary, found one that is constant: check "
            "its markers"
        )
    every = np.lib.stride_tricks.sliding_window_view(x, samples, axis=0)
    every = np.swapaxes(every, 1, 2).reshape(-1, samples * n)
    return every.T @ every / len(every)


def responses(
    setting: Setting, p: Annotated[np.ndarray, "(q,)"], perturbation: Perturbation
) -> tuple[np.ndarray, np.ndarray]:
    """Response (1) and its slopes.

    p: parameters (N·m/rad, N·m·s/rad, -).
    perturbation: drive and point of action.

    Returns:
        h: joint angles, 0 before the onset (rad). Shape (samples, n).
        slopes: dh/dp (rad over the units of the parameters). Shape (samples, n, q).
    """
    n, body = setting.joints, setting.body
    k, b = setting.matrices(p)
    factors = np.ones(len(body.inertia_parts)) if setting.inertia_known else p[2 * len(setting.pairs) :]
    mass = np.tensordot(factors, body.inertia_parts, 1)
    total = k + np.tensordot(factors, body.gravity_parts, 1)
    along = factors @ body.belt_parts if perturbation.push is None else perturbation.push
    inverse = np.linalg.inv(mass)
    system = np.zeros((2 * n, 2 * n))
    system[:n, n:] = np.eye(n)
    system[n:, :n], system[n:, n:] = -inverse @ total, -inverse @ b
    inputs = np.zeros((2 * n, n))
    inputs[n:] = inverse
    step = setting.step_s / setting.substeps
    states = _propagated(system, inputs, (perturbation.drive[:, None] * along)[..., None], step)[..., 0]
    q, rate = states[:, :n], states[:, n:]
    second = (perturbation.drive[:, None] * along - rate @ b.T - q @ total.T) @ inverse.T
    # torque caused by the change of one parameter, sample by sample
    every = slice(None, None, setting.substeps)
    pushed = np.zeros((q[every].shape[0], n, p.size))
    for column, (row, col) in enumerate(setting.pairs):
        for shift, motion in ((0, q), (len(setting.pairs), rate)):
            pushed[:, row, column + shift] = -motion[every, col]
            if setting.symmetric:
                pushed[:, col, column + shift] = -motion[every, row]
    if not setting.inertia_known:
        first = 2 * len(setting.pairs)
        pushed[:, :, first:] = -np.einsum("aij,tj->tia", body.inertia_parts, second[every])
        pushed[:, :, first:] -= np.einsum("aij,tj->tia", body.gravity_parts, q[every])
        if perturbation.push is None:
            pushed[:, :, first:] += np.einsum("ai,t->tia", body.belt_parts, perturbation.drive[every])
    slopes = _propagated(system, inputs, pushed, setting.step_s)[:, :n]
    quiet = ((setting.before, 0), (0, 0))
    return np.pad(q[every], quiet), np.pad(slopes, (*quiet, (0, 0)))


def _propagated(system: np.ndarray, inputs: np.ndarray, force: np.ndarray, step_s: float) -> np.ndarray:
    """States from rest under forces that are linear between samples, shape (t, 2 n, q), exactly."""
    n2, n = inputs.shape
    whole = np.zeros((n2 + 2 * n, n2 + 2 * n))
    whole[:n2, :n2], whole[:n2, n2 : n2 + n] = system, inputs
    whole[n2 : n2 + n, n2 + n :] = np.eye(n)
    exact = scipy.linalg.expm(whole * step_s)
    along = exact[:n2, :n2]
    now, later = exact[:n2, n2 : n2 + n], exact[:n2, n2 + n :] / step_s
    driven = (now - later) @ force[:-1] + later @ force[1:]
    states = np.zeros((force.shape[0], n2, force.shape[2]))
    for t, added in enumerate(driven):
        states[t + 1] = along @ states[t] + added
    return states


def information(setting: Setting, p: np.ndarray, perturbations: Sequence[Perturbation]) -> np.ndarray:
    """Fisher information F of (2), without a prior, shape (q, q) (1 over the units of the parameters)."""
    total = np.zeros((p.size, p.size))
    for one in perturbations:
        slopes = responses(setting, p, one)[1].reshape(-1, p.size)
        total += len(one.response) * slopes.T @ setting.weight @ slopes
    return total


@one_thread()
def fit_matrices(setting: Setting, perturbations: Sequence[Perturbation]) -> MatrixFit:
    """Estimate K and B, and the inertia if it is not known.

    Returns: parameters and what is known of them.
    """
    for one in perturbations:
        _check(setting, one)
    start = setting.start()
    scale, prior = setting.scale(start), setting.prior()
    ridge = prior + np.diag(RIDGE / scale**2)
    means = [one.response.mean(axis=0) for one in perturbations]

    def cost(p: np.ndarray):
        gradient = -ridge @ (p - start)
        worth, total = -gradient @ (p - start), 0.0
        chi2, gains = 0.0, []
        for one, mean in zip(perturbations, means, strict=True):
            h, slopes = responses(setting, p, one)
            weighted = len(one.response) * slopes.reshape(-1, p.size).T @ setting.weight
            residual = (mean - h).ravel()
            gradient = gradient + weighted @ residual
            total = total + weighted @ slopes.reshape(-1, p.size)
            chi2 += len(one.response) * residual @ setting.weight @ residual
            gains.append(weighted)
        return chi2 + worth, gradient, total, gains, chi2

    p, current, damping = start, cost(start), 1e-3
    for _ in range(ITERATIONS):
        curvature = current[2] + ridge
        damped = curvature + damping * np.diag(np.diag(curvature))
        step = np.linalg.solve(damped, current[1])
        # too large a step gives a body that falls within the window: its cost is infinite
        with np.errstate(over="ignore", invalid="ignore"):
            tried = cost(p + step)
        if not tried[0] <= current[0]:
            damping = max(10.0 * damping, 1e-6)
            if damping > 1e6:
                break
            continue
        gained = current[0] - tried[0]
        p, current, damping = p + step, tried, 0.1 * damping
        if gained < SETTLED:
            break
    _, _, f, gains, chi2 = current
    inverse = np.linalg.inv(f + ridge)
    parts, scatter = [], 0.0
    for one, mean, weighted in zip(perturbations, means, gains, strict=True):
        count = len(one.response)
        about = (one.response - mean).reshape(count, -1)
        influence = about @ weighted.T @ inverse / count
        parts.append(influence.T @ influence * count / (count - 1.0))
        scatter += np.einsum("ij,jk,ik->", about, setting.weight, about, optimize=True) / (count - 1.0)
    samples = sum(mean.size for mean in means)
    parts.append(inverse @ prior @ inverse)
    epochs = (*(float(len(one.response)) for one in perturbations), np.inf)
    chi2 = float(chi2 * samples / scatter)
    return MatrixFit(
        p, f + prior, sum(parts), np.array(parts), epochs, setting.scale(p), chi2, samples - p.size, setting
    )


def _check(setting: Setting, one: Perturbation) -> None:
    count, samples, _ = one.response.shape
    after = (one.drive.size - 1) // setting.substeps + 1
    if count < 2:
        raise InputError(f"epochs: expected at least 2 of a perturbation, found {count}: repeat it")
    if samples != setting.before + after:
        raise InputError(
            f"epochs: expected {setting.before + after} samples, as the drive is long, found {samples}: cut "
            "both alike"
        )


@dataclass(frozen=True)
class Limits:
    """Largest error of a parameter that counts as determined; the constants of inertia have that of B."""

    stiffness_percent: Positive = 15.0
    """Half width of a 95 % interval of *K*<sub>ij</sub> in per cent of √(*K*<sub>ii</sub> *K*<sub>jj</sub>),
    and standard error of every direction of the unknowns."""
    damping_percent: Positive = 50.0
    """The same of *B*."""

    @property
    def stiffness(self) -> float:
        """Limit of K_ij in parts of sqrt(K_ii K_jj)."""
        return 0.01 * self.stiffness_percent

    def of(self, setting: Setting, q: int) -> np.ndarray:
        """Limit of every parameter, shape (q,)."""
        pairs = len(setting.pairs)
        return np.r_[np.full(pairs, self.stiffness), np.full(q - pairs, 0.01 * self.damping_percent)]


@dataclass(frozen=True)
class Determined:
    """Directions and parameters determined by a Fisher information."""

    rank: int
    """Directions of the parameters, in parts of their limits, with a standard error below 1."""
    unknowns: int
    """Number of parameters."""
    condition: float
    """Condition of the information of the scaled parameters: largest over smallest eigenvalue."""
    errors: Annotated[np.ndarray, "(q,)"]
    """Standard errors in parts of the scale."""
    entries: Annotated[np.ndarray, "(q,)"]
    """Whether the 95 % interval of a parameter is within its limit."""
    directions: Annotated[np.ndarray, "(n, n)"]
    """Rows: movements of the joints, in parts of 1/sqrt(K_ii), from the best to the least determined."""
    direction_errors: np.ndarray
    """Largest standard error of the torque of a joint against each movement, in parts of the scale."""

    @property
    def all(self) -> bool:
        """True if every direction and every parameter is determined."""
        return self.rank == self.unknowns and bool(self.entries.all())


def determined(
    setting: Setting,
    information_: Annotated[np.ndarray, "(q, q)"],
    scale: Annotated[np.ndarray, "(q,)"],
    limits: Limits,
) -> Determined:
    """Find the directions and parameters that a Fisher information determines within limits.

    scale: natural size of the parameters (units of the parameters).
    limits: in parts of the scale.
    Returns: rank, condition, errors and movements.
    """
    q, limit = scale.size, limits.of(setting, scale.size)
    natural = information_ * np.outer(scale, scale)
    values, vectors = scipy.linalg.eigh(natural)
    # below this, only rounding errors remain
    values = np.maximum(values, 1e-15 * values[-1])
    covariance = (vectors / values) @ vectors.T
    errors = np.sqrt(np.diag(covariance))
    strengths = scipy.linalg.eigvalsh(natural * np.outer(limit, limit))
    n = setting.joints
    where = np.zeros((n, n), int)
    for k, (i, j) in enumerate(setting.pairs):
        where[i, j] = k
        if setting.symmetric:
            where[j, i] = k
    blocks = np.array([covariance[np.ix_(row, row)] for row in where])
    spread, movements = scipy.linalg.eigh(blocks.sum(axis=0))
    movements = movements.T[np.argsort(spread)]
    largest = np.array([max(np.sqrt(v @ block @ v) for block in blocks) for v in movements])
    return Determined(
        int((strengths > 1.0).sum()),
        q,
        float(values[-1] / values[0]),
        errors,
        1.96 * errors <= limit,
        movements * np.sign(movements[np.arange(n), np.abs(movements).argmax(axis=1)])[:, None],
        largest,
    )


@dataclass(frozen=True)
class Entry:
    """One element of a matrix, or the reason why it has no value."""

    name: str
    """For example K_ankle_knee."""
    value: Annotated[float, "N·m/rad"]
    half_width: Annotated[float, "N·m·s/rad"]
    """Estimate and half width of its 95 % interval; NaN if refused."""
    refusal: str = ""
    """One sentence; empty if there is a value."""


def entries(fit: MatrixFit, names: Sequence[str], limits: Limits, known: Determined) -> list[Entry]:
    """Elements of K and B with their 95 % intervals (N·m/rad, N·m·s/rad), or refused.

    If a direction of the parameters is undetermined, the estimate along it is arbitrary. Intervals of
    elements that seem independent of it would rest on slopes at an arbitrary point, so all elements are
    refused.

    names: names of the joints.
    limits: largest half width of an interval in parts of sqrt(K_ii K_jj), sqrt(B_ii B_jj).
    known: directions determined by the information at the estimate.
    Returns: elements of K, then of B, by rows.
    """
    pairs = fit.setting.pairs
    limit = limits.of(fit.setting, fit.parameters.size)
    elements = []
    for kind, (i, row), (j, column) in product("KB", enumerate(names), enumerate(names)):
        place = pairs.index((i, j) if (i, j) in pairs else (j, i))
        k = place if kind == "K" else len(pairs) + place
        elements.append(_entry(fit, f"{kind}_{row}_{column}", k, limit[k], known))
    return elements


def _entry(fit: MatrixFit, name: str, k: int, limit: float, known: Determined) -> Entry:
    """One element of K or B, the parameter at place ``k``, with its interval or the reason of its refusal."""
    value, half = fit.interval(np.eye(fit.parameters.size)[k])
    share = max(half / fit.scale[k], 1.96 * known.errors[k])
    if known.rank < known.unknowns:
        return _refused(
            name, f"the perturbations determine {known.rank} of {known.unknowns} directions of the unknowns"
        )
    if share > limit:
        return _refused(
            name,
            f"its 95 % interval is ±{100.0 * share:.2g} % of sqrt({name[0]}_ii {name[0]}_jj), more than "
            f"{100.0 * limit:g} %",
        )
    return Entry(name, value, half)


def _refused(name: str, reason: str) -> Entry:
    return Entry(name, float("nan"), float("nan"), f"{name} is not determined: {reason}")
