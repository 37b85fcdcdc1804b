"""Options of the analysis of a joint in a position-controlled manipulator."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge

from tepsipe.quantities import Bins, Draws, FilterOrder, Frequency, InnerFraction, Pause, Time


@dataclass(frozen=True)
class PositionManipulatorOptions:
    """Choices of the analysis."""

    lowpass_cutoff_hz: Frequency
    """Butterworth low-pass of angle and torque before the regression."""
    lowpass_order: FilterOrder
    """Order of both passes together."""
    cut_s: Pause
    """Time cut at both ends."""
    training_fraction: InnerFraction
    """First part of the trial, which is fitted; the rest is held out for validation."""
    averaged_bins: Bins
    """Raw frequencies averaged into one."""
    block_s: Time
    """Length of the bootstrapped blocks."""
    bootstrap_draws: Draws
    """Bootstrap samples."""


@dataclass(frozen=True)
class TimeVaryingOptions:
    """Choices of the analysis."""

    window_s: Time
    """Length of the sliding windows of trials with neither trigger nor schedule."""
    window_step_s: Time
    """Distance of the windows."""
    block_s: Time
    """Length of the blocks of residuals that are bootstrapped in windows, longer than the residuals are
    correlated."""
    realisation_s: Time | None
    """Length of a realisation after a trigger; null for the shortest time between triggers."""
    segment_s: Time
    """Length of the short segments of all realisations that are fitted together."""
    segment_step_s: Time
    """Distance of the segments."""
    bins: Annotated[int, Ge(2)]
    """Number of equal bins of a schedule."""
    piece_s: Time
    """Longest piece of the record within a bin that has a level and a trend of its own; pieces shorter than a
    quarter of it are left out."""
    bootstrap_draws: Draws
    """Bootstrap samples."""
