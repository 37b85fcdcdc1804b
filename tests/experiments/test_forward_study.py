"""Simulations against a leg whose motion is exact: only the joint's own parameters follow it."""

import math
from dataclasses import astuple, replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from builders import LEG, RATE_HZ, alike, assert_one_sentence, belt_pulses, swing, trial_of
from builders import Joint as ExactJoint
from typst_builders import STUDY, chapter_words

from tepsipe.drawing.names import PARAMETER_SETS
from tepsipe.errors import InputError
from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.forward.figures import plot_torques
from tepsipe.experiments.forward.scores import FORWARD_SCORES, ForwardScore, engine_of
from tepsipe.experiments.forward.study import (
    engine_differences,
    forward_scores,
    likelihood_joint,
    mean_joint,
    simulate_condition,
    simulated_signals,
    simulation_result,
    swing_growth,
)
from tepsipe.io.estimates import Estimate
from tepsipe.io.result import Result, read_result, write_result
from tepsipe.io.trial import Signal
from tepsipe.mechanics.engines import installed_engines
from tepsipe.mechanics.engines.interface import Joint
from tepsipe.mechanics.forward_dynamics import simulate_dummy
from tepsipe.mechanics.inverse_dynamics import Foot
from tepsipe.mechanics.rubber_joint import SOFTENING, RubberJoint
from tepsipe.mechanics.rubber_joint import swing as rubber_swing
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.reporting.chapters import simulation
from tepsipe.reporting.run import Run, report_content
from tepsipe.signals.perturbations import Perturbation, WindowOptions
from tepsipe.statistics.goodness_of_fit import vaf

FOOT = Foot(mass_kg=2.1, height_m=0.055)
LAYOUT = np.array([[0.0, 0.0], [-0.012, 0.87], [0.012, 0.15]])
LABELS = ("ankle", "leg1", "leg2")
OPTIONS = DummyOptions(
    leg=LEG,
    leg_markers=SegmentMarkers(LABELS, LAYOUT),
    lowpass_cutoff_hz=20.0,
    lowpass_order=4,
    window=WindowOptions(
        rest_before_s=2.0,
        rest_after_s=2.0,
        rest_margin_s=0.2,
        threshold_fraction=0.05,
        signal_to_noise=5.0,
        merge_s=0.06,
    ),
)
TRUTH = Joint(0.015, 0.1, 10.0)
DOUBLE_WEIGHT = 2.0 * 0.4 * 9.81 * 0.4485  # 2 m g r (Nm/rad)
JOINTS = {
    "truth": TRUTH,
    "stiff": Joint(0.015, 0.1, 11.0),
    "printed": Joint(
        0.015 + 2.0 * 0.027, 0.1, 10.0 - DOUBLE_WEIGHT
    ),  # what theta towards +y makes of eq (3-8)
    "soft": Joint(0.015, 0.1, 0.9),  # less than m g r
}
STEP_S, ENGINES = 0.001, dict.fromkeys([*JOINTS, "light", "law", "8.0", "9.0", "10.0"], "auto")


def recorded(moved, force=None):
    """Markers and belt of an exact swing, and F_y on the right belt (N), if it is given."""
    theta = moved.motion.theta[:, None]
    across, along = LAYOUT.T
    positions = np.zeros((theta.size, len(LABELS), 3))
    positions[..., 1] = moved.belt_position[:, None] + across * np.cos(theta) + along * np.sin(theta)
    positions[..., 2] = FOOT.height_m - across * np.sin(theta) + along * np.cos(theta)
    trial = trial_of(RATE_HZ, belt_velocity=(moved.belt_velocity, "m/s"))
    markers = Signal(positions, "m", ("time", "marker", "axis"), "markers")
    signals, axes = {"marker_position": markers}, {"marker": np.array(LABELS), "axis": np.array(list("xyz"))}
    if force is not None:
        loads = np.zeros((theta.size, 2, 3))
        loads[:, 1, 1] = force
        axes["belt"] = np.array(["left", "right"])
        signals["force"] = Signal(loads, "N", ("time", "belt", "axis"), "force")
        signals["moment"] = Signal(0.0 * loads, "Nm", ("time", "belt", "axis"), "moment")
    return replace(trial, axes=trial.axes | axes, signals=trial.signals | signals)


@pytest.fixture(scope="module")
def trial():
    joint = ExactJoint(inertia=0.015, damping=0.1, stiffness=10.0, rest=0.005)
    return recorded(swing(joint, (2.0, 4.0, 6.0), duration_s=10.0))


@pytest.fixture(scope="module")
def simulated(trial):
    return simulate_condition(trial, OPTIONS, FOOT, JOINTS, STEP_S, ENGINES)


@pytest.fixture(scope="module")
def scores(simulated):
    return {(s.parameter_set, s.quantity): s for s in forward_scores("sine-0.3", simulated)}


# ---- what follows the recording ----------------------------------------------------------------


@pytest.mark.slow
def test_true_joint_follows_the_recorded_leg_and_a_wrong_stiffness_does_not(scores):
    true, stiff = scores["truth", "theta"], scores["stiff", "theta"]
    assert true.vaf_trial > 99.9
    assert true.vaf_perturbation > 99.9
    assert scores["truth", "tau_consistent"].vaf_trial > 99.9
    assert stiff.vaf_trial < 90.0
    # perturbations are too short to tell as much as the free swing after them
    assert stiff.vaf_trial + 10.0 < stiff.vaf_perturbation < true.vaf_perturbation


def test_parameters_of_the_printed_equation_follow_its_torque_but_not_the_leg(scores):
    printed, true = scores["printed", "tau"], scores["truth", "tau"]
    assert printed.vaf_trial > 80.0
    assert true.vaf_trial < 50.0
    assert scores["printed", "theta"].vaf_trial < 50.0
    assert scores["printed", "tau_consistent"].vaf_trial < 0.0


def test_simulation_starts_from_rest_as_the_recording_does(simulated):
    assert len(simulated.perturbations) == 3
    recording = {"theta": simulated.theta} | simulated.torques
    for name, signal in recording.items():
        assert np.ptp(signal[:400]) < 1e-6 * np.ptp(signal), name
        # at the end the leg still swings a little
        assert np.abs(signal[:400]).max() < 2e-3 * np.ptp(signal), name
    for name in JOINTS:
        signals = simulated_signals(simulated, name)
        for key in ("theta", "tau"):
            assert np.abs(signals[key][:400]).max() < 1e-3 * np.ptp(recording[key]), (name, key)


@pytest.mark.parametrize("late_s", [0.0, 0.001])
def test_measured_less_simulated_force_is_the_belt_induced_one(late_s):
    """By hand: the plate adds 3 kg times the acceleration of the belt to the rate of the momentum.

    An offset of 5 N is none of it. Log and plate may be later than the markers, which move the foot. All are
    behind one filter.
    """
    moved = swing(ExactJoint(inertia=0.015, damping=0.1, stiffness=10.0), (2.0, 4.0, 6.0), duration_s=10.0)
    momentum_rate = FOOT.mass_kg * moved.belt_acceleration + LEG.mass_kg * moved.motion.y_dd
    induced = 3.0 * moved.belt_acceleration

    def late(x):
        return np.interp(moved.time - late_s, moved.time, x)

    trial = recorded(moved, late(momentum_rate + induced) + 5.0)
    log = replace(trial.signals["belt_velocity"], values=late(moved.belt_velocity))
    trial = replace(trial, signals=trial.signals | {"belt_velocity": log})
    options = replace(OPTIONS, belt_fixed_labels=("ankle",))
    joints = {"corrected": TRUTH, "tep": JOINTS["stiff"]}
    engines = dict.fromkeys(joints, "equations")
    found = simulate_condition(trial, options, FOOT, joints, STEP_S, engines, "right")
    momentum_rate, induced = (options.lowpass(x, RATE_HZ) for x in (momentum_rate, induced))
    for name in joints:
        force = simulated_signals(found, name)["f_y"]
        assert force == pytest.approx(momentum_rate, abs=0.01 * np.ptp(momentum_rate)), name
        difference = found.f_y - force
        assert difference == pytest.approx(induced, abs=0.01 * np.ptp(induced)), name
    scores = {(s.parameter_set, s.quantity): s for s in forward_scores("sine-0.3", found)}
    window = found.perturbations[0]
    part = slice(window.start, window.stop)
    expected = vaf((momentum_rate + induced)[part], momentum_rate[part])
    assert scores["corrected", "f_y"].vaf_perturbation == pytest.approx(expected, abs=1.0)
    assert expected < 90.0
    # the plate is needed for it
    without = simulate_condition(trial, options, FOOT, joints, STEP_S, engines)
    assert without.f_y is None
    assert {s.quantity for s in forward_scores("s", without)} == {"theta", "tau", "tau_consistent"}
    # and its figure has the difference in a panel of its own
    shown, plain = (plot_torques(simulation_result(one)) for one in (found, without))
    assert len(shown.axes) == len(plain.axes) + 2


def test_late_log_moves_neither_windows_nor_force():
    moved = swing(ExactJoint(inertia=0.015, damping=0.1, stiffness=10.0), (2.0, 4.0, 6.0), duration_s=10.0)
    trial = recorded(moved, moved.belt_velocity)  # any force in time with the markers
    options = replace(OPTIONS, belt_fixed_labels=("ankle",))
    joint, engine = {"truth": TRUTH}, {"truth": "equations"}
    belt = trial.signals["belt_velocity"]
    late = replace(belt, values=np.interp(trial.time - 0.05, trial.time, belt.values))
    found = []
    for log in (belt, late):
        recording = replace(trial, signals=trial.signals | {"belt_velocity": log})
        found.append(simulate_condition(recording, options, FOOT, joint, STEP_S, engine, "right"))
    in_time, corrected = found
    starts, others = ([p.start for p in one.perturbations] for one in found)
    assert others == pytest.approx(starts, abs=1)
    assert corrected.f_y == pytest.approx(in_time.f_y, abs=0.01 * np.ptp(in_time.f_y))


def test_offset_of_the_belts_sensor_does_not_matter(trial, scores):
    belt = trial.signals["belt_velocity"]
    shifted = replace(belt, values=belt.values + 0.02)
    moved = replace(trial, signals=trial.signals | {"belt_velocity": shifted})
    again = simulate_condition(moved, OPTIONS, FOOT, {"truth": TRUTH}, STEP_S, ENGINES)
    theta = forward_scores("sine-0.3", again)[0]
    assert theta.vaf_trial == pytest.approx(scores["truth", "theta"].vaf_trial, abs=1e-6)


def test_leg_that_falls_counts_for_nothing_from_there_on(simulated, scores):
    fallen = simulated.simulations["soft"]
    assert fallen.state == "falls"
    assert 2.0 < fallen.fell_at_s < 6.0
    signals = simulated_signals(simulated, "soft")
    stop = fallen.time.size
    for signal in signals.values():
        assert signal.shape == simulated.time.shape
        assert np.isfinite(signal[:stop]).all()
        assert np.isnan(signal[stop:]).all()
    score = scores["soft", "theta"]
    assert score.state == "falls"
    measured, found = simulated.theta, signals["theta"][:stop]
    missed = np.sum((measured[:stop] - found) ** 2) + np.sum(measured[stop:] ** 2)
    assert score.vaf_trial == pytest.approx(100.0 * (1.0 - missed / np.sum(measured**2)))
    # the last perturbation, which it does not see, has a VAF of 0
    last = simulated.perturbations[-1]
    assert stop < last.start
    seen = [
        vaf(measured[p.start : p.stop], np.nan_to_num(signals["theta"][p.start : p.stop]))
        for p in simulated.perturbations[:-1]
    ]
    assert score.vaf_perturbation == pytest.approx(sum(seen) / 3.0)
    assert {s.state for key, s in scores.items() if key[0] != "soft"} == {"settles"}


def test_result_holds_what_figures_show(simulated, tmp_path):
    write_result(tmp_path / "simulation.h5", simulation_result(simulated))
    result = read_result(tmp_path / "simulation.h5")
    assert result.facts["parameter_sets"] == list(JOINTS)
    assert result.facts["states"]["soft"] == "falls"
    assert result.facts["fell_at_s"]["soft"] == simulated.simulations["soft"].fell_at_s
    assert result.facts["fell_at_s"]["truth"] is None
    assert result.arrays.keys() == result.units.keys()
    for name, joint in JOINTS.items():
        assert result.arrays[f"{name}/parameters"].tolist() == list(astuple(joint)[:3])
        for key, signal in simulated_signals(simulated, name).items():
            stored = result.arrays[f"{name}/{key}"]
            assert alike(stored, signal, rel=1e-6, abs=1e-9, nan_ok=True), (name, key)
    windows = [slice(*window) for window in result.arrays["windows"]]
    assert all(np.abs(result.arrays["theta"][w]).max() > 0.01 for w in windows)


def test_differences_between_engines_are_small_and_those_between_joints_are_not(trial):
    def moved(engine, joint=TRUTH):
        return simulate_condition(trial, OPTIONS, FOOT, {"law": joint}, STEP_S, {"law": engine})

    of_engine = [moved(engine) for engine in installed_engines()]
    exact = of_engine[-1]
    assert [one.engines["law"] for one in of_engine] == installed_engines()
    assert engine_differences(exact, exact) == {"theta_percent": 0.0, "tau_percent": 0.0, "vaf_points": 0.0}
    for other in of_engine[:-1]:
        found = engine_differences(other, exact)
        assert 0.0 < found["theta_percent"] < 0.05 and 0.0 < found["tau_percent"] < 0.05
        assert found["vaf_points"] < 0.01
    stiffer = engine_differences(exact, moved("equations", JOINTS["stiff"]))
    assert stiffer["theta_percent"] > 10.0 and stiffer["vaf_points"] > 10.0
    written = simulation_result(exact, stiffer).facts
    assert written["engine_differences"] == stiffer and written["engines"] == {"law": "equations"}


def test_sets_that_the_thesis_compares_are_moved_by_the_engine_and_all_others_by_the_equations():
    assert engine_of("tep", "pybullet") == engine_of("thesis-wristalyzer", "pybullet") == "pybullet"
    assert {engine_of(name, "mujoco") for name in ("corrected", "joint-likelihood")} == {"equations"}
    assert {engine_of(name, "mujoco") for name in PARAMETER_SETS} == {"mujoco", "equations"}


def test_trial_that_cannot_be_simulated_is_refused(trial):
    with pytest.raises(InputError) as caught:
        simulate_condition(trial, OPTIONS, FOOT, {"light": Joint(-0.2, 0.1, 10.0)}, STEP_S, ENGINES)
    assert_one_sentence(caught.value, "inertia of the joint", "-0.2")
    still = replace(trial.signals["belt_velocity"], values=np.zeros(trial.time.size))
    with pytest.raises(InputError) as caught:
        simulate_condition(
            replace(trial, signals=trial.signals | {"belt_velocity": still}),
            OPTIONS,
            FOOT,
            {},
            STEP_S,
            ENGINES,
        )
    assert_one_sentence(caught.value, "belt velocity", "perturbations")


# ---- a joint that softens ------------------------------------------------------------------------

RUBBER = RubberJoint(
    stiffness_Nm_per_rad=10.0,
    half_softening_rad=0.02,
    damping_Nms_per_rad=0.05,
    softened_damping_Nms_per_rad=0.1,
    inertia_Nms2_per_rad=0.007,
)
LAW = Joint(
    0.007,
    0.05,
    10.0,
    softening_Nm_per_rad=SOFTENING * 10.0,
    softened_damping_Nms_per_rad=0.1,
    half_softening_rad=0.02,
)


@pytest.fixture(scope="module")
def rubber_trial():
    """Recording of a leg on a rubber joint, integrated by `rubber_joint.swing`."""
    onsets, peak, parts = (2.0, 4.0, 6.0), 0.3, 4
    half_steps = np.arange(2 * parts * round(10.0 * RATE_HZ) - 1) / (2.0 * parts * RATE_HZ)
    pushed = belt_pulses(half_steps, onsets, peak)[2]
    theta = rubber_swing(LEG, [RUBBER], pushed[None], 1.0 / (parts * RATE_HZ))[0][0, 0, ::parts]
    position, velocity, _ = belt_pulses(np.arange(theta.size) / RATE_HZ, onsets, peak)
    motion = SimpleNamespace(theta=theta)
    return recorded(SimpleNamespace(motion=motion, belt_position=position, belt_velocity=velocity))


@pytest.mark.parametrize("labels", [(), ("ankle",)], ids=["log", "belt-fixed marker"])
def test_law_of_a_joint_that_softens_follows_its_leg_and_no_linear_joint_does(rubber_trial, labels):
    linear = {str(k): Joint(0.007, 0.05, k) for k in (8.0, 9.0, 10.0)}
    options = replace(OPTIONS, belt_fixed_labels=labels)
    found = simulate_condition(rubber_trial, options, FOOT, {"law": LAW, **linear}, STEP_S, ENGINES)
    assert np.abs(found.theta).max() > 0.012
    angle = {s.parameter_set: s.vaf_trial for s in forward_scores("s", found) if s.quantity == "theta"}
    # the recorded angle is low-passed
    assert angle.pop("law") > 99.95
    assert max(angle.values()) < 90.0
    # the torque of the law, too
    torque = next(s for s in forward_scores("s", found) if s.quantity == "tau_consistent")
    assert torque.parameter_set == "law" and torque.vaf_trial > 99.9


@pytest.mark.parametrize("engine", ["pybullet", "mujoco", "equations"])
def test_law_that_moved_the_leg_explains_all_of_its_angle(rubber_trial, engine):
    if engine not in installed_engines():
        pytest.skip(f"the engine {engine} is not installed")
    velocity = rubber_trial.values("belt_velocity")
    moved = simulate_dummy(rubber_trial.time, velocity, LEG, FOOT, LAW, STEP_S, engine)
    assert vaf(np.arctan2(*angle_of(rubber_trial)), moved.theta) > 99.9999


def angle_of(trial):
    """Vector from the ankle to the middle of the leg's markers, along the belt and upwards (m)."""
    ankle, first, second = np.moveaxis(trial.values("marker_position"), 1, 0)
    above = (0.5 * (first + second) - ankle)[:, 1:]
    return above[:, 0], above[:, 1]


def test_joint_of_the_likelihood_has_the_law_of_its_trial():
    rows = [
        estimate(quantity, value, pathway="likelihood")
        for quantity, value in zip(
            ("I_small", "B_small", "K_small", "K"), (0.007, 0.05, 10.0, 8.0), strict=True
        )
    ]
    law = {"softening_Nm_per_rad": 5.0, "softened_damping_Nms_per_rad": 0.1, "half_softening_rad": 0.02}

    def fitted(**facts):
        return Result({}, {}, {"joint_likelihood": facts})

    assert likelihood_joint(rows, fitted(likelihood=law), "likelihood") == LAW
    assert likelihood_joint(rows, fitted(likelihood={}), "likelihood") == Joint(0.007, 0.05, 10.0)
    assert likelihood_joint(rows, fitted(other=law), "likelihood") is None
    with pytest.raises(InputError, match="expected"):
        likelihood_joint(rows[:2], fitted(likelihood=law), "likelihood")


# ---- growth of the swing ---------------------------------------------------------------------------


def pulsed(periods_between, damping=0.0, count=8, every_s=4.0):
    """Angle (rad) of a leg whose belt is pulsed gently every ``every_s``, and the windows.

    Between two onsets the leg swings ``periods_between`` times.
    """
    time = np.arange(round((every_s * count + 1.0) * RATE_HZ)) / RATE_HZ
    onsets = 0.5 + every_s * np.arange(count)
    _, velocity, _ = belt_pulses(time, onsets, 0.01)
    weight = LEG.mass_kg * LEG.gravity_m_per_s2 * LEG.com_m
    about_ankle = LEG.inertia_kgm2 + LEG.mass_kg * LEG.com_m**2
    stiffness = weight + about_ankle * (2.0 * np.pi * periods_between / every_s) ** 2
    joint = Joint(0.0, damping, stiffness)
    found = simulate_dummy(time, velocity, LEG, FOOT, joint, 0.004, "equations")
    first = np.round(onsets * RATE_HZ).astype(int)
    return found, [Perturbation(start, start + 50, 0.01) for start in first.tolist()]


@pytest.mark.parametrize("n", [4, 6, 8])
def test_swings_of_equal_pulses_add_up_with_their_phase(n):
    """Pulses 2 + 1 / (2 n) periods apart add up to sin(k d) / sin(d), d = pi / (2 n): at most 1 / sin(d)."""
    found, windows = pulsed(2.0 + 0.5 / n)
    assert found.period_s == pytest.approx(4.0 / (2.0 + 0.5 / n))
    assert swing_growth(found.theta, windows) == pytest.approx(1.0 / math.sin(0.5 * math.pi / n), rel=0.01)


def test_swing_after_pulses_half_a_period_apart_or_well_damped_does_not_grow():
    assert swing_growth(*of_angle(pulsed(2.5))) == pytest.approx(1.0, abs=0.01)
    assert swing_growth(*of_angle(pulsed(2.0, damping=0.3))) == pytest.approx(1.0, abs=0.01)


def test_swing_of_pulses_in_phase_grows_with_every_one():
    assert swing_growth(*of_angle(pulsed(2.0, count=5))) == pytest.approx(5.0, rel=0.01)


def of_angle(moved):
    return moved[0].theta, moved[1]


def test_growth_of_a_leg_that_falls_is_infinite_and_of_one_pulse_unknown():
    theta = np.ones(100)
    windows = [Perturbation(10, 20, 0.3), Perturbation(50, 60, 0.3)]
    assert swing_growth(theta, windows) == 1.0
    assert swing_growth(np.where(np.arange(100) < 70, 1.0, np.nan), windows) == math.inf
    assert math.isnan(swing_growth(theta, windows[:1]))


# ---- parameters that are evaluated ----------------------------------------------------------------


def estimate(quantity, value, pathway="admittance", estimator="spectral-fit", condition="0.12"):
    return Estimate("wristalyzer", condition, pathway, estimator, quantity, "-", value)


def test_parameters_are_means_over_trials_of_one_pathway_and_estimator():
    rows = [
        estimate(quantity, scale * value, condition=condition)
        for condition, scale in (("0.12", 0.9), ("0.16", 1.1))
        for quantity, value in zip("KIB", (10.0, 0.015, 0.1), strict=True)
    ]
    rows += [estimate("VAF_trial", 99.0), estimate("K", 500.0, pathway="leg")]
    assert astuple(mean_joint(iter(rows), "admittance")) == pytest.approx(astuple(TRUTH))
    rows += [estimate(quantity, 7.0, estimator="as-printed") for quantity in "IBK"]
    of_fit = mean_joint(rows, "admittance", "spectral-fit")
    assert astuple(of_fit) == pytest.approx(astuple(TRUTH))
    assert mean_joint(rows, "admittance").stiffness_Nm_per_rad == pytest.approx(9.0)


@pytest.mark.parametrize(("pathway", "estimator"), [("foot", None), ("admittance", "other")])
def test_parameters_that_were_not_estimated_are_refused(pathway, estimator):
    rows = [estimate(quantity, 1.0) for quantity in "IBK"]
    with pytest.raises(InputError) as caught:
        mean_joint(rows, pathway, estimator)
    assert_one_sentence(caught.value, pathway)


# ---- files -------------------------------------------------------------------------------------

SCORES = [
    ForwardScore("0.20", "tep", "pybullet", "theta", 87.123456789012, -1234.5, "settles", 1.25),
    ForwardScore("sine-0.5", "corrected", "equations", "tau_consistent", 99.9, 0.0, "falls", math.inf),
]


def test_scores_come_back_from_their_file(tmp_path):
    path, again = tmp_path / "forward.csv", tmp_path / "again.csv"
    FORWARD_SCORES.write(path, SCORES)
    read = FORWARD_SCORES.read(path)
    assert read[0] == replace(SCORES[0], vaf_perturbation=87.12345679)
    # a leg that falls has no ratio of swings
    assert replace(read[1], growth=math.inf) == SCORES[1] and math.isnan(read[1].growth)
    FORWARD_SCORES.write(again, read)
    assert again.read_bytes() == path.read_bytes()
    FORWARD_SCORES.write(path, [])
    assert FORWARD_SCORES.read(path) == []


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("vaf_trial", "vaf", "vaf_trial"),
        ("-1234.5", "much", "much"),
        ("99.9,0,falls,", "", "damaged"),
        ("condition,parameter_set", "condition;parameter_set", "columns"),
        (None, "", "found nothing"),
    ],
)
def test_damaged_scores_are_refused(old, new, words, tmp_path):
    path = tmp_path / "forward.csv"
    FORWARD_SCORES.write(path, SCORES)
    text = path.read_text()
    assert old is None or old in text
    path.write_text(text.replace(old, new) if old else new)
    with pytest.raises(InputError) as caught:
        FORWARD_SCORES.read(path)
    assert_one_sentence(caught.value, path, words)


# ---- the report --------------------------------------------------------------------------------


def test_report_tells_spans_of_vaf_and_which_legs_do_not_settle():
    rows = [
        ForwardScore(condition, name, engine_of(name, "mujoco"), quantity, low, high, state, 1.0)
        for condition, name, low, high, state in (
            ("sine-0.1", "tep", 10.0, -5000.0, "falls"),
            ("sine-0.2", "tep", 20.0, 30.0, "settles"),
            ("sine-0.1", "corrected", 99.6, 99.7, "settles"),
            ("sine-0.2", "corrected", 99.8, 100.0, "settles"),
        )
        for quantity in ("theta", "tau", "tau_consistent")
    ]
    study = STUDY | {"step_s": 0.001, "engine": "mujoco", "simulated": {"4_7": "sine-0.1", "4_8": "sine-0.2"}}
    study |= {"reported": {"simulations": {"captions": {}}, "tables": {"table_4_2": {}}, "slips": []}}
    run = Run({"forward": pd.DataFrame(map(vars, rows))}, study=study)
    tables = {"forward": run.tables["forward"].to_csv(index=False)}
    words = chapter_words("simulation", report_content(run, {"simulation": simulation}), tables, cells=" | ")
    # angle, printed and consistent torque: perturbations, then full dataset
    assert "| TEP-SIPE as printed " + 3 * "| 10 to 20 | < \N{MINUS SIGN}1000 to 30 " in words
    assert "| TEP-SIPE, consistent " + 3 * "| 99.6 to 99.8 | 99.7 to 100.0 " in words
    assert "the multi-body engine MuJoCo, and the others with a Runge-Kutta method" in words
    assert "With the estimates of this run by TEP-SIPE as printed, the swing ends in a fall in S1" in words
    assert words.count(" in a fall ") == 1
