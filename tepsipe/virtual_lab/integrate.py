"""Integration of the rigs' equations of motion.

Plain floats and tuples: for a handful of states this is several times faster than arrays,
and every run gives the same bits.

Steps are of one length. Only while the input rests, and once all fast motion has decayed, one step takes the
place of `LONG`; the states between its ends x_0 and x_1 lie on the cubic p that has their values and slopes
f_0 and f_1. Such a step of length H counts if p fulfils the equations in its middle:

    |p' - f(p)| < `DEFECT` in every state,    p = (x_0 + x_1) / 2 + H (f_0 - f_1) / 8
                                              p' = 3 (x_1 - x_0) / (2 H) - (f_0 + f_1) / 4

In a trial of the dummy this changes no state by more than a twentieth of what halving all steps changes (on
rigid ground a hundredth), and the motion of the frame by less than a quarter.
"""

import math
from array import array
from collections.abc import Callable
from functools import cache
from typing import Annotated, Any

import numpy as np

State = tuple[float, ...]
Derivative = Callable[[Any, State], State]

LONG = 8
DEFECT = 3e-5  # in units of SI


def integrate(
    derivative: Derivative,
    initial: State,
    inputs: Annotated[np.ndarray, "(n, 3)"],
    rate_hz: float,
    begin_step: Callable[[int, State], None] = lambda k, state: None,
) -> tuple[np.ndarray, np.ndarray]:
    """Integrate with the classical fourth-order Runge-Kutta rule.

    derivative: ``derivative(u, state)`` returns the time derivative of every state (unit of the state per
    s) under the input u.
    initial: state at t = 0.
    inputs: input at start, middle and end of every step.
    rate_hz: steps per second.
    begin_step: called with number and state at the start of a step; not while the input rests.

    Returns:
        time: grid 0, 1/rate, 2/rate, ... (s), up to the end of the last step.
        states: one row per grid point (units of the states). Shape (n + 1, len(initial)).
    """
    h, rests = 1.0 / rate_hz, _rests(inputs).tolist()
    begin, middle, end = inputs.T.tolist()
    x = tuple(float(value) for value in initial)
    step, steps = stepper(len(x)), len(inputs)
    # grid points and their states, and what the long steps begin and end with
    grid, states, ends = array("q", [0]), array("d", x), array("d")
    k = retry = 0
    known = None  # input and slope at the end of a long step, which are those of the next one's start
    while k < steps:
        rest, u = k >= retry and rests[k], begin[k]
        if not rest:
            begin_step(k, x)
        slope = known[1] if rest and known and known[0] == u else derivative(u, x)
        taken, after, known = 1, x, None
        if rest:
            after = step(derivative, slope, u, u, x, LONG * h)
            last_slope = derivative(u, after)
            if _defect(derivative, u, x, after, slope, last_slope, LONG * h) < DEFECT:
                taken, known = LONG, (u, last_slope)
                ends.extend(x + after + slope + last_slope)
            else:
                retry = k + LONG
        x = after if taken > 1 else step(derivative, slope, middle[k], end[k], x, h)
        k += taken
        grid.append(k)
        states.extend(x)
    if not all(map(math.isfinite, x)):
        raise FloatingPointError("the integration of the rig diverged: check the rig's constants")
    nodes = np.reshape(states, (-1, len(x)))
    return np.arange(steps + 1) * h, _filled(grid, nodes, np.reshape(ends, (-1, 4, len(x))), LONG * h)


def _rests(inputs: Annotated[np.ndarray, "(n, 3)"]) -> Annotated[np.ndarray, "(n,)"]:
    """Whether the input does not change in the `LONG` steps that begin with a step."""
    changes = np.cumsum(np.diff(inputs.ravel(), prepend=0.0) != 0.0)
    rests, free = np.zeros(len(inputs), dtype=bool), max(len(inputs) + 1 - LONG, 0)
    rests[:free] = changes[::3][:free] == changes[3 * LONG - 1 :: 3]
    return rests


def _defect(f: Derivative, u, x: State, after: State, slope: State, last_slope: State, h: float) -> float:
    """Largest defect in the middle of a step of length ``h`` (s) under the input ``u``, see above."""
    ends = list(zip(x, after, slope, last_slope, strict=True))
    middle = tuple([0.5 * (x0 + x1) + 0.125 * h * (f0 - f1) for x0, x1, f0, f1 in ends])
    given = zip(ends, f(u, middle), strict=True)
    return max([abs(1.5 * (x1 - x0) / h - 0.25 * (f0 + f1) - rate) for (x0, x1, f0, f1), rate in given])


def _filled(grid: array, states: np.ndarray, ends: np.ndarray, h: float) -> np.ndarray:
    """States at all grid points: those within steps of length ``h`` (s) lie on cubics."""
    filled = np.empty((grid[-1] + 1, states.shape[1]))
    filled[grid] = states
    start = np.array(grid[:-1])[np.diff(grid) > 1]
    x0, x1, f0, f1 = ends.swapaxes(0, 1)
    for k in range(1, LONG):
        s = k / LONG
        by_slopes = h * s * (1.0 - s) * ((1.0 - s) * f0 - s * f1)
        filled[start + k] = x0 + s**2 * (3.0 - 2.0 * s) * (x1 - x0) + by_slopes
    return filled


@cache
def stepper(n: int) -> Callable[[Derivative, State, Any, Any, State, float], State]:
    """One step of the classical fourth-order rule for ``n`` states, written out state by state.

        k_1 = f(u(t), x),                  k_2 = f(u(t + h/2), x + h/2 k_1)
        k_3 = f(u(t + h/2), x + h/2 k_2),  k_4 = f(u(t + h), x + h k_3)
        x(t + h) = x + h/6 (k_1 + 2 (k_2 + k_3) + k_4)

    A loop over the states takes longer than the sums in it, and a trial has 100,000 steps. The function is
    therefore generated from text, once for every number of states.

    Returns: ``step(f, k_1, middle, end, x, h)`` is the state a step ``h`` (s) after the state ``x``, with the
    input in its middle and at its end; ``f`` is as the ``derivative`` of `integrate` (unit of the state per
    s).
    """

    def listed(form: str) -> str:
        return ", ".join(form.format(k) for k in range(n)) + ","

    text = f"""
def step(f, a, middle, end, x, h):
    half, sixth = 0.5 * h, h / 6.0
    {listed("x{0}")} = x
    {listed("a{0}")} = a
    {listed("b{0}")} = f(middle, ({listed("x{0} + half * a{0}")}))
    {listed("c{0}")} = f(middle, ({listed("x{0} + half * b{0}")}))
    {listed("d{0}")} = f(end, ({listed("x{0} + h * c{0}")}))
    return ({listed("x{0} + sixth * (a{0} + 2.0 * (b{0} + c{0}) + d{0})")})
"""
    names: dict = {}
    exec(text, names)
    return names["step"]
