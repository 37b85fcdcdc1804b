"""Belt-induced load without physics: a response to the acceleration of the belt for every calibrated mass.

    L_M(t) = sum_j c_Mj (h_j * a)(t)

Here a is the acceleration of the belt, h_j are hats over the time since it acted, and c_Mj follow by least
squares from the trials with the mass M on the belt. Between two masses of the calibration the response is
interpolated, beyond them the nearest one counts. It describes any linear, time-invariant treadmill under a
rigid weight. Which part of the change with M is caused by a subject who does not ride rigidly on the belt is
unknown; the constant ``response_share`` of the model carries this.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tepsipe.treadmill.pulse_windows import PulseWindows
from tepsipe.treadmill.recording import BeltRecording

# tips of the hats: time since the acceleration acted (s); the response is 0 at the first and at the last
TIPS_S = (
    *(-0.06, -0.04, -0.02, 0.0, 0.0125, 0.025, 0.0375, 0.05, 0.065),
    *(0.08, 0.1, 0.125, 0.16, 0.2, 0.25, 0.32, 0.4, 0.5, 0.65),
)
# standard deviation of the coefficients' weak prior, relative to a response of the size of the load
LOOSE = 10.0


@dataclass(frozen=True)
class MassResponse:
    """Response of one component of the load to the acceleration of the belt, mass by mass."""

    kg: Annotated[np.ndarray, "(masses,)", "kg"]
    """Masses on the belt of the calibration, from light to heavy."""
    taps: Annotated[np.ndarray, "(masses, n)"]
    """Response to an acceleration of 1 m/s² in one sample (unit of the load)."""
    lead: int
    """Number of taps before the acceleration (samples)."""

    def at(self, carried_kg: float, share: float) -> np.ndarray:
        """Response (as ``taps``), shape (n,), for a mass on the belt (kg).

        Its difference from the response with the lightest mass counts 1 + ``share`` times.
        """
        mixed = np.array([np.interp(carried_kg, self.kg, tap) for tap in self.taps.T])
        return self.taps[0] + (1.0 + share) * (mixed - self.taps[0])

    def load(self, recording: BeltRecording, share: float) -> np.ndarray:
        """MassResponse in a trial (unit of the load), shape (n,)."""
        whole = np.convolve(recording.acceleration, self.at(recording.carried_kg, share))
        return whole[self.lead : self.lead + recording.acceleration.size]

    def in_windows(self, windows: PulseWindows) -> np.ndarray:
        """MassResponse in the mean pulses of trials (unit of the load), shape (trials, n)."""
        return np.array(
            [
                _response(acceleration, self.at(kg, 0.0)[None], self.lead)[0]
                for acceleration, kg in zip(windows.acceleration, windows.kg, strict=True)
            ]
        )


def fit_mass_response(
    windows: PulseWindows,
    load: Annotated[np.ndarray, "(trials, n)"],
    used: Annotated[np.ndarray, "(trials,)"],
) -> MassResponse:
    """Fit the response of every mass to the load of its trials.

    load: measured load of one component less the load carried (N or N·m).
    used: trials to fit; a mass without any of them gets no response.
    """
    hats, lead = _hats(windows.rate_hz)
    masses = np.unique(windows.kg)
    taps = np.zeros((masses.size, hats.shape[1]))
    for row, kg in enumerate(masses):
        rows, right = [np.empty((0, hats.shape[0]))], [np.empty(0)]
        for k in np.flatnonzero(used & (windows.kg == kg)):
            inside, scale = windows.ramp == 1.0, np.sqrt(windows.count[k])
            columns = _response(windows.acceleration[k], hats, lead)[:, inside]
            rows.append(scale * columns.T)
            right.append(scale * load[k, inside])
        found, target = np.concatenate(rows), np.concatenate(right)
        size = max(float(np.linalg.norm(found, axis=0).max(initial=0.0)), 1e-300)
        held = np.eye(hats.shape[0]) * size / LOOSE / np.sqrt(max(target.size, 1))
        stacked = np.concatenate([found, held])
        taps[row] = np.linalg.lstsq(stacked, np.append(target, np.zeros(held.shape[0])))[0] @ hats
    return MassResponse(masses, taps, lead)


def _hats(rate_hz: float) -> tuple[np.ndarray, int]:
    """Hats, shape (hats, n), and the number of their samples before the acceleration."""
    lead, last = round(-TIPS_S[0] * rate_hz), round(TIPS_S[-1] * rate_hz)
    time = np.arange(-lead, last + 1) / rate_hz
    return np.array([np.interp(time, TIPS_S, tip) for tip in np.eye(len(TIPS_S))[1:-1]]), lead


def _response(acceleration: np.ndarray, taps: np.ndarray, lead: int) -> np.ndarray:
    """Response of rows of taps in a periodic window of n samples, shape (rows, n)."""
    n = acceleration.size
    wrapped = np.zeros((taps.shape[0], n))
    wrapped[:, np.arange(-lead, taps.shape[1] - lead) % n] = taps
    return np.fft.irfft(np.fft.rfft(wrapped, axis=1) * np.fft.rfft(acceleration), n, axis=1)
