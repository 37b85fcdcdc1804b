"""A rigid person who stands on a moving belt, and responses with a known impedance, made without the library.

The person is one inverted pendulum on feet that do not turn; its ankles' torque is K, B and what balances it
at rest. Markers, plate and electromyograms are those of an ideal laboratory: no noise but the muscles' own.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
from emg_builders import EMG_RATE_HZ, emg, ramp_burst
from scipy.integrate import solve_ivp

from tepsipe.experiments.standing.epochs import StandingEpochs
from tepsipe.experiments.standing.options import EpochOptions, Person, StanceLimits, StandingOptions
from tepsipe.io.trial import Signal, Trial
from tepsipe.mechanics.anthropometry import both_feet, standing_body
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.signals.emg import EmgOptions
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions

G = 9.81
MASS_KG, STATURE_M, COM_HEIGHT = 64.0, 1.75, 0.55
Z_A, FOOT_COM_M = 0.08, 0.05  # height of the ankles, feet's centre of mass in front of them (m)
ANKLE_M = 0.12  # where the ankles stand on the plate (m)
KNEE_M = 0.42  # knee above the ankle (m): only markers depend on it
STIFFNESS, DAMPING = 800.0, 60.0  # more than m g h = 555 Nm/rad: the person stands without reflexes
LEAN_RAD = 0.05
RATE_HZ = 250.0
PULSE_S = 0.1
# between samples, and at unequal distances
ONSETS_S = (5.0013, 9.4037, 14.1002, 18.3359, 22.9181, 27.2007)
DURATION_S = 33.0
MUSCLES = ("TA", "SOL", "GAS")
LATENCY_S = {"TA": 0.044, "SOL": 0.042, "GAS": 0.05}
REST_UV, BURST_UV, LIMIT_UV = 3.0, 60.0, 2343.0

LAYOUT = {
    "foot": {"foot1": (0.14, -0.05), "foot2": (-0.05, -0.05), "ankle": (0.0, 0.0)},
    "shank": {"ankle": (0.0, 0.0), "shank1": (0.025, 0.37), "shank2": (-0.02, 0.16)},
    "thigh": {"thigh1": (0.03, 0.3), "thigh2": (-0.03, 0.18), "thigh3": (0.03, 0.06)},
}
LABELS = ("foot1", "foot2", "ankle", "shank1", "shank2", "thigh1", "thigh2", "thigh3")
PERSON = Person(
    mass_kg=MASS_KG,
    feet=both_feet(MASS_KG, STATURE_M),
    body=standing_body(MASS_KG, STATURE_M, COM_HEIGHT, Z_A, G),
    foot_com_m=FOOT_COM_M,
    ankle_height_m=Z_A,
    **{
        segment: SegmentMarkers(tuple(places), np.array(list(places.values())))
        for segment, places in LAYOUT.items()
    },
)
OPTIONS = StandingOptions(
    person=PERSON,
    belt="right",
    lowpass=Lowpass(20.0, 4, True),
    stretch_cutoff_hz=60.0,
    window=WindowOptions(4.0, 4.0, 0.5, 0.05, 5.0, 0.06),
    quiet_after_s=2.0,
    limits=StanceLimits(
        foot_shift_m=0.03, foot_lift_m=0.02, other_belt=0.05, unloading=0.3, unloading_s=0.1, lean_rad=0.2
    ),
)
CUTTING = EpochOptions(
    before_s=0.3,
    after_s=1.0,
    baseline_s=(-0.1, -0.02),
    least_perturbations=4,
    max_gap_s=0.1,
    lowpass_cutoff_hz=20.0,
    lowpass_order=4,
    emg=EmgOptions(),
    line_hz=50.0,
)


# ---- the person's motion -------------------------------------------------------------------------


def sine_pulses(time, onsets_s, peak_m_per_s, pulse_s=PULSE_S):
    """Belt position (m), velocity (m/s) and acceleration (m/s2): one period of a sine per onset."""
    position, velocity, acceleration = np.zeros((3, *np.shape(time)))
    omega = 2.0 * np.pi / pulse_s
    for onset in onsets_s:
        phase = omega * (time - onset)
        inside = (phase >= 0.0) & (phase <= 2.0 * np.pi)
        position = position + np.where(inside, (1.0 - np.cos(phase)) * peak_m_per_s / omega, 0.0)
        velocity = velocity + np.where(inside, np.sin(phase) * peak_m_per_s, 0.0)
        acceleration = acceleration + np.where(inside, np.cos(phase) * peak_m_per_s * omega, 0.0)
    return position, velocity, acceleration


@dataclass(frozen=True)
class Stance:
    """How a person stands: K (Nm/rad), B (Nms/rad); onsets (s), peak (m/s) and length (s) of the pulses."""

    stiffness: float = STIFFNESS
    damping: float = DAMPING
    onsets_s: tuple = ONSETS_S
    peak_m_per_s: float = 0.4
    pulse_s: float = PULSE_S
    duration_s: float = DURATION_S

    def belt(self, time):
        """Belt position (m), velocity (m/s) and acceleration (m/s2)."""
        return sine_pulses(time, self.onsets_s, self.peak_m_per_s, self.pulse_s)

    def belt_acceleration(self, t):
        """Belt acceleration (m/s2) at one instant."""
        omega = 2.0 * math.pi / self.pulse_s
        inside = (onset for onset in self.onsets_s if 0.0 <= t - onset <= self.pulse_s)
        return sum(math.cos(omega * (t - onset)) * self.peak_m_per_s * omega for onset in inside)

    def angular_acceleration(self, belt, th, w, sin=np.sin, cos=np.cos):
        """Of a pendulum whose ankles bear its weight at rest, on an accelerated belt (m/s2, rad/s2)."""
        m, h = PERSON.body.mass_kg, PERSON.body.com_m
        resisted = m * G * h * math.sin(LEAN_RAD) + self.stiffness * (th - LEAN_RAD) + self.damping * w
        moment = m * G * h * sin(th) - m * h * belt * cos(th)
        return (moment - resisted) / (PERSON.body.inertia_kgm2 + m * h**2)


USUAL = Stance()


@lru_cache(maxsize=8)
def _swaying(stance):
    """Dense solution (rad, rad/s) of the person's motion, from edge to edge of the pulses."""
    edges = np.unique(
        [0.0, stance.duration_s, *[t + d for t in stance.onsets_s for d in (0.0, stance.pulse_s)]]
    )
    pieces, state = [], (LEAN_RAD, 0.0)
    for start, stop in pairwise(edges):

        def rates(t, x, first=start + 1e-9, last=stop - 1e-9):
            # at an edge the belt's acceleration jumps: each piece has its own side of it
            th, w = x.tolist()  # numbers of Python are several times as fast, one by one
            belt = stance.belt_acceleration(min(max(t, first), last))
            return w, stance.angular_acceleration(belt, th, w, math.sin, math.cos)

        piece = solve_ivp(
            rates, (start, stop), state, "DOP853", dense_output=True, rtol=1e-9, atol=1e-12, max_step=0.05
        )
        pieces.append(piece.sol)
        state = piece.y[:, -1]
    return edges, pieces


def sway(stance, time):
    """Angle (rad) of a person, its rate (rad/s) and acceleration (rad/s2)."""
    edges, pieces = _swaying(stance)
    at = np.clip(time, 0.0, stance.duration_s)
    which = np.clip(np.searchsorted(edges, at, side="right") - 1, 0, len(pieces) - 1)
    th, w = np.empty((2, at.size))
    for k in np.unique(which):
        th[which == k], w[which == k] = pieces[k](at[which == k])
    return th, w, stance.angular_acceleration(stance.belt(at)[2], th, w)


def plate_wrench(stance, time):
    """Fy, Fz (N) and Mx (Nm) on the feet: rates of the momenta of feet and body about the plate's origin."""
    m_f, body = PERSON.feet.mass_kg, PERSON.body
    m, h = body.mass_kg, body.com_m
    th, w, w_rate = sway(stance, time)
    y_belt, _, y_dd = stance.belt(time)
    y = ANKLE_M + y_belt + h * np.sin(th)
    z = Z_A + h * np.cos(th)
    y_com_dd = y_dd + h * (np.cos(th) * w_rate - np.sin(th) * w**2)
    z_com_dd = -h * (np.sin(th) * w_rate + np.cos(th) * w**2)
    f_y = m_f * y_dd + m * y_com_dd
    f_z = m_f * G + m * (G + z_com_dd)
    m_x = m_f * (ANKLE_M + y_belt + FOOT_COM_M) * G - m_f * 0.5 * Z_A * y_dd
    m_x = m_x + m * (y * (G + z_com_dd) - z * y_com_dd) - body.inertia_kgm2 * w_rate
    return f_y, f_z, m_x


def true_torque(stance, time):
    """The ankles' torque (Nm)."""
    th, w, _ = sway(stance, time)
    at_rest = PERSON.body.mass_kg * G * PERSON.body.com_m * np.sin(LEAN_RAD)
    return at_rest + stance.stiffness * (th - LEAN_RAD) + stance.damping * w


# ---- what is recorded of it ------------------------------------------------------------------------


def marker_positions(stance, time, toe_rad=0.0, knee_rad=0.0):
    """x, y, z of every marker (m), shape (n, markers, 3); feet and thighs may be tilted against the rest."""
    th = sway(stance, time)[0]
    y_a = ANKLE_M + stance.belt(time)[0]
    knee = y_a + KNEE_M * np.sin(th), Z_A + KNEE_M * np.cos(th)
    pose = {
        "foot": (y_a, Z_A, 0.0 * th + toe_rad),
        "shank": (y_a, Z_A, th),
        "thigh": (*knee, th + knee_rad),
    }
    positions = np.zeros((time.size, len(LABELS), 3))
    for segment, places in LAYOUT.items():
        y, z, tilt = pose[segment]
        for label, (across, along) in places.items():
            k = LABELS.index(label)
            positions[:, k, 1] = y + across * np.cos(tilt) + along * np.sin(tilt)
            positions[:, k, 2] = z - across * np.sin(tilt) + along * np.cos(tilt)
    return positions


def activity(stance, rng):
    """Instants (s) and raw electromyograms (uV), shape (k, muscles): a burst a latency after every onset."""
    time = np.arange(round((stance.duration_s + 1.0) * EMG_RATE_HZ)) / EMG_RATE_HZ - 0.4996
    envelope = np.full((len(MUSCLES), time.size), REST_UV)
    for row, muscle in zip(envelope, MUSCLES, strict=True):
        for onset in stance.onsets_s:
            row += BURST_UV * ramp_burst(time, onset + LATENCY_S[muscle])
    return time, emg(envelope, rng).T


def standing_trial(stance=USUAL, delay_s=0.0, seed=1, **tilts):
    """The trial of a person whose markers lag behind; ``tilts`` are those of `marker_positions`."""
    # ingest drops the first frame
    time = np.arange(1, round(stance.duration_s * RATE_HZ)) / RATE_HZ
    force, moment = np.zeros((2, time.size, 2, 3))
    force[:, 1, 1], force[:, 1, 2], moment[:, 1, 0] = plate_wrench(stance, time)
    emg_time, voltages = activity(stance, np.random.default_rng(seed))
    markers = marker_positions(stance, time - delay_s, **tilts)
    signals = {
        "belt_velocity": (stance.belt(time)[1], "m/s", ("time",)),
        "marker_position": (markers, "m", ("time", "marker", "axis")),
        "marker_hidden": (np.zeros(markers.shape[:2], dtype=bool), "1", ("time", "marker")),
        "force": (force, "N", ("time", "belt", "axis")),
        "moment": (moment, "Nm", ("time", "belt", "axis")),
        "emg": (voltages.astype(np.float32), "uV", ("emg_time", "muscle")),
    }
    return Trial(
        rate_hz=RATE_HZ,
        axes={
            "time": time,
            "marker": np.array(LABELS),
            "belt": np.array(["left", "right"]),
            "axis": np.array(["x", "y", "z"]),
            "emg_time": emg_time,
            "muscle": np.array(MUSCLES),
        },
        signals={name: Signal(*values, name) for name, values in signals.items()},
        attributes={
            "emg_rate_hz": EMG_RATE_HZ,
            "emg_limits_uV": np.array([[-LIMIT_UV, LIMIT_UV]] * len(MUSCLES)),
            "emg_missing": "",
        },
    )


def with_signal(trial, name, change):
    """The trial with a copy of one signal that ``change`` has altered in place."""
    values = trial.values(name).copy()
    change(values)
    changed = replace(trial.signals[name], values=values)
    return replace(trial, signals={**trial.signals, name: changed})


# ---- responses with a known impedance ------------------------------------------------------------

RESPONSE_TIME = np.arange(-75, 251) / RATE_HZ
FINE_PER_SAMPLE = 40  # of time in which active torque is simulated
SIZES = (1.0, 0.9, 1.1, 0.95, 1.05, 1.0)


def bent(time, start_s=0.0):
    """Angle (rad), its rate (rad/s) and acceleration (rad/s2) of an ankle that bends and comes back.

    Two bumps 64 a u^3 (1 - u)^3, u from 0 to 1: one of 0.12 s, and one of 0.35 s the other way.
    """
    angle, rate, acceleration = np.zeros((3, *np.shape(time)))
    for size, begins, lasts in ((1.0, 0.0, 0.12), (-0.6, 0.05, 0.35)):
        u = np.clip((time - start_s - begins) / lasts, 0.0, 1.0)
        p, a = u * (1.0 - u), 0.02 * 64.0 * size
        slope = 1.0 - 2.0 * u
        angle = angle + a * p**3
        rate = rate + a * 3.0 * p**2 * slope / lasts
        acceleration = acceleration + a * (6.0 * p * slope**2 - 6.0 * p**2) / lasts**2
    return angle, rate, acceleration


def twitched(drive, twitch_s):
    """Force of a critically damped twitch after a drive that is a function of time, at `RESPONSE_TIME`.

    The convolution with t / T^2 exp(-t / T), on time that is 40 times as fine.
    """
    step = 1.0 / (RATE_HZ * FINE_PER_SAMPLE)
    fine = RESPONSE_TIME[0] + np.arange((RESPONSE_TIME.size - 1) * FINE_PER_SAMPLE + 1) * step
    t = (np.arange(fine.size) + 0.5) * step
    force = np.convolve(drive(fine), t / twitch_s**2 * np.exp(-t / twitch_s))[: fine.size] * step
    return force[::FINE_PER_SAMPLE]


def responses_with(torque, drive=None, sizes=SIZES, start_s=0.0, beside=0.0, noise=None, quiet=5):
    """Responses whose ankle bends like `bent`, times ``sizes``, under a torque (Nm) at `RESPONSE_TIME`.

    ``drive`` is muscle -> rectified electromyogram (uV). Unperturbed standing shows ``beside`` (Nm) too.
    ``noise`` makes so many rows of torque (Nm).
    """
    sizes = np.asarray(sizes)[:, None]
    noise = noise or (lambda rows: np.zeros((rows, RESPONSE_TIME.size)))
    motion = dict(zip(("ankle", "ankle_d", "ankle_dd"), bent(RESPONSE_TIME, start_s), strict=True))
    perturbed = {key: sizes * x for key, x in motion.items()}
    unperturbed = {key: np.zeros((quiet, x.size)) for key, x in motion.items()}
    perturbed["torque/ankle"] = sizes * torque + beside + noise(len(sizes))
    unperturbed["torque/ankle"] = beside + noise(quiet)
    perturbed["belt_velocity"] = sizes * sine_pulses(RESPONSE_TIME, (0.0,), 0.4)[1]
    unperturbed["belt_velocity"] = np.zeros((quiet, RESPONSE_TIME.size))
    muscles = tuple(drive or ())
    drives = np.array([drive[muscle] for muscle in muscles]).reshape(-1, RESPONSE_TIME.size).T
    emg_time = np.arange(-300, 1001) / EMG_RATE_HZ
    return StandingEpochs(
        time=RESPONSE_TIME,
        perturbed=perturbed,
        unperturbed=unperturbed,
        stretch={"ankle": perturbed["ankle_d"], "knee": 0.0 * perturbed["ankle_d"]},
        muscles=muscles,
        drive=sizes[..., None] * drives,
        unperturbed_drive=np.zeros((quiet, *drives.shape)),
        envelope=sizes[..., None] * drives,
        emg_time=emg_time,
        emg=np.zeros((len(sizes), emg_time.size, len(muscles))),
        usable=np.ones((len(sizes), len(muscles)), dtype=bool),
        unperturbed_usable=np.ones((quiet, len(muscles)), dtype=bool),
        onsets_s=5.0 + 4.0 * np.arange(len(sizes)),
        left_out=(),
    )
