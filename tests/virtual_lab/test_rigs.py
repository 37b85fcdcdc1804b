"""The laboratory obeys mechanics: energy, momentum and balance of forces, and draws by its seed."""

import copy
import math
from dataclasses import replace

import numpy as np
import pytest
from builders import bend_at_rest, second_order_response
from plate_builders import plate_voltages, pressed

from tepsipe.virtual_lab import integrate as integration
from tepsipe.virtual_lab.belt import PULSES, DriveTruth, velocity_command
from tepsipe.virtual_lab.dummy import DummyMarkers, DummyTruth, FootTilt, dummy_marker_paths, move_dummy
from tepsipe.virtual_lab.dummy_trial import make_dummy_trial
from tepsipe.virtual_lab.force_plate import PlateTruth, lines_of_action, plate_electronics
from tepsipe.virtual_lab.integrate import integrate
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_trial import CaptureTruth, Protocol, record_markers
from tepsipe.virtual_lab.wristalyzer_trial import (
    ManipulatorTruth,
    make_wristalyzer_trial,
    multisine,
    record_manipulator,
)

RATE_HZ = 2000.0
PUSH_N, PUSH_S = 4.0, 0.1
DUMMY = DummyTruth(
    foot_mass_kg=2.1,
    foot_height_m=0.055,
    foot_com_m=[0.0, 0.0275],
    joint_offset_m=[0.0, 0.0],
    leg_mass_kg=0.4,
    leg_com_m=0.4485,
    leg_inertia_kgm2=0.027,
    joint_inertia_kgm2=0.0,
    rest_angle_rad=0.02,
    position_x_m=0.25,
    position_y_m=0.05,
    gravity_m_per_s2=9.81,
)
STEEL = Rubber(10.0, 0.0, 0.0, 0.05, 0.0)  # linear and without damping
# as heavy as the drive is weak: pushed with a known force at first, then left alone
LOOSE = DriveTruth(
    belt_mass_kg=5.0,
    bandwidth_hz=1e-12,
    integral_time_s=1e12,
    force_limit_N=PUSH_N,
    delay_s=0.0,
    viscous_Ns_per_m=0.0,
    velocity_step_m_per_s=0.0,
    velocity_noise_m_per_s=0.0,
)


def push(t):
    """A command that a weak drive can never reach, then none."""
    return np.where(t < PUSH_S, 1e30, 0.0)


def energy(motion, rubber_stiffness=10.0, belt_kg=5.0):
    """Kinetic and potential energy of belt, foot and leg (J)."""
    m, r, g = 0.4, 0.4485, 9.81
    neutral = 0.02 - m * g * r * math.sin(0.02) / rubber_stiffness
    v, w, th = motion.belt_velocity, motion.angle_rate, motion.angle
    leg_y, leg_z = v + r * np.cos(th) * w, -r * np.sin(th) * w
    moving = 0.5 * (belt_kg + 2.1) * v**2 + 0.5 * m * (leg_y**2 + leg_z**2) + 0.5 * 0.027 * w**2
    return moving + m * g * r * np.cos(th) + 0.5 * rubber_stiffness * (th - neutral) ** 2


@pytest.fixture(scope="module")
def released():
    return move_dummy(DUMMY, STEEL, LOOSE, push, 2.0, RATE_HZ)


@pytest.fixture(scope="module")
def standing():
    return move_dummy(DUMMY, STEEL, LOOSE, np.zeros_like, 0.05, RATE_HZ)


# ---- the dummy on the belt ---------------------------------------------------------------------


def test_energy_is_kept_once_the_drive_lets_go(released):
    after = released.time > PUSH_S + 0.01
    found = energy(released)
    stored = found[-1] - found[0]
    assert stored > 0.001
    assert np.ptp(found[after]) < 1e-6 * stored


def test_work_of_the_drive_becomes_energy(released):
    found, pushed = energy(released), np.argmin(np.abs(released.time - PUSH_S))
    work = PUSH_N * released.belt_position[: pushed + 1]
    assert found[: pushed + 1] - found[0] == pytest.approx(work, abs=2e-3 * work[-1])


def test_damped_rubber_loses_what_its_damping_takes():
    damped = move_dummy(DUMMY, replace(STEEL, damping_Nms_per_rad=0.1), LOOSE, push, 2.0, RATE_HZ)
    after = np.flatnonzero(damped.time > PUSH_S + 0.01)
    found = energy(damped)[after]
    power = 0.1 * damped.angle_rate[after] ** 2
    lost = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) / RATE_HZ)])
    assert lost[-1] > 1e-4
    assert found[0] - found == pytest.approx(lost, abs=1e-4 * lost[-1])


def test_impulse_of_the_plate_is_the_change_of_momentum_of_foot_and_leg(released):
    m, r = 0.4, 0.4485
    leg = released.belt_velocity + r * np.cos(released.angle) * released.angle_rate
    momentum = 2.1 * released.belt_velocity + m * leg
    fy = released.reaction[:, 1]
    impulse = np.concatenate([[0.0], np.cumsum(0.5 * (fy[1:] + fy[:-1]) / RATE_HZ)])
    assert np.ptp(momentum) > 0.05
    assert impulse == pytest.approx(momentum, abs=2e-3 * np.ptp(momentum))


def test_belt_left_alone_feels_the_reaction_only(released):
    after = released.time > PUSH_S + 0.01
    belt = 5.0 * released.belt_acceleration[after]
    assert np.ptp(belt) > 0.1
    assert belt == pytest.approx(-released.reaction[after, 1], abs=1e-5 * np.ptp(belt))


def test_standing_dummy_rests_its_weight_on_the_plate(standing):
    assert standing.reaction[0, :3] == pytest.approx([0.0, 0.0, (2.1 + 0.4) * 9.81], abs=1e-6)


def test_centre_of_pressure_of_the_standing_dummy_is_under_its_centre_of_mass(standing):
    _, _, fz, mx, my, _ = standing.reaction[0]
    forward = 0.4 * 0.4485 * math.sin(0.02) / 2.5
    assert mx / fz == pytest.approx(0.05 + forward, abs=1e-7)
    assert -my / fz == pytest.approx(0.25, abs=1e-9)
    assert abs(mx / fz - 0.05) < 0.1


def test_moment_on_the_plate_holds_the_rubbers_moment_while_the_belt_moves(released):
    m, r, g = 0.4, 0.4485, 9.81
    neutral = 0.02 - m * g * r * math.sin(0.02) / 10.0
    _, fy, fz, mx, _, _ = released.reaction.T
    y_ankle, z_ankle = 0.05 + released.belt_position, 0.055
    # about the ankle the foot feels the plate, its own inertia and weight, and the rubber
    on_foot = mx - ((y_ankle) * fz - z_ankle * fy)
    foot = 2.1 * released.belt_acceleration * (z_ankle - 0.5 * 0.055)
    rubber = 10.0 * (released.angle - neutral)
    after = released.time > PUSH_S + 0.01
    assert (on_foot - foot)[after] == pytest.approx(rubber[after], abs=1e-5 * np.ptp(rubber))


@pytest.mark.parametrize("belt_kg", [5.0, 1e6])
def test_small_free_oscillation_has_the_frequency_of_stiffness_over_inertia(belt_kg):
    weak = replace(LOOSE, belt_mass_kg=belt_kg, force_limit_N=0.2 * (belt_kg + 2.5))
    motion = move_dummy(DUMMY, STEEL, weak, push, 6.0, RATE_HZ)
    swinging = (motion.angle - 0.02)[motion.time > 1.0]
    assert 0.0 < np.abs(swinging).max() < 0.01
    time = motion.time[motion.time > 1.0]
    up = np.flatnonzero((swinging[:-1] < 0.0) & (swinging[1:] >= 0.0))
    crossing = time[up] - swinging[up] * (time[up + 1] - time[up]) / (swinging[up + 1] - swinging[up])
    frequency = (crossing.size - 1) / (crossing[-1] - crossing[0])
    p, about_ankle, weight = 0.4 * 0.4485, 0.027 + 0.4 * 0.4485**2, 0.4 * 9.81 * 0.4485
    inertia = about_ankle - p**2 / (belt_kg + 2.5)
    expected = math.sqrt((10.0 - weight * math.cos(0.02)) / inertia) / (2.0 * math.pi)
    assert frequency == pytest.approx(expected, rel=2e-4)


def test_leg_stays_at_rest_on_a_resting_belt(shipped_truth):
    drive = DriveTruth(**shipped_truth["treadmill"]["drive"])
    rubber = Rubber(**shipped_truth["dummy"]["rubber"])
    motion = move_dummy(DUMMY, rubber, drive, np.zeros_like, 1.0, RATE_HZ)
    assert np.abs(motion.angle - 0.02).max() < 1e-10
    assert np.abs(motion.belt_velocity).max() < 1e-10


def test_leg_lags_behind_a_belt_that_starts_forwards(released):
    pushed = released.time < 0.05
    assert released.belt_position[pushed][-1] > 0.0
    assert (np.diff(released.angle[pushed])[5:] < 0.0).all()


# ---- the drive ---------------------------------------------------------------------------------


def driven(truth, profile, amplitude):
    """Time and belt velocity of one pulse that starts at 0.5 s."""
    command = velocity_command(profile, amplitude, np.array([0.5]), 0.1)
    drive, rubber = DriveTruth(**truth["treadmill"]["drive"]), Rubber(**truth["dummy"]["rubber"])
    motion = move_dummy(DUMMY, rubber, drive, command, 1.5, RATE_HZ)
    return motion.time, motion.belt_velocity, command


@pytest.mark.parametrize("profile", ["sine", "minjerk"])
@pytest.mark.parametrize("amplitude", [0.1, 0.5])
def test_belt_moves_longer_than_it_is_commanded_to(shipped_truth, profile, amplitude):
    time, velocity, command = driven(shipped_truth, profile, amplitude)
    commanded = time[np.abs(command(time)) > 0.05 * amplitude]
    moving = time[np.abs(velocity) > 0.05 * np.abs(velocity).max()]
    assert 0.08 < np.ptp(commanded) < 0.1
    assert np.ptp(moving) > np.ptp(commanded) + 0.02
    assert moving[0] > commanded[0]


def test_shape_of_the_belts_pulse_changes_where_the_drive_reaches_its_limit(shipped_truth):
    small, medium, large = (driven(shipped_truth, "sine", a)[1] / a for a in (0.1, 0.15, 0.5))
    assert np.abs(small - medium).max() < 1e-3
    assert np.abs(small - large).max() > 0.02


@pytest.mark.parametrize("profile", ["sine", "minjerk"])
def test_commanded_pulse_reaches_its_amplitude_both_ways_and_brings_the_belt_back(profile):
    s = np.linspace(0.0, 1.0, 20001)
    pulse = PULSES[profile](s[:-1])
    assert (pulse.max(), pulse.min()) == pytest.approx((1.0, -1.0), abs=1e-6)
    assert pulse.mean() == pytest.approx(0.0, abs=1e-9)
    assert pulse[0] == 0.0


def test_commands_start_at_their_onsets_and_rest_in_between():
    command = velocity_command("sine", 0.3, np.array([1.0, 3.0]), 0.1)
    assert command(1.025) == pytest.approx(0.3)
    assert command(3.075) == pytest.approx(-0.3)
    assert not command(np.array([0.0, 0.99, 1.11, 2.5, 3.2, 7.0])).any()


# ---- the force plate ---------------------------------------------------------------------------


def silent_plate(truth):
    """The shipped plate without noise, drift, error of calibration, belt, floor and mounts."""
    off = ("calibration_error", "noise_V", "drift_V_per_s", "felt_belt_mass_kg", "felt_roller_inertia_kgm")
    off += ("belt_lag_s", "friction_N", "friction_coefficient", "friction_Ns_per_m")
    off += ("floor_m_per_s2", "mount_share")
    return PlateTruth(**(truth["treadmill"]["plate"] | dict.fromkeys(off, 0.0)))


def voltages_of(plate, volts_per_newton, reaction, velocity=None, acceleration=None):
    motion = pressed(reaction, RATE_HZ, velocity, acceleration)
    sample = np.arange(0, len(reaction), 2)
    return plate_voltages(plate, volts_per_newton, motion, sample, generator(1, "noise"))


def test_calibrated_voltages_are_the_wrench_on_the_right_belt(shipped_truth, rng):
    plate = silent_plate(shipped_truth)
    volts_per_newton, calibration = plate_electronics(plate, rng)
    wrench = rng.standard_normal(6) * [10.0, 20.0, 300.0, 15.0, 30.0, 5.0]
    found = voltages_of(plate, volts_per_newton, np.tile(wrench, (40, 1))) @ calibration.T
    assert found[:, 6:] == pytest.approx(np.tile(wrench, (20, 1)), rel=1e-9)
    assert found[:, :6] == pytest.approx(np.zeros((20, 6)), abs=1e-9)
    assert np.abs(volts_per_newton - np.diag(np.diag(volts_per_newton))).max() > 1e-6


def test_every_transducer_pulls_where_it_sits(shipped_truth):
    plate = silent_plate(shipped_truth)
    lines = lines_of_action(plate)
    front_right = lines[:, 1]
    assert front_right == pytest.approx([0.0, 0.0, 1.0, 0.8, -0.25, 0.0])
    fore_aft = lines[:, 6]
    assert fore_aft == pytest.approx([0.0, 1.0, 0.0, 0.12, 0.0, 0.0])
    assert np.linalg.matrix_rank(lines) == 6


def test_frame_rings_at_its_resonance_when_the_force_jumps(shipped_truth, rng):
    plate = silent_plate(shipped_truth)
    volts_per_newton, calibration = plate_electronics(plate, rng)
    reaction = np.zeros((4000, 6))
    reaction[200:, 1] = 10.0
    fy = (voltages_of(plate, volts_per_newton, reaction) @ calibration.T)[:, 7]
    assert fy.max() > 15.0
    assert fy[-1] == pytest.approx(10.0, abs=0.01)
    ringing = np.abs(np.fft.rfft((fy - 10.0)[100:] * np.hanning(fy.size - 100)))
    frequency = np.fft.rfftfreq(fy.size - 100, 1e-3)[np.argmax(ringing)]
    assert frequency == pytest.approx(
        plate.resonance_hz * math.sqrt(1.0 - plate.resonance_damping**2), abs=0.6
    )


def test_empty_belt_shows_its_inertia_and_its_friction(shipped_truth, rng):
    silent = silent_plate(shipped_truth)
    plate = replace(silent, felt_belt_mass_kg=0.8, friction_Ns_per_m=12.0)
    volts_per_newton, calibration = plate_electronics(plate, rng)
    time = np.arange(8000) / RATE_HZ
    omega = 2.0 * np.pi * 1.0
    velocity, acceleration = 0.5 * np.sin(omega * time), 0.5 * omega * np.cos(omega * time)
    measured = voltages_of(plate, volts_per_newton, np.zeros((8000, 6)), velocity, acceleration)
    fy = (measured @ calibration.T)[2000:, 7]
    felt = (0.8 * acceleration + 12.0 * velocity)[4000::2]
    assert fy == pytest.approx(felt, abs=0.01 * np.abs(felt).max())


def test_friction_grows_with_the_load(shipped_truth, rng):
    plate = replace(silent_plate(shipped_truth), friction_coefficient=0.06, friction_speed_m_per_s=0.1)
    volts_per_newton, calibration = plate_electronics(plate, rng)
    loaded = np.tile([0.0, 0.0, 200.0, 0.0, 0.0, 0.0], (4000, 1))
    fy = (voltages_of(plate, volts_per_newton, loaded, np.full(4000, 0.4)) @ calibration.T)[:, 7]
    assert fy[-1] == pytest.approx(0.06 * 200.0 * math.tanh(4.0), rel=1e-3)


# ---- motion capture ----------------------------------------------------------------------------


def captured(truth, motion, frames=250, **changes):
    capture = CaptureTruth(**(truth["treadmill"]["capture"] | changes))
    paths = dummy_marker_paths(DummyMarkers(**truth["dummy"]["markers"]), DUMMY, motion)
    return record_markers(capture, paths, 0.3, frames, generator(1, "markers"))


PERFECT = {"noise_m": 0.0, "occlusions_per_minute": 0.0}


def test_markers_on_the_leg_keep_their_distances_if_sampled_at_once(shipped_truth, released):
    positions = captured(shipped_truth, released, marker_sampling_hz=1e12, **PERFECT)
    leg = np.array([[0.0, 0.0], *shipped_truth["dummy"]["markers"]["leg_m"]])
    for i in range(5):
        for j in range(i):
            distance = np.linalg.norm(positions[:, 3 + i] - positions[:, 3 + j], axis=1)
            assert distance == pytest.approx(np.full(250, np.linalg.norm(leg[i] - leg[j])))


def test_every_marker_is_sampled_a_little_later_than_the_one_before_it(shipped_truth, released):
    at_once = captured(shipped_truth, released, marker_sampling_hz=1e12, **PERFECT)
    strobed = captured(shipped_truth, released, marker_sampling_hz=2500.0, **PERFECT)
    shift = (strobed - at_once)[:, :, 1]
    assert np.abs(shift[:, 0]).max() < 1e-9
    frame = np.arange(250) / 250.0 + 0.3 + 0.0008
    velocity = np.interp(frame + 1e-4, released.time, released.belt_velocity)
    assert shift[:, 2] == pytest.approx(velocity * 2.0 / 2500.0, abs=2e-5)


def test_noise_and_hidden_markers_have_the_size_asked_for(shipped_truth, released):
    clean = captured(shipped_truth, released, frames=400, **PERFECT)
    noisy = captured(shipped_truth, released, frames=400, occlusions_per_minute=240.0)
    hidden = np.isnan(noisy).any(axis=2)
    expected = shipped_truth["treadmill"]["capture"]["noise_m"]
    assert np.nanstd(noisy - clean) == pytest.approx(expected, rel=0.03)
    assert (np.isnan(noisy).any(axis=2) == np.isnan(noisy).all(axis=2)).all()
    # 240 per minute for 1.6 s, about 5 frames each, 8 markers
    assert hidden.sum() == pytest.approx(240.0 / 60.0 * 1.6 * 5.0 * 8, rel=0.4)


# ---- the manipulator ---------------------------------------------------------------------------


def manipulator_of(truth, **changes):
    return ManipulatorTruth(**(truth["wristalyzer"]["manipulator"] | changes))


LINEAR = {
    "contact_Nm_per_rad3": 0.0,
    "friction_Nm": 0.0,
    "ripple_Nm": 0.0,
    "log_jitter_s": 0.0,
    "repeated_fraction": 0.0,
    "missing_fraction": 0.0,
    "encoder_step_rad": 1e-9,
}


def test_multisine_holds_only_the_harmonics_it_is_asked_for(shipped_truth):
    truth = manipulator_of(shipped_truth)
    period = multisine(truth, 10.0, generator(1, "phases"))
    power = np.abs(np.fft.rfft(period)) ** 2
    lines = np.flatnonzero(power > 1e-12 * power.max())
    assert lines.tolist() == list(range(10, 201))
    assert np.ptp(power[lines]) < 1e-9 * power.max()
    assert period.std() == pytest.approx(1.0)


def test_multisine_repeats_itself_after_its_period(shipped_truth):
    truth = manipulator_of(shipped_truth)
    signal = multisine(truth, 25.0, generator(1, "phases"))
    assert signal.size == 25 * 2048
    assert (signal[:20480] == signal[20480:40960]).all()
    assert np.abs(signal).max() < 5.0 * signal.std()


def test_linear_joint_in_the_manipulator_answers_as_inertia_damping_and_stiffness(shipped_truth):
    truth = manipulator_of(shipped_truth, log_rate_hz=160.0, **LINEAR)
    recording = record_manipulator(
        truth, Rubber(10.0, 0.095, 0.0, 0.04, 0.0), 0.1, 24.0, generator(1, "a"), generator(1, "b")
    )
    # one period of steady motion; the log's first stamp is one step after its start
    started = recording.trigger_time - truth.lead_s
    first = int(np.argmin(np.abs(recording.log_time - started - truth.lead_s - 12.0)))
    angle = recording.angle[first : first + 1600]
    lines = np.arange(10, 201)
    torque = np.fft.rfft(recording.command[:20480]) / 20480.0
    measured = np.fft.rfft(angle)[lines] / 1600.0
    elapsed = recording.log_time[first] - recording.trigger_time
    measured = measured * np.exp(-2j * np.pi * lines / 10.0 * elapsed)
    truth_response = second_order_response((0.015, 0.095, 10.0), lines / 10.0)
    assert np.abs(measured / torque[lines] / truth_response - 1.0).max() < 0.03


def test_friction_keeps_a_weakly_driven_joint_still(shipped_truth):
    truth = manipulator_of(shipped_truth, **(LINEAR | {"friction_Nm": 0.5}))
    joint, names = Rubber(10.0, 0.1, 0.0, 0.04, 0.0), (generator(1, "a"), generator(1, "b"))
    stuck = record_manipulator(truth, joint, 0.02, 4.0, *names)
    free = record_manipulator(
        replace(truth, friction_Nm=0.0), joint, 0.02, 4.0, generator(1, "a"), generator(1, "b")
    )
    assert stuck.angle.std() < 0.2 * free.angle.std()


def test_log_repeats_and_misses_as_many_lines_as_asked_for(shipped_truth):
    truth = manipulator_of(shipped_truth, **(LINEAR | {"repeated_fraction": 0.05, "missing_fraction": 0.1}))
    joint = Rubber(10.0, 0.1, 0.0, 0.04, 0.0)
    recording = record_manipulator(truth, joint, 0.1, 20.0, generator(1, "a"), generator(1, "b"))
    steps = np.diff(recording.log_time)
    expected = 163.0 * 24.0
    assert recording.log_time.size == pytest.approx(0.9 * expected, rel=0.02)
    assert (steps < 1e-9).mean() == pytest.approx(0.05, abs=0.02)
    assert (steps >= -1e-9).all()


# ---- rubber and integration --------------------------------------------------------------------


def test_rubber_is_odd_linear_for_small_bending_and_softer_beyond():
    rubber = Rubber(10.0, 0.1, 0.35, 0.04, 0.3)
    assert rubber.moment(-0.03, -0.5) == -rubber.moment(0.03, 0.5)
    assert rubber.moment(1e-5, 0.0) / 1e-5 == pytest.approx(10.0, rel=1e-6)
    assert rubber.moment(0.04, 0.0) / 0.04 == pytest.approx(10.0 * (1.0 - 0.35 / 2.0))
    assert rubber.moment(4.0, 0.0) / 4.0 == pytest.approx(10.0 * (1.0 - 0.35), rel=1e-3)
    assert rubber.moment(0.0, 2.0) == pytest.approx(0.2)
    # and it loses more where it is softer
    half = rubber.moment(0.04, 2.0) - rubber.moment(0.04, 0.0)
    assert half == pytest.approx(2.0 * (0.1 + 0.15))


def test_leaning_dummy_bends_a_softening_rubber_until_it_carries_the_leg(shipped_truth):
    rubber = Rubber(**shipped_truth["dummy"]["rubber"])
    gravity_moment = 0.4 * 9.81 * 0.4485 * math.sin(0.05)
    bent = bend_at_rest(lambda phi: rubber.moment(phi, 0.0), gravity_moment)
    drive = DriveTruth(**shipped_truth["treadmill"]["drive"])
    leaning = replace(DUMMY, rest_angle_rad=0.05)
    motion = move_dummy(leaning, rubber, drive, np.zeros_like, 0.5, RATE_HZ)
    assert bent > 0.005
    assert np.abs(motion.angle - 0.05).max() < 1e-10


def test_integration_is_of_fourth_order():
    errors = []
    for rate in (50.0, 100.0):
        still = np.zeros((round(rate), 3))
        time, states = integrate(lambda u, x: (x[1], -100.0 * x[0]), (1.0, 0.0), still, rate)
        errors.append(np.abs(states[:, 0] - np.cos(10.0 * time)).max())
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.1)


# changes by long steps over those by smaller ones: of belt, leg and foot, and of the frame, which sways by
# some micrometres and rings longest
@pytest.mark.parametrize(("on_frame", "most", "of_frame"), [(False, 0.01, 0.0), (True, 0.05, 0.25)])
def test_long_steps_change_little_of_what_smaller_steps_do(
    on_frame, most, of_frame, shipped_truth, monkeypatch
):
    truth = shipped_truth["dummy"]
    rig = DummyTruth(**truth["subject"]), Rubber(**truth["rubber"])
    rig += (DriveTruth(**shipped_truth["treadmill"]["drive"]),)
    below = [(PlateTruth(**shipped_truth["treadmill"]["plate"]), 1.0)] if on_frame else []
    command = velocity_command("sine", 0.5, np.array([0.5]), 0.1)

    def states(rate):
        motion = move_dummy(*rig, command, 3.0, rate, FootTilt(**truth["foot_tilt"]), below)
        names = ("belt_position", "belt_velocity", "angle", "angle_rate", "tilt", "tilt_rate")
        names += ("frame_position", "frame_velocity")
        return np.column_stack([getattr(motion, name) for name in names])

    found = states(RATE_HZ)
    monkeypatch.setattr(integration, "DEFECT", 0.0)
    exact, finer = states(RATE_HZ), states(2.0 * RATE_HZ)[::2]
    assert (found != exact).any()
    shares = np.array([most] * 6 + [of_frame] * 2)
    assert (np.abs(found - exact).max(axis=0) <= shares * np.abs(exact - finer).max(axis=0)).all()


def test_fast_motion_and_a_moving_input_are_integrated_by_short_steps():
    def calls(angular_rate, inputs):
        """States of an oscillator that starts at rest, and how often its derivative was asked for."""
        asked = []

        def derivative(u, x):
            asked.append(u)
            return x[1], u - angular_rate**2 * x[0]

        return integrate(derivative, (0.0, 0.0), inputs, 1000.0)[1], len(asked)

    pushed = np.zeros((2000, 3))
    pushed[20] = 1000.0
    slow, few = calls(1.0, pushed)
    fast, many = calls(300.0, pushed)
    assert slow[2000, 1] == pytest.approx(np.cos(1.9795), abs=1e-6)
    assert np.abs(fast[21:, 1]).max() == pytest.approx(1.0, abs=0.02)
    # four times for each short step; six for each of the long ones
    assert few < 6 * 2000 / 8 + 300 and many > 4 * 2000
    assert calls(1.0, np.random.default_rng(1).standard_normal((2000, 3)))[1] == 4 * 2000


def test_diverging_run_is_an_error():
    with pytest.raises((FloatingPointError, OverflowError)):
        integrate(lambda u, x: (x[0] * x[0],), (10.0,), np.zeros((200, 3)), 100.0)


# ---- seeds -------------------------------------------------------------------------------------


def test_generator_depends_on_the_seed_and_on_every_name():
    draws = {
        names: generator(*names).random()
        for names in [(1, "dummy", "a"), (1, "dummy", "b"), (2, "dummy", "a"), (1, "wristalyzer", "a")]
    }
    assert len(set(draws.values())) == 4
    assert generator(1, "dummy", "a").random() == draws[1, "dummy", "a"]


@pytest.fixture(scope="module")
def shortest_truth(shipped_truth):
    truth = copy.deepcopy(shipped_truth)
    truth["treadmill"]["protocol"] |= {"rest_before_s": 0.5, "rest_after_s": 0.5}
    return truth


def dummy_bytes(truth, condition, folder):
    names = {"log": "log.mat", "calibration": "calibration.csv", "markers": "markers.c3d"}
    files = {kind: folder / name for kind, name in names.items()}
    folder.mkdir()
    make_dummy_trial(truth, condition, Protocol("sine", 0.3, 1.0, 2.0), files)
    return [path.read_bytes() for path in files.values()]


def test_same_trial_has_the_same_bytes_whatever_was_made_before_and_another_has_others(
    shortest_truth, tmp_path
):
    first = dummy_bytes(shortest_truth, "sine-0.3", tmp_path / "first")
    other = dummy_bytes(shortest_truth, "sine-0.3-8s", tmp_path / "other")
    again = dummy_bytes(shortest_truth, "sine-0.3", tmp_path / "again")
    reseeded = dummy_bytes(shortest_truth | {"seed": 1}, "sine-0.3", tmp_path / "reseeded")
    assert again == first
    assert b"Created on" not in first[0][:116]  # the date that MATLAB files usually start with
    assert [a == b for a, b in zip(first, other, strict=True)] == [False, True, False]
    assert [a == b for a, b in zip(first, reseeded, strict=True)] == [False, False, False]


def wristalyzer_texts(truth, condition, folder):
    files = {"log": folder / "log.txt", "command": folder / "command.txt"}
    folder.mkdir()
    make_wristalyzer_trial(truth, condition, 0.1, 1.0, files)
    return [path.read_bytes() for path in files.values()]


def test_trials_in_the_manipulator_share_the_multisine_and_nothing_else(shipped_truth, tmp_path):
    first = wristalyzer_texts(shipped_truth, "0.10", tmp_path / "first")
    other = wristalyzer_texts(shipped_truth, "0.11", tmp_path / "other")
    again = wristalyzer_texts(shipped_truth, "0.10", tmp_path / "again")
    assert again == first
    assert other[1] == first[1]
    assert other[0] != first[0]
