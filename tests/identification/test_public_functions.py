"""The public functions: known truths found again, units converted, unusable input refused in one sentence."""

import numpy as np
import pytest
from builders import LEG, RATE_HZ, Joint, refused, swing
from scipy.signal import butter, sosfiltfilt

from tepsipe import (
    SegmentMarkers,
    Signal,
    find_perturbations,
    fit_admittance,
    fit_impedance,
    fit_joint_likelihood,
    fit_output_error,
    fit_parallel_cascade,
    frequency_response,
    joint_torque,
    segment_motion,
    simulate_joint,
)
from tepsipe.identification.result import Quantity
from tepsipe.signals.filters import butterworth_lowpass

TRUE = Joint(inertia=0.002, damping=0.1, stiffness=10.0)


# ---- a joint from arrays -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def moved():
    return swing(TRUE)


@pytest.fixture(scope="module")
def arrays(moved):
    """Time (s), angle (rad), torque (Nm), belt velocity (m/s) of a joint without noise."""
    motion = moved.motion
    torque = TRUE.inertia * motion.theta_dd + TRUE.damping * motion.theta_d + TRUE.stiffness * motion.theta
    return motion.time, motion.theta, torque, moved.belt_velocity


@pytest.fixture(scope="module")
def pulses(arrays):
    return find_perturbations(arrays[0], arrays[3], rest_before_s=1.9, rest_after_s=1.0)


def test_perturbations_are_where_the_belt_moves(pulses):
    # two lobes from 2, 4 and 6 s on, 0.15 s together, which the filter spreads by some samples
    starts = [p.start / RATE_HZ for p in pulses]
    assert starts == pytest.approx([2.0, 4.0, 6.0], abs=0.03)
    assert [(p.stop - p.start) / RATE_HZ for p in pulses] == pytest.approx([0.15] * 3, abs=0.02)


@pytest.mark.parametrize("windowed", [True, False])
def test_joint_without_noise_is_found_exactly(arrays, pulses, windowed):
    time, angle, torque, _ = arrays
    fit = fit_impedance(time, angle, torque, perturbations=pulses if windowed else None)
    # all signals pass the same filter, which leaves their linear relation as it is
    assert fit.parameters == pytest.approx([0.002, 0.1, 10.0], rel=2e-3, abs=1e-6)
    assert fit.vaf > 99.99
    assert fit.K == fit.quantities["K"].value == fit.parameters[2]


def test_windowed_fit_has_one_estimate_per_perturbation_and_their_mean(arrays, pulses):
    fit = fit_impedance(*arrays[:3], perturbations=pulses)
    assert fit.windows.shape == (3, 3)
    assert fit.windows.mean(axis=0) == pytest.approx(fit.parameters)
    pairs = [(p.start, p.stop) for p in pulses]
    assert fit_impedance(*arrays[:3], perturbations=pairs).parameters.tolist() == fit.parameters.tolist()


def test_window_without_movement_is_refused(arrays):
    time, angle, torque, _ = arrays
    still = np.where(time < 4.0, 0.0, angle)
    windows = [(500, 550), (1000, 1050)]
    refused(lambda: fit_impedance(time, still, torque, perturbations=windows), "none from 500 to 550")


@pytest.mark.parametrize(
    ("value", "error", "cells"),
    [
        (8.05123, 0.0234, ("8.051", "0.023", "[8.028, 8.075]")),
        (8051.23, 23.4, ("8051", "23", "[8028, 8075]")),
        (8.05123, np.nan, ("8.051", "–", "–")),
        (np.nan, 0.02, ("nan", "0.020", "–")),
    ],
)
def test_numbers_are_rounded_by_their_standard_error(value, error, cells):
    assert Quantity(value, "N", error, value - error, value + error).cells() == cells


def test_thesis_leaves_the_torque_at_rest_in(arrays, pulses):
    time, angle, torque, _ = arrays
    offset = fit_impedance(time, angle, torque + 0.5, perturbations=pulses)
    assert offset.parameters == pytest.approx([0.002, 0.1, 10.0], rel=2e-3, abs=1e-6)
    thesis = fit_impedance(time, angle, torque + 0.5, perturbations=pulses, thesis=True)
    assert abs(thesis.K - 10.0) > 1.0
    assert thesis.estimator == "windowed-least-squares-thesis"


def test_interval_covers_the_truth_in_about_95_percent_of_noisy_records(arrays):
    time, angle, torque, _ = arrays
    covered, count = 0, 60
    for seed in range(count):
        rng = np.random.default_rng(seed)
        noisy = torque + 0.02 * torque.std() * rng.standard_normal(time.size)
        fit = fit_impedance(time, angle, noisy, block_s=0.5, bootstrap_draws=400, seed=seed)
        low, high = fit.intervals["K"]
        covered += low <= 10.0 <= high
    assert 0.85 * count <= covered <= count


def test_same_seed_gives_the_same_interval_and_another_seed_another(arrays):
    first, again, other = (
        fit_impedance(*arrays[:3], block_s=0.5, seed=seed).intervals["B"] for seed in (1, 1, 2)
    )
    assert first == again
    assert first != other


def test_wider_confidence_gives_a_wider_interval(arrays):
    time, angle, torque, _ = arrays
    noisy = torque + 0.001 * np.random.default_rng(1).standard_normal(time.size)
    widths = [np.diff(fit_impedance(time, angle, noisy, confidence=c).intervals["K"])[0] for c in (0.8, 0.95)]
    assert widths[1] > widths[0]


def test_signals_are_converted_to_si(arrays, pulses):
    time, angle, torque, velocity = arrays
    plain = fit_impedance(time, angle, torque, perturbations=pulses)
    converted = fit_impedance(
        Signal(1e3 * time, "ms"),
        Signal(np.degrees(angle), "deg"),
        Signal(1e3 * torque, "Nmm"),
        perturbations=find_perturbations(
            time, Signal(1e3 * velocity, "mm/s"), rest_before_s=1.9, rest_after_s=1.0
        ),
    )
    assert converted.parameters == pytest.approx(plain.parameters, rel=1e-9)


def test_result_prints_itself_and_makes_table_and_figure(arrays, pulses, tmp_path):
    fit = fit_impedance(*arrays[:3], perturbations=pulses)
    assert "N·m/rad" in str(fit)
    assert "95 % interval" in fit.summary()
    table = fit.to_frame()
    assert list(table.index[:3]) == ["I", "B", "K"]
    assert table.loc["K", "value"] == fit.K
    assert list(table.columns) == ["value", "unit", "standard_error", "low", "high"]
    fit.plot().savefig(tmp_path / "fit.png")
    assert (tmp_path / "fit.png").stat().st_size > 5000


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        ({"angle": lambda x: x[:-1]}, ["angle", "found 2499"]),
        ({"angle": lambda x: np.degrees(x) * 10.0}, ["angle", "degrees"]),
        ({"angle": lambda x: Signal(x, "mm")}, ["angle", "deg, mrad, rad", "'mm'"]),
        ({"torque": lambda x: np.stack([x, x])}, ["torque", "shape (n)", "(2, 2500)"]),
        ({"torque": lambda x: np.where(np.arange(x.size) == 7, np.nan, x)}, ["torque", "sample 7"]),
        ({"torque": lambda x: ["high"] * x.size}, ["torque", "array of numbers"]),
        ({"torque": lambda x: x + 1j}, ["torque", "array of numbers"]),
        ({"angle": lambda x: np.zeros_like(x)}, ["angle", "0 throughout", "perturbed"]),
        ({"time": lambda x: x[::-1]}, ["time", "increase"]),
        ({"time": lambda x: x + 0.001 * (np.arange(x.size) > 99)}, ["time", "regular clock"]),
        ({"confidence": 95}, ["confidence", "0.95"]),
        ({"bootstrap_draws": 3}, ["bootstrap_draws", "100"]),
        ({"cutoff_hz": 125.0}, ["cutoff", "125 Hz"]),
        ({"thesis": True}, ["perturbations", "thesis"]),
        ({"block_s": 9.0}, ["4 blocks", "block_s"]),
        ({"perturbations": []}, ["perturbations", "at least one"]),
        ({"perturbations": [(2.0, 2.1)]}, ["perturbations", "samples, not seconds"]),
        ({"perturbations": [(2400, 9999)]}, ["perturbations", "9999"]),
        ({"perturbations": [3]}, ["perturbations", "find_perturbations"]),
        ({"perturbations": [(5, 100)]}, ["rest", "rest=(before_s, after_s)"]),
        ({"perturbations": [(500, 600)], "rest": (3.0, 1.0)}, ["rest", "a perturbation in it"]),
    ],
)
def test_unusable_arrays_are_refused_in_one_sentence(arrays, change, parts):
    given = dict(zip(("time", "angle", "torque"), arrays[:3], strict=True))
    options = {}
    for key, value in change.items():
        if key in given:
            given[key] = value(given[key])
        else:
            options[key] = value
    refused(lambda: fit_impedance(**given, **options), *parts)


def test_belt_velocity_in_millimetres_is_recognised(arrays):
    refused(lambda: find_perturbations(arrays[0], 1e5 * arrays[3]), "mm/s", "Signal")


# ---- a leg on the belt ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def on_the_belt():
    """A swinging leg's markers (m) and what moved it."""
    moved = swing(Joint(damping=0.1, stiffness=10.0))
    motion = moved.motion
    layout = np.array([[0.0, 0.0], [-0.012, 0.87], [0.012, 0.39]])
    across, along = layout.T
    cosine, sine = np.cos(motion.theta)[:, None], np.sin(motion.theta)[:, None]
    y = moved.belt_position[:, None] + across * cosine + along * sine
    z = 0.055 - across * sine + along * cosine
    markers = SegmentMarkers(("ankle", "top", "low"), layout)
    return moved, np.stack([y, z], axis=2), markers


def test_torque_from_markers_gives_the_joint_and_the_thesis_equation_its_apparent_one(on_the_belt):
    moved, positions, markers = on_the_belt
    time = moved.motion.time
    motion = segment_motion(time, positions, markers, LEG.com_m)
    pulses = find_perturbations(time, moved.belt_velocity, rest_before_s=1.9, rest_after_s=1.0)
    found = {
        thesis: fit_impedance(
            time, motion.theta, joint_torque(motion, LEG, thesis=thesis), perturbations=pulses, cutoff_hz=None
        ).parameters
        for thesis in (False, True)
    }
    assert found[False] == pytest.approx([0.0, 0.1, 10.0], rel=0.01, abs=2e-4)
    lost = 2.0 * LEG.mass_kg * LEG.gravity_m_per_s2 * LEG.com_m
    assert found[True] == pytest.approx([2.0 * LEG.inertia_kgm2, 0.1, 10.0 - lost], rel=0.02)


def test_output_error_needs_no_torque(on_the_belt):
    moved, positions, markers = on_the_belt
    time = moved.motion.time
    millimetres = Signal(1e3 * positions, "mm", ("time", "marker", "axis"))
    motion = segment_motion(time, millimetres, markers, LEG.com_m)
    pulses = find_perturbations(time, moved.belt_velocity, rest_before_s=1.9, rest_after_s=1.0)
    fit = fit_output_error(motion, moved.belt_position, moved.belt_velocity, LEG, perturbations=pulses)
    assert fit.parameters == pytest.approx([0.0, 0.1, 10.0], rel=0.01, abs=2e-4)
    assert fit.quantities["delay"].value == pytest.approx(0.0, abs=1e-4)
    assert fit.vaf > 99.9
    refused(
        lambda: fit_output_error(motion.theta, *([moved.belt_position] * 2), LEG, perturbations=pulses),
        "SegmentMotion",
        "segment_motion",
    )
    refused(lambda: joint_torque(motion, 0.4), "Leg", "'float'")


def test_markers_that_were_filtered_or_enlarged_are_noted(on_the_belt, rng):
    moved, positions, markers = on_the_belt
    time = moved.motion.time
    positions = positions + 2e-5 * rng.standard_normal(positions.shape)
    pulses = find_perturbations(time, moved.belt_velocity, rest_before_s=1.9, rest_after_s=1.0)
    top = list(markers.labels).index("top")

    def notes(positions):
        motion = segment_motion(time, positions, markers, LEG.com_m)
        fit = fit_output_error(motion, moved.belt_position, moved.belt_velocity, LEG, perturbations=pulses)
        joint = fit_joint_likelihood(
            time,
            positions,
            markers,
            LEG,
            labels=markers.labels,
            belt_fixed=["ankle"],
            perturbations=pulses,
            softening=False,
        )
        found = [[n for n in f.notes if "marker" in n and "synchron" not in n] for f in (fit, joint)]
        return [" ".join(sentences) for sentences in found]

    assert notes(positions) == ["", ""]
    assert all("(camera-scale)" in found for found in notes(1.02 * positions))
    filtered = positions.copy()
    filtered[:, top] = butterworth_lowpass(positions[:, top], RATE_HZ, 10.0)
    assert all("The marker 'top' was filtered" in found for found in notes(filtered))
    spiked = positions.copy()
    spiked[round(1.2 * RATE_HZ), top] += 0.05
    assert all("The marker 'top' has 1 single samples" in found for found in notes(spiked))


@pytest.mark.parametrize(("damping", "noted"), [(0.1, True), (0.2, False)])
def test_output_error_notes_pulses_before_the_leg_has_come_to_rest(damping, noted):
    moved = swing(Joint(damping=damping, stiffness=10.0))  # 2 J / B is 2.1 or 1.1 s, pulses are 2 s apart
    time = moved.motion.time
    pulses = find_perturbations(time, moved.belt_velocity, rest_before_s=1.9, rest_after_s=1.0)
    fit = fit_output_error(moved.motion, moved.belt_position, moved.belt_velocity, LEG, perturbations=pulses)
    told = [note for note in fit.notes if "follow each other every 2 s" in note]
    assert bool(told) == noted
    assert not noted or "time constant 2.14 s" in told[0]


def test_markers_that_cannot_be_the_segments_are_refused(on_the_belt):
    moved, positions, markers = on_the_belt
    time = moved.motion.time
    refused(lambda: segment_motion(time, 1e3 * positions, markers, 0.4485), "mm", "Signal")
    refused(lambda: segment_motion(time, positions, markers, 0.4485, labels=["a", "b"]), "labels", "found 2")
    refused(lambda: segment_motion(time, positions, markers, 0.4485, labels=["ankle", "top", "x"]), "'low'")
    refused(lambda: segment_motion(time, positions[:, ::-1], markers, 0.4485), "one rigid body")


def test_simulated_joint_is_found_again():
    time = np.arange(0.0, 20.0, 1.0 / RATE_HZ)
    velocity = np.zeros_like(time)
    for onset in (3.0, 7.0, 11.0):
        inside = (time >= onset) & (time < onset + 0.1)
        velocity[inside] = 0.3 * np.sin(20.0 * np.pi * (time[inside] - onset))
    simulated = simulate_joint(time, velocity, LEG, I=0.003, B=0.2, K=12.0)
    fit = fit_impedance(
        time, simulated.theta, simulated.torque, perturbations=find_perturbations(time, velocity)
    )
    assert fit.parameters == pytest.approx([0.003, 0.2, 12.0], rel=5e-3)
    refused(lambda: simulate_joint(time, velocity, LEG, B=0.2, K=12.0, engine="bullet"), "engine", "'bullet'")


# ---- frequency response, admittance, parallel cascade --------------------------------------------


def filtered_noise(rng, count, cutoff_hz):
    return sosfiltfilt(butter(2, cutoff_hz, fs=RATE_HZ, output="sos"), rng.standard_normal(count))


@pytest.fixture(scope="module")
def driven():
    """Torque (Nm) and angle (rad) of a joint under random torque that runs straight between its samples."""
    from scipy.signal import lsim

    rng = np.random.default_rng(5)
    time = np.arange(0.0, 60.0, 1.0 / RATE_HZ)
    torque = filtered_noise(rng, time.size, 15.0)
    angle = lsim(([1.0], [0.02, 0.3, 12.0]), torque, time)[1]
    return time, torque, angle


def test_admittance_of_a_known_joint_is_measured_and_fitted(driven):
    time, torque, angle = driven
    response = frequency_response(time, torque, angle, band_hz=(0.5, 12.0), averaged_bins=8)
    expected = 1.0 / (
        12.0 + 2j * np.pi * response.frequency_hz * (0.3 + 2j * np.pi * response.frequency_hz * 0.02)
    )
    assert np.median(np.abs(response.response / expected - 1.0)) < 0.03
    assert np.median(response.coherence) > 0.98
    fit = fit_admittance(response)
    assert fit.parameters == pytest.approx([0.02, 0.3, 12.0], rel=0.03)
    assert fit.vaf > 99.0
    assert "rad/(N·m)" in fit.plot().axes[0].get_ylabel()
    assert list(response.to_frame()) == ["frequency_hz", "gain", "phase_deg", "coherence"]


def test_thesis_fit_starts_at_table_3_2_and_keeps_its_bounds(driven):
    time, torque, angle = driven
    response = frequency_response(time, torque, angle, band_hz=(0.5, 12.0), averaged_bins=8)
    thesis = fit_admittance(response, thesis=True)
    assert thesis.estimator == "spectral-fit-modulus"
    assert thesis.details.start.tolist() == [0.001, 0.1, 10.0]
    stiffer = fit_admittance(response, start=(0.02, 0.3, 25.0), lower=(0, 0, 20), upper=(1, 1, 40))
    assert stiffer.K >= 20.0
    refused(
        lambda: fit_admittance(response, start=(0.02, 0.3, 9.0), lower=(0, 0, 10)), "between their bounds"
    )
    refused(lambda: fit_admittance(response, band_hz=(1.0, 1.1)), "at least 4 frequencies")
    refused(lambda: fit_admittance(np.ones(5)), "FrequencyResponse", "frequency_response")


@pytest.mark.slow
def test_parallel_cascade_of_a_joint_without_reflex_finds_none():
    rng = np.random.default_rng(8)
    time = np.arange(0.0, 40.0, 1.0 / RATE_HZ)
    angle = 0.02 * filtered_noise(rng, time.size, 4.0)
    rate = np.gradient(angle, time)
    torque = 0.01 * np.gradient(rate, time) + 0.8 * rate + 60.0 * angle
    torque += 0.02 * torque.std() * rng.standard_normal(time.size)
    fit = fit_parallel_cascade(time, angle, torque, bootstrap_draws=100)
    assert pytest.approx(60.0, rel=0.03) == fit.K
    assert "reflex_gain" not in fit.quantities
    assert any("no reflex" in finding for finding in fit.findings)
    refused(lambda: fit_parallel_cascade(time, angle, -torque, bootstrap_draws=100), "resists", "reverse")
    refused(
        lambda: fit_parallel_cascade(time, angle, torque, reflex_lag_s=0.1),
        "'reflex_lag_s'",
        "did you mean 'reflex_length_s'?",
    )
    refused(lambda: fit_parallel_cascade(time[:900], angle[:900], torque[:900]), "4 blocks", "record longer")


# ---- treadmill, filter, VAF ----------------------------------------------------------------------
