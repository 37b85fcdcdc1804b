"""Figure of an uncertainty budget, source by source."""

from collections.abc import Iterator
from textwrap import fill

import numpy as np
from matplotlib.figure import Figure

from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES, SCATTER
from tepsipe.reporting.budgets import SHOWN as QUANTITIES
from tepsipe.reporting.budgets import RelativeBudget, budgeted, relative_budgets, source_words
from tepsipe.reporting.figures.style import COLOURS, in_style, new_figure

# sources below this part of the largest (-) are drawn together
SMALL = 0.2
# an axis ends at this multiple of the typical combined uncertainty (-); a triangle marks what lies beyond
SHOWN = 3.5
TYPE_COLOURS = {"A": COLOURS["recommended"], "B": "#e69f00", "combined": "#4b4b4b"}


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Uncertainty budget of each of the ``names``: experiments, and the dummy's foot."""
    contributions = CONTRIBUTIONS.read(files.uncertainty)
    own = budgeted(ESTIMATES.read(files.estimates), chosen.foot_pathway)
    for name in chosen.names:
        budgets = relative_budgets(contributions, own.get(name, []), QUANTITIES)
        yield f"figure_budget_{name}", plot_budgets(budgets)


def bars_of(budget: RelativeBudget) -> list[tuple[str, str, np.ndarray]]:
    """Label, type and percentages of every trial (%) of the bars: combined, Type A, then Type B by size.

    Small sources of Type B are one bar.
    """
    largest = max(float(np.nanmedian(x)) for x in budget.percent.values())
    bars = [("combined", "combined", budget.combined)]
    if SCATTER in budget.percent:
        bars.append((source_words(SCATTER), "A", budget.type_a))
    of_type_b = [name for name in budget.by_size if name != SCATTER]
    large = [name for name in of_type_b if float(np.nanmedian(budget.percent[name])) >= SMALL * largest]
    small = [name for name in of_type_b if name not in large]
    if len(small) == 1:
        large, small = [*large, *small], []
    bars += [(source_words(name), "B", budget.percent[name]) for name in large]
    if small:
        squares = [np.nan_to_num(budget.percent[name]) ** 2 for name in small]
        bars.append((f"{len(small)} further sources", "B", np.sqrt(np.sum(squares, axis=0))))
    return bars


@in_style
def plot_budgets(budgets: dict[str, RelativeBudget]) -> Figure:
    """Standard uncertainty of every source, median over trials and range (% of the estimate).

    Without any budget, because nothing is recommended, the figure says so.
    """
    if not budgets:
        figure, axes = new_figure(1, 1, 0.9)
        axes.set_axis_off()
        axes.text(0.5, 0.5, "No estimate is recommended: no budget.", ha="center", va="center")
        return figure
    drawn = {quantity: bars_of(budget) for quantity, budget in budgets.items()}
    most = max(len(bars) for bars in drawn.values())
    figure, axes = new_figure(1, len(drawn), 0.9 + 0.25 * most, squeeze=False)
    for axis, (quantity, bars) in zip(axes[0], drawn.items(), strict=True):
        most_shown = SHOWN * float(np.nanmedian(bars[0][2]))
        for place, (_, kind, percent) in enumerate(bars):
            low, middle, high = (f(percent) for f in (np.nanmin, np.nanmedian, np.nanmax))
            axis.barh(place, middle, 0.62, color=TYPE_COLOURS[kind])
            axis.plot([low, min(high, most_shown)], [place, place], color="#1b1b1b", linewidth=0.9)
            if high > most_shown:
                axis.plot(most_shown, place, ">", color="#1b1b1b", markersize=4.0, clip_on=False)
        axis.set_yticks(range(len(bars)), [fill(label, 24) for label, _, _ in bars], linespacing=0.9)
        axis.invert_yaxis()
        name = f"${quantity}$" if len(quantity) == 1 else quantity
        axis.set_xlabel(f"Uncertainty of {name} (%)", loc="right")
        axis.grid(axis="y", visible=False)
        axis.set_axisbelow(True)
        axis.set_xlim(0.0, min(most_shown, 1.05 * max(float(np.nanmax(x)) for _, _, x in bars)))
    kinds = {"A": "Type A: shrinks with more perturbations", "B": "Type B: does not"}
    handles = [axes[0, 0].barh([0], [0], color=TYPE_COLOURS[k], label=label) for k, label in kinds.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure
