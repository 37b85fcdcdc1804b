"""Agreement of the signals of a trial with each other: mass, force, belt-fixed markers, torque and angle.

Symbols: y(t) position of a belt-fixed marker along the belt (m), v(t) velocity of the belt (m/s), s scale, d
delay (s):

    y'(t + d) = s v(t)

A marker that is fixed to the belt has s = 1 but for noise, and a correlation near 1 with the belt. The belt
accelerates at least the feet of what stands on it: the regression of the fore-aft force on its acceleration
is a mass of 9 to 11 % of a simulated person, and of 95 % and more of a weight or a dummy. The work
that a torque does on a passive joint, the integral of torque times angular velocity, is positive.
"""

import math

import numpy as np

from tepsipe.errors import InputError
from tepsipe.ingest.limits import Limits, Rig, held_while_moving, source, used_belt
from tepsipe.io.trial import Trial
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.resampling import resample

GRAVITY_M_PER_S2 = 9.81
# motion of markers and belt is compared below this frequency (Hz)
COMPARED_HZ = 20.0
# markers or belt move above this fraction of their highest speed
MOVING_FRACTION = 0.1
# plausible highest speed of a command, and of a belt, over the stated amplitude: drives fall short of their
# command, by 15 to 20 % in pulses of 0.1 s
COMMAND_PER_STATED, BELT_PER_STATED = (0.8, 1.25), (0.6, 1.25)
# smallest ratio of a pulse's peak to the noise around it
PULSE_TO_NOISE = 8.0
# ratio of a segment's speed during the belt's motion to its speed before, above which it moves
STILL_RATIO = 1.3
# the torque is against the motion below this correlation of torque and angular velocity
AGAINST_MOTION = -0.05
# percentile of a joint's speed that is compared
FAST_PERCENTILE = 99.9
# a belt with less on it carries nothing (kg)
LEAST_LOAD_KG = 1.5
# feet on two belts stand farther apart than this, and a centre of pressure below a foot is this close to its
# markers, across the belts (m)
APART_M, BELOW_M = 0.1, 0.08
# parts of a trial whose masses are compared
MASS_PARTS = 4
# on a belt that is faster than this most of the time, a person walks
WALKING_M_PER_S = 0.2


def refuse_mass(trial: Trial, rig: Rig, files: dict[str, str]) -> None:
    """Compare the mean vertical force of the trial with the stated mass on the belt.

    rig: stated contents of the trial.
    files: kind of each source file -> its path, for messages.
    """
    belt = used_belt(trial, rig)
    if belt is None or rig.carried_kg is None:
        return
    low, high = rig.carried_kg
    vertical = trial.values("force")[:, belt, 2].astype(float) / GRAVITY_M_PER_S2
    mass = float(vertical.mean())
    if not low <= mass <= high:
        raise InputError(
            f"{source(files, 'log')}: expected {low:.3g} to {high:.3g} kg on the {rig.belt} belt, found "
            f"{mass:.4g} kg by the mean vertical force: check the calibration matrix and its unit, that this "
            "file is that of the trial, that the plate was not set to zero under its load, and "
            f"{rig.mass_key}"
        )
    parts = [float(part.mean()) for part in np.array_split(vertical, MASS_PARTS)]
    if max(parts) - min(parts) > 0.5 * (high - low):
        raise InputError(
            f"{source(files, 'log')}: expected the same mass on the {rig.belt} belt throughout, found "
            f"{min(parts):.3g} to {max(parts):.3g} kg by the mean vertical force in its quarters: "
            "check the range and the amplifier of the plate, and that nothing touched the belt"
        )


def refuse_other_force(trial: Trial, limits: Limits, rig: Rig, files: dict[str, str]) -> None:
    """Compare the fore-aft force of a loaded belt that is still between pulses with its acceleration.

    limits: lowest share of the mass on the belt that the force accelerates.
    rig: stated contents of the trial.
    files: kind of each source file -> its path, for messages.
    """
    belt = used_belt(trial, rig)
    if belt is None or "belt_velocity" not in trial.signals or trial.rate_hz <= 2.0 * COMPARED_HZ:
        return
    velocity = _lowpass(trial, trial.values("belt_velocity"))
    usual = np.median(velocity)
    if abs(usual) > WALKING_M_PER_S:  # the forces of the steps are larger than those of pulses
        return
    load = float(trial.values("force")[:, belt, 2].mean(dtype=float)) / GRAVITY_M_PER_S2
    if load < LEAST_LOAD_KG or not _stands_out(velocity - usual):
        return
    acceleration = derivative(trial.time, velocity)
    moving = np.abs(acceleration) > MOVING_FRACTION * np.abs(acceleration).max()
    force = _lowpass(trial, trial.values("force")[:, belt, 1].astype(float))
    a, f = (x[moving] - x[moving].mean() for x in (acceleration, force))
    moved = float(a @ f / (a @ a))
    least = limits.accelerated_fraction * load
    if moved < least:
        raise InputError(
            f"{source(files, 'log')}: expected the fore-aft force Fy of the {rig.belt} belt to accelerate at "
            f"least {least:.2g} of the {load:.3g} kg on it, found {moved:.2g} kg by the acceleration of the "
            "belt: check sign, axes, range and trigger of the force plate, or change "
            "plausible.accelerated_fraction in the configuration"
        )


def other_amplitude(trial: Trial, rig: Rig) -> bool:
    """Test for a command, or without one a belt, that is faster or slower than its stated amplitude (m/s).

    Noise raises the highest speed as recorded, and a low-pass reduces that of short pulses: too fast means
    that both are, and too slow as well.
    """
    if rig.amplitude_m_per_s is None or "belt_velocity" not in trial.signals:
        return False
    if trial.rate_hz <= 2.0 * COMPARED_HZ or not _stands_out(_lowpass(trial, trial.values("belt_velocity"))):
        return False  # the analysis finds no perturbation
    commanded = "belt_command" in trial.signals
    recorded = trial.values("belt_command" if commanded else "belt_velocity")
    highest = [np.abs(v - np.median(v)).max() for v in (recorded, _lowpass(trial, recorded))]
    low, high = COMMAND_PER_STATED if commanded else BELT_PER_STATED
    stated = rig.amplitude_m_per_s
    return bool(max(highest) < low * stated or min(highest) > high * stated)


def sides_of_plates(trial: Trial, rig: Rig) -> tuple[bool | None, str]:
    """Compare the plates of a person with a foot on each belt with the sides on which their loads act.

    The centre of pressure of the left plate must lie left of that of the right one. It is known across the
    belts only in the axes of the markers, so one of both must lie below the foot that carries markers.

    rig: stated contents of the trial.
    Returns: True if the plates are exchanged, None if nothing tells it, and a sentence; empty for others than
    a person on two belts.
    """
    labels, belts = (
        trial.axes.get("marker", np.empty(0)).tolist(),
        trial.axes.get("belt", np.empty(0)).tolist(),
    )
    foot = [labels.index(label) for label in rig.belt_fixed if label in labels]
    if not rig.person or rig.belt in (None, *belts) or len(belts) != 2 or not foot:
        return None, ""
    load = trial.values("force")[:, :, 2].mean(axis=0, dtype=float)
    if load.min() < LEAST_LOAD_KG * GRAVITY_M_PER_S2:
        return None, "cannot be told: one of the plates carries nothing"
    places = -trial.values("moment")[:, :, 1].mean(axis=0, dtype=float) / load
    left, right = (float(places[belts.index(belt)]) for belt in ("left", "right"))
    marked = float(np.median(trial.values("marker_position")[:, foot, 0]))
    beside = min(abs(left - marked), abs(right - marked))
    if abs(right - left) < APART_M:
        return None, (
            f"cannot be told: the centres of pressure of both plates are {100.0 * abs(right - left):.0f} cm "
            "apart across the belts"
        )
    if beside > BELOW_M:
        return None, (
            f"cannot be told: the nearer centre of pressure lies {100.0 * beside:.0f} cm beside the foot "
            "with markers, so the moments about the y axis are about another origin"
        )
    side = "left" if left < right else "right"
    return left > right, (
        f"the left plate's centre of pressure lies {100.0 * abs(right - left):.0f} cm to the {side} of the "
        "right plate's, and one of them is below the foot with markers"
    )


def refuse_foreign_markers(trial: Trial, limits: Limits, rig: Rig, files: dict[str, str]) -> None:
    """Compare belt-fixed markers with the belt, and other segments with their rest.

    limits: plausible range of each kind of signal.
    files: kind of each source file -> its path, for messages.
    """
    if "marker_position" not in trial.signals or "belt_velocity" not in trial.signals:
        return
    labels, rate = trial.axes["marker"].tolist(), trial.rate_hz
    if rate <= 2.0 * COMPARED_HZ:
        return
    belt = _lowpass(trial, trial.values("belt_velocity"))
    belt = belt - np.median(belt)
    for label in (label for label in rig.belt_fixed if label in labels):
        position = trial.values("marker_position")[:, labels.index(label), 1].astype(float)
        velocity = derivative(trial.time, _lowpass(trial, position))
        if _stands_out(belt) or _stands_out(velocity):  # otherwise the analysis finds no perturbation
            motion = belt_fixed_motion(velocity, belt, rate, limits.belt_fixed_delay_s)
            if motion[2] < limits.belt_fixed_correlation:
                against = belt_fixed_motion(velocity, -belt, rate, limits.belt_fixed_delay_s)
                _refuse_reversed(label, against[2], limits, files)
            _refuse_belt_fixed(label, motion, limits, rig, files)
    for segment, names in (rig.segments or {}).items():
        columns = [labels.index(label) for label in names if label in labels]
        if columns and _stands_out(belt) and not _moves(trial, columns, belt):
            raise InputError(
                f"{source(files, 'markers')}: expected the markers of the {segment} to move when the belt "
                f"does, found them as still as before ({', '.join(names)}): check their labels, and that the "
                "markers are those of this trial"
            )


def _lowpass(trial: Trial, x: np.ndarray) -> np.ndarray:
    """A signal below the compared frequency (a filter of scipy.signal would take longer to import)."""
    return resample(trial.time, x, trial.time, COMPARED_HZ)


def belt_fixed_motion(
    velocity: np.ndarray, belt_velocity: np.ndarray, rate_hz: float, longest_s: float
) -> tuple[float, float, float]:
    """Scale, delay and correlation of a belt-fixed marker's velocity relative to the belt's.

    velocity, belt_velocity: velocity of the marker along the belt, and of the belt less its constant speed
    (m/s), filtered alike.
    longest_s: longest delay that is searched, in either direction.
    Returns: s, d (s, positive where the marker lags, to one sample) and the uncentred correlation over the
    samples in which either moves.
    """
    v = np.asarray(belt_velocity, dtype=float)
    y = np.asarray(velocity, dtype=float) - np.median(velocity)
    active = np.abs(v) > MOVING_FRACTION * np.abs(v).max(initial=0.0)
    active |= np.abs(y) > max(MOVING_FRACTION * np.abs(y).max(initial=0.0), 0.5 * np.abs(v).max(initial=0.0))
    power = float(v[active] @ v[active])
    if power == 0.0:
        return 0.0, 0.0, 0.0
    best = (0.0, 0.0, -np.inf)
    most = max(1, math.ceil(longest_s * rate_hz))
    for lag in range(-most, most + 1):
        shifted = np.roll(y, -lag)[active]
        product, energy = float(shifted @ v[active]), float(shifted @ shifted)
        correlation = product / np.sqrt(energy * power) if energy > 0.0 else 0.0
        if correlation > best[2]:
            best = (product / power, lag / rate_hz, correlation)
    return best


def _refuse_reversed(label: str, correlation: float, limits: Limits, files: dict[str, str]) -> None:
    """Refuse a belt that moves like a belt-fixed marker but for its sign.

    correlation: correlation of the marker with the reversed velocity of the belt.
    """
    if correlation >= limits.belt_fixed_correlation:
        raise InputError(
            f"{source(files, 'log')}: expected the belt to move with the belt-fixed marker {label!r} of "
            f"{source(files, 'markers', 'log')}, found it to move against it (correlation {correlation:.2g} "
            "with its velocity reversed): reverse the sign of the belt velocity, or correct the direction of "
            "the axes in the configuration"
        )


def _refuse_belt_fixed(
    label: str, motion: tuple[float, float, float], limits: Limits, rig: Rig, files: dict[str, str]
) -> None:
    """Refuse a belt-fixed marker whose scale, delay and correlation do not match the belt's motion."""
    scale, delay_s, correlation = motion
    marker_file, log = source(files, "markers"), source(files, "log")
    where = f"{marker_file}: expected the belt-fixed marker {label!r} to move with the belt"
    where, both = (
        (where, "") if marker_file == log else (f"{where} of {log}", "that both files are of this trial, ")
    )
    low, high = limits.belt_fixed_scale
    if correlation < limits.belt_fixed_correlation:
        if not rig.person:  # after a step a foot is not belt-fixed: standing trials report the step
            raise InputError(
                f"{where}, found a correlation of {correlation:.2g} (at least "
                f"{limits.belt_fixed_correlation:g} is plausible): check {both}the direction of the axes "
                "and of the belt velocity, and the belt-fixed labels in the configuration"
            )
        return
    if abs(delay_s) >= limits.belt_fixed_delay_s:
        raise InputError(
            f"{where}, found it {1e3 * delay_s:.3g} ms later, the longest delay that is searched: check "
            f"{both}the trigger of both instruments"
        )
    if not low <= scale <= high:
        raise InputError(
            f"{where}, found {scale:.3g} times its velocity ({low:g} to {high:g} is plausible): check {both}"
            "the units of both signals"
        )


def _stands_out(velocity: np.ndarray) -> bool:
    """Test for a velocity with pulses above its noise, which is most of it."""
    around = np.abs(velocity - np.median(velocity))
    return bool(around.max() > PULSE_TO_NOISE * 1.4826 * np.median(around))


def _moves(trial: Trial, columns: list[int], belt: np.ndarray) -> bool:
    """Test for a marker that is faster during and shortly after the belt's motion than before it."""
    rate = trial.rate_hz
    moving = np.flatnonzero(np.abs(belt) > MOVING_FRACTION * np.abs(belt).max())
    before = slice(round(0.1 * rate), max(0, int(moving[0]) - round(0.2 * rate)))
    if before.stop - before.start < rate:
        return True  # without a second of rest nothing can be said
    after = np.zeros(belt.size, dtype=bool)
    for k in moving:
        after[k : k + round(0.3 * rate)] = True
    positions = trial.values("marker_position")[:, columns, 1:].astype(float)
    speed = derivative(trial.time, _lowpass(trial, positions))
    size = np.sqrt((speed**2).sum(axis=2))
    root = [np.sqrt(np.mean(size[part] ** 2, axis=0)) for part in (after, before)]
    return bool((root[0] > STILL_RATIO * root[1]).any())


def refuse_joint(trial: Trial, limits: Limits, files: dict[str, str]) -> None:
    """Compare torque and angle of a joint in a manipulator: size, direction, and motion of both.

    limits: plausible range of each kind of signal.
    files: kind of each source file -> its path, for messages.
    """
    if "torque" not in trial.signals or "angle" not in trial.signals:
        return
    torque, angle = (trial.values(name).astype(float) for name in ("torque", "angle"))
    log = source(files, "log")
    # a measured torque varies; a commanded one may be constant
    _refuse_held(trial, angle, torque, "", limits, log, both="command" not in files)
    _refuse_fast(trial, angle, limits, log)
    if not np.ptp(angle) > 0.0 or not np.ptp(torque) > 0.0:
        return  # the analysis refuses a joint that is not perturbed
    _refuse_ratio(angle, torque, "", limits, source(files, "command", "log"))
    work = float(np.corrcoef(torque, derivative(trial.time, angle))[0, 1])
    if work < AGAINST_MOTION:
        raise InputError(
            f"{log}: expected a torque that moves the joint, found one against its motion (correlation "
            f"with the angular velocity {work:.2g}): reverse the sign of the angle or of the torque"
        )


def refuse_joints(trial: Trial, limits: Limits, files: dict[str, str]) -> None:
    """Refuse joints of a person on a platform whose angle or torque is held, or in the wrong unit or column.

    limits: plausible range of each kind of signal.
    files: kind of each source file -> its path, for messages.
    """
    if "joint_torque" not in trial.signals:
        return
    log = source(files, "log")
    for k, joint in enumerate(trial.axes["joint"].tolist()):
        angle, torque = (trial.values(name)[:, k] for name in ("joint_angle", "joint_torque"))
        _refuse_held(trial, angle, torque, f" of the {joint}", limits, log)
        if np.ptp(angle) > 0.0 and np.ptp(torque) > 0.0:
            _refuse_ratio(angle, torque, f" of the {joint}", limits, log)


def _refuse_held(trial: Trial, angle, torque, of: str, limits: Limits, log: str, both: bool = True) -> None:
    """Refuse an angle, or a torque, that is constant while the other one changes."""
    pairs = [("angle", angle, "torque", torque), ("torque", torque, "angle", angle)]
    for still, values, moving, others in pairs[: 1 + both]:
        held = held_while_moving(values, others, trial.rate_hz, 3.0 * limits.frozen_s)
        if held is not None:
            raise InputError(
                f"{log}: expected the {still}{of} to change with the {moving}, found it constant from "
                f"{trial.time[held[0]]:.3f} to {trial.time[held[1] - 1]:.3f} s while the {moving} changes: "
                "check that its sensor was connected, and record again"
            )


def _refuse_fast(trial: Trial, angle: np.ndarray, limits: Limits, log: str) -> None:
    """Refuse an angle that changes faster than a joint; single samples may be noise."""
    speed = float(np.percentile(np.abs(derivative(trial.time, angle)), FAST_PERCENTILE))
    if speed > limits.joint_speed_rad_per_s:
        raise InputError(
            f"{log}: expected a joint of at most {limits.joint_speed_rad_per_s:g} rad/s, found {speed:.3g} "
            "rad/s in one sample of 1000: correct angle_unit if the angle is in degrees, or change "
            "plausible.joint_speed_rad_per_s in the configuration"
        )


def _refuse_ratio(angle, torque, of: str, limits: Limits, file: str) -> None:
    """Refuse a torque whose size is impossible for a joint."""
    ratio, (low, high) = float(torque.std() / angle.std()), limits.torque_per_angle_Nm_per_rad
    if not low <= ratio <= high:
        raise InputError(
            f"{file}: expected a torque{of} of {low:g} to {high:g} N·m per rad of the "
            f"angle, found {ratio:.4g} N·m/rad: check the units of torque and angle, or change "
            "plausible.torque_per_angle_Nm_per_rad in the configuration"
        )
