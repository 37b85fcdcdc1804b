"""Lateness of a muscle's onset if the reflex needs a fast enough stretch, from pulses of several amplitudes.

A reflex with a threshold theta of the speed of stretch begins a latency L after the muscle is lengthened at
this speed, not after the belt starts. With s_k(t) the speed at which pulses of amplitude k lengthen it, and
T_k the onset of their responses,

    T_k = L + d_k(theta),     s_k(d_k) = theta

The larger the pulse, the earlier the threshold is reached. For every theta between 0 and the smallest peak of
s_k, all of them equally likely beforehand, L is the mean of T_k - d_k weighted by 1 / sigma_k^2, and

    weight(theta) = exp(-chi^2 / 2),     chi^2 = sum_k (T_k - d_k - L)^2 / sigma_k^2

The lateness of the onset of all responses together, T - L(theta), has the distribution of these weights. A
single amplitude leaves chi^2 at 0 for every threshold: the lateness then is anything up to the time at which
the stretch is fastest.

A response that begins softly is detected late in the same way, and later after smaller pulses. It is part of
this lateness. Onsets of the change point are used, because those of other detectors depend on the size of a
burst.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.signals.onsets import Onset

# pulses are of one amplitude if the largest is less than so many times the smallest
ALIKE = 1.2
# error of an onset beyond the scatter of resampled ensembles (s)
DETECTOR_S = 0.001
# thresholds that are tried, as shares of the largest one
SHARES = np.linspace(0.0, 0.98, 99)
# lateness beyond which a latency is flagged (s): four amplitudes of a reflex without a threshold leave less
LATE_S = 0.005


@dataclass(frozen=True)
class Lateness:
    """By how much the onset may be later than a latency after the stretch begins to count."""

    median_s: float
    most_s: float
    """Quantiles of 50 and 97.5 %."""
    rms_s: float
    """Root mean square."""
    amplitudes: int
    """Number of amplitudes behind it."""

    @property
    def flags(self) -> tuple[str, ...]:
        """``stretch-threshold`` if the latency may be clearly shorter."""
        return ("stretch-threshold",) if self.most_s > LATE_S else ()


@dataclass(frozen=True)
class Stretch:
    """Onset of the responses to pulses of one amplitude, and the stretch before it."""

    onset_s: float
    error_s: float
    """T_k and its standard error, from the start of the belt."""
    time: Annotated[np.ndarray, "(n,)", "s"]
    speed: Annotated[np.ndarray, "(n,)", "rad/s"]
    """s_k up to its peak, from the start of the belt on."""

    def reached_s(self, threshold: np.ndarray) -> np.ndarray:
        """d_k: instants at which the speed reaches thresholds (rad/s) for the first time."""
        fastest = np.maximum.accumulate(np.maximum(self.speed, 0.0))
        return self.time[np.searchsorted(fastest, threshold, side="right").clip(max=self.time.size - 1)]


def rising_stretch(
    time: np.ndarray, speed: np.ndarray, until_s: float
) -> tuple[Annotated[np.ndarray, "s"], Annotated[np.ndarray, "rad/s"]]:
    """Time every 0.1 ms, and speed of stretch, from the start of the belt to the peak before an instant."""
    fine = np.arange(0.0, until_s, 1e-4)
    values = scipy.interpolate.CubicSpline(time, speed)(fine)
    peak = int(np.argmax(values)) + 1
    return fine[:peak], values[:peak]


def groups_by_amplitude(sizes: Annotated[np.ndarray, "(responses,)"]) -> list[np.ndarray]:
    """Indices of the responses to pulses of about the same size, from small to large."""
    order, groups = np.argsort(np.abs(sizes), kind="stable"), []
    for k in order:
        if groups and abs(sizes[k]) < ALIKE * abs(sizes[groups[-1][0]]):
            groups[-1].append(k)
        else:
            groups.append([k])
    return [np.array(group) for group in groups]


def lateness_of(onset: Onset, stretches: list[Stretch], together: Stretch) -> Lateness:
    """Distribution of the lateness of an onset.

    onset: that of all responses together, by the change point.
    stretches: of each amplitude with an onset.
    together: stretch in all responses, used where no amplitude has an onset of its own.
    """
    if onset.latency_s is None or not stretches:
        stretches, whole_s = [together], together.onset_s
    else:
        whole_s = onset.latency_s
    threshold = SHARES * min(float(one.speed.max()) for one in stretches)
    began = np.array([one.onset_s - one.reached_s(threshold) for one in stretches])
    precision = np.array([1.0 / (one.error_s**2 + DETECTOR_S**2) for one in stretches])
    latency = precision @ began / precision.sum()
    weight = np.exp(-0.5 * (precision @ (began - latency) ** 2))
    late = np.maximum(whole_s - latency, 0.0)
    order = np.argsort(late)
    share = np.cumsum(weight[order]) / weight.sum()
    median, most = (float(late[order][np.searchsorted(share, q)]) for q in (0.5, 0.975))
    return Lateness(median, most, float(np.sqrt(weight @ late**2 / weight.sum())), len(stretches))
