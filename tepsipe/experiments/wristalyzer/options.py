"""Options of the spectral fit of a joint (thesis section 3-1-1)."""

from dataclasses import astuple, dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np
from annotated_types import Ge, Le

from tepsipe.quantities import Band, Bins, Different, FilterOrder, Frequency, Pause, Some, Thesis, Time

if TYPE_CHECKING:
    from tepsipe.identification.admittance_fit import Bounds


Bound = Annotated[float, Ge(-1000), Le(1000)]


@dataclass(frozen=True)
class Impedance:
    """Starting values of a search, or its bounds, which may be negative."""

    I_Nms2_per_rad: Annotated[Bound, Thesis("Table 3-2")]
    """Inertia of the joint."""
    B_Nms_per_rad: Annotated[Bound, Thesis("Table 3-2")]
    """Its damping."""
    K_Nm_per_rad: Annotated[Bound, Thesis("Table 3-2")]
    """Its stiffness."""


@dataclass(frozen=True, kw_only=True)
class WristalyzerOptions:
    """Spectral fit of the joint."""

    lowpass_cutoff_hz: Annotated[Frequency, Thesis("3-1-1")]
    """Butterworth low-pass of torque and angle."""
    lowpass_order: Annotated[FilterOrder, Thesis("3-1-1")]
    """Order of both passes together."""
    cut_s: Annotated[Pause, Thesis("3-1-1")]
    """Time cut at both ends."""
    averaged_bins: Annotated[Bins, Thesis("3-1-1, no number")]
    """Raw frequencies averaged into one."""
    swept_bins: Different[Annotated[int, Ge(1)]] = ()
    """Other numbers of averaged frequencies that are tried."""
    fit_band_hz: Annotated[Band, Thesis("3-1-1")]
    """Fitted frequencies."""
    coherence_outside_root: Annotated[bool, Thesis("3-1-1")] = False
    """True: the coherence of criterion (3-6) stands outside the root, as in the text above the equation.
    False: inside, as in the equation."""
    perturbation_period_s: Time | None
    """Period of the multisine, a whole number of samples; null if the perturbation is not periodic."""
    excited_band_hz: Annotated[Band, Thesis("2-1-1")]
    """Frequencies of the perturbation."""
    start: Impedance
    lower: Impedance
    upper: Impedance
    random_starts: Annotated[int, Ge(0)]
    """Further starting values, and further pairs of bounds, drawn at random."""
    tried_stiffness_Nm_per_rad: Some[Bound]
    """Further starting values of K, within the bounds."""
    profile_stiffness_Nm_per_rad: Band
    """Range of K in its profile likelihood."""
    profile_points: Annotated[int, Ge(5)]
    """Number of values of K in that range."""

    @property
    def bounds(self) -> "Bounds":
        """Starting values and bounds of I, B, K."""
        from tepsipe.identification.admittance_fit import Bounds  # a study that is only read has no fit

        return Bounds(*(np.array(astuple(joint)) for joint in (self.start, self.lower, self.upper)))
