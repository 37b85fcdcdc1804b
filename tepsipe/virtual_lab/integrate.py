"""Fixed-step integration of the rigs' equations of motion.

Plain floats and tuples: for a handful of states this is several times faster than arrays,
and every run gives the same bits.
"""

from array import array
from collections.abc import Callable
from functools import cache

import numpy as np

State = tuple[float, ...]


def integrate(
    derivative: Callable[[float, State], State],
    initial: State,
    duration_s: float,
    rate_hz: float,
    begin: Callable[[int, State], None] = lambda k, state: None,
) -> tuple[np.ndarray, np.ndarray]:
    """Integrate with the classical fourth-order Runge-Kutta rule.

    derivative: ``derivative(t, state)`` returns the time derivative of every state (unit of the state per
    s).
    initial: state at t = 0.
    duration_s: length of the run.
    rate_hz: steps per second.
    begin: called with the number and the state of each step at its start.

    Returns:
        time: grid 0, 1/rate, 2/rate, ... (s), the last point at or just after ``duration_s``.
        states: one row per grid point (units of the states). Shape (n, len(initial)).
    """
    steps = int(np.ceil(duration_s * rate_hz))
    h = 1.0 / rate_hz
    x = tuple(float(value) for value in initial)
    step = stepper(len(x))
    states = array("d", x)
    for k in range(steps):
        begin(k, x)
        x = step(derivative, k * h, x, h)
        states.extend(x)
    states = np.array(states).reshape(steps + 1, len(x))
    if not np.isfinite(states[-1]).all():
        raise FloatingPointError("the integration of the rig diverged: check the rig's constants")
    return np.arange(steps + 1) * h, states


@cache
def stepper(n: int) -> Callable[[Callable[[float, State], State], float, State, float], State]:
    """One step of the classical fourth-order rule for ``n`` states, written out state by state.

        k_1 = f(t, x),                  k_2 = f(t + h/2, x + h/2 k_1)
        k_3 = f(t + h/2, x + h/2 k_2),  k_4 = f(t + h, x + h k_3)
        x(t + h) = x + h/6 (k_1 + 2 (k_2 + k_3) + k_4)

    A loop over the states takes longer than the sums in it, and a trial has 100,000 steps. The function is
    therefore generated from text, once for every number of states.

    Returns: ``step(f, t, x, h)`` is the state a step ``h`` (s) after the state ``x`` at ``t`` (s); ``f`` is
    as the ``derivative`` of `integrate` (unit of the state per s).
    """

    def listed(form: str) -> str:
        return ", ".join(form.format(k) for k in range(n)) + ","

    text = f"""
def step(f, t, x, h):
    half, sixth = 0.5 * h, h / 6.0
    {listed("x{0}")} = x
    {listed("a{0}")} = f(t, x)
    {listed("b{0}")} = f(t + half, ({listed("x{0} + half * a{0}")}))
    {listed("c{0}")} = f(t + half, ({listed("x{0} + half * b{0}")}))
    {listed("d{0}")} = f(t + h, ({listed("x{0} + h * c{0}")}))
    return ({listed("x{0} + sixth * (a{0} + 2.0 * (b{0} + c{0}) + d{0})")})
"""
    names: dict = {}
    exec(text, names)
    return names["step"]
