"""Windowed least squares with noise: variance and bias of I, B, K before anything is measured.

With R the regressors theta'', theta', theta - theta_rest of one window without noise, dR their noise, d_tau
the noise of the torque and x = (I, B, K), the estimate is

    x_hat - x = (R_n' R_n)^-1 R_n' e,    R_n = R + dR,    e = d_tau - dR x

e is white noise of markers and plate behind known filters H_k(f), so that its autocovariance and its
covariance with dR are sums over k of sigma_k^2 times the Fourier transform of H_k H_l^*. With G = R'R + C,
where C = E[dR' dR], and c = E[dR' e],

    bias = G^-1 c,    covariance of a window = G^-1 R' Cov(e) R G^-1 + G^-1 cov(dR' e) G^-1

to second order in the noise, which is enough while C is small compared with R'R. The windows are far apart,
so their mean has the covariance of one window divided by their number, plus the covariance due to the
reference at rest, which all windows share.

Noise in the torque from the leg's motion, and from plate and foot, for a leg near the vertical:

    leg     d_tau = -m r y'' - I_l theta'' + m g r theta            y = mean of the markers + (r - c) theta
    foot    d_tau = dM_x + l_f dF_y - m_f l_f y_A'' / 2 - (m + m_f) g y_A
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.experiments.planning.design import LEG, Design
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import Perturbation

# lags for which the covariance of the noise is computed (s): windows are shorter
_LAGS_S = 16.0


@dataclass(frozen=True)
class WindowNoise:
    """Bias and covariance of windowed least squares due to noise."""

    bias: Annotated[np.ndarray, "(3,)"]
    """Bias of I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad)."""
    covariance: Annotated[np.ndarray, "(3, 3)"]
    """Covariance of the mean over the windows (units of the parameters)."""
    of_rest: Annotated[np.ndarray, "(3,)"]
    """Part of its standard uncertainty that comes through rest, whatever the number of windows (units of
    the parameters)."""


def lowpass_gain(
    frequency_hz: Annotated[np.ndarray, "(m,)"], rate_hz: float, lowpass: Lowpass
) -> Annotated[np.ndarray, "(m,)"]:
    """Response of a Butterworth low-pass.

    frequency_hz: Frequencies.
    """
    order = lowpass.order // 2 if lowpass.zero_lag else lowpass.order
    sections = scipy.signal.butter(order, lowpass.cutoff_hz, fs=rate_hz, output="sos")
    _, gain = scipy.signal.sosfreqz(sections, frequency_hz, fs=rate_hz)
    return np.abs(gain) ** 2 + 0j if lowpass.zero_lag else gain


def _noise_filters(design: Design, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Filters from every source of noise, per standard deviation, to theta and the torque, (k, m)."""
    rig, leg, foot = design.rig, design.leg, design.foot
    layout = rig.leg_markers.layout_m
    centre = layout.mean(axis=0)
    across, along = (layout - centre).T
    spread = float(np.sum(across**2 + along**2))
    # y of every marker, then z
    to_angle = rig.marker_noise_m * np.concatenate([along, -across]) / spread
    theta = to_angle[:, None] * np.ones_like(s)
    mean = rig.marker_noise_m * np.concatenate([np.full(along.size, 1.0 / along.size), np.zeros(along.size)])
    if design.protocol.pathway == LEG:
        y = mean[:, None] + (leg.com_m - centre[1]) * theta
        pull = leg.mass_kg * leg.com_m
        torque = -pull * s**2 * y - leg.inertia_kgm2 * s**2 * theta + pull * leg.gravity_m_per_s2 * theta
        return theta, torque
    ankle = np.zeros((theta.shape[0], s.size), dtype=complex)
    ankle[0] = rig.marker_noise_m
    weight = (leg.mass_kg + foot.mass_kg) * leg.gravity_m_per_s2
    of_markers = -(0.5 * foot.mass_kg * foot.height_m * s**2 + weight) * ankle
    per_sample = np.sqrt(rig.camera_rate_hz / rig.plate_rate_hz)
    of_plate = per_sample * np.array([rig.moment_noise_Nm, foot.height_m * rig.force_noise_N])
    theta = np.vstack([theta, np.zeros((2, s.size))])
    return theta, np.vstack([of_markers, of_plate[:, None] * np.ones_like(s)])


class _Noise:
    """Covariances of the noise between two samples, of regressors and error."""

    def __init__(self, design: Design):
        rate, protocol = design.rig.camera_rate_hz, design.protocol
        self.lags = 2 ** int(np.ceil(np.log2(_LAGS_S * rate)))
        frequency = np.fft.rfftfreq(self.lags, 1.0 / rate)
        s = 2j * np.pi * frequency
        passed = lowpass_gain(frequency, rate, protocol.lowpass)
        theta, torque = _noise_filters(design, s)
        spectra = np.stack([s**2 * theta, s * theta, theta]) * passed
        error = torque * passed - np.einsum("p,pkm->km", design.parameters, spectra)
        self.error = self._shared(error, error)
        self.crossed = [self._shared(x, error) for x in spectra]
        self.moved = [[self._shared(a, b) for b in spectra] for a in spectra]
        # spectral density of the error at 0 Hz; a mean over n samples keeps 1 / n of it
        self.slow = float(np.sum(np.abs(error[:, 0]) ** 2))

    def _shared(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """E[a(t + lag) b(t)] for lags 0, 1, ... and, from the end, -1, -2, ..., shape (lags,)."""
        return np.fft.irfft(np.sum(a * b.conj(), axis=0), self.lags)

    def of_products(self, lag: np.ndarray) -> np.ndarray:
        """Covariance of dR'e of a window with such lags (Isserlis), shape (3, 3)."""
        covariance = np.empty((3, 3))
        for a in range(3):
            for b in range(3):
                product = self.moved[a][b][lag] * self.error[lag]
                covariance[a, b] = np.sum(product + self.crossed[a][lag] * self.crossed[b][lag].T)
        return covariance


def window_noise(
    design: Design, regressors: Annotated[np.ndarray, "(n, 3)"], windows: list[Perturbation], resting: int
) -> WindowNoise:
    """Bias and covariance of the mean of I, B, K over the windows.

    design: noise, filter, leg and joint.
    regressors: theta'' (rad/s²), theta' (rad/s), theta - theta_rest (rad) without noise, filtered.
    resting: samples at rest.
    """
    noise = _Noise(design)
    added = np.array([[x[0] for x in row] for row in noise.moved])
    drawn = np.array([x[0] for x in noise.crossed])
    biases, covariances, through_rest = [], [], []
    for window in windows:
        r = regressors[window.start : window.stop]
        kept = np.arange(len(r))
        lag = kept[:, None] - kept
        inverse = np.linalg.inv(r.T @ r + len(r) * added)
        spread = inverse @ r.T
        biases.append(inverse @ (len(r) * drawn))
        covariances.append(spread @ noise.error[lag] @ spread.T + inverse @ noise.of_products(lag) @ inverse)
        through_rest.append(spread.sum(axis=1))
    of_rest = np.sqrt(noise.slow / max(resting, 1)) * np.mean(through_rest, axis=0)
    total = np.sum(covariances, axis=0) / len(windows) ** 2 + np.outer(of_rest, of_rest)
    return WindowNoise(np.mean(biases, axis=0), total, np.abs(of_rest))
