"""Channels of the likelihood: motion of the foot, angle of the leg and logged velocity of the belt.

Marker j, at the longitudinal offset l_j and the anterior offset a_j of the leg (both 0 on the foot), moves by

    y_j = Y + (l_j + d) sin(theta) + a_j cos(theta) + c_j + e_j

with white noise e_j of one standard deviation sigma. Only the mean of l_j and a_j is taken from the layout:
their differences are measured at rest, because an error of 1 mm in l_j causes an error of 0.1 % in theta. d,
the offset of the joint from its place in the layout, is 0 on the foot; it is fitted to the residuals of least
squares. Least squares over the markers reduces them, sample by sample, to Y and sin(theta) without loss of
information; sigma follows from the residual. The constants c_j are free. A hidden marker is reconstructed
from the others. The net displacement of the belt over the trial is removed as a smooth ramp, so that every
channel can be repeated periodically:

    ramp(t) = D w(t / T),    w(u) = 10 u^3 - 15 u^4 + 6 u^5

Spectra are taken of whole channels, with N samples, and so white noise of variance s^2 has the variance N s^2
at every frequency. sigma is estimated in the band of the fit, after regression of the residuals on Y and
theta, so that residuals that follow them do not count as noise.
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.mechanics.segment_kinematics import SegmentMarkers, fit_rigid_segment

# band of the fit (Hz): below it the foot does not move the leg, above it only noise remains
BAND_HZ = (0.1, 30.0)
# motion in the terms that are not linear: kept up to the first frequency, none beyond the second (Hz)
KEPT_HZ, LOST_HZ = 40.0, 60.0
# smallest noise, over the range of a channel: exact signals have none
_LEAST_NOISE = 1e-7
# range of a channel that does not move, but for rounding (m, rad, m/s)
_STILL = 1e-7
# time at each end over which the position of the belt is averaged (s)
_END_S = 0.2
# largest slope of a belt that counts as horizontal (rad), and smallest detectable one, over its standard
# error
STEEPEST_RAD, SEEN = 0.02, 4.0


@dataclass(frozen=True)
class DummyMarkers:
    """Markers on foot and leg, as measured."""

    positions: Annotated[np.ndarray, "(n, k, 2)"]
    """y along the belt, z up (m), at common instants, not filtered."""
    layout_m: Annotated[np.ndarray, "(k, 2)"]
    """Anterior and longitudinal offset of the leg's markers (m); NaN for markers on the foot."""
    on_foot: Annotated[np.ndarray, "(k,)"]
    """Whether a marker moves with the foot; one on the ankle belongs to both."""
    hidden: Annotated[np.ndarray, "(n, k)"] | None = None
    """Samples that were filled."""
    places: Annotated[np.ndarray, "(k,)"] | None = None
    """Places of the markers in the sequence of a frame, from 0; None if they are not sampled one after the
    other, or their instants are not corrected."""

    @property
    def on_leg(self) -> np.ndarray:
        """Mask of the markers on the leg, shape (k,)."""
        return np.isfinite(self.layout_m).all(axis=1)


@dataclass(frozen=True)
class Channels:
    """Motion of foot, leg and belt, and the noise of the markers."""

    rate_hz: float
    foot: np.ndarray
    angle: np.ndarray
    """Y without its ramp (m), and theta - theta_0 (rad)."""
    log: Annotated[np.ndarray, "(n,)", "m/s"] | None
    """Velocity of the belt without the velocity of the ramp."""
    ramp: Annotated[np.ndarray, "(n,)", "m/s²"]
    """Acceleration of the ramp."""
    theta_0_rad: float
    """Angle at rest."""
    marker_noise_m: float
    """sigma of one marker in one coordinate."""
    marker_freedom: float
    """Degrees of freedom of sigma²."""
    geometry: Annotated[np.ndarray, "(2, 2)"]
    """Covariance of Y and theta per sigma² (1, 1/m; 1/m, 1/m²)."""
    residuals: Annotated[np.ndarray, "(n, k)", "m"]
    """Residuals of the markers."""
    joint_offset_m: float
    joint_offset_error_m: float
    """d, the height of the markers' origin over the joint, and its standard error (m); 0 if no marker is on
    the foot alone."""
    offset_slopes: Annotated[np.ndarray, "(2,)"]
    """Change of Y and theta per error of d, relative to theta (-, 1/m)."""
    on_leg: Annotated[np.ndarray, "(k,)"]
    """Markers on the leg."""

    @property
    def bins(self) -> np.ndarray:
        """Indices of the fitted frequencies among the frequencies of `numpy.fft.rfft`."""
        frequency = np.fft.rfftfreq(self.foot.size, 1.0 / self.rate_hz)
        return np.flatnonzero((frequency >= BAND_HZ[0]) & (frequency <= BAND_HZ[1]))

    @property
    def s(self) -> np.ndarray:
        """Laplace variable j 2 pi f of the fitted frequencies (rad/s)."""
        return 2j * np.pi * self.bins * self.rate_hz / self.foot.size


def dummy_markers(
    positions: Annotated[np.ndarray, "(n, all markers, 3)", "m"],
    labels: list[str],
    leg_markers: SegmentMarkers,
    belt_fixed_labels: tuple[str, ...],
    hidden: Annotated[np.ndarray, "(n, all markers)"] | None = None,
) -> DummyMarkers:
    """Markers of foot and leg out of all markers.

    belt_fixed_labels: those that move with the foot.
    hidden: samples that were filled.
    Returns: in the order of ``labels``.
    """
    wanted = [*belt_fixed_labels, *leg_markers.labels]
    missing = [label for label in wanted if label not in labels]
    if missing or not belt_fixed_labels:
        raise InputError(
            f"expected belt-fixed markers and those of the leg among {', '.join(labels)}, found "
            f"{missing[0] if missing else 'none on the belt'}: correct belt_fixed_labels and leg_markers"
        )
    used = [label for label in labels if label in wanted]
    layout = np.full((len(used), 2), np.nan)
    for label, offsets in zip(leg_markers.labels, leg_markers.layout_m, strict=True):
        layout[used.index(label)] = offsets
    columns = [labels.index(label) for label in used]
    return DummyMarkers(
        np.asarray(positions, dtype=float)[:, columns, -2:],
        layout,
        np.array([label in belt_fixed_labels for label in used]),
        None if hidden is None else np.asarray(hidden, dtype=bool)[:, columns],
        np.array(columns),
    )


def levelled(markers: DummyMarkers, at_rest: np.ndarray) -> DummyMarkers:
    """Markers in axes in which the belt moves horizontally.

    If the axes of the motion capture are tilted by e, terms of second order are wrong, among them -p y'' e
    phi, which cannot be separated from the loss of a joint that softens: 3 mrad change B by 8 %. Every trial
    shows the direction of the belt, so e is measured, with a standard error of 0.03 to 0.1 mrad. The axes are
    left unchanged if e is less than `SEEN` standard errors, so that no noise is added to level axes, and if
    the belt rises by more than `STEEPEST_RAD`, because it is then inclined.

    at_rest: samples at rest.
    Returns: rotated about the place of the foot at rest.
    """
    foot = markers.positions[:, markers.on_foot].mean(axis=1)
    whole = slice(None) if markers.hidden is None else ~markers.hidden[:, markers.on_foot].any(axis=1)
    along, up = (foot[whole] - foot[whole].mean(axis=0)).T
    travelled = float(along @ along)
    if not travelled > 0.0:
        return markers
    slope = float(along @ up) / travelled
    error = np.std(up - slope * along) / np.sqrt(travelled)
    if abs(slope) < SEEN * error or abs(slope) > STEEPEST_RAD:
        return markers
    tilt, origin = np.arctan(slope), foot[at_rest].mean(axis=0)
    cosine, sine = np.cos(tilt), np.sin(tilt)
    turned = (markers.positions - origin) @ np.array([[cosine, -sine], [sine, cosine]]) + origin
    return replace(markers, positions=turned)


def make_channels(
    time: Annotated[np.ndarray, "(n,)", "s"],
    markers: DummyMarkers,
    belt_velocity: np.ndarray | None,
    at_rest: np.ndarray,
    *,
    level: bool = True,
) -> Channels:
    """Reduce markers and log to the channels of the likelihood.

    time: instants, evenly spaced.
    markers: markers of foot and leg.
    belt_velocity: logged velocity of the belt, not filtered (m/s); None without a log whose noise is
    independent of the markers' noise.
    at_rest: samples at rest.
    level: whether axes are levelled by the direction of the belt, see `levelled`.
    """
    if level:
        markers = levelled(markers, at_rest)
    on_leg, k = markers.on_leg, markers.positions.shape[1]
    if k < 3:
        raise InputError(f"expected at least three markers on foot and leg, found {k}: place more")
    pose = fit_rigid_segment(markers.positions[:, on_leg], markers.layout_m[on_leg], np.zeros(2))
    theta_0 = float(pose.angle[at_rest].mean())
    across, along = _measured_layout(markers, at_rest, theta_0)
    y = markers.positions[:, :, 0] - np.outer(np.cos(pose.angle) - np.cos(theta_0), across)
    y = y - y[at_rest].mean(axis=0)
    foot, sine, residuals = _reduced(y, along, markers.hidden)
    offset, spread = _joint_offset(residuals, sine, along, on_leg)
    if offset != 0.0:
        along = along + np.where(on_leg, offset, 0.0)
        foot, sine, residuals = _reduced(y, along, markers.hidden)
    angle = np.arcsin(np.clip(sine + np.sin(theta_0), -1.0, 1.0)) - theta_0
    rate_hz = (time.size - 1) / (time[-1] - time[0])
    for what, signal in (("a foot", foot), ("a belt", belt_velocity), ("a leg", angle)):
        if signal is not None and not np.ptp(signal) > _STILL:
            raise InputError(
                f"expected {what} that moves, found one that stands still: check the belt-fixed "
                "markers and those on the leg, and that the belt was perturbed"
            )
    foot, log, ramp = _without_ramp(foot, belt_velocity, rate_hz)
    noise, freedom = _noise(residuals, foot, angle, rate_hz)
    noise = max(noise, _LEAST_NOISE * float(np.ptp(foot)))
    design = np.column_stack([np.ones(k), along])
    return Channels(
        rate_hz=rate_hz,
        foot=foot,
        angle=angle,
        log=log,
        ramp=ramp,
        theta_0_rad=theta_0,
        marker_noise_m=noise,
        marker_freedom=freedom,
        geometry=np.linalg.inv(design.T @ design) / np.outer([1.0, np.cos(theta_0)], [1.0, np.cos(theta_0)]),
        residuals=residuals,
        joint_offset_m=offset,
        joint_offset_error_m=noise * spread,
        offset_slopes=np.linalg.pinv(design) @ on_leg.astype(float),
        on_leg=on_leg,
    )


def _measured_layout(
    markers: DummyMarkers, at_rest: np.ndarray, theta_0: float
) -> tuple[np.ndarray, np.ndarray]:
    """Anterior and longitudinal offsets (m), 0 on the foot, with the differences measured at rest."""
    on_leg = markers.on_leg
    y, z = markers.positions[at_rest][:, on_leg].mean(axis=0).T
    seen = np.array([y * np.cos(theta_0) - z * np.sin(theta_0), y * np.sin(theta_0) + z * np.cos(theta_0)])
    layout = np.zeros((2, on_leg.size))
    centre = markers.layout_m[on_leg].mean(axis=0)
    layout[:, on_leg] = seen - seen.mean(axis=1, keepdims=True) + centre[:, None]
    return layout[0], layout[1]


def _joint_offset(
    residuals: np.ndarray, sine: np.ndarray, along: np.ndarray, on_leg: np.ndarray
) -> tuple[float, float]:
    """Least-squares d (m) from the residuals of the markers (m), and its standard error per sigma."""
    if on_leg.all():
        return 0.0, 0.0
    design = np.column_stack([np.ones(along.size), along])
    unexplained = on_leg - design @ (np.linalg.pinv(design) @ on_leg.astype(float))
    swing = sine - sine.mean()
    total = float(np.sum(unexplained**2) * np.sum(swing**2))
    if np.sum(unexplained**2) < 1e-9 or not total > 0.0:
        return 0.0, 0.0
    return float(swing @ (residuals @ unexplained)) / total, 1.0 / float(np.sqrt(total))


def _reduced(
    y: np.ndarray, along: np.ndarray, hidden: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Y (m) and sin(theta) relative to rest, and residuals (m), of markers at ``along`` (m)."""
    design = np.column_stack([np.ones(along.size), along])
    whole = np.ones(len(y), dtype=bool) if hidden is None else ~hidden.any(axis=1)
    solve = np.linalg.pinv(design)
    residual = y[whole] - y[whole] @ solve.T @ design.T
    offsets = residual.mean(axis=0) if residual.size else np.zeros(along.size)
    y = y - offsets
    reduced = y @ solve.T
    if not whole.all():
        for pattern in np.unique(hidden[~whole], axis=0):
            rows, seen = (hidden == pattern).all(axis=1), ~pattern
            if np.linalg.matrix_rank(design[seen]) < 2:
                continue  # what the ingest filled is all there is
            reduced[rows] = y[np.ix_(rows, seen)] @ np.linalg.pinv(design[seen]).T
            y[np.ix_(rows, pattern)] = reduced[rows] @ design[pattern].T
    return reduced[:, 0], reduced[:, 1], y - reduced @ design.T


def _without_ramp(
    foot: np.ndarray, belt_velocity: np.ndarray | None, rate_hz: float
) -> tuple[np.ndarray, np.ndarray | None, np.ndarray]:
    """Position (m), velocity (m/s) without the ramp of the net displacement, its acceleration (m/s²)."""
    ends = max(2, round(_END_S * rate_hz))
    displacement = float(foot[-ends:].mean() - foot[:ends].mean())
    lasts = foot.size / rate_hz
    u = np.arange(foot.size) / foot.size
    position = displacement * u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    velocity = displacement / lasts * 30.0 * u**2 * (1.0 - u) ** 2
    acceleration = displacement / lasts**2 * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)
    log = None if belt_velocity is None else np.asarray(belt_velocity, dtype=float) - velocity
    return foot - position, log, acceleration


def _noise(residuals: np.ndarray, foot: np.ndarray, angle: np.ndarray, rate_hz: float) -> tuple[float, float]:
    """Noise sigma (m) in the band of the fit, and degrees of freedom of its square."""
    n, k = residuals.shape
    frequency = np.fft.rfftfreq(n, 1.0 / rate_hz)
    band = (frequency >= BAND_HZ[0]) & (frequency <= BAND_HZ[1])
    motion = scipy.fft.rfft(np.column_stack([foot, angle]), axis=0)[band]
    residual_spectrum = scipy.fft.rfft(residuals, axis=0)[band]
    columns = np.concatenate([motion.real, motion.imag])
    columns = columns / np.linalg.norm(columns, axis=0)
    values = np.concatenate([residual_spectrum.real, residual_spectrum.imag])
    values = values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]
    freedom = (k - 2.0) * (2.0 * band.sum() - 2.0)
    return float(np.sqrt((values**2).sum() / freedom * 2.0 / n)), float(freedom)


def smooth(
    spectrum: Annotated[np.ndarray, "(samples // 2 + 1,)"], samples: int, rate_hz: float, order: int = 0
) -> Annotated[np.ndarray, "(samples,)"]:
    """Derivative of a signal without its highest frequencies.

    spectrum: spectrum of the signal, from `numpy.fft.rfft`.
    samples: its length.
    Returns: the derivative (unit per s to the power of ``order``), smooth above `KEPT_HZ`.
    """
    frequency = np.fft.rfftfreq(samples, 1.0 / rate_hz)
    passed = np.clip((LOST_HZ - frequency) / (LOST_HZ - KEPT_HZ), 0.0, 1.0)
    passed = passed**2 * (3.0 - 2.0 * passed)
    return scipy.fft.irfft(spectrum * passed * (2j * np.pi * frequency) ** order, samples)
