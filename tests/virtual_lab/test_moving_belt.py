"""The frame below a load: its motion and what its transducers show, against integrations by the tests."""

from dataclasses import replace

import numpy as np
import pytest
from plate_builders import pressed
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from tepsipe.virtual_lab.belt import DriveTruth, velocity_command
from tepsipe.virtual_lab.dummy import DummyTruth, FootTilt, move_dummy
from tepsipe.virtual_lab.force_plate import Loaded, PlateTruth, plate_electronics, voltages_of_belts
from tepsipe.virtual_lab.person import feet_of, move_person, segments
from tepsipe.virtual_lab.person_constants import (
    MUSCLES,
    MuscleTruth,
    NervesTruth,
    PersonTruth,
    Subject,
    TaskTruth,
)
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.weight_trial import WeightTruth, move_weight, weight_marker_paths

RATE_HZ = 2000.0
SECONDS, ONSET_S = 0.8, 0.2
FY, FZ, MX = 1, 2, 3
# a frame alone: nothing else between the load and the voltages
ALONE = dict.fromkeys(
    ("sensitivity_spread", "cross_talk", "calibration_error", "noise_V", "drift_V_per_s", "mount_share"), 0.0
) | {"floor_m_per_s2": 0.0, "belt_lag_wander": 0.0}
WITHOUT_BELT = dict.fromkeys(
    (
        "friction_N",
        "friction_coefficient",
        "friction_Ns_per_m",
        "felt_belt_mass_kg",
        "felt_roller_inertia_kgm",
    ),
    0.0,
)
PULSE = velocity_command("sine", 0.3, np.array([ONSET_S]), 0.1)


def plate_of(truth, **changes):
    return PlateTruth(**truth["treadmill"]["plate"] | ALONE | changes)


def drive_of(truth):
    return DriveTruth(**truth["treadmill"]["drive"])


def felt(plate, motion):
    """Wrench by the calibrated transducers of the right belt at every point of the grid (N, N·m)."""
    volts, matrix = plate_electronics(plate, generator(1, "plate"))
    sample, loaded = np.arange(motion.time.size), {"right": Loaded(plate, motion)}
    return (voltages_of_belts(loaded, volts, sample, generator(1, "n")) @ matrix.T)[:, 6:]


def mode_constants(plate):
    """Mass (kg), damping (N·s/m) and stiffness (N/m) of both modes, from frequencies and damping ratios.

    What the transducers show of a mode does not depend on its mass. A second one that moves no load has that
    of the first.
    """
    for mass, hz, ratio in (
        (plate.resonance_mass_kg, plate.resonance_hz, plate.resonance_damping),
        (plate.second_mass_kg or plate.resonance_mass_kg, plate.second_hz, plate.second_damping),
    ):
        stiffness = mass * (2.0 * np.pi * hz) ** 2
        yield mass, 2.0 * ratio * np.sqrt(stiffness * mass), stiffness


@pytest.mark.parametrize("hz", [30.0, 50.0, 90.0])
def test_known_force_and_moment_pass_through_the_empty_frame(hz, shipped_truth):
    plate = plate_of(shipped_truth, **WITHOUT_BELT, resonance_hz=hz)
    time = np.arange(1600) / RATE_HZ
    # 60 kg under a pulse, without and with its own rotation
    shape = np.where(time < 0.1, np.sin(2.0 * np.pi * 10.0 * time), 0.0)
    reaction = np.zeros((time.size, 6))
    reaction[:, FY], reaction[:, MX] = 900.0 * shape, 40.0 * np.abs(shape)
    seen = felt(plate, pressed(reaction, RATE_HZ))
    for k, column in enumerate((FY, MX)):
        load = reaction[:, column]
        expected = 0.0
        shares = (1.0 - plate.second_share[k], plate.second_share[k])
        for share, (mass, damping, stiffness) in zip(shares, mode_constants(plate), strict=True):
            path = solve_ivp(
                lambda t, x, load=load, m=mass, c=damping, s=stiffness: [
                    x[1],
                    (np.interp(t, time, load) - c * x[1] - s * x[0]) / m,
                ],
                (0.0, time[-1]),
                [0.0, 0.0],
                t_eval=time,
                rtol=1e-7,
                atol=1e-10,
                max_step=2.0 / RATE_HZ,
            ).y
            expected = expected + share * (damping * path[1] + stiffness * path[0])
        assert seen[:, column] == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())


def weight_of(kg, height_m=0.1, y_m=0.02):
    return WeightTruth(kg, 0.2, 0.2, 0.2, height_m, 0.25, y_m, 9.81)


def by_hand(plate, drive, kg, time):
    """Position on the frame, of the frame (m), and force on the transducers (N) with a weight on the belt."""
    gain = 2.0 * np.pi * drive.bandwidth_hz * drive.belt_mass_kg
    (m_1, c_1, k_1), (m_2, c_2, k_2) = mode_constants(plate)
    s_1, s_2 = 1.0 - plate.second_share[0], plate.second_share[0]
    own_kg, pitch = drive.belt_mass_kg, s_2 if plate.second_mass_kg else 0.0

    def forces(t, x):
        _, v, q, p_1, w_1, p_2, w_2 = x
        error = PULSE(t - drive.delay_s) - v
        u = gain * (error + q / drive.integral_time_s) - drive.viscous_Ns_per_m * v
        r_1, r_2 = c_1 * w_1 + k_1 * p_1, c_2 * w_2 + k_2 * p_2
        load, a = 0.0, 0.0
        for _ in range(20):  # the friction depends on the acceleration, which depends on the friction
            rollers = v + plate.belt_lag_s * a
            own = (plate.friction_N + plate.friction_coefficient * kg * 9.81) * np.tanh(
                rollers / plate.friction_speed_m_per_s
            )
            own += plate.friction_Ns_per_m * rollers + plate.felt_belt_mass_kg * a
            free = u / own_kg - s_1 * (own - r_1) / m_1 - pitch * (own - r_2) / m_2
            load = kg * free / (1.0 + kg * (1.0 / own_kg + s_1 / m_1 + pitch / m_2))
            a = (u - load) / own_kg
        return error, a, (load + own - r_1) / m_1, (load + own - r_2) / m_2, s_1 * r_1 + s_2 * r_2

    def rates(t, x):
        error, a, a_1, a_2, _ = forces(t, x)
        return [x[1], a, error, x[4], a_1, x[6], a_2]

    start = [0.0] * 7
    x = solve_ivp(rates, (0.0, time[-1]), start, t_eval=time, rtol=1e-7, atol=1e-11, max_step=1e-3).y
    return (
        x[0],
        -s_1 * x[3] - pitch * x[5],
        np.array([forces(t, y)[-1] for t, y in zip(time, x.T, strict=True)]),
    )


PITCH = {"second_hz": 60.0, "second_share": [0.25, 0.6], "second_mass_kg": 50.0}


@pytest.mark.parametrize(
    ("kg", "hz", "second"), [(0.0, 52.0, {}), (60.0, 52.0, {}), (60.0, 30.0, {}), (60.0, 35.0, PITCH)]
)
def test_weight_belt_drive_and_frame_move_together(kg, hz, second, shipped_truth):
    plate = plate_of(shipped_truth, resonance_hz=hz, bristle_share=0.0, **second)
    drive = drive_of(shipped_truth)
    weight = weight_of(kg) if kg else None
    motion = move_weight(weight, drive, PULSE, SECONDS, RATE_HZ, [(plate, 1.0)])
    on_frame, of_frame, force = by_hand(plate, drive, kg, motion.time)
    assert motion.belt_position == pytest.approx(on_frame, abs=1e-4 * np.ptp(on_frame))
    assert motion.frame_position == pytest.approx(of_frame, abs=3e-3 * np.ptp(of_frame))
    assert felt(plate, motion)[:, FY] == pytest.approx(force, abs=3e-3 * np.abs(force).max())


def test_cameras_see_the_frame_move_and_the_log_does_not(shipped_truth):
    plate, weight = plate_of(shipped_truth, resonance_hz=30.0), weight_of(60.0)
    motion = move_weight(weight, drive_of(shipped_truth), PULSE, SECONDS, RATE_HZ, [(plate, 1.0)])
    seen = weight_marker_paths(weight, motion)[0](motion.time)[:, 1]
    assert np.ptp(motion.frame_position) > 1e-4
    assert seen - seen[0] == pytest.approx(motion.belt_position + motion.frame_position, abs=1e-12)
    logged = CubicSpline(motion.time, motion.belt_velocity).antiderivative()(motion.time)
    assert motion.belt_position == pytest.approx(logged, abs=1e-5 * np.ptp(logged))


def test_a_heavier_weight_lowers_the_resonance(shipped_truth):
    plate = plate_of(shipped_truth, **WITHOUT_BELT, second_share=[0.0, 0.0], resonance_damping=0.01)
    lines = []
    for kg in (1e-3, 60.0):
        motion = move_weight(weight_of(kg), drive_of(shipped_truth), PULSE, 3.0, RATE_HZ, [(plate, 1.0)])
        ringing = felt(plate, motion)[round(0.7 * RATE_HZ) :, FY]
        spectrum = np.abs(np.fft.rfft(ringing * np.hanning(ringing.size), 65536))
        low = 65536 * 30 // 2000
        lines.append(RATE_HZ / 65536 * (low + np.argmax(spectrum[low:])))
    # the servo holds the belt: the frame carries weight and drive
    assert lines[0] == pytest.approx(52.0, abs=0.3)
    assert 0.8 < lines[1] / lines[0] < 0.95


def test_an_infinitely_stiff_frame_is_the_ground(shipped_truth):
    plate = plate_of(shipped_truth, second_share=[0.0, 0.0], resonance_mass_kg=1e7)
    drive = drive_of(shipped_truth)
    rigid = move_weight(weight_of(60.0), drive, PULSE, SECONDS, RATE_HZ)
    stiff = move_weight(weight_of(60.0), drive, PULSE, SECONDS, RATE_HZ, [(plate, 1.0)])
    assert stiff.position == pytest.approx(rigid.position, abs=1e-5 * np.ptp(rigid.position))
    assert stiff.reaction[:, FY] == pytest.approx(rigid.reaction[:, FY], abs=1e-2)


def person_of(truth, joints=None, kg=78.0):
    """The shipped person without nerves; with joints of a given stiffness (N·m/rad) on rigid feet."""
    standing = truth["standing"]
    person, task = standing["person"] | {"mass_kg": kg}, dict(standing["tasks"]["relax"])
    task |= {"reflex_s_per_rad": [0.0] * 5, "medium_reflex_s_per_rad": [0.0] * 5}
    if joints:
        person |= {"foot_stiffness_Nm_per_rad": 0.0}
        task |= {
            "stiffness_Nm_per_rad": [joints] * 3,
            "damping_Nms_per_rad": [1e-4 * joints] * 3,
        }
        task |= {"short_range_Nm_per_rad": 0.0}
    nerves = standing["nerves"] | {"balance_Nm_per_rad": 0.0, "balance_Nms_per_rad": 0.0, "wander_Nm": 0.0}
    muscles = {name: MuscleTruth(**standing["muscles"][name] | {"force_Nm": [0.0] * 3}) for name in MUSCLES}
    return Subject(PersonTruth(**person), muscles, TaskTruth(**task), NervesTruth(**nerves))


def weight_like(person):
    """A weight with the mass and the centre of mass of a person in quiet standing."""
    parts = [(feet_of(person).mass_kg, person.foot_com_m, 0.5 * person.ankle_height_m)]
    y, z = 0.0, person.ankle_height_m
    for segment, angle in zip(segments(person), person.stance_rad, strict=True):
        sine, cosine = np.sin(angle), np.cos(angle)
        parts.append((segment.mass_kg, y + segment.com_m * sine, z + segment.com_m * cosine))
        y, z = y + segment.length_m * sine, z + segment.length_m * cosine
    kg, forward, up = np.array(parts).T
    whole = float(kg.sum())
    return weight_of(whole, float(kg @ up) / whole, person.position_y_m + float(kg @ forward) / whole)


def test_a_body_without_joints_is_a_weight(shipped_truth):
    """The same mass and centre of mass, through the same frame: the stiffer the joints, the more alike."""
    rate, seconds = 64000.0, 0.4
    plate, drive = plate_of(shipped_truth, resonance_hz=35.0), drive_of(shipped_truth)
    below = [(plate, 1.0)]
    weight = weight_like(person_of(shipped_truth).person)
    assert weight.mass_kg == pytest.approx(78.0, rel=2e-4)
    alone = felt(plate, move_weight(weight, drive, PULSE, seconds, rate, below))
    apart = []
    for stiffness in (1e7, 1e8):
        subject = person_of(shipped_truth, stiffness)
        motion = move_person(subject, drive, PULSE, seconds, rate, generator(1, "p"), below)
        apart.append(np.abs(felt(plate, motion) - alone).max(axis=0)[[FY, FZ, MX]] / np.ptp(alone[:, FY]))
    assert (apart[1][[0, 2]] < 0.2 * apart[0][[0, 2]]).all()
    assert apart[1] == pytest.approx([0.0, 0.0, 0.0], abs=5e-3)


def resonance(motion, force):
    """Frequency of the largest ratio of a force (N) to the belt's acceleration, between 20 and 60 Hz."""
    a, f = (np.fft.rfft(x * np.hanning(x.size), 65536) for x in (motion.belt_acceleration, force))
    frequency = np.fft.rfftfreq(65536, motion.time[1] - motion.time[0])
    band = (frequency > 20.0) & (frequency < 60.0)
    return frequency[band][np.argmax(np.abs(f / a)[band])]


def test_the_resonance_falls_under_a_weight_and_hardly_under_a_person(shipped_truth):
    off = dict.fromkeys(("friction_N", "friction_coefficient", "belt_lag_s", "bristle_share"), 0.0)
    changes = off | {"resonance_hz": 35.0, "second_share": [0.0, 0.0]}
    plate, drive = plate_of(shipped_truth, **changes), drive_of(shipped_truth)
    below, found = [(plate, 1.0)], {}
    for name, weight in (("empty", None), ("weight", weight_of(78.0))):
        motion = move_weight(weight, drive, PULSE, SECONDS, RATE_HZ, below)
        found[name] = resonance(motion, felt(plate, motion)[:, FY])
    motion = move_person(person_of(shipped_truth), drive, PULSE, SECONDS, RATE_HZ, generator(1, "p"), below)
    found["person"] = resonance(motion, felt(plate, motion)[:, FY])
    assert found["empty"] == pytest.approx(35.0, abs=0.5)
    # by the log: the weight moves with the frame whatever the belt does on it
    assert found["weight"] == pytest.approx(35.0 * np.sqrt(150.0 / 228.0), abs=0.5)
    assert 33.0 < found["person"] <= found["empty"]


def test_a_mode_too_fast_for_the_steps_moves_nothing(shipped_truth):
    plate = plate_of(shipped_truth, resonance_hz=3000.0, second_share=[0.0, 0.0])
    drive = drive_of(shipped_truth)
    rigid = move_weight(weight_of(60.0), drive, PULSE, SECONDS, RATE_HZ)
    stiff = move_weight(weight_of(60.0), drive, PULSE, SECONDS, RATE_HZ, [(plate, 1.0)])
    assert np.array_equal(stiff.position, rigid.position)
    assert not stiff.frame_position.any()


def test_two_frames_share_a_load_and_move_it_by_their_parts(shipped_truth):
    """Two equal frames with half of the load each are one frame of twice the mass and stiffness."""
    plate, drive = plate_of(shipped_truth, **WITHOUT_BELT, resonance_hz=35.0), drive_of(shipped_truth)
    double = replace(plate, resonance_mass_kg=2.0 * plate.resonance_mass_kg)
    on_two = move_weight(weight_of(60.0), drive, PULSE, SECONDS, RATE_HZ, [(plate, 0.5)] * 2)
    on_one = move_weight(weight_of(60.0), drive, PULSE, SECONDS, RATE_HZ, [(double, 1.0)])
    assert on_two.position == pytest.approx(on_one.position, abs=1e-9)
    assert on_two.reaction == pytest.approx(on_one.reaction, abs=1e-5)


@pytest.mark.parametrize("load", ["weight", "dummy", "person"])
def test_a_pitch_like_the_first_mode_is_a_part_of_it(load, shipped_truth):
    """Two modes of the same frequency, damping and mass, which share the force, are one."""
    drive = drive_of(shipped_truth)

    def moved(**changes):
        plate = plate_of(shipped_truth, resonance_hz=35.0, **changes)
        task = drive, PULSE, SECONDS, RATE_HZ
        if load == "weight":
            return move_weight(weight_of(60.0), *task, [(plate, 1.0)])
        if load == "person":
            return move_person(person_of(shipped_truth), *task, generator(1, "p"), [(plate, 1.0)])
        dummy = shipped_truth["dummy"]
        rubber = Rubber(**dummy["rubber"] | {"relaxation_share": 0.2})
        foot = FootTilt(**dummy["foot_tilt"])
        return move_dummy(DummyTruth(**dummy["subject"]), rubber, *task, foot, [(plate, 1.0)])

    one = moved(second_share=[0.0, 0.0])
    same = {"second_hz": 35.0, "second_damping": 0.04, "second_mass_kg": 150.0}
    both = moved(second_share=[0.4, 0.0], **same)
    assert both.frame_position == pytest.approx(one.frame_position, abs=1e-6 * np.ptp(one.frame_position))
    assert both.position == pytest.approx(one.position, abs=1e-8)
    alone = moved(second_share=[0.4, 0.0], **same | {"second_mass_kg": 0.0})
    assert np.ptp(alone.frame_position) < 0.8 * np.ptp(one.frame_position)


def test_forces_are_logged_later_than_the_velocity(shipped_truth):
    motion = move_weight(weight_of(60.0), drive_of(shipped_truth), PULSE, SECONDS, RATE_HZ)
    at_once, late = (felt(plate_of(shipped_truth, force_delay_s=s), motion) for s in (0.0, 0.0015))
    assert late[3:] == pytest.approx(at_once[:-3], abs=1e-6 * np.abs(at_once).max())
    assert np.abs(late - at_once)[:, FY].max() > 10.0


def test_the_dummy_stands_on_belt_plus_frame(shipped_truth):
    """Stiff rubber and an upright leg: 2.5 kg move with the frame, by markers and by the plate."""
    plate, drive = plate_of(shipped_truth, **WITHOUT_BELT, resonance_hz=30.0), drive_of(shipped_truth)
    dummy = DummyTruth(**shipped_truth["dummy"]["subject"] | {"rest_angle_rad": 0.0})
    stiff, below = Rubber(3e4, 3.0, 0.0, 1.0, 0.0), [(plate, 1.0)]
    motion = move_dummy(dummy, stiff, drive, PULSE, SECONDS, RATE_HZ, below=below)
    weight = move_weight(weight_of(2.5), drive, PULSE, SECONDS, RATE_HZ, below)
    assert np.ptp(motion.frame_position) > 1e-5
    assert motion.frame_position == pytest.approx(
        weight.frame_position, abs=0.02 * np.ptp(weight.frame_position)
    )
    assert motion.reaction[:, FY] == pytest.approx(2.5 * motion.acceleration, abs=2.0)
