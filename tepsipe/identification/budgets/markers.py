"""Quantities of the joint likelihood, and their uncertainty due to displaced markers.

The other sources scale the equation of motion (`tepsipe.identification.budgets.leg`). These change the
channels of the likelihood. Each is propagated to first order: markers are displaced by one standard
uncertainty, and one step is taken from the maximum:

    marker_sampling_s                   y_j -> y_j + j dt y_j',  j the place of the marker in the sequence
    levelled_rad                        all markers turned by an angle after levelling
    leg_bending_rad_per_m_per_s2        y_j -> y_j + c l_j y'',  l_j its height on the leg, y'' of the foot

A rod that lags behind the acceleration of its foot by c y'' bends by its first mode; markers show the lag as
if the leg had turned by this angle.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from tepsipe.identification.budgets.leg import LegUncertainty, leg_budget, small_budget
from tepsipe.identification.estimators import Record
from tepsipe.identification.likelihood.channels import DummyMarkers, levelled, make_channels
from tepsipe.identification.likelihood.result import LikelihoodEstimates, first_order_changes
from tepsipe.identification.result import Quantity, quantities_of, symbol_of
from tepsipe.mechanics.impedance_model import PARAMETERS, SMALL
from tepsipe.statistics.uncertainty import CONFIDENCE, Budget, Source


def likelihood_quantities(
    fit: LikelihoodEstimates,
    record: Record,
    known: LegUncertainty,
    confidence: float = CONFIDENCE,
    factor: float = 1.96,
) -> tuple[dict[str, Quantity], Budget]:
    """I, B, K, those of small movements, delay of the angle after the foot, and softening if present.

    record: what they were estimated from.
    known: assumed leg, with its uncertainty.
    confidence: probability of the intervals of budgets.
    factor: half width of Wald's intervals, of delay and softening, in standard errors.

    Returns:
        quantities: by name.
        budget: uncertainty of I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad).
    """
    of_working, of_small = marker_contributions(fit, record, known.sources)
    budget = leg_budget(fit, None, known, of_working)
    small = small_budget(fit, known.leg, known.sources, of_small)
    quantities = quantities_of(dict(zip(PARAMETERS, fit.mean, strict=True)), budget, confidence)
    quantities |= quantities_of(dict(zip(SMALL, fit.small, strict=True)), small, confidence)
    softening = {"K_softened": "C", "B_softened": "B_s"} if fit.fit.softens else {}
    for name, of_law in {"delay": "delay", **softening}.items():
        value, error = fit.fit.value(of_law), fit.fit.standard_error(of_law)
        ends = (value - factor * error, value + factor * error)
        quantities[name] = Quantity(value, symbol_of(name), error, *ends, error)
    return quantities, budget


def marker_contributions(
    fit: LikelihoodEstimates, record: Record, sources: Mapping[str, Source]
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Contribution of displaced markers to I, B, K, at the working amplitude and of small movements.

    record: what they were estimated from.
    sources: uncertain constants; sources that the module's docstring does not list are ignored.
    Returns: for `Budget.contributions` (N·m·s²/rad, N·m·s/rad, N·m/rad).
    """
    time, markers = record.motion.time, levelled(record.markers, record.at_rest)
    moves: dict[str, Callable[[float], np.ndarray]] = {
        "levelled_rad": lambda u: _turned(markers.positions, u),
        "leg_bending_rad_per_m_per_s2": lambda u: _bent(markers, u, fit.fit.model.motion.y_dd),
    }
    if markers.places is not None:
        moves["marker_sampling_s"] = lambda u: _later(markers.positions, time, u * markers.places)
    working, small = {}, {}
    for name, displace in moves.items():
        if name not in sources:
            continue
        displaced = replace(markers, positions=displace(sources[name].standard_uncertainty))
        channels = make_channels(time, displaced, record.belt_log, record.at_rest, level=False)
        both = first_order_changes(fit, channels, record.perturbations)
        working[name], small[name] = (x[None] for x in both)
    return working, small


def _turned(positions: np.ndarray, angle: float) -> np.ndarray:
    """Positions (m), shape (n, k, 2), turned by an angle (rad)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return positions @ np.array([[cosine, -sine], [sine, cosine]])


def _bent(markers: DummyMarkers, lag: float, acceleration: np.ndarray) -> np.ndarray:
    """Positions (m), shape (n, k, 2), on a leg that lags by an angle (rad per m/s²) of the foot (m/s²)."""
    height = np.where(markers.on_leg, markers.layout_m[:, 1], 0.0)
    positions = markers.positions.copy()
    positions[..., 0] += lag * np.outer(acceleration, height)
    return positions


def _later(positions: np.ndarray, time: np.ndarray, lags: np.ndarray) -> np.ndarray:
    """Positions (m), shape (n, k, 2), at instants (s) delayed by the lags of the markers (s)."""
    return positions + lags[:, None] * np.gradient(positions, time, axis=0)
