"""The inverse problem: a known dummy gives printed numbers, from which its constants are found again."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from scipy.interpolate import PPoly

from tepsipe.errors import InputError
from tepsipe.experiments.thesis_dummy.fit import STEP_AT_REST
from tepsipe.experiments.thesis_dummy.inverse import (
    JOINTS,
    SCATTER,
    START,
    PrintedPath,
    belt_motion,
    copied_rms,
    fit_joint,
    fit_marker_noise,
    fit_tables,
    printed_and_predicted,
    printed_fits,
    printed_means,
    printed_quantities,
    swings,
)
from tepsipe.experiments.thesis_dummy.profile import LIMIT_95, last_match, profile
from tepsipe.experiments.thesis_dummy.timing import (
    damping_shift,
    lag_fits,
    linear_joint,
    percussion_height,
    pose_error,
    timing_facts,
)
from tepsipe.io.trial import Signal, Trial
from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.mechanics.rubber_joint import RubberJoint
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.signals.perturbations import WindowOptions

RATE = 250.0
# section 4-1-3 of the thesis: the Wristalyzer's joint, and the same without foot and handle
FOLLOWED = linear_joint(0.015, 0.1, 10.0), linear_joint(0.007, 0.1, 10.0)
LAYOUT = np.array([[0.0, 0.0], [-0.012, 0.87], [0.012, 0.63], [-0.012, 0.39], [0.012, 0.15]])
TWO_MGR, TWO_INERTIA = 2.0 * 0.4 * 9.81 * 0.4485, 2.0 * 0.027
TRUE = RubberJoint(
    stiffness_Nm_per_rad=9.0,
    half_softening_rad=0.03,
    damping_Nms_per_rad=0.04,
    softened_damping_Nms_per_rad=0.08,
    inertia_Nms2_per_rad=0.004,
)


def path(sampled_after_s=0.0):
    return PrintedPath(
        leg=Leg(mass_kg=0.4, com_m=0.4485, inertia_kgm2=0.027),
        markers=SegmentMarkers(("ankle", "a", "b", "c", "d"), LAYOUT),
        sampled_after_s=np.arange(3, 8) * sampled_after_s,
        rate_hz=RATE,
        cutoff_hz=20.0,
        order=4,
        window=WindowOptions(2.0, 3.0, 0.5, 0.05, 5.0, 0.06),
    )


def trial(peak, pulses=3):
    """Sinusoidal pulses of 0.12 s every 3 s, recorded with noise."""
    t = np.arange(0.0, 2.2 + 3.0 * pulses + 3.0, 1.0 / RATE)
    since = np.mod(t - 2.2, 3.0)
    moving = (t >= 2.2) & (t < 2.2 + 3.0 * pulses) & (since < 0.12)
    velocity = np.where(moving, peak * np.sin(2.0 * np.pi * since / 0.12), 0.0)
    velocity += 1e-4 * np.random.default_rng(3).standard_normal(t.size)
    return Trial(RATE, {"time": t}, {"belt_velocity": Signal(velocity, "m/s")})


PEAKS = {"low": 0.1, "middle": 0.3, "high": 0.5, "other": 0.4}


@pytest.fixture(scope="module")
def belts():
    return {name: belt_motion(trial(peak), path()) for name, peak in PEAKS.items()}


def angles_of(joint, belts, own=None):
    """Angle at every frame (rad) by condition."""
    swung = swings(own or path(), [joint], belts)
    return {name: swung[name](belt.time)[:, 0] for name, belt in belts.items()}


def printed_by(joint, belts, noise=0.0, seed=0):
    angles, rng = angles_of(joint, belts), np.random.default_rng(seed)
    found = {n: printed_quantities(printed_fits(path(), b, angles[n], noise, rng)) for n, b in belts.items()}
    return {q: {name: row[q] for name, row in found.items()} for q in next(iter(found.values()))}


def test_the_belt_is_its_mean_pulse_without_noise(belts):
    belt = belts["high"]
    assert len(belt.perturbations) == 3
    velocity = belt.position(belt.time, 1)
    assert np.ptp([velocity[p.start : p.start + 40] for p in belt.perturbations], axis=0).max() < 1e-6
    assert velocity.max() == pytest.approx(0.5, rel=0.1)
    assert belt.acceleration.size == 2 * belt.time.size - 1
    fewer = belt_motion(trial(0.5), path(), longest_s=4.0)
    assert len(fewer.perturbations) == 1
    assert fewer.time.size < belt.time.size


def test_means_around_the_windows_are_those_of_whole_records(belts):
    """Of several joints and lags at once, and with longer steps while the belt rests."""
    own, lags = path(4e-4), np.array([0.0, -1e-4])
    joints = [TRUE, replace(TRUE, stiffness_Nm_per_rad=12.0, half_softening_rad=np.inf)]
    scatter = np.array(list(SCATTER.values()))
    for name, peak in (("low", 0.1), ("high", 0.5)):
        belt, longer = belts[name], belt_motion(trial(peak), own, at_rest=STEP_AT_REST)
        assert longer.clock.size < 0.5 * belt.clock.size == 0.5 * belt.time.size
        exact, swung = (swings(own, joints, {name: b})[name] for b in (belt, longer))
        whole = [
            printed_fits(own, belt, exact(belt.time)[:, k], lag_s=lag).mean for k, lag in enumerate(lags)
        ]
        assert np.abs(whole[0] - whole[1])[1] > 4.0 * SCATTER["B"]
        for of, angle in ((belt, exact), (longer, swung)):
            found = printed_means(own, of, angle, lags)
            assert np.abs((found - whole) / scatter).max() < 0.002


def test_a_linear_joint_is_printed_as_the_signs_of_the_equation_demand(belts):
    # damped so that no swing is left in the last rest, from which the angle at rest is taken
    linear = RubberJoint(**(asdict(TRUE) | JOINTS["linear"] | {"damping_Nms_per_rad": 0.4}))
    printed = printed_by(linear, {"low": belts["low"]})
    assert printed["I"]["low"] == pytest.approx(TWO_INERTIA + 0.004, rel=5e-3)
    assert printed["B"]["low"] == pytest.approx(0.4, rel=1e-2)
    assert printed["K"]["low"] == pytest.approx(9.0 - TWO_MGR, rel=2e-2)


def test_sequential_sampling_lowers_the_printed_damping(belts):
    angles = angles_of(TRUE, {"low": belts["low"]})["low"]
    at_once, later = (
        printed_fits(path(after), belts["low"], angles).mean[1] for after in (0.0, 1.0 / 2500.0)
    )
    assert -0.08 < later - at_once < -0.02


@pytest.mark.slow
def test_known_constants_are_found_again_and_other_conditions_predicted():
    belts = {name: belt_motion(trial(peak, pulses=1), path()) for name, peak in PEAKS.items()}
    printed = printed_by(TRUE, belts)
    found = fit_joint(path(), belts, printed, ["low", "middle", "high"], {})
    for name, value in asdict(TRUE).items():
        assert getattr(found.joint, name) == pytest.approx(value, rel=0.02), name
        assert found.low[name] <= getattr(found.joint, name) <= found.high[name]
    assert found.fitted_rms < 0.02
    assert found.predicted_rms < 0.02
    # a linear joint cannot return them
    linear = fit_joint(path(), belts, printed, ["low", "middle", "high"], JOINTS["linear"])
    assert linear.free == ("stiffness_Nm_per_rad", "damping_Nms_per_rad", "inertia_Nms2_per_rad")
    assert linear.fitted_rms > 10.0 * found.fitted_rms


def test_marker_noise_is_found_from_the_printed_vaf(belts):
    printed = printed_by(TRUE, belts, noise=2e-5, seed=5)
    angles = angles_of(TRUE, belts)
    noise = fit_marker_noise(path(), belts, angles, printed["VAF_trial"], ["low", "middle"], seed=1)
    assert noise == pytest.approx(2e-5, rel=0.1)
    cells = printed_and_predicted(path(), belts, angles, printed, ["low", "middle"], noise, 2, seed=1)
    assert len(cells) == 4 * 8
    roles = {(cell.condition, cell.quantity): cell.role for cell in cells}
    assert roles["low", "K"] == roles["middle", "VAF_trial"] == "fitted"
    assert roles["other", "K"] == roles["low", "SEM_K"] == "predicted"
    for cell in cells:
        close = 0.5 if cell.quantity.startswith("SEM") else 0.1  # of three perturbations
        assert cell.value == pytest.approx(cell.printed, rel=close, abs=0.01), cell


def test_too_few_printed_numbers_are_refused(belts):
    with pytest.raises(InputError, match="more printed numbers than the 5 constants, found 3"):
        fit_joint(path(), belts, printed_by(START, belts), ["low"], {})


# ---- sampling times of the markers ----------------------------------------------------------------

LAYOUTS = {
    "spread": LAYOUT,
    "low": np.array([[0.0, 0.0], [-0.012, 0.6], [0.012, 0.5], [-0.012, 0.4], [0.012, 0.3]]),
    "two": np.array([[0.0, 0.0], [0.0, 0.87]]),
}


def test_a_struck_leg_turns_about_its_centre_of_percussion():
    """A blow at the ankle of a free rod leaves the point at l where it is; by hand from m r and I."""
    leg = path().leg
    height = percussion_height(leg, 0.0)
    # momentum p and angular momentum -p r about the centre of mass
    velocity, rate = 1.0 / leg.mass_kg, -leg.com_m / leg.inertia_kgm2
    assert velocity + (height - leg.com_m) * rate == pytest.approx(0.0, abs=1e-12)


def test_pose_error_is_that_of_the_least_squares_pose():
    heights, late, height, rate = LAYOUTS["low"][:, 1], np.arange(3, 8) * 4e-4, 0.64, 2.0
    displaced = late * (heights - height) * rate
    slope, ankle = np.polyfit(heights, displaced, 1)
    assert pose_error(heights, late, height) * rate == pytest.approx(ankle + slope * height)
    # sampled at once, but late: the whole leg is late, and its centre of percussion does not move
    assert pose_error(heights, np.full(5, 4e-4), height) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_shift_of_the_damping_in_closed_form_is_that_of_simulated_markers(layout, belts):
    offsets = LAYOUTS[layout]
    slots = np.arange(3, 8) if len(offsets) == 5 else np.array([3, 7])
    own = replace(
        path(),
        markers=SegmentMarkers(tuple("abcde"[: len(offsets)]), offsets),
        sampled_after_s=slots / 2500.0,
    )
    angles = angles_of(TRUE, {"low": belts["low"]}, own)["low"]
    at_once = replace(own, sampled_after_s=np.zeros(len(offsets)))
    later, exact = (printed_fits(way, belts["low"], angles) for way in (own, at_once))
    shift = later.mean[1] - exact.mean[1]
    found = damping_shift(own, TRUE.inertia_Nms2_per_rad, exact.squared_rate)
    assert abs(shift) > 0.02
    assert found == pytest.approx(shift, rel=0.15)


def test_lag_of_the_translation_is_found_as_damping(belts):
    """Numbers printed with a lag are returned by the true joint with it, and by another B without."""
    names, lag = ["low", "middle"], 1e-4
    own = {name: belts[name] for name in names}
    angles = angles_of(TRUE, own)
    found = {n: printed_fits(path(), b, angles[n], lag_s=lag).mean for n, b in own.items()}
    printed = {q: {n: found[n][k] for n in names} for k, q in enumerate("IBK")}
    fit = fit_joint(path(), own, printed, names, JOINTS["softening"])
    facts = timing_facts(path(), own, printed, fit, FOLLOWED)
    slope = facts["shift_per_ankle_lag_Nms_per_rad_per_s"]
    # the printed B is higher by the lag: without it, a joint with more damping is found
    assert fit.joint.damping_Nms_per_rad > TRUE.damping_Nms_per_rad
    by_lag = {round(1e6 * row["lag_s"]): row for row in facts["lags"]}
    true, zero = by_lag[100], by_lag[0]
    found, other = true["damping_Nms_per_rad"], zero["damping_Nms_per_rad"]
    assert found - other == pytest.approx(-slope * lag, rel=0.15)
    assert other == pytest.approx(fit.joint.damping_Nms_per_rad, rel=1e-3)
    assert zero["rms"] == pytest.approx(fit.fitted_rms, rel=1e-2)
    # the more a joint damps, the better 0.1 N m s/rad describes its swing
    assert true["vaf_wristalyzer"] < zero["vaf_wristalyzer"]
    assert facts["numbers"] == 6
    # a lag that would need a negative B leaves B at 0 and fits worse
    lags = 0.0, 4e-4
    free, bounded = lag_fits(path(), own, printed, fit, FOLLOWED, lags)
    assert bounded.damping_Nms_per_rad == 0.0
    assert bounded.rms > 2.0 * free.rms


def test_a_belt_that_is_recorded_late_raises_the_printed_damping(belts):
    """A lag of the ankle, made by another clock of the belt, has the stated sign and size."""
    lag, belt = 1e-4, belts["low"]
    angles = angles_of(TRUE, {"low": belt})["low"]
    late = replace(belt, position=PPoly(belt.position.c, belt.position.x + lag))
    assert late.position(3.0 + lag) == pytest.approx(belt.position(3.0))
    exact, recorded = (printed_fits(path(), own, angles) for own in (belt, late))
    rise = recorded.mean[1] - exact.mean[1]
    leg = path().leg
    l = percussion_height(leg, TRUE.inertia_Nms2_per_rad)  # noqa: E741
    assert rise == pytest.approx(leg.mass_kg * leg.com_m * exact.squared_rate * l * lag, rel=0.15)
    assert printed_fits(path(), belt, angles, lag_s=lag).mean == pytest.approx(recorded.mean, rel=1e-6)


def test_the_profile_is_bounded_where_chi_squared_exceeds_its_limit():
    """By hand: chi^2 = 4 (lag / ms - 1)^2 of 4 numbers, B falls by 0.1 per ms."""
    lags = np.linspace(-1.0, 3.0, 401)
    rows = [
        {"lag_s": 1e-3 * t, "rms": abs(t - 1.0), "damping_Nms_per_rad": 0.5 - 0.1 * t, "vaf": t} for t in lags
    ]
    found = profile({"numbers": 4, "lags": rows})
    reach = np.sqrt(LIMIT_95) / 2.0
    assert found["lags_s"] == pytest.approx([1e-3 * (1.0 - reach), 1e-3 * (1.0 + reach)], rel=1e-3)
    assert found["dampings_Nms_per_rad"] == pytest.approx([0.4 + 0.1 * reach, 0.4 - 0.1 * reach], rel=1e-3)
    assert found["unlagged"]["over_least"] == pytest.approx(4.0)
    assert profile({"numbers": 4, "lags": rows[:250]})["lags_s"][1] is None


def test_the_angle_matches_up_to_a_lag_between_those_of_the_fits():
    """By hand: the VAF is 90 - 20 t, 75 at t = 0.75; there the unexplained part is 2.5 of a printed 2."""
    columns = {"lag_s": range(-1, 4), "rms": [2.0, 1.0, 1.0, 1.0, 2.0]}
    columns |= {
        "vaf_wristalyzer": np.arange(110.0, 20.0, -20.0),
        "unexplained_percent": np.arange(6.0, 1.0, -1.0),
    }
    columns["unexplained_percent"] -= 1.75
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    timing = {"numbers": 4, "lags": rows, "printed": {"unexplained_percent": 2.0}}
    assert last_match(timing, 75.0) == pytest.approx(
        {"lag_s": 0.75, "unexplained_ratio": 1.25, "over_least": 0.0}
    )
    assert last_match(timing, 20.0) is None and last_match(timing, 120.0) is None


def test_tables_predict_each_other_and_are_copied():
    printed = {q: {"a-1": 1.0, "a-2": 2.0, "b-1": 1.0, "b-2": 2.0} for q in "IBK"}
    tables = [["a-1", "a-2"], ["b-1", "b-2"]]
    assert copied_rms(printed, tables) == 0.0
    printed["K"] |= {"b-1": 1.0 + 3.0 * SCATTER["K"]}
    assert copied_rms(printed, tables) == pytest.approx(3.0 / np.sqrt(6.0))
    assert np.isnan(copied_rms(printed, [["a-1"], []]))


@pytest.mark.slow
def test_two_tables_of_one_dummy_are_predicted_by_each_other():
    peaks = {"s-1": 0.1, "s-2": 0.3, "s-3": 0.5, "m-1": 0.15, "m-2": 0.25, "m-3": 0.45}
    belts = {name: belt_motion(trial(peak, pulses=1), path()) for name, peak in peaks.items()}
    printed = printed_by(TRUE, belts)
    tables = [list(peaks)[:3], list(peaks)[3:]]
    found = fit_tables(path(), belts, printed, tables, {})
    assert found.joint.stiffness_Nm_per_rad == pytest.approx(TRUE.stiffness_Nm_per_rad, rel=0.01)
    assert found.predicted_rms < 0.05
    # one table alone has too few numbers
    without_loss = fit_tables(path(), belts, printed, [tables[0], ["m-1"]], JOINTS["softening"])
    assert np.isnan(without_loss.predicted_rms)
