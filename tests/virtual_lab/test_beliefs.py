"""What the analysis believes of the rigs, and what the laboratory draws: they agree and share no file."""

import numpy as np
import pytest

from tepsipe.statistics.uncertainty import sources_of
from tepsipe.virtual_lab.drawn_laboratories import drawn_numbers

# drawn constant -> source of the analysis, and what multiplies the one to be the other
SAME = {
    "dummy.subject.leg_mass_kg": ("dummy.leg_mass_kg", 1.0),
    "dummy.subject.leg_com_m": ("dummy.leg_com_m", 1.0),
    "dummy.subject.leg_inertia_kgm2": ("dummy.leg_inertia_kgm2", 1.0),
    "dummy.subject.foot_mass_kg": ("dummy.foot_mass_kg", 1.0),
    "dummy.subject.foot_com_m": ("dummy.foot_com_m", 1.0),
    "dummy.subject.joint_offset_m": ("dummy.joint_offset_m", 1.0),
    "dummy.markers.ankle_m.0": ("dummy.anterior_offset_m", 1.0),
    "dummy.markers.ankle_m.1": ("dummy.longitudinal_offset_m", 1.0),
    **{f"dummy.markers.leg_m.{k}.0": ("dummy.anterior_offset_m", 1.0) for k in range(4)},
    **{f"dummy.markers.leg_m.{k}.1": ("dummy.longitudinal_offset_m", 1.0) for k in range(4)},
    "treadmill.plate.force_scale": ("dummy.force_scale", 1.0),
    "treadmill.plate.vertical_leak": ("dummy.vertical_leak", 1.0),
    "treadmill.plate.origin_height_m": ("dummy.origin_height_m", 1.0),
    "treadmill.capture.clock_ppm": ("dummy.clock_ratio", 1e-6),
    "wristalyzer.manipulator.torque_scale": ("wristalyzer.torque_scale", 1.0),
    "wristalyzer.manipulator.angle_scale": ("wristalyzer.angle_scale", 1.0),
    "wristalyzer.manipulator.torque_delay_s": ("wristalyzer.torque_delay_s", 1.0),
    "treadmill.capture.length_scale": ("dummy.marker_scale", 1.0),
    "treadmill.capture.vertical_rad": ("dummy.vertical_rad", 1.0),
    # the time between markers is the inverse of their rate
    "treadmill.capture.marker_sampling_hz": ("dummy.marker_sampling_s", 1.0 / 2500.0**2),
    "standing.person.foot_mass": ("standing.foot_mass", 1.0 / 0.0139),
    "standing.skin.frequency_hz": ("standing.tissue_hz", 1.0),
    "standing.markers.foot_m": ("standing.foot_markers_m", 1.0),
}
# sources of several experiments that are one quantity of the rig
SHARED = {
    "weight.force_scale": "dummy.force_scale",
    "weight.marker_scale": "dummy.marker_scale",
    "standing.force_scale": "dummy.force_scale",
    "standing.moment_scale": "dummy.force_scale",
    "standing.vertical_leak": "dummy.vertical_leak",
    "standing.origin_height_m": "dummy.origin_height_m",
}
# drawn about another number than the one that the analysis takes: the latter
ABOUT = {"standing.person.marked_rotation": ("standing.marked_rotation", 1.0)}
# drawn constants of the person and sources about something near to them, which are not one quantity
OTHER_QUANTITY = {
    "standing.markers.joint_centre_m.0": "quiet sway shows the axis; the analysis states what then remains",
    "standing.markers.joint_centre_m.1": "as along the belt",
    "standing.person.mass_kg": "acts through the feet only, whose own mass is a source",
    "standing.person.shank_mass": "the torque is computed at the feet",
    "standing.person.thigh_mass": "the torque is computed at the feet",
    "standing.person.foot_com_m": "acts with the foot's mass only, in the moment of its weight",
    "standing.person.foot_stiffness_Nm_per_rad": "the tilt of the foot is measured, see foot_rotation",
    "standing.person.forefoot_share": "moves the rotation of the hindfoot, see foot_rotation",
    "standing.person.marked_share": "of the tilt of the marked foot, see foot_rotation",
    "standing.person.short_range_rad": "part of the true joint",
    "standing.markers.shank_m": "offsets leave the sway about the axis as it is",
    "standing.markers.thigh_m": "the thigh shows the knee only",
    "standing.skin.shank_share": "the responses show the soft tissue; skin_m is what then remains",
    "standing.skin.thigh_share": "as that of the shank",
    "standing.skin.slip_m_per_rad": "shown by the sway",
    "standing.nerves.twitch_s": "the reflex torque has any shape",
    "standing.nerves.relaxation_s": "the reflex torque has any shape",
}
# what is drawn and does not act on the dummy's estimates
HARMLESS = {
    "dummy.subject.rest_angle_rad": "the angle at rest is measured",
    "dummy.markers.foot_m": "the foot does not turn: its markers move alike",
    "treadmill.capture.latency_s": "the delay of the markers is measured in every trial",
}
# what is believed and not drawn
UNDRAWN = {
    "dummy.foot_compliance_rad_per_Nm": "a mechanism of the laboratory, which has this size",
    "dummy.levelled_rad": "a standard error of the trial's own, not of the rig",
    "dummy.leg_bending_rad_per_m_per_s2": "a mechanism of the laboratory, which has this size",
    "dummy.log_delay_s": "the laboratory's log is on one clock",
    "weight.belt_force_ratio": "of the plate's mechanisms, which are not drawn",
    "standing.joint_centre_anterior_m": "what quiet sway leaves of the drawn place of the axis",
    "standing.joint_centre_height_m": "as along the belt",
    "standing.palpated_centre_m": "with the error of palpation, which the laboratory's markers lack",
    "standing.origin_anterior_m": "what resting weights leave of the origin, which is not drawn",
    "standing.unknown_origin_m": "the origin where no weight shows it, which is not drawn",
    "standing.force_marker_delay_s": "what is left of the drawn latency after alignment",
    "standing.skin_m": "what the responses leave of the drawn soft tissue",
    "standing.foot_rotation": "what the drawn forefoot_share does to the rotation of the hindfoot",
    "standing.model_discrepancy": "of the plate's mechanisms, which are not drawn",
    "standing.reflex_onset_s": "latencies of the muscles, which are not drawn",
    "standing.latency_s": "latencies of the muscles, which are not drawn",
    "standing.joint_yield": "hysteresis of the joint, a mechanism of the laboratory, which is not drawn",
}


@pytest.fixture(scope="module")
def drawn(shipped_truth):
    """Constant of the section drawn -> its number."""
    found = {}
    for number in drawn_numbers(shipped_truth):
        (entry,) = [path for path in shipped_truth["drawn"] if f"{number.path}.".startswith(f"{path}.")]
        found.setdefault(entry, number)
    return found


@pytest.mark.parametrize("path", SAME)
def test_laboratory_and_analysis_believe_the_same(drawn, shipped_config, path):
    name, factor = SAME[path]
    experiment, _, source = name.partition(".")
    believed = sources_of(shipped_config["uncertainty"][experiment])[source]
    assert believed.standard_uncertainty == pytest.approx(factor * drawn[path].standard_deviation, rel=0.01)
    assert believed.distribution == drawn[path].distribution


@pytest.mark.parametrize("path", ABOUT)
def test_a_number_drawn_about_another_one_has_the_same_deviation_from_it(drawn, shipped_config, path):
    name, taken = ABOUT[path]
    experiment, _, source = name.partition(".")
    believed = sources_of(shipped_config["uncertainty"][experiment])[source]
    number = drawn[path]
    deviation = np.hypot(number.standard_deviation, number.nominal - taken) / taken
    assert believed.standard_uncertainty == pytest.approx(deviation, rel=0.01)


@pytest.mark.parametrize("name", SHARED)
def test_one_quantity_of_several_experiments_has_one_uncertainty(shipped_config, name):
    one, other = (
        shipped_config["uncertainty"][experiment][source]
        for experiment, source in (x.split(".") for x in (name, SHARED[name]))
    )
    for key in ("standard_uncertainty", "distribution"):
        assert one[key] == other[key]


def test_what_only_one_of_them_has_is_named_with_its_reason(drawn, shipped_config):
    rigs = ("wristalyzer.", "dummy.", "treadmill.plate", "treadmill.capture", "standing.")
    of_rigs = {path for path in drawn if path.startswith(rigs)}
    assert of_rigs == {*SAME, *HARMLESS, *ABOUT, *OTHER_QUANTITY}
    believed = {
        f"{experiment}.{name}"
        for experiment in ("wristalyzer", "dummy", "weight", "standing")
        for name in sources_of(shipped_config["uncertainty"][experiment])
    }
    named = {name for name, _ in (*SAME.values(), *ABOUT.values())} | set(SHARED)
    assert believed == named | set(UNDRAWN)


def test_sway_leaves_less_of_the_joint_centre_than_the_laboratory_draws_and_palpation_more(
    drawn, shipped_config
):
    believed = sources_of(shipped_config["uncertainty"]["standing"])
    felt = believed["palpated_centre_m"].standard_uncertainty
    for k, name in enumerate(("joint_centre_anterior_m", "joint_centre_height_m")):
        before = drawn[f"standing.markers.joint_centre_m.{k}"].standard_deviation
        assert believed[name].standard_uncertainty < before < felt
