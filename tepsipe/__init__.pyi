"""Public names and their types, for editors and type checkers; ``__init__.py`` imports each on first use."""

from tepsipe.errors import InputError as InputError
from tepsipe.experiments.belt.analysis import belt_recording as belt_recording
from tepsipe.experiments.belt.analysis import calibrate_treadmill as calibrate_treadmill
from tepsipe.experiments.belt.compensation import compensate_recording as compensate_recording
from tepsipe.experiments.example import load_example as load_example
from tepsipe.identification.budgets.leg import LegUncertainty as LegUncertainty
from tepsipe.identification.fits import fit_admittance as fit_admittance
from tepsipe.identification.fits import fit_impedance as fit_impedance
from tepsipe.identification.fits import fit_output_error as fit_output_error
from tepsipe.identification.fits import fit_parallel_cascade as fit_parallel_cascade
from tepsipe.identification.likelihood_fit import fit_joint_likelihood as fit_joint_likelihood
from tepsipe.identification.result import ImpedanceFit as ImpedanceFit
from tepsipe.io.trial import Signal as Signal
from tepsipe.io.trial import Trial as Trial
from tepsipe.io.trial import read_trial as read_trial
from tepsipe.mechanics.inverse_dynamics import Leg as Leg
from tepsipe.mechanics.joint_simulation import simulate_joint as simulate_joint
from tepsipe.mechanics.joint_torque import joint_torque as joint_torque
from tepsipe.mechanics.segment_kinematics import SegmentMarkers as SegmentMarkers
from tepsipe.mechanics.segment_kinematics import segment_motion as segment_motion
from tepsipe.signals.filters import lowpass as lowpass
from tepsipe.signals.perturbations import find_perturbations as find_perturbations
from tepsipe.signals.spectra import frequency_response as frequency_response
from tepsipe.statistics.goodness_of_fit import vaf as vaf
from tepsipe.treadmill.registry import load_treadmill_models as load_treadmill_models

__version__: str
__all__ = [
    "ImpedanceFit",
    "InputError",
    "Leg",
    "LegUncertainty",
    "SegmentMarkers",
    "Signal",
    "Trial",
    "belt_recording",
    "calibrate_treadmill",
    "compensate_recording",
    "find_perturbations",
    "fit_admittance",
    "fit_impedance",
    "fit_joint_likelihood",
    "fit_output_error",
    "fit_parallel_cascade",
    "frequency_response",
    "joint_torque",
    "load_example",
    "load_treadmill_models",
    "lowpass",
    "read_trial",
    "segment_motion",
    "simulate_joint",
    "vaf",
]
