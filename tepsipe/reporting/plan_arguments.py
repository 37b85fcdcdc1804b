"""Arguments of ``tepsipe plan``: nothing is imported that takes time, because every command reads them."""

import argparse
from pathlib import Path

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
# what can be chosen: tests hold them equal to those of the planning itself
PATHWAYS = ("joint-likelihood", "joint-likelihood-linear", "leg", "foot")
PROFILES = ("sine", "minjerk", "half-sine", "ramp")
# option, default, unit and meaning of every number, by group
_NUMBERS = {
    "expected joint": (
        ("stiffness", 10.0, "Nm/rad", "K"),
        ("damping", 0.1, "Nms/rad", "B"),
        ("inertia", 0.007, "Nms2/rad", "I, in addition to the leg's own inertia"),
    ),
    "leg and foot": (
        ("leg-mass", 0.4, "kg", "mass of the leg"),
        ("leg-com", 0.4485, "m", "distance of the leg's centre of mass from the joint"),
        ("leg-inertia", 0.027, "kgm2", "moment of inertia of the leg about its centre of mass"),
        ("foot-mass", 2.1, "kg", "mass of the foot"),
        ("foot-height", 0.055, "m", "height of the joint above the belt"),
    ),
    "rig": (
        ("marker-noise", 0.0000065, "m", "noise of a marker in each direction"),
        ("camera-rate", 250.0, "Hz", "rate of the cameras"),
        ("log-noise", 0.001, "m/s", "noise of the logged belt velocity"),
        ("log-rate", 1000.0, "Hz", "rate of the log"),
        ("force-noise", 0.2, "N", "noise of the plate's forces"),
        ("moment-noise", 0.05, "Nm", "noise of the plate's moment"),
        ("plate-rate", 1000.0, "Hz", "rate of the plate"),
        ("sync-jitter", 0.00015, "s", "standard uncertainty of the time between plate and cameras"),
        ("drive-bandwidth", 14.0, "Hz", "bandwidth of the belt's drive; 0 if the belt follows every command"),
        ("drive-acceleration", 24.0, "m/s2", "largest acceleration that the belt's drive can produce"),
    ),
    "protocol": (
        ("amplitude", 0.3, "m/s", "peak velocity of the command"),
        ("duration", 0.1, "s", "length of a pulse"),
        ("interval", 4.0, "s", "time from one onset to the next"),
        ("rest", 3.0, "s", "unperturbed time at the start, and the same at the end"),
        ("cutoff", 20.0, "Hz", "zero-lag low-pass of windowed least squares (leg, foot)"),
    ),
    "standing person, with --standing": (
        ("person-stiffness", 400.0, "Nm/rad", "K of both ankles"),
        ("person-damping", 10.0, "Nms/rad", "B of both ankles"),
        (
            "person-lever",
            0.85,
            "m",
            "height above the ankle of the point about which a pulse turns the shank",
        ),
        ("sway-torque", 2.0, "Nm", "standard deviation of the sway torque that B and K do not explain"),
        ("sway-time", 0.18, "s", "time constant of sway"),
        ("person-angle-noise", 12.0, "rad/m", "noise of the ankle angle, divided by the noise of a marker"),
        (
            "person-type-b",
            0.075,
            "1",
            "relative uncertainty of B and K due to treadmill model, joint centre and feet",
        ),
    ),
    "walking person, with --walking": (
        ("degrees", 2.0, "deg", "rotation of the ankle by a pulse"),
        (
            "planned-degrees",
            1.5,
            "deg",
            "rotation for which the table was computed (walking.planned.amplitude_deg)",
        ),
    ),
    "limits of the belt's motion": (
        ("max-velocity", None, "m/s", "for --optimise; if no limit is given, the peaks of the planned pulse"),
        ("max-displacement", None, "m", "for --optimise"),
        ("max-acceleration", None, "m/s2", "for --optimise"),
        ("max-jerk", None, "m/s3", "for --optimise"),
    ),
}


def add_plan(commands: argparse._SubParsersAction) -> argparse.ArgumentParser:
    """Arguments of ``tepsipe plan``, with the thesis's dummy as default (units in their help)."""
    parser = commands.add_parser(
        "plan",
        help="predict the uncertainty of I, B and K in an experiment, and how many perturbations it needs",
        description="Predict from joint, leg, rig and protocol the standard uncertainty of I, B and K in an "
        "experiment, Type A and Type B, and the number of perturbations that K needs. The defaults describe "
        "the ankle dummy and the treadmill of the thesis. Prints a table and writes it as CSV, with a figure "
        "as PNG.",
    )
    for title, options in _NUMBERS.items():
        group = parser.add_argument_group(title)
        for name, default, unit, meaning in options:
            text = meaning if default is None else f"{meaning}; default {default:g}"
            group.add_argument(f"--{name}", type=float, default=default, metavar=unit, help=text)
        if title.startswith("standing"):
            group.add_argument("--standing", action="store_true", help="plan for a standing person's ankles")
        if title.startswith("walking"):
            group.add_argument(
                "--walking",
                type=Path,
                metavar="NEEDED",
                help="tables/needed.csv of a walking study; divides --strides among the phases",
            )
            group.add_argument(
                "--strides", type=int, default=150, metavar="N", help="perturbed strides; default 150"
            )
        if title == "protocol":
            group.add_argument("--profile", default="sine", choices=PROFILES, help="default sine")
            group.add_argument(
                "--number", type=int, default=14, metavar="N", help="number of perturbations; default 14"
            )
            group.add_argument("--order", type=int, default=4, help="order of the low-pass; default 4")
            group.add_argument(
                "--pathway",
                default=PATHWAYS[0],
                choices=PATHWAYS,
                help="joint-likelihood: likelihood of all markers and the log, for a joint that may soften "
                "or (-linear) a linear one; leg, foot: windowed least squares with that torque; "
                f"default {PATHWAYS[0]}",
            )
    group = parser.add_argument_group("tolerances of the calibration")
    group.add_argument(
        "--tolerance",
        action="append",
        default=[],
        metavar="NAME=U",
        help="standard uncertainty of a constant, for example leg_mass_kg=0.01; the constants are "
        f"{', '.join(TOLERANCES)}",
    )
    group.add_argument("--no-tolerances", action="store_true", help="Type A only")
    parser.add_argument("--optimise", action="store_true", help="also find the best pulse within the limits")
    parser.add_argument(
        "--returning",
        action="store_true",
        help="with --optimise: the belt returns to its starting point within the pulse",
    )
    parser.add_argument(
        "--output", type=Path, default=Path("plan"), metavar="PREFIX", help="write PREFIX.csv and PREFIX.png"
    )
    return parser
