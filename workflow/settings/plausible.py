"""Limits of what the signals of a trial can be."""

from tepsipe.ingest.limits import Limits
from workflow.settings.section import made_from, number, setting


class Plausible(made_from(Limits)):
    """Limits of what the signals of a trial can be."""

    mass_fraction: number(above=0, most=1) = setting(
        "largest relative error of the mass of weight or dummy on the plate. That of a person is compared in "
        "the same way, while the person stands still"
    )
    plate_offset_kg: number(least=0, most=500) = setting("error that is accepted for light masses")
