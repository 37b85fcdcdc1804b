"""Chapter on the ankle dummy: motion of the belt, and conditions of its sentences."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
import pandas as pd

from tepsipe.experiments.dummy.results import cross_validate_dummy, without_own
from tepsipe.identification.estimators import ESTIMATORS, JOINT_LIKELIHOOD
from tepsipe.io.result import Result
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.reporting.run import Run

# from this belt velocity, marker noise is small relative to the motion (m/s)
CLEAR_FROM_M_PER_S = 0.3


def numbers(run: Run) -> dict:
    """Numbers that no table has (units in the keys), and names of estimators that fit no torque."""
    pulses = [_pulse(fit) for fit in run.fits["dummy"].values()]
    return {
        "perturbations": [len(fit.arrays["windows"]) for fit in run.fits["dummy"].values()],
        "windows_percent": [_windows_percent(fit) for fit in run.fits["dummy"].values()],
        "belt_peak_percent": [pulse["peak_percent"] for pulse in pulses if pulse],
        "belt_delay_ms": [pulse["delay_ms"] for pulse in pulses if pulse],
        "cross_validated": _cross_validated(run),
        "largest_step_of_sd": _largest_step_of_sd(run),
        "without_torque": [name for name, one in ESTIMATORS.items() if "torque" not in one.needs],
    }


def _cross_validated(run: Run) -> dict[str, list[float]]:
    """Cross-validated VAFs of the printed torque (%): single ones, and means by predicted trial."""
    pathway, fits = run.settings["dummy"]["as_printed"], run.fits["dummy"]
    needed = [f"{pathway}/{name}" for name in ("parameters", "regressors", "torque")]
    if len(fits) < 2 or any(name not in fit.arrays for fit in fits.values() for name in needed):
        return {"single_percent": [], "predicted_percent": []}
    vafs = without_own(cross_validate_dummy(fits, pathway))
    return {"single_percent": vafs.ravel().tolist(), "predicted_percent": vafs.mean(axis=1).tolist()}


def _largest_step_of_sd(run: Run) -> dict[str, float]:
    """Largest ratio of a parameter's standard deviation over a trial to that at the next lower amplitude (-).

    Printed pathway, trials of one profile with a pulse every 4 s; empty without such trials.
    """
    key = f"{run.settings['dummy']['as_printed']}/parameters"
    spread = {
        name: fit.arrays[key].std(axis=0, ddof=1)
        for name, fit in run.fits["dummy"].items()
        if key in fit.arrays and len(fit.arrays[key]) > 1
    }
    steps = [
        spread[high] / spread[low]
        for profile in ("sine", "minjerk")
        for low, high in pairwise(f"{profile}-0.{k}" for k in range(1, 6))
        if low in spread and high in spread
    ]
    return dict(zip(PARAMETERS, np.max(steps, axis=0).tolist(), strict=True)) if steps else {}


def _windows_percent(fit: Result) -> float:
    """Share of the samples of a trial that lie in fitted windows (%)."""
    inside = np.diff(fit.arrays["windows"], axis=1).sum()
    return 100.0 * float(inside) / len(fit.arrays["time"])


def _pulse(fit: Result) -> dict | None:
    """Peak velocity of the belt relative to the command, and its delay, in the first pulse of a trial."""
    if "belt_command" not in fit.arrays:
        return None
    time, first = fit.arrays["time"], int(fit.arrays["windows"][0, 0])
    rate = 1.0 / float(time[1] - time[0])
    part = slice(max(0, first - round(0.06 * rate)), first + round(0.22 * rate))
    belt, command = (fit.arrays[name][part] for name in ("belt_velocity", "belt_command"))
    if not np.abs(command).max() > 0.0:
        return None
    # the first half of a pulse, in whichever direction it begins
    sign = np.sign(command[np.abs(command) > 0.05 * np.abs(command).max()][0])
    belt, command = sign * belt, sign * command
    return {
        "peak_percent": 100.0 * float(belt.max() / command.max()),
        "delay_ms": 1e3 * float(np.argmax(belt) - np.argmax(command)) / rate,
    }


def _values(run: Run, role: str, quantity: str) -> pd.Series:
    """Estimates by the pathway that is as_printed or recommended."""
    return run.values("dummy", quantity, pathway=run.settings["dummy"][role])


def _clear(run: Run) -> list[str]:
    """Conditions with fast pulses; all if there are none."""
    amplitudes, conditions = run.study["amplitudes"], list(run.fits["dummy"])
    return [c for c in conditions if (amplitudes[c] or 0.0) >= CLEAR_FROM_M_PER_S] or conditions


# ---- conditions of sentences


def commanded(run: Run) -> bool:
    """The log of a trial has the velocity that was commanded."""
    return any(_pulse(fit) is not None for fit in run.fits["dummy"].values())


def stiffness_falls(run: Run) -> bool:
    """The printed K at the largest belt velocity is below the one at the smallest by more than 5 %."""
    return _falls(_values(run, "as_printed", "K"), run.study["amplitudes"])


def _falls(values: pd.Series, amplitudes: Mapping[str, float | None]) -> bool:
    """The mean value at the largest amplitude is below the one at the smallest by more than 5 %."""
    known = {c: a for c, a in amplitudes.items() if a is not None and c in values}
    if len(set(known.values())) < 2:
        return False
    slow, fast = (
        values[[c for c, a in known.items() if a == end(known.values())]].mean() for end in (min, max)
    )
    return bool(fast < 0.95 * slow)


def inertia_above_zero(run: Run) -> bool:
    """Every 95 % interval of the recommended I lies above 0."""
    rows = run.rows(
        "estimates", experiment="dummy", quantity="I", pathway=run.settings["dummy"]["recommended"]
    )
    return bool((rows.ci_low > 0.0).all())


def signs_explain(run: Run) -> bool:
    """The printed and the recommended I and K differ by what the signs predict, within 5 %."""
    leg = run.settings["dummy"]["geometry"]
    weight = leg["leg_mass_kg"] * leg["gravity_m_per_s2"] * leg["leg_com_m"]
    predicted = {"I": 2.0 * leg["leg_inertia_kgm2"], "K": -2.0 * weight}
    differences = {
        q: (_values(run, "as_printed", q) - _values(run, "recommended", q))[_clear(run)].mean()
        for q in predicted
    }
    return all(abs(differences[q] / predicted[q] - 1.0) < 0.05 for q in predicted)


def signs_bridge_thesis(run: Run) -> bool:
    """Without the effect of the signs, the printed mean K is nearer to the manipulator's by half or more.

    Algebra on the thesis's own numbers: no trial of the run is used.
    """
    if not run.study["reported"]:
        return False
    leg, manipulator = run.settings["dummy"]["geometry"], run.study["start_stiffness"]
    printed = float(np.mean(list(_in_thesis(run, "K").values())))
    undone = printed + 2.0 * leg["leg_mass_kg"] * leg["gravity_m_per_s2"] * leg["leg_com_m"]
    return abs(undone - manipulator) < 0.5 * abs(printed - manipulator)


def corrected_inertia_lower(run: Run) -> bool:
    """Without the effect of the signs, the printed mean I is at most two thirds of the manipulator's.

    Algebra on the thesis's own numbers: no trial of the run is used.
    """
    manipulator = (
        run.study["reported"]["tables"].get("table_4_1", {}).get("I") if run.study["reported"] else None
    )
    if not manipulator:
        return False
    printed = float(np.mean(list(_in_thesis(run, "I").values())))
    undone = printed - 2.0 * run.settings["dummy"]["geometry"]["leg_inertia_kgm2"]
    return undone < 2.0 / 3.0 * float(np.mean(list(manipulator.values())))


def _in_thesis(run: Run, quantity: str) -> dict[str, float]:
    """Condition -> printed number of Tables 4-2 and 4-3, with misprints corrected."""
    reported, found = run.study["reported"], {}
    for name in ("table_4_2", "table_4_3"):
        found |= reported["tables"][name].get(quantity, {})
    meant = {(s["quantity"], s["condition"]): s["meant"] for s in reported["slips"]}
    return {c: float(meant.get((quantity, c), value)) for c, value in found.items()}


def consistent_vaf_lower(run: Run) -> bool:
    """The VAF of a perturbation is lower by the consistent equation, in every condition."""
    printed, consistent = (_values(run, role, "VAF_perturbation") for role in ("as_printed", "recommended"))
    return bool((consistent < printed).all())


def vaf_of_trial(run: Run) -> bool:
    """The VAF differs between trials more than twice as much as between their parameters."""
    of_trials, of_parameters = (_values(run, "as_printed", q) for q in ("VAF_trial", "VAF_cross_validated"))
    if not (len(of_trials) and len(of_parameters)):
        return False
    return bool(np.ptp(of_parameters) < 0.5 * np.ptp(of_trials))


def recommended_specified(run: Run) -> bool:
    """The recommended combination is one of those of the specification curve."""
    return len(run.rows("specification", role="recommended")) > 0


def thesis_stiffness_falls(run: Run) -> bool:
    """K of the thesis at the largest belt velocity is below the one at the smallest by more than 5 %."""
    return bool(run.study["reported"]) and _falls(pd.Series(_in_thesis(run, "K")), run.study["amplitudes"])


def thesis_damping_negative(run: Run) -> bool:
    """Most values of B in the thesis's tables are negative."""
    printed = list(_in_thesis(run, "B").values()) if run.study["reported"] else []
    return bool(printed) and bool(np.mean(np.array(printed) < 0.0) > 0.5)


def consistent_torque_smaller(run: Run) -> bool:
    """In every condition the consistent torque has less than half of the printed one's standard deviation."""
    roles = (run.settings["dummy"]["recommended"], run.settings["dummy"]["as_printed"])
    pairs = [[fit.arrays.get(f"{role}/torque") for role in roles] for fit in run.fits["dummy"].values()]
    if any(torque is None for pair in pairs for torque in pair):
        return False
    return all(np.std(consistent) < 0.5 * np.std(printed) for consistent, printed in pairs)


def errors_of_stiffness_alike(run: Run) -> bool:
    """Errors of the joint likelihood's K have one sign, and differ by less than half of their mean."""
    names = [n for n, c in run.settings["dummy"]["pathways"].items() if c["estimator"] == JOINT_LIKELIHOOD]
    if not (names and "recovery" in run.tables):
        return False
    rows = run.rows("recovery", experiment="dummy", pathway=names[0], quantity="K")
    errors = rows.relative_error.to_numpy(float)
    return len(errors) > 2 and bool(np.ptp(errors) < 0.5 * abs(errors.mean()))


def rest_matters(run: Run) -> bool:
    """The median K from the foot changes by more than 5 % if the torque at rest is subtracted."""
    medians = [
        run.rows("specification", torque="foot", estimator=name).K_Nm_per_rad.median()
        for name in ("windowed-least-squares", "windowed-least-squares-thesis")
    ]
    return bool(abs(medians[0] - medians[1]) > 0.05 * abs(medians[0]))


def vaf_does_not_separate(run: Run) -> bool:
    """A combination of choices with a VAF above 99 % deviates by more than 5 % from the recommended K."""
    rows = run.rows("specification")
    if not recommended_specified(run):
        return False
    recommended = rows[rows.role == "recommended"].K_Nm_per_rad.iloc[0]
    return bool(((rows.VAF_percent > 99.0) & ((rows.K_Nm_per_rad / recommended - 1.0).abs() >= 0.05)).any())


PREDICATES = (
    commanded,
    stiffness_falls,
    inertia_above_zero,
    signs_explain,
    signs_bridge_thesis,
    corrected_inertia_lower,
    consistent_vaf_lower,
    vaf_of_trial,
    recommended_specified,
    thesis_stiffness_falls,
    thesis_damping_negative,
    consistent_torque_smaller,
    errors_of_stiffness_alike,
    rest_matters,
    vaf_does_not_separate,
)
