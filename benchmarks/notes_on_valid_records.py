"""Count notes on valid and on spoiled records: simulated joints of all kinds, with the noise of instruments.

    python benchmarks/notes_on_valid_records.py [--seed 1] [--scale 1.0] [--spoiled]

A note on a valid record is a false alarm. 236 records at scale 1; the last line has their share. With
``--spoiled``, every record is spoiled as laboratories do it (`SPOILS`), and is noted, refused, covered by
intervals that are less than 1.5 times as wide as those of the record that was not spoiled, or silently wrong.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import yaml
from scipy.interpolate import CubicSpline
from scipy.signal import butter, lsim, sosfilt, sosfiltfilt

import tepsipe
from tepsipe import InputError, Leg, SegmentMarkers
from tepsipe.experiments.platform.fit import fit as fit_platform
from tepsipe.experiments.position_manipulator.fit import fit as fit_position_manipulator
from tepsipe.experiments.wristalyzer.fit import fit as fit_wristalyzer
from tepsipe.ingest.manipulator_options import ManipulatorOptions, PlatformTableOptions, TableOptions
from tepsipe.ingest.manipulators import ingest_position_manipulator, ingest_torque_manipulator
from tepsipe.ingest.platform import ingest_platform
from tepsipe.virtual_lab.platform_person import PlatformPerson, PlatformProtocol, record_platform

SETTINGS = Path(__file__).parents[1] / "config/config.yaml"
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
    """A leg on a pulsed belt: time (s), simulation, noisy belt velocity (m/s), I, B, K."""
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
    return time, made, velocity + noise(rng, velocity, 0.005), (inertia, damping, stiffness)


def unspoiled(_rng, _rate_hz, time, angle, torque):
    """Signals as they are."""
    return time, angle, torque


def windowed(rng, spoil=unspoiled):
    """Windowed least squares of a pulsed leg."""
    time, made, belt, truth = pulsed(rng)
    angle = made.theta + noise(rng, made.theta, rng.uniform(0.001, 0.01))
    torque = made.torque + noise(rng, made.torque, rng.uniform(0.005, 0.05))
    windows = tepsipe.find_perturbations(time, belt)
    signals = spoil(rng, 1.0 / time[1], time, angle, torque)
    return tepsipe.fit_impedance(*signals, perturbations=windows), truth


def recorded(rng, spoil=unspoiled):
    """Least squares over a record of random movements."""
    rate_hz = float(rng.choice([100.0, 250.0, 1000.0]))
    time = np.arange(0.0, rng.uniform(20.0, 60.0), 1.0 / rate_hz)
    angle = 10.0 ** rng.uniform(-2.3, -1.0) * band_limited(rng, time.size, rate_hz, rng.uniform(2.0, 8.0))
    truth = joint(rng)
    rate, acceleration = derivatives(angle, rate_hz)
    torque = truth[0] * acceleration + truth[1] * rate + truth[2] * angle + rng.uniform(-2.0, 2.0)
    torque += noise(rng, torque, rng.uniform(0.01, 0.2))
    signals = spoil(rng, rate_hz, time, angle + noise(rng, angle, 0.002), torque)
    return tepsipe.fit_impedance(*signals, bootstrap_draws=500), truth


def admittance(rng, spoil=unspoiled):
    """Admittance of a joint under random or periodic torque."""
    rate_hz, period_s = 250.0, 10.0
    time = np.arange(0.0, 80.0, 1.0 / rate_hz)
    count, period = time.size, None
    if rng.random() < 0.5:
        count, period = round(period_s * rate_hz), period_s
    torque = rng.uniform(0.1, 2.0) * np.resize(band_limited(rng, count, rate_hz, 15.0), time.size)
    inertia, damping, stiffness = joint(rng)
    truth = inertia + 0.003, damping, stiffness
    angle = lsim(([1.0], truth), torque, time)[1]
    angle += noise(rng, angle, rng.uniform(0.01, 0.2))
    time, angle, torque = spoil(rng, rate_hz, time, angle, torque)
    response = tepsipe.frequency_response(time, torque, angle, period_s=period, band_hz=(0.5, 12.0))
    return tepsipe.fit_admittance(response), truth


def markers_of(rng, spoil):
    """Markers (m) of a pulsed leg and its foot, the arguments that the fits share, and I, B, K."""
    time, made, belt, truth = pulsed(rng, 5)
    across, along = LAYOUT.T
    cosine, sine = np.cos(made.theta)[:, None], np.sin(made.theta)[:, None]
    still = np.ones((time.size, 1))
    y = made.foot_y[:, None] + np.hstack([FOOT[:, 0] * still, across * cosine + along * sine])
    z = 0.055 + np.hstack([FOOT[:, 1] * still, -across * sine + along * cosine])
    positions = np.stack([y, z], axis=2)
    positions += rng.uniform(2e-5, 2e-4) * rng.standard_normal(positions.shape)
    windows = tepsipe.find_perturbations(time, belt)
    time, positions, belt = spoil(rng, 1.0 / time[1], time, positions, belt)
    return time, positions, belt, windows, SegmentMarkers(("ankle", "top", "low"), LAYOUT), truth


def output_error(rng, spoil=unspoiled):
    """Output error of a pulsed leg."""
    time, positions, belt, windows, markers, truth = markers_of(rng, spoil)
    motion = tepsipe.segment_motion(time, positions, markers, LEG.com_m, labels=LABELS)
    foot = positions[:, :2, 0].mean(axis=1)
    return tepsipe.fit_output_error(motion, foot, belt, LEG, perturbations=windows), truth


def likelihood(rng, spoil=unspoiled):
    """Likelihood of the markers of a pulsed leg."""
    time, positions, belt, windows, markers, truth = markers_of(rng, spoil)
    fit = tepsipe.fit_joint_likelihood(
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
    return fit, truth


def cascade(rng, spoil=unspoiled):
    """Parallel cascade of a joint with a stretch reflex."""
    rate_hz = 250.0
    time = np.arange(0.0, 60.0, 1.0 / rate_hz)
    angle = 0.03 * band_limited(rng, time.size, rate_hz, 3.0)
    rate, acceleration = derivatives(angle, rate_hz)
    torque = 0.01 * acceleration + 0.8 * rate + 60.0 * angle
    stretch = np.roll(np.maximum(rate, 0.0), round(0.04 * rate_hz))
    torque += 5.0 * lsim(([900.0], [1.0, 60.0, 900.0]), stretch, time)[1]
    torque += noise(rng, torque, 0.02)
    signals = spoil(rng, rate_hz, time, angle, torque)
    return tepsipe.fit_parallel_cascade(*signals, bootstrap_draws=100), (0.01, 0.8, 60.0)


class OfStudy:
    """Rows of a study's trial as a fit: flags are notes, and an estimate that is not recommended has one."""

    def __init__(self, rows, names):
        quoted = {row.quantity: row for row in rows if row.recommended}
        found = {name for row in quoted.values() for name in row.flags.split(";") if name}
        found |= {f"{name} is not recommended" for name in names if name not in quoted}
        self.notes, self.names = tuple(sorted(found)), names
        self.intervals = {name: (row.ci_low, row.ci_high) for name, row in quoted.items()}


def study(experiment, options):
    """Options of a study's recordings, of the class ``options``, and its section as shipped."""
    section = yaml.safe_load(SETTINGS.read_text())[experiment]
    known = options.__dataclass_fields__
    chosen = section["ingest"] | {key: x for key, x in section["files"].items() if key in known}
    return options(**chosen), section


def manipulator(rng, spoil=unspoiled):
    """Study of an ankle that a servo moves by steps, with a stretch reflex and slow voluntary torque."""
    options, section = study("position_manipulator", TableOptions)
    section["analysis"]["bootstrap_draws"] = 200
    rate_hz = float(rng.choice([250.0, 400.0, 1000.0]))
    time = np.arange(0.0, rng.uniform(30.0, 70.0), 1.0 / rate_hz)
    steps = np.repeat(rng.choice([-0.03, 0.03], time.size), round(0.15 * rate_hz))[: time.size]
    angle = sosfilt(butter(2, 8.0, fs=rate_hz, output="sos"), steps)
    rate, acceleration = derivatives(angle, rate_hz)
    truth = 10.0 ** rng.uniform(-2.2, -1.7), rng.uniform(0.5, 1.2), rng.uniform(35.0, 90.0)
    torque = truth[0] * acceleration + truth[1] * rate + truth[2] * angle
    stretch = moved(time, np.maximum(rate, 0.0), rng.uniform(0.036, 0.048))
    torque += rng.uniform(3.0, 7.0) * lsim(([900.0], [1.0, 60.0, 900.0]), stretch, time)[1]
    slow = band_limited(rng, time.size, rate_hz, 0.3)
    torque += rng.uniform(0.05, 0.15) * torque.std() * slow + noise(rng, torque, rng.uniform(0.01, 0.03))
    angle = angle + 0.3 + 3e-5 * rng.standard_normal(time.size)
    time, angle, torque = spoil(rng, rate_hz, time, angle, torque)
    table = {"time": time, "angle": angle, "torque": options.torque_sign * torque}
    trial = ingest_position_manipulator(table, options, time[-1] - 1.0, "log")
    return OfStudy(fit_position_manipulator(trial, section, "a", 1).estimates, "IBK"), truth


def wristalyzer(rng, spoil=unspoiled):
    """Study of a wrist under a torque of many frequencies; the angle is logged at uneven instants."""
    options, section = study("wristalyzer", ManipulatorOptions)
    section["analysis"] |= {
        "random_starts": 1,
        "profile_points": 5,
        "tried_stiffness_Nm_per_rad": [5.0, 15.0],
    }
    time = np.arange(0.0, rng.choice([62.0, 72.0, 82.0]), 1e-3)
    period = time[:10000, None]
    torque = np.cos(2.0 * np.pi * (np.arange(10, 201) / 10.0 * period + rng.random(191))).sum(axis=1)
    torque = np.resize(torque, time.size)
    torque *= rng.uniform(0.1, 0.3) / torque.std()
    truth = rng.uniform(0.008, 0.02), rng.uniform(0.06, 0.2), rng.uniform(6.0, 14.0)
    response = lsim(([1.0], truth), torque, time)[1]
    rate_hz = rng.uniform(270.0, 330.0)
    stamps = np.cumsum(rng.uniform(0.8, 1.2, round((time[-1] + 3.0) * rate_hz)) / rate_hz) - 3.0
    stamps = stamps[stamps < time[-1]]
    angle = np.where(stamps >= 0.0, CubicSpline(time, response)(np.maximum(stamps, 0.0)), 0.0)
    angle += noise(rng, angle, rng.uniform(0.005, 0.02))
    stamps, angle, _ = spoil(rng, rate_hz, stamps, angle, np.zeros(stamps.size))
    log = {"time": 10.0 + stamps, "angle": angle, "trigger_time": np.where(stamps < 0.0, 0.0, 10.0)}
    command = {"time": time, "torque": torque}
    trial = ingest_torque_manipulator(log, command, options, time[-1] - 1.0, "log", "command")
    known = yaml.safe_load(SETTINGS.read_text())["uncertainty"]["wristalyzer"]
    return OfStudy(fit_wristalyzer(trial, section, "a", 1, known).estimates, "IBK"), truth


def platform(rng, spoil=unspoiled):
    """Study of a person on a moving platform; ankle and hip are the columns of angle and torque."""
    options, section = study("platform", PlatformTableOptions)
    section["analysis"]["models"] = ["intrinsic", "own-reflex"]
    own = rng.uniform(850.0, 1200.0), rng.uniform(350.0, 600.0)
    stiffness = ((own[0], rng.uniform(80.0, 200.0)), (rng.uniform(60.0, 150.0), own[1]))
    person = PlatformPerson(stiffness_Nm_per_rad=stiffness, own_torque_Nm=(4.0, 2.0))
    made = record_platform(person, PlatformProtocol(rng.choice([120.0, 180.0])), rng)
    time, angle, torque = spoil(rng, 1.0 / made.time[1], made.time, made.angle, made.torque)
    table = {"time": time, "platform": made.platform}
    for k, name in enumerate(("ankle", "hip")):
        table |= {f"{name}_angle": angle[:, k], f"{name}_torque": torque[:, k]}
    trial = ingest_platform(table, options, time[-1] - 1.0, "log")
    return OfStudy(fit_platform(trial, section, "a").estimates, ("K_ankle_ankle", "K_hip_hip")), own


KINDS = {
    windowed: 60,
    recorded: 60,
    admittance: 40,
    output_error: 16,
    likelihood: 16,
    cascade: 8,
    manipulator: 12,
    wristalyzer: 12,
    platform: 12,
}


# ---- spoils --------------------------------------------------------------------------------------


def moved(time, x, late_s):
    """Signal that is recorded too late."""
    return CubicSpline(time, x, axis=0)(np.clip(time - late_s, time[0], time[-1]))


def filtered(rng, x, rate_hz, causal):
    """Signal after a low-pass filter of 6 to 15 Hz, zero-lag or causal."""
    sos = butter(2, rng.uniform(6.0, 15.0), fs=rate_hz, output="sos")
    return x[0] + (sosfilt if causal else sosfiltfilt)(sos, x - x[0], axis=0)


def of_torque(change):
    """Spoil that changes the torque only, by a function of rng, rate (Hz), time (s) and torque (N·m)."""
    return lambda rng, rate_hz, time, angle, torque: (time, angle, change(rng, rate_hz, time, torque))


def of_angle(change):
    """Spoil that changes the angle only."""
    return lambda rng, rate_hz, time, angle, torque: (time, change(rng, rate_hz, time, angle), torque)


def late(rng, _rate_hz, time, x):
    """Delay of 1 to 20 ms in either direction."""
    return moved(time, x, rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-3.0, -1.7))


def drifting(rng, _rate_hz, time, x):
    """Drift by 0.5 to 3 standard deviations over the record."""
    return x + rng.uniform(0.5, 3.0) * x.std() * (time - time[0]) / (time[-1] - time[0])


def spiked(rng, _rate_hz, _time, x):
    """Ten to forty spikes as high as the signal's range."""
    where = rng.integers(3, x.size - 3, rng.integers(10, 40))
    x = x.copy()
    x[where] += np.ptp(x) * rng.choice([-1.0, 1.0], where.size)
    return x


def held(rng, rate_hz, _time, x):
    """One in ten stretches of 50 ms holds its first value."""
    length, x = round(0.05 * rate_hz), x.copy()
    for start in rng.choice(x.size // length, x.size // length // 10, replace=False) * length:
        x[start : start + length] = x[start]
    return x


def saturated(rng, _rate_hz, _time, x):
    """Range of the instrument of 40 to 80 % of the signal's."""
    half = rng.uniform(0.4, 0.8) * np.abs(x - np.median(x)).max()
    return np.clip(x, np.median(x) - half, np.median(x) + half)


def other_gain(rng, _rate_hz, time, x):
    """Gain that changes by 15 to 40 % in the middle of the record."""
    return np.where(time > time.mean(), rng.choice([0.7, 0.85, 1.15, 1.4]), 1.0) * x


def ruined(rng, _rate_hz, time, x):
    """Second half that belongs to another trial."""
    return np.where(time > time.mean(), rng.permutation(x), x)


OF_SIGNALS = {
    "torque filtered": of_torque(lambda rng, rate, time, x: filtered(rng, x, rate, False)),
    "torque filtered, causal": of_torque(lambda rng, rate, time, x: filtered(rng, x, rate, True)),
    "angle filtered": of_angle(lambda rng, rate, time, x: filtered(rng, x, rate, False)),
    "torque late": of_torque(late),
    "torque drifts": of_torque(drifting),
    "torque with spikes": of_torque(spiked),
    "angle with spikes": of_angle(spiked),
    "torque held": of_torque(held),
    "torque clipped": of_torque(saturated),
    "other gain in the second half": of_torque(other_gain),
    "second half ruined": of_torque(ruined),
    "torque reversed": of_torque(lambda rng, rate, time, x: -x),
    "exchanged": lambda rng, rate, time, angle, torque: (time, torque, angle),
}


def of_leg(change):
    """Spoil that changes the markers of the leg beside the ankle, shape (n, 2, 2)."""

    def spoil(rng, rate_hz, time, positions, belt):
        positions = positions.copy()
        positions[:, 3:] = change(rng, rate_hz, time, positions[:, 3:])
        return time, positions, belt

    return spoil


def slipped(rng, _rate_hz, time, x):
    """One marker slips by 2 to 8 mm in the middle of the record."""
    step = np.zeros(x.shape[1:])
    step[0] = rng.uniform(0.002, 0.008) * rng.choice([-1.0, 1.0], 2)
    return x + (time > time.mean())[:, None, None] * step


OF_MARKERS = {
    "leg late": of_leg(lambda rng, rate, time, x: moved(time, x, rng.uniform(0.002, 0.008))),
    "leg early": of_leg(lambda rng, rate, time, x: moved(time, x, -rng.uniform(0.002, 0.008))),
    "leg filtered": of_leg(lambda rng, rate, time, x: filtered(rng, x, rate, False)),
    "marker slips": of_leg(slipped),
    "belt reversed": lambda rng, rate, time, positions, belt: (time, positions, -belt),
    "cameras of another scale": lambda rng, rate, time, positions, belt: (
        time,
        positions * (1.0 + rng.choice([-1.0, 1.0]) * rng.uniform(0.012, 0.04)),
        belt,
    ),
    "belt late": lambda rng, rate, time, positions, belt: (time, positions, moved(time, belt, 0.01)),
}


def of_joint(change, joint=0):
    """Spoil of one joint's torque of several, shape (n, joints)."""

    def spoil(rng, rate_hz, time, angle, torque):
        torque = torque.copy()
        torque[:, joint] = change(rng, rate_hz, time, torque[:, joint])
        return time, angle, torque

    return spoil


OF_ANGLE = {
    "angle filtered": of_angle(lambda rng, rate, time, x: filtered(rng, x, rate, False)),
    "angle filtered, causal": of_angle(lambda rng, rate, time, x: filtered(rng, x, rate, True)),
    "angle late": of_angle(late),
    "angle drifts": of_angle(drifting),
    "angle with spikes": of_angle(spiked),
    "angle held": of_angle(held),
    "angle clipped": of_angle(saturated),
    "other gain in the second half": of_angle(other_gain),
    "second half ruined": of_angle(ruined),
    "angle reversed": of_angle(lambda rng, rate, time, x: -x),
}
OF_JOINTS = {
    "torques filtered": of_torque(lambda rng, rate, time, x: filtered(rng, x, rate, False)),
    "torques filtered, causal": of_torque(lambda rng, rate, time, x: filtered(rng, x, rate, True)),
    "torques late": of_torque(late),
    "torque with spikes": of_joint(spiked),
    "torque held": of_joint(held),
    "torque clipped": of_joint(saturated, 1),
    "other gain in the second half": of_joint(other_gain),
    "torque drifts": of_joint(drifting),
    "second half ruined": of_joint(ruined),
    "torque of the hip reversed": of_joint(lambda rng, rate, time, x: -x, 1),
    "torques exchanged": of_torque(lambda rng, rate, time, x: x[:, ::-1]),
    "angles exchanged": of_angle(lambda rng, rate, time, x: x[:, ::-1]),
    "joints exchanged": lambda rng, rate, time, angle, torque: (time, angle[:, ::-1], torque[:, ::-1]),
}
SPOILS = dict.fromkeys(KINDS, OF_SIGNALS) | {output_error: OF_MARKERS, likelihood: OF_MARKERS}
SPOILS |= {wristalyzer: OF_ANGLE, platform: OF_JOINTS}


def widths(fit):
    """Widths of the intervals of the parameters."""
    return np.diff(ends(fit), axis=0)[0]


def ends(fit):
    """Lower and upper ends of the intervals of the parameters, I, B, K or those of a study."""
    names = getattr(fit, "names", "IBK")
    return np.array([fit.intervals[name] for name in names]).T


def outcome(kind, seed, spoil):
    """``noted``, ``refused``, ``covered``, ``wide`` or ``silent``, for a spoiled record."""
    try:
        fit, truth = kind(np.random.default_rng(seed), spoil)
    except InputError:
        return "refused"
    if fit.notes:
        return "noted"
    low, high = ends(fit)
    if not ((low <= truth) & (truth <= high)).all():
        return "silent"
    clean, _ = kind(np.random.default_rng(seed))
    return "covered" if (widths(fit) < 1.5 * widths(clean)).all() else "wide"


def spoiled(seed, scale):
    """Print how many spoiled records of each kind are noted, refused, covered or silently wrong."""
    count = max(1, round(3 * scale))
    for number, (kind, spoils) in enumerate(SPOILS.items()):
        found = []
        for place, (name, spoil) in enumerate(spoils.items()):
            of_spoil = [outcome(kind, [seed, 100 + number, place, k], spoil) for k in range(count)]
            found += of_spoil
            print(f"{kind.__name__}, {name}: {', '.join(of_spoil)}", flush=True)
        good = sum(each in ("refused", "noted", "covered") for each in found)
        print(f"{kind.__name__}: {100.0 * good / len(found):.0f} % of {len(found)} refused, noted or covered")


def main() -> None:
    """Print every note on a valid record, and their share, or what happens to spoiled records."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scale", type=float, default=1.0, help="number of records relative to 236")
    parser.add_argument("--spoiled", action="store_true", help="spoil every record")
    chosen = parser.parse_args()
    if chosen.spoiled:
        spoiled(chosen.seed, chosen.scale)
        return
    total = noted = 0
    for number, (kind, count) in enumerate(KINDS.items()):
        for k in range(max(1, round(count * chosen.scale))):
            fit, _ = kind(np.random.default_rng([chosen.seed, number, k]))
            total, noted = total + 1, noted + bool(fit.notes)
            for note in fit.notes:
                print(f"{kind.__name__} {k}: {note}", flush=True)
        print(f"{kind.__name__}: done", file=sys.stderr)
    print(f"{noted} of {total} valid records have notes: {100.0 * noted / total:.1f} %")


if __name__ == "__main__":
    main()
