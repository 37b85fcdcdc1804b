"""Responses are aligned to the exact instant of their event; unperturbed windows hold no perturbation."""

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.signals.epochs import between, cut_epochs, ensemble, unperturbed_onsets, without_artefact

RATE_HZ = 1000.0
TIME = np.arange(20000) / RATE_HZ
ONSETS = np.array([2.0003, 5.12345, 9.9999, 14.5])


def wave(time):
    """A signal well within the band, different around every event."""
    return np.sin(2.0 * np.pi * 7.0 * time) + 0.3 * np.cos(2.0 * np.pi * 83.0 * time)


def test_responses_are_those_at_the_exact_instants():
    responses = cut_epochs(wave(TIME), RATE_HZ, ONSETS, 0.1, 0.3)
    assert responses.time[[0, 100, -1]] == pytest.approx([-0.1, 0.0, 0.3])
    assert responses.kept == (0, 1, 2, 3)
    assert responses.dropped == ()
    assert responses.values == pytest.approx(wave(ONSETS[:, None] + responses.time), abs=2e-4)


def test_event_on_a_sample_gives_the_samples_themselves(rng):
    x = rng.standard_normal(2000)
    responses = cut_epochs(x, RATE_HZ, [0.5, 1.25], 0.1, 0.2)
    assert responses.values[0] == pytest.approx(x[400:701], abs=1e-9)
    assert responses.values[1] == pytest.approx(x[1150:1451], abs=1e-9)


@pytest.mark.parametrize("shift_s", [0.0, 0.00037, -12.3456])
def test_clock_that_starts_elsewhere_changes_nothing(shift_s, rng):
    x = rng.standard_normal(2000)
    here = cut_epochs(x, RATE_HZ, [0.5, 1.2503], 0.1, 0.2)
    there = cut_epochs(x, RATE_HZ, np.array([0.5, 1.2503]) + shift_s, 0.1, 0.2, start_s=shift_s)
    assert there.values == pytest.approx(here.values, abs=1e-6)


def test_columns_are_cut_one_by_one(rng):
    x = rng.standard_normal((2000, 3))
    responses = cut_epochs(x, RATE_HZ, [0.5, 1.2503], 0.1, 0.2)
    assert responses.values.shape == (2, 301, 3)
    alone = cut_epochs(x[:, 1], RATE_HZ, [0.5, 1.2503], 0.1, 0.2)
    assert responses.values[:, :, 1] == pytest.approx(alone.values, abs=1e-12)


@pytest.mark.parametrize(("frequency_hz", "least"), [(100.0, 0.9996), (300.0, 0.93)])
def test_fine_components_are_kept_between_the_samples(frequency_hz, least):
    x = np.sin(2.0 * np.pi * frequency_hz * TIME)
    onsets = 5.0 + 0.0005 + np.arange(20) / 7.0
    values = cut_epochs(x, RATE_HZ, onsets, 0.2, 0.2).values
    assert np.sqrt(2.0) * values.std() >= least


def test_window_may_reach_to_the_very_ends():
    responses = cut_epochs(TIME, RATE_HZ, [0.1, TIME[-1] - 0.2], 0.1, 0.2)
    assert responses.values[:, [0, -1]] == pytest.approx(np.array([[0.0, 0.3], [TIME[-1] - 0.3, TIME[-1]]]))


def test_event_whose_window_leaves_the_record_is_refused_or_dropped_and_named():
    onsets = [0.05, 3.0, 19.95, 7.0]
    with pytest.raises(InputError) as caught:
        cut_epochs(wave(TIME), RATE_HZ, onsets, 0.1, 0.2)
    assert_one_sentence(caught.value, "event 1 of 4", "0.050 s")
    responses = cut_epochs(wave(TIME), RATE_HZ, onsets, 0.1, 0.2, outside="drop")
    assert responses.dropped == (0, 2)
    assert responses.kept == (1, 3)
    assert responses.values.shape[0] == 2


@pytest.mark.parametrize("onsets", [[], [0.01], [np.nan, 5.0]])
def test_nothing_to_cut_is_refused(onsets):
    with pytest.raises(InputError) as caught:
        cut_epochs(wave(TIME), RATE_HZ, onsets, 0.1, 0.2, outside="drop")
    assert_one_sentence(caught.value)


def test_missing_samples_are_refused():
    x = wave(TIME)
    x[700] = np.nan
    with pytest.raises(InputError) as caught:
        cut_epochs(x, RATE_HZ, ONSETS, 0.1, 0.2)
    assert_one_sentence(caught.value)


def test_unknown_choice_is_refused():
    with pytest.raises(InputError, match="outside"):
        cut_epochs(wave(TIME), RATE_HZ, ONSETS, 0.1, 0.2, outside="pad")


# ---- ensemble and artefact ---------------------------------------------------------------------


def test_mean_and_spread_of_an_ensemble():
    responses = np.array([[1.0, 5.0], [3.0, 5.0], [5.0, 5.0]])
    found = ensemble(responses)
    assert found.events == 3
    assert found.mean == pytest.approx([3.0, 5.0])
    assert found.sd == pytest.approx([2.0, 0.0])
    assert found.standard_error == pytest.approx([2.0 / np.sqrt(3.0), 0.0])


def test_standard_error_is_the_spread_of_means(rng):
    means = np.array([rng.standard_normal((25, 4)).mean(axis=0) for _ in range(400)])
    assert ensemble(rng.standard_normal((25, 4))).standard_error.mean() == pytest.approx(
        means.std(), rel=0.25
    )


def test_ensemble_of_one_is_refused():
    with pytest.raises(InputError) as caught:
        ensemble(np.ones((1, 10)))
    assert_one_sentence(caught.value)


def test_artefact_in_proportion_to_the_perturbation_is_taken_out(rng):
    sizes = np.array([0.2, -0.3, 0.4, -0.5] * 10)
    artefact = 100.0 * np.exp(-TIME[:300] / 0.02)
    muscle = rng.standard_normal((40, 300, 2))
    both = muscle + sizes[:, None, None] * artefact[:, None]
    assert without_artefact(both, sizes) == pytest.approx(without_artefact(muscle, sizes), abs=1e-10)
    assert without_artefact(both, sizes).std() == pytest.approx(np.sqrt(39.0 / 40.0), rel=0.02)
    assert without_artefact(np.tile(artefact, (3, 1))) == pytest.approx(np.zeros((3, 300)), abs=1e-10)


@pytest.mark.parametrize("sizes", [[1.0, 2.0], [0.0, 0.0, 0.0], [1.0, np.nan, 1.0]])
def test_sizes_that_are_not_those_of_the_responses_are_refused(sizes):
    with pytest.raises(InputError) as caught:
        without_artefact(np.ones((3, 10)), np.array(sizes))
    assert_one_sentence(caught.value)


# ---- unperturbed time --------------------------------------------------------------------------

PERTURBED = np.array([[10.0, 10.4], [4.0, 4.4], [15.5, 16.0]])


@pytest.mark.parametrize("seed", [None, 1, 2, 3])
@pytest.mark.parametrize("count", [1, 5, 12])
def test_windows_lie_in_unperturbed_time_and_apart(seed, count):
    rng = None if seed is None else np.random.default_rng(seed)
    onsets = unperturbed_onsets(20.0, PERTURBED, 1.5, 0.3, 0.5, count, rng)
    assert onsets.shape == (count,)
    assert (np.diff(onsets) >= 0.8 - 1e-9).all()
    starts, ends = onsets - 0.3, onsets + 0.5
    assert starts.min() >= -1e-9
    assert ends.max() <= 20.0 + 1e-9
    for first, last in PERTURBED:
        assert ((ends <= first + 1e-9) | (starts >= last + 1.5 - 1e-9)).all()
    cut_epochs(np.zeros(20001), RATE_HZ, onsets, 0.3, 0.5)


def test_even_windows_are_the_same_every_time_and_drawn_ones_are_those_of_the_seed():
    arguments = (20.0, PERTURBED, 1.5, 0.3, 0.5, 6)
    assert unperturbed_onsets(*arguments).tolist() == unperturbed_onsets(*arguments).tolist()
    drawn = [unperturbed_onsets(*arguments, np.random.default_rng(s)).tolist() for s in (1, 1, 2)]
    assert drawn[0] == drawn[1] != drawn[2]


def test_even_windows_are_spread_over_the_whole_record():
    onsets = unperturbed_onsets(60.0, np.empty((0, 2)), 1.0, 0.5, 0.5, 10)
    assert onsets == pytest.approx(6.0 * np.arange(10) + 3.0, abs=0.51)


def test_record_that_is_exactly_one_window_holds_one():
    assert unperturbed_onsets(0.8, np.empty((0, 2)), 1.0, 0.3, 0.5, 1) == pytest.approx([0.3])


@pytest.mark.parametrize("count", [18, 1000])
def test_more_windows_than_fit_are_refused(count):
    with pytest.raises(InputError) as caught:
        unperturbed_onsets(20.0, PERTURBED, 1.5, 0.3, 0.5, count)
    assert_one_sentence(caught.value, f"expected {count} windows")


@pytest.mark.parametrize(("before_s", "count"), [(-0.5, 3), (0.3, 0)])
def test_windows_without_length_or_number_are_refused(before_s, count):
    with pytest.raises(InputError) as caught:
        unperturbed_onsets(20.0, PERTURBED, 1.5, before_s, 0.5, count)
    assert_one_sentence(caught.value)


def test_windows_without_perturbation_share_the_time_that_is_left():
    # two windows of 1 s in 2.5 s: a quarter of the remaining 0.5 s before the first, three quarters before
    # the second
    found = unperturbed_onsets(2.5, np.empty((0, 2)), 0.1, 0.4, 0.6, 2)
    assert found == pytest.approx([0.125 + 0.4, 0.375 + 1.4])


def test_two_responses_are_enough_for_the_artefact():
    muscle, artefact = np.array([1.0, -1.0]), np.array([3.0, 0.0, 5.0])
    responses = muscle[:, None] + artefact
    assert without_artefact(responses) == pytest.approx(np.tile(muscle[:, None], 3))


def test_times_in_single_precision_keep_the_samples_at_both_ends():
    time = np.arange(-75, 251) * 0.004
    for clock in (time, time.astype(np.float32)):
        for start, stop in ((-0.1, -0.02), (-0.028, 0.152)):
            assert between(clock, start, stop).sum() == round((stop - start) / 0.004) + 1
