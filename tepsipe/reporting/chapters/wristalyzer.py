"""Chapter on the Wristalyzer: numbers of signals and fits, and conditions of its sentences."""

import math

import numpy as np
import pandas as pd

from tepsipe.experiments.wristalyzer.analysis import validate_other_bounds
from tepsipe.experiments.wristalyzer.names import AS_PRINTED, MODULUS, PERIODS, REGRESSION
from tepsipe.io.result import Result
from tepsipe.reporting.claims import HIGH_VAF
from tepsipe.reporting.run import Run

# a mean coherence below this is that of unrelated signals (-)
UNRELATED = 0.2
# values that differ by less are called the same (%)
ALIKE_PERCENT = 5.0
# a coherence that is nearer to the printed one agrees with it (-)
COHERENCE_APART = 0.05
# errors agree with the printed ones if none of them is larger or smaller by this factor
ERROR_FACTOR = 2.0


def numbers(run: Run) -> dict:
    """Numbers that no table has (units in the keys)."""
    fits = run.fits["wristalyzer"]
    arrays = fits[run.study["best"]].arrays
    content = {
        **_lowest_coherence(run),
        "natural_frequency_Hz": _natural_frequency(run),
        "starts": len(arrays["many_starts/start"]),
        "other_bounds": _other_bounds(fits),
        "torque_rms_Nm": [float(fit.arrays["torque"].std()) for fit in fits.values()],
        "coherence_above_lowpass": _coherence_above_lowpass(run),
        "damping_shift_percent": _damping_shift(run),
        "nearest_bins": _nearest_bins(run),
    }
    return content | {"pooled": _pooled(run)}


def _other_bounds(fits: dict[str, Result]) -> dict:
    """Fits within random bounds: all, at the minimum of the printed bounds, of high VAF; losses in one trial.

    A loss (%) is the VAF of a fit in its own trial less its lowest VAF in another one; None without a fit.
    """
    ends = [
        np.isclose(found, fit.arrays[f"{AS_PRINTED}/parameters"], rtol=1e-3).all(axis=1)
        for fit in fits.values()
        if (found := fit.arrays["other_bounds/parameters"]).size
    ]
    scores = validate_other_bounds(fits)
    return {
        "fits": sum(end.size for end in ends),
        "usual": sum(int(end.sum()) for end in ends),
        "kept": int((scores[:, 0] >= HIGH_VAF).sum()),
        "largest_loss_in_one_trial_percent": _largest_loss(scores),
        "printed_bounds_loss_in_one_trial_percent": _largest_loss(
            validate_other_bounds(fits, f"{AS_PRINTED}/parameters")
        ),
    }


def _largest_loss(scores: np.ndarray) -> float | None:
    """Largest loss of VAF in one other trial (%) by fits whose own VAF is high."""
    own, _, lowest = scores[scores[:, 0] >= HIGH_VAF].T
    return float((own - lowest).max()) if own.size else None


def _lowest_coherence(run: Run) -> dict:
    """The lowest coherence in the fitted band, and its frequency."""
    arrays = run.fits["wristalyzer"][run.study["best"]].arrays
    frequency, coherence = arrays[f"{AS_PRINTED}/frequency"], arrays[f"{AS_PRINTED}/coherence"]
    low, high = run.settings["wristalyzer"]["analysis"]["fit_band_hz"]
    inside = np.flatnonzero((frequency >= low) & (frequency <= high))
    lowest = inside[np.argmin(coherence[inside])]
    return {"coherence": coherence[lowest], "coherence_at_Hz": frequency[lowest]}


def _natural_frequency(run: Run) -> float | None:
    best = run.study["best"]
    inertia, stiffness = (_fitted(run, quantity)[best] for quantity in ("I", "K"))
    return math.sqrt(stiffness / inertia) / 2.0 / math.pi if stiffness * inertia > 0.0 else None


def _fitted(run: Run, quantity: str, estimator: str = AS_PRINTED) -> pd.Series:
    return run.values("wristalyzer", quantity, estimator=estimator)


def _coherence_above_lowpass(run: Run) -> float:
    """Mean coherence of the tapered estimate beyond the low-pass."""
    arrays = run.fits["wristalyzer"][run.study["best"]].arrays
    cutoff_hz = run.settings["wristalyzer"]["analysis"]["lowpass_cutoff_hz"]
    above = arrays["tapered/coherence"][arrays["tapered/frequency"] > 1.05 * cutoff_hz]
    return float(np.mean(above)) if above.size else math.nan


def _damping_shift(run: Run) -> float | None:
    """Largest difference of B between averages over frequencies and over periods (%)."""
    averaged, periodic = (_fitted(run, "B", name) for name in (AS_PRINTED, PERIODS))
    return 100.0 * float((averaged / periodic - 1.0).abs().max()) if len(periodic) else None


def _printed(run: Run, row: str) -> pd.Series:
    """A row of Table 4-1 as the thesis prints it, by condition (unit of the row); empty without a thesis."""
    reported = run.study["reported"] or {}
    return pd.Series(reported.get("tables", {}).get("table_4_1", {}).get(row, {}), dtype=float)


def _distance_to_errors(run: Run) -> pd.Series:
    """Largest factor between errors of the run and printed errors, by number of averaged frequencies."""
    rows = run.rows("averaging")
    factor = np.log(rows.error.to_numpy() / rows.condition.map(_printed(run, "error")).to_numpy())
    return np.exp(pd.Series(np.abs(factor), index=rows.averaged_bins)).groupby(level=0).max().dropna()


def _distance_to_coherence(run: Run) -> pd.Series:
    """Distance of the lowest coherence of the example from the printed one, by number of frequencies."""
    rows = run.rows("averaging", condition=run.study["best"])
    rows = rows[rows.averaged_bins > 1]
    printed = run.study["reported"]["values"]["coherence_minimum"]
    return (rows.set_index("averaged_bins").lowest_coherence - printed).abs()


def _nearest_bins(run: Run) -> dict | None:
    """Numbers of averaged frequencies with the errors and with the coherence nearest to the printed ones."""
    if not swept(run):
        return None
    distances = {"error": _distance_to_errors(run), "coherence": _distance_to_coherence(run)}
    return {name: int(distance.idxmin()) for name, distance in distances.items()}


def _pooled(run: Run) -> list[dict] | None:
    """K and B of the rubber, and of the friction of the manipulator, by trial."""
    if "wristalyzer_pooled" not in run.fits:
        return None
    pooled = run.fits["wristalyzer_pooled"]["wristalyzer_pooled"]
    shares = {n.removeprefix("shares/"): a for n, a in pooled.arrays.items() if n.startswith("shares/")}

    def share(trial: int, *names: str) -> dict:
        own = sum(shares[name][trial] for name in names if name in shares)
        return {"B_Nms_per_rad": own[1], "K_Nm_per_rad": own[2]}

    return [
        {
            "condition": condition,
            "rms_angle_rad": pooled.arrays["rms_angle"][k],
            "rubber": share(k, "small", "softening"),
            "friction": share(k, "friction"),
        }
        for k, condition in enumerate(pooled.facts["conditions"])
    ]


# ---- conditions of sentences


def bins_tried(run: Run) -> bool:
    """The number of averaged frequencies was varied."""
    return len(run.rows("averaging")) > 0


def swept(run: Run) -> bool:
    """Errors and coherence of several numbers of averaged frequencies can be compared with printed ones."""
    if not bins_tried(run) or not _printed(run, "error").size:
        return False
    return len(_distance_to_errors(run)) > 0 and len(_distance_to_coherence(run)) > 0


def bins_disagree(run: Run) -> bool:
    """No number of averaged frequencies returns both the printed errors and the printed coherence."""
    if not swept(run):
        return False
    errors, coherence = _distance_to_errors(run), _distance_to_coherence(run)
    return not set(errors.index[errors < ERROR_FACTOR]) & set(coherence.index[coherence < COHERENCE_APART])


def averaging_dips(run: Run) -> bool:
    """Even a linear joint without noise has a lower coherence with the most averaged frequencies."""
    rows = run.rows("averaging", condition=run.study["best"])
    if not len(rows) or not resonant(run):
        return False
    most = rows.loc[rows.averaged_bins.idxmax()]
    near = abs(most.lowest_coherence_Hz / _natural_frequency(run) - 1.0) < 0.25
    return bool(near and most.linear_coherence < 1.0 - COHERENCE_APART)


def sem_not_from_bins(run: Run) -> bool:
    """The SEM of K is below every printed one, whatever the number of averaged frequencies."""
    printed = _printed(run, "SEM_K")
    return bool(swept(run) and run.rows("averaging").K_sem_as_printed.max() < printed.min())


def printed_sem_falls(run: Run) -> bool:
    """From the first to the last condition the printed SEM of K falls, and the printed error rises."""
    sem, error = _printed(run, "SEM_K"), _printed(run, "error")
    return bool(sem.size and error.size and sem.iloc[-1] < sem.iloc[0] and error.iloc[-1] > error.iloc[0])


def one_minimum(run: Run) -> bool:
    """Every fit to the complex residual converged, and to the same K."""
    fits = run.fits["wristalyzer"]
    stiffness = abs(_fitted(run, "K")[run.study["best"]])
    starts = len(fits[run.study["best"]].arrays["many_starts/start"])
    return all(
        fit.facts["many_starts_stiffness_spread_Nm_per_rad"] < 1e-3 * stiffness
        and fit.facts["many_starts_converged"] == starts
        for fit in fits.values()
    )


def modulus_depends(run: Run) -> bool:
    """K of a fit to the modulus differs by more than 1 % between starting values."""
    found = [fit.arrays["tried/modulus"][:, 2] for fit in run.fits["wristalyzer"].values()]
    return any(float(np.ptp(k)) > 0.01 * float(np.abs(k).min()) for k in found)


def only_modulus_depends(run: Run) -> bool:
    """The starting value of K matters to the fit to the modulus, and not to the complex residual."""
    return one_minimum(run) and modulus_depends(run)


def modulus_worse(run: Run) -> bool:
    """The lowest VAF of the fits to the modulus is lower by more than 1 %."""
    modulus = _fitted(run, "VAF_trial", MODULUS)
    return modulus.min() < _fitted(run, "VAF_trial").min() - 1.0


def vaf_peaks(run: Run) -> bool:
    """The VAF falls towards the smallest and towards the largest scale factor."""
    vaf = _fitted(run, "VAF_trial")
    return 0 < int(vaf.fillna(-math.inf).argmax()) < len(vaf) - 1


def coherence_above_thesis(run: Run) -> bool:
    """The coherence of simulated trials is higher than the printed one, by more than 0.05."""
    if not run.simulated or not run.study["reported"]:
        return False
    printed = run.study["reported"]["values"]["coherence_minimum"]
    return _lowest_coherence(run)["coherence"] > printed + 0.05


def last_vaf_above_thesis(run: Run) -> bool:
    """The VAF of simulated trials at the largest scale factor exceeds the printed one by more than 1 %."""
    if not run.simulated or not run.study["reported"]:
        return False
    printed = list(run.study["reported"]["tables"]["table_4_1"]["VAF_trial"].values())[-1]
    return _fitted(run, "VAF_trial").iloc[-1] > printed + 1.0


def spectral_fit_nearer(run: Run) -> bool:
    """The largest errors of I, B and K by the printed criterion are below those of the period regression."""
    own, other = (
        [
            run.rows("recovery", experiment="wristalyzer", estimator=estimator, quantity=quantity)
            .get("relative_error", pd.Series(dtype=float))
            .abs()
            .max()
            for quantity in ("I", "B", "K")
        ]
        for estimator in (AS_PRINTED, REGRESSION)
    )
    return all(a < b for a, b in zip(own, other, strict=True))


def unrelated_above_lowpass(run: Run) -> bool:
    """Angle and torque are unrelated beyond the low-pass."""
    return _coherence_above_lowpass(run) < UNRELATED


def cross_validated(run: Run) -> bool:
    """There are several trials, each of which predicts the others."""
    return len(run.fits["wristalyzer"]) > 1 and bool(_fitted(run, "VAF_cross_validated").notna().all())


def resonant(run: Run) -> bool:
    """The fitted joint has a natural frequency."""
    return _natural_frequency(run) is not None


def averages_alike(run: Run) -> bool:
    """Averages over frequencies and over periods yield about the same B."""
    shift = _damping_shift(run)
    # as it is printed
    return shift is not None and round(shift, 1) < ALIKE_PERCENT


def leaks(run: Run) -> bool:
    """A record without its ends is more than 1 % of a period from a whole number of periods."""
    period_s = run.settings["wristalyzer"]["analysis"]["perturbation_period_s"]
    if period_s is None:
        return False
    facts = [fit.facts for fit in run.fits["wristalyzer"].values()]
    periods = [(f["kept_samples"][1] - f["kept_samples"][0]) / f["rate_hz"] / period_s for f in facts]
    return any(abs(p - round(p)) > 0.01 for p in periods)


def pooled(run: Run) -> bool:
    """One joint was fitted to all trials together."""
    return "wristalyzer_pooled" in run.fits


def softens(run: Run) -> bool:
    """The fit to all trials needs a rubber that softens."""
    return len(_pooled_rows(run, "K_softened")) > 0


def friction_found(run: Run) -> bool:
    """The interval of the friction lies above 0."""
    return bool((_pooled_rows(run, "friction").ci_low > 0.0).any())


def _pooled_rows(run: Run, quantity: str) -> pd.DataFrame:
    return run.rows("estimates", experiment="wristalyzer", condition="pooled", quantity=quantity)


def thesis_frequencies_differ(run: Run) -> bool:
    """The printed eigenfrequency differs by more than 5 % from the one of the printed K and I."""
    if not run.study["reported"]:
        return False
    table = run.study["reported"]["tables"]["table_4_1"]
    stiffness, inertia = (np.mean(list(table[quantity].values())) for quantity in ("K", "I"))
    of_joint = math.sqrt(stiffness / inertia) / 2.0 / math.pi
    return bool(abs(run.study["reported"]["values"]["eigenfrequency_hz"] / of_joint - 1.0) > 0.05)


def thesis_stiffness_unchanged(run: Run) -> bool:
    """The printed K differs by less than 1 % between scale factors."""
    if not run.study["reported"]:
        return False
    printed = np.array(list(run.study["reported"]["tables"]["table_4_1"]["K"].values()))
    return bool(np.ptp(printed) < 0.01 * printed.mean())


PREDICATES = (
    bins_tried,
    swept,
    bins_disagree,
    averaging_dips,
    sem_not_from_bins,
    printed_sem_falls,
    one_minimum,
    modulus_depends,
    only_modulus_depends,
    modulus_worse,
    vaf_peaks,
    coherence_above_thesis,
    last_vaf_above_thesis,
    spectral_fit_nearer,
    unrelated_above_lowpass,
    cross_validated,
    resonant,
    averages_alike,
    leaks,
    pooled,
    softens,
    friction_found,
    thesis_frequencies_differ,
    thesis_stiffness_unchanged,
)
