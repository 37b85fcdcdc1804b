"""Resonance of the frame below a subject, beside that of the empty belt.

The largest ratio |F / a| of the fore-aft force to the belt's acceleration lies near the resonance of the
frame with what moves with it. Under a weight it is lower than on the empty belt; the force of a person passes
through the empty frame, and it stays. With A and F the mean spectra of acceleration and force over the n
pulses of a trial, N_A and N_F the variances of these means over the pulses, and sums over all trials and
`BAND_HZ` around each frequency,

    |F / a|^2 = sum n (|F|^2 - N_F) / sum n (|A|^2 - N_A)

It is known up to the frequency at which the motion of the belt is lost in its noise.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tepsipe.treadmill.prepared import PreparedTrial

# window of a pulse from its onset (s), and steps of the frequency (Hz)
BEFORE_S, AFTER_S, STEP_HZ = 0.1, 0.45, 0.125
# lowest resonance that is looked for, and its distance from the end of the band (Hz)
LOWEST_HZ, INSIDE_HZ = 15.0, 3.0
# a pulse of a whole sine has zeros in its spectrum, which this covers (Hz)
BAND_HZ = 5.0
# power of the mean acceleration of the belt, or of the force, over that of its noise
CLEAR = 10.0
# height of a resonance over the lowest ratio at a lower frequency: harmonics of the friction reach 7
RISE = 10.0
# smallest resonance under a person, relative to the empty belt's, whose mass does not move with the frame
WITHIN = 0.92


class FramePeak(NamedTuple):
    """Resonance of a frame, as the fore-aft force and the belt's acceleration show it."""

    hz: float | None
    """Frequency of the largest ratio; None where none is seen in the band."""
    up_to_hz: float
    """End of the band in which pulses move the belt clearly."""


def frame_peak(trials: Sequence[PreparedTrial], belt: str) -> FramePeak:
    """Resonance in the pulses of some trials with the same load on a belt, left or right."""
    motion = reaction = of_motion = of_reaction = frequency = np.zeros(1)
    for trial in trials:
        rate, column = trial.rate_hz, trial.trial.axes["belt"].tolist().index(belt)
        velocity = trial.trial.values("belt_velocity").astype(float)
        force = trial.trial.values("force")[:, column, 1].astype(float)
        before, length = round(BEFORE_S * rate), round((BEFORE_S + AFTER_S) * rate)
        onsets = np.array([o for o in trial.onsets if before <= o <= velocity.size + before - length])
        if onsets.size < 2:
            continue
        at = onsets[:, None] - before + np.arange(length)
        # pulses of both directions count alike
        signs = np.sign(velocity[at] @ velocity[at[0]])[:, None]
        pulses = [signs * x[at] for x in (np.gradient(velocity, 1.0 / rate), force)]
        samples, taper = round(rate / STEP_HZ), np.hanning(length)
        a, f = (np.fft.rfft((x - x[:, :before].mean(axis=1)[:, None]) * taper, samples) for x in pulses)
        frequency = np.fft.rfftfreq(samples, 1.0 / rate)
        n = onsets.size
        own, others = (x.var(axis=0, ddof=1) for x in (a, f))
        motion = motion + n * np.abs(a.mean(axis=0)) ** 2 - own
        reaction = reaction + n * np.abs(f.mean(axis=0)) ** 2 - others
        of_motion, of_reaction = of_motion + own, of_reaction + others
    width = min(round(BAND_HZ / STEP_HZ), motion.size)
    motion, reaction, of_motion, of_reaction = (
        np.convolve(x, np.ones(width), "same") for x in (motion, reaction, of_motion, of_reaction)
    )
    lost = (motion < CLEAR * of_motion) & (frequency > LOWEST_HZ)
    last = int(np.argmax(lost)) if lost.any() else frequency.size - 1
    up_to_hz = float(frequency[last])
    band = (frequency >= LOWEST_HZ) & (frequency < up_to_hz)
    if not band.any():
        return FramePeak(None, up_to_hz)
    ratio = np.sqrt(np.maximum(reaction[band], 0.0) / motion[band])
    highest = int(np.argmax(ratio))
    hz = float(frequency[band][highest])
    risen = ratio[highest] > RISE * ratio[: highest + 1].min()
    risen &= reaction[band][highest] > CLEAR * of_reaction[band][highest]
    return FramePeak(hz if risen and hz < up_to_hz - INSIDE_HZ else None, up_to_hz)


def moves_with_frame(under: Sequence[FramePeak], empty: FramePeak | None) -> bool | None:
    """Test for a subject whose mass lowers the resonance of the frame, as a weight does.

    under: resonance in every trial of the subject.
    empty: resonance of the empty belt.
    Returns: None if a resonance lies above the band of the pulses, or is not known.
    """
    seen = [peak.hz for peak in under if peak.hz is not None]
    if empty is None or empty.hz is None or not seen:
        return None
    return bool(np.median(seen) < WITHIN * empty.hz)


def resonance_sentence(under: Sequence[FramePeak], empty: FramePeak | None) -> str:
    """What the resonances under a subject and of the empty belt say, for a person to read."""
    if empty is None or not under:
        return "not compared: no recording of the empty belt"
    if moves_with_frame(under, empty) is None:
        ends = min(peak.up_to_hz for peak in (*under, empty) if peak.hz is None)
        return f"cannot be compared: the pulses show none below {ends:.0f} Hz, where their motion ends"
    seen = float(np.median([peak.hz for peak in under if peak.hz is not None]))
    return f"{seen:.0f} Hz with the person, {empty.hz:.0f} Hz with the empty belt"
