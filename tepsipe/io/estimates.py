"""Tidy rows of estimates, the common format of all experiments, of their budgets, and beside the truth.

They are written to ``estimates.csv``, ``uncertainty.csv`` and ``recovery.csv`` in ``results/tables``.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from tepsipe.io.tables import Table, Undefinable

# flag -> its meaning for an estimate, and what to check
FLAGS = {
    "at-bound": "a parameter lies at a bound of its search. Widen the bound, or check units and signs",
    "assumed": "the record does not determine the value, which is assumed. See the rows of its range",
    "relaxation-assumed": "a part of the stiffness relaxes at assumed rates, on which the value depends. Try "
    "other relaxation_times_s",
    "not-converged": "the fit stopped before it converged. Try other starting values",
    "undefined": "the value is not a finite number. The parameters describe no stable joint",
    "no-interval": "the standard error or interval is not a number. Record more perturbations",
    "leg-disagrees": "K of the windowed fit and K of the joint likelihood disagree. Look for markers of the "
    "leg that wobble, bend or slip",
    "foot-leg-delay": "the leg moves too early or too late after the foot. Check the sampling instants of "
    "the markers, and whether one on foot or ankle slips",
    "joint-inertia": "I differs from the known inertia of the joint. Weigh the leg, and find its centre of "
    "mass",
    "foot-markers-apart": "markers on the foot move against each other. Check their tape, and whether the "
    "foot tilts",
    "camera-scale": "the markers of the leg are further apart or closer than their layout by more than 1 %. "
    "Check the calibration of the cameras, and measure the layout again",
    "markers-slip": "a marker stays displaced after perturbations. Check the tape of all markers",
    "markers-pulse-locked": "markers leave the rigid leg in every perturbation. Look for bending or soft "
    "mounts",
    "lack-of-fit": "the model of the joint leaves a repeated motion or a large part of the signal "
    "unexplained. Inspect the residuals for wobble, hysteresis and wrong time stamps",
    "log-delay": "the log was early or late against the other instrument by more than 2 ms (torque) or 6 ms "
    "(belt), and was corrected. Check the trigger",
    "torque-delay": "the torque was recorded more than 1 ms before or after the movement that causes it, or "
    "one of the two was filtered. The fit does not correct this. Check triggers and filters",
    "filtered-signal": "a signal was filtered before it was recorded, and the other was not. Export both "
    "without a filter, or filter both alike",
    "joints-exchanged": "torques follow the angle of the other joint, or the slow torque of the hip exceeds "
    "the ankle's. Check the columns of ankle and hip",
    "spikes": "single samples lie far from their neighbours. Remove them, and check cables",
    "held-samples": "values are held and then jump. Look for lost samples, or a slower clock",
    "clipped": "peaks are cut off at one value. Choose a larger range of the instrument",
    "other-amplitude": "the commanded belt is more than a quarter faster, or a fifth slower, than the "
    "amplitude in the trial sheet. Check that the file is the one of this trial",
    "calibration-differs": "the force plate has another calibration in this recording than in those of "
    "weight and empty belt. Use one calibration matrix for all; tepsipe check names what differs",
    "trials-differ": "K or B of one trial of the task differs from the others by more than a quarter and "
    "chance. Nothing is recommended beyond 40 %. Check its row of the trial sheet and its recording",
    "muscles-exchanged": "a muscle responds more when it is shortened than when it is stretched. Check the "
    "channels of the electromyograms",
    "emg-trigger": "the muscles respond earlier than a reflex can, or much later. Check the trigger of the "
    "electromyograms",
    "halves-differ": "the first and the second part of the record do not agree: the joint or the recording "
    "changed. Check mounts, sensors and the subject",
    "time-varying": "the stiffness differs between segments of the record by more than chance, so nothing is "
    "recommended. Analyse the parts separately, or name a schedule or trigger",
    "stamp-jitter": "time stamps of the log are random by more than 1.2 ms. Stamp samples when they are "
    "taken",
    "noise-biased": "noise of the markers biases the estimate. Record more, equal or larger perturbations, "
    "place markers further apart, or use the joint likelihood of a dummy",
    "pre-reflex-differs": "K differs from K of the pre-reflex window by more than 5 % and more than chance. "
    "Check the onset of the reflexes and the friction of the belt",
    "window-sensitive": "K changes by more than 25 % between windows. Check the onset of the "
    "reflexes and the treadmill model",
    "skin-motion": "soft tissue of the shank moves over the bone by more than can be corrected. Fasten the "
    "markers of the shank to bony places",
    "muscle-left-out": "a muscle that acts at the ankle has no usable electromyogram, so its torque counts "
    "as stiffness and damping. Repair its electrode, or quote another estimator",
    "few-perturbations": "more than 30 % of the perturbations are unusable. Read the reasons, and repeat the "
    "trial",
    "not-identified": "the perturbation does not determine the quantity, so it has no value. Record a "
    "second, independent perturbation",
    "no-response": "the angle does not respond to the perturbation. Perturb more, or more often",
    "no-contact": "the foot is in the air, so the belt does not perturb its joint. Perturb in stance",
    "coherent-residual": "the model leaves torque that is coherent with the platform, so it is too simple. "
    "Do not quote its parameters",
    "edge-of-search": "an onset or delay lies at an end of its search range, or the data prefer one beyond "
    "it. Widen the range",
    "stretch-threshold": "the latency may be more than 5 ms shorter: responses begin later after smaller "
    "pulses, or the pulses cannot tell whether the reflex needs a fast stretch. Record pulses of several "
    "amplitudes",
    "reflex-not-determined": "the reflex torque is not clearly above its uncertainty, or its start is not. "
    "Record more or larger perturbations",
    "slow-reflex": "the fitted muscle is slower than 1.9 Hz, so the response is more than a reflex. Do not "
    "quote its gain",
    "mass-differs": "the mass estimated from the fore-aft force differs from the trial sheet. Check the "
    "mass, the scale of the force, and friction and mounts of the belt",
    "diverged": "the prediction grows without limit. The parameters describe no stable joint",
    "treadmill-model": "on held-out trials the treadmill model is off by more than a tenth of K, or its "
    "constants are impossible. Record the empty belt and a weight close to the subject's mass, with the "
    "subject's pulses",
    "treadmill-not-converged": "the search for the constants of the treadmill model did not converge, and "
    "the model is off by more than a tenth of K, or its constants are impossible. Inspect the calibration "
    "trials one by one for slip of the weight, clipped channels and a wrong mass",
    "plate-origin": "in quiet standing the centre of pressure is more than 4 cm from the person's centre of "
    "mass. Check the origin of the force plate, or state where the weight's centre of mass lies",
    "plate-scale": "the force plate and the weights give different vertical forces. Check the scale of the "
    "plate, and the masses of the weights",
    "plate-transducer": "the force plate and the weights give different vertical forces, at different "
    "places. Check the gain of every transducer",
    "negative": "B or K is negative, which no joint has. Check signs, clocks and delays of the recording",
    "uncompensated": "no weight was recorded on the treadmill, so the belt-induced load is part of the "
    "torque. Record the empty belt, and a weight near the subject's mass",
    "frame-resonance": "the frame of the treadmill resonates lower under the person than when empty, as it "
    "does under a weight, although a person's force passes through the empty frame. Record a weight of the "
    "person's mass with the same pulses",
    "beyond-calibrated-mass": "the subject is heavier than the weights of the treadmill's calibration. "
    "Record a weight near the subject's mass",
}
UNCERTAINTIES = ("standard_error", "ci_low", "ci_high", "sem_as_printed", "u_type_a", "u_type_b")
# quantities of which one estimate per trial is recommended
QUOTED = ("I", "B", "K", "mass")
# a VAF below this belongs to a diverging prediction (%)
DIVERGED_VAF = -1e6
TYPES = ("A", "B")


@dataclass(frozen=True)
class Estimate:
    """One estimated quantity."""

    experiment: str
    condition: str
    pathway: str
    estimator: str
    """Method of computing the torque, and of estimating the parameters."""
    quantity: str
    unit: str
    """For example I in Nms2/rad, or VAF_trial in %."""
    value: Undefinable
    """The estimate (``unit``)."""
    standard_error: float | None = None
    ci_low: float | None = None
    ci_high: float | None = None
    """Combined standard uncertainty and 95 % interval (``unit``); None where there is none."""
    sem_as_printed: float | None = None
    """Thesis eq (3-2) as printed; None where there is none."""
    n_perturbations: int | None = None
    """Number of perturbations behind the value."""
    u_type_a: float | None = None
    u_type_b: float | None = None
    """Standard uncertainties from the trial's own scatter and from everything else (``unit``); None where
    they were not evaluated. Their root sum of squares is ``standard_error``."""
    recommended: bool = False
    """Whether this is the estimate of its quantity to quote."""
    flags: str = ""
    """Names of the checks in `FLAGS` that the estimate failed, joined by ``;``."""


def flagged(estimates: Iterable[Estimate], *flags: str) -> list[Estimate]:
    """Estimates with further flags, names in `FLAGS`; none is repeated."""
    return [
        replace(e, flags=";".join(dict.fromkeys([*filter(None, e.flags.split(";")), *flags])))
        for e in estimates
    ]


def recommended(estimates: Iterable[Estimate], pathway: str, estimator: str | None = None) -> list[Estimate]:
    """Mark the estimates to quote.

    estimates: rows of one or more trials, the same quantity once per trial, pathway and estimator.
    estimator: the recommended estimator; any of the pathway if left out.
    Returns: rows of this pathway and estimator with a quantity of `QUOTED` are marked, and no others. Where
    B or K is negative none of its trial, pathway and estimator is; they are flagged ``negative`` instead.
    """
    rows = list(estimates)
    impossible = {_fit_of(e) for e in rows if e.quantity in ("B", "K") and e.value < 0.0}
    marked = []
    for e in rows:
        chosen = e.quantity in QUOTED and e.pathway == pathway and estimator in (None, e.estimator)
        if chosen and _fit_of(e) in impossible:
            marked += flagged([replace(e, recommended=False)], "negative")
        else:
            marked.append(replace(e, recommended=chosen))
    return marked


def _fit_of(estimate: Estimate) -> tuple[str, ...]:
    return estimate.experiment, estimate.condition, estimate.pathway, estimate.estimator


def _flagged_where_undefined(estimate: Estimate) -> Estimate:
    """The estimate with the flags that its numbers require, None for an uncertainty that is NaN.

    A value that is not finite gets the flag ``undefined``, unless the quantity is ``not-identified``. An
    uncertainty that is not a number gets ``no-interval``, and the VAF of a diverging prediction ``diverged``.
    A standard error of a row without Type A and B is of Type A.
    """
    if estimate.standard_error is not None and estimate.u_type_a is None and estimate.u_type_b is None:
        estimate = replace(estimate, u_type_a=estimate.standard_error)
    lost = [name for name in UNCERTAINTIES if (x := getattr(estimate, name)) is not None and math.isnan(x)]
    undefined = not math.isfinite(estimate.value)
    refused = "not-identified" in estimate.flags.split(";")
    flags = ["undefined"] * (undefined and not refused) + ["no-interval"] * bool(lost)
    if not undefined and estimate.quantity.startswith("VAF") and estimate.value < DIVERGED_VAF:
        flags.append("diverged")
    return flagged([replace(estimate, **dict.fromkeys(lost))], *flags)[0] if flags else estimate


def _check(estimate: Estimate) -> None:
    flags = [flag for flag in estimate.flags.split(";") if flag]
    if math.isnan(estimate.value) and not {"undefined", "not-identified"} & set(flags):
        raise ValueError("a row without a value and without the flag 'undefined' or 'not-identified'")
    unknown = [flag for flag in flags if flag not in FLAGS]
    if unknown:
        raise ValueError(f"the unknown flag {unknown[0]!r}")
    if (estimate.n_perturbations or 0) < 0:
        raise ValueError(f"a value of {estimate.n_perturbations} perturbations")


# participant and belt may follow, without being read
ESTIMATES = Table(
    Estimate,
    "estimates",
    check=_check,
    complete=_flagged_where_undefined,
    further=("participant", "belt"),
)


@dataclass(frozen=True)
class Contribution:
    """Contribution of one source to the uncertainty of one estimate."""

    experiment: str
    condition: str
    pathway: str
    estimator: str
    quantity: str
    unit: str
    """The estimate, as in `Estimate`."""
    source: str
    """Name of the source, with its own unit; `SCATTER` for Type A."""
    type: str
    """{"A", "B"}: Whether it is seen in the scatter of the trial, or known otherwise."""
    u: float
    """Standard uncertainty that it contributes to the estimate (``unit``), never negative."""


def _check_contribution(row: Contribution) -> None:
    if row.type not in TYPES or not row.u >= 0.0:
        raise ValueError(f"{row.u:g} of type {row.type!r}")


CONTRIBUTIONS = Table(Contribution, "uncertainty budgets", check=_check_contribution)


@dataclass(frozen=True)
class Recovery:
    """One estimate and its true value; the fields are the columns of ``tables/recovery.csv``."""

    experiment: str
    condition: str
    pathway: str
    estimator: str
    quantity: str
    unit: str
    """The estimate, as in `Estimate`."""
    truth: float
    """The laboratory's constant, or the value of the nearest linear joint (``unit``)."""
    value: Undefinable
    """The estimate (``unit``)."""
    relative_error: float | None
    """(value - truth) / truth; None where it is not finite."""
    covered: bool | None
    """True if the 95 % interval contains the truth; None without an interval."""
    truth_of: str
    """Movements for which the truth holds."""
    recommended: bool = False
    """True if the study recommends the estimate."""
    flags: str = ""
    """Names of the checks that the trial failed for it, joined by ";"."""


RECOVERIES = Table(Recovery, "estimates beside the truth")
