"""Friction with memory: bristles that bend before they slide (Dahl's model; LuGre without Stribeck effect).

A displacement x of the belt over deck and bearings first bends bristles, which slide once they are bent by d:

    z' = (x' - |x'| z) / d,    force = F z,    -1 <= z <= 1

The force depends on where the belt has been, not on how fast: small movements are elastic, large ones meet
full friction, and after a pulse a force stays behind. P. R. Dahl (1968), A solid friction model, Aerospace
Corporation TOR-0158(3107-18)-1; C. Canudas de Wit et al. (1995), IEEE Transactions on Automatic Control 40,
419-425.
"""

from array import array

import numpy as np


def bristle_deflection(displacement: np.ndarray, breakaway_m: float) -> np.ndarray:
    """Deflection z of the bristles, from z = 0.

    Parameters
    ----------
    displacement : ndarray, shape (n,)
        Path of the belt over its support (m), monotonic between samples.
    breakaway_m : float
        Displacement d that the bristles take (m).

    Returns
    -------
    ndarray, shape (n,)
        z (-), exact for the path that joins the samples by straight lines.
    """
    steps = np.diff(displacement)
    kept = np.exp(-np.abs(steps) / breakaway_m).tolist()
    z, found = 0.0, array("d", [0.0])
    for sign, part in zip(np.sign(steps).tolist(), kept, strict=True):
        z = sign + (z - sign) * part if sign else z
        found.append(z)
    return np.array(found)
