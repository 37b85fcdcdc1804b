"""A person standing on the treadmill (thesis sections 3-2 and 4-2).

The trial comes first: `options` are the person and the choices of the analysis, `stance` refuses trials with
steps, `joint_torque` computes joint angles and ankle torque from markers and force plate, and `epochs` cuts
the responses to single perturbations. `estimates` is the form of every fit to them.

Two estimators fit the responses, each a package that reads in its own order. `thesis` has the thesis's
method: intrinsic parameters and a parametric torque of the muscles, and the latencies of their reflexes.
`free_reflex` leaves the reflex torque free; it is the recommended estimate, with its uncertainty budget and
checks.
"""
