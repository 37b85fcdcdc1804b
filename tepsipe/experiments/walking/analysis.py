"""From a walking trial to the impedance of the ankle at each perturbed phase of stance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.walking.deviations import Deviations, filter_walk, subtract_unperturbed
from tepsipe.experiments.walking.impedance import PhaseImpedance, estimate_impedance, without_contact
from tepsipe.experiments.walking.options import WalkingOptions
from tepsipe.experiments.walking.plausible import refuse_other_units
from tepsipe.experiments.walking.strides import (
    CONTACT_N,
    Pulses,
    Strides,
    WalkingRecording,
    locate_pulses,
    random_onsets,
    refuse_swapped_belts,
)
from tepsipe.statistics.uncertainty import Source

FEWEST_UNPERTURBED = 12
# least strides at a phase of a walk without pulses
FEWEST_WITHOUT_PULSES = 3
# least share of a window in which the foot must be loaded
LEAST_CONTACT = 0.9


@dataclass(frozen=True)
class WalkingImpedance:
    """Results of a trial."""

    phases: dict[float, PhaseImpedance]
    """Nominal phase (%) -> impedance."""
    at_percent: dict[float, float]
    """Nominal phase (%) -> phase to which K belongs (%)."""
    deviations: dict[float, Deviations]
    """Nominal phase (%) -> strides minus their unperturbed behaviour."""
    stance_s: float
    """Mean stance of the unperturbed strides."""
    quiet: np.ndarray
    """Mask of the unperturbed strides."""
    dropped: tuple[str, ...]
    """A sentence for every stride, pulse and phase that was left out."""


def analyse_walking(
    recording: WalkingRecording,
    strides: Strides,
    onsets: Sequence[float],
    options: WalkingOptions | None = None,
    sources: Mapping[str, Source] | None = None,
) -> WalkingImpedance:
    """Impedance of the ankle at each phase of stance that was perturbed.

    recording: signals of the perturbed leg.
    strides: strides of the same leg, from `segment_strides`.
    onsets: onsets of the pulses (s).
    options: Choices; None for the recommended ones.
    sources: type B, see `estimate_impedance`.
    Returns: impedance of each phase, and omissions.
    """
    options = options or WalkingOptions()
    pulses, quiet, percent = place_pulses(recording, strides, onsets, options)
    stance, starts = float(strides.stance[quiet].mean()), strides.start[quiet]
    delay = pulses.onset - strides.start[pulses.stride]
    walk = filter_walk(recording, options.lowpass_cutoff_hz, options.lowpass_order, options.matched_by)
    phases, onset_percent, at_percent, deviations = {}, {}, {}, {}
    dropped = [
        *strides.dropped,
        *pulses.dropped,
        *_of_no_phase(recording.name, pulses.onset, percent, options),
    ]
    for phase in options.onsets_percent:
        at_phase = np.abs(percent - phase) <= options.phase_tolerance_percent
        if not at_phase.any():
            continue
        if at_phase.sum() < options.fewest_strides:
            dropped.append(
                f"{recording.name}: expected at least {options.fewest_strides} perturbed strides at "
                f"{phase:g} % of "
                f"stance, found {at_phase.sum()}: record more, the other phases are kept"
            )
            continue
        deviation = subtract_unperturbed(
            walk,
            (pulses.onset[at_phase], delay[at_phase]),
            starts,
            options.window_s,
            options.ridge,
            options.state_before_s,
        )
        deviations[phase] = deviation
        phases[phase] = estimate_impedance(deviation, options, sources)
        onset_percent[phase] = float(percent[at_phase].mean())
        if _loaded(recording, pulses.onset[at_phase], options.window_s) < LEAST_CONTACT:
            phases[phase] = without_contact(phases[phase])
            at_percent[phase] = onset_percent[phase]
            continue
        at_percent[phase] = onset_percent[phase] + 100.0 * phases[phase].at_s / stance
    for phase, rising in _rising(phases, at_percent, stance).items():
        phases[phase] = estimate_impedance(deviations[phase], options, sources, rising)
        at_percent[phase] = onset_percent[phase] + 100.0 * phases[phase].at_s / stance
    return WalkingImpedance(phases, at_percent, deviations, stance, quiet, tuple(dropped))


def place_pulses(
    recording: WalkingRecording, strides: Strides, onsets: Sequence[float], options: WalkingOptions
) -> tuple[Pulses, np.ndarray, np.ndarray]:
    """Pulses in their strides (s), unperturbed strides, and places of the pulses in stance (%).

    Arguments are those of `analyse_walking`.
    """
    refuse_swapped_belts(recording, strides)
    refuse_other_units(recording, strides)
    pulses = locate_pulses(strides, onsets, options.window_s, recording.name)
    quiet = _unperturbed(strides, np.asarray(onsets, float), options.recovery_strides)
    if quiet.sum() < FEWEST_UNPERTURBED:
        raise InputError(
            f"{recording.name}: expected at least {FEWEST_UNPERTURBED} unperturbed strides, found "
            f"{quiet.sum()}: "
            "record unperturbed walking, or perturb fewer strides"
        )
    percent = 100.0 * (pulses.onset - strides.start[pulses.stride]) / float(strides.stance[quiet].mean())
    off = np.abs(percent[:, None] - np.array(options.onsets_percent))
    if ((off <= options.phase_tolerance_percent).sum(axis=0) < options.fewest_strides).all():
        raise InputError(
            f"{recording.name}: expected at least {options.fewest_strides} perturbed strides at one of "
            "the phases "
            f"{', '.join(f'{p:g}' for p in options.phases_percent)} % of stance, found fewer at each: "
            "record more"
        )
    return pulses, quiet, percent


def without_pulses(
    strides: Strides, options: WalkingOptions, rng: np.random.Generator
) -> tuple[np.ndarray, WalkingOptions]:
    """Onsets of pulses of no size at random strides (s), and options for them.

    With them, the intervals of a walk without pulses say what is known of the ankle: nothing.
    """
    onsets = random_onsets(strides, options.phases_percent, rng)
    return onsets, replace(options, fewest_strides=FEWEST_WITHOUT_PULSES, recovery_strides=0)


def _rising(
    phases: dict[float, PhaseImpedance], at_percent: dict[float, float], stance_s: float
) -> dict[float, tuple[float, float, float]]:
    """Rate of K at each phase from the adjacent ones, its uncertainty, and the time of K after the onset."""
    usable = [phase for phase, fit in phases.items() if not fit.flags]
    rates = {}
    for k, phase in enumerate(usable):
        first, last = usable[max(k - 1, 0)], usable[min(k + 1, len(usable) - 1)]
        if first == last:
            continue
        interval_s = stance_s * (at_percent[last] - at_percent[first]) / 100.0
        low, high = phases[first], phases[last]
        u = np.hypot(low.budget.type_a[2], high.budget.type_a[2])
        rates[phase] = (
            float(high.values[2] - low.values[2]) / interval_s,
            float(u) / interval_s,
            phases[phase].at_s,
        )
    return rates


def _loaded(recording: WalkingRecording, onsets: np.ndarray, window_s: float) -> float:
    """Mean share of the windows with the foot on the belt."""
    time = onsets[:, None] + np.arange(0.0, window_s, 1.0 / recording.rate_hz)
    return float((np.interp(time, recording.time, recording.vertical) > CONTACT_N).mean())


def _unperturbed(strides: Strides, onsets: np.ndarray, recovery: int) -> np.ndarray:
    """Strides that are neither perturbed nor among those after a perturbed one."""
    quiet = np.ones(len(strides), dtype=bool)
    for onset in onsets:
        first = int(np.searchsorted(strides.start, onset, side="right")) - 1
        quiet[max(first, 0) : max(first, -1) + 1 + recovery] = False
    return quiet


def _of_no_phase(name: str, onset: np.ndarray, percent: np.ndarray, options: WalkingOptions) -> list[str]:
    """A sentence for every pulse that is near none of the phases."""
    distance = np.abs(percent[:, None] - np.array(options.onsets_percent)).min(axis=1, initial=np.inf)
    return [
        f"{name}: expected the pulse at {onset[k]:.3f} s at one of the phases "
        f"{', '.join(f'{p:g}' for p in options.onsets_percent)} % of stance, found it at {percent[k]:.0f} "
        "%: the "
        "pulse is left out"
        for k in np.flatnonzero(distance > options.phase_tolerance_percent)
    ]
