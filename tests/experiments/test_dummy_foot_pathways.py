"""The foot's free body: by hand, on an exactly integrated dummy, and from a whole trial on the plate."""

from dataclasses import replace

import numpy as np
import pytest
from belt_builders import OPTIONS, belt_recording
from builders import LEG, RATE_HZ, Joint, assert_one_sentence, swing
from scipy.interpolate import CubicSpline

from tepsipe.errors import InputError
from tepsipe.experiments.dummy.foot_pathways import FootOptions, analyse_foot
from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.dummy.options import FootPathway
from tepsipe.identification.estimators import Record, estimate
from tepsipe.identification.regression.windows import regress_torque
from tepsipe.io.trial import Signal, Trial
from tepsipe.mechanics.inverse_dynamics import Foot, foot_torque, foot_torque_as_printed
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.signals.filters import Lowpass, butterworth_lowpass
from tepsipe.signals.perturbations import Perturbation, WindowOptions
from tepsipe.statistics.goodness_of_fit import vaf
from tepsipe.statistics.least_squares import least_squares_line
from tepsipe.treadmill.registry import fit_model

FOOT = Foot(mass_kg=2.1, height_m=0.055)
M_F, L_F = 2.1, 0.055
M, R, I_L, G = 0.4, 0.4485, 0.027, 9.81
ANKLE_M = 0.13  # where the dummy stands on the plate


def one(*values):
    return [np.array([float(value)]) for value in values]


# ---- by hand -----------------------------------------------------------------------------------


def test_leaning_leg_at_rest_presses_the_plate_in_front_of_the_ankle():
    # 2.1 kg under the ankle at 0.13 m, and 0.4 kg whose centre is 0.05 m in front of it
    f_z = 2.5 * 9.81
    m_x = (2.1 * 0.13 + 0.4 * 0.18) * 9.81
    torque = foot_torque(FOOT, *one(0.0, f_z, m_x, 0.13, 0.0))
    assert torque == pytest.approx(0.4 * 9.81 * 0.05)
    pressure = m_x / f_z
    assert torque == pytest.approx(f_z * (pressure - 0.13))


def test_bare_foot_that_is_accelerated_needs_no_torque():
    # 2.1 kg with its centre 0.0275 m above the belt, pushed by 4 m/s2
    push, weight = 2.1 * 4.0, 2.1 * 9.81
    m_x = 0.13 * weight - 0.0275 * push
    torque = foot_torque(FOOT, *one(push, weight, m_x, 0.13, 4.0))
    assert torque == pytest.approx(0.0, abs=1e-12)


def test_shear_at_the_ankle_has_the_height_of_the_foot_as_its_lever():
    # a massless foot: a pull of 10 N at the ankle that tips nothing must be held by the pressure's place
    torque = foot_torque(Foot(0.0, 0.055), *one(10.0, 0.0, -0.55, 0.0, 0.0))
    assert torque == pytest.approx(0.0, abs=1e-12)


def test_torque_does_not_depend_on_where_the_plate_has_its_origin(rng):
    f_y, f_z, m_x, y_a, y_a_dd = rng.standard_normal((5, 20))
    moved = foot_torque(FOOT, f_y, f_z, m_x + 0.3 * f_z, y_a + 0.3, y_a_dd)
    assert moved == pytest.approx(foot_torque(FOOT, f_y, f_z, m_x, y_a, y_a_dd), abs=1e-12)


def test_printed_torque_takes_half_the_height_of_both_shears():
    # foot and leg pushed by 3 m/s2: 2.5 x 3 N below, 0.4 x 3 N above
    torque = foot_torque_as_printed(FOOT, LEG, *one(7.5, 3.0))
    assert torque == pytest.approx(-(7.5 + 1.2) * 0.0275)


# ---- an exact dummy ----------------------------------------------------------------------------


def reaction(moved):
    """Fy, Fz, Mx of the plate on foot and leg, from the rates of their momenta about the plate's origin.

    The moment about x is the sum of y F_z - z F_y; theta turns from z towards y, against it.
    """
    th, motion = moved.motion.theta, moved.motion
    y_a = ANKLE_M + moved.belt_position
    y, z = y_a + R * np.sin(th), L_F + R * np.cos(th)
    f_y = M_F * moved.belt_acceleration + M * motion.y_dd
    f_z = M_F * G + M * (G + motion.z_dd)
    spin_rate = M * (y * motion.z_dd - z * motion.y_dd) - I_L * motion.theta_dd
    spin_rate -= M_F * 0.5 * L_F * moved.belt_acceleration
    return f_y, f_z, spin_rate + (M_F * y_a + M * y) * G


def test_foot_of_a_swinging_dummy_feels_the_torque_of_its_rubber():
    for joint in (Joint(damping=0.1, stiffness=10.0, rest=0.02), Joint(inertia=0.015, stiffness=8.0)):
        moved = swing(joint)
        y_a = ANKLE_M + moved.belt_position
        torque = foot_torque(FOOT, *reaction(moved), y_a, moved.belt_acceleration)
        assert np.ptp(moved.torque) > 0.1
        assert torque == pytest.approx(moved.torque, abs=1e-10)


def test_printed_equation_gives_the_predicted_wrong_parameters_and_a_perfect_fit():
    joint = Joint(inertia=0.015, damping=0.1, stiffness=10.0)
    moved = swing(joint, peak_m_per_s=1e-3)
    m = moved.motion
    torque = foot_torque_as_printed(FOOT, LEG, reaction(moved)[0], m.y_dd)
    regressors = np.column_stack([m.theta_dd, m.theta_d, m.theta])
    fit = least_squares_line(regressors, torque)
    a, b = -(M_F * 0.5 * L_F + M * L_F), -L_F * M * R
    p, about_ankle, k_g = M * R, I_L + M * R**2 + 0.015, M * G * R
    apparent = [b - a * about_ankle / p, -a * 0.1 / p, -a * (10.0 - k_g) / p]
    assert apparent == pytest.approx([0.0446, 0.0445, 3.66], rel=2e-3)
    assert fit.parameters == pytest.approx(apparent, rel=1e-4)
    assert vaf(torque, regressors @ fit.parameters) == pytest.approx(100.0, abs=1e-6)


# ---- any torque --------------------------------------------------------------------------------


def test_regression_takes_any_torque_and_refers_it_to_rest(rng):
    moved = swing(Joint(stiffness=10.0, rest=0.02), peak_m_per_s=0.1)
    m = moved.motion
    torque = 0.02 * m.theta_dd + 0.3 * m.theta_d + 12.0 * m.theta + 5.0
    windows = [Perturbation(500, 600, 0.1), Perturbation(1000, 1100, 0.1)]
    at_rest = m.time < 1.9
    found = regress_torque(m, torque, windows, at_rest)
    assert found.parameters == pytest.approx(np.tile([0.02, 0.3, 12.0], (2, 1)), rel=1e-6)
    assert found.torque_rest_Nm == pytest.approx(12.0 * m.theta[0] + 5.0)
    assert found.vaf_trial == pytest.approx(100.0)
    printed = regress_torque(m, torque, windows, at_rest, thesis=True)
    assert np.abs(printed.mean - [0.02, 0.3, 12.0]).max() > 1.0  # 5 Nm at rest are not stiffness
    record = Record(motion=m, torque=torque, perturbations=windows, at_rest=at_rest)
    assert estimate("windowed-least-squares", record).parameters.tolist() == found.parameters.tolist()
    with pytest.raises(InputError, match=r"expected an estimator of .*, found 'ols'"):
        estimate("ols", record)
    with pytest.raises(InputError, match="found none of 'leg', 'foot_position', 'belt_velocity'"):
        estimate("output-error", record)


# ---- a whole trial -----------------------------------------------------------------------------

LAYOUT = {"ankle": (0.0, 0.0), "leg1": (-0.012, 0.87), "leg2": (0.012, 0.63), "leg3": (-0.012, 0.39)}
LABELS = ["foot1", "foot2", *LAYOUT]
LOWPASS = Lowpass(20.0, 4, True)
DUMMY = DummyOptions(
    leg=LEG,
    leg_markers=SegmentMarkers(tuple(LAYOUT), np.array(list(LAYOUT.values()))),
    lowpass_cutoff_hz=20.0,
    lowpass_order=4,
    window=WindowOptions(1.9, 2.0, 0.2, 0.05, 5.0, 0.06),
)
CHOICE = FootOptions(FOOT, "ankle", ("foot1", "foot2", "ankle"), "right")
PATHWAYS = {
    "foot-thesis": FootPathway("foot-thesis", None, None, "windowed-least-squares-thesis"),
    "foot": FootPathway("foot", None, None, "windowed-least-squares"),
    "foot-long": FootPathway("foot", None, 1.5, "windowed-least-squares"),
}
JOINT = Joint(damping=0.5, stiffness=10.0, rest=0.02)
BELT_KG, BELT_KGM = 0.5, 0.02  # what the belt adds to Fy and Mx per m/s2


def plate_trial(delay_s=0.0, belt_kg=0.0, belt_kgm=0.0):
    """The dummy on the right belt, with markers that lag behind; transducers have an offset."""
    moved = swing(JOINT, peak_m_per_s=0.2)
    f_y, f_z, m_x = reaction(moved)
    late = np.clip(moved.time - delay_s, 0.0, moved.time[-1])
    th = CubicSpline(moved.time, moved.motion.theta)(late)
    y_a = CubicSpline(moved.time, moved.belt_position)(late) + ANKLE_M
    markers = np.zeros((late.size, len(LABELS), 3))
    for k, label in enumerate(LABELS):
        across, along = LAYOUT.get(label, (0.0, 0.0))
        tilt = th if label in LAYOUT else 0.0 * th
        markers[:, k, 1] = y_a + across * np.cos(tilt) + along * np.sin(tilt)
        markers[:, k, 2] = L_F - across * np.sin(tilt) + along * np.cos(tilt)
    force, moment = np.zeros((2, late.size, 2, 3))
    force[:, 1, 1] = f_y + belt_kg * moved.belt_acceleration + 3.0
    force[:, 1, 2] = f_z
    moment[:, 1, 0] = m_x + belt_kgm * moved.belt_acceleration
    signals = {
        "belt_velocity": (moved.belt_velocity, "m/s", ("time",)),
        "belt_command": (moved.belt_velocity, "m/s", ("time",)),
        "marker_position": (markers, "m", ("time", "marker", "axis")),
        "force": (force, "N", ("time", "belt", "axis")),
        "moment": (moment, "Nm", ("time", "belt", "axis")),
    }
    return Trial(
        rate_hz=RATE_HZ,
        axes={"time": moved.time, "marker": np.array(LABELS), "belt": np.array(["left", "right"])},
        signals={name: Signal(*values, name) for name, values in signals.items()},
    )


def parameters(trial, pathways=PATHWAYS, models=None, choice=CHOICE):
    found = analyse_foot(trial, "dummy/sine-0.2", DUMMY, choice, pathways, models or {})
    return {name: regression.mean for name, regression in found.regressions.items()}


def apparent(joint, a, b=0.0, c=0.0, d=0.0):
    """I, B, K that a torque a y_f'' + b th'' + c th' + d th shows."""
    p, about_ankle, k_g = M * R, I_L + M * R**2 + joint.inertia, M * G * R
    return [b - a * about_ankle / p, c - a * joint.damping / p, d - a * (joint.stiffness - k_g) / p]


@pytest.mark.parametrize("delay_s", [0.0, 0.0012, -0.002])
def test_joint_comes_back_from_the_plate_whatever_the_markers_lag(delay_s):
    found = parameters(plate_trial(delay_s))
    for name in ("foot", "foot-long"):
        assert found[name] == pytest.approx([0.0, 0.5, 10.0], rel=0.02, abs=1e-3), name
    a, b = -(M_F * 0.5 * L_F + M * L_F), -L_F * M * R
    assert found["foot-thesis"][[0, 2]] == pytest.approx(np.array(apparent(JOINT, a, b))[[0, 2]], rel=0.05)


def test_plate_that_was_filtered_or_clipped_is_flagged(rng):
    trial = plate_trial()
    loads = {name: trial.signals[name] for name in ("force", "moment", "marker_position")}
    noisy = {
        name: replace(x, values=x.values + 1e-4 * np.ptp(x.values) * rng.standard_normal(x.values.shape))
        for name, x in loads.items()
    }

    def flags(**changed):
        signals = trial.signals | noisy
        signals |= {name: replace(noisy[name], values=f(noisy[name].values)) for name, f in changed.items()}
        return analyse_foot(
            replace(trial, signals=signals), "dummy/sine-0.2", DUMMY, CHOICE, PATHWAYS, {}
        ).flags

    def filtered(x):
        return butterworth_lowpass(x, RATE_HZ, 10.0)

    assert flags() == ()
    assert flags(force=filtered, moment=filtered) == ("filtered-signal",)
    assert "clipped" in flags(force=lambda x: np.clip(x, None, 0.6 * x.max(axis=0)))


def test_load_of_the_belt_is_taken_for_impedance_until_a_model_takes_it_out(rng):
    acceleration = rng.standard_normal(8000)
    empty = belt_recording(np.cumsum(acceleration) / RATE_HZ, acceleration, acceleration, rate_hz=RATE_HZ)
    options = replace(OPTIONS, fir_lead_s=0.02, fir_lag_s=0.04)
    models = {
        load: {
            "fir": fit_model("fir", [replace(empty, load=k * empty.load, unit=u).filtered(LOWPASS)], options)
        }
        for load, k, u in (("Fy", BELT_KG, "N"), ("Mx", BELT_KGM, "Nm"))
    }
    pathways = PATHWAYS | {"foot-compensated": FootPathway("foot", "fir", None, "windowed-least-squares")}
    found = parameters(plate_trial(0.0, BELT_KG, BELT_KGM), pathways, models)
    # Fy has the height of the ankle as its lever
    error = np.array(apparent(JOINT, BELT_KGM + L_F * BELT_KG))
    assert found["foot"] - [0.0, 0.5, 10.0] == pytest.approx(error, rel=0.08)
    assert abs(error[2]) > 1.5
    assert found["foot-compensated"] == pytest.approx([0.0, 0.5, 10.0], rel=0.02, abs=1e-3)


def test_what_the_foot_cannot_be_analysed_with_is_refused():
    trial = plate_trial()

    def refused(*names, **changes):
        with pytest.raises(InputError) as caught:
            parameters(trial, **changes)
        assert_one_sentence(caught.value, *names)

    other = {"x": replace(PATHWAYS["foot"], torque="knee")}
    refused("'knee'", "foot-thesis, foot", pathways=other)
    other = {"x": replace(PATHWAYS["foot"], treadmill_model="firr")}
    refused("'firr'", pathways=other, models={"Fy": {}, "Mx": {}})
    refused("2.5 s", "dummy/sine-0.2", pathways={"x": replace(PATHWAYS["foot"], window_s=2.5)})
    refused("'toe'", "'foot1'", choice=replace(CHOICE, belt_fixed_labels=("toe",)))
    refused("'middle'", "'right'", choice=replace(CHOICE, belt="middle"))
