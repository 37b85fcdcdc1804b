"""Epochs for the estimator with a free reflex torque, and their change with each source of uncertainty.

The mean responses change in proportion to each uncertain constant. One slope per source and trial is
therefore kept, and the trials of a task can be refitted for any deviation without their recordings.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated

import numpy as np
import scipy

from tepsipe.experiments.standing.epochs import StandingEpochs, quiet_onsets
from tepsipe.experiments.standing.free_reflex.free_body import (
    SOURCES,
    FreeBody,
    JointCentre,
    centre_from_pulses,
    centre_from_sway,
    free_body,
    relative_motion,
    rotation_per_place,
    tissue_frequencies,
    tissue_from_pulses,
    tissue_motion,
)
from tepsipe.experiments.standing.joint_torque import StandingTrial, by_belt
from tepsipe.experiments.standing.options import BOTH, EpochOptions, StandingOptions
from tepsipe.io.result import Result
from tepsipe.signals.epochs import between, cut_epochs
from tepsipe.signals.filters import Lowpass
from tepsipe.treadmill.frame_peak import FramePeak, frame_peak
from tepsipe.treadmill.held_out import HeldOut, Subject, misfit, predicted_error
from tepsipe.treadmill.registry import FittedModel

# length of an epoch after its onset (s), beyond which no window of the estimator reaches
AFTER_S = 0.2
# start of an epoch before its baseline (s)
MARGIN_S = 0.02
# responses within which the apparent centre of the joint is sought (s)
PULSE_S = (-0.02, 0.1)
# step of the sources for their slopes
STEP = 1e-3
# usable centre: largest share of the foot's rotation in the ankle's, largest standard error (m)
FOOT_SHARE, CENTRE_ERROR_M = 0.3, 0.002
# largest distance of a usable centre from the palpated one (m)
FAR_M = 0.03
# rotations of the hindfoot over the assumed one, beside 1, at which centre and soft tissue are found
OTHER_ROTATIONS = (0.6, 1.4)


@dataclass(frozen=True)
class BroadbandEpochs:
    """Responses of one trial."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    """Time from the onset."""
    perturbed: Annotated[np.ndarray, "(responses, n, 3)"]
    """Torque (N·m), ankle angle (rad) and its rate (rad/s), relative to their mean in the baseline."""
    quiet_time: Annotated[np.ndarray, "(m,)", "s"]
    """Time in an unperturbed epoch."""
    quiet: Annotated[np.ndarray, "(epochs, m, 3)"]
    """The same signals in quiet standing."""
    slopes: dict[str, np.ndarray]
    """Source -> change of the mean responses per unit of the source, relative to the baseline, shape (n,
    3)."""
    draws: Annotated[np.ndarray, "(draws, n)", "N·m"]
    """Torque of the mean response by every draw of the treadmill model, relative to the best."""
    belt: Annotated[np.ndarray, "(n, 2)"]
    """Velocity (m/s) and displacement (m) of the belt in the mean response, relative to their mean in the
    baseline."""
    baseline_s: tuple[float, float]
    """Start and end of the baseline, from the onset."""
    cutoff_hz: float
    order: int
    """Cutoff (Hz) and order of the zero-lag low-pass of all signals."""
    peak_m_per_s: float
    """Largest speed of the belt, median over responses."""
    carried_kg: float
    """Mass on the belt."""
    calibrated_kg: float | None
    """Largest mass with which the treadmill model was calibrated (kg); None if it says none."""
    centre: JointCentre | None
    """Centre of the joint from quiet sway (m)."""
    centre_used: bool
    """Whether the torque refers to that centre, not to the assumed one."""
    apparent: JointCentre | None
    """Apparent centre from the responses (m)."""
    skin_m: float
    """Motion of the soft tissue over the bone at a pulse of 0.5 m/s, which quiet sway has not (m); 0 where
    it is not known."""
    treadmill_error: tuple[float, float] | None = None
    """Error of K that held-out trials of the treadmill predict, and its standard error (N·m/rad)."""
    misfit: Annotated[np.ndarray, "(1 + k, n)", "N·m"] | None = None
    """From `tepsipe.treadmill.held_out.misfit`; None where no trial of the treadmill shows it."""
    treadmill_flag: str = "treadmill-model"
    """Name of the flag, in `tepsipe.flags.FLAGS`, if this error is too large."""
    origin_known: bool = True
    """Whether weights showed the origin of the force plate along the belt."""
    plate_flags: tuple[str, ...] = ()
    """Names of faults of the plate, in `tepsipe.flags.FLAGS`."""
    frame: FramePeak | None = None
    empty_frame: FramePeak | None = None
    """Resonance of the frame below the person in all pulses of the trial, and of the empty belt; None for a
    person on two belts, or where it is not known."""
    recording: str = ""
    """Name of the trial, which the epochs of both directions of its perturbations share; empty for epochs
    that share nothing with others."""
    tilt: Annotated[np.ndarray, "(responses, n, 4)"] | None = None
    quiet_tilt: Annotated[np.ndarray, "(epochs, m, 4)"] | None = None
    """Rotation of the foot, from `FreeBody.tilt`, relative to the baseline like ``perturbed`` and ``quiet``;
    None where it is not known."""
    rotation_per_m: float | None = None
    """From `rotation_per_place` (1/m)."""
    turned: tuple[tuple[JointCentre | None, float], ...] = ()
    """``centre`` and ``skin_m`` at each of `OTHER_ROTATIONS`."""

    @property
    def count(self) -> int:
        """Number of responses."""
        return self.perturbed.shape[0]

    @property
    def baseline(self) -> np.ndarray:
        """True for samples of the baseline, shape (n,)."""
        return between(self.time, *self.baseline_s)

    @cached_property
    def _stretches(self) -> dict[tuple[int, int], np.ndarray]:
        return {}

    def quiet_stretches(self, first: int, last: int, step: int) -> np.ndarray:
        """Stretches of quiet standing, shape (m, last + 1 - first, 3), every ``step`` samples.

        Each is as long as samples ``first`` to ``last`` of an epoch. Its baseline is as long as that of the
        responses and as far before it, so its moments are those of sway and noise in the responses. The
        stretches are cut once for a window, in which many onsets of reflexes are tried.
        """
        if (first, last) not in self._stretches:
            zero = np.flatnonzero(self.baseline)
            start = min(first, int(zero[0]))
            pieces = np.lib.stride_tricks.sliding_window_view(self.quiet, last + 1 - start, axis=1)
            # pieces with the same start are adjacent: start, epoch, time, signal
            pieces = np.moveaxis(pieces[:, ::step], (1, 3), (0, 2))
            still = pieces[:, :, zero - start].mean(axis=2, keepdims=True)
            stretches = (pieces[:, :, first - start :] - still).reshape(-1, last + 1 - first, 3)
            self._stretches[first, last] = stretches
        return self._stretches[first, last]


def by_recording(epochs: Sequence[BroadbandEpochs]) -> list[list[int]]:
    """Positions of the epochs of each recording: two where its perturbations have both directions."""
    found: dict[object, list[int]] = {}
    for k, trial in enumerate(epochs):
        found.setdefault(trial.recording or k, []).append(k)
    return list(found.values())


def cut_broadband(
    standing: StandingTrial,
    epochs: StandingEpochs,
    options: StandingOptions,
    cutting: EpochOptions,
    lowpass: Lowpass,
    models: dict[str, FittedModel],
) -> BroadbandEpochs | None:
    """Epochs of the same perturbations as ``epochs``, with their own filter.

    standing: the trial with the filter of all signals.
    epochs: its epochs: their onsets are used.
    lowpass: filter of all signals here; its cutoff is lowered if the cameras are too slow for it.
    models: component, Fy or Mx -> treadmill model; empty for the loads as measured. For a person with a
    foot on each belt: belt -> the same.
    Returns: none if no perturbation of the trial is usable.
    """
    if not epochs.count:
        return None
    lowpass = lowpass.within(standing.prepared.rate_hz)
    centres = [
        centre_from_sway(standing.trial, options.person, standing.unperturbed, standing.hidden, rotation)
        for rotation in (1.0, *OTHER_ROTATIONS)
    ]
    centre = centres[0]
    used = centre is not None and _usable(centre)
    offset = centre.offset_m if centre is not None and used else np.zeros(2)
    body = free_body(standing, options, lowpass, models, offset)
    start, rate = float(standing.time[0]), standing.prepared.rate_hz
    before = -cutting.baseline_s[0] + MARGIN_S

    def cut(x: np.ndarray, at: np.ndarray, after: float):
        pieces = cut_epochs(x, rate, at, before, after, start)
        zero = between(pieces.time, *cutting.baseline_s)
        return pieces.time, pieces.values - pieces.values[:, zero].mean(axis=1, keepdims=True)

    apparent, skins_m, turned = _pulses(standing, epochs.onsets_s, options, lowpass, body.surface_dd, centres)
    body = replace(body, skins_m=skins_m)
    best, still = np.column_stack([body.signals(), body.tilt()]), quiet_onsets(standing, cutting)
    quiet_time, quiet = cut(best, still, cutting.after_s)
    time, perturbed = cut(best, epochs.onsets_s, AFTER_S)
    velocity = cut(standing.prepared.behind(lowpass).belt_velocity, epochs.onsets_s, AFTER_S)[1]
    changes = {
        source: (body.signals({source: STEP}) - body.signals({source: -STEP})) / (2.0 * STEP)
        for source in SOURCES
    }
    slopes = cut(np.column_stack(list(changes.values())), epochs.onsets_s, AFTER_S)[1].mean(axis=0)
    carried_kg = float(body.load.f_z[standing.unperturbed].mean()) / options.person.body.gravity_m_per_s2
    return BroadbandEpochs(
        time=time,
        perturbed=perturbed[..., :3],
        quiet_time=quiet_time,
        quiet=quiet[..., :3],
        slopes={source: slopes[:, 3 * k : 3 * k + 3] for k, source in enumerate(SOURCES)},
        draws=_mean_draws(body, epochs.onsets_s, time, cutting.baseline_s),
        belt=_belt(time, velocity.mean(axis=0), cutting.baseline_s),
        baseline_s=cutting.baseline_s,
        cutoff_hz=lowpass.cutoff_hz,
        order=lowpass.order,
        peak_m_per_s=float(np.median(np.abs(epochs.perturbed["belt_velocity"]).max(axis=1))),
        carried_kg=carried_kg,
        calibrated_kg=_calibrated_kg(standing, options, by_belt(models, options), carried_kg),
        centre=centre,
        centre_used=used,
        apparent=apparent,
        skin_m=skins_m[0],
        origin_known=standing.plate.origin_known,
        plate_flags=standing.plate_flags,
        frame=None if options.belt == BOTH else frame_peak([standing.prepared], options.belt),
        recording=standing.prepared.name,
        tilt=perturbed[..., 3:],
        quiet_tilt=quiet[..., 3:],
        rotation_per_m=rotation_per_place(options.person),
        turned=turned,
    )


def _calibrated_kg(
    standing: StandingTrial, options: StandingOptions, models: dict[str, dict], carried_kg: float
) -> float | None:
    """Largest mass of the calibration (kg), with the present shares of two plates; None if it says none."""
    found = []
    for belt, of_belt in models.items():
        masses = [getattr(model.model, "heaviest_kg", None) for model in of_belt.values()]
        heaviest = [mass for mass in masses if mass is not None]
        if heaviest and belt == options.belt:
            return max(heaviest)
        if heaviest:
            weight = float(standing.prepared.load(belt)["Fz"][standing.unperturbed].mean())
            found.append(max(heaviest) * carried_kg * options.person.body.gravity_m_per_s2 / weight)
    return min(found, default=None)


def with_treadmill_error(
    broadband: BroadbandEpochs,
    epochs: StandingEpochs,
    held_out: HeldOut,
    ankle_height_m: float,
    window_s: float,
) -> BroadbandEpochs:
    """Epochs with the error of K predicted by held-out trials of the treadmill (N·m/rad), and its resonance.

    broadband, epochs: the same responses with both filters.
    held_out: residuals of trials that the treadmill model has not seen.
    ankle_height_m, window_s: height of the ankle above the belt (m), and length of the fitted window (s).
    """
    rate = 1.0 / float(np.diff(broadband.time).mean())
    fitted = (broadband.time > -0.5 / rate) & (broadband.time <= window_s + 0.5 / rate)
    motion = broadband.perturbed.mean(axis=0)[fitted]
    velocity = epochs.perturbed["belt_velocity"].mean(axis=0)[epochs.time > -0.5 / rate]
    subject = Subject(
        mass_kg=broadband.carried_kg,
        lever_m=ankle_height_m,
        velocity=velocity,
        regressors=motion[:, [2, 1]],
        rate_hz=rate,
        own_zero=False,
        instruments=broadband.belt[fitted],
    )
    error = predicted_error(held_out, subject)
    found = float(error.parameters[-1]), float(error.standard_error[-1])
    return replace(
        broadband,
        treadmill_error=found,
        misfit=misfit(held_out, subject, broadband.time),
        treadmill_flag=held_out.failed,
        empty_frame=held_out.empty_frame,
    )


def _usable(centre: JointCentre) -> bool:
    """Test for a joint centre that is precise, near the palpated one, and over a foot that stands still."""
    return bool(
        centre.foot_rad < FOOT_SHARE * centre.sway_rad
        and centre.standard_error_m.max() < CENTRE_ERROR_M
        and np.hypot(*centre.offset_m) < FAR_M
    )


def _belt(time: np.ndarray, velocity: np.ndarray, baseline_s: tuple[float, float]) -> np.ndarray:
    """Velocity (m/s) and displacement (m) of the belt, relative to the baseline, shape (n, 2)."""
    belt = np.column_stack([velocity, scipy.integrate.cumulative_trapezoid(velocity, time, initial=0.0)])
    zero = between(time, *baseline_s)
    return belt - belt[zero].mean(axis=0)


def _mean_draws(
    body: FreeBody, onsets_s: np.ndarray, time: np.ndarray, baseline_s: tuple[float, float]
) -> np.ndarray:
    """Mean response of every draw, shape (draws, n), between samples by straight lines."""
    if not body.draws.shape[0]:
        return np.empty((0, time.size))
    at = (onsets_s[:, None] + time - body.time[0]) / (body.time[1] - body.time[0])
    low = np.clip(np.floor(at).astype(int), 0, body.time.size - 2)
    part = at - low
    mean = ((1.0 - part) * body.draws[:, low] + part * body.draws[:, low + 1]).mean(axis=1)
    zero = between(time, *baseline_s)
    return mean - mean[:, zero].mean(axis=1, keepdims=True)


def _pulses(
    standing: StandingTrial,
    onsets_s: np.ndarray,
    options: StandingOptions,
    lowpass: Lowpass,
    surface_dd: np.ndarray,
    centres: Sequence[JointCentre | None],
) -> tuple[JointCentre | None, tuple[float, float, float], tuple[tuple[JointCentre | None, float], ...]]:
    """Apparent centre of the joint while the belt moves, and motion of the soft tissue at 0.5 m/s (m).

    The motion is given for each of `tissue_frequencies`, and for the first of them with each further centre,
    of `OTHER_ROTATIONS`.
    """
    if onsets_s.size < 2:
        return None, (0.0, 0.0, 0.0), tuple((centre, 0.0) for centre in centres[1:])
    person, labels, rate = options.person, standing.prepared.markers, standing.prepared.rate_hz
    positions = lowpass(standing.trial.values("marker_position")[:, :, 1:].astype(float), rate)
    peak = float(np.abs(standing.belt_velocity).max())

    def cut(x: np.ndarray) -> np.ndarray:
        at = onsets_s + standing.delay_s
        return cut_epochs(x, rate, at, -PULSE_S[0], PULSE_S[1], float(standing.time[0])).values

    motion = relative_motion(positions, labels, person)
    at_rest = float(motion[standing.unperturbed, 0].mean())
    apparent = centre_from_pulses(cut(motion), at_rest)

    def moved(rotation: float) -> np.ndarray:
        return relative_motion(positions, labels, person, exclusive=True, rotation=rotation)

    by_shank, patterns = moved(1.0), []
    for tissue_hz in tissue_frequencies():
        wobbling = positions.copy()
        wobbling[..., 0] += STEP * tissue_motion(positions, labels, person, surface_dd, peak, rate, tissue_hz)
        patterns.append(cut((relative_motion(wobbling, labels, person, exclusive=True) - by_shank) / STEP))

    def skin_m(centre: JointCentre | None, motion: np.ndarray, pattern: np.ndarray) -> float:
        if centre is None:
            return 0.0
        responses = cut(motion)
        first = responses[:, : max(1, round(-0.5 * PULSE_S[0] * rate))].mean(axis=1, keepdims=True)
        return tissue_from_pulses(responses - first, pattern, centre.own_m, at_rest)

    usual, lower, higher = (skin_m(centres[0], by_shank, pattern) for pattern in patterns)
    turned = tuple(
        (centre, skin_m(centre, moved(rotation), patterns[0]))
        for rotation, centre in zip(OTHER_ROTATIONS, centres[1:], strict=True)
    )
    return apparent, (usual, lower, higher), turned


# ---- to and from a result's file -------------------------------------------------------------------

# of the responses like the first one, and of those to perturbations of the opposite direction
GROUPS = ("broadband", "broadband_opposite")
SIGNAL_UNITS = "Nm, rad, rad/s"
UNITS = {"time": "s", "perturbed": SIGNAL_UNITS, "quiet_time": "s", "quiet": SIGNAL_UNITS, "belt": "m/s, m"}
TORQUES = ("draws", "misfit")
TILT_UNITS = dict.fromkeys(("tilt", "quiet_tilt"), "rad, rad/s, rad, rad")
PLAIN = (
    *("baseline_s", "cutoff_hz", "order"),
    *("peak_m_per_s", "carried_kg", "calibrated_kg", "centre_used", "skin_m"),
    *("treadmill_error", "treadmill_flag", "origin_known", "frame", "empty_frame", "recording"),
    "rotation_per_m",
)


def broadband_result(epochs: BroadbandEpochs, group: str = GROUPS[0]) -> Result:
    """Epochs as arrays below a group, one of `GROUPS`, with their units, and facts."""
    written = UNITS if epochs.tilt is None else UNITS | TILT_UNITS
    signals = {
        f"{group}/{key}": (getattr(epochs, key).astype(np.float32), unit) for key, unit in written.items()
    }
    per_unit = ", ".join(f"{unit} per unit" for unit in ("Nm", "rad", "rad/s"))
    signals |= {f"{group}/slopes/{source}": (slope, per_unit) for source, slope in epochs.slopes.items()}
    for key in TORQUES:
        if getattr(epochs, key) is not None:
            signals[f"{group}/{key}"] = (getattr(epochs, key).astype(np.float32), "Nm")
    facts = {key: getattr(epochs, key) for key in PLAIN} | {"plate_flags": list(epochs.plate_flags)}
    facts |= {key: _written(getattr(epochs, key)) for key in ("centre", "apparent")}
    facts["turned"] = [[_written(centre), skin_m] for centre, skin_m in epochs.turned]
    return Result.of(signals, {group: facts})


def _written(centre: JointCentre | None) -> dict | None:
    if centre is None:
        return None
    return {k: x.tolist() if isinstance(x, np.ndarray) else x for k, x in vars(centre).items()}


def _read(centre: dict | None) -> JointCentre | None:
    if centre is None:
        return None
    return JointCentre(**{k: np.array(x) if isinstance(x, list) else x for k, x in centre.items()})


def broadband_of(result: Result, group: str = GROUPS[0]) -> BroadbandEpochs | None:
    """Read the epochs of `broadband_result` from a group of a result; None without them."""
    if group not in result.facts:
        return None
    facts = dict(result.facts[group])
    facts["plate_flags"] = tuple(facts["plate_flags"])
    for key in ("frame", "empty_frame"):
        facts[key] = None if facts[key] is None else FramePeak(*facts[key])
    facts |= {key: _read(facts[key]) for key in ("centre", "apparent")}
    facts["turned"] = tuple((_read(centre), skin_m) for centre, skin_m in facts["turned"])
    names = [key for key in (*UNITS, *TILT_UNITS, *TORQUES) if f"{group}/{key}" in result.arrays]
    arrays = {key: result.arrays[f"{group}/{key}"].astype(float) for key in names}
    slopes = {source: result.arrays[f"{group}/slopes/{source}"] for source in SOURCES}
    return BroadbandEpochs(**arrays, slopes=slopes, **facts)
