"""What ``tepsipe plan`` computes, prints and writes."""

import argparse
import math
from dataclasses import dataclass, replace
from pathlib import Path

from tepsipe.errors import InputError, listed, quoted
from tepsipe.experiments.planning.design import Design, Protocol, Rig
from tepsipe.experiments.planning.optimal_pulse import OptimalPulse, optimise_pulse
from tepsipe.experiments.planning.plan import Plan, expected_likelihood, plan_experiment
from tepsipe.experiments.planning.pulses import Drive, Limits, peaks_of, pulse_of
from tepsipe.io.tables import write_records
from tepsipe.mechanics.engines.interface import Joint
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.reporting.plan_arguments import TOLERANCES
from tepsipe.signals.perturbations import SMALLEST_PEAK_M_PER_S
from tepsipe.statistics.uncertainty import Source


@dataclass(frozen=True)
class Optimised:
    """The plan with the best pulse (units in `OptimalPulse`)."""

    found: OptimalPulse
    """The pulse (m/s) and its bound (N·m/rad)."""
    plan: Plan
    """What it shows (units there)."""


def design_of(chosen: argparse.Namespace) -> Design:
    """The design that the arguments describe (units in their help)."""
    bandwidth = None if chosen.drive_bandwidth == 0.0 else chosen.drive_bandwidth
    rig = Rig(
        marker_noise_m=chosen.marker_noise,
        camera_rate_hz=chosen.camera_rate,
        log_noise_m_per_s=chosen.log_noise,
        log_rate_hz=chosen.log_rate,
        force_noise_N=chosen.force_noise,
        moment_noise_Nm=chosen.moment_noise,
        plate_rate_hz=chosen.plate_rate,
        sync_jitter_s=chosen.sync_jitter,
        drive=Drive(bandwidth_hz=bandwidth, acceleration_m_per_s2=chosen.drive_acceleration),
    )
    protocol = Protocol(
        pulse=pulse_of(chosen.profile, chosen.amplitude, chosen.duration),
        number=chosen.number,
        interval_s=chosen.interval,
        rest_before_s=chosen.rest,
        rest_after_s=chosen.rest,
        pathway=chosen.pathway,
        cutoff_hz=chosen.cutoff,
        order=chosen.order,
    )
    return Design(
        joint=Joint(chosen.inertia, chosen.damping, chosen.stiffness),
        leg=Leg(mass_kg=chosen.leg_mass, com_m=chosen.leg_com, inertia_kgm2=chosen.leg_inertia),
        foot=Foot(mass_kg=chosen.foot_mass, height_m=chosen.foot_height),
        rig=rig,
        protocol=protocol,
        sources={} if chosen.no_tolerances else _sources(chosen.tolerance),
    )


def _sources(changes: list[str]) -> dict[str, Source]:
    values = dict(TOLERANCES)
    for change in changes:
        name, _, text = change.partition("=")
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if name not in TOLERANCES or not (math.isfinite(value) and value >= 0.0):
            raise InputError(
                f"--tolerance: expected NAME=U with a name of {listed(TOLERANCES)} and a number of at "
                f"least 0, found {quoted(change)}: correct it"
            )
        values[name] = value
    return {name: Source(name, value) for name, value in values.items()}


def limits_of(chosen: argparse.Namespace, plan: Plan) -> Limits:
    """Limits of the best pulse (m/s, m, m/s², m/s³): those given, or else the peaks of the planned pulse."""
    given = (chosen.max_velocity, chosen.max_displacement, chosen.max_acceleration, chosen.max_jerk)
    if all(limit is None for limit in given):
        return peaks_of(plan.motion.pulse_velocity)
    return Limits(*(math.inf if limit is None else limit for limit in given))


def run_plan(chosen: argparse.Namespace) -> tuple[Plan, Optimised | None]:
    """Plan, and optimise where it is asked for (units in the results)."""
    plan = plan_experiment(design_of(chosen))
    given = any(
        value is not None
        for value in (chosen.max_velocity, chosen.max_displacement, chosen.max_acceleration, chosen.max_jerk)
    )
    if not chosen.optimise:
        if given or chosen.returning:
            raise InputError(
                "plan: expected --optimise with limits of the belt or --returning, found none: add it"
            )
        return plan, None
    return plan, best_of(plan, limits_of(chosen, plan), not chosen.returning)


def best_of(plan: Plan, limits: Limits, one_way: bool) -> Optimised:
    """Best pulse within limits (m/s, m, m/s², m/s³), and the plan with it.

    plan: with any pulse of the wanted length (units there).
    one_way: whether the belt may stay where it was moved to, and go back with the next pulse.
    """
    design = plan.design
    pulse = replace(design.protocol.pulse, one_way=one_way)
    shaped = replace(design, protocol=replace(design.protocol, pulse=pulse))
    found = optimise_pulse(shaped, expected_likelihood(design, plan.motion), limits)
    if found.peaks.velocity_m_per_s < SMALLEST_PEAK_M_PER_S:
        raise InputError(
            f"limits: expected limits that allow a pulse of {SMALLEST_PEAK_M_PER_S:g} m/s, found that "
            "the best one "
            f"reaches {found.peaks.velocity_m_per_s:.2g} m/s: raise them or plan longer pulses"
        )
    best = replace(design, protocol=replace(design.protocol, pulse=found.pulse))
    return Optimised(found, plan_experiment(best))


def summary(plan: Plan, best: Optimised | None) -> str:
    """Table of a plan as text (units in it)."""
    lines = [f"{'':2}{'value':>10}{'u':>11}{'Type A':>11}{'Type B':>11}{'bound':>11}{'95 % +-':>9}  unit"]
    for row in plan.rows():
        bound = "-" if row["cramer_rao"] is None else f"{row['cramer_rao']:.3g}"
        half = "-" if row["half_width_percent"] is None else f"{row['half_width_percent']:.3g} %"
        cells = "".join(f"{row[key]:>11.3g}" for key in ("u_combined", "predicted_u", "u_type_b"))
        lines.append(f"{row['quantity']:2}{row['value']:>10.4g}{cells}{bound:>11}{half:>9}  {row['unit']}")
    protocol, k = plan.design.protocol, plan.rows()[2]
    profile = protocol.pulse.profile
    lines.append(
        f"\n{protocol.number} perturbations ({profile}) in {protocol.lasts_s:g} s, {protocol.pathway}"
    )
    if plan.bias.any():
        share = 100.0 * plan.bias[2] / plan.design.parameters[2]
        lines.append(f"bias of K by noise of the markers: {share:.2g} %")
    for percent in (5, 10, 20):
        needed = k[f"n_for_{percent}_percent"]
        alone = "tolerances and bias" if plan.bias.any() else "tolerances"
        text = f"no number, {alone} alone exceed it" if needed is None else str(needed)
        lines.append(f"perturbations for K +-{percent} % (95 %): {text}")
    if best is not None:
        lines += ["", *_of_best(plan, best)]
    return "\n".join(lines)


def _of_best(plan: Plan, best: Optimised) -> list[str]:
    ratio = best.plan.type_a[2] / plan.type_a[2]
    names = ("m/s", "m", "m/s2", "m/s3")
    peaks = ", ".join(
        f"{x:.3g} {unit}" for x, unit in zip(vars(best.found.peaks).values(), names, strict=True)
    )
    return [
        f"best pulse: Type A of K {best.plan.type_a[2]:.3g} Nm/rad, {ratio:.2f} times the planned one's",
        f"  peaks of the belt: {peaks}",
        f"  Cramer-Rao bound of K, linear joint: {best.found.standard_error:.3g} Nm/rad; no pulse of this "
        f"length within these limits is below {best.found.least_standard_error:.3g} Nm/rad",
    ]


def write_plan(plan: Plan, best: Optimised | None, path: Path) -> None:
    """Write the rows of a plan, and of the plan with the best pulse, as CSV (units in it)."""
    found = [{"design": plan.design.protocol.pulse.profile} | row for row in plan.rows()]
    if best is not None:
        found += [{"design": best.found.pulse.profile} | row for row in best.plan.rows()]
    write_records(path, found)
