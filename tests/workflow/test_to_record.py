"""What is still to be recorded on a plate, by the pulses of its trials."""

import numpy as np
import pytest

from tepsipe.treadmill.recording import BeltRecording
from workflow.support.to_record import lacking_on_plate

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
