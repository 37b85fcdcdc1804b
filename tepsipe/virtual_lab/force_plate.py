"""The dual-belt treadmill's 14 force transducers and what stands between them and the load.

Per belt: 4 vertical transducers in the corners, 2 medio-lateral ones at the belt's ends, 1 fore-aft
one in its middle. A wrench w = (Fx, Fy, Fz, Mx, My, Mz) spreads over the 7 transducers as the
least-norm forces f with E f = w, where E holds the transducers' lines of action. Voltages are
sensitivity times cross-talk times f. The calibration matrix is what a careful static calibration
of such a plate would have found.
"""

from dataclasses import dataclass

import numpy as np
from scipy import signal

BELTS = ("left", "right")
TRANSDUCERS = ("z_front_left", "z_front_right", "z_rear_left", "z_rear_right", "x_front", "x_rear", "y")
COMPONENTS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")


@dataclass(frozen=True)
class PlateTruth:
    """Hidden constants of the force plate.

    Attributes
    ----------
    belt_length_m, belt_width_m, transducer_depth_m : float
        Distances between the transducers along and across the belt, and their depth under it (m).
    sensitivity_V_per_N, sensitivity_spread, cross_talk, calibration_error : float
        Volts per newton; relative spread of it; relative leak into other channels; relative error
        of the calibration (V/N, -, -, -).
    noise_V, drift_V_per_s : float
        White noise of a channel (V) and standard deviation of its linear drift (V/s).
    felt_belt_mass_kg : float
        Mass of the moving belt that the fore-aft transducer feels (kg).
    friction_Ns_per_m, friction_per_load_s_per_m : float
        Belt friction in phase with velocity: unloaded (Ns/m), and more per newton of load (s/m).
    resonance_hz, resonance_damping, resonance_mass_kg : float
        Fore-aft resonance of the unloaded frame (Hz), its damping ratio (-), its moving mass (kg).
    rate_hz : float
        Sampling rate of the log (Hz).
    """

    belt_length_m: float
    belt_width_m: float
    transducer_depth_m: float
    sensitivity_V_per_N: float
    sensitivity_spread: float
    cross_talk: float
    calibration_error: float
    noise_V: float
    drift_V_per_s: float
    felt_belt_mass_kg: float
    friction_Ns_per_m: float
    friction_per_load_s_per_m: float
    resonance_hz: float
    resonance_damping: float
    resonance_mass_kg: float
    rate_hz: float


def lines_of_action(truth: PlateTruth) -> np.ndarray:
    """Wrench about the belt's centre of a unit force in every transducer, shape (6, 7) (N/N, Nm/N)."""
    half_l, half_w, depth = (
        0.5 * truth.belt_length_m,
        0.5 * truth.belt_width_m,
        truth.transducer_depth_m,
    )
    places = [(-half_w, half_l), (half_w, half_l), (-half_w, -half_l), (half_w, -half_l)]
    points = [(x, y, -depth) for x, y in places]
    points += [(0.0, half_l, -depth), (0.0, -half_l, -depth), (0.0, 0.0, -depth)]
    directions = [(0, 0, 1)] * 4 + [(1, 0, 0)] * 2 + [(0, 1, 0)]
    columns = [
        np.concatenate([direction, np.cross(point, direction)])
        for point, direction in zip(points, directions, strict=True)
    ]
    return np.column_stack(columns).astype(float)


def plate_electronics(truth: PlateTruth, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """What the plate does to transducer forces, and the calibration matrix found for it.

    Parameters
    ----------
    truth : PlateTruth
        Constants (units in their names).
    rng : numpy.random.Generator
        Draws spread, cross-talk and calibration errors: one plate for the whole study.

    Returns
    -------
    volts_per_newton : ndarray, shape (14, 14)
        Voltages of all channels per transducer force (V/N).
    calibration : ndarray, shape (12, 14)
        Force and moment components of both belts per voltage (N/V, Nm/V).
    """
    n = len(TRANSDUCERS) * len(BELTS)
    gains = 1.0 + truth.sensitivity_spread * rng.standard_normal(n)
    leak = truth.cross_talk * rng.standard_normal((n, n))
    np.fill_diagonal(leak, 0.0)
    volts_per_newton = truth.sensitivity_V_per_N * (np.diag(gains) + leak)
    both = np.kron(np.eye(len(BELTS)), lines_of_action(truth))
    calibration = both @ np.linalg.inv(volts_per_newton)
    calibration *= 1.0 + truth.calibration_error * rng.standard_normal(calibration.shape)
    return volts_per_newton, calibration


def plate_voltages(
    truth: PlateTruth,
    volts_per_newton: np.ndarray,
    reaction: np.ndarray,
    belt_velocity: np.ndarray,
    belt_acceleration: np.ndarray,
    load_kg: float,
    grid_rate_hz: float,
    sample: np.ndarray,
    rng: np.random.Generator,
) -> np.ndarray:
    """Voltages of the 14 channels with the load on the right belt.

    Parameters
    ----------
    truth : PlateTruth
        Constants (units in their names).
    volts_per_newton : ndarray, shape (14, 14)
        From `plate_electronics` (V/N).
    reaction : ndarray, shape (n, 6)
        Wrench of the plate on the load about the belt's centre (N, Nm).
    belt_velocity, belt_acceleration : ndarray, shape (n,)
        Motion of the right belt (m/s, m/s2).
    load_kg : float
        Mass on the belt (kg).
    grid_rate_hz : float
        Rate of the arrays above (Hz).
    sample : ndarray of int, shape (k,)
        Grid points at which the log samples (-).
    rng : numpy.random.Generator
        Draws noise and drift.

    Returns
    -------
    ndarray, shape (k, 14)
        Voltages (V), left belt first.
    """
    wrench = reaction.copy()
    friction = truth.friction_Ns_per_m + truth.friction_per_load_s_per_m * reaction[:, 2]
    felt = truth.felt_belt_mass_kg * belt_acceleration + friction * belt_velocity
    wrench[:, 1] += felt
    frequency = truth.resonance_hz * np.sqrt(truth.resonance_mass_kg / (truth.resonance_mass_kg + load_kg))
    natural = 2.0 * np.pi * frequency
    frame = signal.cont2discrete(
        (
            [natural**2],
            [1.0, 2.0 * truth.resonance_damping * natural, natural**2],
        ),
        1.0 / grid_rate_hz,
        method="bilinear",
    )
    numerator, denominator = np.ravel(frame[0]), frame[1]
    for column in (1, 3):
        start = wrench[0, column]
        wrench[:, column] = start + signal.lfilter(numerator, denominator, wrench[:, column] - start)
    right = wrench[sample] @ np.linalg.pinv(lines_of_action(truth)).T
    forces = np.concatenate([np.zeros_like(right), right], axis=1)
    drift = truth.drift_V_per_s * rng.standard_normal(forces.shape[1])
    elapsed = np.arange(sample.size)[:, None] / truth.rate_hz
    noise = truth.noise_V * rng.standard_normal(forces.shape)
    return forces @ volts_per_newton.T + drift * elapsed + noise
