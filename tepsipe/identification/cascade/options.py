"""Options of the parallel-cascade model."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Le

from tepsipe.quantities import DIFFERENT, Delay, Different, Latency, NotNegative, Pair, Positive, Some, Time


@dataclass(frozen=True)
class ParallelCascadeOptions:
    """Options of the fit."""

    intrinsic_lag_s: Latency = 0.04
    """Longest lag, and lead, of the intrinsic response."""
    stop_radii_rad: Annotated[Sequence[Annotated[float, Gt(0), Le(3.2)]], DIFFERENT] = (
        0.002,
        0.004,
        0.008,
        0.016,
    )
    """Radii of the stop elements (short-range stiffness), of which those within the recorded movement are
    used; `[]` for none."""
    relaxation_times_s: Annotated[Sequence[Time], DIFFERENT] = (0.05, 0.2)
    """Time constants of elements whose torque relaxes; `[]` for none."""
    reflex_poles_per_s: Annotated[Sequence[Positive], DIFFERENT, "rad/s"] = (16.0, 25.0, 40.0)
    """Poles of the Laguerre functions of the reflex response that are tried; `[]` for knots only."""
    reflex_order: Annotated[int, Ge(1), Le(10)] = 5
    """Their number."""
    reflex_length_s: Time = 0.6
    """Length of a reflex response of knots, after its delay; shortest block of the cross-validation."""
    reflex_knot_s: Time = 0.025
    """Distance of its knots, at most half its length."""
    reflex_thresholds_rad_per_s: Different[NotNegative] = (*(0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8),)
    """Velocity thresholds of the reflex that are tried."""
    reflex_delays_s: Pair[Latency] = (0.03, 0.06)
    """Shortest and longest delay that is tried."""
    profiled_delays_s: Pair[Delay] = (0.0, 0.1)
    """Shortest and longest delay whose cross-validated error is reported, to show what the trial does not
    separate."""
    expected_delay_s: Latency = 0.04
    """Preferred delay among those that the trial does not separate, within `reflex_delays_s`."""
    delay_tolerance: NotNegative = 0.01
    """Relative difference of the cross-validated error from which delays are separated."""
    penalties: Some[Positive] = (1e-6, 1e-4, 1e-2, 1.0)
    """Values of λ that are tried, see `tepsipe/identification/cascade/parallel_cascade.py`."""
    term_tolerance: NotNegative = 0.01
    """Relative difference of the cross-validated error below which a model with fewer terms is taken; every
    record chooses it itself for the terms of the reflex."""
    folds: Annotated[int, Ge(2)] = 10
    """Number of blocks of the fitted part for the cross-validation; fewer if they would be shorter than
    `reflex_length_s` plus the longest delay."""
    slow_horizons_s: Different[Time] = (0.25, 0.1, 0.5, 1.0, 2.0)
    """Times by which the slow torque is predicted ahead; the first one is that of
    `VAF_held_out_with_slow_torque`."""
