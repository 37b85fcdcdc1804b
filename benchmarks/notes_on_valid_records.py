"""Count notes on valid records: simulated joints of all kinds, with the noise of instruments.

    python benchmarks/notes_on_valid_records.py [--seed 1] [--scale 1.0]

A note on a valid record is a false alarm. 200 records at scale 1; the last line has their share.
"""

import argparse
import sys

import numpy as np
from scipy.signal import butter, lsim, sosfiltfilt

import tepsipe
from tepsipe import Leg, SegmentMarkers

LEG = Leg(mass_kg=0.4, com_m=0.4485, inertia_kgm2=0.027)
LAYOUT = np.array([[0.0, 0.0], [-0.012, 0.87], [0.012, 0.39]])
FOOT = np.array([[-0.05, 0.0], [0.1, 0.0]])
LABELS = ["heel", "toe", "ankle", "top", "low"]


def noise(rng, x, share):
    """White noise with a share of the signal's standard deviation."""
    return share * x.std() * rng.standard_normal(x.shape)


def band_limited(rng, count, rate_hz, cutoff_hz):
    """Random signal below a cutoff, standard deviation 1."""
    x = sosfiltfilt(butter(2, cutoff_hz, fs=rate_hz, output="sos"), rng.standard_normal(count))
    return x / x.std()


def derivatives(x, rate_hz):
    """First two derivatives of a signal far below half the sampling rate, exact at every frequency.

    The signal goes on, mirrored, beyond its ends.
    """
    longer = np.concatenate([2.0 * x[0] - x[:0:-1], x, 2.0 * x[-1] - x[-2::-1]])
    slope = np.linspace(longer[0], longer[-1], longer.size)
    per_sample = slope[1] - slope[0]
    spectrum = np.fft.rfft(longer - slope)
    turn = 2j * np.pi * np.fft.rfftfreq(longer.size, 1.0 / rate_hz)
    kept = slice(x.size - 1, 2 * x.size - 1)
    first, second = (np.fft.irfft(spectrum * turn**n, longer.size)[kept] for n in (1, 2))
    return first + per_sample * rate_hz, second


def joint(rng):
    """I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad) of finger, wrist, dummy or ankle."""
    inertia = rng.choice([0.0, 1.0]) * 10.0 ** rng.uniform(-3.0, -1.5)
    stiffness = rng.uniform(6.0, 40.0)
    moment = LEG.inertia_kgm2 + LEG.mass_kg * LEG.com_m**2 + inertia
    return inertia, 2.0 * rng.uniform(0.05, 0.4) * np.sqrt(stiffness * moment), stiffness


def pulsed(rng, count=None):
    """A leg on a pulsed belt: time (s), simulation, belt velocity (m/s), noisy belt velocity."""
    rate_hz = float(rng.choice([100.0, 200.0, 250.0, 500.0]))
    count = count or int(rng.integers(4, 20))
    time = np.arange(0.0, 3.0 + 2.5 * count + 2.0, 1.0 / rate_hz)
    velocity, lasts_s = np.zeros(time.size), rng.uniform(0.15, 0.4)
    for k in range(count):
        x = (time - 3.0 - 2.5 * k) / lasts_s
        inside = (x >= 0.0) & (x <= 1.0)
        velocity[inside] += (
            rng.choice([-1.0, 1.0]) * np.sin(2.0 * np.pi * x[inside]) * np.sin(np.pi * x[inside])
        )
    velocity *= rng.uniform(0.1, 0.4)
    inertia, damping, stiffness = joint(rng)
    made = tepsipe.simulate_joint(
        time,
        velocity,
        LEG,
        I=inertia,
        B=damping,
        K=stiffness,
        engine="equations",
        rest_angle_rad=rng.uniform(-0.02, 0.02),
    )
    return time, made, velocity + noise(rng, velocity, 0.005)


def windowed(rng):
    """Windowed least squares of a pulsed leg."""
    time, made, belt = pulsed(rng)
    angle = made.theta + noise(rng, made.theta, rng.uniform(0.001, 0.01))
    torque = made.torque + noise(rng, made.torque, rng.uniform(0.005, 0.05))
    windows = tepsipe.find_perturbations(time, belt)
    return tepsipe.fit_impedance(time, angle, torque, perturbations=windows)


def recorded(rng):
    """Least squares over a record of random movements."""
    rate_hz = float(rng.choice([100.0, 250.0, 1000.0]))
    time = np.arange(0.0, rng.uniform(20.0, 60.0), 1.0 / rate_hz)
    angle = 10.0 ** rng.uniform(-2.3, -1.0) * band_limited(rng, time.size, rate_hz, rng.uniform(2.0, 8.0))
    inertia, damping, stiffness = joint(rng)
    rate, acceleration = derivatives(angle, rate_hz)
    torque = inertia * acceleration + damping * rate + stiffness * angle + rng.uniform(-2.0, 2.0)
    torque += noise(rng, torque, rng.uniform(0.01, 0.2))
    return tepsipe.fit_impedance(time, angle + noise(rng, angle, 0.002), torque, bootstrap_draws=500)


def admittance(rng):
    """Admittance of a joint under random or periodic torque."""
    rate_hz, period_s = 250.0, 10.0
    time = np.arange(0.0, 80.0, 1.0 / rate_hz)
    count, period = time.size, None
    if rng.random() < 0.5:
        count, period = round(period_s * rate_hz), period_s
    torque = rng.uniform(0.1, 2.0) * np.resize(band_limited(rng, count, rate_hz, 15.0), time.size)
    inertia, damping, stiffness = joint(rng)
    angle = lsim(([1.0], [inertia + 0.003, damping, stiffness]), torque, time)[1]
    angle += noise(rng, angle, rng.uniform(0.01, 0.2))
    response = tepsipe.frequency_response(time, torque, angle, period_s=period, band_hz=(0.5, 12.0))
    return tepsipe.fit_admittance(response)


def markers_of(rng):
    """Markers (m) of a pulsed leg and its foot, and the arguments that the fits share."""
    time, made, belt = pulsed(rng, 5)
    across, along = LAYOUT.T
    cosine, sine = np.cos(made.theta)[:, None], np.sin(made.theta)[:, None]
    still = np.ones((time.size, 1))
    y = made.foot_y[:, None] + np.hstack([FOOT[:, 0] * still, across * cosine + along * sine])
    z = 0.055 + np.hstack([FOOT[:, 1] * still, -across * sine + along * cosine])
    positions = np.stack([y, z], axis=2)
    positions += rng.uniform(2e-5, 2e-4) * rng.standard_normal(positions.shape)
    windows = tepsipe.find_perturbations(time, belt)
    return time, positions, belt, windows, SegmentMarkers(("ankle", "top", "low"), LAYOUT)


def output_error(rng):
    """Output error of a pulsed leg."""
    time, positions, belt, windows, markers = markers_of(rng)
    motion = tepsipe.segment_motion(time, positions, markers, LEG.com_m, labels=LABELS)
    foot = positions[:, :2, 0].mean(axis=1)
    return tepsipe.fit_output_error(motion, foot, belt, LEG, perturbations=windows)


def likelihood(rng):
    """Likelihood of the markers of a pulsed leg."""
    time, positions, belt, windows, markers = markers_of(rng)
    return tepsipe.fit_joint_likelihood(
        time,
        positions,
        markers,
        LEG,
        labels=LABELS,
        belt_fixed=["heel", "toe"],
        perturbations=windows,
        belt_velocity=belt,
        softening=False,
    )


def cascade(rng):
    """Parallel cascade of a joint with a stretch reflex."""
    rate_hz = 250.0
    time = np.arange(0.0, 60.0, 1.0 / rate_hz)
    angle = 0.03 * band_limited(rng, time.size, rate_hz, 3.0)
    rate, acceleration = derivatives(angle, rate_hz)
    torque = 0.01 * acceleration + 0.8 * rate + 60.0 * angle
    stretch = np.roll(np.maximum(rate, 0.0), round(0.04 * rate_hz))
    torque += 5.0 * lsim(([900.0], [1.0, 60.0, 900.0]), stretch, time)[1]
    torque += noise(rng, torque, 0.02)
    return tepsipe.fit_parallel_cascade(time, angle, torque, bootstrap_draws=100)


KINDS = {windowed: 60, recorded: 60, admittance: 40, output_error: 16, likelihood: 16, cascade: 8}


def main() -> None:
    """Print every note on a valid record, and their share."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scale", type=float, default=1.0, help="number of records relative to 200")
    chosen = parser.parse_args()
    total = noted = 0
    for number, (kind, count) in enumerate(KINDS.items()):
        for k in range(max(1, round(count * chosen.scale))):
            fit = kind(np.random.default_rng([chosen.seed, number, k]))
            total, noted = total + 1, noted + bool(fit.notes)
            for note in fit.notes:
                print(f"{kind.__name__} {k}: {note}", flush=True)
        print(f"{kind.__name__}: done", file=sys.stderr)
    print(f"{noted} of {total} valid records have notes: {100.0 * noted / total:.1f} %")


if __name__ == "__main__":
    main()
