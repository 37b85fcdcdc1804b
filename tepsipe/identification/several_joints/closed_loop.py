"""Impedance of several joints that stand in a closed loop, with the perturbation as instrument.

With the torque tau_i of joint i that resists the angles theta_j of all joints,

    tau_i = sum_j [ K_ij + B_ij s + (D_ij + E_ij s) exp(-s d_i) ] theta_j + n_i                       (1)

K and B are stiffness and damping that act at once, D and E stiffness and damping of a reflex with delay d_i.
n_i is the person's spontaneous torque. It moves the body, so theta is correlated with n_i and least
squares of (1) are biased. The perturbation u is independent of n_i: at the right parameters the residual of
(1) is not coherent with it. Let A_l and C_l be the parts of the cross products of [tau_i, theta_j ...] in
band l (b frequencies) that are and are not linear in u (m perturbations), v = [1, -p]. The estimate minimises

    chi2(p) = 2 (b - (m + 1)/2) sum_l log(1 + v'A_l v / v'C_l v)                                       (2)

that is the coherence of the residual with the perturbation, in every band over its own noise. This is limited
information maximum likelihood (Anderson and Rubin 1949) with noise of any spectrum; unlike two-stage least
squares it stays unbiased if coherence is low. With the right model chi2 has a chi-squared distribution with
2 m L - q degrees of freedom, which tests the model. Standard errors come from the jackknife over bands.

Quantities that the data do not determine are refused
(`tepsipe.identification.several_joints.closed_loop`).

Identifiability of parameters that are estimated with instruments.

Per band l, the regressors x have cross products A_l that are linear in the perturbation and C_l that are not;
by chance A_l contains m/(b - m) C_l of noise. With the noise s_l of the residual,

    N = sum_l 2 m/(b - m) C_l / s_l,     F = sum_l 2 A_l / s_l - N                                     (1)

F is the Fisher information of the parameters, N what noise alone would show as such. Directions w of the
parameters with F w = (r - 1) N w, w'N w = 1, have the strength r (Cragg and Donald 1993). With one
perturbation all angles are responses to one signal u: theta_j = H_j u, and any change of the impedance with

    sum_j dZ_ij(s) H_j(s) = 0                                                                         (2)

leaves the torque that u drives the same. In the mechanics of a body without delays, H_j = N_j(s)/D(s) with
polynomials N_j of second order, so dZ = c [N_2, -N_1] is such a change: a model of K and B alone excludes it,
one with terms of inertia or with a free delayed K and B for every angle does not. If joints move in
proportion, (2) holds for K and B, too. Directions of a strength below a limit are not determined, and neither
is a parameter to which they contribute.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy
from annotated_types import Ge, Gt, Le

from tepsipe.errors import InputError
from tepsipe.identification.one_thread import one_thread
from tepsipe.quantities import ASCENDING, Frequency, Latency, Pair

# signal-to-noise ratio assumed for a direction that is too weak
CONCEDED = 0.02


@dataclass(frozen=True)
class Directions:
    """Directions of the parameters and the information along each."""

    strength: Annotated[np.ndarray, "(q,)"]
    """Power in the bands with the perturbation over the power of noise alone, from weak to strong."""
    vectors: Annotated[np.ndarray, "(q, q)"]
    """Columns: one standard deviation of noise along each direction (units of the parameters)."""
    influence: Annotated[np.ndarray, "(L, q)"]
    """Change of the parameters without one band, along the directions that are determined (units of the
    parameters)."""
    limit: float
    """Least strength of a direction that is determined."""

    def in_units(self, factor: np.ndarray) -> "Directions":
        """The same for parameters multiplied by ``factor``, shape (q,) (unit of the result over its own)."""
        return Directions(self.strength, self.vectors * factor[:, None], self.influence * factor, self.limit)

    def standard_error(self, combination: np.ndarray) -> float:
        """Standard error of a linear combination of the parameters, shape (q,): jackknife over the bands.

        Directions that are too weak count with a signal of 2 % of noise, so that a combination to which they
        contribute has a large standard error.
        """
        weak = self.strength < self.limit
        loads = combination @ self.vectors[:, weak]
        bands = self.influence.shape[0]
        chance = ((self.influence @ combination) ** 2).sum() * (bands - 1) / bands
        return float(np.sqrt(chance + (loads**2).sum() / CONCEDED))

    def weak_partners(self, combination: np.ndarray) -> np.ndarray:
        """Parameters that a weak direction of a combination also moves, shape (q,), relative."""
        loads = combination @ self.vectors
        weak = self.strength < self.limit
        if not weak.any():
            return np.zeros(combination.size)
        k = int(np.flatnonzero(weak)[np.abs(loads[weak]).argmax()])
        return np.abs(self.vectors[:, k])


def directions_by_strength(
    a: Annotated[np.ndarray, "(L, 1 + q, 1 + q)"],
    c: Annotated[np.ndarray, "(L, 1 + q, 1 + q)"],
    v: Annotated[np.ndarray, "(1 + q,)"],
    noise: Annotated[np.ndarray, "(L,)"],
    chance: float,
    limit: float,
) -> Directions:
    """Directions of the parameters by strength (1).

    a, c: cross products of response and regressors that are, and are not, linear in the perturbation
    (squared units of the columns).
    v: 1 and the negative parameters (units of the parameters).
    noise: power of the residual's noise in each band (squared unit of the response).
    chance: m/(b - m), fraction of C that A contains by chance.
    limit: least strength of a direction that is determined.
    """
    total = 2.0 * np.einsum("l,lij->ij", 1.0 / noise, a)[1:, 1:]
    alone = 2.0 * chance * np.einsum("l,lij->ij", 1.0 / noise, c)[1:, 1:]
    # without any noise, rounding errors take its place
    alone = alone + 1e-12 * np.trace(total) / total.shape[0] * np.eye(total.shape[0])
    strength, vectors = scipy.linalg.eigh(total, alone)
    strong = vectors[:, strength >= limit]
    signal = strength[strength >= limit] - 1.0
    # one Newton step from the estimate without a band: its gradient over the information of the others
    weighted = 2.0 * (a - chance * c) / noise[:, None, None]
    gradient = (weighted @ v)[:, 1:] @ strong
    others = np.diag(signal) - strong.T @ weighted[:, 1:, 1:] @ strong
    influence = np.linalg.solve(others, gradient[:, :, None])[:, :, 0] @ strong.T
    return Directions(strength, vectors, influence, limit)


MODELS = {
    "intrinsic": "*K* and *B* of both angles",
    "own-reflex": "the same with a delayed *K* and *B* of each joint's own angle",
    "all-reflex": "the same of both angles",
}
# largest slope of (2) per standard error of a parameter at its minimum
GRADIENT = 1e-3
# (2) rises by this for a parameter one standard error along a direction that is not determined
RIDGE = 0.1


@dataclass(frozen=True)
class MultiJointOptions:
    """Choices of the estimate."""

    band_hz: Annotated[Pair[Frequency], ASCENDING]
    """Lowest and highest frequency that is fitted: where the platform moves and the torque is measured
    well."""
    averaged_bins: Annotated[int, Ge(4)]
    """Raw frequencies per band; the record must hold 8 bands, and so must its held-out part."""
    taper_fraction: Annotated[float, Ge(0), Le(0.25)]
    """Part of the record over which each end fades."""
    delays_s: Pair[Latency]
    """Delays of reflexes that are tried, one for each joint's torque."""
    delay_step_s: Latency
    """Step of these delays."""
    strength: Annotated[float, Gt(1)] = 2.0
    """Least power of a combination of parameters in the bands over that of noise alone; weaker ones are not
    determined."""


@dataclass(frozen=True)
class Spectra:
    """Discrete Fourier transforms of a record in bands."""

    frequency_hz: Annotated[np.ndarray, "(L, b)"]
    """Raw frequencies of each band."""
    perturbation: Annotated[np.ndarray, "(L, b, m)"]
    """Orthonormal columns that span the perturbations in each band."""
    angle: Annotated[np.ndarray, "(L, b, joints)", "rad"]
    torque: Annotated[np.ndarray, "(L, b, joints)", "N·m"]
    """Transforms."""
    response: Annotated[np.ndarray, "(L, m, 2 joints)"]
    """Frequency response from the perturbations to angles and torques (rad, N·m per unit of u)."""
    coherence: Annotated[np.ndarray, "(L, 2 joints)"]
    """Squared multiple coherence of angles and torques with the perturbations."""

    def coherence_threshold(self) -> float:
        """Coherence that unrelated signals exceed with a probability of 5 %."""
        _, b, m = self.perturbation.shape
        return float(scipy.special.betaincinv(m, b - m, 0.95))


@dataclass(frozen=True)
class RowFit:
    """Parameters of one joint's torque."""

    model: str
    """One of `MODELS`."""
    terms: tuple[tuple[str, int], ...]
    """Kind (K, B, D, E) of each parameter and joint whose angle it multiplies."""
    parameters: Annotated[np.ndarray, "(q,)"]
    """In the order of ``terms`` (N·m/rad, N·m·s/rad); along undetermined directions they are arbitrary."""
    delay_s: float | None
    """d_i; None without a reflex."""
    delays_s: Annotated[np.ndarray, "(t,)"]
    delay_chi2: Annotated[np.ndarray, "(t,)"]
    """Delays that were tried (s) and chi2 (2) at each."""
    chi2: float
    """At the estimate."""
    freedom: int
    """Degrees of freedom of chi2 if the model is right."""
    directions: Directions
    """Determined directions; last column the delay, if there is one (units of the parameters)."""
    direct: Annotated[np.ndarray, "(q,)"]
    """Ordinary least squares of (1) at the same delay, which feedback biases (units of the parameters)."""
    converged: bool
    """Whether the fixed point was reached."""

    @property
    def p_value(self) -> float:
        """Probability of a larger chi2 if the model is right."""
        return float(scipy.special.chdtrc(self.freedom, self.chi2))

    def impedance(self, frequency_hz: np.ndarray) -> np.ndarray:
        """Torque per angle of each joint at some frequencies (Hz), shape (n, joints) (N·m/rad)."""
        s = 2j * np.pi * np.asarray(frequency_hz)
        joints = 1 + max(joint for _, joint in self.terms)
        impedance = np.zeros((s.size, joints), complex)
        for (kind, joint), value in zip(self.terms, self.parameters, strict=True):
            impedance[:, joint] += value * _factor(kind, s, self.delay_s)
        return impedance


def banded_spectra(
    perturbation: np.ndarray,
    angle: Annotated[np.ndarray, "(n, joints)"],
    torque: Annotated[np.ndarray, "(n, joints)"],
    rate_hz: float,
    options: MultiJointOptions,
) -> Spectra:
    """Transforms of a record, without means, in bands of neighbouring frequencies.

    perturbation: external perturbations, independent of the person.
    angle, torque: joint angles (rad) and torques that resist them (N·m).
    """
    u = perturbation.reshape(angle.shape[0], -1)
    n, b = u.shape[0], options.averaged_bins
    frequency = np.fft.rfftfreq(n, 1.0 / rate_hz)
    low, high = options.band_hz
    inside = np.flatnonzero((frequency >= low) & (frequency <= min(high, 0.499 * rate_hz)))
    bands = inside.size // b
    if bands < 8:
        raise InputError(
            f"expected at least 8 bands of {b} frequencies from {low:g} to {high:g} Hz, found {bands} in "
            f"{n / rate_hz:.4g} s: record longer, widen the band, or average over fewer bins"
        )
    for name, x in (("perturbation", u), ("angle", angle), ("torque", torque)):
        if not np.ptp(x, axis=0).all():
            raise InputError(
                f"expected every {name} to vary, found one that is constant: check its column, and "
                "whether the platform moved"
            )
    chosen = inside[: bands * b].reshape(bands, b)
    window = scipy.signal.windows.tukey(n, 2.0 * options.taper_fraction)[:, None]

    def transformed(x: np.ndarray) -> np.ndarray:
        return np.fft.rfft(window * (x - x.mean(axis=0)), axis=0)[chosen] / np.sqrt((window**2).sum())

    of_u, of_angle, of_torque = transformed(u), transformed(angle), transformed(torque)
    orthonormal, triangle = np.linalg.qr(of_u)
    both = np.concatenate([of_angle, of_torque], axis=2)
    projected = np.conj(np.swapaxes(orthonormal, 1, 2)) @ both
    power = (np.abs(both) ** 2).sum(axis=1)
    return Spectra(
        frequency[chosen],
        orthonormal,
        of_angle,
        of_torque,
        np.linalg.solve(triangle, projected),
        (np.abs(projected) ** 2).sum(axis=1) / power,
    )


def _factor(kind: str, s: np.ndarray, delay_s: float | None) -> np.ndarray:
    """Factor of an angle in (1), without the parameter, at s (rad/s)."""
    if kind in "KB":
        return np.ones_like(s) if kind == "K" else s
    late = np.exp(-s * delay_s)
    return late if kind == "D" else s * late


def model_terms(model: str, joint: int, joints: int) -> tuple[tuple[str, int], ...]:
    """Parameters of one joint's torque in a model: kind and joint whose angle it multiplies.

    ``intrinsic`` has K and B of all angles, ``own-reflex`` adds a reflex to the joint's own angle,
    ``all-reflex`` to all angles.
    """
    terms = [(kind, j) for kind in "KB" for j in range(joints)]
    if model == "own-reflex":
        terms += [("D", joint), ("E", joint)]
    elif model == "all-reflex":
        terms += [(kind, j) for kind in "DE" for j in range(joints)]
    elif model != "intrinsic":
        raise InputError(f"expected a model out of {', '.join(MODELS)}, found {model!r}: correct its name")
    return tuple(terms)


def _columns(spectra: Spectra, joint: int, terms, delay_s: float | None) -> np.ndarray:
    """Torque of a joint and regressors of (1), shape (L, b, 1 + q) (N·m, rad, rad/s)."""
    s = 2j * np.pi * spectra.frequency_hz
    regressors = [_factor(kind, s, delay_s) * spectra.angle[:, :, j] for kind, j in terms]
    return np.stack([spectra.torque[:, :, joint], *regressors], axis=2)


def cross_products(
    perturbation: Annotated[np.ndarray, "(L, b, m)"], columns: Annotated[np.ndarray, "(L, b, q)"]
) -> tuple[np.ndarray, np.ndarray]:
    """A and C of (2): cross products of columns that are, and are not, linear in the perturbation.

    perturbation: orthonormal in each band.
    columns: Transforms.
    Returns: real parts (squared units of the columns).
    """
    adjoint = np.conj(np.swapaxes(columns, 1, 2))
    projected = np.conj(np.swapaxes(perturbation, 1, 2)) @ columns
    a = (np.conj(np.swapaxes(projected, 1, 2)) @ projected).real
    return a, (adjoint @ columns).real - a


@dataclass(frozen=True)
class Solution:
    """Minimum of (2)."""

    p: Annotated[np.ndarray, "(q,)"]
    """Parameters of scaled columns."""
    chi2: float
    """(2) there."""
    weak: int
    """Number of directions that are not determined."""
    converged: bool
    """Whether (2) is flat there."""


def minimise(
    a: Annotated[np.ndarray, "(L, 1 + q, 1 + q)"],
    c: Annotated[np.ndarray, "(L, 1 + q, 1 + q)"],
    shape: tuple[int, int],
    strength: float,
    starts=(),
) -> Solution:
    """Minimise (2) from the solution for k = m/(b - m) and from others, small along weak directions.

    a, c: cross products of torque and regressors.
    shape: frequencies per band b and perturbations m.
    strength: strength of a direction that is determined.
    starts: further parameters to start from. Shape (q,).
    """
    b, m = shape
    chance = m / (b - m)
    noise = c[:, 0, 0] / (b - m)
    for _ in range(3):
        g = np.einsum("l,lij->ij", 1.0 / noise, a - chance * c)
        first = np.linalg.lstsq(g[1:, 1:], g[1:, 0], rcond=None)[0]
        v = np.r_[1.0, -first]
        noise = ((c @ v) @ v) / (b - m)
    directions = directions_by_strength(a, c, v, noise, chance, strength)
    weak = directions.strength < strength
    # unit steps along each direction change (2) about equally
    basis = directions.vectors / np.sqrt(np.maximum(directions.strength - 1.0, CONCEDED))
    inverse = np.linalg.inv(basis)
    factor = 2.0 * (b - 0.5 * (m + 1))

    def chi2_of(p: np.ndarray) -> tuple[float, np.ndarray]:
        v = np.r_[1.0, -p]
        av, cv = a @ v, c @ v
        coherent, rest = av @ v, cv @ v
        slope = ((av + cv) / (coherent + rest)[:, None] - cv / rest[:, None]).sum(axis=0)
        return factor * np.log1p(coherent / rest).sum(), -2.0 * factor * slope[1:]

    def cost(z: np.ndarray) -> tuple[float, np.ndarray]:
        value, slope = chi2_of(basis @ z)
        return value + RIDGE * (z[weak] ** 2).sum(), basis.T @ slope + 2.0 * RIDGE * np.where(weak, z, 0.0)

    minima = [
        scipy.optimize.minimize(cost, inverse @ start, jac=True, method="BFGS", options={"gtol": GRADIENT})
        for start in (first, *starts)
    ]
    best = min(minima, key=lambda one: one.fun)
    p = basis @ best.x
    flat = bool(np.abs(best.jac).max() < 1e3 * GRADIENT)
    return Solution(p, chi2_of(p)[0], int(weak.sum()), flat)


def _scaled(a: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cross products of columns of unit power, and the roots of their power (units of the columns)."""
    scale = np.sqrt(np.einsum("lii->i", a + c))
    return a / np.outer(scale, scale), c / np.outer(scale, scale), scale


def scaled_products(spectra: Spectra, joint: int, terms, delay_s: float | None):
    """Cross products of (2) for columns of unit power.

    joint: whose torque.
    terms: kinds of the parameters, and joints whose angle they multiply.
    delay_s: delay of a reflex.

    Returns
    -------
    a, c : ndarray, shape (L, 1 + q, 1 + q)
        Parts that are, and are not, linear in the perturbations.
    scale : ndarray, shape (1 + q,)
        Roots of the columns' power (N·m, rad, rad/s).
    """
    return _scaled(*cross_products(spectra.perturbation, _columns(spectra, joint, terms, delay_s)))


@one_thread()
def fit_row(spectra: Spectra, joint: int, model: str, options: MultiJointOptions) -> RowFit:
    """Parameters of one joint's torque by the perturbation as instrument.

    joint: whose torque.
    model: {"intrinsic", "own-reflex", "all-reflex"}: Terms of (1).
    Returns: parameters, test of the model, and what the record determines.
    """
    _, b, m = spectra.perturbation.shape
    terms = model_terms(model, joint, spectra.angle.shape[2])

    delays, tried, delay, starts = np.empty(0), np.empty(0), None, ()
    if model != "intrinsic":
        count = 1 + round((options.delays_s[1] - options.delays_s[0]) / options.delay_step_s)
        delays = np.linspace(*options.delays_s, max(count, 3))
        products = [scaled_products(spectra, joint, terms, d)[:2] for d in delays]
        tried, starts = _profile(products, (b, m), options.strength)
        delay = _vertex(delays, tried)
    a, c, scale = scaled_products(spectra, joint, terms, delay)
    solution = minimise(a, c, (b, m), options.strength, starts)
    parameters = solution.p * scale[0] / scale[1:]
    normal = (a + c).sum(axis=0)
    direct = np.linalg.lstsq(normal[1:, 1:], normal[1:, 0], rcond=None)[0] * scale[0] / scale[1:]
    return RowFit(
        model=model,
        terms=terms,
        parameters=parameters,
        delay_s=delay,
        delays_s=delays,
        delay_chi2=tried,
        chi2=solution.chi2,
        freedom=2 * m * spectra.frequency_hz.shape[0] - (len(terms) - solution.weak) - (delay is not None),
        directions=_determined(spectra, joint, terms, parameters, delay, options),
        direct=direct,
        converged=solution.converged,
    )


def _profile(products: list, shape: tuple[int, int], strength: float):
    """Least chi2 of every delay, searches started at its neighbours' solutions, too; best solution."""
    solutions = []
    for a, c in products:
        solutions.append(minimise(a, c, shape, strength, [solution.p for solution in solutions[-1:]]))
    for k in range(len(solutions) - 2, -1, -1):
        restarted = minimise(*products[k], shape, strength, [solutions[k + 1].p])
        solutions[k] = min(solutions[k], restarted, key=lambda solution: solution.chi2)
    chi2 = np.array([solution.chi2 for solution in solutions])
    return chi2, (solutions[int(chi2.argmin())].p,)


def _vertex(delays: np.ndarray, chi2: np.ndarray) -> float:
    """Delay of the least chi2: vertex of the parabola through the best one tried and its neighbours (s)."""
    k = int(chi2.argmin())
    if not 0 < k < delays.size - 1:
        return float(delays[k])
    left, middle, right = chi2[k - 1 : k + 2]
    bend = left - 2.0 * middle + right
    step = delays[1] - delays[0]
    return float(delays[k] + (0.5 * step * (left - right) / bend if bend > 0.0 else 0.0))


def _determined(spectra, joint, terms, parameters, delay_s, options) -> Directions:
    """Directions of the parameters, including the delay, that the record determines."""
    _, b, m = spectra.perturbation.shape
    columns = _columns(spectra, joint, terms, delay_s)
    v = np.r_[1.0, -parameters]
    if delay_s is not None:
        late = [k for k, (kind, _) in enumerate(terms) if kind in "DE"]
        slope = -2j * np.pi * spectra.frequency_hz * (columns[:, :, 1:][:, :, late] @ parameters[late])
        columns, v = np.concatenate([columns, slope[:, :, None]], axis=2), np.r_[v, 0.0]
    a, c = cross_products(spectra.perturbation, columns)
    noise = ((c @ v) @ v) / (b - m)
    a, c, scale = _scaled(a, c)
    v = v * scale / scale[0]
    return directions_by_strength(a, c, v, noise / scale[0] ** 2, m / (b - m), options.strength).in_units(
        scale[0] / scale[1:]
    )
