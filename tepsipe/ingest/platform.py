"""From a table of a person on a moving platform to one trial on one regular clock."""

import numpy as np

from tepsipe.errors import InputError
from tepsipe.ingest.manipulator_options import JOINTS, PlatformTableOptions
from tepsipe.ingest.manipulators import RADIANS_PER_UNIT, recorded_columns, refuse_exchanged, refuse_slow
from tepsipe.io.trial import Signal, Trial, faults_attribute
from tepsipe.signals.sample_faults import flags_of

PERTURBATIONS = ("platform", "second_perturbation")


def ingest_platform(
    table: dict[str, np.ndarray], options: PlatformTableOptions, duration_s: float, name: str
) -> Trial:
    """Trial of a person on a moving platform.

    table: ``time`` (s), ``platform`` (in ``options.platform_unit``), ``ankle_angle``, ``hip_angle`` (in
    ``options.angle_unit``), ``ankle_torque``, ``hip_torque`` (N·m), and, if there is one,
    ``second_perturbation``.
    options: rate, longest gap, units and sign.
    duration_s: length of the trial by the protocol.
    name: names the source in messages.
    Returns: ``platform``, ``joint_angle`` and ``joint_torque`` (N·m, resists the angle) of ankle and hip,
    and ``second_perturbation``, if there is one.
    """
    perturbations = [key for key in PERTURBATIONS if key in table]
    keys = [*perturbations, *(f"{joint}_{what}" for what in ("angle", "torque") for joint in JOINTS)]
    recorded = recorded_columns(table, keys, options.max_gap_s, duration_s, name)
    columns = recorded.columns
    angles = slice(len(perturbations), len(perturbations) + 2)
    columns[:, angles] *= RADIANS_PER_UNIT[options.angle_unit]
    for k, joint in enumerate(JOINTS):
        refuse_exchanged(columns[:, angles.start + k], columns[:, angles.stop + k], name, joint)
    swing = float(np.ptp(columns[:, angles], axis=0).max())
    if swing > np.pi:
        raise InputError(
            f"{name}: expected joint angles within half a revolution, found a swing of {swing:.3g} rad when "
            f"read as {options.angle_unit}: correct angle_unit in the configuration or in the trial sheet"
        )
    faults = [
        flag
        for k in range(len(JOINTS))
        for flag in flags_of(
            recorded.recorded_hz, None, angle=columns[:, angles.start + k], torque=columns[:, angles.stop + k]
        )
    ]
    rate = options.resample_rate_hz
    refuse_slow(recorded.recorded_hz, rate, "platform.ingest.resample_rate_hz", name)
    grid, even = recorded.resampled(columns, rate)
    steps = recorded.steps(rate)
    both = ("time", "joint")
    signals = {
        "platform": Signal(even[:, 0], options.platform_unit, ("time",), "motion of the platform", steps),
        "joint_angle": Signal(even[:, angles], "rad", both, "joint angles", steps),
        "joint_torque": Signal(
            options.torque_sign * even[:, angles.stop :],
            "Nm",
            both,
            "joint torques that resist the angles",
            steps,
        ),
    }
    if len(perturbations) > 1:
        signals["second_perturbation"] = Signal(even[:, 1], "1", ("time",), "second perturbation", steps)
    return Trial(
        rate_hz=rate,
        axes={"time": grid, "joint": np.array(JOINTS)},
        signals=signals,
        attributes=recorded.attributes | faults_attribute(*faults),
    )
