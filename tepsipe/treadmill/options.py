"""Options of the treadmill models, and the weight that calibrates them."""

from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Le

from tepsipe.quantities import Gravity, Length, Mass, Offset, Thesis, Time

# frames that are fitted to force and moment together, with draws of their errors, and the name of that which
# predicts trials best that it has not seen
FRAMES = ("bristle-frame", "linear-frame")
BEST = "best-frame"


@dataclass(frozen=True)
class RippleOptions:
    """Options of the detection and tracking of ripple."""

    most_orders: Annotated[int, Ge(0)] = 12
    """Largest number of tracked lines."""
    line_to_floor: Annotated[float, Gt(1)] = 30.0
    """Power of a line over the running median of the spectrum around it."""
    # a shorter memory follows faster, but mistakes more of the signal near the ripple for ripple
    memory_s: Time = 20.0  # T
    """Memory of the tracked amplitudes."""


@dataclass(frozen=True)
class ModelOptions:
    """Choices of the fits."""

    shortest_s: Time = 15.0
    """Shortest total time of the evaluated samples of all recordings to which a model is fitted or on which
    it is evaluated."""
    hnat2014_evaluations: Annotated[int, Ge(1)] = 100
    """Number of evaluations after which the optimisation of `hnat2014` ends."""
    output_error_order: Annotated[int, Ge(1), Le(12)] = 3
    """Poles of `output-error`."""
    fir_lead_s: Annotated[float, Ge(0), Le(60)] = 0.1
    """Lead of `fir`; `fir-causal` has none."""
    fir_lag_s: Annotated[float, Gt(0), Le(60)] = 0.4
    """Memory of `fir` and `fir-causal`."""
    spectral_segment_s: Time = 2.56
    """Length of the segments of `spectral`, half of which is a lead, and, for tables, of the coherence
    limit."""
    ripple: RippleOptions | None = field(default_factory=RippleOptions)
    # None where it is not tracked: only a belt that travels has ripple


@dataclass(frozen=True, kw_only=True)
class Weight:
    """The weight on the belt."""

    mass_kg: Annotated[Mass, Thesis("2-1-2")]
    """Mass of the weight, as weighed."""
    com_height_m: Length  # h
    """Height of its centre of mass above the belt."""
    com_forward_of_markers_m: Offset | None = None
    """Distance along the belt from the mean of its markers forward to its centre of mass; null if unknown:
    then the weight does not show the origin of the plate."""
    gravity_m_per_s2: Gravity  # g
    """Gravity."""
