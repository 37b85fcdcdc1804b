"""Figures of a planned experiment."""

import numpy as np
from matplotlib.figure import Figure

from tepsipe.experiments.planning.plan import COVERAGE, Plan
from tepsipe.experiments.planning.pulses import STEP_S
from tepsipe.reporting.figures.style import COLOURS, CYCLE, in_style, new_figure


@in_style
def plot_plan(plans: dict[str, Plan]) -> Figure:
    """Half width of the 95 % interval of K (%) over the number of perturbations, and the belt's pulses (m/s).

    ``plans`` are the plans by name; dashed lines are Type A alone.
    """
    figure, (left, right) = new_figure(1, 2, 3.0)
    numbers = np.unique(np.geomspace(1, 1000, 120).round().astype(int))
    for colour, (name, plan) in zip(CYCLE * (1 + len(plans)), plans.items(), strict=False):
        scale = 100.0 * COVERAGE / plan.design.parameters[2]
        widths = [scale * plan.with_number(int(n))[2] for n in numbers]
        left.loglog(numbers, widths, color=colour, label=name)
        of_noise = [scale * plan.type_a_with(int(n))[2] for n in numbers]
        left.loglog(numbers, of_noise, color=colour, linewidth=0.7, linestyle="--")
        elapsed = 1e3 * STEP_S * np.arange(plan.motion.pulse_velocity.size)
        right.plot(elapsed, plan.motion.pulse_velocity, color=colour)
    left.axhline(10.0, color=COLOURS["other"], linewidth=0.7)
    left.set(xlabel="perturbations", ylabel="half width of the 95 % interval of K (%)")
    right.set(xlabel="time from the onset (ms)", ylabel="velocity of the belt (m/s)", xlim=(0.0, 250.0))
    figure.legend(loc="outside upper center", ncols=3)
    return figure
