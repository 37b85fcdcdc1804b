"""Settings of a person on a platform that moves forwards and backwards, from recordings."""

from typing import Literal

from workflow.settings.position_manipulator import TableIngest
from workflow.settings.quantities import (
    AngleUnit,
    Delimiter,
    Fraction,
    Frequency,
    InnerFraction,
    Positive,
    Sign,
    band,
    different,
    fixed,
    number,
)
from workflow.settings.section import Section, one_of, setting

ReflexDelay = number(above=0, most=1)  # s


class PlatformColumns(Section):
    """Columns of the table."""

    time: str = setting("column: time (s)")
    platform: str = setting("column: motion of the platform (in `platform_unit`)")
    ankle_angle: str = setting("column: angle of the ankle (in `angle_unit`)")
    hip_angle: str = setting("column: angle of the hip (in `angle_unit`)")
    ankle_torque: str = setting("column: torque of the ankle (N·m)")
    hip_torque: str = setting("column: torque of the hip (N·m)")
    second_perturbation: str | None = setting(
        "column: a second perturbation, independent of the platform (any unit); null if there is none"
    )


class PlatformFiles(Section):
    """Tables of a recording."""

    columns: PlatformColumns
    delimiter: Delimiter = setting("delimiter of the table")
    angle_unit: AngleUnit = setting("unit of the angles")
    torque_sign: Sign = setting(
        "−1 if a torque that resists a positive angle is recorded as negative, otherwise 1"
    )
    platform_unit: Literal["m", "m/s", "m/s2"] = setting(
        "position, velocity or acceleration of the platform; estimates do not depend on which"
    )


class PlatformAnalysis(Section):
    """Closed-loop identification of ankle and hip."""

    band_hz: band(Frequency) = setting(
        "lowest and highest frequency that is fitted: where the platform moves and the torque is measured "
        "well"
    )
    averaged_bins: int = setting(
        "raw frequencies per band; the record must hold 8 bands, and so must its held-out part", least=4
    )
    taper_fraction: number(least=0, most=0.25) = setting("part of the record over which each end fades")
    models: different(
        one_of(
            {
                "intrinsic": "*K* and *B* of both angles",
                "own-reflex": "the same with a delayed *K* and *B* of each joint's own angle",
                "all-reflex": "the same of both angles",
            }
        )
    ) = setting("models from the least free to the most")
    delays_s: fixed(ReflexDelay, 2) = setting(
        "delays of reflexes that are tried, one for each joint's torque"
    )
    delay_step_s: ReflexDelay = setting("step of these delays")
    strength: number(above=1) = setting(
        "least power of a combination of parameters in the bands over that of noise alone; weaker ones "
        "are not determined"
    )
    largest_share: Positive = setting(
        "largest standard error of a quoted quantity, times the angle that the platform drives, over the "
        "torque that it drives"
    )
    mode_below_hz: Frequency = setting(
        "below this frequency motion is slow; its direction is that of `K_mode`"
    )
    rejected_below: Fraction = setting(
        "a model is rejected if the torque that it leaves is coherent with the platform with a smaller "
        "probability"
    )
    training_fraction: InnerFraction = setting(
        "first part of the trial, fitted for the held-out validation; estimates are of the whole trial"
    )


class Platform(Section):
    """A person on a moving platform."""

    files: PlatformFiles
    ingest: TableIngest
    analysis: PlatformAnalysis
