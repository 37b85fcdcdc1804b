"""Trials of the dummy for Monte Carlo studies: one exact motion, and markers and log drawn again and again.

The motion is integrated once per condition by the virtual laboratory, with its shipped constants unless
others are given. Instruments are redrawn: marker noise, trigger, clock, noise of the log, and what is
broken on purpose.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import yaml
from scipy.interpolate import CubicSpline

from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.io.trial import Signal, Trial
from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.reporting.recovery import TrueMotion, linear_truth
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.virtual_lab.belt import DriveTruth
from tepsipe.virtual_lab.dummy import DummyTruth, move_dummy
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.treadmill_trial import INTEGRATION_RATE_HZ, Protocol, schedule_trial

ROOT = Path(__file__).parents[1]
LAB = yaml.safe_load((ROOT / "config/virtual_lab.yaml").read_text(encoding="utf-8"))
LEG = Leg(mass_kg=0.4, com_m=0.4485, inertia_kgm2=0.027)
LABELS = ["foot1", "foot2", "foot3", "ankle", "leg1", "leg2", "leg3", "leg4"]
LAYOUT = [[0.0, 0.0], *LAB["dummy"]["markers"]["leg_m"]]
OPTIONS = DummyOptions(
    leg=LEG,
    leg_markers=SegmentMarkers(tuple(LABELS[3:]), LAYOUT),
    lowpass_cutoff_hz=20.0,
    lowpass_order=4,
    window=WindowOptions(6.0, 8.0, 0.5, 0.05, 5.0, 0.06),
    belt_fixed_labels=tuple(LABELS[:4]),
)
LINEAR_RUBBER = {
    "stiffness_Nm_per_rad": 10.0,
    "damping_Nms_per_rad": 0.1,
    "softening": 0.0,
    "softened_damping_Nms_per_rad": 0.0,
}
RATE_HZ, DURATION_S = 250.0, 70.0


@dataclass(frozen=True)
class Instruments:
    """Instruments that record a motion; the defaults are the shipped laboratory's.

    Attributes
    ----------
    marker_noise_m, log_noise_m_per_s : float
        Standard deviations (m; m/s, per sample of the log at 1000 Hz).
    clock_ppm : float
        Half width of the difference of the clocks' rates (1e-6).
    """

    marker_noise_m: float = LAB["treadmill"]["capture"]["noise_m"]
    log_noise_m_per_s: float = LAB["treadmill"]["drive"]["velocity_noise_m_per_s"]
    clock_ppm: float = 20.0


class Motion:
    """The exact motion of one condition."""

    def __init__(self, condition: str, rubber: dict | None = None):
        """Integrate a condition such as sine-0.3, with constants of the rubber that differ."""
        profile, amplitude = condition.split("-")
        self.condition, rig = condition, LAB["treadmill"]
        self.rubber = LAB["dummy"]["rubber"] | (rubber or {})
        dummy = DummyTruth(**LAB["dummy"]["subject"])
        rng = np.random.default_rng(1)
        schedule = schedule_trial(rig, Protocol(profile, float(amplitude), 4.0, DURATION_S), 8.0, rng)
        self.exact = move_dummy(
            dummy,
            Rubber(**self.rubber),
            DriveTruth(**rig["drive"]),
            schedule.command,
            schedule.ends_s,
            INTEGRATION_RATE_HZ,
        )
        self.starts_s = schedule.trigger_s + rig["capture"]["latency_s"] + 1.0 / RATE_HZ
        self.onsets_s = schedule.onsets_s - self.starts_s
        self.inertia = dummy.joint_inertia_kgm2
        self.instants = self.starts_s + np.arange(round(DURATION_S * RATE_HZ) - 1) / RATE_HZ

    @cached_property
    def foot(self) -> np.ndarray:
        """Position (m) at the markers' instants."""
        return CubicSpline(self.exact.time, self.exact.belt_position)(self.instants)

    @cached_property
    def foot_dd(self) -> np.ndarray:
        """Acceleration (m/s²) at the markers' instants."""
        return np.interp(self.instants, self.exact.time, self.exact.belt_acceleration)

    @cached_property
    def angle(self) -> np.ndarray:
        """Angle (rad) at the markers' instants."""
        return CubicSpline(self.exact.time, self.exact.angle)(self.instants)

    @cached_property
    def velocity(self) -> CubicSpline:
        """Velocity (m/s) of the belt."""
        return CubicSpline(self.exact.time, self.exact.belt_velocity)

    @property
    def small(self) -> np.ndarray:
        """True I, B, K of small movements."""
        names = ("damping_Nms_per_rad", "stiffness_Nm_per_rad")
        return np.array([self.inertia, *(self.rubber[name] for name in names)])

    def at_work(self, perturbations) -> np.ndarray:
        """True I, B, K of the nearest linear joint in the windows."""
        motion, time = self.exact, np.arange(self.instants.size) / RATE_HZ
        true = TrueMotion(
            motion.time - self.starts_s,
            motion.angle,
            motion.angle_rate,
            np.gradient(motion.angle_rate, motion.time),
            motion.joint_torque,
        )
        parameters = linear_truth(true, [(time[p.start], time[p.stop - 1]) for p in perturbations])
        return np.array(list(parameters.values()))

    def trial(
        self, rng: np.random.Generator, instruments: Instruments | None = None, broken: Callable | None = None
    ) -> Trial:
        """Markers and log of the motion.

        ``broken(positions, motion, rng)`` may change the positions (m), shape (n, 8, 2), before noise.
        """
        instruments = instruments or Instruments()
        positions = np.zeros((self.instants.size, len(LABELS), 3))
        across, along = np.vstack([np.zeros((3, 2)), LAYOUT]).T
        positions[:, :, 1] = self.foot[:, None] + np.outer(np.cos(self.angle), across)
        positions[:, :, 1] += np.outer(np.sin(self.angle), along)
        positions[:, :, 2] = np.outer(np.cos(self.angle), along) - np.outer(np.sin(self.angle), across)
        if broken is not None:
            positions[:, :, 1:] = broken(positions[:, :, 1:], self, rng)
        positions += instruments.marker_noise_m * rng.standard_normal(positions.shape)
        # the trigger falls anywhere between two samples of the log, and clocks differ
        late = rng.uniform(-0.0005, 0.0005) - LAB["treadmill"]["capture"]["latency_s"]
        rate = 1.0 + 1e-6 * rng.uniform(-instruments.clock_ppm, instruments.clock_ppm)
        log = self.velocity(self.starts_s + (self.instants - self.starts_s) * rate + late)
        # a log of four times the rate, limited to the band of the markers
        log = log + 0.5 * instruments.log_noise_m_per_s * rng.standard_normal(log.size)
        return Trial(
            rate_hz=RATE_HZ,
            axes={
                "time": np.arange(self.instants.size) / RATE_HZ,
                "marker": np.array(LABELS),
                "axis": np.array(["x", "y", "z"]),
            },
            signals={
                "belt_velocity": Signal(log, "m/s", ("time",), "velocity"),
                "marker_position": Signal(positions, "m", ("time", "marker", "axis"), "markers"),
                "marker_position_as_sampled": Signal(positions, "m", ("time", "marker", "axis"), "markers"),
            },
            attributes={},
        )


def with_leg(options: DummyOptions = OPTIONS, **changes) -> DummyOptions:
    """Options that assume another leg (kg, m, kg·m²)."""
    return replace(options, leg=replace(options.leg, **changes))
