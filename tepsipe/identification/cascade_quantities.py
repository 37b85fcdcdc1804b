"""Quantities of a parallel-cascade fit with intervals, for `tepsipe.fit_parallel_cascade`."""

import numpy as np

from tepsipe.identification.cascade_fit import ParallelCascadeFit
from tepsipe.identification.result import PARAMETERS, UNITS, Quantity


def cascade_quantities(
    found: ParallelCascadeFit, confidence: float
) -> tuple[dict[str, Quantity], tuple[str, ...]]:
    """Quantities with intervals, and what to know about them.

    Parameters
    ----------
    found : ParallelCascadeFit
        The fit (units there).
    confidence : float
        Probability of the intervals (-).

    Returns
    -------
    dict of str to Quantity
        I, B, K and further quantities of the terms that were selected (units in them).
    tuple of str
        Sentences on assumed values and the slow torque.
    """

    def drawn(value: float, unit: str, draws: np.ndarray) -> Quantity:
        return Quantity.drawn(value, unit, draws, confidence, found.blocks)

    short, structure = found.short_range, found.structure
    quantities = {
        name: drawn(found.impedance[k], UNITS[name], found.impedance_bootstrap[:, k])
        for k, name in enumerate(PARAMETERS)
    }
    quantities["K working"] = drawn(found.working_stiffness, "N·m/rad", found.working_stiffness_bootstrap)
    quantities["K short range"] = drawn(short.stiffness, "N·m/rad", short.stiffness_bootstrap)
    yields = short.yield_angle_bootstrap[np.isfinite(short.yield_angle_bootstrap)]
    if np.isfinite(short.yield_angle_rad) and yields.size > 1:
        quantities["yield angle"] = drawn(short.yield_angle_rad, "rad", yields)
    relaxing = found.relaxing
    times = relaxing.time_bootstrap[np.isfinite(relaxing.time_bootstrap)]
    if np.isfinite(relaxing.time_s) and times.size > 1:
        quantities["K relaxing"] = drawn(relaxing.stiffness, "N·m/rad", relaxing.stiffness_bootstrap)
        quantities["relaxation time"] = drawn(relaxing.time_s, "s", times)
    if structure.stiffening:
        quantities["dK/dtheta"] = drawn(found.stiffening, "N·m/rad²", found.stiffening_bootstrap)
    slow = (
        f"With the slow torque, predicted {found.slow.horizon_s:g} s ahead from past residuals, the held-out "
        f"VAF is {found.slow.vaf.held_out:.1f} %."
    )
    if not structure.direction:
        return quantities, ("Cross-validation found no reflex.", slow)
    quantities["reflex gain"] = drawn(found.gain, "N·m·s/rad", found.gain_bootstrap)
    if structure.gain_slope:
        quantities["dG/dtheta"] = drawn(found.gain_slope, "N·m·s/rad²", found.gain_slope_bootstrap)
    if structure.unloading:
        quantities["unloading gain"] = drawn(
            found.unloading_gain, "N·m·s/rad", found.unloading_gain_bootstrap
        )
    quantities["reflex delay"] = Quantity(structure.delay_s, "s")
    quantities["reflex threshold"] = Quantity(structure.threshold_rad_per_s, "rad/s")
    assumed = tuple(
        f"The {choice.quantity.replace('_', ' ')} of {choice.value:g} {choice.unit} is assumed: the record "
        f"does not separate {choice.low:g} to {choice.high:g} {choice.unit}, with cross-validated VAFs of "
        f"{choice.vaf_low:.1f} to {choice.vaf_high:.1f} %."
        for choice in found.assumptions
        if not choice.determined
    )
    return quantities, (*assumed, slow)
