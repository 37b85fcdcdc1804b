"""The standing person with a free reflex torque: the recommended estimate, its budget and its checks.

`joint_centre` finds the centre of the ankle in quiet sway. `free_body` is the torque of the feet at a higher
cutoff than the other signals, and its change with each source of uncertainty; `broadband` cuts both into
epochs. `fit_errors` carries the sources through to B and K of a fit, and `fit` estimates both by generalised
least squares. `checks` compares the fit with a short window, and the treadmill model with held-out trials.
`reflex` has the numbers of the reflex torque that K and B leave. `results` joins fits, budgets and tables.
"""
