"""A rigid person of known torque on the belt: angles, torque and onsets come back, steps are named."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from belt_builders import OPTIONS as FAMILY
from belt_builders import belt_recording
from builders import assert_one_sentence
from standing_builders import (
    ANKLE_M,
    FOOT_COM_M,
    LABELS,
    LEAN_RAD,
    MASS_KG,
    ONSETS_S,
    OPTIONS,
    PERSON,
    PULSE_S,
    RATE_HZ,
    USUAL,
    G,
    Stance,
    plate_wrench,
    standing_trial,
    sway,
    true_torque,
    with_signal,
)

from tepsipe.errors import InputError
from tepsipe.experiments.standing.joint_torque import process_standing
from tepsipe.experiments.standing.options import TORQUES, TorquePathway
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.treadmill.plate_check import PlateCheck
from tepsipe.treadmill.registry import fit_model

PATHWAYS = {name: TorquePathway(name, None) for name in TORQUES}
FOOT = [LABELS.index(label) for label in PERSON.foot.labels]
LEG = [k for k in range(len(LABELS)) if k not in FOOT]
SMOOTH = OPTIONS.lowpass


@cache
def usual_trial(delay_s=0.0):
    return standing_trial(delay_s=delay_s)


def processed(trial, options=OPTIONS, pathways=PATHWAYS, models=None):
    return process_standing(trial, "standing/relax-pos-0.4", options, pathways, models or {})


@cache
def usual_standing(delay_s=0.0):
    return processed(usual_trial(delay_s))


def fault_of(trial, options=OPTIONS):
    return processed(trial, options, {}).fault


# ---- angles, pressure, torque ------------------------------------------------------------------


def test_angles_are_those_of_the_person():
    standing = usual_standing()
    angle = SMOOTH(sway(USUAL, standing.time)[0], RATE_HZ)
    assert np.ptp(angle) > 0.01
    for found in (standing.ankle, standing.shank, standing.thigh):
        assert found == pytest.approx(angle, abs=2e-6)
    assert standing.knee == pytest.approx(np.zeros(angle.size), abs=1e-9)


def test_derivatives_are_those_of_the_ankles_angle():
    standing = usual_standing()
    _, rate, acceleration = sway(USUAL, standing.time)
    assert standing.ankle_d == pytest.approx(SMOOTH(rate, RATE_HZ), abs=2e-3)
    # the acceleration jumps between samples, so that samples of it are not quite it
    smooth = SMOOTH(acceleration, RATE_HZ)
    assert np.std(standing.ankle_dd - smooth) < 0.1 * np.std(smooth)
    assert np.ptp(rate) > 0.3
    # 60 Hz instead of 20 Hz keeps more of the sharp beginning
    fine = standing.stretch_velocity["ankle"]
    assert np.std(fine - rate) < 0.4 * np.std(standing.ankle_d - rate)
    assert standing.stretch_velocity["knee"] == pytest.approx(np.zeros(rate.size), abs=1e-9)


def test_joints_angles_are_positive_where_feet_and_thighs_tip_less_and_more():
    standing = processed(standing_trial(toe_rad=-0.1, knee_rad=0.2))
    assert standing.ankle == pytest.approx(standing.shank + 0.1, abs=1e-9)
    assert standing.knee == pytest.approx(np.full(standing.time.size, 0.2), abs=1e-9)


def test_centre_of_pressure_is_under_the_centre_of_mass_at_rest():
    standing = usual_standing()
    body, m_f = PERSON.body, PERSON.feet.mass_kg
    in_front = (m_f * FOOT_COM_M + body.mass_kg * body.com_m * np.sin(LEAN_RAD)) / MASS_KG
    assert standing.y_cop[:1000] == pytest.approx(np.full(1000, ANKLE_M + in_front), abs=1e-6)
    f_y, f_z, m_x = (SMOOTH(x, RATE_HZ) for x in plate_wrench(USUAL, standing.time))
    assert standing.y_cop == pytest.approx(m_x / f_z, abs=1e-9)
    assert standing.f_y == pytest.approx(f_y, abs=1e-9)


def test_both_free_bodies_give_the_ankles_torque():
    standing = usual_standing()
    torque = SMOOTH(true_torque(USUAL, standing.time), RATE_HZ)
    assert np.ptp(torque) > 30.0
    # products of filtered signals are not filtered products: a little is left during the pulses
    assert standing.torque["ankle"] == pytest.approx(torque, abs=0.25)
    middle = slice(200, -200)
    assert standing.torque["single-joint"][middle] == pytest.approx(torque[middle], abs=0.25)
    # eq (3-14), on the feet: by vectors the same but for m_f r_Af - I_f, as the feet do not turn
    feet = PERSON.feet
    garbled = feet.mass_kg * np.hypot(0.05, 0.04) - feet.inertia_kgm2
    vectors = standing.torque["ankle-thesis-vector"]
    assert vectors == pytest.approx(standing.torque["ankle"] - garbled, abs=1e-3)
    # by scalars at rest: m_f g 0.05 and the same, whatever holds the body
    at_rest = -feet.mass_kg * G * 0.05 - garbled
    assert standing.torque["ankle-thesis"][:1000] == pytest.approx(np.full(1000, at_rest), abs=1e-4)
    assert torque[:1000].mean() == pytest.approx(27.7, abs=0.1)


def test_load_of_the_belt_is_taken_out_by_a_model_of_the_treadmill(rng):
    belt_kg, belt_kgm = 5.0, 0.5  # what the belt adds to Fy and Mx per m/s2
    acceleration = rng.standard_normal(8000)
    empty = belt_recording(np.cumsum(acceleration) / RATE_HZ, acceleration, acceleration, RATE_HZ)
    options = replace(FAMILY, fir_lead_s=0.02, fir_lag_s=0.04)
    models = {
        load: {
            "fir": fit_model("fir", [replace(empty, load=k * empty.load, unit=u).filtered(SMOOTH)], options)
        }
        for load, k, u in (("Fy", belt_kg, "N"), ("Mx", belt_kgm, "Nm"))
    }
    trial = usual_trial()
    belt_dd = USUAL.belt(trial.time)[2]

    def add(values, place, load):
        values[(slice(None), *place)] += load

    trial = with_signal(trial, "force", lambda x: add(x, (1, 1), belt_kg * belt_dd))
    trial = with_signal(trial, "moment", lambda x: add(x, (1, 0), belt_kgm * belt_dd))
    pathways = {"ankle": TorquePathway("ankle", None), "compensated": TorquePathway("ankle", "fir")}
    standing = processed(trial, pathways=pathways, models=models)
    torque = SMOOTH(true_torque(USUAL, trial.time), RATE_HZ)
    # (0.5 + 0.08 x 5) Nm per m/s2, of 25 m/s2 less what the filter takes
    as_measured = standing.torque["ankle"] - torque
    assert np.abs(as_measured).max() > 10.0
    assert np.std(standing.torque["compensated"] - torque) < 0.1 * np.std(as_measured)
    assert standing.torque["compensated"][:1000].mean() == pytest.approx(torque[:1000].mean(), abs=0.02)


# ---- clocks ------------------------------------------------------------------------------------


def test_onsets_are_found_to_a_fraction_of_a_sample():
    standing = usual_standing()
    error = standing.onsets_s - ONSETS_S
    assert np.abs(error).max() < 0.0005  # an eighth of a sample
    assert (standing.ends_s > np.array(ONSETS_S) + PULSE_S).all()
    assert (standing.ends_s < np.array(ONSETS_S) + PULSE_S + 0.02).all()


@pytest.mark.slow
# a quarter of 60 ms holds three samples only
@pytest.mark.parametrize(
    ("pulse_s", "peak_m_per_s", "apart_s"), [(0.06, 0.5, 0.002), (0.1, -0.2, 0.0005), (0.2, 0.3, 0.0005)]
)
def test_onsets_of_other_pulses_are_found_as_well(pulse_s, peak_m_per_s, apart_s):
    standing = processed(standing_trial(Stance(pulse_s=pulse_s, peak_m_per_s=peak_m_per_s)), pathways={})
    assert standing.fault is None
    error = standing.onsets_s - ONSETS_S
    assert np.abs(error).max() < apart_s


def test_nothing_near_a_perturbation_counts_as_unperturbed():
    standing = usual_standing()
    assert 0.2 < standing.unperturbed.mean() < 0.7
    for onset in ONSETS_S:
        near = (standing.time > onset - 0.5) & (standing.time < onset + PULSE_S + 2.0)
        assert not standing.unperturbed[near].any()


@pytest.mark.slow
@pytest.mark.parametrize("delay_s", [0.0, 0.0008, -0.0015])
def test_delay_of_the_markers_is_found_and_taken_out(delay_s):
    standing = usual_standing(delay_s)
    assert standing.delay_s == pytest.approx(delay_s, abs=5e-6)
    torque = SMOOTH(true_torque(USUAL, standing.time), RATE_HZ)
    assert standing.torque["ankle"] == pytest.approx(torque, abs=0.25)
    angle = SMOOTH(sway(USUAL, standing.time)[0], RATE_HZ)
    assert standing.ankle == pytest.approx(angle, abs=1e-5)


# ---- who does not stand still --------------------------------------------------------------------


def moved(trial, columns, path):
    """The trial with markers that leave their place by path(time), shape (n, 2): y and z (m)."""

    def change(positions):
        positions[:, columns, 1:] += path(trial.time)[:, None]

    return with_signal(trial, "marker_position", change)


def rising(time, start_s, lasts_s):
    """0, then a smooth rise, then 1."""
    return 0.5 - 0.5 * np.cos(np.pi * np.clip((time - start_s) / lasts_s, 0.0, 1.0))


def slid(distance_m, lasts_s, back_after_s=None):
    """The whole person slides to another place, and perhaps back."""

    def path(time):
        place = rising(time, 16.2, lasts_s)
        if back_after_s is not None:
            place = place - rising(time, 16.2 + back_after_s, lasts_s)
        return np.column_stack([distance_m * place, 0.0 * time])

    return moved(usual_trial(), slice(None), path)


def test_quiet_standing_has_no_fault():
    for amplitude in (0.4, 0.5):
        assert fault_of(standing_trial(Stance(peak_m_per_s=amplitude))) is None


@pytest.mark.parametrize(("distance_m", "said"), [(0.035, "3.5 cm"), (0.06, "6 cm"), (-0.2, "20 cm")])
@pytest.mark.parametrize("lasts_s", [0.1, 0.3, 1.0])
def test_foot_that_moves_to_another_place_and_stays_there_is_a_step(distance_m, said, lasts_s):
    fault = fault_of(slid(distance_m, lasts_s))
    assert f"moved on the belt by {said}" in fault
    assert "where standing allows 3 cm: a step" in fault
    at = float(fault.split(" at ")[1].split(" s")[0])
    assert 16.2 <= at <= 16.25 + lasts_s


def test_foot_that_comes_back_is_a_step_too():
    assert "moved on the belt by 5 cm at 16." in fault_of(slid(0.05, 0.2, back_after_s=0.4))


def test_foot_that_shifts_less_than_allowed_is_not():
    assert fault_of(slid(0.025, 0.3)) is None
    assert fault_of(slid(0.02, 0.2, back_after_s=0.4)) is None


def test_belt_whose_logged_velocity_drifts_is_no_step():
    # 0.5 mm/s, the log's step: 1.6 cm over the trial, and a slow wave of 2 cm
    trial = usual_trial()
    crept = moved(
        trial,
        slice(None),
        lambda t: np.column_stack([0.0005 * t + 0.02 * np.sin(2.0 * np.pi * t / 30.0), 0.0 * t]),
    )
    assert fault_of(crept) is None


def test_foot_that_is_lifted_is_a_step():
    def lift(time):
        up = 0.03 * np.sin(np.pi * np.clip((time - 20.1) / 0.4, 0.0, 1.0))
        return np.column_stack([0.0 * time, up])

    trial = moved(usual_trial(), [LABELS.index("foot1")], lift)
    fault = fault_of(trial)
    assert "'foot1' was lifted by 3 cm at 20.2 s" in fault
    assert "standing allows 2 cm: a step" in fault


def with_force(trial, column, change):
    """The trial with Fz (N) of one belt that ``change`` has altered, given the instants (s)."""

    def add(force):
        force[:, column, 2] = change(trial.time, force[:, column, 2])

    return with_signal(trial, "force", add)


def test_weight_on_the_other_belt_is_a_step():
    def tread(sign):
        return lambda t, f_z: f_z + sign * 100.0 * rising(t, 12.0, 0.3) * (1.0 - rising(t, 13.0, 0.3))

    # 100 N of 64 kg are 16 %
    fault = fault_of(with_force(with_force(usual_trial(), 0, tread(1)), 1, tread(-1)))
    assert "16% of the weight was on the other belt at 12.1 s" in fault
    assert "standing allows 5%: a step, repeat the trial" in fault
    assert fault_of(with_force(usual_trial(), 0, lambda t, f_z: f_z + 20.0)) is None


@pytest.mark.parametrize("share", [0.08, -0.08])
def test_load_that_shows_on_both_plates_is_cross_talk(share):
    trial = usual_trial()
    loaded = trial.values("force")[:, 1, 2]
    fault = fault_of(with_force(trial, 0, lambda _, f_z: f_z + share * loaded))
    assert "8% of the weight was on the other belt" in fault and "carried 100% of it" in fault
    assert "no step, but cross-talk between the plates" in fault and "repeat" not in fault


def test_weight_that_hangs_in_the_harness_is_a_stumble():
    def hang(lasts_s):
        def change(time, f_z):
            away = rising(time, 20.6, 0.1) * (1.0 - rising(time, 20.6 + lasts_s, 0.1))
            return f_z * (1.0 - 0.5 * away)

        return with_force(usual_trial(), 1, change)

    fault = fault_of(hang(0.4))
    assert "50% of the weight left the plate at 20.7 s for 0.38 s" in fault
    assert "stumble into the harness" in fault
    # a jolt of less than 0.1 s is none
    assert fault_of(hang(0.04)) is None


def test_shank_that_leans_far_is_a_stumble():
    trial = usual_trial()

    def tip(positions):
        # about the ankle, by 0.3 rad more than the person sways: 17 degrees
        turn = 0.3 * rising(trial.time, 20.5, 0.4) * (1.0 - rising(trial.time, 21.0, 0.4))
        ankle = positions[:, LABELS.index("ankle"), 1:].copy()
        for k in LEG:
            y, z = (positions[:, k, 1:] - ankle).T
            positions[:, k, 1] = ankle[:, 0] + y * np.cos(turn) + z * np.sin(turn)
            positions[:, k, 2] = ankle[:, 1] - y * np.sin(turn) + z * np.cos(turn)

    fault = fault_of(with_signal(trial, "marker_position", tip))
    assert "the shank leaned 17 degrees from upright at 20." in fault
    assert "standing allows 11: a stumble" in fault


@pytest.mark.parametrize(("factor", "faulty"), [(1.05, False), (1.2, True)])
def test_weight_that_changes_while_the_person_stands_is_no_persons(factor, faulty):
    trial = usual_trial()

    def louder(force):
        force[trial.time > 0.5 * trial.time[-1]] *= factor

    fault = fault_of(with_signal(trial, "force", louder))
    assert (fault is not None) is faulty
    assert not faulty or "while the person stood still: check the range and the amplifier" in fault


def test_what_is_bridged_while_a_marker_is_hidden_is_no_evidence():
    def away(time):
        # from 20 to 21 s a straight line out, another one back
        return np.column_stack([0.08 * np.clip(1.0 - 2.0 * np.abs(time - 20.5), 0.0, 1.0), 0.0 * time])

    column = LABELS.index("foot2")
    trial = moved(usual_trial(), [column], away)
    assert "'foot2' moved on the belt" in fault_of(trial)

    def hide(hidden):
        hidden[(trial.time > 20.0) & (trial.time < 21.0), column] = True

    assert fault_of(with_signal(trial, "marker_hidden", hide)) is None


# ---- what is refused ---------------------------------------------------------------------------


def refused(trial, *names, options=OPTIONS, **choices):
    with pytest.raises(InputError) as caught:
        processed(trial, options, **choices)
    assert_one_sentence(caught.value, *names)


def test_markers_that_come_too_late_are_refused_and_not_taken_for_a_step():
    refused(usual_trial(0.05), "standing/relax-pos-0.4", "20 ms")


@pytest.mark.parametrize("mass_kg", [50.0, 80.0])
def test_person_of_another_mass_is_refused(mass_kg):
    heavy = replace(OPTIONS, person=replace(PERSON, mass_kg=mass_kg))
    refused(usual_trial(), "standing/relax-pos-0.4", f"{mass_kg:g} kg", "found 64 kg", options=heavy)


def test_person_on_the_other_belt_is_refused():
    refused(usual_trial(), "64 kg", "left belt", options=replace(OPTIONS, belt="left"))


def test_belt_that_the_plate_does_not_have_is_refused():
    refused(usual_trial(), "'middle'", "'left', 'right'", options=replace(OPTIONS, belt="middle"))


def test_marker_that_was_not_recorded_is_named():
    trial = usual_trial()
    names = np.array([*LABELS[:-1], "toe"])
    refused(replace(trial, axes={**trial.axes, "marker": names}), "'thigh3'", "'toe'")


def test_markers_that_sit_elsewhere_are_refused():
    upside_down = SegmentMarkers(PERSON.thigh.labels, PERSON.thigh.layout_m[::-1])
    person = replace(PERSON, thigh=upside_down)
    refused(usual_trial(), "markers of the thigh", "mm", options=replace(OPTIONS, person=person))


def test_torque_that_is_unknown_is_refused():
    refused(usual_trial(), "'knee'", "ankle-thesis", pathways={"knee": TorquePathway("knee", None)})


@pytest.mark.parametrize("models", [{}, {"Fy": {}, "Mx": {}}])
def test_model_of_the_treadmill_that_is_not_there_is_refused(models):
    pathways = {"ankle": TorquePathway("ankle", "loaded-frame")}
    refused(usual_trial(), "'loaded-frame'", pathways=pathways, models=models)


def test_standing_that_is_hardly_ever_unperturbed_is_refused():
    # from 0.5 s before the first perturbation to 30 s after the last nothing counts
    trial = standing_trial(Stance(onsets_s=(1.2, 4.0, 6.0), duration_s=9.0))
    window = replace(OPTIONS.window, rest_before_s=1.4, rest_after_s=2.0)
    options = replace(OPTIONS, window=window, quiet_after_s=30.0)
    refused(trial, "1 s of unperturbed standing", "0.69 s", options=options)


def test_belt_that_does_not_move_is_refused():
    def stop(velocity):
        velocity[:] = 0.0

    refused(with_signal(usual_trial(), "belt_velocity", stop), "standing/relax-pos-0.4", "perturbations")


# ---- a plate that does not balance the person ----------------------------------------------------


def on_plate(origin_m=0.0, scale=1.0):
    """The usual trial on a plate whose origin lies forward, and whose moment has another scale."""
    trial = usual_trial()
    force_z = trial.values("force")[..., 2]

    def change(moment):
        moment[..., 0] = scale * (moment[..., 0] - origin_m * force_z)

    return with_signal(trial, "moment", change)


@pytest.mark.parametrize(("origin_m", "scale"), [(0.05, 1.0), (-0.02, 1.1)])
def test_plate_that_weights_have_shown_is_corrected_in_the_torque(origin_m, scale):
    check = PlateCheck(origin_m, 0.001, scale, 0.001, 1.0, 0.0)
    sound, off = usual_standing(), on_plate(origin_m, scale)
    found = process_standing(off, "standing/relax-pos-0.4", OPTIONS, PATHWAYS, {}, check)
    assert found.torque["ankle"] == pytest.approx(sound.torque["ankle"], abs=1e-6)
    assert found.plate_flags == ()
    assert found.plate is check


def test_centre_of_pressure_shows_a_plate_that_no_weight_has_shown():
    assert usual_standing().plate_flags == ()
    for origin_m in (-0.05, 0.05):
        assert processed(on_plate(origin_m)).plate_flags == ("plate-origin",)
    for origin_m in (-0.3, 0.3):
        assert "outside the foot" in processed(on_plate(origin_m)).fault
    assert processed(on_plate(0.01)).fault is None


def test_faults_of_recordings_and_another_calibration_flag_the_plate():
    rng, trial = np.random.default_rng(2), usual_trial()
    matrix = rng.standard_normal((6, 12))
    shifted, far = matrix.copy(), matrix.copy()
    shifted[3] -= 0.004 * matrix[2]
    far[3] -= 0.02 * matrix[2]

    def flags(attributes, **of_weights):
        marked = replace(trial, attributes=trial.attributes | attributes)
        check = PlateCheck(**of_weights)
        return process_standing(marked, "standing/a", OPTIONS, PATHWAYS, {}, check).plate_flags

    assert flags({"faults": "clipped"}) == ("clipped",)
    assert flags({}, faults=("spikes",)) == ("spikes",)
    assert flags({"calibration_right": matrix}, calibration=matrix) == ()
    assert flags({"calibration_right": shifted}, calibration=matrix) == ("calibration-differs",)
    assert flags({"calibration_right": far}, calibration=matrix) == ("other-calibration",)


@pytest.mark.parametrize("cutoff_hz", [11.0, 14.0])
@pytest.mark.parametrize("name", ["force", "marker_position"])
def test_signals_that_were_filtered_before_they_were_recorded_are_flagged(name, cutoff_hz, rng):
    trial = usual_trial()
    for signal, noise in (("force", 0.4), ("moment", 0.3), ("marker_position", 8e-5)):
        trial = with_signal(
            trial, signal, lambda x, sd=noise: np.add(x, sd * rng.standard_normal(x.shape), x)
        )
    assert processed(trial).plate_flags == ()

    def smooth(x):
        x[:] = butterworth_lowpass(x, RATE_HZ, cutoff_hz)

    assert processed(with_signal(trial, name, smooth)).plate_flags == ("filtered-signal",)


def test_reversed_moment_is_a_fault_by_its_name():
    """The ankles stand 0.12 m forward, so a reversed moment puts the pressure behind the heel."""
    assert "sign" in processed(on_plate(0.0, -1.0)).fault
    back = on_plate(2.0 * ANKLE_M + 2.0 * 0.044, -1.0)  # the same where both signs put it below the foot
    assert "turn the sign of M_x" in processed(back).fault
