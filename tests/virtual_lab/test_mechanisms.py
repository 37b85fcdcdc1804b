"""What a real laboratory has and a kind one leaves out: energy, symmetric limits and cases worked by hand."""

import copy
import math
from dataclasses import replace

import ezc3d
import numpy as np
import pytest
from plate_builders import plate_voltages, pressed

from tepsipe.virtual_lab.belt import DriveTruth
from tepsipe.virtual_lab.dummy import DummyMarkers, DummyTruth, FootTilt, dummy_marker_paths, move_dummy
from tepsipe.virtual_lab.dummy_trial import Wobble, make_dummy_trial, slipping, wobbling
from tepsipe.virtual_lab.force_plate import (
    PlateTruth,
    belt_wrench,
    bristle_deflection,
    plate_electronics,
)
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_trial import Protocol
from tepsipe.virtual_lab.wristalyzer_trial import ManipulatorTruth, record_manipulator

RATE_HZ = 2000.0
FY, MX = 1, 3
STEEL = Rubber(10.0, 0.0, 0.0, 0.05, 0.0)
TILTING = FootTilt(compliance_rad_per_Nm=0.01, damping_ratio=0.0, foot_inertia_kgm2=0.006)


def plate_of(truth, **changes):
    off = ("bristle_share", "friction_lever_m", "felt_belt_mass_kg", "felt_roller_inertia_kgm")
    plain = truth["treadmill"]["plate"] | dict.fromkeys(off, 0.0) | {"second_share": [0.0, 0.0]}
    return PlateTruth(**plain | changes)


# ---- friction of the belt ------------------------------------------------------------------------


def test_bristles_bend_first_and_slide_later():
    path = np.linspace(0.0, 0.005, 500)
    z = bristle_deflection(path, 0.0005)
    assert z == pytest.approx(1.0 - np.exp(-path / 0.0005), abs=1e-12)
    # turned round, they bend back from where they were
    back = bristle_deflection(np.concatenate([path, path[::-1]]), 0.0005)[500:]
    assert back == pytest.approx(-1.0 + (z[-1] + 1.0) * np.exp(-(0.005 - path[::-1]) / 0.0005), abs=1e-9)


def test_bristles_depend_on_the_path_and_not_on_its_speed():
    slow = 0.002 * np.sin(np.linspace(0.0, 9.0, 9001))
    fast = bristle_deflection(slow[::10], 0.0005)
    assert fast == pytest.approx(bristle_deflection(slow, 0.0005)[::10], abs=2e-3)
    assert bristle_deflection(-slow, 0.0005) == pytest.approx(-bristle_deflection(slow, 0.0005))
    assert np.abs(fast).max() < 1.0


def test_small_movements_are_elastic_and_large_ones_lose_energy():
    turn = np.linspace(0.0, 20.0 * math.pi, 20001)

    def lost(amplitude):
        """Work of ten cycles over what Coulomb friction of the same size takes."""
        x = amplitude * np.sin(turn)
        z = bristle_deflection(x, 0.001)
        return np.sum(0.5 * (z[1:] + z[:-1]) * np.diff(x)) / (40.0 * amplitude)

    assert lost(1e-6) < 1e-3
    assert 0.0 < lost(3e-4) < lost(3e-3) < lost(0.1) < 1.0
    assert lost(0.1) == pytest.approx(1.0, abs=0.03)


def test_a_force_stays_behind_after_a_pulse(shipped_truth):
    time = np.arange(2000) / RATE_HZ
    velocity = 0.3 * np.sin(2.0 * np.pi * 10.0 * time) * (time < 0.1)
    acceleration, load = np.gradient(velocity, time), np.full(2000, 196.2)
    own = {"friction_Ns_per_m": 0.0, "friction_N": 15.0, "friction_coefficient": 0.1, "bristle_m": 0.0005}

    def force(share):
        plate = plate_of(shipped_truth, bristle_share=share, **own)
        return belt_wrench(plate, load, velocity, acceleration, np.zeros(2000), RATE_HZ)[:, FY]

    assert np.abs(force(0.0)[-100:]).max() == 0.0
    # the belt comes back 9.5 mm: bristles of 0.5 mm are bent backwards to the full
    assert force(0.2)[-1] == pytest.approx(-0.2 * (15.0 + 19.62), rel=1e-3)
    assert np.ptp(force(0.2)[-100:]) == 0.0
    assert force(0.2).max() == pytest.approx(
        0.2 * 34.62 + 0.8 * 34.62 * math.tanh(0.3 / own_speed(shipped_truth)), rel=1e-3
    )


def own_speed(truth):
    return truth["treadmill"]["plate"]["friction_speed_m_per_s"]


def test_friction_below_the_belt_has_a_moment(shipped_truth):
    velocity, still = np.full(3, 0.4), np.zeros(3)
    wrench = belt_wrench(plate_of(shipped_truth), np.full(3, 200.0), velocity, still, still, RATE_HZ)
    assert (wrench[:, MX] == 0.0).all()
    assert wrench[0, FY] > 5.0
    plate = plate_of(shipped_truth, friction_lever_m=0.05)
    moved = belt_wrench(plate, np.full(3, 200.0), velocity, still, still, RATE_HZ)
    assert moved[:, FY] == pytest.approx(wrench[:, FY])
    # M_x = y F_z - z F_y, 0.05 m below the belt
    assert moved[:, MX] == pytest.approx(0.05 * wrench[:, FY])


# ---- frame ---------------------------------------------------------------------------------------


def ringing(truth, **changes):
    """Fy and Mx at 1000 Hz after steps of 10 N and 2 N·m."""
    off = ("sensitivity_spread", "cross_talk", "calibration_error", "noise_V", "drift_V_per_s", "mount_share")
    quiet = dict.fromkeys((*off, "floor_m_per_s2", "vertical_leak", "origin_height_m"), 0.0)
    plate = plate_of(truth, **quiet | {"force_scale": [1.0, 1.0]} | changes)
    n, still = 4000, np.zeros(4000)
    step = (np.arange(n) >= 10).astype(float)
    reaction = np.column_stack([still, 10.0 * step, still, 2.0 * step, still, still])
    volts, matrix = plate_electronics(plate, generator(1, "plate"))
    sample = np.arange(0, n, 2)
    motion = pressed(reaction, RATE_HZ)
    seen = plate_voltages(plate, volts, motion, sample, generator(1, "trial"))
    return (seen @ matrix.T)[:, [6 + FY, 6 + MX]]


def lines_of(signal):
    """Frequencies of the two largest peaks of the spectrum (Hz)."""
    spectrum = np.abs(np.fft.rfft((signal - signal[-1]) * np.hanning(2 * signal.size)[signal.size :], 32768))
    peaks = np.flatnonzero((spectrum[1:-1] > spectrum[:-2]) & (spectrum[1:-1] > spectrum[2:])) + 1
    largest = peaks[np.argsort(spectrum[peaks])[-2:]]
    return sorted(largest * 1000.0 / 32768)


def test_both_modes_of_the_frame_ring(shipped_truth):
    own = {"resonance_hz": 50.0, "resonance_damping": 0.01, "resonance_mass_kg": 150.0}
    own |= {"second_hz": 90.0, "second_damping": 0.01, "second_share": [0.3, 0.5]}
    felt = ringing(shipped_truth, **own)
    for column in (0, 1):
        assert lines_of(felt[20:, column]) == pytest.approx([50.0, 90.0], abs=0.2)
    # slowly, both together pass all of the load
    assert felt[-200:].mean(axis=0) == pytest.approx([10.0, 2.0], rel=1e-3)


def test_equal_modes_are_one(shipped_truth):
    one = ringing(shipped_truth)
    plate = shipped_truth["treadmill"]["plate"]
    same = {f"second_{key}": plate[f"resonance_{key}"] for key in ("hz", "damping")}
    assert ringing(shipped_truth, second_share=[0.4, 0.7], **same) == pytest.approx(one, abs=1e-9)


# ---- the rubber that relaxes -------------------------------------------------------------------------


RELAXING = replace(STEEL, relaxation_share=0.2, relaxation_s=(0.05,))


def swing(subject, rubber, duration_s=1.0, foot=None):
    heavy = loose_drive(belt_mass_kg=1e6, force_limit_N=4e5)
    return move_dummy(subject, rubber, heavy, push, duration_s, RATE_HZ, foot)


def test_relaxing_rubber_is_stiffer_when_quick_and_its_old_self_when_slow(subject):
    slow, quick = (replace(RELAXING, relaxation_s=(time_s,)) for time_s in (1e4, 1e-3))
    rest = 0.4 * 9.81 * 0.4485 * math.sin(0.02)
    # quicker than the slack: a stiffer spring that was as bent at rest
    stiffer = replace(STEEL, stiffness_Nm_per_rad=12.0)
    found, expected = swing(subject, slow), swing(subject, stiffer)
    assert found.angle == pytest.approx(expected.angle, abs=1e-3 * np.ptp(expected.angle))
    assert found.joint_torque[-1] == pytest.approx(
        rest + 12.0 * (found.angle[-1] - 0.02), abs=1e-3 * np.ptp(found.joint_torque)
    )
    # slower than it: k T of damping is left
    damped = replace(STEEL, damping_Nms_per_rad=0.2 * 10.0 * 1e-3)
    found, expected = swing(subject, quick), swing(subject, damped)
    assert found.angle == pytest.approx(expected.angle, abs=0.01 * np.ptp(expected.angle))


@pytest.mark.parametrize("foot", [None, TILTING])
def test_energy_of_a_relaxing_rubber_is_what_its_dashpot_takes(subject, foot):
    """Work of the joint's torque on the bending is stored in two springs or lost in the dashpot."""
    motion = swing(subject, RELAXING, 0.6, foot)
    neutral = 0.02 - 0.4 * 9.81 * 0.4485 * math.sin(0.02) / 10.0
    bent = motion.angle - motion.tilt - neutral
    stretch = (motion.joint_torque - 10.0 * bent) / 2.0  # of the spring in series: k = 2 N·m/rad
    bending = np.diff(bent)
    work = np.sum(0.5 * (motion.joint_torque[1:] + motion.joint_torque[:-1]) * bending)
    stored = 0.5 * 10.0 * (bent[-1] ** 2 - bent[0] ** 2) + 0.5 * 2.0 * (stretch[-1] ** 2 - stretch[0] ** 2)
    lost = np.sum(2.0 * (0.5 * (stretch[1:] + stretch[:-1])) ** 2) / RATE_HZ / 0.05
    assert stretch[0] == pytest.approx(0.0, abs=1e-9)
    assert lost > 0.05 * abs(work)
    assert work == pytest.approx(stored + lost, abs=2e-3 * lost)


@pytest.mark.parametrize("foot", [None, TILTING])
def test_friction_of_the_rubber_follows_the_bending_of_the_joint(subject, foot):
    """The torque beyond the spring is that of bristles along the path of leg and foot."""
    motion = swing(subject, replace(STEEL, bristle_Nm_per_rad=3.0, bristle_rad=0.01), 0.6, foot)
    neutral = 0.02 - 0.4 * 9.81 * 0.4485 * math.sin(0.02) / 10.0
    bent = motion.angle - motion.tilt - neutral
    expected = 3.0 * 0.01 * bristle_deflection(bent - bent[0], 0.01)
    assert np.ptp(expected) > 0.01
    assert motion.joint_torque - 10.0 * bent == pytest.approx(expected, abs=1e-3 * np.ptp(expected))


def test_manipulator_feels_the_rubber_relax(shipped_truth):
    """The mean torque over the mean angle of a joint that is pushed slowly and quickly, by hand."""
    own = dict.fromkeys(("contact_Nm_per_rad3", "friction_Nm", "ripple_Nm"), 0.0)
    rig = shipped_truth["wristalyzer"]["manipulator"] | own | {"torque_scale": 1.0}
    rig |= {"band_low_hz": 2.0, "band_high_hz": 2.0, "period_s": 0.5, "lead_s": 0.0, "tail_s": 0.0}
    rubber = Rubber(10.0, 0.1, 0.0, 0.05, 0.0, relaxation_share=0.2, relaxation_s=(0.05,))
    rngs = generator(1, "a"), generator(1, "b")
    motion = record_manipulator(ManipulatorTruth(**rig), rubber, 0.1, 8.0, *rngs).motion
    late = (motion.time > 6.0) & (motion.time <= 8.0)
    line = np.exp(-2j * np.pi * 2.0 * motion.time[late])
    s = 2j * np.pi * 2.0
    expected = 10.0 + 0.1 * s + 0.015 * s**2 + 2.0 * 0.05 * s / (1.0 + 0.05 * s)
    found = (line @ motion.torque[late]) / (line @ motion.angle[late])
    assert abs(found / expected - 1.0) < 5e-3


# ---- the foot on its tape --------------------------------------------------------------------------


def loose_drive(**changes):
    drive = DriveTruth(5.0, 1e-12, 1e12, 4.0, 0.0, 0.0, 0.0, 0.0)
    return replace(drive, **changes)


def push(t):
    return np.where(t < 0.1, 1e30, 0.0)


@pytest.fixture(scope="module")
def subject(shipped_truth):
    own = {"joint_inertia_kgm2": 0.0, "rest_angle_rad": 0.02}
    return DummyTruth(**shipped_truth["dummy"]["subject"] | own)


@pytest.fixture(scope="module")
def tilting(subject):
    return move_dummy(subject, STEEL, loose_drive(), push, 1.0, RATE_HZ, TILTING)


def test_energy_is_kept_while_the_foot_tilts(subject, tilting):
    m, r, g, h, mf, up = 0.4, 0.4485, 9.81, 0.055, 2.1, 0.0275
    rest = m * g * r * math.sin(0.02)
    neutral = 0.02 - rest / 10.0
    v, w, th, x, ph = (
        tilting.belt_velocity,
        tilting.angle_rate,
        tilting.angle,
        tilting.tilt_rate,
        tilting.tilt,
    )
    moving = 0.5 * 5.0 * v**2 + 0.5 * mf * (v + up * x) ** 2 + 0.5 * 0.006 * x**2 + 0.5 * 0.027 * w**2
    moving += 0.5 * m * ((v + h * x + r * np.cos(th) * w) ** 2 + (r * np.sin(th) * w) ** 2)
    stored = m * g * r * np.cos(th) + 0.5 * 10.0 * (th - ph - neutral) ** 2 + 0.5 * 100.0 * ph**2
    found = moving + stored + rest * ph - 0.5 * (mf * up + m * h) * g * ph**2
    after = tilting.time > 0.11
    assert np.abs(ph).max() > 5e-4
    assert found[-1] - found[0] > 0.001
    assert np.ptp(found[after]) < 1e-5 * (found[-1] - found[0])


def test_impulse_of_the_plate_is_the_momentum_of_a_tilting_foot_and_leg(tilting):
    leg = tilting.belt_velocity + 0.055 * tilting.tilt_rate
    leg = leg + 0.4485 * np.cos(tilting.angle) * tilting.angle_rate
    momentum = 2.1 * (tilting.belt_velocity + 0.0275 * tilting.tilt_rate) + 0.4 * leg
    fy = tilting.reaction[:, FY]
    impulse = np.concatenate([[0.0], np.cumsum(0.5 * (fy[1:] + fy[:-1]) / RATE_HZ)])
    assert impulse == pytest.approx(momentum, abs=3e-3 * np.ptp(momentum))


def test_support_feels_what_the_plate_feels_about_it(tilting):
    # slow compared with the foot: the moment about the point under the ankle is that of the tape
    _, _, fz, mx, _, _ = tilting.reaction.T
    about = mx - (0.05 + tilting.belt_position) * fz
    after = tilting.time > 0.15
    tape = 100.0 * tilting.tilt + about[0]
    assert np.ptp(tape[after]) > 0.05
    assert (about - tape)[after] == pytest.approx(np.zeros(after.sum()), abs=0.01 * np.ptp(tape[after]))


def test_stiff_tape_is_no_tape(subject):
    stiff = replace(TILTING, compliance_rad_per_Nm=1e-5, damping_ratio=0.7)
    plain, held = (
        move_dummy(subject, STEEL, loose_drive(), push, 0.6, RATE_HZ, foot) for foot in (None, stiff)
    )
    assert held.angle == pytest.approx(plain.angle, abs=2e-4 * np.ptp(plain.angle))
    moment, after = plain.reaction[:, MX], plain.time > 0.15
    assert held.reaction[after, MX] == pytest.approx(moment[after], abs=0.01 * np.ptp(moment))
    off = move_dummy(
        subject, STEEL, loose_drive(), push, 0.6, RATE_HZ, replace(stiff, compliance_rad_per_Nm=0.0)
    )
    assert (off.angle == plain.angle).all()
    assert not off.tilt.any()


def test_markers_on_a_tilted_foot_turn_about_the_belt(subject, shipped_truth, tilting):
    layout = DummyMarkers(**shipped_truth["dummy"]["markers"])
    paths = dummy_marker_paths(layout, subject, tilting)
    k = 800
    at, ph, th = tilting.time[[k]], tilting.tilt[k], tilting.angle[k]
    y = 0.05 + tilting.belt_position[k]
    toe = paths[1](at)[0]
    assert toe[1:] == pytest.approx([y + 0.04 + 0.015 * ph, 0.015 - 0.04 * ph], abs=1e-9)
    ankle = paths[3](at)[0]
    assert ankle[1:] == pytest.approx([y + 0.055 * ph, 0.055], abs=1e-9)
    top = paths[4](at)[0] - ankle
    assert top[1] == pytest.approx(-0.012 * math.cos(th) + 0.6 * math.sin(th), abs=1e-9)


# ---- markers ---------------------------------------------------------------------------------------


def test_wobbling_mass_lags_behind_a_steady_push_and_rings_at_its_frequency():
    wobble = Wobble(hz=10.0, damping=0.05, common=1.0, growing_per_m=0.0)
    time = np.arange(8000) / RATE_HZ
    lag = wobbling(wobble, time, np.full(8000, 2.0))
    assert lag[-1] == pytest.approx(-2.0 / (20.0 * math.pi) ** 2, rel=1e-3)
    assert lag.min() == pytest.approx(lag[-1] * (1.0 + math.exp(-math.pi * 0.05)), rel=0.01)
    assert time[np.argmin(lag)] == pytest.approx(0.05, abs=0.001)


def test_slipping_marker_steps_at_every_pulse_and_stays():
    onsets = np.array([1.0, 2.0])
    shift = slipping(0.001, 0.02, onsets, np.random.default_rng(1))
    first, second = 0.001 * np.random.default_rng(1).standard_normal(2)
    found = shift(np.array([0.5, 1.02, 1.9, 3.0]))
    assert found == pytest.approx([0.0, first * (1.0 - math.exp(-1.0)), first, first + second], abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("section", "changes", "moved"),
    [
        ("slip", {"foot_m": 0.001}, ["foot1", "foot2", "foot3"]),
        ("slip", {"ankle_m": 0.001}, ["ankle"]),
        ("wobble", {"common": 0.3, "hz": 12.0}, ["ankle", "leg1", "leg2", "leg3", "leg4"]),
        ("wobble", {"growing_per_m": 0.3, "hz": 12.0}, ["leg1", "leg2", "leg3", "leg4"]),
    ],
)
def test_only_loose_markers_move(shipped_truth, section, changes, moved, tmp_path):
    truth = copy.deepcopy(shipped_truth)
    truth["treadmill"]["protocol"] |= {"rest_before_s": 0.5, "rest_after_s": 0.5}
    truth["dummy"] |= {
        "wobble": truth["dummy"]["wobble"] | {"common": 0.0, "growing_per_m": 0.0},
        "slip": truth["dummy"]["slip"] | {"foot_m": 0.0, "ankle_m": 0.0},
    }
    names = {"log": "log.mat", "calibration": "calibration.csv", "markers": "markers.c3d"}
    files = {kind: tmp_path / name for kind, name in names.items()}
    seen = []
    for own in ({}, changes):
        truth["dummy"][section] |= own
        make_dummy_trial(truth, "sine-0.5", Protocol("sine", 0.5, 1.0, 2.2), files)
        seen.append(positions(files["markers"]))
    difference = np.nanmax(np.abs(seen[1] - seen[0]), axis=(0, 2))
    labels = ["foot1", "foot2", "foot3", "ankle", "leg1", "leg2", "leg3", "leg4"]
    assert [label for label, d in zip(labels, difference, strict=True) if d > 2e-5] == moved
    assert difference.max() < 0.005


def positions(path):
    """Markers (m), shape (frames, markers, 3)."""
    return ezc3d.c3d(str(path))["data"]["points"][:3].transpose(2, 1, 0) / 1000.0
