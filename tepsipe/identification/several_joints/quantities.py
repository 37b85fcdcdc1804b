"""Stiffness and damping of several joints with intervals, or a sentence that refuses them.

A quantity c'p is quoted if the record determines it: its standard error u, times the angle (or rate) that the
perturbation drives, may be at most a stated share of the torque that the perturbation drives,

    u rms(x) <= share rms(tau)                                                                       (1)

and the record must exclude values at twice this distance (below).
Otherwise it is refused by name, and no number is given. Combinations remain: the static stiffness K + D of an
angle, and the static stiffness along the mode in which the perturbation moves the joints slowly,
sum_j (K_ij + D_ij) phi_j, which is known even if the joints move in proportion.

Profile of the criterion: standard errors trust the model near its estimate, at its delay. Where directions
of the parameters are hardly determined, distant values may fit equally well with another delay. A
quantity c'p is therefore held at a value v, and the criterion chi2 of
`tepsipe.identification.several_joints.closed_loop` is minimised over all other parameters and over the
delays. Its rise over the least chi2 has a chi-squared distribution with one degree of freedom if v is true
and the delay is identified: below 3.84 the record does not exclude v. If the delay is not, or directions
beside it, the rise can be larger, but chi2 itself has at most its own distribution (Anderson and Rubin
1949): v is excluded only if the model with v is rejected.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.identification.one_thread import one_thread
from tepsipe.identification.result import Quantity, symbol_of
from tepsipe.identification.several_joints.closed_loop import (
    RowFit,
    Spectra,
    cross_products,
    minimise,
    scaled_products,
)

# rise of chi2 that excludes a value at 95 %
EXCLUDED = 3.84


class Profile:
    """Least chi2 of one joint's torque with a quantity held at a value."""

    def __init__(self, fit: RowFit, spectra: Spectra, joint: int, weakly: bool):
        _, b, m = spectra.perturbation.shape
        self._shape, self._fit = (b, m), fit
        # torque that no model of this kind explains makes every value less certain
        self._excluded = EXCLUDED * max(1.0, fit.chi2 / fit.freedom)
        delays = [None]
        if fit.delay_s is not None:
            near = np.full(fit.delays_s.size, True)
            if not weakly:
                near = fit.delay_chi2 <= fit.delay_chi2.min() + self._excluded
            delays = sorted({*fit.delays_s[near].tolist(), fit.delay_s})
        self._products = [scaled_products(spectra, joint, fit.terms, delay) for delay in delays]
        scale = [fit.parameters * scale[1:] / scale[0] for _, _, scale in self._products]
        # without the term that keeps parameters small along weak directions: a strength below all others
        self._best = [
            minimise(a, c, self._shape, 0.0, [start])
            for (a, c, _), start in zip(self._products, scale, strict=True)
        ]
        self.least = min([fit.chi2, *(one.chi2 for one in self._best)])
        if weakly:
            self._excluded = float(scipy.special.chdtri(fit.freedom + 1, 0.05)) - self.least

    def excludes(self, combination: Annotated[np.ndarray, "(q,)"], value: float) -> bool:
        """Test whether the record excludes a value of a combination of the parameters.

        combination: weights of the parameters.
        """
        for (a, c, scale), best in zip(self._products, self._best, strict=True):
            weights = combination * scale[0] / scale[1:]
            at = value * weights / (weights @ weights)
            free = np.linalg.svd(weights[None, :])[2][1:].T
            # torque less the part of the held value, and regressors of the free parameters
            change = np.zeros((1 + weights.size, 1 + free.shape[1]))
            change[0, 0], change[1:, 0], change[1:, 1:] = 1.0, -at, free
            held = [np.einsum("ki,lkm,mj->lij", change, x, change, optimize=True) for x in (a, c)]
            if minimise(*held, self._shape, 0.0, [free.T @ (best.p - at)]).chi2 - self.least < self._excluded:
                return False
        return True


NAMES = {"K": "K", "B": "B", "D": "K_reflex", "E": "B_reflex"}
# an undetermined direction involves a parameter with this part of its largest effect on the torque
INVOLVED = 0.3
# rise of chi2 above its minimum within which 95 % of the delays lie
DELAY_CHI2 = 3.84


def driven_products(
    spectra: Spectra, columns: Annotated[np.ndarray, "(L, b, q)"]
) -> Annotated[np.ndarray, "(L, q, q)"]:
    """Cross products of the parts of some columns that the perturbations drive, without chance.

    columns: Transforms.
    Returns: per band (squared units of the columns).
    """
    _, b, m = spectra.perturbation.shape
    a, c = cross_products(spectra.perturbation, columns)
    return a - m / (b - m) * c


def slow_mode(spectra: Spectra, below_hz: float) -> np.ndarray:
    """Mode of the joints at low frequencies, as driven by the perturbations, shape (joints,).

    Principal direction of the driven angles below a frequency (Hz), or in the lowest band; its largest
    component is 1.
    """
    low = spectra.frequency_hz.mean(axis=1) <= below_hz
    low[0] = True
    power = driven_products(spectra, spectra.angle)[low].sum(axis=0)
    mode = np.linalg.eigh(power)[1][:, -1]
    return mode / mode[np.abs(mode).argmax()]


@one_thread()
def joint_quantities(
    fit: RowFit,
    spectra: Spectra,
    joint: int,
    names: Sequence[str],
    largest_share: float,
    mode_below_hz: float,
) -> dict[str, Quantity]:
    """All quantities of one joint's torque by name, for example K_ankle_hip (torque per angle of the hip).

    fit: parameters and what the record determines.
    joint: whose torque.
    mode_below_hz: below this frequency motion is slow.
    Returns: parameters, static stiffness per angle if there is a reflex, along the slow mode, delay.
    """
    s = 2j * np.pi * spectra.frequency_hz[:, :, None]
    drive = [driven_products(spectra, x) for x in (spectra.angle, s * spectra.angle, spectra.torque)]
    angle, rate, torque = (np.sqrt(np.clip(np.einsum("lii->i", x), 0.0, None)) for x in drive)
    driven = max(float(torque[joint]), 1e-12)
    amplitude = np.array([(angle if kind in "KD" else rate)[j] for kind, j in fit.terms]) / driven
    labels = [f"{NAMES[kind]}_{names[joint]}_{names[j]}" for kind, j in fit.terms]
    weak = bool((fit.directions.strength < fit.directions.limit).any())
    weakly = _open_delay(fit) or (weak and fit.delay_s is not None)
    judge = _Judge(fit, labels, amplitude, largest_share, Profile(fit, spectra, joint, weakly))
    quantities = {
        label: judge(label, NAMES[kind], np.eye(len(fit.terms))[k], amplitude[k])
        for k, (label, (kind, _)) in enumerate(zip(labels, fit.terms, strict=True))
    }
    for j, name in enumerate(names):
        if ("D", j) in fit.terms:
            static = np.array([float(kind in "KD" and i == j) for kind, i in fit.terms])
            label = f"K_static_{names[joint]}_{name}"
            quantities[label] = judge(label, "K", static, angle[j] / driven)
    mode = slow_mode(spectra, mode_below_hz)
    along = np.array([mode[j] if kind in "KD" else 0.0 for kind, j in fit.terms])
    mode_amplitude = np.sqrt(max(float(mode @ drive[0].sum(axis=0) @ mode), 0.0)) / (mode @ mode)
    label = f"K_mode_{names[joint]}"
    quantities[label] = judge(label, "K", along, mode_amplitude / driven)
    if fit.delay_s is not None:
        reflex = any(
            one.identified
            for one, (kind, _) in zip(quantities.values(), fit.terms, strict=False)
            if kind in "DE"
        )
        label = f"delay_{names[joint]}"
        quantities[label] = _delay(fit, label, reflex)
    return quantities


@dataclass(frozen=True)
class _Judge:
    """Quotes or refuses a combination of the parameters."""

    fit: RowFit
    labels: list[str]
    amplitude: np.ndarray
    largest_share: float
    profile: Profile

    def __call__(self, name: str, kind: str, combination: np.ndarray, amplitude: float) -> Quantity:
        fit, unit = self.fit, symbol_of(kind)
        padded = np.zeros(fit.directions.strength.size)
        padded[: combination.size] = combination
        u = fit.directions.standard_error(padded)
        if not np.isfinite(amplitude) or u * amplitude > self.largest_share:
            return Quantity.refused(unit, self._refusal(name, padded, combination, u * amplitude))
        far = 2.0 * self.largest_share / max(amplitude, 1e-12)
        reason = f"{name} is not identified: values far from the best explain the record as well"
        value, half = float(combination @ fit.parameters), u * _quantile(fit.freedom)
        if not all(self.profile.excludes(combination, value + step) for step in (-far, far)):
            return Quantity.refused(unit, reason)
        return Quantity(value, unit, u, value - half, value + half)

    def _refusal(self, name: str, padded: np.ndarray, combination: np.ndarray, share: float) -> str:
        partners = self.fit.directions.weak_partners(padded)[: len(self.labels)] * self.amplitude
        involved = [
            label
            for label, effect, weight in zip(self.labels, partners, combination, strict=True)
            if 0.0 < effect >= INVOLVED * partners.max() and not weight
        ]
        if involved:
            return (
                f"{name} is not identified: the perturbation does not separate it from {', '.join(involved)}"
            )
        if share > 1e3:
            return f"{name} is not identified: the perturbation drives no torque of this joint"
        return (
            f"{name} is not identified: its standard error amounts to {100.0 * share:.2g} % of the torque "
            f"that the perturbation drives, more than {100.0 * self.largest_share:g} %"
        )


def _delay(fit: RowFit, name: str, reflex: bool) -> Quantity:
    """Delay of the reflex (s), if the reflex is identified and its delay is inside the range tried."""
    inside = np.flatnonzero(fit.delay_chi2 <= fit.delay_chi2.min() + DELAY_CHI2)
    if _open_delay(fit):
        ends = f"{fit.delays_s[inside[0]]:g} to {fit.delays_s[inside[-1]]:g} s"
        return Quantity.refused(
            "s", f"{name} is not identified: the record does not exclude {ends}, at an end of those tried"
        )
    if not reflex:
        return Quantity.refused(
            "s", f"{name} is not identified: neither is any stiffness or damping of the reflex"
        )
    u = fit.directions.standard_error(np.eye(fit.directions.strength.size)[-1])
    half = u * _quantile(fit.freedom)
    return Quantity(fit.delay_s, "s", u, fit.delay_s - half, fit.delay_s + half)


def _open_delay(fit: RowFit) -> bool:
    """Test for delays, not excluded by the record, that reach an end of the range tried."""
    if fit.delay_s is None:
        return False
    inside = fit.delay_chi2 <= fit.delay_chi2.min() + DELAY_CHI2
    return bool(inside[0] or inside[-1])


def _quantile(freedom: int) -> float:
    return float(scipy.special.stdtrit(max(freedom, 1), 0.975))
