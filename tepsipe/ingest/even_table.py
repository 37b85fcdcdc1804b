"""From columns with time stamps of their own to a regular clock, alike for every table of a joint."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.signals.resampling import (
    BAND_PER_RATE,
    RepairedTime,
    fill_gaps,
    refuse_short,
    regular_time,
    repair_time_stamps,
    resample,
    runs_of,
)

# zeros in a row that may stand for missing samples: at least this number, for at most this time (s)
FEWEST_ZEROS, LONGEST_ZEROS_S = 3, 1.0


@dataclass(frozen=True)
class RecordedColumns:
    """Columns of a table at their own instants, with repeated stamps and gaps removed."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    """Instants from the first sample on."""
    columns: Annotated[np.ndarray, "(n, c)"]
    """Values (units of the table)."""
    missing: np.ndarray
    """Samples that were filled."""
    repaired: RepairedTime
    """Repairs of the time stamps (s)."""
    recorded_hz: float
    """Mean rate."""

    @property
    def attributes(self) -> dict[str, float]:
        """Attributes of a trial from its table: repaired samples and the mean rate (Hz)."""
        return {
            "repeated_stamps": self.repaired.repeated,
            "missing_samples": int(self.missing.sum()),
            "recorded_rate_hz": self.recorded_hz,
        }

    def steps(self, rate_hz: float) -> tuple[str, ...]:
        """Processing of a signal that is resampled to ``rate_hz`` (Hz), in words."""
        return (
            f"{self.repaired.repeated} repeated stamps dropped",
            f"{int(self.missing.sum())} missing samples filled",
            f"resampled from {self.recorded_hz:.4g} to {rate_hz:g} Hz",
        )

    def resampled(self, columns: np.ndarray, rate_hz: float) -> tuple[np.ndarray, np.ndarray]:
        """Regular instants (s) and ``columns``, shape (n, c), at these instants."""
        grid = regular_time(self.time[0], self.time[-1], rate_hz)
        band = BAND_PER_RATE * rate_hz if rate_hz < 0.99 * self.recorded_hz else None
        return grid, np.column_stack([resample(self.time, x, grid, band) for x in columns.T])


def recorded_columns(
    table: dict[str, np.ndarray], keys: list[str], max_gap_s: float, duration_s: float, name: str
) -> RecordedColumns:
    """Columns of a table with its time stamps repaired and its gaps filled.

    table: ``time`` (s) and the columns.
    keys: columns wanted.
    max_gap_s, duration_s: longest gap, and length of the trial by the protocol.
    name: names the source in messages.
    """
    usual_s = float(np.nanmedian(np.diff(table["time"]))) if table["time"].size > 1 else 0.0
    if usual_s > 0.999 * max_gap_s:
        raise InputError(
            f"{name}: expected samples closer than {max_gap_s:g} s, found one every {usual_s:.3g} s: convert "
            "the time to seconds if it is not, record faster, or increase max_gap_s in the configuration"
        )
    repaired = repair_time_stamps(table["time"], max_gap_s, name)
    time = table["time"][repaired.keep]
    time = time - time[0]
    refuse_short(time[-1], duration_s, name)
    recorded_hz = (time.size - 1) / (time[-1] - time[0])
    values = np.column_stack([table[key] for key in keys])[repaired.keep]
    for key, column in zip(keys, values.T, strict=True):
        _refuse_placeholders(time, column, key.replace("_", " "), name)
    columns, missing = fill_gaps(values, recorded_hz, max_gap_s, name)
    return RecordedColumns(time, columns, missing, repaired, recorded_hz)


def _refuse_placeholders(time: np.ndarray, values: np.ndarray, what: str, name: str) -> None:
    """Refuse runs of zeros that a signal enters or leaves by larger steps than it takes anywhere else."""
    steps = np.abs(np.diff(values))
    zero = values == 0.0
    runs = [(start, stop) for start, stop in runs_of(zero) if stop - start >= FEWEST_ZEROS]
    border = zero[1:] | zero[:-1]
    usual = float(np.nanmax(steps[~border], initial=0.0))
    for start, stop in runs:
        if time[stop - 1] - time[start] > LONGEST_ZEROS_S:  # a signal that stands still
            continue
        beside = steps[[k for k in (start - 1, stop - 1) if 0 <= k < steps.size]]
        if usual > 0.0 and np.nanmax(beside, initial=0.0) > usual:
            raise InputError(
                f"{name}: expected the {what} of every sample, found {stop - start} zeros in a row at "
                f"{time[start]:.3f} s, which it enters or leaves by a larger step than any other: leave the "
                "fields of missing samples empty"
            )


def refuse_slow(recorded_hz: float, rate_hz: float, setting: str, name: str) -> None:
    """Refuse a recording slower than the rate of the trial (Hz); ``setting`` names the key to lower."""
    if rate_hz > recorded_hz * 1.001:
        raise InputError(
            f"{name}: expected a recording at {rate_hz:g} Hz or faster, found {recorded_hz:.4g} Hz: lower "
            f"{setting} in the configuration"
        )
