"""Joint impedance from transient endpoint perturbations (TEP-SIPE).

Arrays in, one result out. Arguments are NumPy arrays in SI units, or ``Signal(values, unit)``, which is
converted. Options are keyword-only, carry their unit in their name, and default to the recommended method;
``thesis=True`` selects the method of the thesis. Input that cannot be used raises an `InputError` with one
sentence.

Read
    load_example          a simulated recording with its truth, to try the functions on
    read_trial            a trial's HDF5 file, as the study writes it
    Trial, Signal         what it holds

Signals
    lowpass               zero-lag Butterworth filter
    find_perturbations    windows in which the belt moved
    frequency_response    response and coherence of two signals
    vaf                   variance accounted for (thesis eq 3-1)

Mechanics
    Leg, SegmentMarkers   masses and lengths, and positions of markers
    segment_motion        angle and accelerations of a segment from its markers
    joint_torque          torque of the joint by inverse dynamics
    simulate_joint        motion and forces of a joint of known impedance

Identification: each returns an ImpedanceFit with .I .B .K, intervals, .vaf, .summary(), .to_frame(), .plot()
    fit_impedance         angle and torque, per perturbation or over one record
    fit_output_error      angle and motion of the foot, without a torque
    fit_joint_likelihood  markers of leg and foot, and velocity of the belt, at once
    fit_admittance        a frequency response (Wristalyzer)
    fit_parallel_cascade  intrinsic stiffness and stretch reflex
    ImpedanceFit          the result
    LegUncertainty        uncertainty of masses, lengths and markers of a leg, for fit_impedance

Treadmill
    belt_recording        load and velocity of an accelerated belt
    calibrate_treadmill   models of the belt-induced load, fitted and validated
    load_treadmill_models models from a file
    compensate_recording  a recorded file with corrected loads
"""

import importlib
from typing import Any

__version__ = "1.0.0"

# public name -> module that defines it; imported on first use. The same names with types are in __init__.pyi
_PUBLIC = {
    "InputError": "tepsipe.errors",
    "load_example": "tepsipe.experiments.example",
    "read_trial": "tepsipe.io.trial",
    "Trial": "tepsipe.io.trial",
    "Signal": "tepsipe.io.trial",
    "lowpass": "tepsipe.signals.filters",
    "find_perturbations": "tepsipe.signals.perturbations",
    "frequency_response": "tepsipe.signals.spectra",
    "vaf": "tepsipe.statistics.goodness_of_fit",
    "Leg": "tepsipe.mechanics.inverse_dynamics",
    "SegmentMarkers": "tepsipe.mechanics.segment_kinematics",
    "segment_motion": "tepsipe.mechanics.segment_kinematics",
    "joint_torque": "tepsipe.mechanics.joint_torque",
    "simulate_joint": "tepsipe.mechanics.joint_simulation",
    "fit_impedance": "tepsipe.identification.fits",
    "fit_output_error": "tepsipe.identification.fits",
    "fit_joint_likelihood": "tepsipe.identification.likelihood_fit",
    "fit_admittance": "tepsipe.identification.fits",
    "fit_parallel_cascade": "tepsipe.identification.fits",
    "ImpedanceFit": "tepsipe.identification.result",
    "LegUncertainty": "tepsipe.identification.budgets.leg",
    "belt_recording": "tepsipe.experiments.belt.analysis",
    "calibrate_treadmill": "tepsipe.experiments.belt.analysis",
    "load_treadmill_models": "tepsipe.treadmill.registry",
    "compensate_recording": "tepsipe.experiments.belt.compensation",
}
__all__ = list(_PUBLIC)


def __getattr__(name: str) -> Any:
    if name in _PUBLIC:
        return getattr(importlib.import_module(_PUBLIC[name]), name)
    text = f"module 'tepsipe' has no attribute {name!r}"
    if not name.startswith("_"):
        text += f": {importlib.import_module('tepsipe.errors').nearest(name, _PUBLIC)}"
    raise AttributeError(text)


def __dir__() -> list[str]:
    return sorted([*_PUBLIC, "__version__"])
