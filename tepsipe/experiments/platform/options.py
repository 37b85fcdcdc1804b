"""Options of the analysis of a person on a moving platform."""

from dataclasses import dataclass
from typing import Annotated, Literal

from tepsipe.identification.several_joints.closed_loop import MODELS, MultiJointOptions
from tepsipe.quantities import Different, Fraction, Frequency, InnerFraction, Meanings, Positive


@dataclass(frozen=True, kw_only=True)
class PlatformOptions(MultiJointOptions):
    """Choices of the analysis."""

    models: Different[Annotated[Literal[tuple(MODELS)], Meanings(MODELS)]]
    """Models from the least free to the most."""
    largest_share: Positive
    """Largest standard error of a quoted quantity, times the angle that the platform drives, over the torque
    that it drives."""
    mode_below_hz: Frequency
    """Below this frequency motion is slow; its direction is that of `K_mode`."""
    rejected_below: Fraction
    """A model is rejected if the torque that it leaves is coherent with the platform with a smaller
    probability."""
    training_fraction: InnerFraction
    """First part of the trial, fitted for the held-out validation; estimates are of the whole trial."""
