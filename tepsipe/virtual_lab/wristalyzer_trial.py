"""One trial of the Wristalyzer experiment, from its protocol and the laboratory's truth to raw files.

The torque-controlled manipulator (Wristalyzer) with the ankle dummy's foot strapped to its handle.

Symbols: th handle angle (rad), w its rate (rad/s), tau commanded torque (N·m). The rod is fixed to
the arm rest, so the foot and the handle turn as one body against the rubber:

    J w' = tau + ripple - rubber(th, w) - contact * th^3 - Fc tanh(w / ws)
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import scipy
from annotated_types import Ge, Gt, Le

from tepsipe.quantities import Angle, Frequency, NotNegative, Pause, Positive, Rate, Time
from tepsipe.virtual_lab.integrate import integrate
from tepsipe.virtual_lab.rubber import Memory, Rubber
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.truth_file import TrueMotion, write_true_motion


@dataclass(frozen=True)
class ManipulatorTruth:
    """The torque-controlled manipulator."""

    inertia_kgm2: Annotated[float, Gt(0), Le(20)]
    """Inertia of foot and handle about the joint."""
    contact_Nm_per_rad3: Annotated[NotNegative, "N·m/rad³"]
    """Hardening at large angles, where the rubber is pressed against the brick."""
    friction_Nm: NotNegative
    """Coulomb friction of the drive train."""
    friction_rate_rad_per_s: Positive
    """Rate at which it saturates."""
    ripple_Nm: NotNegative
    """Torque ripple: root mean square."""
    ripple_bandwidth_hz: Frequency
    """Its bandwidth."""
    torque_per_factor_Nm: Annotated[float, Gt(0), Le(5000)]
    """Root mean square of the multisine per unit of scale factor."""
    torque_scale: Annotated[float, Gt(0), Le(10)]
    """True over commanded torque."""
    angle_scale: Annotated[float, Gt(0), Le(10)]
    """Reading over true angle."""
    torque_delay_s: Annotated[float, Ge(-1), Le(1)]
    """Delay of the torque after its command."""
    band_low_hz: Frequency
    """Lowest component of the multisine."""
    band_high_hz: Frequency
    """Highest component of the multisine."""
    period_s: Time
    """Its period."""
    command_rate_hz: Rate
    """Rate of the torque command."""
    log_rate_hz: Rate
    """Mean rate of the log."""
    log_jitter_s: Annotated[float, Ge(0), Le(10)]
    """Standard deviation of its instants."""
    repeated_fraction: NotNegative
    """Fraction of the log's lines that repeat the preceding sample."""
    missing_fraction: NotNegative
    """Fraction of the log's lines that are not written."""
    encoder_step_rad: Annotated[float, Gt(0), Le(3.2)]
    """Resolution of the angle."""
    encoder_zero_rad: Angle
    """Its reading at rest."""
    lead_s: Pause
    """Time logged before the trigger."""
    tail_s: Pause
    """Time logged after the command."""


@dataclass(frozen=True)
class ManipulatorRecording:
    """Contents of the manipulator's two files."""

    log_time: Annotated[np.ndarray, "(n,)", "s"]
    """Time stamps of the log's lines, on the log's own clock."""
    angle: Annotated[np.ndarray, "(n,)", "rad"]
    """Encoder readings."""
    trigger_time: Annotated[float, "s"]
    """Stamp, on the log's clock, at which the command started."""
    command: Annotated[np.ndarray, "(m,)", "N·m"]
    """Torque command from the trigger on."""
    command_rate_hz: float
    motion: TrueMotion | None
    """Hidden motion of the handle and the torque on it, including the drive's ripple (s, rad, N·m); None
    where only the two files are written."""


def multisine(
    truth: ManipulatorTruth, duration_s: float, rng: np.random.Generator
) -> Annotated[np.ndarray, "(duration_s * command_rate_hz,)"]:
    """Random-phase multisine of unit root mean square.

    truth: band, period and rate of the command.
    duration_s: length (s); the last period may be cut.
    Returns: the signal.
    """
    harmonics = np.arange(
        round(truth.band_low_hz * truth.period_s), round(truth.band_high_hz * truth.period_s) + 1
    )
    samples = round(truth.period_s * truth.command_rate_hz)
    spectrum = np.zeros(samples // 2 + 1, dtype=complex)
    spectrum[harmonics] = np.exp(1j * rng.uniform(0.0, 2.0 * np.pi, harmonics.size))
    period = np.fft.irfft(spectrum, samples)
    period /= period.std()
    total = round(duration_s * truth.command_rate_hz)
    return np.resize(period, total)


def record_manipulator(
    truth: ManipulatorTruth,
    rubber: Rubber,
    factor: float,
    duration_s: float,
    signal_rng: np.random.Generator,
    trial_rng: np.random.Generator,
) -> ManipulatorRecording:
    """Perturb the dummy's joint and log the signals of the instruments.

    factor: scale factor of the perturbation.
    duration_s: length of the perturbation.
    signal_rng, trial_rng: draw the multisine's phases (the same in every trial) and this trial's noise.
    Returns: contents of the two files.
    """
    rate = truth.command_rate_hz
    command = factor * truth.torque_per_factor_Nm * multisine(truth, duration_s, signal_rng)
    lead = round(truth.lead_s * rate)
    instants = np.arange(command.size, dtype=float)
    late = np.interp(instants - rate * truth.torque_delay_s, instants, command, left=0.0)
    pushed = truth.torque_scale * late
    applied = np.concatenate([np.zeros(lead), pushed, np.zeros(round(truth.tail_s * rate) + 1)])
    white = trial_rng.standard_normal(applied.size)
    ripple = scipy.signal.sosfilt(
        scipy.signal.butter(1, truth.ripple_bandwidth_hz, fs=rate, output="sos"), white
    )
    applied = applied + truth.ripple_Nm * ripple / ripple.std()

    memory = Memory(rubber)
    moment = memory.moment if memory.states else rubber.moment

    inertia, contact = truth.inertia_kgm2, truth.contact_Nm_per_rad3
    coulomb, slow, tanh = truth.friction_Nm, truth.friction_rate_rad_per_s, math.tanh

    def derivative(pushing: float, state: tuple[float, ...]) -> tuple[float, ...]:
        th, w = state
        added = contact * th * th * th + coulomb * tanh(w / slow)
        return w, (pushing - (moment(th, w) + added)) / inertia

    steps = math.ceil((truth.lead_s + duration_s + truth.tail_s) * rate)
    # each torque is held until the next
    held = applied[np.minimum(np.arange(steps + 1), applied.size - 1)]
    inputs = np.column_stack([held[:-1], held[:-1], held[1:]])
    if memory.states:
        derivative = memory.with_states(derivative, lambda state: state)
    time, states = integrate(derivative, (0.0, 0.0, *memory.at_rest(0.0)), inputs, rate)
    th, w = states[:, :2].T
    # the last stage of a Runge-Kutta step, which counts one sixth, is at the next instant; the torque of an
    # instant is the mean of the steps around it
    acting = (5.0 * held + np.concatenate([held[1:], held[-1:]])) / 6.0
    torque = 0.5 * (acting + np.concatenate([acting[:1], acting[:-1]]))
    motion = TrueMotion(time - truth.lead_s, th, w, np.gradient(w, time), torque)
    return _log(truth, time, states, command, trial_rng, motion)


def _log(
    truth: ManipulatorTruth,
    time: np.ndarray,
    states: np.ndarray,
    command: np.ndarray,
    rng: np.random.Generator,
    motion: TrueMotion,
) -> ManipulatorRecording:
    """Sample the angle irregularly, as the operating system of the logging computer does."""
    step = 1.0 / truth.log_rate_hz
    instants = np.arange(step, time[-1] - step, step)
    instants = instants + np.clip(rng.normal(0.0, truth.log_jitter_s, instants.size), -0.4 * step, 0.4 * step)
    angle = scipy.interpolate.CubicHermiteSpline(time, states[:, 0], states[:, 1])(instants)
    angle *= truth.angle_scale
    angle = truth.encoder_step_rad * np.round(angle / truth.encoder_step_rad)
    angle += truth.encoder_zero_rad
    repeated = rng.random(instants.size) < truth.repeated_fraction
    repeated[0] = False
    source = np.where(repeated, np.arange(instants.size) - 1, np.arange(instants.size))
    written = rng.random(instants.size) >= truth.missing_fraction
    started = 1000.0 * rng.random()
    return ManipulatorRecording(
        log_time=(started + instants[source])[written],
        angle=angle[source][written],
        trigger_time=started + truth.lead_s,
        command=command,
        command_rate_hz=truth.command_rate_hz,
        motion=motion,
    )


def write_dflow_log(path: Path, recording: ManipulatorRecording) -> None:
    """Write the manipulator's log: tab-separated text, stamps in s, angle in rad, torque in N·m.

    ``TriggerTime`` is 0 until the command starts, then the stamp at which it did.
    """
    started = recording.log_time >= recording.trigger_time
    trigger = np.where(started, recording.trigger_time, 0.0)
    lines = ["TimeStamp\tFrameNumber\tMotorAngle\tTriggerTime\n"]
    rows = zip(recording.log_time.tolist(), recording.angle.tolist(), trigger.tolist(), strict=True)
    lines += [f"{t:.6f}\t{k}\t{a:.8f}\t{c:.6f}\n" for k, (t, a, c) in enumerate(rows)]
    path.write_text("".join(lines))


def write_torque_command(path: Path, recording: ManipulatorRecording) -> None:
    """Write the torque command: tab-separated text, time from the trigger in s, torque in N·m."""
    lines = ["Time\tTorqueCommand\n"]
    step = 1.0 / recording.command_rate_hz
    lines += [f"{k * step:.9f}\t{tau:.8f}\n" for k, tau in enumerate(recording.command.tolist())]
    path.write_text("".join(lines))


def make_wristalyzer_trial(
    truth: dict, condition: str, amplitude: float, duration_s: float, files: dict[str, Path]
) -> None:
    """Make one trial of the Wristalyzer experiment.

    truth: the laboratory's constants, as its configuration file holds them.
    condition: name of the condition: it seeds the trial's noise.
    amplitude: scale factor of the perturbation.
    duration_s: length of the perturbation.
    files: files to write: ``log`` and ``command``, the torque, and ``motion``, the hidden motion of the
    handle, if it is wanted.
    """
    seed = truth["seed"]
    recording = record_manipulator(
        ManipulatorTruth(**truth["wristalyzer"]["manipulator"]),
        Rubber(**truth["dummy"]["rubber"]),
        amplitude,
        duration_s,
        generator(seed, "wristalyzer", "multisine"),
        generator(seed, "wristalyzer", condition),
    )
    write_dflow_log(files["log"], recording)
    write_torque_command(files["command"], recording)
    if "motion" in files:
        write_true_motion(files["motion"], recording.motion)
