"""Electromyograms whose bursts are known: shaped noise times an envelope, amplifier noise and hum."""

import numpy as np

EMG_RATE_HZ = 1000.0


def interference_pattern(shape, rng):
    """Gaussian noise of unit variance along the last axis, 20 to 450 Hz, most of it at 50 to 120 Hz."""
    samples = shape[-1]
    frequency = np.fft.rfftfreq(samples, 1.0 / EMG_RATE_HZ)
    gain = frequency / (np.hypot(frequency, 60.0) * (1.0 + (frequency / 120.0) ** 2))
    gain *= (frequency > 20.0) & (frequency < 450.0)
    noise = np.fft.irfft(gain * np.fft.rfft(rng.standard_normal(shape)), samples)
    return noise / np.sqrt(np.sum(gain[1:] ** 2) / (samples // 2))


def ramp_burst(time, onset_s, rise_s=0.012, decay_s=0.04):
    """A burst from 0 to 1: a straight rise, then half a cosine."""
    past = time - onset_s
    decay = 0.5 + 0.5 * np.cos(np.pi * np.clip((past - rise_s) / decay_s, 0.0, 1.0))
    return np.clip(past / rise_s, 0.0, 1.0) * decay


def sine_burst(time, onset_s, length_s=0.05):
    """A burst from 0 to 1: half a sine, as the first lobe of a sinusoidal stretch velocity."""
    past = time - onset_s
    return np.where((past > 0.0) & (past < length_s), np.sin(np.pi * past / length_s), 0.0)


def emg(envelope, rng, noise=1.0, hum=1.0):
    """Raw electromyogram (uV) of an envelope (uV), shape (..., n): each row with a hum of its own phase."""
    time = np.arange(envelope.shape[-1]) / EMG_RATE_HZ
    phase = rng.uniform(0.0, 2.0 * np.pi, (*envelope.shape[:-1], 1))
    pattern = envelope * interference_pattern(envelope.shape, rng)
    white = noise * rng.standard_normal(envelope.shape)
    return pattern + white + hum * np.sin(2.0 * np.pi * 50.0 * time + phase)


def raw_responses(burst, events, peak, rng, rest=2.0, spread=0.3, **disturbances):
    """Time (s) from -0.4 to 0.4 s and raw responses (uV) whose bursts reach ``peak`` times the rest.

    The size of the bursts differs from event to event by ``spread`` (logarithm's standard deviation).
    """
    time = np.arange(-400, 401) / EMG_RATE_HZ
    size = np.exp(spread * rng.standard_normal((events, 1)))
    envelope = rest * (1.0 + (peak - 1.0) * size * burst(time))
    return time, emg(envelope, rng, **disturbances)
