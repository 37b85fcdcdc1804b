"""Further statements of the thesis that a run can test: quality, spread, rests, noise (chapters 4 and 5)."""

from collections.abc import Callable

import numpy as np

from tepsipe.experiments.noise.rows import NoiseRow
from tepsipe.experiments.planning.design import FOOT, LEG
from tepsipe.experiments.wristalyzer.names import AS_PRINTED
from tepsipe.mechanics.impedance_model import admittance
from tepsipe.reporting.findings import Findings
from tepsipe.reporting.planned import CHANGE, TYPE_A, planned_value

NOISY = ("tau", "theta", "both")
READING, TRUE_TORQUE = "as-tabulated", "recommended-regression"  # of Table 4-4
START_K = 10.0  # N·m/rad, the simulated joint of Table 4-4
BEST_FACTOR = "0.16"  # the scale factor of thesis Figure 4-1
EXCITED_HZ, DOMINANT_HZ = 20.0, 9.0


def _profiles(values: dict) -> tuple[list[float], list[float]]:
    """Values of sines, and of the minimum-jerk pulses of the same amplitude and interval."""
    both = [name for name in values if name.startswith("sine-") and name.replace("sine", "minjerk") in values]
    if not both:
        raise KeyError("profiles")
    return [values[name] for name in both], [values[name.replace("sine", "minjerk")] for name in both]


def _unexplained(f: Findings, quantity: str, pathway: str | None = None) -> dict:
    return {name: 100.0 - vaf for name, vaf in f.by_condition("dummy", quantity, pathway).items()}


def _minjerk_over_sine(f: Findings) -> float:
    sine, minjerk = _profiles(_unexplained(f, "VAF_trial"))
    return float(np.mean(np.log(minjerk)) - np.mean(np.log(sine)))


def _small_over_large(f: Findings) -> float:
    left = _unexplained(f, "VAF_trial")
    return float(min(left[f"{p}-0.1"] / left[f"{p}-0.5"] for p in ("sine", "minjerk")))


def _foot_over_leg(f: Findings) -> float:
    leg, foot = (_unexplained(f, "VAF_perturbation", pathway) for pathway in (None, "foot-thesis"))
    return float(min(foot[name] / leg[name] for name in leg))


def _at_8_s(quantity: str, profile: str) -> Callable[[Findings], tuple[float, float]]:
    def pair(f: Findings) -> tuple[float, float]:
        values = f.by_condition("dummy", quantity)
        return values[f"{profile}-0.5-8s"], values[f"{profile}-0.5"]

    return pair


def _change(quantity: str, profile: str) -> Callable[[Findings], float]:
    def difference(f: Findings) -> float:
        rarely, often = _at_8_s(quantity, profile)(f)
        return rarely - often

    return difference


def _ratio_8_s(quantity: str, profile: str) -> Callable[[Findings], float]:
    def ratio(f: Findings) -> float:
        rarely, often = _at_8_s(quantity, profile)(f)
        return rarely / often

    return ratio


def _spread_ratio(column: int) -> Callable[[Findings], float]:
    """Ratio of the standard deviation over perturbations at 0.5 m/s to that at 0.1 m/s."""

    def ratio(f: Findings) -> float:
        spread = {
            name: fit.arrays[f"{f.as_printed}/parameters"][:, column].std(ddof=1)
            for name, fit in f.fits["dummy"].items()
        }
        large, small = ([spread[f"{p}-{a}"] for p in ("sine", "minjerk")] for a in ("0.5", "0.1"))
        return float(np.mean(large) / np.mean(small))

    return ratio


def _relative_sems(f: Findings, experiment: str, quantity: str) -> dict[str, float]:
    """Condition -> SEM over value, both of one row of a table."""
    return {
        e.condition: e.sem_as_printed / e.value
        for e in f.estimates
        if (e.experiment, e.quantity) == (experiment, quantity)
        and (experiment == "dummy" or e.estimator == AS_PRINTED)
        and e.sem_as_printed is not None
    }


def _relative_sem(f: Findings) -> float:
    """Smallest ratio of the relative SEM of K to that of I in the Wristalyzer."""
    inertia, stiffness = (_relative_sems(f, "wristalyzer", quantity) for quantity in ("I", "K"))
    return min(stiffness[name] / inertia[name] for name in inertia)


def _coherence(f: Findings) -> tuple[np.ndarray, np.ndarray]:
    arrays = f.fits["wristalyzer"][BEST_FACTOR].arrays
    return arrays[f"{AS_PRINTED}/frequency"], arrays[f"{AS_PRINTED}/coherence"]


def _lowest_coherence(f: Findings) -> float:
    frequency, coherence = _coherence(f)
    return float(coherence[(frequency >= 1.0) & (frequency <= DOMINANT_HZ)].min())


def _frequency_of_lowest(f: Findings) -> float:
    frequency, coherence = _coherence(f)
    band = (frequency >= 1.0) & (frequency <= DOMINANT_HZ)
    return float(frequency[band][np.argmin(coherence[band])])


def coherence_drop(f: Findings, estimator: str = AS_PRINTED) -> float:
    """Least drop of the mean coherence from within the excited band to above it, by a spectral estimator."""
    drops = []
    for fit in f.fits["wristalyzer"].values():
        frequency, coherence = (fit.arrays[f"{estimator}/{name}"] for name in ("frequency", "coherence"))
        inside = (frequency >= 1.0) & (frequency <= EXCITED_HZ)
        above = (frequency > 1.1 * EXCITED_HZ) & (frequency <= 2.0 * EXCITED_HZ)
        drops.append(coherence[inside].mean() - coherence[above].mean())
    return float(min(drops))


def _above_9_hz(f: Findings) -> float:
    """Largest ratio of the mean admittance from 9 to 20 Hz to that below 9 Hz."""
    ratios = []
    for fit in f.fits["wristalyzer"].values():
        frequency = fit.arrays[f"{AS_PRINTED}/frequency"]
        size = np.abs(fit.arrays[f"{AS_PRINTED}/response"])
        below = (frequency >= 1.0) & (frequency < DOMINANT_HZ)
        above = (frequency >= DOMINANT_HZ) & (frequency <= EXCITED_HZ)
        ratios.append(size[above].mean() / size[below].mean())
    return float(max(ratios))


def _transition_line(f: Findings) -> float:
    """Distance of the response from the fitted model: from 9 to 20 Hz, relative to below 9 Hz."""
    arrays = f.fits["wristalyzer"][BEST_FACTOR].arrays
    frequency, response = (arrays[f"{AS_PRINTED}/{name}"] for name in ("frequency", "response"))
    response, frequency = response[frequency > 0], frequency[frequency > 0]
    misfit = np.abs(np.log(response / admittance(arrays[f"{AS_PRINTED}/parameters"], frequency)))
    below = misfit[(frequency >= 1.0) & (frequency < DOMINANT_HZ)].mean()
    return float(misfit[(frequency >= DOMINANT_HZ) & (frequency <= EXCITED_HZ)].mean() / below)


def _minima(f: Findings) -> float:
    """Number of windows in which eq (3-9) does not have exactly one least-squares solution.

    The equation is linear in I, B and K, so its sum of squares is a paraboloid with one minimum, unless the
    regressors depend on each other. In that case a standard error is not finite.
    """
    errors = [fit.arrays[f"{f.as_printed}/standard_errors"] for fit in f.fits["dummy"].values()]
    return float(sum((~np.isfinite(one).all(axis=1)).sum() for one in errors)) if errors else np.nan


def _times_the_truth(quantity: str) -> Callable[[Findings], float]:
    def ratio(f: Findings) -> float:
        found = np.mean([f.noisy(READING, quantity, target) for target in NOISY])
        return float(found / f.noisy(TRUE_TORQUE, quantity, "none"))

    return ratio


def _on_angle_validates_best(f: Findings) -> float:
    tau, theta, both = (f.noisy(READING, "VAF_cross_validated", target) for target in NOISY)
    return theta - max(tau, both)


def _spreads(f: Findings, estimator: str, noise_on: str) -> list[NoiseRow]:
    """Rows of K of the sines, by one processing and noise target."""
    rows = [
        row
        for row in f.noise
        if (row.estimator, row.noise_on, row.quantity) == (estimator, noise_on, "K")
        and row.condition.startswith("sine")
    ]
    if not rows:
        raise KeyError(estimator)
    return rows


def _spread_of_smallest(f: Findings) -> float:
    spread = {row.condition: row.sd for row in _spreads(f, READING, "tau")}
    return spread["sine-0.1"] / max(sd for name, sd in spread.items() if name != "sine-0.1")


def _spread_by_target(f: Findings) -> float:
    theta, tau = (np.mean([row.sd for row in _spreads(f, READING, target)]) for target in ("theta", "tau"))
    return float(theta / tau)


def _growth(f: Findings, condition: str, parameter_set: str = "thesis-tep") -> float:
    """Largest swing of a simulated trial relative to the swing after its first perturbation."""
    found = [
        s.growth
        for s in f.forward
        if (s.condition, s.parameter_set, s.quantity) == (condition, parameter_set, "theta")
    ]
    if not found:
        raise KeyError(parameter_set)
    return float(found[0])


def _largest_ratio_with_noise(f: Findings) -> float:
    """Largest ratio of I, B or K with noise to the simulated one."""
    true = {q: f.noisy(TRUE_TORQUE, q, "none") for q in ("I", "B", "K")}
    return max(f.noisy(READING, q, target) / true[q] for q in true for target in NOISY)


def _effect_of_snr(f: Findings) -> float:
    """Range of the mean of K over the signal-to-noise ratios relative to the simulated K, the largest."""
    ranges = []
    for target in NOISY:
        rows = [row for row in _spreads(f, "as-printed", target) if row.stiffness_Nm_per_rad == START_K]
        means = [np.mean([r.mean for r in rows if r.snr_db == snr]) for snr in {r.snr_db for r in rows}]
        ranges.append(np.ptp(means) / START_K)
    return float(max(ranges))


def _mass_sd(condition: str) -> Callable[[Findings], float]:
    return lambda f: f.by_condition("weight", "mass_sd")[condition]


def _planned_ratio(more: tuple[str, str], less: tuple[str, str]) -> Callable[[Findings], float]:
    """Ratio of two planned standard uncertainties of K, of (design, pathway) each."""

    def ratio(f: Findings) -> float:
        first, second = (planned_value(f.planned, d, TYPE_A, "K", p) for d, p in (more, less))
        return first / second

    return ratio


def _planned_change(of_filter: str) -> Callable[[Findings], float]:
    """Size of the change of K by a filter without noise (%)."""
    return lambda f: abs(planned_value(f.planned, of_filter, CHANGE, "K"))


def _uncompensated(f: Findings) -> float:
    """Mean distance of K by plate and foot from that by the leg, without over with a treadmill model."""
    leg, foot, compensated = (
        {
            e.condition: e.value
            for e in f.estimates
            if (e.experiment, e.pathway, e.quantity) == ("dummy", pathway, "K")
        }
        for pathway in ("leg", "foot", "foot-compensated")
    )
    without, with_model = (
        np.mean([abs(values[name] - leg[name]) for name in leg]) for values in (foot, compensated)
    )
    return float(without / with_model)


MEASURES: dict[str, Callable[[Findings], float]] = {
    "wristalyzer_lowest_vaf": lambda f: min(f.by_condition("wristalyzer", "VAF_trial").values()),
    "wristalyzer_lowest_vaf_figure": lambda f: min(f.by_condition("wristalyzer", "VAF_trial").values()),
    "wristalyzer_lowest_cross_validated_figure": lambda f: min(
        f.by_condition("wristalyzer", "VAF_cross_validated").values()
    ),
    "wristalyzer_highest_cross_validated": lambda f: max(
        f.by_condition("wristalyzer", "VAF_cross_validated").values()
    ),
    "wristalyzer_relative_sem": _relative_sem,
    "wristalyzer_lowest_coherence": _lowest_coherence,
    "wristalyzer_frequency_of_lowest_coherence": _frequency_of_lowest,
    "wristalyzer_coherence_drop": coherence_drop,
    "wristalyzer_above_9_hz": _above_9_hz,
    "pulse_length": lambda f: 1e3 * min(fit.facts["mean_window_s"] for fit in f.fits["dummy"].values()),
    "printed_lowest_cross_validated": lambda f: min(f.by_condition("dummy", "VAF_cross_validated").values()),
    "printed_minjerk_over_sine": _minjerk_over_sine,
    "printed_small_over_large": _small_over_large,
    "printed_negative_dampings": lambda f: float(sum(b < 0.0 for b in f.by_condition("dummy", "B").values())),
    "printed_damping_change_sine_8s": _change("B", "sine"),
    "printed_damping_change_minjerk_8s": _change("B", "minjerk"),
    "printed_stiffness_ratio_sine_8s": _ratio_8_s("K", "sine"),
    "printed_stiffness_ratio_minjerk_8s": _ratio_8_s("K", "minjerk"),
    "printed_inertia_spread_ratio": _spread_ratio(0),
    "printed_damping_spread_ratio": _spread_ratio(1),
    "foot_over_leg": _foot_over_leg,
    "weight_sd_sine_low": _mass_sd("sine-0.1"),
    "weight_sd_minjerk_low": _mass_sd("minjerk-0.1"),
    "weight_sd_sine_high": _mass_sd("sine-0.5"),
    "weight_sd_minjerk_high": _mass_sd("minjerk-0.5"),
    "simulated_angle_matched": lambda f: float(np.median(f.followed("thesis-wristalyzer", "theta"))),
    "simulated_angle_of_tep": lambda f: max(f.followed("thesis-tep", "theta")),
    "simulated_torque_of_tep": lambda f: min(f.followed("thesis-tep", "tau")),
    "simulated_amplifies": lambda f: _growth(f, "sine-0.5"),
    "simulated_amplifies_less": lambda f: _growth(f, "sine-0.5") / _growth(f, "sine-0.5-8s"),
    "wristalyzer_transition_line": _transition_line,
    "wristalyzer_local_minima": lambda f: max(
        fit.facts["many_starts_stiffness_spread_Nm_per_rad"] for fit in f.fits["wristalyzer"].values()
    ),
    "wristalyzer_sem": lambda f: max(
        max(_relative_sems(f, "wristalyzer", quantity).values()) for quantity in ("I", "B")
    ),
    "printed_sem": lambda f: max(_relative_sems(f, "dummy", "K").values()),
    "printed_minima": _minima,
    "printed_over_wristalyzer": lambda f: float(
        np.mean(list(f.by_condition("dummy", "I").values()))
        / np.mean(list(f.by_condition("wristalyzer", "I").values()))
    ),
    "noise_largest_ratio": _largest_ratio_with_noise,
    "noise_inertia_ratio": _times_the_truth("I"),
    "noise_damping_ratio": _times_the_truth("B"),
    "noise_angle_validates_best": _on_angle_validates_best,
    "noise_snr_effect": _effect_of_snr,
    "noise_spread_of_smallest": _spread_of_smallest,
    "noise_spread_by_target": _spread_by_target,
    "treadmill_left_in": _uncompensated,
    "planned_minjerk_over_sine": _planned_ratio(("minjerk-0.3", LEG), ("sine-0.3", LEG)),
    "planned_small_over_large": _planned_ratio(("sine-0.1", LEG), ("sine-0.5", LEG)),
    "planned_foot_over_leg": _planned_ratio(("sine-0.3", FOOT), ("sine-0.3", LEG)),
    "planned_zero_lag_filter": _planned_change("zero-lag, all signals"),
    "planned_one_sided_filter": _planned_change("one-sided, torque only"),
}
