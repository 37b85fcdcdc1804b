"""From sections of the configuration to the options of treadmill models: what several scripts need."""

from tepsipe.treadmill.registry import FamilyOptions
from tepsipe.treadmill.ripple import RippleOptions


def family_options(models: dict) -> FamilyOptions:
    """Options of a section ``models``; ``ripple`` is that of a travelling belt only."""
    models = {key: value for key, value in models.items() if key not in ("family", "calibration_draws")}
    if "ripple" in models:
        models["ripple"] = RippleOptions(**models["ripple"])
    return FamilyOptions(**models)
