"""Claims of the thesis that can be tested, with the findings of this run (thesis chapters 4 and 5)."""

import difflib
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from operator import sub, truediv

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.dummy.results import cross_validate_dummy, without_own
from tepsipe.experiments.forward.scores import ForwardScore
from tepsipe.experiments.noise.onsets import found_from
from tepsipe.experiments.noise.rows import NoiseRow
from tepsipe.experiments.planning.design import FOOT, LEG
from tepsipe.experiments.weight.analysis import shapes, speed_at_peak, usual_weight
from tepsipe.experiments.wristalyzer.analysis import validate_other_bounds
from tepsipe.experiments.wristalyzer.names import AS_PRINTED, MODULUS, PATHWAY
from tepsipe.io.estimates import Estimate
from tepsipe.io.result import Result
from tepsipe.io.tables import Table
from tepsipe.mechanics.impedance_model import PARAMETERS, admittance
from tepsipe.reporting.ledger import (
    CONTRADICTED,
    EXPLAINED,
    FITTED,
    IMPLIED,
    NOT_COMPUTED,
    NOT_REPRODUCED,
    PREDICTED,
    WITHIN,
    basis_of,
    null_verdict_of,
)
from tepsipe.reporting.planned import CHANGE, TYPE_A, PlannedRow, planned_value
from tepsipe.reporting.thesis_tables import TABLE_COLUMNS, TableRow
from tepsipe.treadmill.calibration import ModelScore

WRISTALYZER_TABLE, NOISE_TABLE = "table_4_1", "table_4_4"


@dataclass(frozen=True)
class Findings:
    """Results of this run against which claims are tested."""

    estimates: list[Estimate]
    """All estimates (units in them)."""
    fits: dict[str, dict[str, Result]]
    """Experiment -> condition -> fit."""
    as_printed: str
    """Pathway that reproduces the thesis."""
    scores: list[ModelScore] = field(default_factory=list)
    """Scores of the treadmill models (units in them)."""
    forward: list[ForwardScore] = field(default_factory=list)
    """Scores of the forward simulations (%)."""
    table_4_4: list[TableRow] = field(default_factory=list)
    """Rows of Table 4-4 (units in them)."""
    noise: list[NoiseRow] = field(default_factory=list)
    """Rows of the noise study (units in them)."""
    recorded: bool = False
    """Whether no trial of manipulator and dummy was simulated: nothing was fitted or predicted."""
    planned: list[PlannedRow] = field(default_factory=list)
    """What the planning says about the thesis's experiments (units in them)."""

    def score(self, model: str, train: str, test: str, load: str, cutoff_hz: float) -> float:
        """R2 (-) of a treadmill model."""
        wanted = (model, train, test, load, cutoff_hz)
        for s in self.scores:
            if (s.model, s.train, s.test, s.load, s.cutoff_hz) == wanted:
                return s.r2
        raise KeyError(wanted)

    def followed(self, parameter_set: str, quantity: str, vaf: str = "vaf_trial") -> list[float]:
        """VAF (%) of a simulated quantity over the trial or the perturbations, condition by condition."""
        wanted = (parameter_set, quantity)
        return [getattr(s, vaf) for s in self.forward if (s.parameter_set, s.quantity) == wanted]

    def noisy(self, estimator: str, quantity: str, noise_on: str) -> float:
        """Cell of Table 4-4 for the first simulated stiffness (unit of the quantity)."""
        for row in self.table_4_4:
            if (row.pathway, row.quantity) == (estimator, quantity):
                value = row.values[TABLE_COLUMNS.index(noise_on)]
                if value is not None:
                    return value
        raise KeyError(quantity)

    def by_condition(self, experiment: str, quantity: str, pathway: str | None = None) -> dict:
        """Condition -> value of a quantity (unit of the quantity), as printed."""
        if experiment not in self.fits:
            raise KeyError(experiment)
        pathways = {"wristalyzer": PATHWAY, "dummy": pathway or self.as_printed}
        return {
            e.condition: e.value
            for e in self.estimates
            if e.experiment == experiment
            and e.quantity == quantity
            and e.pathway == pathways.get(experiment, "force")
            and (experiment != "wristalyzer" or e.estimator == AS_PRINTED)
        }


def findings_of_cells(cells: dict[tuple[str, str, str], float], as_printed: str) -> Findings:
    """Findings of a study that consists of printed cells: what a measure is by the thesis's own numbers.

    cells: (table, row, column) -> number (unit of the row), as `tepsipe.reporting.ledger` has them.
    as_printed: pathway of Tables 4-2 and 4-3.
    Returns: estimates with their SEMs, and the rows of Table 4-4; nothing else.
    """
    estimates, noise = [], {}
    for (table, row, column), value in cells.items():
        if table == NOISE_TABLE:
            noise.setdefault(row, {})[column] = value
        elif not row.startswith("SEM_"):
            sem = cells.get((table, f"SEM_{row}", column))
            names = (
                ("wristalyzer", column, PATHWAY, AS_PRINTED)
                if table == WRISTALYZER_TABLE
                else ("dummy", column, as_printed, "printed")
            )
            estimates.append(Estimate(*names, row, "as printed", value, sem_as_printed=sem))
    nothing = [None] * len(TABLE_COLUMNS)
    rows = []
    for row, columns in noise.items():
        values = [columns.get(column) for column in TABLE_COLUMNS]
        true = [values[0], *nothing[1:]]
        rows.append(TableRow("as-tabulated", "printed", row, "as printed", values, nothing))
        rows.append(TableRow("recommended-regression", "printed", row, "as printed", true, nothing))
    fits = {e.experiment: {} for e in estimates}
    return Findings(estimates, fits, as_printed, table_4_4=rows)


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


def _lowest_predicted(f: Findings) -> float:
    """Lowest mean VAF (%) with which the parameters of the other trials predict a trial."""
    vafs = without_own(cross_validate_dummy(f.fits["dummy"], f.as_printed))
    return float(vafs.mean(axis=1).min())


def _foot_over_leg(f: Findings) -> float:
    leg, foot = (_unexplained(f, "VAF_perturbation", pathway) for pathway in (None, "foot-thesis"))
    return float(min(foot[name] / leg[name] for name in leg))


def _every_8_s(
    compare: Callable[[float, float], float], quantity: str, profile: str
) -> Callable[[Findings], float]:
    """A quantity of pulses every 8 s compared with that of pulses every 4 s."""

    def compared(f: Findings) -> float:
        values = f.by_condition("dummy", quantity)
        return compare(values[f"{profile}-0.5-8s"], values[f"{profile}-0.5"])

    return compared


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


def _lost_with_other_bounds(f: Findings) -> float:
    """Largest loss of mean VAF in cross-validation (%) by a fit within random bounds with a high own VAF."""
    own, others, _ = validate_other_bounds(f.fits["wristalyzer"]).T
    high = own >= HIGH_VAF
    return float((own[high] - others[high]).max())


def _minima(f: Findings) -> float:
    """Number of windows in which eq (3-9) does not have exactly one least-squares solution.

    The equation is linear in I, B and K, so its sum of squares is a paraboloid with one minimum, unless the
    regressors depend on each other. In that case a standard error is not finite.
    """
    errors = [fit.arrays[f"{f.as_printed}/sem"][:, -1] for fit in f.fits["dummy"].values()]
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


def _noise_of_amplitude(f: Findings) -> float:
    """Lowest level (dB) with all pulses found at 0.1 m/s less the one at 0.5 m/s, the smaller one."""
    lowest = found_from(f.noise)
    return min(lowest[f"{profile}-0.1"] - lowest[f"{profile}-0.5"] for profile in ("sine", "minjerk"))


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


def _mean(values: dict) -> float:
    return float(np.mean(list(values.values())))


def _extreme(
    of: Callable[[Iterable[float]], float], experiment: str, quantity: str
) -> Callable[[Findings], float]:
    return lambda f: of(f.by_condition(experiment, quantity).values())


def _at(values: dict, *amplitudes: str) -> list[float]:
    """Values of the conditions with one of the amplitudes (m/s), every 4 s."""
    return [v for name, v in values.items() if name.split("-", 1)[-1] in amplitudes]


def _ratio(values: dict) -> float:
    return float(np.mean(_at(values, "0.5")) / np.mean(_at(values, "0.1")))


def _over_others(values: dict, condition: str) -> float:
    """Value of a condition relative to the largest of the other profiles and amplitudes (-)."""
    others = {f"{profile}-0.{k}" for profile in ("sine", "minjerk") for k in range(1, 6)} - {condition}
    return values[condition] / max(values[name] for name in others)


def _gap(quantity: str, better: str, worse: str, vaf: str = "vaf_trial") -> Callable[[Findings], float]:
    """Lowest VAF (%) of a simulated quantity by one parameter set less the highest by another."""
    return lambda f: min(f.followed(better, quantity, vaf)) - max(f.followed(worse, quantity, vaf))


def _unsettled(forward: list[ForwardScore]) -> float:
    """Number of conditions in which a leg with the printed TEP-SIPE parameters does not settle."""
    states = {s.condition: s.state for s in forward if s.parameter_set == "thesis-tep"}
    if not states:
        raise KeyError("forward")
    return float(sum(state != "settles" for state in states.values()))


def _least_step(values: dict) -> float:
    """Smallest ratio between one amplitude and the next lower one, over both profiles."""
    steps = []
    for profile in ("sine", "minjerk"):
        along = [values[f"{profile}-0.{k}"] for k in range(1, 6)]
        steps += [b / a for a, b in pairwise(along)]
    return min(steps)


def _least_fact(findings: Findings, fact: str) -> float:
    """Smallest of a fact (any unit) over the trials in which the person stood still."""
    facts = [fit.facts[fact] for fit in findings.fits["standing"].values() if fit.facts["responses"]]
    return float(min(facts))


def _shortest_latency(findings: Findings) -> float:
    """Shortest latency of all muscles in all tasks (s)."""
    found = [e.value for e in findings.estimates if e.quantity.startswith("latency_")]
    return min(e for e in found)


def _spread(findings: Findings) -> dict:
    return {
        condition: float(fit.arrays[f"{findings.as_printed}/parameters"][:, 2].std(ddof=1))
        for condition, fit in findings.fits["dummy"].items()
    }


OWN_THRESHOLD = "our threshold, the thesis prints none"
START_STIFFNESS = 10.0  # N·m/rad, Table 3-2
HIGH_VAF = 87.0  # %, lowest of Table 4-1
ROUNDING = 1e-9  # of the difference of two decimal numbers, in any unit

MEASURES: dict[str, Callable[[Findings], float]] = {
    "wristalyzer_inertia": lambda f: _mean(f.by_condition("wristalyzer", "I")),
    "wristalyzer_damping": lambda f: _mean(f.by_condition("wristalyzer", "B")),
    "wristalyzer_stiffness": lambda f: _mean(f.by_condition("wristalyzer", "K")),
    "wristalyzer_stiffness_at_start": lambda f: float(
        sum(abs(k - START_STIFFNESS) < 5e-4 for k in f.by_condition("wristalyzer", "K").values())
    ),
    "wristalyzer_highest_vaf": _extreme(max, "wristalyzer", "VAF_trial"),
    "wristalyzer_best_factor": lambda f: float(
        max(f.by_condition("wristalyzer", "VAF_trial").items(), key=lambda item: item[1])[0]
    ),
    "wristalyzer_lowest_cross_validated": _extreme(min, "wristalyzer", "VAF_cross_validated"),
    "printed_inertia": lambda f: _mean(f.by_condition("dummy", "I")),
    "printed_stiffness_low": lambda f: float(np.mean(_at(f.by_condition("dummy", "K"), "0.1", "0.2", "0.3"))),
    "printed_damping": lambda f: _mean(f.by_condition("dummy", "B")),
    "printed_stiffness_ratio": lambda f: _ratio(f.by_condition("dummy", "K")),
    "printed_lowest_vaf_perturbation": _extreme(min, "dummy", "VAF_perturbation"),
    "printed_lowest_vaf_trial": _extreme(min, "dummy", "VAF_trial"),
    "printed_spread_ratio": lambda f: _ratio(_spread(f)),
    "weight_mass_sine_low": lambda f: f.by_condition("weight", "mass")["sine-0.1"],
    "weight_mass_sine_high": lambda f: f.by_condition("weight", "mass")["sine-0.5"],
    "weight_mass_minjerk_low": lambda f: f.by_condition("weight", "mass")["minjerk-0.1"],
    "weight_mass_minjerk_high": lambda f: f.by_condition("weight", "mass")["minjerk-0.5"],
    "weight_mass_spread_ratio": lambda f: _ratio(f.by_condition("weight", "mass_sd")),
    "weight_mass_fall": lambda f: float(
        np.mean(_at(f.by_condition("weight", "mass"), "0.5"))
        - np.mean(_at(f.by_condition("weight", "mass"), "0.1"))
    ),
    "weight_speed_at_peak": lambda f: min(speed_at_peak(usual_weight(f.fits["weight"]), "20 Hz")),
    "weight_least_step": lambda f: _least_step(f.by_condition("weight", "added_force_peak")),
    "weight_growth": lambda f: _ratio(f.by_condition("weight", "added_force_peak")),
    "weight_largest": lambda f: _over_others(f.by_condition("weight", "added_force_peak"), "minjerk-0.5"),
    "weight_over_empty": lambda f: min(shapes(f.fits["empty"], f.fits["weight"], "20 Hz")[1]),
    "weight_shape_at_10_hz": lambda f: min(shapes(f.fits["empty"], f.fits["weight"], "10 Hz")[0]),
    "weight_size_at_10_hz": lambda f: min(shapes(f.fits["empty"], f.fits["weight"], "10 Hz")[1]),
    "simulated_angle_gap": _gap("theta", "thesis-wristalyzer", "thesis-tep"),
    "simulated_torque_gap": _gap("tau", "thesis-tep", "thesis-wristalyzer"),
    "simulated_angle_gap_in_perturbations": _gap(
        "theta", "thesis-wristalyzer", "thesis-tep", "vaf_perturbation"
    ),
    "simulated_torque_gap_in_perturbations": _gap(
        "tau", "thesis-tep", "thesis-wristalyzer", "vaf_perturbation"
    ),
    "simulated_growth": lambda f: _unsettled(f.forward),
    "noise_free_stiffness": lambda f: f.noisy("as-tabulated", "K", "none"),
    "noise_inertia": lambda f: f.noisy("as-tabulated", "I", "tau"),
    "noise_damping": lambda f: f.noisy("as-tabulated", "B", "tau"),
    "noise_stiffness_angle": lambda f: f.noisy("as-tabulated", "K", "theta"),
    "noise_stiffness_torque": lambda f: f.noisy("as-tabulated", "K", "tau"),
    "noise_cross_validated": lambda f: f.noisy("as-tabulated", "VAF_cross_validated", "tau"),
    "standing_angle_over_sway": lambda f: _least_fact(f, "angle_over_sway"),
    "standing_torque_over_sway": lambda f: _least_fact(f, "torque_over_sway"),
    "standing_shortest_latency": lambda f: 1e3 * _shortest_latency(f),
    "second_order_r2": lambda f: f.score("mass-spring-damper", "empty", "weight", "Fy", 20.0),
    "wristalyzer_lowest_vaf": _extreme(min, "wristalyzer", "VAF_trial"),
    "wristalyzer_lowest_vaf_figure": _extreme(min, "wristalyzer", "VAF_trial"),
    "wristalyzer_lowest_cross_validated_figure": _extreme(min, "wristalyzer", "VAF_cross_validated"),
    "wristalyzer_highest_cross_validated": _extreme(max, "wristalyzer", "VAF_cross_validated"),
    "wristalyzer_relative_sem": _relative_sem,
    "wristalyzer_lowest_coherence": _lowest_coherence,
    "wristalyzer_frequency_of_lowest_coherence": _frequency_of_lowest,
    "wristalyzer_coherence_drop": coherence_drop,
    "wristalyzer_above_9_hz": _above_9_hz,
    "pulse_length": lambda f: 1e3 * min(fit.facts["mean_window_s"] for fit in f.fits["dummy"].values()),
    "printed_lowest_cross_validated": _extreme(min, "dummy", "VAF_cross_validated"),
    "printed_lowest_predicted": _lowest_predicted,
    "printed_minjerk_over_sine": _minjerk_over_sine,
    "printed_small_over_large": _small_over_large,
    "printed_negative_dampings": lambda f: float(sum(b < 0.0 for b in f.by_condition("dummy", "B").values())),
    "printed_damping_change_sine_8s": _every_8_s(sub, "B", "sine"),
    "printed_damping_change_minjerk_8s": _every_8_s(sub, "B", "minjerk"),
    "printed_stiffness_ratio_sine_8s": _every_8_s(truediv, "K", "sine"),
    "printed_stiffness_ratio_minjerk_8s": _every_8_s(truediv, "K", "minjerk"),
    "printed_inertia_spread_ratio": _spread_ratio(0),
    "printed_damping_spread_ratio": _spread_ratio(1),
    "foot_over_leg": _foot_over_leg,
    "weight_sd_sine_low": _mass_sd("sine-0.1"),
    "weight_sd_minjerk_low": _mass_sd("minjerk-0.1"),
    "weight_sd_sine_high": _mass_sd("sine-0.5"),
    "weight_sd_minjerk_high": _mass_sd("minjerk-0.5"),
    "simulated_angle_matched": lambda f: float(np.median(f.followed("thesis-wristalyzer", "theta"))),
    "simulated_angle_of_run": lambda f: float(np.median(f.followed("wristalyzer", "theta"))),
    "simulated_angle_of_tep": lambda f: max(f.followed("thesis-tep", "theta")),
    "simulated_torque_of_tep": lambda f: min(f.followed("thesis-tep", "tau")),
    "simulated_amplifies": lambda f: _growth(f, "sine-0.5"),
    "simulated_amplifies_less": lambda f: _growth(f, "sine-0.5") / _growth(f, "sine-0.5-8s"),
    "wristalyzer_transition_line": _transition_line,
    "wristalyzer_local_minima": lambda f: max(
        fit.facts["many_starts_stiffness_spread_Nm_per_rad"] for fit in f.fits["wristalyzer"].values()
    ),
    "wristalyzer_lost_with_other_bounds": _lost_with_other_bounds,
    "wristalyzer_sem": lambda f: max(
        max(_relative_sems(f, "wristalyzer", quantity).values()) for quantity in ("I", "B")
    ),
    "printed_sem": lambda f: max(
        abs(share) for quantity in PARAMETERS for share in _relative_sems(f, "dummy", quantity).values()
    ),
    "printed_minima": _minima,
    "printed_over_wristalyzer": lambda f: (
        _mean(f.by_condition("dummy", "I")) / _mean(f.by_condition("wristalyzer", "I"))
    ),
    "noise_largest_ratio": _largest_ratio_with_noise,
    "noise_inertia_ratio": _times_the_truth("I"),
    "noise_damping_ratio": _times_the_truth("B"),
    "noise_angle_validates_best": _on_angle_validates_best,
    "noise_snr_effect": _effect_of_snr,
    "noise_spread_of_smallest": _spread_of_smallest,
    "noise_spread_by_target": _spread_by_target,
    "noise_of_amplitude": _noise_of_amplitude,
    "treadmill_left_in": _uncompensated,
    "planned_minjerk_over_sine": _planned_ratio(("minjerk-0.3", LEG), ("sine-0.3", LEG)),
    "planned_small_over_large": _planned_ratio(("sine-0.1", LEG), ("sine-0.5", LEG)),
    "planned_foot_over_leg": _planned_ratio(("sine-0.3", FOOT), ("sine-0.3", LEG)),
    "planned_zero_lag_filter": _planned_change("zero-lag, all signals"),
    "planned_one_sided_filter": _planned_change("one-sided, torque only"),
}


def _modulus_fits_at_start(f: Findings) -> float:
    """Number of fits of the modulus of eq (3-6), which is not smooth, that stay at their starting K."""
    found = [
        e.value
        for e in f.estimates
        if (e.experiment, e.estimator, e.quantity) == ("wristalyzer", MODULUS, "K")
    ]
    return float(sum(abs(k - START_STIFFNESS) < 5e-4 for k in found))


def _tapered_drop(f: Findings) -> float:
    """Drop of the coherence above 20 Hz with a taper, which removes the step between the record's ends."""
    return coherence_drop(f, "tapered")


# number that the explanation of a claim predicts, in place of one outside the tolerance
EXPLANATIONS: dict[str, Callable[[Findings], float]] = {
    "wristalyzer_stiffness_at_start": _modulus_fits_at_start,
    "wristalyzer_coherence_drop": _tapered_drop,
    "noise_free_stiffness": lambda f: f.noisy("recommended-regression", "K", "none"),
}


@dataclass(frozen=True)
class ClaimVerdict:
    """One row of ``claims.csv``."""

    claim: str
    where: str
    unit: str
    """The statement, its place in the thesis, and the unit of its number."""
    reported: float
    reproduced: float | None
    """Number of the thesis and of this run (``unit``); None if this run does not have the result."""
    tolerance: str
    """Largest difference (``unit``), or ``below`` or ``above``."""
    verdict: str
    """See `check_claims`."""
    section: str
    """Section of the report."""
    null_value: float | None
    """Of a null model (``unit``)."""
    null_verdict: str
    """``implied`` if the null model is within the tolerance, otherwise ``not reproduced``."""
    margin: float | None
    """Value of the thesis's own printed numbers (``unit``), if they determine it."""
    used: str
    """What was used to get the number of this run, and whether the claim can discriminate."""
    statements: str
    """Numbers of the statements of chapters 4 to 6 that it tests, joined by ``;``."""
    measure: str
    """Name in `MEASURES` of the number; sentences of the report rest on the claim by this name."""
    reason: str
    """What is known of a number outside the tolerance, with the number that an explanation predicts."""


CLAIM_VERDICTS = Table(ClaimVerdict, "claims")


def check_claims(
    claims: list[dict],
    findings: Findings,
    bases: dict[str, str],
    printed: Findings | None = None,
    nulls: Findings | None = None,
    assertions: list[dict] | None = None,
) -> list[ClaimVerdict]:
    """Test every claim.

    claims: keys claim, where, measure, unit, reported, tolerance, section (``unit`` holds for reported and
    tolerance; the tolerance ``below`` requires less than reported, ``above`` more); verdict, which a
    simulated trial within the tolerance has; used, a name in ``bases``; and optionally null_value and
    margin (``unit``), in place of those by ``nulls`` and ``printed``, own_threshold, true if the thesis
    prints no such number, and outside, the reason of a number outside the tolerance.
    bases: what numbers are obtained from, in words.
    printed, nulls: numbers that the thesis printed, and those of the null models, as `findings_of_cells`
    makes them.
    assertions: statements of the thesis in their order, with the ``measures`` of the claims that test them.
    Returns: one per claim: the verdict is that of the claim within the tolerance (``predicted`` in place of
    ``fitted`` if no trial was simulated), ``explained`` outside it if the number that the explanation
    predicts is within, ``not computed`` if this run does not have the result (reproduced is None),
    otherwise ``not reproduced``. A claim that is ``implied`` is measured on the printed numbers; if these do
    not satisfy it, it is ``contradicted by itself``.
    """
    nothing = Findings([], {}, findings.as_printed)
    rows = [_checked(claim, findings, bases, printed or nothing, nulls or nothing) for claim in claims]
    tested = [
        [k for k, one in enumerate(assertions or [], 1) if claim["measure"] in one.get("measures", ())]
        for claim in claims
    ]
    return [
        replace(row, statements=";".join(map(str, numbers)))
        for row, numbers in zip(rows, tested, strict=True)
    ]


def _checked(
    claim: dict, findings: Findings, bases: dict[str, str], printed: Findings, nulls: Findings
) -> ClaimVerdict:
    name = claim["measure"]
    if name not in MEASURES:
        close = difflib.get_close_matches(name, MEASURES, n=3, cutoff=0.0)
        raise InputError(
            f"expected a measure of tepsipe/reporting/claims.py, found {name!r}: "
            f"did you mean {' or '.join(close)}?"
        )
    basis = basis_of(claim, bases)
    value = _measured(MEASURES[name], printed if claim["verdict"] == IMPLIED else findings)
    null, margin = (
        claim.get(key, _measured(MEASURES[name], numbers))
        for key, numbers in (("null_value", nulls), ("margin", printed))
    )
    null_verdict = null_verdict_of(None if null is None else _holds(claim, null))
    if claim.get("own_threshold"):
        basis += f"; {OWN_THRESHOLD}"
    used = basis + ("; cannot discriminate: the null model is within" if null_verdict == IMPLIED else "")
    tolerance = claim["tolerance"]
    verdict, predicted = _verdict(claim, value, findings)
    reason = "" if verdict in (*WITHIN, NOT_COMPUTED) else claim.get("outside", "")
    return ClaimVerdict(
        *(claim["claim"], claim["where"], claim["unit"], claim["reported"], value),
        tolerance=tolerance if isinstance(tolerance, str) else f"{tolerance:.10g}",
        verdict=verdict,
        section=claim["section"],
        null_value=null,
        null_verdict=null_verdict,
        margin=margin,
        used=used,
        statements="",
        measure=name,
        reason=reason if predicted is None else f"{reason}: {predicted:.3g}",
    )


def _verdict(claim: dict, value: float | None, findings: Findings) -> tuple[str, float | None]:
    """Verdict, and the number within the tolerance that an explanation predicts (``unit``)."""
    if value is None:
        return NOT_COMPUTED, None
    if _holds(claim, value):
        recorded = findings.recorded and claim["verdict"] == FITTED
        return PREDICTED if recorded else claim["verdict"], None
    if claim["verdict"] == IMPLIED:
        return CONTRADICTED, None
    predicted = None
    if claim["measure"] in EXPLANATIONS:
        predicted = _measured(EXPLANATIONS[claim["measure"]], findings)
    explained = predicted is not None and _holds(claim, predicted)
    return (EXPLAINED, predicted) if explained else (NOT_REPRODUCED, None)


def _measured(measure: Callable[[Findings], float], findings: Findings) -> float | None:
    """A finite number, or None where the study does not have what it is made of."""
    try:
        with warnings.catch_warnings():  # means of nothing are not a number
            warnings.simplefilter("ignore", RuntimeWarning)
            value = measure(findings)
    except (ValueError, KeyError, ZeroDivisionError):
        return None
    return value if np.isfinite(value) else None


def _holds(claim: dict, value: float) -> bool:
    if claim["tolerance"] == "below":
        return value < claim["reported"]
    if claim["tolerance"] == "above":
        return value > claim["reported"]
    return abs(value - claim["reported"]) <= claim["tolerance"] + ROUNDING
