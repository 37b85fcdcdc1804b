"""Resonance of the frame under a person and on the empty belt, in recordings of the virtual laboratory."""

from dataclasses import replace

import numpy as np
import pytest

from tepsipe.treadmill.frame_peak import FramePeak, frame_peak, moves_with_frame, resonance_sentence
from tepsipe.treadmill.prepared import prepare_trial
from tests.virtual_lab.test_force_recovery import LOWPASS, WINDOW, Laboratory

PERSON_KG = 64.0


class Noisy(Laboratory):
    """Trials of the shipped treadmill, with the noise of force and log, on another frame."""

    def __init__(self, truth, hz):
        super().__init__(truth, hz)
        shipped = truth["treadmill"]["plate"]
        self.plate = replace(self.plate, noise_V=shipped["noise_V"], floor_m_per_s2=shipped["floor_m_per_s2"])

    def peak(self, name, move):
        """Resonance in trials of both directions."""
        trials = []
        for profile in ("sine", "negative-sine"):
            trial, _ = self.trial(name, move, 0.4, profile)
            velocity = trial.signals["belt_velocity"]
            noise = np.random.default_rng(2).normal(0.0, 0.0005, velocity.values.size)
            trial.signals["belt_velocity"] = replace(velocity, values=velocity.values + noise)
            trials.append(prepare_trial(trial, name, LOWPASS, WINDOW))
        return frame_peak(trials, "right")


class MassOnFrame(Noisy):
    """The laboratory as it was: the person stands on rigid ground, and the frame carries her mass."""

    def person(self, command, below):
        return super().person(command, [])

    def peak(self, name, move):
        kg = self.plate.resonance_mass_kg
        under = self.plate.resonance_hz * np.sqrt(kg / (kg + PERSON_KG))
        self.plate = replace(self.plate, resonance_hz=under, resonance_mass_kg=kg + PERSON_KG)
        return super().peak(name, move)


@pytest.mark.slow
def test_person_whose_mass_moves_with_the_frame_is_found_out(shipped_truth):
    empty = Noisy(shipped_truth, 35.0).peak("empty", Noisy(shipped_truth, 35.0).weight(0.0))
    now, before = Noisy(shipped_truth, 35.0), MassOnFrame(shipped_truth, 35.0)
    seen, old = now.peak("person", now.person), before.peak("person", before.person)
    assert empty.hz == pytest.approx(35.0, abs=1.5)
    assert seen.hz == pytest.approx(empty.hz, abs=2.0)
    assert old.hz == pytest.approx(35.0 * np.sqrt(150.0 / 214.0), abs=1.5)
    assert moves_with_frame([seen], empty) is False
    assert moves_with_frame([old], empty) is True


@pytest.mark.slow
def test_a_frame_above_the_band_of_the_pulses_cannot_be_compared(shipped_truth):
    stiff = Noisy(shipped_truth, 110.0)
    empty, person = stiff.peak("empty", stiff.weight(0.0)), stiff.peak("person", stiff.person)
    assert empty.hz is None
    assert empty.up_to_hz < 100.0
    assert moves_with_frame([person], empty) is None
    assert "cannot be compared" in resonance_sentence([person], empty)


@pytest.mark.parametrize(
    ("under", "empty", "moves", "words"),
    [
        ([(28.0, 60.0), (30.0, 60.0)], (35.0, 60.0), True, "29 Hz with the person, 35 Hz with the empty"),
        ([(33.0, 60.0), (None, 30.0)], (35.0, 60.0), False, "33 Hz with the person"),
        ([(None, 30.0)], (35.0, 60.0), None, "none below 30 Hz"),
        ([(33.0, 60.0)], (None, 42.0), None, "none below 42 Hz"),
        ([], (35.0, 60.0), None, "not compared"),
        ([(33.0, 60.0)], None, None, "not compared"),
    ],
)
def test_verdicts(under, empty, moves, words):
    known = None if empty is None else FramePeak(*empty)
    peaks = [FramePeak(*peak) for peak in under]
    assert moves_with_frame(peaks, known) is moves
    assert words in resonance_sentence(peaks, known)
