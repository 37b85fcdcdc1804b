"""Mechanisms of the virtual person, each by its own physics: skin, feet, muscles, short range, legs."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.signal import lsim
from standing_builders import LABELS, PERSON

from tepsipe.errors import InputError
from tepsipe.experiments.standing.free_reflex.free_body import parts_of_foot
from tepsipe.reporting.recovery import TrueMotion, linear_truth_standing
from tepsipe.virtual_lab.belt import DriveTruth, velocity_command
from tepsipe.virtual_lab.person import feet_of, move_person, segments, true_ankles
from tepsipe.virtual_lab.person_constants import (
    FOOT,
    MARKERS,
    MUSCLES,
    MuscleTruth,
    NervesTruth,
    PersonMarkers,
    PersonTruth,
    SkinTruth,
    Subject,
    TaskTruth,
)
from tepsipe.virtual_lab.person_mechanisms import MECHANISMS, without
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.standing_trial import marker_displacements, wobble

G = 9.81
FY, FZ, MX = 1, 2, 3
SHANK = slice(3, 5)
THIGH = slice(5, 8)
ONSET_S = 0.3


class Laboratory:
    """The shipped person after one pulse of the belt, with some of her constants changed."""

    def __init__(self, standing, drive, amplitude=0.4, seconds=0.9, task="relax", rate_hz=1000.0, **changes):
        self.person = PersonTruth(**standing["person"] | changes.get("person", {}))
        self.doing = TaskTruth(**standing["tasks"][task] | changes.get("task_changes", {}))
        self.nerves = NervesTruth(**standing["nerves"] | {"wander_Nm": 0.0} | changes.get("nerves", {}))
        self.markers = PersonMarkers(**standing["markers"] | changes.get("markers", {}))
        self.skin = SkinTruth(**standing["skin"] | changes.get("skin", {}))
        muscles = {name: MuscleTruth(**standing["muscles"][name]) for name in MUSCLES}
        self.motion = move_person(
            Subject(self.person, muscles, self.doing, self.nerves),
            DriveTruth(**drive),
            velocity_command("sine", amplitude, np.array([ONSET_S]), 0.1),
            seconds,
            rate_hz,
            generator(1, "mechanisms"),
        )
        self.ankles = true_ankles(self.person, self.doing, self.motion, 0.0)

    def places(self, **skin):
        """Marker -> place, forward of the ankle and above the belt (m)."""
        own = replace(self.skin, **skin)
        return dict(
            zip(MARKERS, marker_displacements(self.markers, self.person, own, self.motion), strict=True)
        )

    def fitted(self, window_s=0.06):
        """B and K of the nearest linear ankles."""
        own = TrueMotion(*(getattr(self.ankles, name) for name in TrueMotion.__dataclass_fields__))
        onset = np.array([ONSET_S + self.delay_s])
        return linear_truth_standing([own], [onset], window_s, False, (-0.1, -0.02))

    # of the drive, until the belt starts
    delay_s = 0.012


@pytest.fixture(scope="module")
def drive(shipped_truth):
    return shipped_truth["treadmill"]["drive"] | {"velocity_step_m_per_s": 0.0}


@pytest.fixture(scope="module")
def plain(shipped_truth):
    return without(shipped_truth["standing"])


@pytest.fixture(scope="module")
def shipped(shipped_truth, drive):
    return Laboratory(shipped_truth["standing"], drive)


@pytest.fixture(scope="module")
def ideal(plain, drive):
    return Laboratory(plain, drive)


# ---- what is on, and how to switch it off ---------------------------------------------------------


def test_mechanisms_without_a_switch_are_those_that_are_off(shipped_truth, plain):
    """Every mechanism but the drawn joint centre is on as shipped."""
    standing = shipped_truth["standing"]
    on = [name for name in MECHANISMS if without(standing, [name]) != standing]
    assert on == [name for name in MECHANISMS if name != "joint centre"]
    assert without(standing, []) == standing
    assert without(plain) == plain
    assert plain["skin"]["shank_share"] == plain["skin"]["thigh_share"] == 0.0
    assert plain["tasks"]["stiff"]["medium_reflex_s_per_rad"] == [0.0] * 5
    assert plain["person"]["foot_stiffness_Nm_per_rad"] == 0.0


def test_an_ideal_leg_is_rigid_and_its_foot_moves_with_the_belt(ideal):
    places = ideal.places()
    assert np.ptp(ideal.motion.foot) == 0.0
    for name in ("foot1", "foot2", "ankle"):
        assert np.ptp(places[name], axis=0) == pytest.approx([0.0, 0.0], abs=1e-15)
    for one, other in (("ankle", "shank1"), ("shank1", "shank2"), ("thigh1", "thigh3")):
        assert np.ptp(np.linalg.norm(places[one] - places[other], axis=1)) < 1e-12
    np.testing.assert_array_equal(ideal.ankles.marked_angle, ideal.ankles.angle)


# ---- skin ------------------------------------------------------------------------------------------


def test_soft_tissue_is_an_oscillator_under_the_acceleration_of_the_bone(shipped):
    """Against another simulation, driven by the acceleration of belt and bone."""
    bone = shipped.places(shank_share=0.0)["shank1"]
    found = shipped.places()["shank1"] - bone
    time = shipped.motion.time
    acceleration = CubicSpline(time, bone)(time, 2)[:, 0] + shipped.motion.belt_acceleration
    w = 2.0 * math.pi * 12.0
    _, x, _ = lsim(([-1.0], [1.0, 2.0 * 0.3 * w, w**2]), acceleration, time)
    assert found[:, 0] == pytest.approx(0.15 * x, abs=2e-3 * np.abs(x).max())
    assert 0.0003 < np.abs(found[:, 0]).max() < 0.001


def test_soft_tissue_follows_slow_motion_and_stays_behind_fast_motion(shipped):
    """Below its natural frequency the skin lags by a / w^2, far above it the skin stays in place."""
    time = np.arange(0.0, 8.0, 0.001)
    still = replace_motion(shipped.motion, time)
    for hz in (1.0, 12.0, 60.0):
        ratio = hz / 12.0
        gain = ratio**2 / math.hypot(1.0 - ratio**2, 0.6 * ratio)
        moved = np.column_stack([1e-3 * np.sin(2.0 * math.pi * hz * time), 0.0 * time])
        found = wobble(SkinTruth(12.0, 0.3), 1.0, still, moved)[time > 4.0, 0]
        assert np.abs(found).max() == pytest.approx(1e-3 * gain, rel=0.03)


def replace_motion(motion, time):
    still = np.zeros(time.size)
    return replace(motion, time=time, belt_acceleration=still, frame_acceleration=still)


def test_malleolus_slips_by_the_rotation_of_the_ankle(shipped):
    slid = shipped.places()["ankle"] - shipped.places(slip_m_per_rad=0.0)["ankle"]
    assert slid[:, 0] == pytest.approx(0.003 * shipped.ankles.marked_angle, abs=1e-15)
    assert not slid[:, 1].any()


# ---- feet ------------------------------------------------------------------------------------------


def test_feet_tilt_by_the_torque_over_their_stiffness_when_it_changes_slowly(plain, drive):
    """With little damping and long after the pulse, the foot is a spring in series with the ankle."""
    soft = {"foot_stiffness_Nm_per_rad": 4000.0, "foot_damping_Nms_per_rad": 0.0}
    found = Laboratory(plain, drive, seconds=1.6, person=soft)
    late = found.motion.time > 0.9
    torque = (found.ankles.torque + found.ankles.active)[late]
    assert found.motion.foot[late] == pytest.approx(torque / 4000.0, abs=0.01 * np.abs(torque).max() / 4000.0)


def test_plate_holds_the_ankles_torque_and_the_inertia_of_feet_that_tilt(shipped):
    """Moments about the ankles on the feet: plate, weight and inertia against intrinsic and active torque."""
    motion, person = shipped.motion, shipped.person
    force_y, force_z, moment = motion.reaction[:, [FY, FZ, MX]].T
    ankle_y, ankle_z = person.position_y_m + motion.belt_position, person.ankle_height_m
    about_ankle = moment - ankle_y * force_z + ankle_z * force_y
    feet = feet_of(person)
    rest = {"forward": person.foot_com_m, "below": -0.5 * person.ankle_height_m}
    forward = rest["forward"] * np.cos(motion.foot) + rest["below"] * np.sin(motion.foot)
    up = rest["below"] * np.cos(motion.foot) - rest["forward"] * np.sin(motion.foot)

    def twice(x):
        return CubicSpline(motion.time, x)(motion.time, 2)

    y_dd, z_dd = motion.belt_acceleration + twice(forward), twice(up)
    needed = feet.mass_kg * (forward * (z_dd + G) - up * y_dd) - feet.inertia_kgm2 * twice(motion.foot)
    torque = about_ankle - needed
    expected = shipped.ankles.torque + shipped.ankles.active
    assert torque - torque[0] == pytest.approx(expected, abs=0.003 * np.abs(expected).max())


def test_foot_that_tilts_obeys_its_equation(shipped):
    """Solved again by itself, under the torques and the belt of the whole person."""
    motion, person = shipped.motion, shipped.person
    feet = feet_of(person)
    inertia = feet.inertia_kgm2 + feet.mass_kg * (0.05**2 + 0.04**2)
    load = shipped.ankles.torque + shipped.ankles.active + feet.mass_kg * 0.04 * motion.belt_acceleration
    load = CubicSpline(motion.time, load)

    def rates(t, x):
        return x[1], (load(t) - 8000.0 * x[0] - 10.0 * x[1]) / inertia

    assert (person.foot_stiffness_Nm_per_rad, person.foot_damping_Nms_per_rad) == (8000.0, 10.0)
    solved = solve_ivp(rates, (0.0, 0.9), (0.0, 0.0), "DOP853", motion.time[:900], rtol=1e-8, max_step=2e-3)
    assert solved.y[0] == pytest.approx(motion.foot[:900], abs=0.01 * np.abs(motion.foot).max())


def test_arch_keeps_a_part_of_the_tilt_from_the_forefoot(shipped):
    """The heel behind the ankle rises, the forefoot sinks by half of what a rigid foot's would."""
    places, tilt = shipped.places(), 2.0 * 0.53 * shipped.motion.foot
    assert places["foot2"][:, 1] - 0.03 == pytest.approx(0.05 * tilt, abs=1e-6)
    assert places["foot1"][:, 1] - 0.03 == pytest.approx(-0.14 * 0.5 * tilt, abs=1e-6)


@pytest.mark.parametrize(("share", "stiffness"), [(1.0, 3000.0), (0.3, 8000.0)])
def test_analysis_finds_the_share_of_the_forefoot(shipped_truth, drive, share, stiffness):
    """Of a rigid foot on a soft sole, and of a soft foot."""
    person = {"forefoot_share": share, "foot_stiffness_Nm_per_rad": stiffness}
    places = Laboratory(shipped_truth["standing"], drive, seconds=0.5, person=person).places()
    moved = np.stack([places[label] - places[label][0] for label in LABELS], axis=1)
    moved[:, [LABELS.index(label) for label in PERSON.foot.labels]] += PERSON.foot.layout_m
    hind, fore = parts_of_foot(moved, list(LABELS), PERSON).T
    assert np.abs(hind).max() > 1e-3
    assert fore == pytest.approx(share * hind, abs=0.01 * np.abs(hind).max())


# ---- muscles and nerves ------------------------------------------------------------------------------


def test_medium_latency_reflex_repeats_the_stretch_later(plain, drive):
    """Drive above tone: a gain times the stretch a short and a medium latency ago, above the threshold."""
    standing = plain | {"nerves": plain["nerves"] | {"balance_Nm_per_rad": 0.0, "balance_Nms_per_rad": 0.0}}
    medium = {"medium_reflex_s_per_rad": [0.18, 0.16, 0.16, 0.18, 0.18]}
    found = Laboratory(standing, drive, seconds=0.6, task_changes=medium)
    motion = found.motion
    stretch = CubicSpline(motion.time, motion.rates[:, 0])
    sol = MUSCLES.index("SOL")

    def answered(latency_s):
        late = motion.time - latency_s
        return np.maximum(np.where(late > 0.0, stretch(late), 0.0) - 0.02, 0.0)

    expected = found.doing.tone[sol] + 0.22 * answered(0.042) + 0.16 * answered(0.07)
    assert motion.drive[:, sol] == pytest.approx(expected, abs=2e-4)
    # only the lengthening half of the motion is answered
    assert motion.drive[:, sol].min() == found.doing.tone[sol]
    assert motion.drive[:, sol].max() > found.doing.tone[sol] + 0.1


@pytest.mark.parametrize("relaxation_s", [0.0, 0.06, 0.1])
def test_force_follows_a_drive_by_its_twitch(plain, drive, relaxation_s):
    """Active torque from the drive, by another simulation of T T2 x'' + (T + T2) x' + x = e."""
    found = Laboratory(plain, drive, seconds=0.8, nerves={"relaxation_s": relaxation_s})
    rise, fall = 0.04, relaxation_s or 0.04
    over = found.motion.drive - np.array(found.doing.tone)
    force = np.array([-80.0, 150.0, 100.0, 0.0, 0.0])
    expected = sum(
        gain * lsim(([1.0], [rise * fall, rise + fall, 1.0]), column, found.motion.time)[1]
        for gain, column in zip(force, over.T, strict=True)
    )
    assert np.abs(expected).max() > 2.0
    assert found.motion.active == pytest.approx(expected, abs=0.005 * np.abs(expected).max())


# ---- short range -------------------------------------------------------------------------------------


def test_short_range_yields_after_its_rotation(plain, drive):
    """Dahl's element solved again, from the ankle's rate; its deflection never exceeds the range."""
    found = Laboratory(plain, drive, amplitude=0.5, task_changes={"short_range_Nm_per_rad": 200.0})
    rate = CubicSpline(found.motion.time, found.ankles.rate)
    solved = solve_ivp(
        lambda t, z: rate(t) - abs(rate(t)) * z / 0.004,
        (0.0, 0.85),
        (0.0,),
        "DOP853",
        found.motion.time[:850],
        rtol=1e-8,
        max_step=2e-3,
    )
    assert solved.y[0] == pytest.approx(found.motion.short_range[:850], abs=2e-5)
    assert 0.0039 < np.abs(found.motion.short_range).max() <= 0.004
    part = found.ankles.torque - 310.0 * found.ankles.angle - 8.0 * found.ankles.rate
    assert part == pytest.approx(200.0 * found.motion.short_range, abs=1e-9)


def test_stiffness_falls_from_the_whole_to_what_large_rotations_leave(plain, drive):
    """Smaller pulses find more of the short range, a tiny one all of it; without it K and B are exact."""
    found = [
        Laboratory(plain, drive, amplitude, task_changes={"short_range_Nm_per_rad": 200.0}).fitted()["K"]
        for amplitude in (0.001, 0.1, 0.2, 0.5)
    ]
    assert found[0] == pytest.approx(510.0, rel=0.02)
    assert 510.0 > found[0] > found[1] > found[2] > found[3] > 330.0
    linear = Laboratory(plain, drive).fitted()
    assert linear == pytest.approx({"B": 8.0, "K": 310.0}, rel=1e-3)


# ---- legs, joint and body ----------------------------------------------------------------------------


def test_marked_leg_bears_its_share_and_carries_the_same_hips(shipped):
    person, motion = shipped.person, shipped.motion
    assert shipped.ankles.marked_torque == pytest.approx(0.53 * shipped.ankles.torque)
    swung = motion.angles[:, 0] - person.stance_rad[0]
    expected = 1.01 * swung - 2.0 * 0.53 * motion.foot
    assert shipped.ankles.marked_angle == pytest.approx(expected, abs=1e-12)
    # the hip above the marked leg, found from two markers of its thigh, moves with the hips of both legs
    places = shipped.places(thigh_share=0.0)
    low, high = places["thigh3"], places["thigh1"]
    hip = low + (high - low) * (segments(person)[1].length_m - 0.06) / 0.24
    middle = sum(
        part.length_m * np.sin(angle)
        for part, angle in zip(segments(person)[:2], motion.angles[:, :2].T, strict=True)
    )
    assert np.ptp(hip[:, 0] - middle) < 0.01 * np.ptp(middle)


def test_joint_lies_beside_the_marker_by_its_offset(plain, drive):
    """The bone turns about the joint, so the malleolus, which lies 4 mm behind it and 3 mm below, moves."""
    found = Laboratory(plain, drive, markers={"joint_centre_m": [0.004, 0.003]})
    places, angle = found.places(), found.motion.angles[:, 0]
    at = np.array([0.0, 0.08])
    expected = at + np.column_stack(
        [
            -0.004 * np.cos(angle) - 0.003 * np.sin(angle),
            -0.003 * np.cos(angle) + 0.004 * np.sin(angle),
        ]
    )
    np.testing.assert_allclose(places["ankle"], expected, atol=1e-15)
    # the layout that was measured from the malleolus stays what it was
    distance = np.linalg.norm(places["shank1"] - places["ankle"], axis=1)
    assert distance == pytest.approx(math.hypot(0.025, 0.37), abs=1e-12)
    assert places["foot1"][0] == pytest.approx([0.136, 0.027])


def test_heavier_legs_leave_the_upper_body_less(shipped_truth):
    standing = shipped_truth["standing"]["person"]
    usual, heavy = (PersonTruth(**standing | {"foot_mass": mass}) for mass in (FOOT[1], 0.015))

    def whole(person):
        return feet_of(person).mass_kg + sum(part.mass_kg for part in segments(person))

    assert whole(heavy) == pytest.approx(whole(usual), rel=1e-12)
    assert feet_of(heavy).mass_kg == pytest.approx(2.0 * 0.015 * 64.0)
    assert feet_of(heavy).inertia_kgm2 / feet_of(usual).inertia_kgm2 == pytest.approx(0.015 / FOOT[1])
    assert segments(heavy)[2].mass_kg < segments(usual)[2].mass_kg


# ---- truth of what was fitted ------------------------------------------------------------------------


def swaying(torque):
    """Three pulses of an ankle that drifts: each response counts from its own rest."""
    t = np.arange(0.0, 12.0, 0.002)
    angle = 0.003 * np.sin(0.7 * t)
    for onset in (2.0, 5.0, 8.0):
        u = np.clip(t - onset, 0.0, None)
        angle = angle + 0.02 * np.sin(31.0 * u) * np.exp(-6.0 * u)
    rate = np.gradient(angle, t)
    acceleration = np.gradient(rate, t)
    return TrueMotion(t, angle, rate, acceleration, torque(acceleration, rate, angle))


ONSETS_S = np.array([2.0, 5.0, 8.0])
BASELINE_S = (-0.1, -0.02)


@pytest.mark.parametrize("inertia", [False, True])
def test_truth_of_linear_ankles_is_theirs(inertia):
    motion = swaying(lambda a, w, th: (0.02 * a if inertia else 0.0) + 8.0 * w + 370.0 * th + 40.0)
    found = linear_truth_standing([motion, motion], [ONSETS_S, ONSETS_S[:2]], 0.06, inertia, BASELINE_S)
    expected = {"B": 8.0, "K": 370.0} | ({"I": 0.02} if inertia else {})
    assert found == pytest.approx(expected, rel=1e-6)


def test_truth_without_motion_is_refused():
    still = swaying(lambda a, w, th: 370.0 * th)
    with pytest.raises(InputError, match=r"expected motion within 0\.06 s after every onset, found none"):
        linear_truth_standing([replace(still, angle=0.0 * still.angle)], [ONSETS_S], 0.06, False, BASELINE_S)
