"""Motions and spectra whose parameters are known, made without the library's formulas."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tepsipe.errors import InputError
from tepsipe.io.trial import Signal, Trial
from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.mechanics.segment_kinematics import SegmentMotion
from tepsipe.signals.response import FrequencyResponse

# thesis Table 2-2
LEG = Leg(mass_kg=0.4, com_m=0.4485, inertia_kgm2=0.027, gravity_m_per_s2=9.81)
RATE_HZ = 250.0
PULSE_S = 0.025  # of `belt_pulses`: half the time between its two lobes
WRISTALYZER_DURATION_S = 12.0
DUMMY_DURATION_S = 12.0


@dataclass(frozen=True)
class Joint:
    """A linear joint: inertia (kg m2), damping (Nms/rad), stiffness (Nm/rad), angle at rest (rad)."""

    inertia: float = 0.0
    damping: float = 0.1
    stiffness: float = 10.0
    rest: float = 0.0


@dataclass(frozen=True)
class Swing:
    """Exact motion of a leg on a belt that is pulsed (s, m, rad)."""

    time: np.ndarray
    belt_position: np.ndarray
    belt_velocity: np.ndarray
    belt_acceleration: np.ndarray
    motion: SegmentMotion
    torque: np.ndarray


def belt_pulses(time, onsets_s, peak_m_per_s):
    """Belt position, velocity and acceleration: one Gaussian bump of position per onset.

    The velocity has two lobes of opposite sign, each with the peak velocity.
    """
    height = peak_m_per_s * PULSE_S * np.exp(0.5)
    position, velocity, acceleration = np.zeros((3, *np.shape(time)))
    for onset in onsets_s:
        x = (time - onset - 4.0 * PULSE_S) / PULSE_S
        bump = height * np.exp(-0.5 * x**2)
        position = position + bump
        velocity = velocity - x / PULSE_S * bump
        acceleration = acceleration + (x**2 - 1.0) / PULSE_S**2 * bump
    return position, velocity, acceleration


def _belt_acceleration(t, onsets_s, peak_m_per_s):
    """Belt acceleration of `belt_pulses` at one instant."""
    found = 0.0
    for onset in onsets_s:
        x = (t - onset - 4.0 * PULSE_S) / PULSE_S
        found += (x * x - 1.0) * math.exp(-0.5 * x * x)
    return peak_m_per_s * math.exp(0.5) / PULSE_S * found


@lru_cache(maxsize=64)
def swing(joint, onsets_s=(2.0, 4.0, 6.0), peak_m_per_s=0.3, duration_s=10.0, leg=LEG):
    """The leg's motion, exact, from its non-linear equation of motion.

    J th'' = m g r sin(th) - m r y_f'' cos(th) - B th' - K (th - th_ref)
    """
    m, r, g = leg.mass_kg, leg.com_m, leg.gravity_m_per_s2
    about_ankle = leg.inertia_kgm2 + m * r**2 + joint.inertia
    neutral = joint.rest - m * g * r * np.sin(joint.rest) / joint.stiffness

    def angular_acceleration(belt, th, w, sin, cos):
        bent = joint.damping * w + joint.stiffness * (th - neutral)
        return (m * g * r * sin(th) - m * r * belt * cos(th) - bent) / about_ankle

    def rates(t, x):
        th, w = x.tolist()  # numbers of Python are several times as fast, one by one
        return w, angular_acceleration(
            _belt_acceleration(t, onsets_s, peak_m_per_s), th, w, math.sin, math.cos
        )

    time = np.arange(round(duration_s * RATE_HZ)) / RATE_HZ
    solution = solve_ivp(
        rates,
        (0.0, time[-1]),
        (joint.rest, 0.0),
        method="DOP853",
        t_eval=time,
        rtol=1e-10,
        atol=1e-12,
        max_step=0.02,
    )
    th, w = solution.y
    position, velocity, acceleration = belt_pulses(time, onsets_s, peak_m_per_s)
    w_rate = angular_acceleration(acceleration, th, w, np.sin, np.cos)
    motion = SegmentMotion(
        time=time,
        theta=th,
        theta_d=w,
        theta_dd=w_rate,
        y_dd=acceleration + r * (np.cos(th) * w_rate - np.sin(th) * w**2),
        z_dd=-r * (np.sin(th) * w_rate + np.cos(th) * w**2),
        marker_residual_rms_m=0.0,
    )
    torque = joint.inertia * w_rate + joint.damping * w + joint.stiffness * (th - neutral)
    made = Swing(time, position, velocity, acceleration, motion, torque)
    for x in (*vars(made).values(), *vars(motion).values()):
        if isinstance(x, np.ndarray):
            x.flags.writeable = False  # others get the same
    return made


def second_order_response(parameters, frequency_hz):
    """Angle over torque of a joint with I, B, K, from the balance of its torques."""
    inertia, damping, stiffness = parameters
    omega = 2.0 * np.pi * np.asarray(frequency_hz)
    return 1.0 / ((stiffness - inertia * omega**2) + 1j * damping * omega)


def multisine_record(parameters, periods, rate_hz=256.0, period_s=10.0, band_hz=(1.0, 20.0), seed=3):
    """Periodic torque of random phases and the steady angle of a joint, line by line."""
    lines = np.arange(round(band_hz[0] * period_s), round(band_hz[1] * period_s) + 1)
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, lines.size)
    samples = round(period_s * rate_hz)
    spectrum = np.zeros(samples // 2 + 1, dtype=complex)
    spectrum[lines] = samples / 40.0 * np.exp(1j * phases)
    response = second_order_response(parameters, np.arange(spectrum.size) / period_s)
    total = round(periods * samples)
    torque = np.resize(np.fft.irfft(spectrum, samples), total)
    angle = np.resize(np.fft.irfft(spectrum * response, samples), total)
    return torque, angle


def noisy_spectrum(parameters, noise, rng, frequency_hz=None):
    """Spectral estimate whose weighted log ratio to the truth is white with a known deviation."""
    frequency = np.arange(1.0, 9.01, 0.1) if frequency_hz is None else frequency_hz
    weight = np.sqrt(1.0 / frequency)
    errors = rng.standard_normal(frequency.size) + 1j * rng.standard_normal(frequency.size)
    response = second_order_response(parameters, frequency) * np.exp(noise * errors / weight)
    return FrequencyResponse(frequency, response, np.ones_like(frequency), 5)


def trial_of(rate_hz, **signals):
    """A trial on a regular clock from arrays of equal length; each value is (samples, unit)."""
    samples = next(iter(signals.values()))[0].shape[0]
    return Trial(
        rate_hz=rate_hz,
        axes={"time": np.arange(samples) / rate_hz},
        signals={name: Signal(values, unit, ("time",), name) for name, (values, unit) in signals.items()},
    )


def scaled_leg(leg, factor):
    """The same leg, `factor` times as heavy."""
    return replace(leg, mass_kg=factor * leg.mass_kg, inertia_kgm2=factor * leg.inertia_kgm2)


def bend_at_rest(moment, critical_stiffness):
    """Bending (rad) at which a joint of a given moment (Nm) carries a critical_stiffness moment (Nm)."""
    return brentq(lambda phi: moment(phi) - critical_stiffness, -1.0, 1.0, xtol=1e-14)


def refused(function, *parts):
    """Call a function that raises `InputError` with one sentence that has these parts."""
    try:
        found = function()
    except InputError as error:
        assert_one_sentence(error, *parts)
    else:
        raise AssertionError(f"expected a refusal, found {found!r}")


def alike(found, expected, rel=0.0, abs=0.0, nan_ok=False):
    """Whether long arrays are equal within the larger tolerance: `pytest.approx` takes 10 µs per number."""
    within = np.abs(found - expected) <= np.maximum(rel * np.abs(expected), abs)
    equal = within | (np.isnan(found) & np.isnan(expected)) if nan_ok else within
    return np.shape(found) == np.shape(expected) and bool(np.all(equal))


def assert_one_sentence(error, *names):
    """A message for a person: one sentence that names the source, what was expected, what found."""
    text = str(error)
    for name in (*map(str, names), "expected", "found"):
        assert name in text, f"{name!r} is not in: {text}"
    assert "\n" not in text, f"more than one line: {text!r}"
    assert ". " not in text, f"more than one sentence: {text}"
    assert "Traceback" not in text
    assert len(text) < 600, f"{len(text)} characters are too many for one sentence"
