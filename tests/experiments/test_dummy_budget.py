"""Budget of the dummy: every contribution against the whole analysis with another value, and by hand."""

from dataclasses import replace

import numpy as np
import pytest
from builders import LEG, Joint
from scipy.interpolate import CubicSpline

from tepsipe import (
    LegUncertainty,
    fit_impedance,
    fit_joint_likelihood,
    fit_output_error,
    joint_torque,
    segment_motion,
)
from tepsipe.experiments.dummy.foot_budget import FOOT_SOURCES
from tepsipe.experiments.dummy.foot_pathways import analyse_foot
from tepsipe.experiments.dummy.leg_pathways import analyse_dummy
from tepsipe.experiments.dummy.options import Pathway
from tepsipe.experiments.dummy.results import fitted_dummy
from tepsipe.identification.budgets.leg import (
    KNOWN_OF_LEGS,
    LEG_SOURCES,
    LIKELIHOOD_SOURCES,
    compliance_contributions,
    driven_tilt_contributions,
)
from tepsipe.identification.regression.windows import regress_torque
from tepsipe.io.trial import Signal
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.mechanics.segment_kinematics import JointMotion, SegmentMarkers
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.signals.perturbations import Perturbation, rest_samples
from tepsipe.statistics.uncertainty import Source, sources_of
from tepsipe.virtual_lab.belt import DriveTruth
from tepsipe.virtual_lab.dummy import DummyTruth, FootTilt, move_dummy
from tepsipe.virtual_lab.rubber import Rubber
from tests.experiments import test_dummy_foot_pathways as plate
from tests.experiments.test_dummy_leg_pathways import OPTIONS, trial_of_swing

# small enough to be linear, large enough to be no rounding
U = {
    "leg_mass_kg": 0.004,
    "leg_com_m": 0.002,
    "leg_inertia_kgm2": 0.0003,
    "joint_offset_m": 0.001,
    "anterior_offset_m": 0.0005,
    "longitudinal_offset_m": 0.0005,
    "vertical_rad": 0.003,
    "marker_scale": 0.001,
    "clock_ratio": 0.0001,
    "marker_sampling_s": 4e-6,
    "foot_compliance_rad_per_Nm": 0.0005,
    "leg_bending_rad_per_m_per_s2": 3.2e-7,
    "foot_mass_kg": 0.03,
    "foot_com_m": 0.002,
    "force_scale": 0.003,
    "vertical_leak": 0.002,
    "origin_height_m": 0.001,
    "log_delay_s": 0.0002,
}
SOURCES = {name: Source(name, u) for name, u in U.items()}
PATHWAYS = {
    "leg": Pathway("leg", "aligned", "windowed-least-squares"),
    "simulated": Pathway("leg", "aligned", "output-error"),
    "leg-thesis": Pathway("leg-thesis", "aligned", "windowed-least-squares-thesis"),
}
KNOWN = replace(OPTIONS, belt_fixed_labels=("ankle",), sources=SOURCES)
BARE = replace(KNOWN, sources={})


@pytest.fixture(scope="module")
def trial():
    return trial_of_swing(Joint(rest=0.005))


@pytest.fixture(scope="module")
def found(trial):
    return analyse_dummy(trial, KNOWN, PATHWAYS)


def means(trial, options, *names):
    analysis = analyse_dummy(trial, options, {name: PATHWAYS[name] for name in names})
    return {name: regression.mean for name, regression in analysis.regressions.items()}


def with_markers(trial, change):
    values = trial.signals["marker_position"].values.copy()
    signal = replace(trial.signals["marker_position"], values=change(values))
    return replace(trial, signals=trial.signals | {"marker_position": signal})


# ---- public functions --------------------------------------------------------------------------


@pytest.mark.slow
def test_public_functions_have_the_intervals_of_the_pathways():
    trial, name = trial_of_swing(Joint(rest=0.005), noise_m=5e-5), "joint-likelihood"
    sources = {name: s for name, s in SOURCES.items() if name in KNOWN_OF_LEGS}
    known = replace(KNOWN, sources=sources)
    pathways = PATHWAYS | {"likelihood": Pathway("leg", "aligned", name)}
    del pathways["leg-thesis"]
    study = analyse_dummy(trial, known, pathways)
    labels, positions = trial.axes["marker"].tolist(), trial.values("marker_position")
    belt, leg, markers = trial.values("belt_velocity"), known.leg, known.leg_markers
    motion, late = (
        segment_motion(trial.time, x, markers, leg.com_m, labels=labels)
        for x in (positions, later(positions, trial.time, U["marker_sampling_s"]))
    )
    windows = {
        "perturbations": study.regressions["leg"].perturbations,
        "rest": rest_samples(trial.time, known.window),
    }
    fits = {
        "leg": fit_impedance(
            trial.time,
            motion.theta,
            joint_torque(motion, leg),
            **windows,
            cutoff_hz=None,
            uncertainty=LegUncertainty(leg, markers, sources, motion, late),
        ),
        "simulated": fit_output_error(motion, positions[:, 0, 1], belt, leg, **windows, uncertainty=sources),
        "likelihood": fit_joint_likelihood(
            trial.time,
            positions,
            markers,
            leg,
            labels=labels,
            belt_fixed=known.belt_fixed_labels,
            belt_velocity=belt,
            **windows,
            uncertainty=sources,
        ),
    }
    for name, fit in fits.items():
        for key in "IBK":
            mine, theirs = fit.quantities[key], study.quantities[name][key]
            near = 1e-3 * (theirs.high - theirs.low)
            assert [mine.value, mine.low, mine.high] == pytest.approx(
                [theirs.value, theirs.low, theirs.high], rel=0.0, abs=near
            ), (name, key)
            assert set(mine.parts) == set(theirs.parts)


def later(positions, time, lag_s):
    """Positions at instants that are later by the lag times the place of the marker in a frame."""
    lags = lag_s * np.arange(positions.shape[1])
    return positions + lags[:, None] * np.gradient(positions, time, axis=0)


# ---- the leg -----------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", ["leg_mass_kg", "leg_com_m", "leg_inertia_kgm2"])
def test_a_property_of_the_leg_contributes_what_the_whole_analysis_with_another_value_shows(
    trial, found, name
):
    field = {"leg_mass_kg": "mass_kg", "leg_com_m": "com_m", "leg_inertia_kgm2": "inertia_kgm2"}[name]
    ends = [
        means(
            trial,
            replace(BARE, leg=replace(LEG, **{field: getattr(LEG, field) + sign * U[name]})),
            "leg",
            "simulated",
        )
        for sign in (1.0, -1.0)
    ]
    for pathway in ("leg", "simulated"):
        (row,) = found.budgets[pathway].contributions[name]
        expected = 0.5 * (ends[0][pathway] - ends[1][pathway])
        assert row == pytest.approx(expected, rel=2e-3, abs=2e-7), pathway


@pytest.mark.slow
def test_the_joint_likelihood_has_the_contributions_of_fits_with_another_leg():
    trial = trial_of_swing(Joint(), noise_m=5e-5)
    pathways = {"likelihood": Pathway("leg", "aligned", "joint-likelihood")}

    def fitted(options):
        return analyse_dummy(trial, options, pathways)

    budget = fitted(KNOWN).budgets["likelihood"]
    for field, name in (("mass_kg", "leg_mass_kg"), ("com_m", "leg_com_m")):
        ends = [
            fitted(replace(BARE, leg=replace(LEG, **{field: getattr(LEG, field) + sign * U[name]})))
            for sign in (1.0, -1.0)
        ]
        above, below = (found.regressions["likelihood"].mean for found in ends)
        assert budget.contributions[name][0] == pytest.approx(0.5 * (above - below), rel=2e-3, abs=1e-6)


@pytest.mark.slow
def test_tilted_axes_of_the_motion_capture_do_not_change_the_joint_likelihood():
    trial = trial_of_swing(Joint(), noise_m=1e-6)
    likelihood = {"likelihood": Pathway("leg", "aligned", "joint-likelihood")}

    def fitted(angle):
        def turned(x):
            y, z = x[..., 1].copy(), x[..., 2].copy()
            x[..., 1], x[..., 2] = (
                y * np.cos(angle) + z * np.sin(angle),
                z * np.cos(angle) - y * np.sin(angle),
            )
            return x

        return analyse_dummy(with_markers(trial, turned), BARE, likelihood).regressions["likelihood"].mean

    level = fitted(0.0)
    assert fitted(0.005) == pytest.approx(level, rel=2e-3, abs=2e-5)
    # further than a belt can be tilted by mistake it is inclined, and axes are what they are
    assert abs(fitted(0.05)[1] - level[1]) > 1e-4


def test_stiffness_and_damping_are_proportional_to_mass_and_centre_of_mass(found):
    for pathway in ("leg", "simulated"):
        mean, budget = found.regressions[pathway].mean, found.budgets[pathway]
        for name, value in (("leg_mass_kg", LEG.mass_kg), ("leg_com_m", LEG.com_m)):
            (row,) = budget.contributions[name]
            assert row[1:] == pytest.approx(U[name] / value * mean[1:], rel=0.02), (pathway, name)
        # an inertia that is taken too large is missed in that of the joint
        (row,) = budget.contributions["leg_inertia_kgm2"]
        assert row[0] == pytest.approx(-U["leg_inertia_kgm2"], rel=1e-3)
        assert abs(row[2] / mean[2]) < 1e-4


def test_every_marker_and_direction_contributes_what_another_layout_shows(trial, found):
    labels, layout = OPTIONS.leg_markers.labels, OPTIONS.leg_markers.layout_m

    def moved(label, direction, by):
        other = layout.copy()
        other[labels.index(label), direction] += by
        return means(trial, replace(BARE, leg_markers=SegmentMarkers(labels, other)), "leg")["leg"]

    parts = found.budgets["leg"].contributions
    for kind, direction, label in (
        ("longitudinal_offset_m", 1, "leg1"),
        ("anterior_offset_m", 0, "leg2"),
        ("longitudinal_offset_m", 1, "ankle"),
    ):
        assert parts[kind].shape == (5, 3)
        expected = 0.5 * (moved(label, direction, 0.0005) - moved(label, direction, -0.0005))
        row = parts[kind][labels.index(label)]
        assert row == pytest.approx(expected, rel=0.02, abs=2e-6), label
    assert np.abs(parts["longitudinal_offset_m"][1]).max() > 1e-5


def test_a_joint_elsewhere_contributes_what_a_layout_from_there_shows(trial, found):
    labels, layout = OPTIONS.leg_markers.labels, OPTIONS.leg_markers.layout_m
    rows = found.budgets["leg"].contributions["joint_offset_m"]
    for row, offset in zip(rows, ([0.001, 0.0], [0.0, 0.001]), strict=True):
        above, below = (
            means(
                trial,
                replace(BARE, leg_markers=SegmentMarkers(labels, layout - sign * np.array(offset))),
                "leg",
            )["leg"]
            for sign in (1.0, -1.0)
        )
        assert row == pytest.approx(0.5 * (above - below), rel=0.02, abs=2e-6)
    assert abs(rows[1][0]) > 1e-4


def test_a_rod_that_bends_contributes_what_markers_that_lag_show(trial, found):
    labels, lag = trial.axes["marker"].tolist(), U["leg_bending_rad_per_m_per_s2"]
    height = dict(zip(OPTIONS.leg_markers.labels, OPTIONS.leg_markers.layout_m[:, 1], strict=True))
    foot = trial.values("marker_position")[:, labels.index("ankle"), 1]
    foot_dd = CubicSpline(trial.time, foot)(trial.time, 2)

    def lagging(by):
        def change(x):
            x[..., 1] += by * np.outer(foot_dd, [height.get(label, 0.0) for label in labels])
            return x

        return means(with_markers(trial, change), BARE, "leg")["leg"]

    (row,) = found.budgets["leg"].contributions["leg_bending_rad_per_m_per_s2"]
    assert row == pytest.approx(0.5 * (lagging(lag) - lagging(-lag)), rel=0.05, abs=1e-6)
    assert abs(row[2] / found.regressions["leg"].mean[2]) > 1e-3


def test_scale_and_direction_of_the_motion_capture_contribute_what_other_markers_show(trial, found):
    tilt = U["vertical_rad"]

    def turned(angle):
        def change(x):
            y, z = x[..., 1].copy(), x[..., 2].copy()
            x[..., 1] = y * np.cos(angle) + z * np.sin(angle)
            x[..., 2] = z * np.cos(angle) - y * np.sin(angle)
            return x

        return means(with_markers(trial, change), BARE, "leg")["leg"]

    (row,) = found.budgets["leg"].contributions["vertical_rad"]
    assert row == pytest.approx(0.5 * (turned(tilt) - turned(-tilt)), rel=0.05, abs=2e-6)

    def scaled(by):
        return means(with_markers(trial, lambda x: by * x), BARE, "leg", "simulated")

    above, below = scaled(1.001), scaled(0.999)
    for pathway in ("leg", "simulated"):
        (row,) = found.budgets[pathway].contributions["marker_scale"]
        assert row == pytest.approx(0.5 * (above[pathway] - below[pathway]), rel=0.03, abs=3e-6), pathway


def test_a_clock_and_a_longer_time_between_markers_contribute_alike_in_both_methods(found):
    (leg,) = found.budgets["leg"].contributions["clock_ratio"]
    (simulated,) = found.budgets["simulated"].contributions["clock_ratio"]
    critical = LEG.mass_kg * LEG.gravity_m_per_s2 * LEG.com_m
    assert simulated[2] == pytest.approx(-2.0 * U["clock_ratio"] * (10.0 - critical), rel=0.01)
    assert leg[1:] == pytest.approx(simulated[1:], rel=0.05)
    # the mean of the leg's markers is sampled later than those below: B falls by 40 to 100 per s
    (late,) = found.budgets["leg"].contributions["marker_sampling_s"]
    assert 1e-5 < abs(late[1]) < 1e-3
    assert "marker_sampling_s" not in found.budgets["simulated"].contributions


def test_the_thesis_has_type_a_only_and_no_sources_no_type_b(trial, found):
    fitted = fitted_dummy("sine-0.3", found, 100, 1)
    rows = {(row.pathway, row.quantity): row for row in fitted.estimates}
    assert rows["leg-thesis", "K"].u_type_b is None and rows["leg", "K"].u_type_b > 0.05
    thesis = found.regressions["leg-thesis"].parameters[:, 2]
    assert rows["leg-thesis", "K"].standard_error == pytest.approx(thesis.std(ddof=1) / np.sqrt(thesis.size))
    parts = fitted.contributions
    assert {part.source for part in parts if part.pathway == "leg"} == {"scatter", *LEG_SOURCES}
    assert {part.source for part in parts if part.pathway == "leg-thesis"} == {"scatter"}
    assert not any(b.contributions for b in analyse_dummy(trial, BARE, PATHWAYS).budgets.values())


def test_the_budget_scales_with_the_units_of_mass(found):
    # forces in another unit: masses, inertias and K in the same multiple, relative uncertainty unchanged
    leg = replace(LEG, mass_kg=10.0 * LEG.mass_kg, inertia_kgm2=10.0 * LEG.inertia_kgm2)
    wide = {name: SOURCES[name] for name in LEG_SOURCES}
    for name in ("leg_mass_kg", "leg_inertia_kgm2"):
        wide[name] = Source(name, 10.0 * U[name])
    compliance = "foot_compliance_rad_per_Nm"
    wide[compliance] = Source(compliance, 0.1 * U[compliance])
    heavy = analyse_dummy(
        trial_of_swing(Joint(rest=0.005)), replace(KNOWN, leg=leg, sources=wide), {"leg": PATHWAYS["leg"]}
    )
    for name, rows in heavy.budgets["leg"].contributions.items():
        assert rows == pytest.approx(10.0 * found.budgets["leg"].contributions[name], rel=1e-6, abs=1e-12)


def test_a_difference_of_two_conditions_is_sharper_than_either(found):
    stiffer = analyse_dummy(
        trial_of_swing(Joint(rest=0.005, stiffness=11.0)), KNOWN, {"leg": PATHWAYS["leg"]}
    )
    one, other = found.budgets["leg"], stiffer.budgets["leg"]
    difference = other.minus(one)
    assert difference.type_b[2] < 0.5 * one.type_b[2]
    # what is left is the mass of 1 N m/rad
    assert difference.of_source("leg_mass_kg")[2] == pytest.approx(0.01 * 1.0, rel=0.05)


def test_a_compliance_in_series_lowers_the_apparent_joint():
    values, c = np.array([0.007, 0.05, 10.0]), 1e-5
    (row,) = compliance_contributions(values, {"foot_compliance_rad_per_Nm": Source("c", c)}).values()
    s = 1j * np.array([0.5, 1.0, 2.0])
    joint = values[0] * s**2 + values[1] * s + values[2]
    apparent = joint / (1.0 + c * joint) - joint
    assert row[0, 2] + row[0, 0] * np.real(s**2) == pytest.approx(apparent.real, rel=1e-3)
    assert row[0, 1] * s.imag == pytest.approx(apparent.imag, rel=1e-2)
    assert compliance_contributions(values, {}) == {}


# ---- the foot ----------------------------------------------------------------------------------

OF_FOOT = {name: plate.PATHWAYS[name] for name in ("foot", "foot-long")}


def foot_means(trial, choice=plate.CHOICE):
    return plate.parameters(trial, OF_FOOT, choice=choice)


def with_loads(trial, change):
    force, moment = (trial.signals[name].values.copy() for name in ("force", "moment"))
    change(force[:, 1, 1], force[:, 1, 2], moment[:, 1, 0])
    signals = {"force": force, "moment": moment}
    return replace(
        trial,
        signals=trial.signals
        | {
            name: Signal(values, trial.signals[name].unit, trial.signals[name].axes, name)
            for name, values in signals.items()
        },
    )


def test_force_plate_and_foot_contribute_what_other_loads_and_another_foot_show():
    trial = plate.plate_trial()
    found = analyse_foot(trial, "x", replace(plate.DUMMY, sources=SOURCES), plate.CHOICE, plate.PATHWAYS, {})
    assert found.budgets["foot-thesis"].contributions == {}
    before = foot_means(trial)

    def fore_aft(f_y, f_z, m_x):
        f_y *= 1.0 + U["force_scale"]

    def vertical(f_y, f_z, m_x):
        f_z *= 1.0 + U["force_scale"]
        m_x *= 1.0 + U["force_scale"]

    def leak(f_y, f_z, m_x):
        f_y += U["vertical_leak"] * f_z

    def origin(f_y, f_z, m_x):
        m_x += U["origin_height_m"] * f_y

    heavier = replace(plate.FOOT, mass_kg=plate.FOOT.mass_kg + U["foot_mass_kg"])
    changed = {
        ("force_scale", 0): foot_means(with_loads(trial, fore_aft)),
        ("force_scale", 1): foot_means(with_loads(trial, vertical)),
        ("vertical_leak", 0): foot_means(with_loads(trial, leak)),
        ("origin_height_m", 0): foot_means(with_loads(trial, origin)),
        ("foot_mass_kg", 0): foot_means(trial, replace(plate.CHOICE, foot=heavier)),
    }
    for name in OF_FOOT:
        budget = found.budgets[name]
        assert set(budget.contributions) == set(FOOT_SOURCES)
        for (source, place), after in changed.items():
            expected = after[name] - before[name]
            row = budget.contributions[source][place]
            assert row == pytest.approx(expected, rel=1e-3, abs=1e-8), (name, source)
        rows = budget.contributions["joint_offset_m"]
        higher = replace(plate.FOOT, height_m=plate.FOOT.height_m + 0.001)
        # in the foot that is 1 mm higher the centre of mass rises, too, by half of that
        expected = foot_means(trial, replace(plate.CHOICE, foot=higher))[name] - before[name]
        assert rows[1] - 0.25 * budget.contributions["foot_com_m"][0] * np.sign(-1.0) == pytest.approx(
            expected, rel=2e-3, abs=1e-6
        )


def test_a_delay_of_the_log_after_the_forces_contributes_what_later_forces_show():
    found = analyse_foot(
        plate.plate_trial(), "x", replace(plate.DUMMY, sources=SOURCES), plate.CHOICE, OF_FOOT, {}
    )
    trial = plate.plate_trial()
    shift = U["log_delay_s"]

    def later(f_y, f_z, m_x):
        for x in (f_y, f_z, m_x):
            x[:] = CubicSpline(trial.time, x)(np.clip(trial.time - shift, 0.0, None))

    # forces that come later are those of a log, and of markers aligned to it, that come earlier
    after = foot_means(with_loads(trial, later))
    before = foot_means(trial)
    for name in OF_FOOT:
        (row,) = found.budgets[name].contributions["log_delay_s"]
        # one step to one side: the second order of K is a few per cent of it
        assert row[:2] == pytest.approx((after[name] - before[name])[:2], rel=0.03, abs=1e-5), name
        assert row[2] == pytest.approx((after[name] - before[name])[2], rel=0.1), name
        assert abs(row[1]) > 1e-3


def test_shipped_sources_are_those_of_the_pathways(config):
    known = set(sources_of(config["uncertainty"]["dummy"]))
    assert known == {*LEG_SOURCES, *LIKELIHOOD_SOURCES, *FOOT_SOURCES}


def test_tilt_that_the_inertia_of_the_foot_drives_raises_the_damping(shipped_truth):
    """Windows of a moving dummy with a foot that tilts, and with one that does not."""
    truth, c, rate = shipped_truth["dummy"], 0.0005, 2000.0
    subject = DummyTruth(**truth["subject"] | {"joint_offset_m": [0.0, 0.0], "rest_angle_rad": 0.0})
    drive = DriveTruth(**shipped_truth["treadmill"]["drive"])
    rubber = Rubber(9.0, 0.075, 0.0, 0.05, 0.0)

    def pulse(t):
        return np.where((t >= 0.2) & (t < 0.3), 0.3 * np.sin(2.0 * np.pi * (t - 0.2) / 0.1), 0.0)

    window = [Perturbation(int(0.2 * rate), int(0.36 * rate), 0.3)]
    fits = {}
    for held, compliance in (("rigid", 0.0), ("tilting", c)):
        moved = move_dummy(subject, rubber, drive, pulse, 0.8, rate, FootTilt(compliance, 0.2, 0.006))
        angle, angle_rate, torque = (
            butterworth_lowpass(x, rate, 20.0, 4) for x in (moved.angle, moved.angle_rate, moved.joint_torque)
        )
        motion = JointMotion(moved.time, angle, angle_rate, np.gradient(angle_rate, moved.time))
        fits[held] = regress_torque(motion, torque, window, moved.time < 0.1)
    leg = Leg(mass_kg=0.4, com_m=0.4485, inertia_kgm2=0.027)
    source = {"foot_compliance_rad_per_Nm": Source("c", c)}
    (row,) = driven_tilt_contributions(fits["rigid"], leg, Foot(2.1, 0.055), source).values()
    change = fits["tilting"].mean - fits["rigid"].mean
    assert row[0] == pytest.approx(change, rel=0.25)
    # the damping of a foot that only the joint tilts would fall
    assert change[1] > 0.02 * 0.075
    (slow,) = compliance_contributions(fits["rigid"].mean, source).values()
    assert slow[0, 1] < 0.0
    assert driven_tilt_contributions(fits["rigid"], leg, Foot(2.1, 0.055), {}) == {}
