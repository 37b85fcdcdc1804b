"""Fit of the virtual force plate to section 4-1-2: measure of its statements, and shipped constants."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks import plate_constants as script


@pytest.mark.slow
def test_stiff_frame_without_friction_measures_the_mass_and_no_other_force():
    off = ("friction_N", "friction_coefficient", "friction_Ns_per_m", "felt_belt_mass_kg", "mount_share")
    plate = replace(script.SHIPPED, resonance_hz=800.0, second_hz=900.0, **dict.fromkeys(off, 0.0))
    found = script.pulse(plate, ("sine", 0.1))
    # the belt, whose acceleration is the instrument, moves by a little less than the weight
    assert found.mass_kg == pytest.approx(20.0, rel=2e-3)
    assert np.abs(found.induced).max() < 0.02 * np.abs(found.jerk_force).max() / (2.0 * np.pi * 10.0)


@pytest.mark.slow
@pytest.mark.parametrize("plate", [script.fitted_plate(), script.changed(script.DAMPED)])
def test_fitted_plates_meet_the_statements_and_the_shipped_one_does_not(plate):
    fitted, shipped = script.statements(plate), script.statements(script.SHIPPED)
    printed = np.array(list(script.PRINTED.values()))
    assert (np.abs(fitted.masses_kg - printed[:, 0]) <= printed[:, 1]).all()
    assert (np.abs(np.log2(fitted.sds_kg / printed[:, 1])) <= 1.0).all()
    assert (np.abs(np.log2(shipped.sds_kg / printed[:, 1])) > 1.0).sum() >= 2

    def share(found):
        return float((found.differences > 0.0).all(axis=0).mean())

    assert share(fitted) > 0.75 > 0.25 > share(shipped)


@pytest.mark.slow
def test_kept_page_has_the_fitted_constants_within_their_ranges(root):
    page = (root / "benchmarks/plate_constants.md").read_text(encoding="utf-8")
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| `")]
    kept = {key.strip("`"): float(value) for key, _, _, value, *_ in rows}  # column "Fitted"
    assert set(kept) == set(script.CONSTANTS)
    for key, own in script.CONSTANTS.items():
        value = script.value_of(script.fitted_plate(), key)
        assert own.low <= value <= own.high and kept[key] == pytest.approx(value, rel=5e-3)
