"""Free bodies of a standing person: by hand, by Newton and Euler, and on an exactly integrated pendulum."""

from dataclasses import replace

import numpy as np
import pytest
from builders import RATE_HZ
from standing_builders import LEAN_RAD, PERSON, USUAL, Z_A, plate_wrench, sway, true_torque

from tepsipe.mechanics.anthropometry import Feet, StandingBody, both_feet, standing_body
from tepsipe.mechanics.inverse_dynamics import (
    Foot,
    Leg,
    PlateLoad,
    foot_torque,
    leg_torque,
    single_joint_torque,
    standing_torque,
    standing_torque_as_printed,
)

G = 9.81
FEET = Feet(mass_kg=2.0, inertia_kgm2=0.03)
WEIGHT = 2.0 * G  # of the feet
Y_A, Z_ANKLE, Y_F, Z_F = 0.12, 0.08, 0.17, 0.04


def one(value):
    return np.array([float(value)])


def load(f_y, f_z, m_x):
    return PlateLoad(one(f_y), one(f_z), one(m_x))


def by_feet(plate, com_dd=(0.0, 0.0), angle_dd=0.0, feet=FEET, com=(Y_F, Z_F)):
    """Torque of feet whose ankles are at (0.12, 0.08) m."""
    ankle = np.array([[Y_A, Z_ANKLE]])
    return standing_torque(feet, G, plate, ankle, np.array([com]), np.array([com_dd]), one(angle_dd))


# ---- feet, by hand -----------------------------------------------------------------------------


def test_body_that_leans_forward_at_rest_is_held_by_its_weight_times_its_lever():
    # 60 kg with its centre 0.03 m in front of the ankles, feet of 2 kg with theirs 0.05 m in front
    m_x = (60.0 * 0.15 + 2.0 * 0.17) * G
    torque = by_feet(load(0.0, 62.0 * G, m_x))
    assert torque == pytest.approx(60.0 * G * 0.03)
    # the same from the centre of pressure, 9.34 / 62 m
    pressure = 9.34 / 62.0
    assert torque == pytest.approx(62.0 * G * (pressure - Y_A) - WEIGHT * 0.05)


def test_body_that_leans_backward_is_held_the_other_way():
    m_x = (60.0 * 0.10 + 2.0 * 0.17) * G
    assert by_feet(load(0.0, 62.0 * G, m_x)) == pytest.approx(-60.0 * G * 0.02)


def test_horizontal_force_has_the_height_of_the_ankles_as_its_lever():
    nothing = Feet(0.0, 0.0)
    # pulled with 10 N at the ankles, massless feet press on the plate 0.8 Nm further back
    assert by_feet(load(10.0, 0.0, -0.8), feet=nothing) == pytest.approx(0.0, abs=1e-12)
    # pulled with 10 N where they touch the plate, they need the ankles' 10 N x 0.08 m
    assert by_feet(load(10.0, 0.0, 0.0), feet=nothing) == pytest.approx(0.8)


BARE = {
    # load of the plate on feet without a body: what moves them, about the plate's origin
    "at rest": (load(0.0, WEIGHT, 0.17 * WEIGHT), {}),
    "pushed forward by 4 m/s2": (load(8.0, WEIGHT, 0.17 * WEIGHT - 0.04 * 8.0), {"com_dd": (4.0, 0.0)}),
    "lifted by 1.5 m/s2": (load(0.0, WEIGHT + 3.0, 0.17 * (WEIGHT + 3.0)), {"com_dd": (0.0, 1.5)}),
    # towards +y is against a right-handed turn about x
    "turned by 5 rad/s2": (load(0.0, WEIGHT, 0.17 * WEIGHT - 0.03 * 5.0), {"angle_dd": 5.0}),
}


@pytest.mark.parametrize("how", BARE)
def test_bare_feet_need_no_torque_when_they_are(how):
    plate, motion = BARE[how]
    assert by_feet(plate, **motion) == pytest.approx(0.0, abs=1e-12)
    if motion:
        assert np.abs(by_feet(plate)) > 0.05


def test_any_motion_of_the_feet_gives_the_torque_that_moved_them(rng):
    y_a, z_a, y_f, z_f, y_dd, z_dd, turn, r_y, r_z, torque = rng.standard_normal((10, 50))
    m, i = FEET.mass_kg, FEET.inertia_kgm2
    # Newton and Euler about the plate's origin, with the ankles' force (r_y, r_z) and -torque on the feet
    f_y, f_z = m * y_dd - r_y, m * (z_dd + G) - r_z
    m_x = m * (y_f * (z_dd + G) - z_f * y_dd) - i * turn - (y_a * r_z - z_a * r_y) + torque
    found = standing_torque(
        FEET,
        G,
        PlateLoad(f_y, f_z, m_x),
        np.column_stack([y_a, z_a]),
        np.column_stack([y_f, z_f]),
        np.column_stack([y_dd, z_dd]),
        turn,
    )
    assert found == pytest.approx(torque, abs=1e-10)


def test_torque_does_not_depend_on_where_the_plate_has_its_origin():
    m_x = (60.0 * 0.15 + 2.0 * 0.17) * G
    here = by_feet(load(25.0, 62.0 * G, m_x), (4.0, 0.0))
    ankle, com = np.array([[Y_A + 0.4, Z_ANKLE]]), np.array([[Y_F + 0.4, Z_F]])
    plate = load(25.0, 62.0 * G, m_x + 0.4 * 62.0 * G)
    there = standing_torque(FEET, G, plate, ankle, com, np.array([[4.0, 0.0]]), one(0.0))
    assert there == pytest.approx(here)


def test_feet_of_the_dummy_have_the_torque_of_the_dummys_foot(rng):
    f_y, f_z, m_x, y_a, y_a_dd = rng.standard_normal((5, 20))
    zero, height = np.zeros(20), np.full(20, 0.055)
    found = standing_torque(
        Feet(2.1, 0.5),
        G,
        PlateLoad(f_y, f_z, m_x),
        np.column_stack([y_a, height]),
        np.column_stack([y_a, 0.5 * height]),
        np.column_stack([y_a_dd, zero]),
        zero,
    )
    assert found == pytest.approx(foot_torque(Foot(2.1, 0.055), f_y, f_z, m_x, y_a, y_a_dd), abs=1e-12)


# ---- eq (3-14) as printed ----------------------------------------------------------------------


def printed(plate, com_dd=(0.0, 0.0), feet=FEET, gravity=G, metre=1.0, vectors=False):
    """The printed torque of feet with their centre at (0.17, 0.05) m, in a unit of so many metres."""
    ankle, com = np.array([[Y_A, Z_ANKLE]]) / metre, np.array([[Y_F, 0.05]]) / metre
    return standing_torque_as_printed(feet, gravity, plate, ankle, com, np.array([com_dd]), vectors)


def test_vector_products_are_minus_the_torque_on_the_body_if_the_feet_do_not_turn(rng):
    f_y, f_z, m_x, y_a, z_a, y_f, z_f, y_dd, z_dd = rng.standard_normal((9, 50))
    motion = (*(np.column_stack(x) for x in ((y_a, z_a), (y_f, z_f), (y_dd, z_dd))),)
    plate, flat = PlateLoad(f_y, f_z + 10.0, m_x), np.zeros(50)
    consistent = standing_torque(FEET, G, plate, *motion, flat)
    garbled = -FEET.inertia_kgm2 + FEET.mass_kg * np.hypot(y_f - y_a, z_f - z_a)
    vectors = standing_torque_as_printed(FEET, G, plate, *motion, True)
    assert vectors == pytest.approx(-consistent + garbled, rel=1e-12, abs=1e-12)
    scalars = standing_torque_as_printed(FEET, G, plate, *motion, False)
    assert np.abs(scalars - vectors).max() > 10.0
    # the feet's own turn is the one thing that the vectors miss
    turned = standing_torque(FEET, G, plate, *motion, flat + 7.0)
    assert vectors + turned - garbled == pytest.approx(7.0 * FEET.inertia_kgm2, abs=1e-12)


def test_vector_products_have_the_sign_of_the_torque_on_the_feet_in_eq_3_7():
    # eq (3-7) of the dummy's foot, m_f y'' = 0: F_y l_f / 2 - F_Ay l_f / 2 + tau_A = 0 with F_Ay = -F_y
    flat, plate = np.array([[0.0, Z_ANKLE]]), load(10.0, WEIGHT, 0.0)
    middle = np.array([[0.0, 0.5 * Z_ANKLE]])
    nothing = Feet(FEET.mass_kg, FEET.mass_kg * 0.5 * Z_ANKLE)  # whose garbled terms cancel
    found = standing_torque_as_printed(nothing, G, plate, flat, middle, np.zeros((1, 2)), True)
    assert found == pytest.approx(-10.0 * Z_ANKLE)


def test_torque_of_scalars_is_the_sum_of_its_terms():
    terms = (
        (0.12 - 90.0 / 600.0) * 20.0,  # (y_A - y_CoP) F_y = -0.6
        -(0.12 - 0.17) * 2.0 * 3.0,  # -(y_A - y_f) m_f y_f'' = 0.3
        -(0.12 - 0.17) * 2.0 * 9.81,  # -(y_A - y_f) m_f g = 0.981
        -0.03,  # -I_f
        2.0 * 0.0583095,  # m_f r_Af, 0.05 m in front and 0.03 m below
    )
    assert sum(terms) == pytest.approx(0.767619)
    assert printed(load(20.0, 600.0, 90.0), (3.0, 0.0)) == pytest.approx(sum(terms), rel=1e-6)


def test_only_vectors_see_how_far_a_body_leans():
    upright = printed(load(0.0, 62.0 * G, (60.0 * Y_A + 2.0 * Y_F) * G))
    leaning = printed(load(0.0, 62.0 * G, (60.0 * (Y_A + 0.05) + 2.0 * Y_F) * G))
    assert leaning == pytest.approx(upright)
    leans = (60.0 * (Y_A + 0.05) + 2.0 * Y_F) * G
    by_vectors = [printed(load(0.0, 62.0 * G, m), vectors=True) for m in (leans, leans - 3.0 * G)]
    assert by_vectors[0] - by_vectors[1] == pytest.approx(-3.0 * G)
    assert by_feet(load(0.0, 62.0 * G, (60.0 * (Y_A + 0.05) + 2.0 * Y_F) * G)) == pytest.approx(3.0 * G)


@pytest.mark.parametrize("vectors", [True, False])
def test_derived_torque_has_one_unit_and_the_printed_last_terms_do_not(vectors):
    # in centimetres: forces in kg cm/s2, moments of inertia in kg cm2, torque in kg cm2/s2
    plate, com_dd = (20.0, 600.0, 90.0), (3.0, 1.0)
    in_cm = load(2e3, 6e4, 9e5)
    feet_cm = replace(FEET, inertia_kgm2=1e4 * FEET.inertia_kgm2)
    ankle, com = np.array([[Y_A, Z_ANKLE]]), np.array([[Y_F, 0.05]])
    metres = standing_torque(FEET, G, load(*plate), ankle, com, np.array([com_dd]), one(2.0))
    cm_dd = (300.0, 100.0)
    found = standing_torque(feet_cm, 981.0, in_cm, 100.0 * ankle, 100.0 * com, np.array([cm_dd]), one(2.0))
    assert found == pytest.approx(1e4 * metres)
    # garbled: I_f in kg cm2 is 1e4 times that in kg m2, as a torque; m_f r_Af in kg cm only 100 times
    arm = FEET.mass_kg * np.hypot(0.05, 0.03)
    in_metres = printed(load(*plate), com_dd, vectors=vectors)
    wrong = printed(in_cm, cm_dd, feet_cm, 981.0, 0.01, vectors)
    assert wrong - 1e4 * in_metres == pytest.approx((1e2 - 1e4) * arm)


# ---- the body as one pendulum ------------------------------------------------------------------

BODY = StandingBody(mass_kg=60.0, com_m=0.9, inertia_kgm2=16.0, gravity_m_per_s2=G)


def by_pendulum(theta=0.0, theta_dd=0.0, ankle_dd=(0.0, 0.0), body=BODY):
    return single_joint_torque(body, one(theta), one(theta_dd), np.array([ankle_dd]))


def test_pendulum_by_hand():
    assert by_pendulum(theta=0.1) == pytest.approx(60.0 * 9.81 * 0.9 * np.sin(0.1))
    # upright, falling forward by 2 rad/s2: 16 + 60 x 0.9^2 = 64.6 kg m2 about the ankles
    assert by_pendulum(theta_dd=2.0) == pytest.approx(-64.6 * 2.0)
    # upright, carried forward by 3 m/s2 without turning
    assert by_pendulum(ankle_dd=(3.0, 0.0)) == pytest.approx(-60.0 * 0.9 * 3.0)
    # in a lift that starts with 2 m/s2 everything weighs more
    assert by_pendulum(theta=0.2, ankle_dd=(0.0, 2.0)) == pytest.approx(60.0 * 0.9 * 11.81 * np.sin(0.2))


def test_pendulum_is_the_dummys_leg_on_a_moving_ankle(rng):
    theta, theta_d, theta_dd, y_dd, z_dd = 0.3 * rng.standard_normal((5, 30))
    leg = Leg(mass_kg=BODY.mass_kg, com_m=BODY.com_m, inertia_kgm2=BODY.inertia_kgm2, gravity_m_per_s2=G)
    y_com = y_dd + 0.9 * (np.cos(theta) * theta_dd - np.sin(theta) * theta_d**2)
    z_com = z_dd - 0.9 * (np.sin(theta) * theta_dd + np.cos(theta) * theta_d**2)
    found = single_joint_torque(BODY, theta, theta_dd, np.column_stack([y_dd, z_dd]))
    assert found == pytest.approx(leg_torque(leg, theta, theta_dd, y_com, z_com), abs=1e-10)


TIME = np.arange(1, 8000) / RATE_HZ


def test_pendulum_on_a_perturbed_belt_feels_the_torque_of_its_ankles():
    theta, _, theta_dd = sway(USUAL, TIME)
    belt_dd = np.column_stack([USUAL.belt(TIME)[2], np.zeros(TIME.size)])
    torque = single_joint_torque(PERSON.body, theta, theta_dd, belt_dd)
    assert np.ptp(true_torque(USUAL, TIME)) > 20.0
    assert torque == pytest.approx(true_torque(USUAL, TIME), abs=1e-8)


def test_feet_under_a_perturbed_pendulum_feel_it_too():
    y_belt, _, y_dd = USUAL.belt(TIME)
    zero, ankle = np.zeros(TIME.size), np.column_stack([0.12 + y_belt, np.full(TIME.size, Z_A)])
    torque = standing_torque(
        PERSON.feet,
        G,
        PlateLoad(*plate_wrench(USUAL, TIME)),
        ankle,
        ankle + np.array([0.05, -0.5 * Z_A]),
        np.column_stack([y_dd, zero]),
        zero,
    )
    assert torque == pytest.approx(true_torque(USUAL, TIME), abs=1e-8)


def test_simulated_person_stands_at_rest_until_the_belt_moves():
    quiet = np.arange(0.0, 5.0, 0.01)
    assert sway(USUAL, quiet)[0] == pytest.approx(np.full(quiet.size, LEAN_RAD), abs=1e-9)


# ---- what is assumed of the body ---------------------------------------------------------------


def test_feet_are_those_of_winters_table():
    # 64 kg, 1.75 m: 2 x 0.0145 x 64 = 1.856 kg, radius of gyration 0.475 x 0.152 x 1.75 = 0.12635 m
    feet = both_feet(64.0, 1.75)
    assert feet.mass_kg == pytest.approx(1.856)
    assert feet.inertia_kgm2 == pytest.approx(1.856 * 0.12635**2)


def test_body_on_the_ankles_is_the_whole_one_less_the_feet():
    # centre of all: 0.55 x 1.75 = 0.9625 m; of the feet: 0.04 m; so of the 62.144 kg above the ankles
    # (64 x 0.9625 - 1.856 x 0.04) / 62.144 = 0.990051 m above the floor, 0.910051 m above the ankles
    body = standing_body(64.0, 1.75, 0.55, 0.08, G)
    assert body.mass_kg == pytest.approx(62.144)
    assert body.com_m == pytest.approx(0.910051, abs=1e-6)
    assert body.critical_stiffness == pytest.approx(62.144 * 9.81 * 0.910051, rel=1e-6)
    assert body.critical_stiffness == pytest.approx(554.80, abs=0.01)


def test_body_turns_about_the_ankles_like_a_uniform_rod():
    body = standing_body(64.0, 1.75, 0.55, 0.08, G)
    length = 2.0 * body.com_m
    about_ankle = body.inertia_kgm2 + body.mass_kg * body.com_m**2
    assert about_ankle == pytest.approx(body.mass_kg * length**2 / 3.0)
    assert about_ankle == pytest.approx(68.623, abs=1e-3)
