"""The standing person by the thesis's method, with a parametric torque of the muscles.

`impedance` fits I, B, K and the gains of the muscles to mean responses; `latency` finds when each muscle
answers its own stretch; `results` fits all estimators of a trial or task, and makes the tables and result
files of both.
"""
