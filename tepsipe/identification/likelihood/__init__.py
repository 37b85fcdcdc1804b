"""Likelihood of all motion channels of a trial on the treadmill: markers of leg and foot, belt velocity.

In the order in which they build on each other: `channels` reduces markers and drive log to the motion of
the foot, the angle of the leg and the velocity of the belt, with their noise. `model` has the equations of
motion of a leg on a joint, and the spectra that they predict for these channels. `likelihood` compares both
at every frequency, with the foot's motion unknown, and finds the parameters that make the measured spectra
most likely. `result` turns them into I, B and K at the amplitude of the perturbations, with intervals, and
into the residuals that checks examine.

Each module states its equations in its docstring. A joint is the anatomical joint throughout.
"""
