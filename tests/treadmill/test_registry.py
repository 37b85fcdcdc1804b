"""Linear models of what a treadmill adds: known truths come back, properties hold, misuse is refused."""

import re
from dataclasses import fields, replace

import numpy as np
import pytest
from belt_builders import (
    OPTIONS,
    RATE_HZ,
    belt_recording,
    pulsed_evaluated,
    restless_belt,
    swaying_belt,
)
from builders import assert_one_sentence
from scipy import signal

from tepsipe.errors import InputError
from tepsipe.signals.filters import Lowpass
from tepsipe.treadmill.black_box_models import (
    _steiglitz_mcbride,
    fit_discrete_output_error,
    fit_finite_response,
)
from tepsipe.treadmill.bristle_fit import Calibrated, residuals
from tepsipe.treadmill.bristle_frame import AT, BristleFrame
from tepsipe.treadmill.calibration import coherence_limit
from tepsipe.treadmill.linear_frame import MEAN, LinearFrame
from tepsipe.treadmill.recording import check_recordings, score
from tepsipe.treadmill.registry import (
    FAMILY,
    JOINT,
    evaluate,
    fit_model,
    load_treadmill_models,
    pick,
    save_models,
)

LINEAR = ("hnat2014", "output-error", "fir-causal", "fir", "spectral")
CONTINUOUS = ("mass-spring-damper", *LINEAR, "ripple-tracking")
NUMERATOR, DENOMINATOR = np.array([1.5, -2.0, 0.9]), np.array([1.0, -1.1, 0.5])
# a response that begins two samples before the acceleration and has died away within 0.1 s
LEAD, RESPONSE = 2, np.array([0.3, -0.4, 2.0, 1.0, 0.5, -0.3, 0.2, 0.1])


def of_order_2(v, a):
    return signal.lfilter(NUMERATOR, DENOMINATOR, a)


def of_response(v, a):
    """The load k samples after an acceleration is RESPONSE[k + LEAD] times as large."""
    load = np.zeros(a.size)
    for k, h in enumerate(RESPONSE, start=-LEAD):
        load += h * np.roll(a, k)
    return load


def noisy(truth, size, rng):
    return lambda v, a: truth(v, a) + size * rng.standard_normal(a.size)


# ---- known truths come back --------------------------------------------------------------------


def test_published_procedure_recovers_a_transfer_function_of_order_2(rng):
    train, test = (restless_belt(of_order_2, rng) for _ in range(2))
    fitted = fit_model("hnat2014", [train], OPTIONS)
    assert fitted.model.numerator == pytest.approx(NUMERATOR, rel=1e-4)
    assert fitted.model.denominator == pytest.approx(DENOMINATOR, rel=1e-4)
    assert evaluate(fitted, [test]).r2 == pytest.approx(1.0, abs=1e-8)


@pytest.mark.parametrize("poles", [[0.6], [0.5 + 0.4j, 0.5 - 0.4j], [0.8, 0.3 + 0.6j, 0.3 - 0.6j]])
def test_output_error_model_recovers_a_transfer_function_of_its_order(poles, rng):
    numerator = np.array([2.0, -1.0, 0.5, 0.3])[: len(poles) + 1]
    denominator = np.real(np.poly(poles))
    noise = 0.5  # in the load: what an equation error would take for poles
    truth = noisy(lambda v, a: signal.lfilter(numerator, denominator, a), noise, rng)
    model = fit_discrete_output_error([restless_belt(truth, rng, 300.0)], len(poles))
    assert model.order == len(poles)
    assert model.denominator == pytest.approx(denominator, abs=0.03)
    assert model.numerator == pytest.approx(numerator, abs=0.03)


def test_published_procedure_and_output_error_of_order_2_find_the_same_minimum(rng):
    train = restless_belt(noisy(of_order_2, 1.0, rng), rng)
    published, other = (fit_model(name, [train], OPTIONS) for name in ("hnat2014", "output-error"))
    assert other.model.denominator == pytest.approx(published.model.denominator, abs=1e-3)
    assert evaluate(other, [train]).r2 == pytest.approx(evaluate(published, [train]).r2, abs=1e-7)


def test_finite_response_recovers_an_impulse_response_with_its_lead(rng):
    train, test = (restless_belt(of_response, rng) for _ in range(2))
    fitted = fit_model("fir", [train], OPTIONS)
    expected = np.zeros(26)  # 5 samples of lead, the present one, 20 of lag
    expected[5 - LEAD : 5 - LEAD + RESPONSE.size] = RESPONSE
    assert fitted.model.lead == 5
    # samples at the two ends know nothing of what lies beyond them
    assert fitted.model.taps == pytest.approx(expected, abs=3e-3)
    assert evaluate(fitted, [test]).r2 > 0.9999


def test_causal_response_misses_exactly_what_comes_before_the_acceleration(rng):
    train, test = (restless_belt(of_response, rng, 300.0) for _ in range(2))
    fitted = fit_model("fir-causal", [train], OPTIONS)
    assert fitted.model.taps[:6] == pytest.approx(RESPONSE[LEAD:], abs=0.02)
    # white acceleration: every tap carries its square of the load's power
    missed = np.sum(RESPONSE[:LEAD] ** 2) / np.sum(RESPONSE**2)
    assert evaluate(fitted, [test]).r2 == pytest.approx(1.0 - missed, abs=0.01)


def test_finite_response_is_the_least_squares_solution_over_all_judged_samples(rng):
    recordings = []
    for size in (0.5, 5.0):
        r = restless_belt(noisy(of_order_2, size, rng), rng, 25.0)
        recordings.append(replace(r, evaluated=rng.uniform(size=r.load.size) > 0.3))
    model = fit_finite_response(recordings, 0.02, 0.05)
    rows, right = [], []
    for r in recordings:
        a = np.pad(r.acceleration, 10)
        shifted = [a[10 - k : 10 - k + r.load.size] for k in range(-2, 6)]
        rows.append(np.column_stack(shifted)[r.evaluated])
        right.append(r.load[r.evaluated])
    expected = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=None)[0]
    assert model.taps == pytest.approx(expected, abs=1e-6)


def test_spectral_estimate_recovers_a_short_response(rng):
    train, test = (restless_belt(of_response, rng, 300.0) for _ in range(2))
    model = fit_model("spectral", [train], OPTIONS)
    middle = slice(model.model.lead - LEAD, model.model.lead - LEAD + RESPONSE.size)
    assert model.model.taps[middle] == pytest.approx(RESPONSE, abs=0.03)
    assert evaluate(model, [test]).r2 > 0.995


def test_mass_damper_and_spring_come_back(rng):
    def load(x, v, a):
        along = np.arange(x.size) / RATE_HZ
        swayed = x - np.polyval(np.polyfit(along, x, 1), along)
        return 3.0 * a + 7.0 * (v - v.mean()) + 40.0 * swayed - 2.0

    train, test = (swaying_belt(load, rng) for _ in range(2))
    fitted = fit_model("mass-spring-damper", [train], OPTIONS)
    assert fitted.model.coefficients == pytest.approx([3.0, 7.0, 40.0, -2.0], rel=2e-3)
    assert evaluate(fitted, [test]).r2 == pytest.approx(1.0, abs=1e-5)


def test_mean_of_the_perturbations_is_subtracted_where_they_are():
    samples, length = 3000, 20
    shape = np.sin(np.pi * np.arange(length) / length)
    sizes, onsets = np.array([1.0, 2.0, 6.0]), (500, 1200, 2000)
    load = np.zeros(samples)
    for size, onset in zip(sizes, onsets, strict=True):
        load[onset : onset + length] = size * shape
    r = belt_recording(
        np.sin(np.arange(samples)),
        np.cos(np.arange(samples)),
        load,
        onsets=onsets,
        evaluated=pulsed_evaluated(samples, onsets, length),
        condition="sine-0.3",
    )
    fitted = fit_model("mean-subtraction", [r], replace(OPTIONS, shortest_s=0.5))
    elsewhere = replace(r, onsets=(300, 2990), name="trial 2")
    predicted = fitted.predict(elsewhere)
    assert predicted[300:320] == pytest.approx(3.0 * shape)  # the mean of 1, 2 and 6
    assert predicted[2990:] == pytest.approx(3.0 * shape[:10])
    assert np.count_nonzero(predicted) == np.count_nonzero(shape) + np.count_nonzero(shape[:10])
    left = fitted.compensate(r)
    assert left[500:520] == pytest.approx(-2.0 * shape, abs=1e-12)
    with pytest.raises(InputError) as caught:
        fitted.predict(replace(r, condition="sine-0.4"))
    assert_one_sentence(caught.value, "trial 1", "'sine-0.4'", "'sine-0.3'")


def test_samples_that_are_not_judged_do_not_matter(rng):
    clean = restless_belt(noisy(of_order_2, 0.5, rng), rng)
    clean = replace(clean, evaluated=np.arange(clean.load.size) >= 500)
    dirty = replace(clean, load=np.where(clean.evaluated, clean.load, 1e3))
    for name in ("mass-spring-damper", *LINEAR):
        expected, found = (fit_model(name, [r], OPTIONS).predict(clean) for r in (clean, dirty))
        assert found == pytest.approx(expected, abs=2e-3), name


# ---- the limit of linear models ----------------------------------------------------------------


@pytest.mark.parametrize("noise_to_signal", [0.0, 0.25, 1.0, 4.0])
def test_limit_is_the_part_of_the_power_that_the_belt_causes(noise_to_signal, rng):
    size = 2.0 * np.sqrt(noise_to_signal * np.sum(RESPONSE**2))
    r = restless_belt(noisy(of_response, size, rng), rng, 600.0)
    expected = 1.0 / (1.0 + noise_to_signal)
    assert coherence_limit([r], 2.56) == pytest.approx(expected, abs=0.02)


def test_limit_of_unrelated_signals_is_nothing(rng):
    r = restless_belt(lambda v, a: rng.standard_normal(a.size), rng, 600.0)
    assert 0.0 <= coherence_limit([r], 2.56) < 0.005


def test_limit_does_not_depend_on_units_nor_on_a_common_delay(rng):
    r = restless_belt(noisy(of_order_2, 2.0, rng), rng)
    limit = coherence_limit([r], 2.56)
    scaled = replace(r, load=1e3 * r.load, acceleration=1e-3 * r.acceleration)
    assert coherence_limit([scaled], 2.56) == pytest.approx(limit, rel=1e-9)
    late = replace(r, load=np.roll(r.load, 7), acceleration=np.roll(r.acceleration, 7))
    assert coherence_limit([late], 2.56) == pytest.approx(limit, abs=0.01)


def test_limit_of_perturbations_that_respond_alike_is_one_and_of_one_perturbation_unknown(rng):
    onsets, length = (100, 300, 500, 700), 80
    shape = np.hanning(40)
    acceleration, load = np.zeros((2, 1000))
    for size, onset in zip((1.0, -2.0, 0.5, 3.0), onsets, strict=True):
        acceleration[onset : onset + 40] = size * shape
        load[onset + 5 : onset + 45] = 7.0 * size * shape
    r = belt_recording(acceleration, acceleration, load, onsets=onsets)
    r = replace(r, evaluated=pulsed_evaluated(1000, onsets, length))
    assert coherence_limit([r], 1.0) == pytest.approx(1.0)
    turned = replace(r, load=np.where(np.arange(1000) < 250, -load, load))
    coherence = ((-1.0 + 4.0 + 0.25 + 9.0) / (1.0 + 4.0 + 0.25 + 9.0)) ** 2
    assert coherence_limit([turned], 1.0) == pytest.approx((4.0 * coherence - 1.0) / 3.0)
    single = replace(r, onsets=(100,), evaluated=pulsed_evaluated(1000, (100,), length))
    assert np.isnan(coherence_limit([single], 1.0))


@pytest.mark.parametrize("size", [1.0, 5.0])
def test_no_linear_model_exceeds_the_limit_and_the_right_one_reaches_it(size, rng):
    train, test = (restless_belt(noisy(of_order_2, size, rng), rng, 200.0) for _ in range(2))
    limit = coherence_limit([test], OPTIONS.spectral_segment_s)
    found = {name: evaluate(fit_model(name, [train], OPTIONS), [test]).r2 for name in LINEAR}
    # 100 s hold about 150 independent segments: the limit itself is uncertain by about 0.01
    assert max(found.values()) < limit + 0.01
    assert found["hnat2014"] == pytest.approx(limit, abs=0.02)
    assert found["output-error"] == pytest.approx(limit, abs=0.02)


# ---- properties --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [n for n in CONTINUOUS if n != "hnat2014"])  # whose bounds are absolute
def test_load_in_another_unit_is_predicted_alike(name, rng):
    train, test = (restless_belt(noisy(of_order_2, 1.0, rng), rng, 40.0) for _ in range(2))
    fitted = fit_model(name, [train], OPTIONS)
    scaled = fit_model(name, [replace(train, load=1e3 * train.load)], OPTIONS)
    larger = replace(test, load=1e3 * test.load)
    expected = 1e3 * fitted.predict(test)
    assert scaled.predict(larger) == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())
    assert evaluate(scaled, [larger]).r2 == pytest.approx(evaluate(fitted, [test]).r2, abs=1e-5)


@pytest.mark.parametrize("name", LINEAR)
def test_later_motion_gives_the_same_load_later(name, rng):
    fitted = fit_model(name, [restless_belt(noisy(of_order_2, 1.0, rng), rng, 30.0)], OPTIONS)
    r = restless_belt(of_order_2, rng, 30.0)
    rest, padding = 217, 400

    def padded(before):
        parts = (np.zeros(before), r.acceleration, np.zeros(padding + rest - before))
        a = np.concatenate(parts)
        return fitted.predict(belt_recording(a, a, a))

    early, late = padded(padding), padded(padding + rest)
    assert np.abs(early).max() > 1.0
    assert late[rest:] == pytest.approx(early[:-rest], abs=1e-9)


@pytest.mark.parametrize(
    ("name", "lead_s"), [("hnat2014", 0.0), ("output-error", 0.0), ("fir-causal", 0.0), ("fir", 0.05)]
)
def test_models_look_exactly_as_far_ahead_as_they_say(name, lead_s, rng):
    fitted = fit_model(name, [restless_belt(noisy(of_response, 1.0, rng), rng, 30.0)], OPTIONS)
    a = rng.standard_normal(1000)
    kicked = a.copy()
    kicked[600] += 100.0
    difference = np.subtract(*(fitted.predict(belt_recording(x, x, x)) for x in (kicked, a)))
    first = np.flatnonzero(np.abs(difference) > 1e-9)[0]
    assert first == 600 - round(lead_s * RATE_HZ)


def test_finite_response_ends_where_it_says(rng):
    fitted = fit_model("fir", [restless_belt(noisy(of_response, 1.0, rng), rng, 30.0)], OPTIONS)
    kick = np.zeros(1000)
    kick[600] = 1.0
    told = np.flatnonzero(np.abs(fitted.predict(belt_recording(kick, kick, kick))) > 1e-9)
    assert (told[0], told[-1]) == (595, 620)


# ---- judging -----------------------------------------------------------------------------------


def test_score_by_hand():
    first = belt_recording(
        *np.zeros((2, 3)), np.array([99.0, 1.0, 2.0]), evaluated=np.array([False, True, True])
    )
    second = belt_recording(*np.zeros((2, 2)), np.array([3.0, 6.0]))
    found = score([first, second], [np.array([0.0, 1.0, 1.0]), np.array([3.0, 4.0])])
    # loads 1, 2, 3, 6 with the mean 3 leave 0, 1, 0, 2
    assert found.r2 == pytest.approx(1.0 - 5.0 / 14.0)
    assert found.rms_before == pytest.approx(np.sqrt(50.0 / 4.0))
    assert found.rms_after == pytest.approx(np.sqrt(5.0 / 4.0))


def test_score_of_the_mean_is_zero_and_of_less_than_that_negative(rng):
    r = belt_recording(*np.zeros((2, 50)), 3.0 + rng.standard_normal(50))
    assert score([r], [np.full(50, r.load.mean())]).r2 == pytest.approx(0.0, abs=1e-12)
    assert score([r], [np.zeros(50)]).r2 < -1.0


# ---- keeping models ----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def every_model():
    """One fitted model of every name, and a recording that all of them can predict."""
    rng = np.random.default_rng(7)
    lowpass = Lowpass(20.0, 2, True)
    onsets = tuple(range(200, 5600, 300))
    recordings = []
    for kg in (0.0, 20.0):
        r = restless_belt(lambda v, a: 3.0 * a + 0.1 * rng.standard_normal(a.size), rng)
        ripple = 2.0 * np.cos(2.0 * np.pi * 1.7 * r.position)
        carried = kg * 0.1 * r.acceleration
        r = replace(r, beside=0.0 * carried, beside_carried=0.0 * carried)
        r = replace(
            r, load=r.load + ripple, carried=carried, carried_kg=kg, rigid_kg=kg, name=f"with {kg:g} kg"
        )
        recordings.append(r.filtered(lowpass))
    pulsed = [
        replace(r, onsets=onsets, evaluated=pulsed_evaluated(r.load.size, onsets, 250), condition=r.name)
        for r in recordings
    ]
    constants = np.full(len(AT), 1e-3)
    constants[AT["moment_mass"]] = 3.0
    joint = Calibrated(
        {"Mx": BristleFrame("Mx", constants, ("bristles",), 100.0, 20.0)},
        residuals,
        rng.standard_normal((3, constants.size)),
        np.zeros((2, constants.size)),
        {"bristles": 1.0},
        1.0,
    )
    linear = replace(joint, models={"Mx": LinearFrame("Mx", MEAN + 1e-7, ("bristles",), 100.0, 20.0)})
    joints = {"bristle-frame": joint, "linear-frame": replace(linear, deviations=np.ones((3, MEAN.size)))}
    options = replace(OPTIONS, joint=joints)
    models = [
        fit_model(name, pulsed if name == "mean-subtraction" else recordings, options) for name in FAMILY
    ]
    return models, pulsed[1]


def same(one, other):
    """Whether two models hold the same constants, bit by bit."""
    if isinstance(one, np.ndarray):
        return isinstance(other, np.ndarray) and one.dtype == other.dtype and np.array_equal(one, other)
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if hasattr(one, "__dataclass_fields__"):
        return type(one) is type(other) and all(
            same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one)
        )
    return one == other


def test_models_are_kept_exactly_and_applied_in_one_call(every_model, tmp_path):
    models, recording = every_model
    assert [m.name for m in models] == list(FAMILY)
    assert models[-1].model.order > 0, "the ripple should have been found"
    save_models(tmp_path / "models.json", models)
    kept = load_treadmill_models(tmp_path / "models.json")
    assert list(kept) == list(FAMILY)
    for model in models:
        assert same(pick(kept, model.name), model), model.name
        compensated = load_treadmill_models(tmp_path / "models.json")[model.name].compensate(recording)
        assert np.array_equal(compensated, model.compensate(recording)), model.name
        assert np.abs(compensated - recording.load).max() > 0.1, model.name


def test_compensation_takes_the_prediction_out_of_the_load(every_model):
    models, recording = every_model
    for model in models:
        if model.name not in ("loaded-frame", *JOINT):
            expected = recording.load - model.predict(recording)
            assert np.array_equal(model.compensate(recording), expected), model.name


DAMAGES = {
    "cut off": lambda text: text[: len(text) // 2],
    "nothing": lambda text: "",
    "a list": lambda text: "[1, 2]",
    "other content": lambda text: '{"columns": []}',
    "wrong kind": lambda text: text.replace('"ImpulseResponse"', '"Polynomial"'),
    "constant left out": lambda text: text.replace('"lead"', '"lag"'),
    "no rate": lambda text: re.sub(r"\"rate_hz\": [\d.]+", '"rate_hz": 0.0', text),
    "text for a number": lambda text: text.replace('"values": [', '"values": ["far", ', 1),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_file_of_models_is_refused(damage, every_model, tmp_path):
    path = tmp_path / "models.json"
    save_models(path, [m for m in every_model[0] if m.name == "fir"])
    path.write_text(DAMAGES[damage](path.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_treadmill_models(path)
    assert_one_sentence(caught.value, path, "fit the models again")


def test_missing_file_of_models_and_missing_model_are_refused(every_model, tmp_path):
    with pytest.raises(InputError) as caught:
        load_treadmill_models(tmp_path / "none.json")
    assert_one_sentence(caught.value, tmp_path / "none.json")
    with pytest.raises(InputError) as caught:
        pick({"fir": every_model[0][0]}, "firr")
    assert_one_sentence(caught.value, "'firr'", "'fir'")


# ---- what is refused ---------------------------------------------------------------------------


@pytest.fixture
def sound(rng):
    return restless_belt(of_order_2, rng, 30.0)


def refused(recordings, *names, shortest_s=20.0):
    with pytest.raises(InputError) as caught:
        check_recordings(recordings, shortest_s)
    assert_one_sentence(caught.value, *names)


def test_nothing_to_calibrate_with_is_refused():
    refused([], "none", "calibrate")


def test_recordings_that_do_not_belong_together_are_refused(sound):
    other = replace(sound, name="trial 2")
    check_recordings([sound, other], 20.0)
    refused([sound, replace(other, rate_hz=101.0)], "trial 2", "101 Hz", "100 Hz", "trial 1")
    refused([sound, replace(other, unit="N")], "trial 2", "found N:", "in Nm")


def test_belt_or_load_that_never_changes_is_refused(sound):
    steady = np.full(sound.load.size, 1.2)
    refused([replace(sound, velocity=steady)], "trial 1", "1.2 m/s", "accelerated")
    refused([replace(sound, load=-3.0 * steady)], "trial 1", "-3.6 Nm", "load that changes")
    # motion outside of what is evaluated does not count
    late = np.arange(sound.load.size) > 500
    refused([replace(sound, velocity=np.where(late, 1.2, 0.0), evaluated=late)], "1.2 m/s")


def test_recording_that_is_too_short_is_refused(sound):
    refused([sound], "trial 1", "31 s", "30 s", shortest_s=31.0)
    short = replace(sound, evaluated=np.arange(sound.load.size) < 150)
    with pytest.raises(InputError) as caught:
        fit_model("fir", [short], replace(OPTIONS, shortest_s=1.0))
    assert_one_sentence(caught.value, "trial 1", "260 samples", "26 taps", "150")


def test_unknown_model_and_perturbations_that_are_not_separate_are_refused(sound):
    with pytest.raises(InputError) as caught:
        fit_model("wavelet", [sound], OPTIONS)
    assert_one_sentence(caught.value, "'wavelet'", *FAMILY)
    with pytest.raises(InputError) as caught:
        fit_model("mean-subtraction", [sound], OPTIONS)
    assert_one_sentence(caught.value, "trial 1", "continuously")


def test_model_is_applied_only_to_what_it_was_calibrated_for(sound):
    lowpass = Lowpass(6.0, 2, False)
    fitted = fit_model("fir", [sound.filtered(lowpass)], OPTIONS)
    test = replace(sound.filtered(lowpass), name="trial 2")
    for found, names in (
        (replace(test, rate_hz=128.0), ("100 Hz", "128 Hz")),
        (replace(test, unit="N"), ("load in Nm", "found N:")),
        (replace(test, lowpass=None), ("filtered", "found None")),
        (replace(test, lowpass=Lowpass(6.0, 2, True)), ("zero_lag=False", "zero_lag=True")),
        (replace(test, lowpass=Lowpass(7.0, 2, False)), ("6.0", "7.0")),
    ):
        for apply in (fitted.predict, fitted.compensate):
            with pytest.raises(InputError) as caught:
                apply(found)
            assert_one_sentence(caught.value, "trial 2", "'fir'", *names)


@pytest.mark.parametrize("name", ("mass-spring-damper", *LINEAR))
def test_sign_that_is_turned_and_wrong_unit_are_refused(name, rng):
    def load(v, a):
        return 3.0 * a + 2.0 * rng.standard_normal(a.size)

    train, test = (restless_belt(load, rng, 30.0, name=name) for name in ("trial 1", "trial 2"))
    fitted = fit_model(name, [train], OPTIONS)
    assert evaluate(fitted, [test]).r2 == pytest.approx(0.9, abs=0.02)
    for factor, hint in ((-1.0, "opposite sign"), (1e3, "not in Nm"), (1e-3, "not in Nm")):
        with pytest.raises(InputError) as caught:
            evaluate(fitted, [replace(test, load=factor * test.load)])
        assert_one_sentence(caught.value, "trial 2", "trial 1", hint)


def test_small_load_of_another_mass_is_judged_not_refused(rng):
    """An empty belt under its axis of symmetry has a thirtieth of a weight's moment."""

    def recorded(size, kg):
        r = restless_belt(lambda v, a: size * a + 0.002 * rng.standard_normal(a.size), rng, 30.0)
        return replace(r, carried_kg=kg)

    heavy = fit_model("fir", [recorded(3.0, 20.0)], OPTIONS)
    light = recorded(0.1, 0.0)
    assert evaluate(heavy, [light]).r2 < -100.0
    assert evaluate(heavy, [recorded(3.0, 20.0)]).r2 > 0.99
    assert evaluate(fit_model("fir", [recorded(0.1, 0.0)], OPTIONS), [light]).r2 > 0.99


def test_another_but_plausible_treadmill_is_judged_not_refused(rng):
    train, test = (restless_belt(lambda v, a: 3.0 * a, rng, 30.0) for _ in range(2))
    fitted = fit_model("fir", [train], OPTIONS)
    assert evaluate(fitted, [replace(test, load=2.0 * test.load)]).r2 == pytest.approx(0.75, abs=1e-3)


def test_cutoff_above_half_the_rate_is_refused(sound):
    for both_ways in (True, False):
        with pytest.raises(InputError, match=r"50 Hz.*found 60 Hz: change the cutoff"):
            sound.filtered(Lowpass(60.0, 2, both_ways))


# ---- the filter --------------------------------------------------------------------------------


def test_causal_filter_halves_the_power_at_its_cutoff_and_ignores_the_future(rng):
    time = np.arange(1000) / RATE_HZ
    lowpass = Lowpass(6.0, 2, False)
    tone = lowpass(np.sin(2.0 * np.pi * 6.0 * time), RATE_HZ)
    assert np.sqrt(2.0 * np.mean(tone[-100:] ** 2)) == pytest.approx(np.sqrt(0.5), rel=1e-3)
    x = rng.standard_normal((1000, 2))
    changed = x.copy()
    changed[500:] += 5.0
    assert np.array_equal(lowpass(changed, RATE_HZ)[:500], lowpass(x, RATE_HZ)[:500])


def test_filter_passes_over_all_signals_alike_and_leaves_the_raw_velocity(rng):
    r = restless_belt(of_order_2, rng, 30.0, carried=rng.standard_normal(3000))
    lowpass = Lowpass(6.0, 2, False)
    filtered = r.filtered(lowpass)
    for key in ("acceleration", "load", "carried"):
        expected = signal.lfilter(*signal.butter(2, 6.0, fs=RATE_HZ), getattr(r, key))
        assert getattr(filtered, key) == pytest.approx(expected, abs=1e-9), key
    assert np.array_equal(filtered.raw_velocity, r.velocity)
    # the belt ran before the recording began: no jump from zero to 1.2 m/s
    assert filtered.velocity[:10] == pytest.approx(r.velocity[:10], abs=0.1)
    assert filtered.lowpass == lowpass


def test_starting_values_of_the_output_error_model_are_exact_without_noise(rng):
    found = _steiglitz_mcbride([restless_belt(of_order_2, rng)], 2)
    assert found == pytest.approx(np.concatenate([NUMERATOR, DENOMINATOR[1:]]), abs=1e-6)
