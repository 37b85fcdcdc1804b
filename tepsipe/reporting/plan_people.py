"""What ``tepsipe plan`` says about people: a standing person's ankles, and strides of a walking person."""

import argparse
from pathlib import Path

import numpy as np

from tepsipe.errors import InputError, quoted
from tepsipe.experiments.planning.pulses import Drive, pulse_of
from tepsipe.experiments.planning.standing_plan import StandingDesign, StandingPlan, plan_standing
from tepsipe.experiments.walking.needed_strides import FEWEST_PLANNED, NEEDED_ROWS, allocation
from tepsipe.io.tables import write_records


def standing_plan_of(chosen: argparse.Namespace) -> StandingPlan:
    """The plan that the arguments describe (units in their help)."""
    if chosen.optimise or chosen.returning:
        raise InputError("plan: expected no --optimise with --standing, found it: plan the pulses one by one")
    bandwidth = None if chosen.drive_bandwidth == 0.0 else chosen.drive_bandwidth
    return plan_standing(
        StandingDesign(
            stiffness_Nm_per_rad=chosen.person_stiffness,
            damping_Nms_per_rad=chosen.person_damping,
            lever_m=chosen.person_lever,
            sway_Nm=chosen.sway_torque,
            sway_s=chosen.sway_time,
            marker_noise_m=chosen.marker_noise,
            camera_rate_hz=chosen.camera_rate,
            angle_per_marker=chosen.person_angle_noise,
            pulse=pulse_of(chosen.profile, chosen.amplitude, chosen.duration),
            number=chosen.number,
            drive=Drive(bandwidth_hz=bandwidth, acceleration_m_per_s2=chosen.drive_acceleration),
            type_b=0.0 if chosen.no_tolerances else chosen.person_type_b,
        )
    )


def standing_summary(plan: StandingPlan) -> str:
    """Table and sentences of a plan (units in it)."""
    lines = ["quantity      value    Type A    Type B  combined  95 % interval"]
    rows = plan.rows()
    for row in rows:
        numbers = (row[key] for key in ("value", "predicted_u", "u_type_b", "u_combined"))
        cells = " ".join(f"{x:9.4g}" for x in numbers)
        lines.append(f"{row['quantity']:2} ({row['unit']}) {cells}  +-{row['half_width_percent']:.1f} %")
    lines.append(f"\n{plan.design.number} responses of both ankles, free-reflex-gls; I of the feet is known")
    for percent in (5, 10, 20):
        needed = rows[1][f"n_for_{percent}_percent"]
        text = "no number, Type B alone exceeds it" if needed is None else str(needed)
        lines.append(f"responses for K +-{percent} % (95 %): {text}")
    return "\n".join(lines)


def write_standing(plan: StandingPlan, path: Path) -> None:
    """Write the rows of a plan as CSV (units in it)."""
    write_records(path, [{"design": f"standing-{plan.design.pulse.profile}"} | row for row in plan.rows()])


def walking_summary(chosen: argparse.Namespace) -> str:
    """Strides of each phase of stance, from a walking study's table of strides needed."""
    if not 0.0 < chosen.degrees < np.inf:
        raise InputError(f"--degrees: expected a positive angle, found {chosen.degrees:g}: correct it")
    every = NEEDED_ROWS.read(chosen.walking)
    first = next((row.condition for row in every), None)
    rows = [row for row in every if (row.condition, row.matching) == (first, "state")]
    if not rows:
        raise InputError(
            f"{chosen.walking}: expected strides needed at phases of stance, found none: run a study of "
            "walking"
        )
    # the variance of one stride falls with the square of the amplitude
    needed = [row.strides_for_15_percent * (chosen.planned_degrees / chosen.degrees) ** 2 for row in rows]
    strides = allocation(needed, chosen.strides, FEWEST_PLANNED)
    lines = [f"{chosen.strides} perturbed strides of {chosen.degrees:g} degrees, by {quoted(first)}", ""]
    lines.append("phase (%)  K expected (Nm/rad)  for 15 %  strides  u of K (%, Type A)")
    for row, need, number in zip(rows, needed, strides, strict=True):
        lines.append(
            f"{row.phase_percent:9g}  {row.K_Nm_per_rad:19g}  {np.ceil(need):8.0f}  {number:7d}  "
            f"{15.0 * np.sqrt(need / number):18.1f}"
        )
    return "\n".join(lines)
