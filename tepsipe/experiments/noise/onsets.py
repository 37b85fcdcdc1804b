"""Detection of perturbations with noise on the velocity of the belt (thesis chapter 5).

Symbols: v velocity of the belt without noise (m/s), F the low-pass filter, n white Gaussian noise.

    sd(n)^2 = max over the trials of a profile (mean v^2) / SNR,     perturbations of v + F n

The noise is the same at every amplitude of a profile, because the instruments do not change with it. A
perturbation is found if the detection of the analysis has an onset less than `NEAR_S` from its onset without
noise. Of a trial that the detection refuses nothing is found.
"""

from collections.abc import Iterable

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.noise.filtered_noise import cell_generators
from tepsipe.experiments.noise.rows import NoiseRow
from tepsipe.experiments.noise.trial import SimulatedTrial
from tepsipe.signals.perturbations import WindowOptions, filtered_perturbations
from tepsipe.treadmill.prepared import Filter

BELT, DETECTION, FOUND, ERROR = "belt", "detection", "onsets_found", "onset_error"
# half of a commanded pulse (s)
NEAR_S = 0.05


def onset_rows(
    trial: SimulatedTrial,
    others: Iterable[SimulatedTrial],
    levels_db: Iterable[float],
    draws: int,
    seed: int,
    window: WindowOptions,
    lowpass: Filter,
) -> list[NoiseRow]:
    """Share of the perturbations that are found (%), and RMS error of their onsets (ms), at every level.

    others: further trials of the profile.
    levels_db: signal power over noise power.
    draws, seed: as for `sweep`.
    window: search for perturbations.
    lowpass: filter of the noise; takes a signal and its rate.
    Returns: two rows per level; one if nothing was found.
    """
    power = max(float(np.mean(one.y_foot_d**2)) for one in (trial, *others))
    expected, rows = trial.windows[:, 0], []
    for level in levels_db:
        generator, _ = cell_generators(seed, trial.name, BELT, f"{level:g}")
        deviation = np.sqrt(power / 10.0 ** (level / 10.0))
        shares, errors = np.zeros(draws), []
        for k in range(draws):
            noise = deviation * generator.standard_normal(trial.time.size)
            velocity = trial.y_foot_d + lowpass(noise, trial.rate_hz)
            try:
                found = filtered_perturbations(velocity, trial.rate_hz, window, trial.name)
            except InputError:
                continue
            onsets = np.array([p.start for p in found])
            distance = onsets[:, None] - expected
            nearest = distance[np.abs(distance).argmin(axis=0), np.arange(expected.size)] / trial.rate_hz
            near = np.abs(nearest) < NEAR_S
            # a false onset counts as one that is missed
            shares[k] = near.sum() / max(expected.size, onsets.size)
            errors.extend(1e3 * nearest[near])
        numbers = {FOUND: ("%", 100.0 * shares.mean(), 100.0 * shares.std())}
        if errors:
            numbers[ERROR] = ("ms", float(np.sqrt(np.mean(np.square(errors)))), float(np.std(errors)))
        rows += [
            NoiseRow(
                condition=trial.name,
                noise_on=BELT,
                snr_db=float(level),
                estimator=DETECTION,
                quantity=quantity,
                mean=float(mean),
                sd=float(sd),
                bias=None,
                n_draws=draws,
                unit=unit,
                stiffness_Nm_per_rad=float(trial.truth[2]),
                without_noise=None,
                apparent=None,
            )
            for quantity, (unit, mean, sd) in numbers.items()
        ]
    return rows


def found_from(rows: Iterable[NoiseRow]) -> dict[str, float]:
    """Condition -> lowest level (dB) from which on all its perturbations are found; without those of none."""
    shares: dict[str, dict[float, float]] = {}
    for row in rows:
        if row.quantity == FOUND:
            shares.setdefault(row.condition, {})[row.snr_db] = row.mean
    lowest = {}
    for condition, of_level in shares.items():
        missed = [level for level, share in of_level.items() if share < 100.0]
        found = [level for level in of_level if level > max(missed, default=-np.inf)]
        if found:
            lowest[condition] = min(found)
    return lowest
