"""From sections of the configuration to the options of treadmill models: what several scripts need."""

from tepsipe.treadmill_models.family import FamilyOptions
from tepsipe.treadmill_models.ripple import RippleOptions


def family_options(models: dict) -> FamilyOptions:
    """Options of a section ``models`` but for its ``family``."""
    models = {key: value for key, value in models.items() if key != "family"}
    return FamilyOptions(**{**models, "ripple": RippleOptions(**models["ripple"])})
