"""The interval of the stiffness holds that of the spring."""

import numpy as np

from tepsipe.experiments.toy.fit import fit
from tepsipe.io.trial import Signal, Trial


def test_interval_holds_the_stiffness(rng):
    time = np.arange(2000) / 100.0
    angle = 0.1 * np.sin(time)
    torque = 10.0 * angle + rng.normal(0.0, 0.01, time.size)
    signals = {"angle": Signal(angle, "rad"), "torque": Signal(torque, "Nm")}
    (row,) = fit(Trial(100.0, {"time": time}, signals, {}), {"analysis": {"cut_s": 1.0}}, "a").estimates
    assert row.ci_low < 10.0 < row.ci_high
