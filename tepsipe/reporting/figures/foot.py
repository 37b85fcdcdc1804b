"""Figure of the ankle dummy's parameters from the foot's side, beside those from the leg's."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from tepsipe.io.result import Result, read_result
from tepsipe.reporting.figures.dummy import true_parameters
from tepsipe.reporting.figures.pathways import plot_pathways

# of the recommended pathway of the leg, then of those of the foot; further ones have the last
COLOURS = ("recommended", "as printed", "other", "other too", "compensated too", "compensated", "command")


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figure of the fits from the ``leg`` and from the ``foot`` of every trial."""
    results = {}
    for name, leg, foot in zip(chosen.conditions, files.leg, files.foot, strict=True):
        of_leg, of_foot = read_result(leg), read_result(foot)
        results[name] = Result({**of_leg.arrays, **of_foot.arrays}, {}, of_foot.facts)
    pathways = [chosen.recommended, *of_foot.facts["pathways"]]
    colours = dict.fromkeys(pathways, COLOURS[-1]) | dict(zip(pathways, COLOURS, strict=False))
    truth = true_parameters(files.recovery, chosen.conditions, chosen.recommended)
    usable = [p for p in pathways if p == chosen.recommended or p in chosen.usable]
    yield "figure_foot", plot_pathways(results, colours, truth, usable)
