"""The weight and the empty belt on the plate: what is carried and what the belt adds are told apart."""

from dataclasses import replace

import numpy as np
import pytest
from belt_builders import belt_recording, pulsed_evaluated
from builders import assert_one_sentence, belt_pulses, trial_of

from tepsipe.errors import InputError
from tepsipe.experiments.weight.analysis import (
    analyse_weight,
    estimate_masses,
    fitted_weight,
    shapes,
    speed_at_peak,
)
from tepsipe.io.result import Result
from tepsipe.io.trial import Signal, Trial
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.statistics.uncertainty import Source
from tepsipe.treadmill.options import Weight
from tepsipe.treadmill.prepared import zero_line
from tepsipe.treadmill.trial_recordings import PlateOptions, marker_lag, plate_recordings, table_recording

RATE_HZ = 250.0
TIME = np.arange(3000) / RATE_HZ
ONSETS_S = (3.0, 5.0, 7.0)
WEIGHT = Weight(mass_kg=20.0, com_height_m=0.1, gravity_m_per_s2=9.81)
LOWPASS = Lowpass(30.0, 4, True)
OPTIONS = PlateOptions("right", LOWPASS, LOWPASS, WindowOptions(2.5, 4.0, 0.3, 0.05, 5.0, 0.06), 0.3)
SOURCES = {"force_scale": Source("force_scale", 0.01), "belt_force_ratio": Source("belt_force_ratio", 0.01)}
ADDED_KG, ADDED_KGM = 4.0, -0.8  # what the belt adds to Fy and Mx per m/s2


def plate_trial(kg, stands_m=0.02, peak=0.4, lag_s=0.0):
    """A body of some mass on the right belt, centre 0.1 m above it; transducers drift, markers may lag."""
    y, v, a = belt_pulses(TIME, ONSETS_S, peak)
    force, moment = np.zeros((2, TIME.size, 2, 3))
    force[:, 1, 1] = (kg + ADDED_KG) * a + 5.0 - 0.3 * TIME
    force[:, 1, 2] = 9.81 * kg + 2.0 * TIME
    # moment about x: y F_z - z F_y
    moment[:, 1, 0] = 9.81 * kg * (stands_m + y) - 0.1 * kg * a + ADDED_KGM * a + 0.1 * TIME
    force[:, 0] = 99.0
    seen = stands_m + belt_pulses(TIME - lag_s, ONSETS_S, peak)[0]
    markers = np.stack([np.full_like(y, 0.3), seen, np.full_like(y, 0.15)], axis=1)
    signals = {
        "belt_velocity": Signal(v + 0.002, "m/s", ("time",), "measured"),
        "force": Signal(force, "N", ("time", "belt", "axis"), "measured"),
        "moment": Signal(moment, "Nm", ("time", "belt", "axis"), "measured"),
        "marker_position": Signal(
            np.stack([markers] * 4, axis=1), "m", ("time", "marker", "axis"), "measured"
        ),
    }
    return Trial(RATE_HZ, {"time": TIME, "belt": np.array(["left", "right"])}, signals)


def recordings_of(kg, **changes):
    weight = replace(WEIGHT, mass_kg=kg) if kg else None
    options = replace(OPTIONS, **changes)
    return plate_recordings(plate_trial(kg), "weight/sine-0.4", "sine-0.4", options, weight)


@pytest.mark.slow
@pytest.mark.parametrize("weight_motion", ["belt", "markers"])
@pytest.mark.parametrize("kg", [0.0, 20.0])
def test_load_of_the_belt_and_of_the_weight_are_told_apart(kg, weight_motion):
    found = recordings_of(kg, weight_motion=weight_motion)
    y, v, a = belt_pulses(TIME, ONSETS_S, 0.4)
    y, v, a = (LOWPASS(x, RATE_HZ) for x in (y, v, a))
    force, moment = found["Fy"], found["Mx"]
    assert (force.unit, moment.unit) == ("N", "Nm")
    for r in (force, moment):
        assert r.carried_kg == kg
        assert r.velocity == pytest.approx(v, abs=1e-6)
        assert r.acceleration == pytest.approx(a, abs=2e-3 * np.abs(a).max())
    assert force.carried == pytest.approx(kg * a, abs=2e-3 * max(kg, 1.0) * np.abs(a).max())
    assert moment.carried == pytest.approx(kg * (9.81 * y - 0.1 * a), abs=2e-3 * max(kg, 1.0))
    assert force.load == pytest.approx(ADDED_KG * a, abs=0.05 * ADDED_KG)
    assert moment.load == pytest.approx(ADDED_KGM * a, abs=0.05)


def test_segments_begin_where_the_belt_does_and_do_not_depend_on_the_filter():
    wide = recordings_of(20.0)["Fy"]
    narrow = recordings_of(20.0, lowpass=Lowpass(8.0, 4, True))["Fy"]
    assert narrow.onsets == wide.onsets
    assert np.array_equal(wide.onsets, wide.onsets[0] + np.array([0, 500, 1000]))
    assert wide.onsets[0] / RATE_HZ == pytest.approx(3.03, abs=0.04)
    assert np.array_equal(wide.evaluated, pulsed_evaluated(TIME.size, wide.onsets, 75))
    parts = wide.segments(wide.velocity)
    assert parts.shape == (3, 75)
    assert parts[0] == pytest.approx(parts[2], abs=1e-6)


@pytest.mark.parametrize("lag_s", [0.0, 0.002, -0.005])
def test_lag_of_the_markers_is_measured_and_moves_the_mass_only_if_they_are_used(lag_s):
    trial = plate_trial(20.0, lag_s=lag_s)
    assert marker_lag(trial, "weight/sine-0.4", OPTIONS) == pytest.approx(lag_s, abs=2e-5)
    of_belt, of_markers = (
        estimate_masses(
            plate_recordings(trial, "x", "x", replace(OPTIONS, weight_motion=motion), WEIGHT)["Fy"]
        )
        for motion in ("belt", "markers")
    )
    assert of_belt == pytest.approx(np.full(3, 20.0 + ADDED_KG), rel=2e-3)
    # accelerations of belt and markers that are apart by a time T: their product falls by T^2 / 2 y^(4) / y''
    assert np.all(of_markers > of_belt - 0.05)
    assert (of_markers - of_belt > 0.1).all() == (lag_s != 0.0)


def test_noise_of_the_markers_does_not_make_the_mass_too_small(rng):
    """Noise with a fifth of the power of the acceleration: 20 kg, not 20 / 1.2."""
    a = rng.standard_normal(40000)
    noisy = 20.0 * (a + np.sqrt(0.2) * rng.standard_normal(a.size))
    onsets = tuple(range(100, 39900, 100))
    r = belt_recording(a, a, 20.0 * a - noisy, carried=noisy, carried_kg=20.0, onsets=onsets, unit="N")
    r = replace(r, evaluated=pulsed_evaluated(a.size, onsets, 75))
    masses = estimate_masses(r)
    assert masses.mean() == pytest.approx(20.0, abs=4.0 * masses.std() / np.sqrt(masses.size))
    assert masses.mean() > 19.5


def test_mass_that_the_belt_adds_is_found_in_the_estimated_mass():
    found = recordings_of(20.0)["Fy"]
    assert estimate_masses(found) == pytest.approx(np.full(3, 20.0 + ADDED_KG), rel=2e-3)


def test_estimated_mass_is_exact_for_an_exact_mass_and_ignores_what_is_uncorrelated(rng):
    a = rng.standard_normal(600)
    carried = 20.0 * a
    r = belt_recording(a, a, 0.0 * a, carried=carried, carried_kg=20.0, onsets=(100, 300), unit="N")
    r = replace(r, evaluated=pulsed_evaluated(600, r.onsets, 75))
    assert estimate_masses(r) == pytest.approx([20.0, 20.0], rel=1e-12)
    heavy = np.where(np.arange(600) < 250, -0.5, 2.0)
    assert estimate_masses(replace(r, load=heavy * a)) == pytest.approx([19.5, 22.0])
    inside = r.evaluated
    orthogonal = np.zeros(600)
    for start in r.onsets:
        part, x = slice(start, start + 75), rng.standard_normal(75)
        orthogonal[part] = x - a[part] * (a[part] @ x) / (a[part] @ a[part])
    assert np.abs(orthogonal[inside]).max() > 1.0
    assert estimate_masses(replace(r, load=50.0 * orthogonal)) == pytest.approx([20.0, 20.0], rel=1e-10)


def test_rows_and_arrays_of_the_weight_experiment():
    wide, narrow = (recordings_of(20.0, lowpass=Lowpass(hz, 4, True))["Fy"] for hz in (20.0, 10.0))
    found = analyse_weight({"20 Hz": wide, "10 Hz": narrow}, SOURCES)
    fitted = fitted_weight("weight", "sine-0.4", found)
    rows = {row.quantity: row for row in fitted.estimates}
    assert list(rows) == ["mass", "mass_sd", "added_force_peak"]
    mass = rows["mass"]
    assert mass.value == pytest.approx(found.masses.mean())
    assert mass.recommended and not rows["mass_sd"].recommended
    # by hand: SD / sqrt(3), 1 % of the force and of the belt; the quantile lies between those of 2 and inf
    type_b = np.hypot(0.01, 0.01) * mass.value
    assert mass.u_type_a == pytest.approx(found.masses.std(ddof=1) / np.sqrt(3.0))
    assert mass.u_type_b == pytest.approx(type_b)
    assert mass.standard_error == pytest.approx(np.hypot(mass.u_type_a, type_b))
    assert 1.9599 <= (mass.ci_high - mass.value) / mass.standard_error < 4.303
    assert mass.value - mass.ci_low == pytest.approx(mass.ci_high - mass.value)
    assert rows["mass_sd"].value == pytest.approx(found.masses.std(ddof=1))
    a = LOWPASS(belt_pulses(TIME, ONSETS_S, 0.4)[2], RATE_HZ)
    assert rows["added_force_peak"].value == pytest.approx(ADDED_KG * np.abs(a).max(), rel=0.15)
    assert [(row.quantity, row.source) for row in fitted.contributions] == [
        ("mass", source) for source in ("scatter", *SOURCES)
    ]
    result = fitted.result
    assert result.arrays["10 Hz/added_force"].shape == (3, 75)
    assert np.array_equal(result.arrays["20 Hz/added_force"], wide.segments(wide.load))
    empty = analyse_weight({"20 Hz": recordings_of(0.0)["Fy"]}, SOURCES)
    fitted = fitted_weight("empty", "sine-0.4", empty)
    assert [row.quantity for row in fitted.estimates] == ["added_force_peak"]
    assert not fitted.contributions


def test_mass_is_flagged_where_its_interval_does_not_hold_that_of_the_trial_sheet():
    # intervals are about 1.96 x 1.4 % wide to either side
    a = np.tile(np.sin(np.linspace(0.0, 2.0 * np.pi, 300)), 2)
    r = belt_recording(a, a, 0.0 * a, carried=20.0 * a, carried_kg=20.0, onsets=(100, 300), unit="N")
    r = replace(r, evaluated=pulsed_evaluated(600, r.onsets, 75))
    for added_kg, flags in ((0.0, ""), (0.5, ""), (-0.5, ""), (0.7, "mass-differs"), (-0.7, "mass-differs")):
        found = analyse_weight({"20 Hz": replace(r, load=added_kg * a)}, SOURCES)
        mass, *others = fitted_weight("weight", "sine", found).estimates
        assert mass.value == pytest.approx(20.0 + added_kg)
        assert mass.recommended and mass.flags == flags, added_kg
        assert not any(row.flags for row in others)


def test_shapes_and_peaks_by_hand():
    def result(force, speed):
        arrays = {"20 Hz/added_force": np.array(force), "20 Hz/belt_velocity": np.array(speed)}
        return Result({key: np.stack([x - 1.0, x + 1.0]) for key, x in arrays.items()}, {}, {})

    empty = {"a": result([0.0, 3.0, 4.0], [0.0, 0.2, 0.5]), "b": result([1.0, 0.0, 0.0], [0.5, 0.1, 0.0])}
    weight = {"a": result([0.0, 4.0, 3.0], [0.0, 0.2, 0.5]), "b": result([0.0, 0.0, -2.0], [0.1, 0.1, -0.4])}
    alike, sizes = shapes(empty, weight, "20 Hz")
    assert alike == pytest.approx([0.96, 0.0])
    assert sizes == pytest.approx([1.0, 2.0])
    assert speed_at_peak(empty, "20 Hz") == pytest.approx([1.0, 1.0])
    assert speed_at_peak(weight, "20 Hz") == pytest.approx([0.4, 1.0])


def test_line_through_rest_goes_and_nothing_else():
    at_rest = (TIME < 2.0) | (TIME > 10.0)
    bump = np.exp(-0.5 * ((TIME - 5.0) / 0.2) ** 2)
    both = np.column_stack([bump + 3.0 - 0.2 * TIME, 2.0 * bump + 7.0 * TIME])
    assert zero_line(both, TIME, at_rest) == pytest.approx(np.column_stack([bump, 2.0 * bump]), abs=1e-9)


def test_plate_trials_that_cannot_be_used_are_refused():
    def refused(*names, **changes):
        with pytest.raises(InputError) as caught:
            recordings_of(20.0, **changes)
        assert_one_sentence(caught.value, "weight/sine-0.4", *names)

    refused("'middle'", "'left', 'right'", belt="middle")
    refused("2.2 s", segment_s=2.2)
    refused("6 s", segment_s=6.0)


def test_table_becomes_a_recording_without_its_ends():
    time = np.arange(3000) / 100.0
    trial = trial_of(100.0, load=(np.sin(time), "Nm"), belt_velocity=(time**2, "m/s"))
    found = table_recording(trial, "slow-1", 1.0)
    assert (found.unit, found.rate_hz, found.carried_kg) == ("Nm", 100.0, 0.0)
    assert np.array_equal(found.evaluated, (np.arange(3000) >= 100) & (np.arange(3000) < 2900))
    # central differences are exact for a parabola
    assert found.acceleration[1:-1] == pytest.approx(2.0 * time[1:-1], rel=1e-9)
    steady = trial_of(100.0, load=(np.sin(time), "N"), belt_velocity=(np.full(3000, 1.5), "m/s"))
    assert table_recording(steady, "x", 1.0).position == pytest.approx(1.5 * time)
    assert table_recording(steady, "x", 1.0).unit == "N"
