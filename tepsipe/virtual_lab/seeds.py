"""One random generator per trial and purpose."""

import zlib

import numpy as np


def generator(seed: int, *names: str) -> np.random.Generator:
    """Random generator that depends on the study's seed and the names only.

    Trials made in any order, on any number of cores, alone or together, draw the same numbers.

    seed: seed of the laboratory.
    *names: purpose of the generator, for example ``"dummy", "sine-0.1", "markers"``.
    Returns: A PCG64 generator of its own (dimensionless draws).
    """
    return np.random.default_rng([seed, zlib.crc32("/".join(names).encode())])
