"""Registry of the rigs: what makes the raw files of each simulated experiment, and from which constants."""

from dataclasses import dataclass

DUMMY = tuple(f"dummy.{part}" for part in ("rubber", "subject", "markers", "foot_tilt", "wobble", "slip"))
# the person's constants, but for those of a task
PERSON = tuple(f"standing.{part}" for part in ("person", "muscles", "nerves", "markers", "skin", "emg"))


@dataclass(frozen=True)
class Rig:
    """How trials of an experiment are made."""

    module: str
    """Module of this package with the function that makes a trial, called make_<module>."""
    constants: tuple[str, ...]
    """Constants that it is given, as paths; ``{weight}``: weight or heavy_weight, ``{task}``: the trial's."""
    told: tuple[str, ...]
    """What it is told of the trial: arguments of that function."""
    motion: bool = False
    """Whether it writes the hidden motion beside the raw files."""


RIGS = {
    "wristalyzer": Rig(
        "wristalyzer_trial", ("seed", "wristalyzer", "dummy.rubber"), ("amplitude", "duration_s"), True
    ),
    "dummy": Rig("dummy_trial", ("seed", "treadmill", *DUMMY), ("protocol",), True),
    "weight": Rig("weight_trial", ("seed", "treadmill", "{weight}"), ("protocol", "belt")),
    "empty": Rig("weight_trial", ("seed", "treadmill"), ("protocol", "belt")),
    "standing": Rig(
        "standing_trial",
        ("seed", "treadmill", *PERSON, "standing.tasks.{task}"),
        ("task", "protocol", "belt"),
        True,
    ),
}
