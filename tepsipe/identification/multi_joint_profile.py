"""Whether another value of a quantity explains a record as well, however weakly it is identified.

Standard errors trust the model near its estimate, at its delay. Where directions of the parameters are hardly
determined, other values may fit as well far away, with another delay. A quantity c'p is therefore held at a
value v, and the criterion chi2 of `tepsipe.identification.multi_joint` is minimised over all other parameters
and over the delays. Its rise over the least chi2 has a chi-squared distribution with one degree of freedom if
v is true and the delay is identified: below 3.84 the record does not exclude v. If the delay is not, or
directions beside it, the rise can be larger, but chi2 itself has at most its own distribution (Anderson and
Rubin 1949): v is excluded only if the model with v is rejected.
"""

import numpy as np
import scipy

from tepsipe.identification.multi_joint import RowFit, Spectra, minimise, scaled_products

# rise of chi2 that excludes a value at 95 % (-)
EXCLUDED = 3.84


class Profile:
    """Least chi2 (-) of one joint's torque with a quantity held at a value (its unit)."""

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
        # without what keeps parameters small along weak directions: a strength that none falls below
        self._best = [
            minimise(a, c, self._shape, 0.0, [start])
            for (a, c, _), start in zip(self._products, scale, strict=True)
        ]
        self.least = min([fit.chi2, *(one.chi2 for one in self._best)])
        if weakly:
            self._excluded = float(scipy.special.chdtri(fit.freedom + 1, 0.05)) - self.least

    def excludes(self, combination: np.ndarray, value: float) -> bool:
        """Whether the record excludes a value of a combination of the parameters (its unit).

        Parameters
        ----------
        combination : ndarray, shape (q,)
            Weights of the parameters (unitless).
        value : float
            The value (unit of the combination).
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
