"""Exchanged channels and a wrong trigger of electromyograms, from muscles that answer their own stretch."""

from dataclasses import replace

import numpy as np
import pytest
from emg_builders import EMG_RATE_HZ, emg, ramp_burst
from standing_builders import RESPONSE_TIME, responses_with

from tepsipe.experiments.standing.emg_checks import emg_faults
from tepsipe.experiments.standing.thesis.latency import muscle_latency
from tepsipe.signals.emg import EmgOptions, process_emg
from tepsipe.signals.onsets import OnsetOptions

LENGTHENED_BY = {"TA": {"ankle": -1.0}, "SOL": {"ankle": 1.0}, "GAS": {"ankle": 1.0}}
LATENCY_S = {"TA": 0.044, "SOL": 0.042, "GAS": 0.05}
OPTIONS = OnsetOptions(search_s=(0.02, 0.12), bootstrap_draws=20)


def pulses(rng, sign, late_s=0.0, columns=("TA", "SOL", "GAS"), artefact=0.0, count=9):
    """Responses to pulses of one direction; muscles answer in the columns of their own or other names.

    late_s: by which the answers come later. artefact: of skin and cables (uV), alike after every pulse.
    """
    time = np.arange(-700, 1401) / EMG_RATE_HZ
    sizes = sign * (1.0 + 0.1 * rng.standard_normal(count))
    skin = artefact * sizes[:, None] * np.sin(2.0 * np.pi * 25.0 * np.clip(time, 0.0, 0.12))
    recorded = {}
    for muscle, joints in LENGTHENED_BY.items():
        burst = 40.0 if sign * joints["ankle"] > 0.0 else 0.0
        size = np.exp(0.3 * rng.standard_normal((count, 1)))
        raw = emg(3.0 + burst * size * ramp_burst(time, LATENCY_S[muscle] + late_s), rng) + skin
        recorded[muscle] = process_emg(raw.T, EMG_RATE_HZ, EmgOptions()).band_passed.T[:, 400:1701]
    made = responses_with(0.0 * RESPONSE_TIME, dict.fromkeys(columns, 0.0 * RESPONSE_TIME), sizes=sizes)
    stretch = {"ankle": sign * np.abs(made.stretch["ankle"]), "knee": made.stretch["knee"]}
    return replace(made, emg=np.stack(list(recorded.values()), axis=2), stretch=stretch)


def faults(signs, seed, **spoiled):
    rng = np.random.default_rng(seed)
    trials = [pulses(rng, sign, **spoiled) for sign in signs]
    found = [muscle_latency(trials, muscle, joints, OPTIONS, rng) for muscle, joints in LENGTHENED_BY.items()]
    latencies = [latency for latency in found if not isinstance(latency, str)]
    return emg_faults(trials, LENGTHENED_BY, latencies, "changepoint")


DIRECTIONS = [(1.0, -1.0), (1.0,), (-1.0,)]


@pytest.mark.parametrize("signs", DIRECTIONS)
@pytest.mark.parametrize("artefact", [0.0, 30.0])
def test_sound_channels_have_no_fault(signs, artefact):
    for seed in range(4):
        assert faults(signs, seed, artefact=artefact) == ()


@pytest.mark.parametrize("signs", DIRECTIONS)
@pytest.mark.parametrize("columns", [("SOL", "TA", "GAS"), ("GAS", "SOL", "TA")])
def test_channels_of_antagonists_that_are_exchanged_are_found(signs, columns):
    assert "muscles-exchanged" in faults(signs, 21, columns=columns)


@pytest.mark.parametrize("late_s", [0.035, -0.04, -0.06])
def test_trigger_that_is_early_or_late_is_found(late_s):
    for seed in (31, 32):
        assert faults((1.0, -1.0), seed, late_s=late_s) == ("emg-trigger",)


def test_late_reflexes_of_tall_people_are_no_fault():
    assert faults((1.0, -1.0), 41, late_s=0.012) == ()


def test_without_muscles_there_is_no_fault():
    nobody = [responses_with(0.0 * RESPONSE_TIME)]
    assert emg_faults(nobody, LENGTHENED_BY, [], "changepoint") == ()


def test_pulses_that_stretch_and_shorten_a_muscle_in_turn_do_not_count():
    rng, exchanged = np.random.default_rng(21), ("SOL", "TA", "GAS")
    trials = [pulses(rng, sign, columns=exchanged) for sign in (1.0, -1.0)]
    assert emg_faults(trials, LENGTHENED_BY, [], "changepoint") == ("muscles-exchanged",)
    for k, trial in enumerate(trials):
        swing = 0.2 * np.sin(2.0 * np.pi * np.clip(RESPONSE_TIME, 0.0, 0.1) / 0.05)
        ankle = np.tile(swing, (trial.count, 1))
        trials[k] = replace(trial, stretch=trial.stretch | {"ankle": ankle})
    assert emg_faults(trials, LENGTHENED_BY, [], "changepoint") == ()
