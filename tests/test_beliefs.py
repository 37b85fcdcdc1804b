"""What the analysis believes of the rigs, and what the laboratory draws: they agree and share no file."""

import pytest

from tepsipe.statistics.uncertainty import sources_of
from tepsipe.virtual_lab.drawn import drawn_numbers

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
    "dummy.log_delay_s": "the laboratory's log is on one clock",
    "weight.belt_force_ratio": "of the plate's mechanisms, which are not drawn",
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


def test_what_only_one_of_them_has_is_named_with_its_reason(drawn, shipped_config):
    rigs = ("wristalyzer.", "dummy.", "treadmill.plate", "treadmill.capture")
    of_rigs = {path for path in drawn if path.startswith(rigs)}
    assert of_rigs == set(SAME) | set(HARMLESS)
    believed = {
        f"{experiment}.{name}"
        for experiment in ("wristalyzer", "dummy", "weight")
        for name in sources_of(shipped_config["uncertainty"][experiment])
    }
    shared = {name for name, _ in SAME.values()} | {"weight.force_scale", "weight.marker_scale"}
    assert believed == shared | set(UNDRAWN)
    for shared in ("force_scale", "marker_scale"):
        of_dummy, of_weight = (shipped_config["uncertainty"][e][shared] for e in ("dummy", "weight"))
        assert of_dummy == of_weight
