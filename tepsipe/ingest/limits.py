"""Limits of the signals of a trial, and the stated contents of its rig."""

from dataclasses import dataclass

from tepsipe.io.trial import Trial


@dataclass(frozen=True)
class Limits:
    """Plausible range of each kind of signal: (lowest, highest)."""

    rate_hz: tuple[float, float]
    belt_velocity_m_per_s: tuple[float, float]
    belt_acceleration_m_per_s2: tuple[float, float]
    """Motion of the belt."""
    marker_position_m: tuple[float, float]
    """Every coordinate of a marker."""
    marker_speed_m_per_s: float
    """Highest speed of a marker from sample to sample."""
    force_N: tuple[float, float]
    moment_Nm: tuple[float, float]
    """Load of a force plate or of a treadmill."""
    angle_rad: tuple[float, float]
    torque_Nm: tuple[float, float]
    """Angle and torque of a joint in a manipulator."""
    joint_speed_rad_per_s: float
    """Angular velocity of a joint that 0.1 % of the samples may exceed."""
    torque_per_angle_Nm_per_rad: tuple[float, float]
    """Standard deviation of the torque over the standard deviation of the angle."""
    emg_uV: tuple[float, float]
    """Raw electromyogram (uV)."""
    frozen_s: float
    """Longest stretch of identical samples of a noisy channel."""
    belt_fixed_correlation: float
    """Lowest correlation between the velocities of a belt-fixed marker and of the belt."""
    belt_fixed_scale: tuple[float, float]
    """Ratio s of the two velocities."""
    belt_fixed_delay_s: float
    """Longest delay d between the two, in either direction."""
    accelerated_fraction: float
    """Lowest share of the mass on the belt that the fore-aft force accelerates with it."""


@dataclass(frozen=True)
class Rig:
    """Stated contents of the trial; unknown ones may be omitted."""

    belt: str | None = None
    """Belt that carries something: its force plate must be alive."""
    carried_kg: tuple[float, float] | None = None
    """Lowest and highest mass on that belt."""
    mass_key: str = "the masses in the configuration"
    """Where this mass is stated, for messages."""
    belt_fixed: tuple[str, ...] = ()
    """Belt-fixed markers."""
    segments: dict[str, tuple[str, ...]] | None = None
    """Segment -> its markers, which must move when the belt does."""
    person: bool = False
    """Whether a person stands on the belt: a step moves the foot, and stretches in which a marker is frozen
    are marked as hidden, so that their perturbations are left out."""


def source(files: dict[str, str], *kinds: str) -> str:
    """Path of the first of these kinds of file that is present, otherwise of the first of all."""
    return next(
        (str(files[kind]) for kind in kinds if kind in files), str(next(iter(files.values()), "trial"))
    )


def used_belt(trial: Trial, rig: Rig) -> int | None:
    """Index of the belt in use on the axis of the trial's plates, or None."""
    if rig.belt is None or "force" not in trial.signals:
        return None
    belts = trial.axes["belt"].tolist()
    return belts.index(rig.belt) if rig.belt in belts else None
