"""Figures of the dummy: every pathway stands beside its own true value."""

import numpy as np
import pytest
from matplotlib.collections import LineCollection

from tepsipe.experiments.dummy.figures import plot_pathways
from tepsipe.io.result import Result


def trues(axis):
    """True values of an axis with the abscissae of their middles."""
    lines = [c for c in axis.collections if isinstance(c, LineCollection) and len(c.get_segments()[0]) == 2]
    segments = [s for c in lines for s in c.get_segments() if np.ptp(s[:, 1]) == 0.0]
    return {round(float(s[:, 0].mean()), 6): float(s[0, 1]) for s in segments}


def test_every_pathway_has_its_own_truth():
    """Output error finds 10.2 for small movements where the windows have 8.4; the foot does not feel I."""
    found = {"leg": (0.007, 0.09, 8.5), "small": (0.007, 0.065, 10.3), "foot": (0.0005, 0.08, 8.0)}
    truth = {"leg": (0.0072, 0.087, 8.4), "small": (0.007, 0.065, 10.2), "foot": (0.0002, 0.087, 9.4)}
    arrays = {
        f"{name}/mean_and_interval": np.array([own, 0.9 * np.array(own), 1.1 * np.array(own)])
        for name, own in found.items()
    }
    results = {"sine-0.1": Result(arrays, {}, {})}
    of_pathways = {
        name: dict(zip("IBK", ([value] for value in own), strict=True)) for name, own in truth.items()
    }
    of_pathways = {n: {q: np.array(v) for q, v in own.items()} for n, own in of_pathways.items()}
    figure = plot_pathways(results, dict.fromkeys(found, "other"), of_pathways)
    for k, axis in enumerate(figure.axes):
        shown = trues(axis)
        places = sorted(shown)
        assert [shown[x] for x in places] == pytest.approx([own[k] for own in truth.values()])
        points = [
            float(line.get_xdata()[0])
            for line in axis.lines
            if line.get_marker() == "o" and line.get_xdata().size
        ]
        assert sorted(points) == pytest.approx(places, abs=1e-6)
    without = plot_pathways(results, dict.fromkeys(found, "other"), {name: {} for name in found})
    assert trues(without.axes[0]) == {}
