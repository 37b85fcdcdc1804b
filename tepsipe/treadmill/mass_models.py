"""Treadmill models with a mass: a response for every calibrated mass, mass and damper, and the loaded frame.

Response to the acceleration of the belt for every calibrated mass, without physics:

    L_M(t) = sum_j c_Mj (h_j * a)(t)

Here a is the acceleration of the belt, h_j are hats over the time since it acted, and c_Mj follow by least
squares from the trials with the mass M on the belt. Between two masses of the calibration the response is
interpolated, beyond them the nearest one counts. It describes any linear, time-invariant treadmill under a
rigid weight. A change with M is friction, which grows with a subject's mass, or the frame's response to the
load of the weight, which does not; without physics the two cannot be told apart, so M is the whole mass, and
the constant ``response_share`` of the model carries the doubt.

The simplest models: subtraction of the mean of the empty belt, and mass, damper and spring.

Physical model of the belt-induced load: a frame that carries the load, belt friction, and mounts.

    measured = R_M S [ true + m a + c w + (f_0 + f_1 M) w / sqrt(v_0^2 + w^2) ],      w = v + T a
    R_M(s) = 1 / (1 + d s + (e_0 + e_1 M) s^2),     S(s) = 1 - k t s / (1 + t s)

Symbols: M mass on the belt (kg); v, a velocity (m/s) and acceleration (m/s²) of the belt under the load;
w velocity of the belt at the friction surface, which leads by the time T because the belt stretches.

- R_M: resonance of the frame on its stiff supports. Its frequency decreases with the mass of a weight, which
  moves with it; e_0 + e_1 M is moving mass over stiffness. The force of a person passes through R_0.
- S: mounts between the deck and the floor, which take the fraction k of a fast force and relax with the time
  constant t. A static calibration does not detect them.
- Forces in phase with acceleration come from moving parts, m. Forces in phase with velocity come from
  friction, with a viscous part c and a part f that saturates above the speed v_0 and increases with the mass.

The moment about the belt's axis of symmetry contains neither friction nor S: the model reduces to
measured = R_M [true + m a + c v], which identifies the frame best. The moment is therefore fitted first, and
the force with the frame from the moment. Unlike the other models this one needs recordings with more than
one mass, and it can be inverted: the true load follows from the measured one.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError, listed
from tepsipe.treadmill.black_box_models import BeltModel
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


@dataclass(frozen=True)
class MeanSubtraction(BeltModel):
    """Mean load of every perturbation of the empty belt, by condition (thesis section 3-1-2, eq 3-11)."""

    templates: dict[str, np.ndarray]
    """Condition -> mean load from the perturbation's onset on (unit of the load), shape (w,)."""
    rate_hz: float
    """Sampling rate for which it holds."""

    @property
    def order(self) -> int:
        """Number of conditions that can be subtracted."""
        return len(self.templates)

    def predict(self, recording: BeltRecording) -> np.ndarray:
        """L (unit of the load), shape (n,)."""
        if recording.condition not in self.templates:
            raise InputError(
                f"{recording.name}: expected a recording of the empty belt in condition "
                f"{recording.condition!r}, found {listed(self.templates)}: record it, or use another model"
            )
        template = self.templates[recording.condition]
        predicted = np.zeros(recording.load.size)
        for onset in recording.onsets:
            stop = min(onset + template.size, predicted.size)
            predicted[onset:stop] = template[: stop - onset]
        return predicted


def fit_mean_subtraction(recordings: list[BeltRecording]) -> MeanSubtraction:
    """Mean load over the perturbations of every condition (unit of the load)."""
    by_condition: dict[str, list[np.ndarray]] = {}
    for r in recordings:
        if not r.onsets:
            raise InputError(
                f"{r.name}: expected separate perturbations to average, found a continuously perturbed belt: "
                "use another model"
            )
        by_condition.setdefault(r.condition, []).append(r.segments(r.load))
    templates = {condition: np.concatenate(parts).mean(axis=0) for condition, parts in by_condition.items()}
    return MeanSubtraction(templates, recordings[0].rate_hz)


@dataclass(frozen=True)
class MassSpringDamper(BeltModel):
    """L = m a + c (v - mean v) + k (y - trend y) + d: a simple second-order model (thesis chapter 5)."""

    coefficients: Annotated[np.ndarray, "(4,)"]
    """m, c, k, d (unit of the load over m/s², m/s, m, 1)."""
    rate_hz: float
    """Sampling rate of the calibration."""

    @property
    def order(self) -> int:
        """2."""
        return 2

    def predict(self, recording: BeltRecording) -> np.ndarray:
        """L (unit of the load), shape (n,)."""
        return motion_regressors(recording) @ self.coefficients


def fit_mass_spring_damper(recordings: list[BeltRecording]) -> MassSpringDamper:
    """Least squares over all evaluated samples (unit of the load)."""
    rows = np.concatenate([motion_regressors(r)[r.evaluated] for r in recordings])
    load = np.concatenate([r.load[r.evaluated] for r in recordings])
    scale = np.linalg.norm(rows, axis=0)
    solution = np.linalg.lstsq(rows / scale, load, rcond=1e-10)[0] / scale
    return MassSpringDamper(solution, recordings[0].rate_hz)


def motion_regressors(recording: BeltRecording) -> np.ndarray:
    """Regressors of eq L: a (m/s²), v less its mean (m/s), distance less its trend (m), 1; shape (n, 4)."""
    v = recording.velocity - recording.velocity.mean()
    y = recording.through_lowpass(scipy.signal.detrend(recording.position))
    return np.column_stack([recording.acceleration, v, y, np.ones_like(v)])


STIFF_HZ = 50.0


@dataclass(frozen=True)
class LoadedFrame(BeltModel):
    """The model's constants."""

    frame: Annotated[np.ndarray, "(3,)"]
    """d (s), e_0 (s2), e_1 (s2/kg)."""
    motion: Annotated[np.ndarray, "(4,)"]
    """m (unit of the load over m/s²), c (over m/s), f_0 (unit of the load), f_1 (over kg)."""
    lag_s: float
    friction_speed_m_per_s: float
    """T (s), v_0 (m/s)."""
    mount_share: Annotated[float, "s"]
    mount_time_s: float
    rate_hz: float
    """Sampling rate of the calibration."""
    converged: bool = True
    """Whether the optimisation converged inside its bounds."""

    @property
    def order(self) -> int:
        """Order of the frame's response, 2."""
        return 2

    @property
    def constants(self) -> np.ndarray:
        """d, e_0, e_1, m, c, f_0, f_1, T, v_0, k, t in their units, shape (11,)."""
        others = [self.lag_s, self.friction_speed_m_per_s, self.mount_share, self.mount_time_s]
        return np.concatenate([self.frame, self.motion, others])

    def moved(self, step: np.ndarray) -> "LoadedFrame":
        """The model with a step, shape (11,), added to its ``constants``."""
        x = self.constants + step
        lag_s, speed, share, time_s = x[7:].tolist()
        return replace(
            self,
            frame=x[:3],
            motion=x[3:7],
            lag_s=lag_s,
            friction_speed_m_per_s=speed,
            mount_share=share,
            mount_time_s=time_s,
        )

    def resonance_hz(self, carried_kg: float) -> float:
        """Natural frequency of the frame (Hz) with a weight on the belt (kg)."""
        slowness = self.frame[1] + self.frame[2] * carried_kg
        return float(1.0 / (2.0 * np.pi * np.sqrt(slowness))) if slowness > 0.0 else float("inf")

    def added(self, recording: BeltRecording) -> np.ndarray:
        """Belt-induced load before the response of the frame (unit of the load), shape (n,)."""
        return _motion(recording, self.lag_s, self.friction_speed_m_per_s) @ self.motion

    def predict(self, recording: BeltRecording) -> np.ndarray:
        """L (unit of the load), shape (n,), from the belt's motion and the known load carried."""
        response = self._response(recording.rigid_kg)
        return (
            _filtered(recording.carried + self.added(recording), recording.rate_hz, response)
            - recording.carried
        )

    def added_per_kg(self, recording: BeltRecording) -> np.ndarray:
        """Friction of another kg on the belt, before the frame's response (N or N·m), shape (n,)."""
        heavier = replace(recording, carried_kg=recording.carried_kg + 1.0)
        return self.added(heavier) - self.added(recording)

    def compensate(
        self, recording: BeltRecording, force: np.ndarray | None = None, friction: np.ndarray | None = None
    ) -> np.ndarray:
        """Measured load, corrected for the frame's response and the belt-induced load, less the known load.

        Shape (n,), unit of the load; ``force`` and ``friction`` (N) are not needed.
        """
        response = self._response(recording.rigid_kg)
        measured = recording.load + recording.carried
        before = _filtered(measured, recording.rate_hz, lambda s: 1.0 / response(s))
        return before - self.added(recording) - recording.carried

    def frame_acceleration(self, recording: BeltRecording) -> np.ndarray:
        """Acceleration of the frame (m/s²), shape (n,), from the measured fore-aft force."""
        measured = recording.load + recording.carried
        return _filtered(measured, recording.rate_hz, lambda s: -self.frame[2] * s**2)

    def _response(self, rigid_kg: float):
        def response(s: np.ndarray) -> np.ndarray:
            frame = _frame_response(s, self.frame, rigid_kg)
            return frame * _mount_response(s, self.mount_share, self.mount_time_s)

        return response


def fit_loaded_frame(
    recordings: list[BeltRecording], frame: Annotated[np.ndarray, "(3,)"] | None = None
) -> LoadedFrame:
    """Fit all recordings together: linear parameters by least squares, the others by optimisation.

    recordings: calibration, with at least two different masses on the belt.
    frame: d (s), e_0 (s2), e_1 (s2/kg) from the moment; friction and mounts are then estimated. Without it
    the frame is estimated, with viscous friction only and without mounts.
    Returns: constants that minimise the squared error of the measured load.
    """
    masses = sorted({r.carried_kg for r in recordings})
    if len(masses) < 2:
        raise InputError(
            f"{recordings[0].name}: expected recordings with at least two different masses on the belt, "
            f"found only {masses[0]:g} kg: calibrate with the empty belt and with a weight"
        )
    target = np.concatenate([(r.load + r.carried)[r.evaluated] for r in recordings])
    stiff = 1.0 / (2.0 * np.pi * STIFF_HZ) ** 2

    def model(x: np.ndarray, motion: np.ndarray) -> LoadedFrame:
        rate = recordings[0].rate_hz
        if frame is None:
            shape = np.array([1e-3 * x[0], stiff * x[1], stiff * x[2] / masses[-1]])
            return LoadedFrame(shape, motion, 0.0, 1.0, 0.0, 1.0, rate)
        return LoadedFrame(frame, motion, 1e-3 * x[0], x[1], x[2], x[3], rate)

    moving = 2 if frame is None else 4  # columns of `_motion`, which the known load follows
    steady = [_spectra(np.stack([r.acceleration, r.carried]), r.rate_hz) for r in recordings]
    samples = [np.flatnonzero(r.evaluated) for r in recordings]

    # of a gradient's evaluations only some move lag and friction, which two of the inputs do not feel
    @lru_cache(maxsize=4 * len(recordings))
    def spectra(k: int, lag_s: float, friction_speed_m_per_s: float) -> dict[int, np.ndarray]:
        """Spectra of the columns that are not zero throughout."""
        columns = _motion(recordings[k], lag_s, friction_speed_m_per_s)[:, 1:moving].T
        (first, last), *_ = steady[k]
        spectra = [first, *_spectra(columns, recordings[k].rate_hz)[0], last]
        return {column: spectrum for column, spectrum in enumerate(spectra) if spectrum.any()}

    def solve(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        trial = model(x, np.zeros(4))
        rows, known = [], {}
        for k, r in enumerate(recordings):
            _, s, padded = steady[k]
            alike = r.rigid_kg, padded
            if alike not in known:
                known[alike] = trial._response(r.rigid_kg)(s)
            inputs = spectra(k, trial.lag_s, trial.friction_speed_m_per_s)
            responses = np.zeros((samples[k].size, moving + 1))
            for column, spectrum in inputs.items():
                responses[:, column] = scipy.fft.irfft(known[alike] * spectrum, padded)[samples[k]]
            rows.append(responses)
        stacked, rest = np.split(np.concatenate(rows), [moving], axis=1)
        stacked, remaining = np.ascontiguousarray(stacked), target - rest[:, 0]
        scale = np.maximum(np.linalg.norm(stacked, axis=0), 1e-300)
        solution = np.linalg.lstsq(stacked / scale, remaining, rcond=1e-10)[0] / scale
        return np.concatenate([solution, np.zeros(4 - solution.size)]), remaining - stacked @ solution

    if frame is None:  # ms, and parts of the slowness of a stiff frame
        start, low, high = [0.5, 1.0, 0.1], [0.0, 0.0, 0.0], [np.inf, np.inf, np.inf]
    else:  # ms, m/s, share, s
        start, low, high = [1.0, 0.2, 0.02, 0.05], [-20.0, 0.01, -0.5, 0.005], [20.0, 5.0, 0.9, 2.0]
    search = scipy.optimize.least_squares(
        lambda x: solve(x)[1], start, bounds=(low, high), diff_step=1e-3, x_scale=np.maximum(start, 0.02)
    )
    converged = bool(search.success and not search.active_mask.any())
    return replace(model(search.x, solve(search.x)[0]), converged=converged)


def _motion(recording: BeltRecording, lag_s: float, friction_speed_m_per_s: float) -> np.ndarray:
    """Columns a, w, w / sqrt(v_0^2 + w^2), and the last times M."""
    w = recording.raw_velocity + lag_s * recording.raw_acceleration
    # friction is non-linear: it is computed from unfiltered motion, then filtered like the measured load
    rubbing = recording.through_lowpass(w / np.hypot(friction_speed_m_per_s, w))
    sliding = recording.velocity + lag_s * recording.acceleration
    return np.column_stack([recording.acceleration, sliding, rubbing, recording.carried_kg * rubbing])


def _frame_response(s: np.ndarray, frame: np.ndarray, rigid_kg: float) -> np.ndarray:
    return 1.0 / (1.0 + frame[0] * s + (frame[1] + frame[2] * rigid_kg) * s**2)


def _mount_response(s: np.ndarray, share: float, time_s: float) -> np.ndarray:
    return 1.0 - share * time_s * s / (1.0 + time_s * s)


def _filtered(x: np.ndarray, rate_hz: float, response) -> np.ndarray:
    """``x``, shape (n,) or (n, c), filtered by a response given over s; ``x`` begins and ends at rest."""
    spectra, s, padded = _spectra(x.T, rate_hz)
    return scipy.fft.irfft(response(s) * spectra, padded)[..., : x.shape[0]].T


def _spectra(x: np.ndarray, rate_hz: float) -> tuple[np.ndarray, np.ndarray, int]:
    """Spectra of the rows of ``x``, followed by a second of rest, their s (rad/s) and length (samples)."""
    padded = scipy.fft.next_fast_len(x.shape[-1] + round(rate_hz), real=True)
    s = 2j * np.pi * scipy.fft.rfftfreq(padded, 1.0 / rate_hz)
    return scipy.fft.rfft(x, padded), s, padded
