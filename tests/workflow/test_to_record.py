"""What is still to be recorded, by the pulses of the trials, in the words of the guideline."""

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tepsipe.io.trial import Trial
from tepsipe.treadmill.recording import BeltRecording
from workflow.support.to_record import PAGE, Read, faults_of, lacking_on_plate, to_record

RATE_HZ = 250.0


def recording(kg, *signs):
    """A load (kg) under pulses that go away in a direction and come back within 0.1 s."""
    time, onsets = np.arange(0.0, 2.0 * len(signs) + 1.0, 1.0 / RATE_HZ), []
    velocity = np.zeros(time.size)
    for k, sign in enumerate(signs):
        since = time - 1.0 - 2.0 * k
        onsets.append(int(np.argmax(since >= 0.012)))  # detected late
        pulse = (since >= 0.0) & (since <= 0.1)
        velocity[pulse] += sign * 0.3 * np.sin(2.0 * np.pi * since[pulse] / 0.1)
    zeros = np.zeros(time.size)
    signals = (velocity, np.gradient(velocity, time), velocity, zeros, zeros)
    return BeltRecording("a", "a", RATE_HZ, *signals, kg, "N", zeros > -1.0, tuple(onsets))


@pytest.mark.parametrize(
    ("loads", "lacks"),
    [
        ([], ["the empty belt", "a weight (20 kg is enough)"]),
        ([(0.0, 1, -1)], ["a weight (20 kg is enough)"]),
        ([(20.0, 1), (20.0, -1)], ["the empty belt"]),
        ([(0.0, 1, -1), (20.0, 1)], ["pulses backward under the weight of 20 kg"]),
        ([(0.0, -1), (20.0, 1, -1)], ["pulses forward on the empty belt"]),
        ([(0.0, 1), (0.0, -1), (20.0, -1, 1)], []),
    ],
)
def test_a_plate_needs_the_empty_belt_and_a_weight_under_pulses_of_both_directions(loads, lacks):
    assert lacking_on_plate([recording(*load) for load in loads]) == lacks


def said_of(*loads):
    """Parts of the sentences on a standing person after trials of these loads and 12 s without pulses."""
    plates = {("weight", f"{k}"): recording(*load) for k, load in enumerate(loads)}
    study = SimpleNamespace(
        conditions=lambda _: ["calm-1"],
        trials={("standing", "calm-1"): SimpleNamespace(source="recorded")},
        treadmill=SimpleNamespace(
            belt_of=lambda *_: "left", plate_trials=lambda _: [(*trial, None) for trial in plates]
        ),
        settings={
            "weight": {"weight": {"mass_kg": 20.0, "com_forward_of_markers_m": None}, "further_weights": []}
        },
    )
    said = to_record(study, Read(plates=plates, quiet_s={None: 12.0}))
    assert all(sentence.endswith(f" ({PAGE})") for sentence in said)
    return [part for sentence in said for part in sentence.split(": ", 1)[1].split(", ")]


def test_the_guideline_uses_the_same_words():
    page = (Path(__file__).parents[2] / PAGE).read_text(encoding="utf-8")
    table = page.partition("| To be recorded |")[2].partition("\n\n")[0]
    asked = [re.findall(r"`([^`]+)`", row.split(" | ")[0]) for row in table.splitlines()[2:]]
    said = said_of() + said_of((0.0, 1), (20.0, 1)) + said_of((0.0, -1), (20.0, -1))
    for words in asked:
        assert words
        for word in words:
            assert any(word in part for part in said), word
    for part in said:
        if "found 12 s" not in part:
            assert any(word in part for words in asked for word in words), part


def test_faults_of_recordings_and_other_calibrations_are_asked_for():
    matrix = np.random.default_rng(6).standard_normal((6, 12))
    scaled = matrix * np.array([1.0, 0.9, 1.0, 1.0, 1.0, 1.0])[:, None]

    def trial(calibration, faults=""):
        return Trial(250.0, {}, {}, {"calibration_right": calibration.tolist(), "faults": faults})

    read = Read(
        trials={
            ("standing", "a"): trial(scaled, "clipped"),
            ("standing", "b"): trial(scaled),
            ("weight", "w"): trial(matrix),
            ("empty", "e"): trial(matrix),
        }
    )
    clipped, calibration = faults_of(read)
    assert clipped.startswith("standing/a: peaks are cut off")
    assert clipped.endswith("(clipped)")
    assert "'standing/a', 'standing/b'" in calibration
    assert "than in weight/w" in calibration
    assert "F_y times 0.9" in calibration
    assert faults_of(Read(trials={("weight", "w"): trial(matrix), ("empty", "e"): trial(matrix)})) == []
