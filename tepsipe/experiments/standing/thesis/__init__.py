"""The standing person by the thesis's method: epochs, parametric muscle torque, reflex latencies."""
