"""Linear model of the frame below a belt: the load follows from the measured one and the frame's inertia.

The frame with its mass matrix rests on springs and dampers, which are the transducers. What stands on the
belt, belt and friction push it with W = (force, moment about the belt's axis), and the transducers measure
L = K u + C u' of its displacement u. With Newton's law and dampers in proportion to the springs, C = d K,

    W = L + mass s^2 u,    u = K^-1 L / (1 + d s)   so that   W = G L + A q L,   q = s^2 / (1 + d s)

without any resonance to be searched for: the load is linear in G, in the inertia over stiffness A, and in the
compliance K^-1. Of W the belt takes B = m a + c v + friction, at the depth `lever` below its surface. What
stands on the belt exerts the rest,

    F = [g + A_FF q + S_F q^2 + k t s / (1 + t s)] L_F + A_FM q L_M - B
    M = [g_M + A_MM q + S_M q^2] L_M + (x + A_MF q) L_F - m_M a - c_M v - lever B

S stands for a second mode of the frame, of which the transducers show the sum with the first. Mounts, which
take the part k / (1 + k) of a quick force to the floor, relax within the time t. The frame, and all that
stands on it, accelerates by

    u'' = -(k_FF q L_F + k_FM q L_M) forwards,    phi'' = -(k_FM q L_F + k_MM q L_M) in pitch

A person's force is F. That of a weight of the mass M, with its centre at the height h, is known besides:
F = M (a + u'' - h phi''), M_x = M g y - h F. Its moment of inertia about its own centre is neglected. The
mass of whoever else stands there is not part of the frame; it only presses on the belt, whose friction grows.

Friction is a sum of curves v / sqrt(v_i^2 + v^2) of several speeds, and, where held-out trials ask for it, of
bristles of several pre-sliding distances (`tepsipe.treadmill.pulse_windows`): the generalised Maxwell-slip
model, linear in their forces (Lampaert, Swevers & Al-Bender 2002). The velocity of friction leads the belt's
by T, because the belt stretches. The log of the force is ahead of that of the speed by D.

For given D, d, t and T all other constants follow from one convex least-squares problem over force and moment
of the mean pulses of all trials, with normal priors (`PRIORS`). These four are scanned, then improved by
damped Gauss-Newton steps. In these the residual of the load is divided by the frame's response, so that it
becomes that of the measured load, and the modelled load takes the place of the measured one in the
regressors: these are its derivatives, whose noise would bias the constants towards zero (output error; Ljung
1999, System Identification, 7.4). Errors of the constants are
those of clusters (`tepsipe.statistics.clusters`), a trial each.

Bristles, second mode, scale and pitch are terms that the data may not need. The variant with the smallest
error on left-out trials is used. Trials that were drawn otherwise might have preferred another one, and
variants that predict the weights almost equally well can differ by a fifth in a person's B. Each draw of the
constants therefore chooses its variant again, by the same errors with random weights of the trials (Bayesian
bootstrap: Yao et al. 2018, Bayesian Analysis 13:917). The difference from the variant that is used counts in
either direction.
"""

import itertools
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, NamedTuple

import numpy as np

from tepsipe.errors import InputError
from tepsipe.statistics.clusters import leave_out
from tepsipe.treadmill.black_box_models import BeltModel
from tepsipe.treadmill.bristle_fit import (
    COMPONENTS,
    Calibrated,
    centred,
    heaviest,
    left_out_in_turn,
    noise_weights,
)
from tepsipe.treadmill.bristle_frame import LOWEST_HZ
from tepsipe.treadmill.pulse_windows import (
    Bristles,
    PulseWindows,
    bent_in_turn,
    coarse_spectrum,
    from_each_pulse,
    held,
    mean_state,
    over_line,
    pulse_windows,
    pulses_of,
)
from tepsipe.treadmill.recording import BeltRecording

# speeds at which sliding friction saturates (m/s), and pre-sliding distances of bristles (m)
SPEEDS = {"slow": 0.03, "medium": 0.1, "fast": 0.3}
DISTANCES = {"short": 1e-4, "long": 5e-4}


class Prior(NamedTuple):
    """Normal prior of a constant."""

    mean: float
    sd: float


SEARCHED = {
    "lead_s": Prior(0.0, 2e-3),
    "damping_s": Prior(5e-4, 1e-3),
    "mount_time_s": Prior(0.05, 0.1),
    "second_s2": Prior(5e-6, 5e-6),
    "lag_s": Prior(0.0, 0.01),
}
OF_FRAME = ("lead_s", "damping_s", "mount_time_s", "second_s2")
# response -> constants of the force, or of the moment, that it multiplies: which measured load it filters
FORCE = {
    "force_gain": ("Fy", "same", Prior(1.0, 0.05)),
    "force_inertia": ("Fy", "twice", Prior(0.0, 1e-4)),
    "force_second": ("Fy", "again", Prior(0.0, 1e-10)),
    "force_coupling": ("Mx", "twice", Prior(0.0, 1e-4)),
    "mount_share": ("Fy", "relaxing", Prior(0.0, 0.2)),
}
MOMENT = {
    "moment_gain": ("Mx", "same", Prior(1.0, 0.01)),
    "moment_inertia": ("Mx", "twice", Prior(0.0, 1e-4)),
    "cross_talk_m": ("Fy", "same", Prior(0.0, 0.005)),
    "moment_second": ("Mx", "again", Prior(0.0, 1e-10)),
    "moment_coupling": ("Fy", "twice", Prior(0.0, 3e-5)),
}
COMPLIANCE = {"sway": Prior(0.0, 5e-7), "tilt": Prior(0.0, 2e-7), "pitch": Prior(0.0, 5e-7)}
BELT = {"belt_mass": Prior(0.0, 30.0), "viscous": Prior(0.0, 30.0)}
OF_MOMENT = {"belt_moment": Prior(0.0, 3.0), "moment_viscous": Prior(0.0, 3.0), "lever_m": Prior(0.0, 0.2)}
RUBBING = {"": Prior(0.0, 10.0), "_per_kg": Prior(0.0, 0.3)}
SMOOTH, BRISTLES = (
    {f"{name}{per}": prior for name in names for per, prior in RUBBING.items()}
    for names in (SPEEDS, DISTANCES)
)
PRIORS = {
    **SEARCHED,
    **{name: prior for name, (*_, prior) in (FORCE | MOMENT).items()},
    **COMPLIANCE,
    **BELT,
    **OF_MOMENT,
    **SMOOTH,
    **BRISTLES,
}
CONSTANTS = tuple(PRIORS)
AT = {name: k for k, name in enumerate(CONSTANTS)}
MEAN, SD = np.array(list(PRIORS.values())).T
# values of these that are scanned (s), their limits, and steps of the derivatives by them
SCANNED = ((-1e-3, 0.0, 1e-3), (5e-4,), (0.02, 0.1), (5e-6,), (0.0, 7e-3))
LIMITS = np.array([[-0.01, 0.01], [0.0, 0.01], [0.005, 1.0], [0.0, 2e-5], [-0.02, 0.02]])
STEPS = (2e-5, 2e-5, 1e-3, 1e-7, 1e-4)
# steps of a search, gain of the cost that ends them, relative to it, and smallest and small damping of a step
MOST, ENOUGH, LEAST, SMALL = 30, 1e-3, 1e-3, 0.1
# what held-out trials may ask for -> its constants
TERMS = {
    "bristles": tuple(BRISTLES),
    "second-mode": ("second_s2", "force_second", "moment_second"),
    "scale": ("force_gain", "moment_gain", "cross_talk_m"),
    "pitch": ("force_coupling", "moment_coupling", "tilt", "pitch"),
}
SHOWN_HZ = np.arange(1.0, 300.0, 0.05)  # frequencies at which a resonance is looked for
PLAIN = "sway"  # variant without these


def _responses(s: np.ndarray, c: dict[str, float]) -> dict[str, np.ndarray]:
    """Responses of which the constants are factors, of a load whose log is ahead of the belt's."""
    late, twice, relaxed = np.exp(-s * c["lead_s"]), s**2 / (1.0 + c["damping_s"] * s), c["mount_time_s"] * s
    return {
        "same": late,
        "twice": twice * late,
        "again": twice**2 / (1.0 + c["damping_s"] * s + c["second_s2"] * s**2) * late,
        "relaxing": relaxed / (1.0 + relaxed) * late,
    }


def _matrix(
    constants: np.ndarray, s: np.ndarray, kg: float | np.ndarray, height_m: float | np.ndarray
) -> np.ndarray:
    """Matrix from the measured load at s (rad/s) to the load on the frame, less what moves a weight with it.

    Shape (2, 2, ...): force, moment of the load; force, moment measured.
    """
    c = dict(zip(CONSTANTS, constants.tolist(), strict=True))
    found = _responses(s, c)
    columns = dict.fromkeys(((row, load) for row in (0, 1) for load in COMPONENTS), 0.0)
    for row, terms in enumerate((FORCE, MOMENT)):
        for name, (load, response, _) in terms.items():
            columns[row, load] = columns[row, load] + c[name] * found[response]
    for load, moved in (("Fy", c["sway"] - height_m * c["tilt"]), ("Mx", c["tilt"] - height_m * c["pitch"])):
        back = kg * moved * found["twice"]
        columns[0, load] = columns[0, load] + back
        columns[1, load] = columns[1, load] - height_m * back
    return np.array([[columns[row, load] for load in COMPONENTS] for row in (0, 1)])


def _inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverse of matrices of shape (2, 2, ...)."""
    (a, b), (c, d) = matrix
    return np.array([[d, -b], [-c, a]]) / (a * d - b * c)


@dataclass(frozen=True)
class LinearFrame(BeltModel):
    """The model's constants, the same for fore-aft force and moment."""

    component: str
    """{"Fy", "Mx"}: The load that it predicts."""
    constants: Annotated[np.ndarray, "(c,)"]
    """Those of `CONSTANTS` in their order."""
    terms: tuple[str, ...]
    """Those of `TERMS` that held-out trials asked for."""
    rate_hz: float
    """Sampling rate of the calibration."""
    heaviest_kg: float
    """Largest mass of the calibration."""
    converged: bool = True
    """Whether the constants that are searched for converged inside their limits."""

    @property
    def holds_errors(self) -> bool:
        """True: it has them from its calibration and from held-out trials."""
        return True

    @property
    def order(self) -> int:
        """Order of the frame's response."""
        return 4

    @cached_property
    def named(self) -> dict[str, float]:
        """The constants by their names."""
        return dict(zip(CONSTANTS, self.constants.tolist(), strict=True))

    def moved(self, step: np.ndarray) -> "LinearFrame":
        """The model with a step, shape (c,), added to its ``constants``."""
        return replace(self, constants=self.constants + step)

    def resonance_hz(self, carried_kg: float) -> float:
        """Lowest natural frequency of the undamped frame (Hz) with a weight at the belt's height (kg)."""
        undamped = self.constants.copy()
        undamped[[AT[name] for name in ("lead_s", "damping_s", "mount_share")]] = 0.0
        (a, b), (c, d) = _matrix(undamped, 2j * np.pi * SHOWN_HZ, carried_kg, 0.0).real
        beyond = a * d - b * c <= 0.0
        return float(SHOWN_HZ[np.argmax(beyond)]) if beyond.any() else float("inf")

    def plausible(self, mass_kg: float) -> bool:
        """Test for a resonance, and a friction under a mass (kg), that an empty treadmill can have."""
        sliding = sum(self._force(name, mass_kg) for name in (*SPEEDS, *DISTANCES))
        return bool(
            np.isfinite(self.constants).all()
            and self.resonance_hz(0.0) >= LOWEST_HZ
            and sliding + 0.5 * self.named["viscous"] >= 0.0
        )

    def predict(self, recording: BeltRecording) -> np.ndarray:
        """L (unit of the load), shape (n,), relative to its value before each pulse."""
        carried, beside = recording.carried, recording.beside_carried
        if beside is None:
            self._refuse(recording, bool(recording.rigid_kg))
            beside = np.zeros(carried.size)
        force, moment = (carried, beside) if self.component == "Fy" else (beside, carried)
        belt = self.belt_force(recording)
        loads = [force + belt, moment + self._moment(recording, belt)]
        found = [over_line(x) for x in loads]
        s = 2j * np.pi * np.fft.rfftfreq(carried.size, 1.0 / recording.rate_hz)
        inverse = _inverse(_matrix(self.constants, s, recording.rigid_kg, recording.rigid_height_m))
        static = _inverse(_matrix(self.constants, np.zeros(1), 0.0, 0.0))[..., 0].real
        row = COMPONENTS.index(self.component)
        spectrum = sum(g * x for g, (x, _) in zip(inverse[row], found, strict=True))
        line = sum(g * x for g, (_, x) in zip(static[row], found, strict=True))
        return from_each_pulse(recording, np.fft.irfft(spectrum, carried.size) + line - carried)

    def compensate(
        self,
        recording: BeltRecording,
        force: np.ndarray | None = None,
        friction: Annotated[np.ndarray, "(n,)", "N"] | None = None,
    ) -> np.ndarray:
        """True load less the load carried (unit of the load), shape (n,), but for a constant.

        ``friction`` is the output of `belt_force` (N), if it is known already; ``force`` is not needed.
        """
        seen, c = self._seen(recording), self.named
        belt = self.belt_force(recording) if friction is None else friction
        terms = FORCE if self.component == "Fy" else MOMENT
        found = sum(c[name] * seen[load, response] for name, (load, response, _) in terms.items())
        found = found - (belt if self.component == "Fy" else self._moment(recording, belt))
        kg, height_m = recording.rigid_kg, recording.rigid_height_m
        if kg:
            back = -kg * (self._frame(seen)[0] - height_m * self._frame(seen)[1])
            found = found + (back if self.component == "Fy" else -height_m * back)
        return found - recording.carried

    def added_per_kg(self, recording: BeltRecording) -> np.ndarray:
        """Friction of another kg on the belt, before the frame's response (N or N·m), shape (n,)."""
        heavier = replace(recording, carried_kg=recording.carried_kg + 1.0)
        added = self.belt_force(heavier) - self.belt_force(recording)
        return added if self.component == "Fy" else self.named["lever_m"] * added

    def frame_acceleration(self, recording: BeltRecording) -> np.ndarray:
        """Acceleration of the frame (m/s²), shape (n,), from the measured force and moment."""
        return self._frame(self._seen(recording))[0]

    def shared_friction(self, other: BeltModel, recording: BeltRecording) -> np.ndarray | None:
        """Output of `belt_force` (N), shape (n,), if ``other`` has the same constants; else None."""
        same = isinstance(other, LinearFrame) and np.array_equal(self.constants, other.constants)
        return self.belt_force(recording) if same else None

    def belt_force(self, recording: BeltRecording) -> np.ndarray:
        """B (N), shape (n,)."""
        c, kg = self.named, recording.carried_kg
        total = c["belt_mass"] * recording.acceleration + c["viscous"] * recording.velocity
        for name in (*SPEEDS, *DISTANCES):
            if force := self._force(name, kg):
                total = total + force * _rubbing(recording, c["lag_s"], name)
        return total

    def _force(self, name: str, kg: float) -> float:
        """Force of one curve of friction (N) under a mass (kg)."""
        return self.named[name] + kg * self.named[f"{name}_per_kg"]

    def _moment(self, recording: BeltRecording, belt: np.ndarray) -> np.ndarray:
        c = self.named
        own = c["belt_moment"] * recording.acceleration + c["moment_viscous"] * recording.velocity
        return own + c["lever_m"] * belt

    def _frame(self, seen: dict) -> tuple[np.ndarray, np.ndarray]:
        """Accelerations u'' (m/s²) and phi'' (rad/s²)."""
        c, force, moment = self.named, seen["Fy", "twice"], seen["Mx", "twice"]
        return -c["sway"] * force - c["tilt"] * moment, -c["tilt"] * force - c["pitch"] * moment

    def _refuse(self, recording: BeltRecording, needed: bool) -> None:
        if needed:
            raise InputError(
                f"{recording.name}: expected force and moment of the plate together, found only the "
                f"{'force' if self.component == 'Fy' else 'moment'}: make both recordings of a trial at once"
            )

    def _seen(self, recording: BeltRecording) -> dict[tuple[str, str], np.ndarray]:
        """Measured loads through every response, each of shape (n,)."""
        self._refuse(recording, recording.beside is None)
        c = self.named

        def through() -> dict[tuple[str, str], np.ndarray]:
            own, beside = (self.component, *(load for load in COMPONENTS if load != self.component))
            loads = {own: recording.load + recording.carried, beside: recording.beside}
            s = 2j * np.pi * np.fft.rfftfreq(recording.load.size, 1.0 / recording.rate_hz)
            found = {}
            for load, x in loads.items():
                spectrum, line = over_line(x)
                for name, response in _responses(s, c).items():
                    found[load, name] = np.fft.irfft(response * spectrum, x.size)
                found[load, "same"] += line
            return found

        return recording.once(("seen", *(c[name] for name in OF_FRAME)), through)


def _rubbing(recording: BeltRecording, lag_s: float, name: str) -> np.ndarray:
    """One curve of friction in a trial, shape (n,), filtered like the recording."""

    def found() -> np.ndarray:
        pulses = recording.once("pulses", lambda: pulses_of(recording))
        w = pulses.velocity + lag_s * pulses.acceleration
        if name in SPEEDS:
            return held(recording, pulses, w / np.hypot(SPEEDS[name], w), np.zeros(pulses.start.shape))
        z, last = bent_in_turn(pulses, w, Bristles(DISTANCES[name], 0.0, 1.0))
        return held(recording, pulses, z, last)

    return recording.once(("rubbing", lag_s, name), found)


class Problem:
    """The mean pulses of all trials as spectra, and what is linear in the constants."""

    def __init__(self, windows: PulseWindows):
        self.windows = windows
        self._kg, self._height_m = windows.kg[:, None], windows.height_m[:, None]
        measured = np.array([windows.load[c] + windows.carried[c] for c in COMPONENTS])
        self.measured = np.fft.rfft(measured, axis=2)
        self.known = np.array([np.fft.rfft(windows.carried[c], axis=1) for c in COMPONENTS])
        self._moves = {
            "belt_mass": np.fft.rfft(windows.acceleration, axis=1),
            "viscous": np.fft.rfft(windows.velocity, axis=1),
        }
        self._rubbed: dict[float, dict[str, np.ndarray]] = {}

    def matrix(self, constants: np.ndarray) -> np.ndarray:
        """`_matrix` of every trial, shape (2, 2, trials, n // 2 + 1)."""
        return _matrix(constants, self.windows.s[None, :], self._kg, self._height_m)

    def _rubbing(self, lag_s: float) -> dict[str, np.ndarray]:
        """Spectra of the curves of friction, each of shape (trials, n // 2 + 1)."""
        if lag_s not in self._rubbed:
            windows = self.windows
            w = windows.fine_velocity + lag_s * windows.fine_acceleration
            found = {n: coarse_spectrum(windows, w / np.hypot(v, w)) for n, v in SPEEDS.items()}
            for name, distance_m in DISTANCES.items():
                z = mean_state(windows, w, Bristles(distance_m, 0.0, 1.0))
                found[name] = coarse_spectrum(windows, z)
            self._rubbed[lag_s] = {**found, **{f"{name}_per_kg": self._kg * x for name, x in found.items()}}
        return self._rubbed[lag_s]

    def _belt(self, lag_s: float) -> dict[str, np.ndarray]:
        return self._moves | self._rubbing(lag_s)

    def modelled(self, constants: np.ndarray) -> np.ndarray:
        """Spectra of the load that the model expects at the transducers, shape (2, trials, n // 2 + 1)."""
        c = dict(zip(CONSTANTS, constants.tolist(), strict=True))
        belt = sum(c[name] * x for name, x in self._belt(c["lag_s"]).items() if c[name])
        own = c["belt_moment"] * self._moves["belt_mass"] + c["moment_viscous"] * self._moves["viscous"]
        pushed = self.known + np.array([belt, own + c["lever_m"] * belt])
        return np.einsum("ij...,j...->i...", _inverse(self.matrix(constants)), pushed)

    def columns(self, constants: np.ndarray, loads: np.ndarray) -> np.ndarray:
        """Derivatives of the error of the true load by the constants, (c, 2, trials, n // 2 + 1).

        Those by constants that are searched for are 0.

        loads: spectra of force and moment at the transducers, as ``measured``.
        """
        c = dict(zip(CONSTANTS, constants.tolist(), strict=True))
        found = np.zeros((len(CONSTANTS), *self.known.shape), dtype=complex)
        responses = _responses(self.windows.s[None, :], c)
        for row, terms in enumerate((FORCE, MOMENT)):
            for name, (load, response, _) in terms.items():
                found[AT[name], row] = loads[COMPONENTS.index(load)] * responses[response]
        force, moment = self._kg * loads * responses["twice"]
        for name, back in (
            ("sway", force),
            ("tilt", moment - self._height_m * force),
            ("pitch", -self._height_m * moment),
        ):
            found[AT[name]] = back, -self._height_m * back
        total = 0.0
        for name, x in self._belt(c["lag_s"]).items():
            found[AT[name]] = -x, -c["lever_m"] * x
            total = total + c[name] * x
        found[AT["belt_moment"], 1], found[AT["moment_viscous"], 1] = (-x for x in self._moves.values())
        found[AT["lever_m"], 1] = -total
        return found


def residuals(windows: PulseWindows, constants: np.ndarray) -> dict[str, np.ndarray]:
    """Measured less modelled mean pulses: component -> residual (N, N·m), shape (trials, n)."""
    problem = Problem(windows)
    found = np.fft.irfft(problem.measured - problem.modelled(constants), windows.samples, axis=-1)
    return dict(zip(COMPONENTS, found, strict=True))


class _Fit(NamedTuple):
    """One variant."""

    constants: np.ndarray
    converged: bool
    left_out: Annotated[np.ndarray, "(trials,)"]
    """Share of each trial, left out, in the mean square error relative to the noise."""
    without_trial: np.ndarray
    """Change of the constants without each trial, shape (trials, c)."""
    spread: np.ndarray
    """Root of the covariance of the constants, shape (k, c)."""


class _Search:
    """Search for the constants of one variant."""

    def __init__(self, problem: Problem, weights: dict[str, float], terms: tuple[str, ...]):
        self.problem, self._weights = problem, np.array([weights[c] for c in COMPONENTS])
        absent = [name for term, names in TERMS.items() if term not in terms for name in names]
        self._free = np.array([name not in absent for name in CONSTANTS])
        self._linear = self._free & (np.arange(len(CONSTANTS)) >= len(SEARCHED))

    def _weighted(self, spectra: np.ndarray) -> np.ndarray:
        """Errors (k, 2, trials, n // 2 + 1) relative to the noise of the transducers, shape (k, 2 m)."""
        windows = self.problem.windows
        found = centred(windows, np.fft.irfft(spectra, windows.samples, axis=-1)) / self._weights[:, None]
        return found.reshape(len(found), -1)

    def convex(self, searched: tuple[float, ...]) -> tuple[float, np.ndarray]:
        """Cost and constants of the error of the true load, without friction's lever."""
        constants = np.where(self._linear, 0.0, MEAN)
        constants[: len(searched)] = searched
        columns = self.problem.columns(constants, self.problem.measured)
        error = np.einsum("k,k...->...", constants, columns) - self.problem.known
        used = np.flatnonzero(self._linear)
        found = self._weighted(np.concatenate([columns[used], error[None]]))
        step, cost = _least_squares(found[:-1], found[-1], used, constants)
        constants[used] += step
        return cost, constants

    def fit(self, starts: list[np.ndarray]) -> _Fit:
        """Constants after damped Gauss-Newton steps from the best of several starts, and their errors."""
        constants = min(starts, key=lambda start: self._linearised(start)[-1]) if starts[1:] else starts[0]
        used, (error, slopes, cost), ended = np.flatnonzero(self._free), self._linearised(constants), False
        damped = 0.0
        for _ in range(MOST):
            step, expected = _least_squares(slopes, error, used, constants, damped)
            held = self._outwards(constants, used, step)
            if held.any():
                step = np.zeros(used.size)
                step[~held], expected = _least_squares(slopes[~held], error, used[~held], constants, damped)
            ended = bool(damped == 0.0 and cost - expected < ENOUGH * cost)
            tried = constants.copy()
            tried[used] += step
            tried[: len(SEARCHED)] = np.clip(tried[: len(SEARCHED)], *LIMITS.T)
            following = self._linearised(tried)
            if better := following[-1] < cost:
                ended |= damped <= SMALL and cost - following[-1] < ENOUGH * cost
                constants, (error, slopes, cost) = tried, following
            if ended:
                break
            damped = (0.1 * damped if damped > LEAST else 0.0) if better else max(10.0 * damped, LEAST)
        # neither a frame without damping nor mounts without relaxation are faults
        inside = bool(np.abs(constants[[AT["lead_s"], AT["lag_s"]], None] - LIMITS[[0, 4]]).min() > 0.0)
        windows, rows = self.problem.windows, slopes * SD[used, None]
        trial = np.repeat(np.arange(windows.kg.size), windows.evaluated.sum(axis=1))
        trial = np.tile(trial, len(COMPONENTS))
        left_out, *found = leave_out(-rows.T, error, trial, np.ones(used.size))
        # what the trials leave open is known by its prior only
        unknown = np.linalg.inv(rows @ rows.T + np.eye(used.size))
        changes, spread = (
            np.zeros((windows.kg.size, SD.size)),
            np.zeros((windows.kg.size + used.size, SD.size)),
        )
        changes[:, used] = found[0] * SD[used]
        spread[:, used] = np.concatenate([found[1], unknown]) * SD[used]
        return _Fit(constants, ended and inside, left_out, changes, spread)

    def _outwards(self, constants: np.ndarray, used: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Test of every used constant for a step beyond the limit at which it is."""
        low, high = np.tile([[-np.inf], [np.inf]], SD.size)
        low[: len(SEARCHED)], high[: len(SEARCHED)] = LIMITS.T
        x = constants[used]
        return ((x <= low[used]) & (step < 0.0)) | ((x >= high[used]) & (step > 0.0))

    def _linearised(self, constants: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """Error relative to the noise, its derivatives, and the cost with the priors."""
        problem = self.problem
        modelled, inverse = problem.modelled(constants), _inverse(problem.matrix(constants))
        columns = np.einsum("ij...,kj...->ki...", inverse, problem.columns(constants, modelled))
        for k, size in enumerate(STEPS):
            step = np.zeros(len(CONSTANTS))
            step[k] = size
            columns[k] = (modelled - problem.modelled(constants + step)) / size
        found = self._weighted(np.concatenate([columns[self._free], (problem.measured - modelled)[None]]))
        weak = (constants - MEAN)[self._free] / SD[self._free]
        return found[-1], found[:-1], float(found[-1] @ found[-1] + weak @ weak)


def _least_squares(
    slopes: np.ndarray, error: np.ndarray, used: np.ndarray, constants: np.ndarray, damped: float = 0.0
) -> tuple[np.ndarray, float]:
    """Step of the used constants from an error and its derivatives, shape (c, m), and the cost behind it.

    damped: damping of the step (Marquardt 1963).
    """
    rows, weak = slopes * SD[used, None], (MEAN - constants)[used] / SD[used]
    normal = rows @ rows.T
    step = np.linalg.solve(normal + np.diag(1.0 + damped * np.diag(normal)), weak - rows @ error)
    return step * SD[used], float(np.sum((error + step @ rows) ** 2) + np.sum((weak - step) ** 2))


def fit_linear_frame(
    trials: list[dict[str, BeltRecording]],
    draws: int,
    rng: np.random.Generator,
    like: Calibrated | None = None,
) -> Calibrated:
    """Fit all trials together.

    trials: for each calibration trial component Fy or Mx -> recording, with two masses or more.
    draws: number of draws of the errors of the constants.
    like: fit of the same trials with another filter, whose terms are kept.
    """
    windows = pulse_windows(left_out_in_turn(trials))
    weights, problem, heaviest_kg = noise_weights(windows), Problem(windows), heaviest(windows)
    variants = [terms for size in range(len(TERMS) + 1) for terms in itertools.combinations(TERMS, size)]
    variants = variants if like is None else [like.models["Fy"].terms]
    scan = _Search(problem, weights, tuple(TERMS))
    if like is None:
        searched = min(itertools.product(*SCANNED), key=lambda tried: scan.convex(tried)[0])
    fits: dict[tuple[str, ...], _Fit] = {}
    for terms in variants:
        search = _Search(problem, weights, terms)
        starts = [search.convex(searched)[1]] if like is None else [like.models["Fy"].constants]
        starts += [fit.constants for smaller, fit in fits.items() if set(smaller) < set(terms)]
        fits[terms] = search.fit(starts)
    terms = min(fits, key=lambda terms: float(fits[terms].left_out.sum()))
    constants, converged, _, without_trial, _ = fits[terms]
    scores = {"+".join(c) or PLAIN: float(np.sqrt(fit.left_out.sum())) for c, fit in fits.items()}
    deviations = _drawn(list(fits.values()), constants, draws, rng)
    models = {
        c: LinearFrame(c, constants, terms, windows.rate_hz, heaviest_kg, converged) for c in COMPONENTS
    }
    return Calibrated(models, residuals, deviations, without_trial, scores, min(scores.values()))


def _drawn(
    fits: list[_Fit], chosen: np.ndarray, draws: int, rng: np.random.Generator
) -> Annotated[np.ndarray, "(draws, c)"]:
    """Errors of the chosen constants, drawn with the variant that random weights of the trials prefer."""
    squares = np.array([fit.left_out for fit in fits])
    preferred = np.argmin(rng.standard_exponential((draws, squares.shape[1])) @ squares.T, axis=1)
    found = np.empty((draws, chosen.size))
    for row, k, sign in zip(found, preferred.tolist(), rng.choice([-1.0, 1.0], draws).tolist(), strict=True):
        spread = fits[k].spread
        row[:] = sign * (fits[k].constants - chosen) + rng.standard_normal(len(spread)) @ spread
    return found
