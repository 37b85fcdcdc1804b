"""Designs, printed tables and files of ``tepsipe plan``.

A design file has the keys of the library's dataclasses (`Design`, `StandingDesign`, `WalkingDesign`), and of
section ``plan`` of a study. Options of the command replace its values.
"""

import json
import math
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from tepsipe.arguments import described, one_of, read_options
from tepsipe.errors import InputError, nearest, quoted
from tepsipe.experiments.planning.design import Design, Protocol, Rig
from tepsipe.experiments.planning.optimal_pulse import Optimised, best_of
from tepsipe.experiments.planning.plan import Plan, plan_experiment
from tepsipe.experiments.planning.pulses import Limits, Pulse, peaks_of, pulse_of
from tepsipe.experiments.planning.standing_plan import StandingDesign, StandingPlan, plan_standing
from tepsipe.experiments.walking.needed_strides import FEWEST_PLANNED, NEEDED_ROWS, allocation
from tepsipe.io.readers.plain_file import read_text
from tepsipe.io.tables import write_records
from tepsipe.mechanics.engines.interface import Joint
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.statistics.uncertainty import Source, stated_sources

# standard uncertainties of the thesis's dummy, as the study states them with reasons (units in the names)
TOLERANCES = {
    "leg_mass_kg": 0.00433,
    "leg_com_m": 0.002,
    "leg_inertia_kgm2": 0.000289,
    "joint_offset_m": 0.001,
    "anterior_offset_m": 0.0001,
    "longitudinal_offset_m": 0.0005,
    "vertical_rad": 0.003,
    "marker_scale": 0.0001,
    "clock_ratio": 0.0000115,
    "foot_mass_kg": 0.0289,
    "foot_com_m": 0.002,
    "foot_compliance_rad_per_Nm": 0.0005,
    "force_scale": 0.00289,
    "vertical_leak": 0.002,
    "origin_height_m": 0.001,
}
# joint, leg, foot and pulse of the thesis's dummy
JOINT = {"inertia_Nms2_per_rad": 0.007, "damping_Nms_per_rad": 0.1, "stiffness_Nm_per_rad": 10.0}
LEG = {"mass_kg": 0.4, "com_m": 0.4485, "inertia_kgm2": 0.027}
FOOT = {"mass_kg": 2.1, "height_m": 0.055}
PULSE = {"profile": "sine", "amplitude_m_per_s": 0.3, "duration_s": 0.1}
PULSE_OF_A_PERSON = PULSE | {"amplitude_m_per_s": 0.4}
# sections and keys of a design of the dummy
DUMMY = ("joint", "leg", "foot", "rig", "protocol", "tolerances", "without_tolerances", "limits", "returning")
# option of the command -> key of the design, by experiment
OPTIONS = {
    "dummy": {
        "stiffness": "joint.stiffness_Nm_per_rad",
        "damping": "joint.damping_Nms_per_rad",
        "number": "protocol.number",
        "amplitude": "protocol.amplitude_m_per_s",
        "profile": "protocol.profile",
        "duration": "protocol.duration_s",
        "pathway": "protocol.pathway",
        "marker_noise": "rig.marker_noise_m",
        "camera_rate": "rig.camera_rate_hz",
    },
    "standing": {
        "stiffness": "stiffness_Nm_per_rad",
        "damping": "damping_Nms_per_rad",
        "number": "number",
        "amplitude": "amplitude_m_per_s",
        "profile": "profile",
        "duration": "duration_s",
        "marker_noise": "marker_noise_m",
        "camera_rate": "camera_rate_hz",
        "frame": "frame_hz",
    },
    "walking": {"number": "number", "needed": "needed"},
}


@dataclass(frozen=True)
class DummyDesign:
    """A design of the dummy, and how its pulse may be improved."""

    design: Design
    """The experiment."""
    limits: Limits | None
    """Of the belt's motion for the best pulse (m/s, m, m/s², m/s³); None for the peaks of the planned
    pulse."""
    returning: bool
    """Whether the belt returns within the best pulse."""

    def plan(self, optimise: bool) -> tuple[Plan, Optimised | None]:
        """Plan, and optimise where it is asked for."""
        if not optimise and (self.limits or self.returning):
            raise InputError(
                "plan: expected --optimise with limits of the belt or returning, found none: add it"
            )
        plan = plan_experiment(self.design)
        if not optimise:
            return plan, None
        return plan, best_of(plan, self.limits or peaks_of(plan.motion.pulse_velocity), not self.returning)


@dataclass(frozen=True, kw_only=True)
class WalkingDesign:
    """Perturbed strides to be divided among the phases of stance."""

    needed: str
    """Table of strides needed, of a study of walking."""
    number: int = 150
    """Perturbed strides."""
    amplitude_deg: float = 2.0
    planned_amplitude_deg: float = 1.5
    """Rotation of the ankle by a pulse, and the rotation for which the table was computed."""

    def __post_init__(self):
        """Refuse impossible rotations."""
        for name in ("amplitude_deg", "planned_amplitude_deg"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(
                    f"walking: expected a positive {name}, found {getattr(self, name):g}: correct it"
                )


def read_design(path: Path) -> dict[str, Any]:
    """Keys and values of a design file: TOML, or JSON if its name ends in .json."""
    text = read_text(path, "a design file")
    try:
        if path.suffix.lower() == ".json":
            content = json.loads(text, object_pairs_hook=_without_repetition)
        else:
            content = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(
            f"{path}: expected a design as TOML, or as JSON if its name ends in .json, found "
            f"{quoted(error)}: correct it"
        ) from error
    if not isinstance(content, dict):
        raise InputError(f"{path}: expected keys and values, found {described(content)}: correct it")
    return content


def _without_repetition(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a key that is given twice")
    return found


def design_of(
    path: Path | None, experiment: str | None, options: Mapping[str, Any]
) -> DummyDesign | StandingDesign | WalkingDesign:
    """Design of a file, if there is one, with the options of the command (units in their help) instead."""
    content = {} if path is None else read_design(path)
    place = "plan" if path is None else str(path)
    stated = one_of(content.pop("experiment", experiment or "dummy"), f"{place}: experiment", _MAKERS)
    experiment = experiment or stated
    for name, value in options.items():
        if name not in OPTIONS[experiment]:
            raise InputError(
                f"plan: expected no --{name.replace('_', '-')} with the experiment {experiment}, found it: "
                "leave it out"
            )
        *sections, key = OPTIONS[experiment][name].split(".")
        section = content
        for part in sections:
            section = section.setdefault(part, {})
        if isinstance(section, dict):  # what is no section is refused below
            section[key] = value
    try:
        return _MAKERS[experiment](content, place)
    except InputError as error:
        if path is None or str(error).startswith(place):
            raise
        raise InputError(f"{place}: {error}") from error


def _pulse_of(content: dict[str, Any], defaults: dict[str, Any], place: str) -> Pulse:
    """Pulse of the keys of a section, which are taken out of it."""
    given = {key: content.pop(key) for key in PULSE if key in content}
    return pulse_of(**(defaults | read_options(pulse_of, given, place, PULSE)))


def _section(content: Mapping[str, Any], name: str, place: str) -> dict[str, Any]:
    """Copy of a section of a design; empty where it is left out."""
    found = content.get(name, {})
    if not isinstance(found, Mapping):
        raise InputError(f"{place}: {name}: expected keys and values, found {described(found)}: correct it")
    return dict(found)


def _choice(content: Mapping[str, Any], name: str, place: str) -> bool:
    """Truth value of a design; false where it is left out."""
    found = content.get(name, False)
    if not isinstance(found, bool):
        raise InputError(f"{place}: {name}: expected true or false, found {described(found)}: correct it")
    return found


def _dummy_design(content: dict[str, Any], place: str) -> DummyDesign:
    for name in content:
        if name not in DUMMY:
            raise InputError(f"{place}: expected a known key, found {quoted(name)}: {nearest(name, DUMMY)}")
    joint, leg, foot, rig, protocol, stated, limits = (
        _section(content, name, place)
        for name in ("joint", "leg", "foot", "rig", "protocol", "tolerances", "limits")
    )
    without, returning = (_choice(content, name, place) for name in ("without_tolerances", "returning"))
    pulse = _pulse_of(protocol, PULSE, f"{place}: protocol")
    sources = {name: Source(name, u) for name, u in TOLERANCES.items()}
    sources |= stated_sources(stated, list(TOLERANCES), f"{place}: tolerances")
    design = Design(
        joint=Joint(**(JOINT | read_options(Joint, joint, f"{place}: joint", JOINT))),
        leg=Leg(**(LEG | read_options(Leg, leg, f"{place}: leg", [*LEG, "gravity_m_per_s2"]))),
        foot=Foot(**(FOOT | read_options(Foot, foot, f"{place}: foot", FOOT))),
        rig=Rig(**read_options(Rig, rig, f"{place}: rig", _keys(Rig, "leg_markers"))),
        protocol=Protocol(
            pulse=pulse, **read_options(Protocol, protocol, f"{place}: protocol", _keys(Protocol, "pulse"))
        ),
        sources={} if without else sources,
    )
    found = Limits(**read_options(Limits, limits, f"{place}: limits")) if limits else None
    return DummyDesign(design, found, returning)


def _standing_design(content: dict[str, Any], place: str) -> StandingDesign:
    pulse = _pulse_of(content, PULSE_OF_A_PERSON, place)
    keys = _keys(StandingDesign, "pulse", "options")
    return StandingDesign(pulse=pulse, **read_options(StandingDesign, content, place, keys))


def _walking_design(content: dict[str, Any], place: str) -> WalkingDesign:
    return WalkingDesign(**read_options(WalkingDesign, content, place))


def _keys(kind: type, *without: str) -> list[str]:
    """Names of the fields of a dataclass that a design file may hold."""
    return [field.name for field in fields(kind) if field.name not in without]


def walking_summary(design: WalkingDesign) -> str:
    """Strides of each phase of stance, from the table of strides needed (units in it)."""
    every = NEEDED_ROWS.read(design.needed)
    first = next((row.condition for row in every), None)
    rows = [row for row in every if (row.condition, row.matching) == (first, "state")]
    if not rows:
        raise InputError(
            f"{design.needed}: expected strides needed at phases of stance, found none: run a study of "
            "walking"
        )
    # the variance of one stride falls with the square of the amplitude
    ratio = design.planned_amplitude_deg / design.amplitude_deg
    needed = [row.strides_for_15_percent * ratio**2 for row in rows]
    strides = allocation(needed, design.number, FEWEST_PLANNED)
    lines = [f"{design.number} perturbed strides of {design.amplitude_deg:g} degrees, by {quoted(first)}", ""]
    lines.append("phase (%)  K expected (Nm/rad)  for 15 %  strides  u of K (%, Type A)")
    for row, need, number in zip(rows, needed, strides, strict=True):
        lines.append(
            f"{row.phase_percent:9g}  {row.K_Nm_per_rad:19g}  {np.ceil(need):8.0f}  {number:7d}  "
            f"{15.0 * np.sqrt(need / number):18.1f}"
        )
    return "\n".join(lines)


def _standing_summary(plan: StandingPlan) -> str:
    """Table and sentences of a plan (units in it)."""
    lines = ["quantity      value    Type A    Type B  combined  95 % interval"]
    rows = plan.rows()
    for row in rows:
        numbers = (row[key] for key in ("value", "predicted_u", "u_type_b", "u_combined"))
        cells = " ".join(f"{x:9.4g}" for x in numbers)
        lines.append(f"{row['quantity']:2} ({row['unit']}) {cells}  +-{row['half_width_percent']:.1f} %")
    lines.append(
        f"\n{plan.design.number} responses of both ankles on a frame of {plan.design.frame_hz:g} Hz, "
        "free-reflex-gls; I of the feet is known"
    )
    for percent in (5, 10, 20):
        needed = rows[1][f"n_for_{percent}_percent"]
        text = "no number, Type B alone exceeds it" if needed is None else str(needed)
        lines.append(f"responses for K +-{percent} % (95 %): {text}")
    return "\n".join(lines)


def _summary(plan: Plan, best: Optimised | None) -> str:
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


def carried_out(
    design: DummyDesign | StandingDesign, optimise: bool, table: Path
) -> tuple[str, dict[str, Plan | StandingPlan]]:
    """Plan an experiment, and with ``optimise`` the best pulse, and write the rows as CSV (units in it).

    Returns: the plan as text, and plans by the profiles of their pulses.
    """
    if isinstance(design, StandingDesign):
        standing = plan_standing(design)
        rows = [{"design": f"standing-{design.pulse.profile}"} | row for row in standing.rows()]
        text, plans = _standing_summary(standing), {design.pulse.profile: standing}
    else:
        plan, best = design.plan(optimise)
        profile = plan.design.protocol.pulse.profile
        rows, plans = [{"design": profile} | row for row in plan.rows()], {profile: plan}
        if best is not None:
            rows += [{"design": best.found.pulse.profile} | row for row in best.plan.rows()]
            plans["optimal"] = best.plan
        text = _summary(plan, best)
    write_records(table, rows)
    return text, plans


# experiment -> maker of its design
_MAKERS: dict[str, Callable[[dict[str, Any], str], DummyDesign | StandingDesign | WalkingDesign]] = {
    "dummy": _dummy_design,
    "standing": _standing_design,
    "walking": _walking_design,
}
