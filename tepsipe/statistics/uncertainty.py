"""Type A and Type B uncertainty, budgets and combined intervals (GUM: JCGM 100:2008).

Type A is the uncertainty from the scatter within a trial. Type B is all other uncertainty: masses, lengths,
calibrations, delays. Each source i of Type B has a standard uncertainty u(x_i); through the estimator
f it contributes u_i(y) = c_i u(x_i), c_i = df/dx_i, to the estimate y (JCGM 100, eq 10):

    u_c^2(y) = u_A^2 + sum_i u_i^2(y)

The interval is y +- t u_c with Student's quantile at the effective degrees of freedom of Welch and
Satterthwaite (JCGM 100, eq G.2b):

    nu_eff = u_c^4 / (u_A^4 / nu_A + sum_i u_i^4 / nu_i)

A contribution keeps its sign, so a source common to two estimates affects their difference only by the
difference of its contributions (JCGM 100, section 5.2). Two departures from the letter of the GUM: the
bootstrap of a calibration counts as Type B here, because it is evaluated once and does not vary within a
trial; and the same degrees of freedom hold for all components of one source, unless a source has its own.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
import scipy
from annotated_types import MinLen

from tepsipe.arguments import check_options
from tepsipe.errors import InputError, listed, quoted
from tepsipe.quantities import Distribution, NotNegative, Positive

CONFIDENCE = 0.95
# probability of a false alarm by all checks of a trial or a rig together
FALSE_ALARMS = 0.05
SCATTER = "scatter"  # the source of Type A


@dataclass(frozen=True)
class Source:
    """A constant assumed by the analysis, and its uncertainty."""

    name: str
    """For example ``leg_mass_kg``."""
    standard_uncertainty: NotNegative
    """Standard deviation of what is believed, in the unit of the source's name; relative for names without
    unit."""
    distribution: Distribution = "normal"
    """A rectangular distribution has a half width √3 times as large, a triangular one √6 times; for readers
    of the budget, because sources are propagated to first order, where only the standard uncertainty
    counts."""
    freedom: Positive = np.inf
    """Degrees of freedom, if the standard uncertainty is itself an estimate from few values."""
    source: Annotated[str, MinLen(1)] = ""
    """Why it is believed: a measurement, a data sheet, a publication."""


def sources_of(section: Mapping[str, Mapping | None]) -> dict[str, Source]:
    """Sources of one experiment from its settings.

    section: name -> standard_uncertainty (unit in the name), distribution, source (why it is believed) and,
    where u(x) is an estimate, freedom; None for a source that is switched off.
    Returns: those that are not switched off.
    """
    sources = {}
    for name, stated in section.items():
        if stated is None:
            continue
        check_options(Source, stated, f"uncertainty of {name}")
        sources[name] = Source(name, **stated)
    return sources


def stated_sources(uncertainty: object, known: Sequence[str], place: str) -> dict[str, Source]:
    """Sources of Type B that a user states.

    uncertainty: name -> standard uncertainty (unit in the name).
    known: names that the function knows.
    place: name of the function, for messages.
    Returns: empty if nothing is stated.
    """
    advice = f"give standard uncertainties by name, of {listed(known)}"
    if not isinstance(uncertainty, Mapping | None):
        raise InputError(f"{place}, uncertainty: expected a mapping, found {quoted(uncertainty)}: {advice}")
    sources = {}
    for name, stated in (uncertainty or {}).items():
        if name not in known:
            raise InputError(f"{place}, uncertainty: expected a known source, found {quoted(name)}: {advice}")
        u = stated.standard_uncertainty if isinstance(stated, Source) else stated
        number = isinstance(u, int | float | np.number) and not isinstance(u, bool)
        if not (number and math.isfinite(u) and u >= 0.0):
            raise InputError(
                f"{place}, uncertainty: expected a standard uncertainty of at least 0 for {name}, found "
                f"{quoted(u)}: give a number, such as half the width of a 68 % interval"
            )
        sources[name] = stated if isinstance(stated, Source) else Source(name, float(u))
    return sources


@dataclass(frozen=True)
class Budget:
    """Uncertainty of p estimates, source by source."""

    type_a: Annotated[np.ndarray, "(p,)"]
    """Standard uncertainties from the trial's own scatter (units of the estimates)."""
    freedom_a: float | np.ndarray
    """Their degrees of freedom, shape (p,)."""
    contributions: dict[str, np.ndarray] = field(default_factory=dict)
    """Source -> root R of its covariance, R'R (units of the estimates). One row, c_i u(x_i) with its sign,
    if it was propagated linearly; as many rows as draws if by a bootstrap, shape (k, p)."""
    freedom: dict[str, float | np.ndarray] = field(default_factory=dict)
    """Source -> degrees of freedom, of all components or shape (p,); infinite where none are given."""

    def of_source(self, name: str) -> np.ndarray:
        """Standard uncertainty contributed by a source, shape (p,) (units of the estimates)."""
        return np.sqrt((self.contributions[name] ** 2).sum(axis=0))

    @property
    def type_b(self) -> np.ndarray:
        """Standard uncertainty of Type B, shape (p,) (units of the estimates)."""
        squares = [self.of_source(name) ** 2 for name in self.contributions]
        return np.sqrt(np.sum([np.zeros_like(self.type_a), *squares], axis=0))

    @property
    def combined(self) -> np.ndarray:
        """Combined standard uncertainty u_c, shape (p,) (units of the estimates)."""
        return np.hypot(self.type_a, self.type_b)

    @property
    def effective_freedom(self) -> np.ndarray:
        """Effective degrees of freedom of Welch and Satterthwaite, shape (p,)."""
        quartic = self.type_a**4 / self.freedom_a
        for name in self.contributions:
            quartic = quartic + self.of_source(name) ** 4 / self.freedom.get(name, np.inf)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(quartic > 0.0, self.combined**4 / quartic, np.inf)

    def interval(
        self, values: Annotated[np.ndarray, "(p,)"], confidence: float = CONFIDENCE
    ) -> tuple[np.ndarray, np.ndarray]:
        """Ends of the interval values +- t u_c.

        values: the estimates.
        confidence: probability of the interval.
        Returns: units of ``values``; infinite where the combined uncertainty is.
        """
        half = coverage_factor(self.effective_freedom, confidence) * self.combined
        return values - half, values + half

    def minus(self, other: "Budget") -> "Budget":
        """Budget of the difference of two estimates (units of both).

        Type A of both is independent and adds in quadrature, with degrees of freedom by Welch and
        Satterthwaite for the first estimate. A source of the same name is the same quantity: its
        contributions are subtracted. A source in only one of the budgets is kept.
        """
        names = dict.fromkeys([*self.contributions, *other.contributions])
        difference = {}
        for name in names:
            mine, theirs = self.contributions.get(name), other.contributions.get(name)
            if mine is not None and theirs is not None and mine.shape != theirs.shape:
                raise ValueError(f"{name}: expected shared draws, found {len(mine)} and {len(theirs)}")
            difference[name] = (0.0 if mine is None else mine) - (0.0 if theirs is None else theirs)
        squares = np.array([self.type_a**2, other.type_a**2])
        with np.errstate(divide="ignore", invalid="ignore"):
            freedom = squares.sum(axis=0) ** 2 / (
                squares[0] ** 2 / self.freedom_a + squares[1] ** 2 / other.freedom_a
            )
        finite = freedom[np.isfinite(freedom)]
        return Budget(
            np.sqrt(squares.sum(axis=0)),
            float(finite.min()) if finite.size else np.inf,
            difference,
            {**other.freedom, **self.freedom},
        )


def coverage_factor(freedom: np.ndarray, confidence: float = CONFIDENCE) -> np.ndarray:
    """Student's quantile of a two-sided interval for degrees of freedom that may be infinite."""
    p = 0.5 * (1.0 + confidence)
    freedom = np.asarray(freedom, dtype=float)
    finite = np.where(np.isfinite(freedom), freedom, 1.0)
    return np.where(np.isfinite(freedom), scipy.special.stdtrit(finite, p), scipy.special.ndtri(p))


def scatter(values: Annotated[np.ndarray, "(n, p)"]) -> tuple[np.ndarray, float]:
    """Type A of a mean over n perturbations: SD / sqrt(n), and n - 1 degrees of freedom (JCGM 100, 4.2).

    values: estimates of n perturbations.
    Returns: standard uncertainty (units of ``values``) and degrees of freedom; infinite and 1 if n < 2.
    """
    n = len(values)
    if n < 2:
        return np.full(values.shape[1], np.inf), 1.0
    return values.std(axis=0, ddof=1) / np.sqrt(n), n - 1.0


def error_of_mean(signal: np.ndarray, terms: int = 8) -> tuple[float, float]:
    """Standard error of the mean of a stretch of correlated noise, and its degrees of freedom.

    The mean square of the products with the slowest cosines, which the spectrum at frequency zero determines
    (equal-weighted cosine estimator: Mueller 2007; Lazarus, Lewis, Stock & Watson 2018):

        u = sqrt(mean of c_j^2 / n),    c_j = sqrt(2 / n) sum_t cos(pi j (t - 1/2) / n) x_t,    j = 1 ... m

    signal: the samples, n above 1.
    Returns: standard error (unit of ``signal``) and m, or n - 1 if this is less.
    """
    n = signal.size
    terms = min(terms, n - 1)
    slow = scipy.fft.dct(signal - signal.mean(), type=2, norm="ortho")[1 : terms + 1]
    return float(np.sqrt(np.mean(slow**2) / n)), float(terms)


def in_quadrature(*parts: tuple[np.ndarray, float]) -> tuple[np.ndarray, np.ndarray]:
    """Sum of independent standard uncertainties with their degrees of freedom (Welch and Satterthwaite).

    Returns: standard uncertainties and effective degrees of freedom; those of the first part where all are
    zero.
    """
    u = np.sqrt(np.sum([np.square(u) for u, _ in parts], axis=0))
    with np.errstate(divide="ignore", invalid="ignore"):
        freedom = 1.0 / np.sum([(part / u) ** 4 / freedom for part, freedom in parts], axis=0)
    return u, np.where(np.isfinite(freedom), freedom, parts[0][1])


def linear_contributions(
    estimate: Callable[[Mapping[str, float]], np.ndarray], sources: Sequence[Source]
) -> dict[str, np.ndarray]:
    """Signed contributions by central differences over +-u(x_i) (JCGM 100, section 5.1.3, note 2).

    estimate: takes deviations of the sources by name, returns the estimates, shape (p,). Sources that are
    not named do not deviate.
    Returns: source -> c_i u(x_i) (units of the estimates), for `Budget.contributions`.
    """
    contributions = {}
    for source in sources:
        u = source.standard_uncertainty
        above, below = (np.asarray(estimate({source.name: sign * u})) for sign in (1.0, -1.0))
        contributions[source.name] = 0.5 * (above - below)[None]
    return contributions


def root_of_draws(draws: Annotated[np.ndarray, "(n, p)"]) -> Annotated[np.ndarray, "(n, p)"]:
    """Root of the covariance of draws, for `Budget.contributions`: deviations from their mean / sqrt(n - 1).

    draws: estimates for n draws of a source.
    """
    return (draws - draws.mean(axis=0)) / np.sqrt(len(draws) - 1.0)
