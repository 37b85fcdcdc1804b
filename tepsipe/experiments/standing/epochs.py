"""Epochs of a standing person: baseline-corrected responses to the perturbations of a trial.

Every epoch is cut around the instant at which the belt starts to move; unperturbed epochs of the same length
are cut from undisturbed standing. All are baseline-corrected by their mean just before the onset, which
removes slow sway. An unreliable epoch is omitted and reported, never averaged silently.
"""

from dataclasses import dataclass, replace
from typing import Annotated, Self

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.standing.joint_torque import StandingTrial
from tepsipe.experiments.standing.options import EpochOptions
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.signals.emg import channel_fault, clipped_perturbations, process_emg
from tepsipe.signals.epochs import between, cut_epochs, unperturbed_onsets
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.signals.perturbations import same_direction
from tepsipe.signals.resampling import runs_of

# signals of the epochs and their units, in addition to the torques, one per pathway
UNITS = {
    "ankle": "rad",
    "ankle_d": "rad/s",
    "ankle_dd": "rad/s2",
    "shank": "rad",
    "thigh": "rad",
    "knee": "rad",
    "f_y": "N",
    "belt_velocity": "m/s",
}


@dataclass(frozen=True)
class StandingEpochs:
    """Responses of one trial."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    """Time from the onset."""
    perturbed: dict[str, np.ndarray]
    unperturbed: dict[str, np.ndarray]
    """Baseline-corrected signals of `UNITS` and ``torque/<pathway>`` (N·m), after perturbations and in
    unperturbed standing, shape (responses, n)."""
    stretch: dict[str, np.ndarray]
    """Velocity of ankle and knee with the filter for stretches (rad/s), shape (responses, n)."""
    muscles: tuple[str, ...]
    """Muscles with a usable channel."""
    drive: Annotated[np.ndarray, "(responses, n, muscles)"]
    unperturbed_drive: Annotated[np.ndarray, "(responses, n, muscles)"]
    """Rectified electromyogram with the filter of all signals, baseline-corrected (uV)."""
    envelope: Annotated[np.ndarray, "(responses, n, muscles)"]
    """Envelope of the electromyograms, thesis section 3-2 (uV)."""
    emg_time: Annotated[np.ndarray, "(m,)", "s"]
    """Time from the onset at the electromyograms' rate."""
    emg: Annotated[np.ndarray, "(responses, m, muscles)"]
    """Band-passed, unrectified electromyograms (uV)."""
    usable: Annotated[np.ndarray, "(responses, muscles)"]
    unperturbed_usable: Annotated[np.ndarray, "(responses, muscles)"]
    """False where a channel was clipped."""
    onsets_s: Annotated[np.ndarray, "(responses,)"]
    """Onsets of the perturbations."""
    left_out: tuple[str, ...]
    """Reasons for omitted perturbations and muscles, one sentence each."""

    @property
    def count(self) -> int:
        """Number of perturbations with a response."""
        return self.onsets_s.size

    def by_direction(self) -> list[Self]:
        """The responses to perturbations of each direction of the belt, first those like the first response.

        Means over responses of both directions would cancel. Epochs of one direction are returned as they
        are.
        """
        if not self.count:
            return [self]
        alike = same_direction(self.perturbed["belt_velocity"])
        return [self] if alike.all() else [self._only(kept) for kept in (alike, ~alike)]

    def _only(self, kept: np.ndarray) -> Self:
        parts = ("drive", "envelope", "emg", "usable", "onsets_s")
        return replace(
            self,
            perturbed={key: x[kept] for key, x in self.perturbed.items()},
            stretch={key: x[kept] for key, x in self.stretch.items()},
            **{key: getattr(self, key)[kept] for key in parts},
        )


def cut_standing_epochs(standing: StandingTrial, options: EpochOptions) -> StandingEpochs:
    """Epochs of all reliable perturbations.

    standing: angles, torque, onsets, and the trial's electromyograms (uV).
    Returns: responses (rad, N·m, uV), none if the person did not stand still, and reasons for omissions.
    """
    trial, name = standing.trial, standing.prepared.name
    left_out = []
    kept = np.zeros(standing.onsets_s.size, dtype=bool)
    if standing.fault is not None:
        left_out.append(f"{name}: left out as a whole: {standing.fault}")
    else:
        for k in range(kept.size):
            fault = _perturbation_fault(standing, k, options)
            kept[k] = fault is None
            if fault is not None:
                left_out.append(f"{name}: perturbation at {standing.onsets_s[k]:.2f} s left out: {fault}")
        if kept.sum() < options.least_perturbations:
            left_out.append(
                f"{name}: left out as a whole: expected at least {options.least_perturbations} usable "
                f"perturbations, found {kept.sum()}: repeat the trial"
            )
            kept[:] = False
    onsets = standing.onsets_s[kept]
    window = options.before_s, options.after_s
    quiet = quiet_onsets(standing, options)
    rate = trial.rate_hz
    signals = {key: getattr(standing, key) for key in UNITS}
    signals |= {f"torque/{key}": x for key, x in standing.torque.items()}
    table = np.column_stack(list(signals.values()))
    start = float(standing.time[0])

    def cut(x: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if not at.size:
            time = cut_epochs(x, rate, quiet, *window, start).time
            return time, np.zeros((0, time.size, *x.shape[1:]))
        responses = cut_epochs(x, rate, at, *window, start)
        return responses.time, responses.values

    time, perturbed = cut(table, onsets)
    _, unperturbed = cut(table, quiet)
    stretch = {key: cut(x, onsets)[1] for key, x in standing.stretch_velocity.items()}
    zero = between(time, *options.baseline_s)
    perturbed, unperturbed = _from_baseline(perturbed, zero), _from_baseline(unperturbed, zero)
    channels = _channels(trial, name, options, onsets, quiet, standing.fault is None)
    activity = _emg_responses(trial, channels, options, onsets, quiet, time, zero)
    return StandingEpochs(
        time=time,
        perturbed={key: perturbed[..., k] for k, key in enumerate(signals)},
        unperturbed={key: unperturbed[..., k] for k, key in enumerate(signals)},
        stretch=stretch,
        muscles=channels.muscles,
        **activity,
        usable=channels.usable,
        unperturbed_usable=channels.unperturbed_usable,
        onsets_s=onsets,
        left_out=(*left_out, *channels.left_out),
    )


def quiet_onsets(standing: StandingTrial, options: EpochOptions) -> np.ndarray:
    """Instants (s) of unperturbed standing with all markers visible and all signals recorded."""
    clocks = standing.time, standing.trial.axes.get("emg_time", standing.time)
    start, end = max(clock[0] for clock in clocks), min(clock[-1] for clock in clocks)
    onsets = start + unperturbed_onsets(
        float(end - start),
        np.column_stack([standing.onsets_s, standing.ends_s]) - start,
        _quiet_after(standing),
        options.before_s,
        options.after_s,
        None,
    )
    seen = [_longest_hidden(standing, at, options)[0] <= options.max_gap_s for at in onsets]
    if not any(seen):
        name = standing.prepared.name
        raise InputError(
            f"{name}: expected unperturbed standing with every marker visible, found a hidden marker in all "
            f"{onsets.size} unperturbed epochs: check what stood between markers and cameras"
        )
    return onsets[seen]


def _longest_hidden(standing: StandingTrial, at: float, options: EpochOptions) -> tuple[float, str]:
    """Longest time (s) for which a marker was hidden in the window around an instant, and its name."""
    inside = (standing.time >= at - options.before_s) & (standing.time <= at + options.after_s)
    lengths = [
        max((stop - start for start, stop in runs_of(hidden & inside)), default=0) / standing.prepared.rate_hz
        for hidden in standing.hidden.T
    ]
    return max(zip(lengths, standing.labels, strict=True), key=lambda pair: pair[0])


def _quiet_after(standing: StandingTrial) -> float:
    """Time after the end of a perturbation that does not count as unperturbed (s)."""
    step = standing.time[1] - standing.time[0]
    last = np.flatnonzero(standing.unperturbed & (standing.time > standing.ends_s[-1]))
    return float(standing.time[last[0]] - standing.ends_s[-1] + step) if last.size else np.inf


def _from_baseline(responses: np.ndarray, zero: np.ndarray) -> np.ndarray:
    """Responses, shape (r, n, c), baseline-corrected (same unit)."""
    return responses - responses[:, zero].mean(axis=1, keepdims=True)


def _perturbation_fault(standing: StandingTrial, k: int, options: EpochOptions) -> str | None:
    """Reason why the response to a perturbation is unreliable, one sentence; None if it is reliable."""
    onset, end, time = standing.onsets_s[k], standing.ends_s[k], standing.time
    if onset - options.before_s < time[0] or onset + options.after_s > time[-1]:
        return (
            f"expected the record from {options.before_s:g} s before to {options.after_s:g} s after it, "
            "found it cut off: record longer before the first and after the last perturbation"
        )
    following = standing.onsets_s[k + 1] if k + 1 < standing.onsets_s.size else np.inf
    if following - options.before_s < onset + options.after_s:
        return (
            f"expected {options.before_s + options.after_s:g} s to the next perturbation, found "
            f"{following - onset:.2g} s: shorten the window of the responses in the configuration"
        )
    margin = 0.02
    moving = (time >= onset - margin) & (time <= end + margin)
    for label, hidden in zip(standing.labels, standing.hidden.T, strict=True):
        if (hidden & moving).any():
            return (
                f"marker {label!r} was hidden while the belt moved. Check what stood between it and the "
                "cameras"
            )
    longest, label = _longest_hidden(standing, onset, options)
    if longest > options.max_gap_s:
        return (
            f"marker {label!r} was hidden for {longest:.2g} s of the response, and at most "
            f"{options.max_gap_s:g} s can be filled. Check what stood between it and the cameras"
        )
    return None


@dataclass(frozen=True)
class _Channels:
    """Usable muscles, their columns in the recording, and the responses for which each is usable."""

    muscles: tuple[str, ...]
    columns: list[int]
    usable: np.ndarray
    unperturbed_usable: np.ndarray
    left_out: list[str]


def _channels(
    trial: Trial, name: str, options: EpochOptions, onsets: np.ndarray, quiet: np.ndarray, stood: bool
) -> _Channels:
    if "emg" not in trial.signals:
        nobody = (np.zeros((at.size, 0), dtype=bool) for at in (onsets, quiet))
        reason = trial.attributes.get("no_emg", "the trial has no file of electromyograms")
        return _Channels((), [], *nobody, [f"{name}: no muscles: {reason}"])
    muscles, columns, usable, unperturbed_usable, left_out = [], [], [], [], []
    missing = trial.attributes["emg_missing"]
    left_out += [
        f"{name}: muscle {muscle} left out: its channel is not in the file of electromyograms, correct the "
        "label in the configuration"
        for muscle in missing.split(", ")
        if muscle
    ]
    limits = np.asarray(trial.attributes["emg_limits_uV"])
    rate = float(trial.attributes["emg_rate_hz"])
    start = float(trial.axes["emg_time"][0])
    for column, muscle in enumerate(trial.axes["muscle"].tolist() if stood else []):
        raw = trial.values("emg")[:, column].astype(float)
        fault = channel_fault(raw, limits[column], rate, options.line_hz)
        if fault is not None:
            left_out.append(f"{name}: muscle {muscle} left out: {fault}")
            continue
        clipped, beside = (
            clipped_perturbations(raw, limits[column], rate, at, options.before_s, options.after_s, start)
            for at in (onsets, quiet)
        )
        left_out += [
            f"{name}: perturbation at {onset:.2f} s left out for muscle {muscle}: the amplifier was "
            "clipped, lower its gain or fasten the cables"
            for onset in onsets[clipped]
        ]
        if clipped.all() and clipped.size:
            left_out.append(
                f"{name}: muscle {muscle} left out: clipped in every perturbation, lower its gain"
            )
            continue
        if beside.all():
            left_out.append(
                f"{name}: muscle {muscle} left out: clipped in all unperturbed standing, lower its gain"
            )
            continue
        muscles.append(muscle)
        columns.append(column)
        usable.append(~clipped)
        unperturbed_usable.append(~beside)
    stacked = [
        np.array(rows, dtype=bool).reshape(len(muscles), at.size).T
        for rows, at in ((usable, onsets), (unperturbed_usable, quiet))
    ]
    return _Channels(tuple(muscles), columns, *stacked, left_out)


def _emg_responses(
    trial: Trial,
    channels: _Channels,
    options: EpochOptions,
    onsets: np.ndarray,
    quiet: np.ndarray,
    time: np.ndarray,
    zero: np.ndarray,
) -> dict[str, np.ndarray]:
    """Electromyograms of `StandingEpochs`: its fields by name (uV, s)."""
    grid_rate = (time.size - 1) / (time[-1] - time[0])
    recorded = "emg" in trial.signals
    rate = float(trial.attributes["emg_rate_hz"]) if recorded else grid_rate
    start = float(trial.axes["emg_time"][0]) if recorded else 0.0
    step = round(rate / grid_rate)
    if abs(step * grid_rate - rate) > 1e-6 * rate:
        raise InputError(
            f"electromyograms: expected a rate that is a multiple of {grid_rate:g} Hz, found {rate:g} Hz: "
            "export them at such a rate"
        )
    before, after = round(options.before_s * rate), round(options.after_s * rate)
    emg_time = np.arange(-before, after + 1) / rate
    muscles = len(channels.muscles)
    if not muscles or not onsets.size:
        return {
            "drive": np.zeros((onsets.size, time.size, muscles)),
            "unperturbed_drive": np.zeros((quiet.size, time.size, muscles)),
            "envelope": np.zeros((onsets.size, time.size, muscles)),
            "emg_time": emg_time,
            "emg": np.zeros((onsets.size, emg_time.size, muscles)),
        }
    processed = process_emg(trial.values("emg")[:, channels.columns].astype(float), rate, options.emg)
    smooth = butterworth_lowpass(processed.rectified, rate, options.lowpass_cutoff_hz, options.lowpass_order)

    def cut(x: np.ndarray, at: np.ndarray) -> np.ndarray:
        return cut_epochs(x, rate, at, options.before_s, options.after_s, start).values

    # one spline for both: these signals have most samples
    drive = _from_baseline(cut(smooth, np.concatenate([onsets, quiet]))[:, ::step], zero)
    return {
        "drive": drive[: onsets.size],
        "unperturbed_drive": drive[onsets.size :],
        "envelope": cut(processed.envelope, onsets)[:, ::step],
        "emg_time": emg_time,
        "emg": cut(processed.band_passed, onsets),
    }


# ---- to and from a result's file -------------------------------------------------------------------

PLAIN = {
    "time": "s",
    "drive": "uV",
    "unperturbed_drive": "uV",
    "envelope": "uV",
    "emg_time": "s",
    "emg": "uV",
    "usable": "1",
    "unperturbed_usable": "1",
    "onsets_s": "s",
}
GROUPS = ("perturbed", "unperturbed", "stretch")


def epochs_result(responses: StandingEpochs) -> Result:
    """Responses as arrays with their units, float32 where they are many."""
    signals = {key: (_narrow(getattr(responses, key)), unit) for key, unit in PLAIN.items()}
    for group in GROUPS:
        for key, x in getattr(responses, group).items():
            signals[f"{group}/{key}"] = (_narrow(x), _unit(group, key))
    return Result.of(signals, {"muscles": responses.muscles, "left_out": responses.left_out})


def _narrow(x: np.ndarray) -> np.ndarray:
    return x.astype(np.float32) if x.ndim > 1 and x.dtype == float else x


def _unit(group: str, key: str) -> str:
    if group == "stretch":
        return "rad/s"
    return UNITS.get(key, "Nm")


def epochs_of(result: Result) -> StandingEpochs:
    """Read the responses from a result of `epochs_result` (units as there)."""
    groups: dict[str, dict[str, np.ndarray]] = {group: {} for group in GROUPS}
    for key, x in result.arrays.items():
        group, _, name = key.partition("/")
        if group in groups and name:
            groups[group][name] = x.astype(float)
    plain = {key: result.arrays[key] for key in PLAIN}
    plain = {key: x if x.dtype == bool else x.astype(float) for key, x in plain.items()}
    return StandingEpochs(
        **plain, **groups, muscles=tuple(result.facts["muscles"]), left_out=tuple(result.facts["left_out"])
    )
