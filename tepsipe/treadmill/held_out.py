"""Gate of a treadmill model: the effect of its error on I, B and K.

R2 does not show whether a model is good enough: 0.998 is compatible with a wrong stiffness. What counts is
the error of the torque, e = M_x + l F_y of the residuals, with the lever l of the joint, as far as it looks
like the joint's own motion. The residual of trials that the fit has not seen, with the pulses of the subject
and near its mass, is regressed on the subject's own motion,

    e(t) = dI theta'' + dB theta' + dK theta (+ constant),

which is the error that the compensated estimates inherit. Noise of the cameras in that motion would make the
error look smaller than it is (errors in variables): where the motion of the belt is known, it serves as
instrument. Residuals of calibration trials come from a fit
without that trial. The gate does not detect the state of friction before a pulse, nor wrong geometry.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.io.result import Result
from tepsipe.treadmill.bristle_fit import COMPONENTS, Calibrated, left_out_in_turn
from tepsipe.treadmill.bristle_frame import BristleFrame
from tepsipe.treadmill.frame_peak import FramePeak
from tepsipe.treadmill.linear_frame import LinearFrame
from tepsipe.treadmill.mass_models import MassResponse
from tepsipe.treadmill.plate_check import PlateCheck
from tepsipe.treadmill.pulse_windows import (
    BEFORE_S,
    PulseWindows,
    by_direction,
    longest_window,
    pulse_windows,
)
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.registry import FittedModel

# largest predicted error of K that is trusted, with two standard errors, relative to K
TRUSTED = 0.1
# largest mass of a subject relative to the heaviest weight of the calibration
BEYOND = 1.1
# trials whose pulses differ from the subject's by this much more than the most similar ones also count
ALIKE = 0.05
ALIGNMENTS = 4
UNITS = {"Fy": "N", "Mx": "Nm"}
# factor, and excess, by which the unexplained part of a model exceeds its limit
TIMES, MORE = 2.0, 0.02
# standard error of a model that falls below its limit
UNKNOWN = 1e9
# standard errors that a normal deviate exceeds once in 20 times, on one side
ONE_SIDED = 1.645


@dataclass(frozen=True)
class HeldOut:
    """Residuals of trials held out of a model's fit."""

    rate_hz: float
    before_s: float
    after_s: float
    """Sampling rate (Hz), and time of a window before and after the onset of its pulse (s)."""
    names: tuple[str, ...]
    """The trials."""
    kg: Annotated[np.ndarray, "(trials,)", "kg"]
    """Mass on the belt."""
    velocity: Annotated[np.ndarray, "(trials, n)", "m/s"]
    """Mean velocity of the belt."""
    residual: dict[str, list[np.ndarray]]
    """Component -> measured less modelled load of every pulse, trial by trial (N, N·m), shape (pulses, n)."""
    refit: dict[str, np.ndarray]
    """Component -> change of the residuals by a fit to all trials (N, N·m), shape (trials, n)."""
    below_limit_kg: tuple[float, ...]
    """Masses at which R2 of the model falls clearly below its limit (kg), see `below_limit`."""
    converged: bool = True
    """Whether the search for the model's constants converged inside its bounds."""
    calibration: np.ndarray | None = None
    """Calibration of the plate in the recordings of weight and empty belt."""
    plate_flags: tuple[str, ...] = ()
    """Names, in `tepsipe.flags.FLAGS`, of faults of the plate that resting weights show."""
    model: str | None = None
    """Name of the model."""
    empty_frame: FramePeak | None = None
    """Resonance of the empty belt."""

    def of(self, models: Mapping[str, FittedModel]) -> bool:
        """Test for residuals of the model of a plate, given by component of the load."""
        return any(model.name == self.model for model in models.values())

    @property
    def failed(self) -> str:
        """Name of the flag, in `FLAGS`, of what the model errs by too much."""
        return "treadmill-model" if self.converged else "treadmill-not-converged"


@dataclass(frozen=True)
class Subject:
    """Mass, lever and motion of the subject, for the gate."""

    mass_kg: float
    """Mass on the belt."""
    lever_m: float
    """Height of the joint over the belt l."""
    velocity: Annotated[np.ndarray, "(m,)", "m/s"]
    """Mean velocity of the belt from the onset of the pulses."""
    regressors: Annotated[np.ndarray, "(m, p)"]
    """Mean theta'' (rad/s²), theta' (rad/s), theta (rad) over the window of the estimate, from the onset;
    without theta'' for an estimator without inertia."""
    rate_hz: float
    own_zero: bool
    """Whether the estimator has a free constant torque in every window."""
    instruments: Annotated[np.ndarray, "(m, p)"] | None = None
    """Signals that resemble the regressors without noise of the cameras; the regressors if left out."""


@dataclass(frozen=True)
class PredictedError:
    """Error of the parameters due to the treadmill model."""

    parameters: Annotated[np.ndarray, "(p,)"]
    standard_error: Annotated[np.ndarray, "(p,)"]
    """dI (N·m·s²/rad), dB (N·m·s/rad), dK (N·m/rad), and their standard errors over the pulses; without dI
    for an estimator without inertia. The latter are `UNKNOWN` where R2 falls below its limit."""
    trials: tuple[str, ...]
    """The held-out trials that were used."""
    difference: float
    """Root mean square difference between their pulses and the subject's, relative to the latter."""

    def trusted(self, stiffness: float) -> bool:
        """Test for |dK| plus two standard errors below a tenth of K (N·m/rad)."""
        return trusted(float(self.parameters[-1]), float(self.standard_error[-1]), stiffness)


def trusted(error: float, standard_error: float, stiffness: float) -> bool:
    """Test for an error of K plus two standard errors below a tenth of K (all in N·m/rad)."""
    return abs(error) + 2.0 * standard_error <= TRUSTED * abs(stiffness)


def clearly_wrong(error: float, standard_error: float, stiffness: float, share: float = TRUSTED) -> bool:
    """Test for an error of K (N·m/rad) that is unknown, or exceeds a share of K at 95 %."""
    return standard_error >= UNKNOWN or abs(error) - ONE_SIDED * standard_error > share * abs(stiffness)


def below_limit(r2: float, limit: float) -> bool:
    """Test for R2 of a model clearly below its upper limit for linear models."""
    return bool(1.0 - r2 > TIMES * (1.0 - limit) + MORE)


def held_out_residuals(
    calibrated: Calibrated | None,
    training: list[dict[str, BeltRecording]],
    testing: list[dict[str, BeltRecording]],
    below_limit_kg: Sequence[float] = (),
) -> Result:
    """Residuals of all trials, each from a model fitted without it.

    calibrated: the fit of the training trials; without one there are no residuals.
    training, testing: for each trial component -> recording.
    below_limit_kg: masses at which R2 falls clearly below its limit.
    """
    if calibrated is None:
        return Result({}, {}, {"trials": []})
    constants = calibrated.models["Fy"].constants
    signals: dict[str, tuple[np.ndarray, str]] = {}
    after_s = min(longest_window(trial["Fy"]) for trial in (*training, *testing))
    facts: dict = {"trials": [], "kg": [], "before_s": BEFORE_S, "after_s": after_s}
    facts["below_limit_kg"] = list(below_limit_kg)
    facts["converged"] = all(model.converged for model in calibrated.models.values())

    def keep(
        windows: PulseWindows,
        k: int,
        residual: dict[str, np.ndarray],
        of_all: dict[str, np.ndarray],
        free: dict[str, MassResponse],
    ) -> None:
        residual = {c: r - free[c].in_windows(windows) if free else r for c, r in residual.items()}
        name = windows.names[k]
        facts["trials"].append(name)
        facts["kg"].append(float(windows.kg[k]))
        facts["rate_hz"] = windows.rate_hz
        part = slice(0, round((BEFORE_S + after_s) * windows.rate_hz))
        signals[f"{name}/velocity"] = (windows.velocity[k, part], "m/s")
        for c in COMPONENTS:
            single = windows.single[c][k] - windows.load[c][k] + residual[c][k]
            signals[f"{name}/{c}"] = (single[:, part].astype(np.float32), UNITS[c])
            refit = of_all[c][k, part] - residual[c][k, part]
            signals[f"{name}/refit_{c}"] = (refit.astype(np.float32), UNITS[c])

    whole = {c: m.by_mass for c, m in calibrated.models.items()} if calibrated.by_mass else {}

    def of_all(windows: PulseWindows) -> dict[str, np.ndarray]:
        residual = calibrated.residuals(windows, constants)
        return {c: r - whole[c].in_windows(windows) if whole else r for c, r in residual.items()}

    windows = pulse_windows(left_out_in_turn(training), whole=True)
    fitted = of_all(windows)
    for k, change in enumerate(calibrated.without_trial):
        free = calibrated.by_mass[k] if calibrated.by_mass else {}
        keep(windows, k, calibrated.residuals(windows, constants + change), fitted, free)
    if testing:
        windows = pulse_windows(by_direction(testing), whole=True)
        fitted = of_all(windows)
        for k in range(windows.kg.size):
            keep(windows, k, fitted, fitted, {})
    return Result.of(signals, facts)


def read_held_out(result: Result) -> HeldOut | None:
    """Residuals from a result of `held_out_residuals`, None if there are none."""
    names, plate = tuple(result.facts["trials"]), PlateCheck.from_result(result)
    if not names:
        return None
    return HeldOut(
        rate_hz=float(result.facts["rate_hz"]),
        before_s=float(result.facts["before_s"]),
        after_s=float(result.facts["after_s"]),
        names=names,
        kg=np.array(result.facts["kg"], dtype=float),
        velocity=np.array([result.arrays[f"{name}/velocity"] for name in names]),
        residual={c: [np.asarray(result.arrays[f"{n}/{c}"], dtype=float) for n in names] for c in COMPONENTS},
        refit={
            c: np.array([result.arrays[f"{n}/refit_{c}"] for n in names], dtype=float) for c in COMPONENTS
        },
        below_limit_kg=tuple(result.facts["below_limit_kg"]),
        converged=bool(result.facts["converged"]),
        calibration=plate.calibration,
        plate_flags=(*plate.flags, *plate.faults),
        model=result.facts.get("model"),
        empty_frame=FramePeak(*result.facts["empty_frame"]) if "empty_frame" in result.facts else None,
    )


def predicted_error(held_out: HeldOut, subject: Subject) -> PredictedError:
    """Error of the subject's I, B, K predicted from the treadmill model's held-out residuals.

    Between the masses of two groups of trials the prediction is interpolated. The residual of a pulse in the
    opposite direction counts with the opposite sign. After the window of the residuals their last value is
    held.

    subject: mass, motion and lever of the subject.
    Returns: error of the compensated estimates.
    """
    if abs(held_out.rate_hz - subject.rate_hz) > 1e-6 * held_out.rate_hz:
        raise InputError(
            f"expected the subject at {held_out.rate_hz:g} Hz, the rate of the treadmill's calibration, "
            f"found {subject.rate_hz:g} Hz: resample one of the two"
        )
    solve, p = _parameters_of_torque(subject), subject.regressors.shape[1]
    total, variance, used, differences = np.zeros(p), np.zeros(p), [], []
    window = np.arange(subject.regressors.shape[0])
    for weight, kg in _masses(held_out.kg, subject.mass_kg):
        rows = np.flatnonzero(held_out.kg == kg)
        signs, delays, distance = _compare(held_out, rows, subject)
        near = np.flatnonzero(distance <= distance.min() + ALIKE)
        means, errors = [], []
        for k in near:
            torque = _torque_errors(held_out, rows[k], subject.lever_m, delays[k] + window)
            deviations = signs[k] * torque @ solve.T
            means.append(deviations.mean(axis=0))
            count = deviations.shape[0]
            errors.append(deviations.var(axis=0, ddof=1) / count if count > 1 else np.full(p, np.inf))
        total += weight * np.mean(means, axis=0)
        variance += weight**2 * np.mean(errors, axis=0) / near.size
        if kg in held_out.below_limit_kg:
            variance += UNKNOWN**2
        used += [held_out.names[rows[k]] for k in near]
        differences.append(float(distance.min()))
    return PredictedError(total, np.sqrt(variance), tuple(used), max(differences))


def _parameters_of_torque(subject: Subject) -> np.ndarray:
    """Matrix from a torque in the subject's window (N·m) to its dI, dB, dK, shape (p, m)."""
    columns, p = subject.regressors, subject.regressors.shape[1]
    instruments = columns if subject.instruments is None else subject.instruments
    if subject.own_zero:
        columns, instruments = (np.column_stack([x, np.ones(len(x))]) for x in (columns, instruments))
    size, of_instruments = (np.maximum(np.linalg.norm(x, axis=0), 1e-300) for x in (columns, instruments))
    instruments = instruments / of_instruments
    return (np.linalg.pinv(instruments.T @ (columns / size)) @ instruments.T / size[:, None])[:p]


def _masses(known: np.ndarray, mass_kg: float) -> list[tuple[float, float]]:
    """(weight, mass in kg) of the groups of trials on both sides of the subject's mass, or of the nearest."""
    masses = np.unique(known)
    above = int(np.searchsorted(masses, mass_kg))
    if above in (0, masses.size):
        return [(1.0, float(masses[min(above, masses.size - 1)]))]
    low, high = masses[above - 1], masses[above]
    share = float((mass_kg - low) / (high - low))
    return [(w, float(m)) for w, m in ((1.0 - share, low), (share, high)) if w > 0.0]


def _compare(
    held_out: HeldOut, rows: np.ndarray, subject: Subject
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Signs, delays (samples) and relative differences of some trials' pulses from the subject's, (rows,)."""
    onset = round(held_out.before_s * held_out.rate_hz)
    length = min(subject.velocity.size, held_out.velocity.shape[1] - onset, round(0.3 * held_out.rate_hz))
    velocity_of_subject = subject.velocity[:length]
    norm = max(float(np.linalg.norm(velocity_of_subject)), 1e-300)
    at = onset + np.arange(length)
    matches = []
    for velocity in held_out.velocity[rows]:
        sign = 1.0 if velocity_of_subject @ velocity[at] >= 0.0 else -1.0
        delay = 0.0
        for _ in range(ALIGNMENTS):  # onsets are samples, and belts under other loads begin otherwise
            shifted = sign * np.interp(at + delay, np.arange(velocity.size), velocity)
            slope = np.gradient(shifted)
            delay += float((velocity_of_subject - shifted) @ slope / max(float(slope @ slope), 1e-300))
            delay = float(np.clip(delay, -onset / 4, onset / 4))
        shifted = sign * np.interp(at + delay, np.arange(velocity.size), velocity)
        matches.append((sign, delay, float(np.linalg.norm(shifted - velocity_of_subject)) / norm))
    signs, delays, difference = np.array(matches).T
    return signs, delays, difference


def misfit(
    held_out: HeldOut, subject: Subject, time: Annotated[np.ndarray, "(n,)", "s"]
) -> Annotated[np.ndarray, "(1 + k, n)", "N·m"]:
    """Torque that a model leaves in pulses like the subject's under a weight, and k rows of its error.

    The model is fitted to all trials: the errors of its constants are another source. Masses and trials count
    as in `predicted_error`. The sum of squares of the k rows is the variance of the first row.

    time: regular instants from the onset.
    """
    at, mean, rows_of_error = time * held_out.rate_hz, np.zeros(time.size), []
    for weight, kg in _masses(held_out.kg, subject.mass_kg):
        rows = np.flatnonzero(held_out.kg == kg)
        signs, delays, distance = _compare(held_out, rows, subject)
        near = np.flatnonzero(distance <= distance.min() + ALIKE)
        for k in near:
            torque = _torque_errors(held_out, rows[k], subject.lever_m, delays[k] + at, refit=True)
            own, count = weight * signs[k] / near.size * torque, len(torque)
            mean += own.mean(axis=0)
            rows_of_error.append((own - own.mean(axis=0)) / np.sqrt(max(count * (count - 1.0), 1.0)))
    return np.concatenate([mean[None], *rows_of_error])


def _torque_errors(
    held_out: HeldOut, k: int, lever_m: float, samples: np.ndarray, *, refit: bool = False
) -> np.ndarray:
    """Residual torque of every pulse of a trial at samples from its onset (N·m), shape (pulses, m).

    refit: whether the model is fitted to all trials, not to the others only.
    """
    force, moment = (held_out.residual[c][k] + (held_out.refit[c][k] if refit else 0.0) for c in ("Fy", "Mx"))
    error = moment + lever_m * force
    onset, rate = round(held_out.before_s * held_out.rate_hz), held_out.rate_hz
    error = error - error[:, : round(0.8 * onset)].mean(axis=1, keepdims=True)
    last = round((held_out.before_s + held_out.after_s) * rate) - 2  # beyond it the window returns to zero
    at = np.clip(onset + samples, 0, last)
    low = np.floor(at).astype(int)
    errors = error[:, low] + (at - low) * (error[:, np.minimum(low + 1, last)] - error[:, low])
    if onset + samples[-1] + 1 > last:
        errors[:, at >= last] = error[:, last - round(0.2 * rate) : last].mean(axis=1, keepdims=True)
    return errors


def model_flags(model: BristleFrame | LinearFrame, mass_kg: float) -> list[str]:
    """Flags of estimates that a model compensates for a subject of some mass (kg): names in `FLAGS`.

    ``beyond-calibrated-mass`` where the mass exceeds the heaviest weight by more than a tenth,
    where a constant is outside the plausible range of a treadmill ``treadmill-model``, or
    ``treadmill-not-converged`` if the search for the constants did not converge.
    """
    flags = []
    if mass_kg > BEYOND * model.heaviest_kg:
        flags.append("beyond-calibrated-mass")
    if not model.plausible(mass_kg):
        flags.append("treadmill-model" if model.converged else "treadmill-not-converged")
    return flags
