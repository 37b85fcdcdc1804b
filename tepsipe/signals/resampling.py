"""Conversion of signals to one common, regular clock: repair, fill, align, resample.

No function extrapolates: a result exists only where its source was recorded.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.signals.differentiation import spline_pieces

# a passband of 0.4 times the new rate keeps the analysed band and removes what would alias into it
BAND_PER_RATE = 0.4
# window of the low-pass: ripple of 0.01 % (80 dB) on both sides of a transition that ends at half of the new
# rate (Kaiser's formulas: A. V. Oppenheim & R. W. Schafer, Discrete-Time Signal Processing, 3rd edn, 7.5.3).
# The 0.4 % of a Hamming window would be an error of 0.2 to 0.4 % of a torque over an angle
KAISER_BETA = 0.1102 * (80.0 - 8.7)
# half of its length in periods of the cutoff
LOBES = 5.0


@dataclass(frozen=True)
class RepairedTime:
    """Outcome of `repair_time_stamps`."""

    keep: np.ndarray
    """Samples whose stamps are kept."""
    repeated: int
    """Number of samples dropped because they repeat the preceding stamp."""
    longest_step_s: float
    """Longest step between kept stamps."""


def repair_time_stamps(time: Annotated[np.ndarray, "(n,)", "s"], max_gap_s: float, what: str) -> RepairedTime:
    """Drop repeated time stamps and refuse unreliable ones.

    max_gap_s: longest step allowed between samples.
    what: names the source in messages, for example its file.
    Returns: samples to keep, and properties of the stamps.
    """
    bad = np.flatnonzero(~np.isfinite(time))
    if bad.size:
        raise InputError(
            f"{what}: expected a time stamp on every line, found none on line {bad[0] + 1} of the "
            "samples: repair or cut the file there"
        )
    if time.size < 2:
        raise InputError(f"{what}: expected a time series, found {time.size} samples: record again")
    steps = np.diff(time)
    backwards = np.flatnonzero(steps < 0.0)
    if backwards.size:
        k = backwards[0]
        raise InputError(
            f"{what}: expected time to increase, found it running backwards from {time[k]:.6g} s to "
            f"{time[k + 1]:.6g} s at sample {k + 2}: cut the file into trials or repair its stamps"
        )
    keep = np.concatenate([[True], steps > 0.0])
    longest = float(np.diff(time[keep]).max(initial=0.0))
    if longest > max_gap_s:
        k = int(np.argmax(steps))
        raise InputError(
            f"{what}: expected no step longer than {max_gap_s:g} s, found one of {longest:.3g} s at "
            f"{time[k]:.6g} s: cut the trial there or "
            "increase max_gap_s"
        )
    return RepairedTime(keep, int((~keep).sum()), longest)


def fill_gaps(x: np.ndarray, rate_hz: float, max_gap_s: float, what: str) -> tuple[np.ndarray, np.ndarray]:
    """Fill short runs of NaN by a cubic spline through the samples around them.

    Runs that touch either end of the record are filled with the nearest sample.

    x: Signal; a sample is missing if any of its c components is NaN.
    max_gap_s: longest run that may be filled.
    what: names the signal in messages.

    Returns:
        filled: signal without NaN (unit of ``x``).
        missing: true where a sample was filled.
    """
    columns = x.reshape(x.shape[0], -1)
    missing = ~np.isfinite(columns).all(axis=1)
    if not missing.any():
        return x.copy(), missing
    start, stop = max(runs_of(missing), key=lambda run: run[1] - run[0])
    length_s = (stop - start) / rate_hz
    if length_s > max_gap_s + 1e-9:
        raise InputError(
            f"{what}: expected gaps of at most {max_gap_s:g} s, found one of {length_s:.3g} s at "
            f"{start / rate_hz:.3f} s: cut the trial there or allow longer gaps "
            "(max_gap_s)"
        )
    present = np.flatnonzero(~missing)
    if present.size < 4:
        raise InputError(f"{what}: expected samples, found only {present.size}: record again")
    around = np.zeros_like(missing)
    for start, end in runs_of(missing):
        around[max(0, start - 25) : end + 25] = True
    knots = np.flatnonzero(around & ~missing)
    gaps = np.flatnonzero(missing)
    filled = columns.copy()
    filled[gaps] = scipy.interpolate.CubicSpline(knots, columns[knots])(
        np.clip(gaps, present[0], present[-1])
    )
    return filled.reshape(x.shape), missing


def bridge_gaps(
    x: Annotated[np.ndarray, "(n, c)"], rate_hz: float, max_gap_s: float, what: str
) -> tuple[np.ndarray, np.ndarray]:
    """Bridge long runs of NaN by straight lines, so that the remaining gaps can be filled; mark them.

    A bridge contains no information: use it only where marked samples are omitted.

    x: Signal; a sample is missing if any of its c components is NaN.
    max_gap_s: longest run that is not bridged.
    what: names the signal in messages.

    Returns:
        bridged: signal with NaN in short runs only (unit of ``x``). Shape (n, c).
        long: true in a bridge.
    """
    missing = ~np.isfinite(x).all(axis=1)
    if (~missing).sum() < 4:
        raise InputError(
            f"{what}: expected samples, found {int((~missing).sum())} of {missing.size}: the marker was "
            "hidden all the time, record again or take the trial out of the trial sheet"
        )
    long = np.zeros(missing.size, dtype=bool)
    for start, stop in runs_of(missing):
        long[start:stop] = stop - start > max_gap_s * rate_hz + 1e-9
    bridged = x.copy()
    known, gaps = np.flatnonzero(~missing), np.flatnonzero(long)
    for column in bridged.T:
        column[gaps] = np.interp(gaps, known, column[known])
    return bridged, long


def runs_of(marked: np.ndarray) -> list[tuple[int, int]]:
    """Start and stop (samples) of each run of True in a boolean array of shape (n,)."""
    edges = np.diff(np.concatenate([[0], marked.astype(int), [0]]))
    starts, stops = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return list(zip(starts.tolist(), stops.tolist(), strict=True))


def resample(
    time: np.ndarray,
    x: np.ndarray,
    new_time: Annotated[np.ndarray, "(m,)"],
    band_hz: float | None = None,
    rate_hz: float | None = None,
) -> Annotated[np.ndarray, "(m,)"]:
    """Evaluate a sampled signal at other instants by a cubic spline.

    time: instants of the samples (s), increasing.
    x: Samples.
    new_time: instants wanted (s), increasing, within the recorded ones.
    band_hz: cutoff (Hz) of a linear-phase low-pass that is applied first. Needed where the new rate is
    lower than the old one; requires regular ``time``.
    rate_hz: rate of regular ``time`` (Hz), exact where it is known: the length of the filter follows from
    it.
    Returns: resampled signal (unit of ``x``).
    """
    tolerance = 1e-6 * (time[-1] - time[0]) / time.size
    if new_time[0] < time[0] - tolerance or new_time[-1] > time[-1] + tolerance:
        raise InputError(
            f"expected samples from {new_time[0]:.4f} s to {new_time[-1]:.4f} s, found them only from "
            f"{time[0]:.4f} s to {time[-1]:.4f} s: the recording is too short"
        )
    if band_hz is not None and band_hz * (time[-1] - time[0]) < 1.0:
        raise InputError(
            f"expected a recording of at least {1.0 / band_hz:.3g} s for a low-pass at {band_hz:.3g} Hz, "
            f"found {time[-1] - time[0]:.3g} s: raise the rate, or record longer"
        )
    if band_hz is not None:
        x = _band_limit(x, rate_hz or (time.size - 1) / (time[-1] - time[0]), band_hz)
    pieces = list(spline_pieces(time.size))
    wanted = np.split(new_time, np.searchsorted(new_time, [time[within.start] for _, within in pieces[1:]]))
    return np.concatenate(
        [
            scipy.interpolate.CubicSpline(time[around], x[around])(instants)
            for (around, _), instants in zip(pieces, wanted, strict=True)
        ]
    )


def _band_limit(x: np.ndarray, rate_hz: float, band_hz: float) -> np.ndarray:
    """Linear-phase low-pass whose gain is 1 below 0.75 ``band_hz``, 1/2 at it, 0 from 1.25; ends mirrored."""
    half = int(np.ceil(LOBES * rate_hz / band_hz))
    # windowed sinc of static gain 1; importing scipy.signal would take longer than an ingest job
    lag = np.arange(-half, half + 1)
    taps = np.sinc(2.0 * band_hz / rate_hz * lag) * np.kaiser(lag.size, KAISER_BETA)
    taps /= taps.sum()
    columns = x.reshape(x.shape[0], -1)
    half_pad = min(half, x.shape[0] - 1)
    padded = np.pad(columns, ((half_pad, half_pad), (0, 0)), mode="reflect", reflect_type="odd")
    out = np.column_stack([np.convolve(column, taps, mode="same") for column in padded.T])
    return out[half_pad : half_pad + x.shape[0]].reshape(x.shape)


def regular_time(start_s: float, end_s: float, rate_hz: float) -> np.ndarray:
    """Instants k / rate within [start, end] (s), shape (n,); multiples of the period of ``rate_hz`` (Hz)."""
    first = int(np.ceil(start_s * rate_hz - 1e-6))
    last = int(np.floor(end_s * rate_hz + 1e-6))
    return np.arange(first, last + 1) / rate_hz


def rising_edge(line: np.ndarray, threshold: float, what: str) -> int:
    """Index of the first sample of a trigger line (V) at or above ``threshold`` (V)."""
    high = line >= threshold
    if not high.any():
        raise InputError(
            f"{what}: expected the trigger to rise above {threshold:g} V, found at most "
            f"{np.max(line):.3g} V: check that the trigger line was connected"
        )
    if high[0]:
        raise InputError(
            f"{what}: expected the trigger to rise after the log's start, found it high from the "
            "first sample on: start the log before the trigger"
        )
    return int(np.argmax(high))


def rising_edges(line: np.ndarray, what: str) -> Annotated[np.ndarray, "(r,)"]:
    """Samples at which a trigger that repeats rises through the middle of its range.

    what: names the source in messages.
    Returns: first samples above the middle.
    """
    high = line > 0.5 * (line.min() + line.max())
    edges = np.flatnonzero(high[1:] & ~high[:-1]) + 1
    if not edges.size:
        raise InputError(
            f"{what}: expected a trigger that rises at the start of every realisation, found {line[0]:g} "
            "throughout or no rise: name another column"
        )
    return edges


def align_sequential_samples(
    positions: Annotated[np.ndarray, "(n, markers, 3)"], rate_hz: float, marker_sampling_hz: float
) -> tuple[np.ndarray, np.ndarray]:
    """Interpolate sequentially sampled markers (Optotrak strober) at common instants.

    Marker k of frame n is sampled at n / rate + k / strober. Its position at the common instants
    n / rate follows from a cubic spline through its samples. The first frame is dropped, because all
    markers but the first were sampled after its instant.

    positions: positions as sampled (m), without NaN, markers in the order of sequential sampling.
    rate_hz, marker_sampling_hz: frames per second, and markers per second within a frame.

    Returns:
        time: common instants, counted from the first marker of the first frame (s). Shape (n - 1,).
        aligned: positions at these instants (m). Shape (n - 1, markers, 3).
    """
    frames, markers = positions.shape[:2]
    spread = (markers - 1) / marker_sampling_hz
    if spread > 1.0 / rate_hz:
        raise InputError(
            f"expected all markers within a frame of {1e3 / rate_hz:.3g} ms, found {markers} markers that "
            f"take {1e3 * spread:.3g} ms when sampled sequentially at {marker_sampling_hz:g} Hz: correct "
            "marker_sampling_hz (none for cameras)"
        )
    frame_time = np.arange(frames) / rate_hz
    aligned = np.empty((frames - 1, markers, positions.shape[2]))
    for k in range(markers):
        aligned[:, k] = scipy.interpolate.CubicSpline(frame_time + k / marker_sampling_hz, positions[:, k])(
            frame_time[1:]
        )
    return frame_time[1:], aligned


def refuse_short(lasts_s: float, duration_s: float, what: str) -> None:
    """Compare the length of a record (s) with the protocol's (s)."""
    if lasts_s < duration_s - 0.1:
        raise InputError(
            f"{what}: expected {duration_s:g} s of trial, as the trial sheet says, found {lasts_s:.2f} "
            "s: the file is truncated, copy it again, or correct the trial sheet"
        )
