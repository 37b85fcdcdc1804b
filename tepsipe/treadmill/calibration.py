"""Calibration of treadmill models on some trials and held-out validation on others: rows of their table.

Coherence gives the upper limit of R2 for linear, time-invariant models of the belt acceleration.
"""

from dataclasses import dataclass

import numpy as np

from tepsipe.io.result import Result
from tepsipe.io.tables import Table
from tepsipe.treadmill.black_box_models import spectrum_over_distance
from tepsipe.treadmill.bristle_frame import AT
from tepsipe.treadmill.mass_models import LoadedFrame
from tepsipe.treadmill.options import FRAMES
from tepsipe.treadmill.recording import BeltRecording, check_recordings
from tepsipe.treadmill.registry import FamilyOptions, FittedModel, evaluate, fit_model


def coherence_limit(recordings: list[BeltRecording], segment_s: float) -> float:
    """Fraction of the load's power that is coherent with the belt acceleration.

    The spectra are averaged over half-overlapping Hann segments of continuous recordings, or over the
    zero-padded perturbations of transient ones. The coherence of unrelated signals averaged over n
    segments has a bias of 1/n, which is removed.

    recordings: recordings on which models are evaluated.
    segment_s: length of the segments of continuous recordings.
    Returns: sum gamma^2 S_LL / sum S_LL over all frequencies but 0 Hz, the upper limit of R2. NaN for a
    single segment.
    """
    s_aa, s_al, s_ll, count = 0.0, 0.0, 0.0, 0.0
    for r in recordings:
        a, load = _segments(r.acceleration, r, segment_s), _segments(r.load, r, segment_s)
        overlapping = 1.0 if r.onsets else HANN_HALF_OVERLAP
        spectrum_a, spectrum_l = (np.fft.rfft(x, axis=1)[:, 1:] for x in (a, load))
        s_aa = s_aa + np.sum(np.abs(spectrum_a) ** 2, axis=0)
        s_ll = s_ll + np.sum(np.abs(spectrum_l) ** 2, axis=0)
        s_al = s_al + np.sum(np.conj(spectrum_a) * spectrum_l, axis=0)
        count += overlapping * a.shape[0]
    if count <= 1.0:
        return float("nan")
    power = s_aa * s_ll
    coherence = np.abs(s_al) ** 2 / np.where(power > 0.0, power, 1.0)
    unbiased = (count * coherence - 1.0) / (count - 1.0)
    return float(np.clip(np.sum(unbiased * s_ll) / np.sum(s_ll), 0.0, 1.0))


# number of independent averages per half-overlapping Hann segment (Welch 1967)
HANN_HALF_OVERLAP = 0.947


def _segments(x: np.ndarray, recording: BeltRecording, segment_s: float) -> np.ndarray:
    """Segments without their mean, tapered or padded, shape (segments, samples)."""
    if recording.onsets:
        parts = recording.segments(x)
        return np.pad(parts, ((0, 0), (0, parts.shape[1])))
    samples = min(round(segment_s * recording.rate_hz), int(recording.evaluated.sum()))
    inside = x[recording.evaluated] - x[recording.evaluated].mean()
    parts = np.lib.stride_tricks.sliding_window_view(inside, samples)[:: max(1, samples // 2)]
    return parts * np.hanning(samples)


@dataclass(frozen=True)
class ModelScore:
    """One model, fitted on some recordings and evaluated on others."""

    model: str
    """Name in the family."""
    train: str
    test: str
    """Recordings to which it was fitted, and recordings on which it was evaluated."""
    cutoff_hz: float
    """Cutoff of the low-pass filter of all signals."""
    r2: float
    """Fraction of the load's variance that is predicted."""
    rms_before: float
    rms_after: float
    """Root mean square of the load and of the residual (``unit``)."""
    order: int
    """Number of poles, taps, lines or conditions: the size of the model."""
    r2_limit: float
    """Upper limit of R2 for a linear model of the belt acceleration on these recordings."""
    load: str
    unit: str
    """Name of the load, and its unit."""
    converged: bool = True
    """Whether the optimisation converged; true for models without one."""


# a belt, left or right, may follow
MODEL_SCORES = Table(ModelScore, "scores of models", further=("belt",))


@dataclass(frozen=True)
class Calibration:
    """One model to fit."""

    model: str
    """Name in the family."""
    train: str
    """Name of the group of recordings to fit it to."""
    tests: tuple[str, ...]
    """Names of the groups to evaluate it on."""


def calibrate(
    plan: list[Calibration],
    training: dict[str, list[BeltRecording]],
    testing: dict[str, list[BeltRecording]],
    load: str,
    options: FamilyOptions,
) -> tuple[list[ModelScore], list[FittedModel]]:
    """Fit every model of a plan and evaluate it on the test recordings.

    plan: models to fit, with their training and test recordings.
    training, testing: groups of recordings, all with the same filter. No recording should be in both.

    Returns:
        scores: one per model and test (unit of the load).
        models: one per entry of the plan.
    """
    scores, models = [], []
    for recordings in testing.values():
        check_recordings(recordings, options.shortest_s)
    limits = {name: coherence_limit(group, options.spectral_segment_s) for name, group in testing.items()}
    for entry in plan:
        fitted = fit_model(entry.model, training[entry.train], options)
        models.append(fitted)
        for test in entry.tests:
            score = evaluate(fitted, testing[test])
            scores.append(
                ModelScore(
                    entry.model,
                    entry.train,
                    test,
                    testing[test][0].lowpass.cutoff_hz,
                    score.r2,
                    score.rms_before,
                    score.rms_after,
                    fitted.model.order,
                    limits[test],
                    load,
                    fitted.unit,
                    getattr(fitted.model, "converged", True),
                )
            )
    return scores, models


# ---- which models on which trials ----------------------------------------------------------------

ALL_EMPTY = "empty, all"
BOTH = "empty+weight"
# entry for a resonance that the signals do not show (Hz)
UNSEEN_HZ = 1e6
# models that need more than one mass on the belt
OF_BOTH = ("loaded-frame", *FRAMES)


def group_of(experiment: str, carried_kg: float, usual_kg: float) -> str:
    """Group of a trial of the empty belt or of a weight: its experiment, with the mass of another weight.

    The usual weight has the mass ``usual_kg`` (kg).
    """
    if experiment == "empty" or abs(carried_kg - usual_kg) <= 1e-6 * usual_kg:
        return experiment
    return f"{experiment} of {carried_kg:g} kg"


def plate_groups(
    recordings: list[tuple[str, str, BeltRecording]],
) -> tuple[dict[str, list[BeltRecording]], dict[str, list[BeltRecording]]]:
    """Group recordings of the empty belt and of weights (units as in the recordings).

    recordings: group by `group_of`, role calibrate or validate.
    Returns: training by group, all groups together, and all trials of the empty belt, whose mean is
    subtracted condition by condition; testing by group.
    """
    training: dict[str, list[BeltRecording]] = {}
    testing: dict[str, list[BeltRecording]] = {}
    for experiment, role, recording in recordings:
        if experiment == "empty":
            training.setdefault(ALL_EMPTY, []).append(recording)
        if role == "calibrate":
            training.setdefault(experiment, []).append(recording)
            training.setdefault(BOTH, []).append(recording)
        else:
            testing.setdefault(experiment, []).append(recording)
    return training, testing


def plate_plan(family: list[str], tests: list[str]) -> list[Calibration]:
    """Plan of the models to fit to the empty belt, to the weight, or to both, and of their tests.

    The mean of the empty belt is subtracted from the trials of the weight only, and the frames need
    both experiments. Every other model is fitted to each experiment and evaluated on each.
    """
    plan = []
    for model in family:
        if model == "mean-subtraction":
            plan.append(Calibration(model, ALL_EMPTY, tuple(t for t in tests if t == "weight")))
        elif model in OF_BOTH:
            plan.append(Calibration(model, BOTH, tuple(tests)))
        else:
            plan += [Calibration(model, train, tuple(tests)) for train in ("empty", "weight")]
    return plan


def table_plan(family: list[str], train: str, tests: list[str]) -> list[Calibration]:
    """Plan that fits every model to all calibration trials and evaluates it on the others."""
    return [Calibration(model, train, tuple(tests)) for model in family]


# ---- data of figures -----------------------------------------------------------------------------


def mean_responses(models: list[FittedModel], recordings: list[BeltRecording]) -> Result:
    """Measured and predicted load, mean over the perturbations of each recording (unit of the load)."""
    signals: dict[str, tuple[np.ndarray, str]] = {}
    for r in recordings:
        for key, x in ({"measured": r.load} | {m.name: m.predict(r) for m in models}).items():
            signals[f"{r.condition}/{key}"] = (r.segments(x).mean(axis=0), r.unit)
    heaviest = max(r.carried_kg for r in recordings)
    facts = {
        "conditions": [r.condition for r in recordings],
        "models": [m.name for m in models],
        "rate_hz": recordings[0].rate_hz,
        "cutoff_hz": recordings[0].lowpass.cutoff_hz,
        "loaded_frame": next(
            (_frame_facts(m.model, heaviest) for m in models if m.name == "loaded-frame"), None
        ),
        "bristle_frame": next(
            (_bristle_facts(m, heaviest) for m in models if m.name == "bristle-frame"), None
        ),
    }
    return Result.of(signals, facts)


def _bristle_facts(fitted: FittedModel, usual_kg: float) -> dict:
    """Terms of the frame with bristles, and its resonance (Hz) and uncertainty at several masses (kg)."""
    model = fitted.model
    masses = sorted({0.0, usual_kg, model.heaviest_kg})
    resonances = [min(model.resonance_hz(kg), UNSEEN_HZ) for kg in masses]
    slowness = fitted.deviations[:, [AT["slowness_s2"], AT["slowness_s2_per_kg"]]]
    # f = 1 / (2 pi sqrt(e)): df = 2 pi^2 f^3 de
    spreads = [
        2.0 * np.pi**2 * hz**3 * float(np.std(slowness @ [1.0, kg])) if hz < UNSEEN_HZ else 0.0
        for kg, hz in zip(masses, resonances, strict=True)
    ]
    return {
        "terms": list(model.terms),
        "converged": model.converged,
        "masses_kg": masses,
        "resonance_hz": resonances,
        "resonance_sd_hz": spreads,
        "constants": model.named._asdict(),
    }


def _frame_facts(frame: LoadedFrame, load_kg: float) -> dict:
    return {
        "empty_hz": frame.resonance_hz(0.0),
        "loaded_hz": frame.resonance_hz(load_kg),
        "motion": frame.motion.tolist(),
        "lag_s": frame.lag_s,
        "friction_speed_m_per_s": frame.friction_speed_m_per_s,
        "mount_share": frame.mount_share,
        "mount_time_s": frame.mount_time_s,
    }


def table_result(
    models: list[FittedModel], recordings: list[BeltRecording], ingested: dict, most_samples: int = 3000
) -> Result:
    """Measured and predicted load of every test recording, and the spectrum over distance.

    recordings: test recordings, with the filter of the models.
    ingested: recording -> record of its ingest, stored with the result.
    most_samples: largest number of samples shown of a recording, from its middle (samples).
    Returns: per recording time, measured and predicted load (unit of the load).
    """
    signals: dict[str, tuple[np.ndarray, str]] = {}
    for r in recordings:
        start = max(0, (r.load.size - most_samples) // 2)
        part = slice(start, start + most_samples)
        own = {
            "time": (np.arange(r.load.size) / r.rate_hz, "s"),
            "belt_velocity": (r.velocity, "m/s"),
            "measured": (r.load, r.unit),
            **{m.name: (m.predict(r), r.unit) for m in models},
        }
        signals |= {f"{r.name}/{key}": (x[part], unit) for key, (x, unit) in own.items()}
    first = recordings[0]
    tracker = next((m.model for m in models if m.model.untracked is not None), None)
    if tracker is not None:
        for key, predicted in (
            ("untracked", tracker.untracked.predict(first)),
            ("tracked", tracker.predict(first)),
        ):
            spectrum = spectrum_over_distance(first, first.load - predicted)
            if spectrum is not None:
                signals["ripple/order"] = (spectrum.order_per_m, "1/m")
                signals[f"ripple/{key}"] = (np.sqrt(spectrum.power), first.unit)
        signals["ripple/tracked_orders"] = (tracker.orders_per_m, "1/m")
    facts = {
        "recordings": [r.name for r in recordings],
        "models": [m.name for m in models],
        "ingested": ingested,
        "unit": first.unit,
        "cutoff_hz": first.lowpass.cutoff_hz,
        "rate_hz": first.rate_hz,
    }
    return Result.of(signals, facts)
