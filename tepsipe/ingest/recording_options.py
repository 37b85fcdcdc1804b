"""Force plates and channels in a laboratory's recordings."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge

from tepsipe.errors import InputError, listed
from tepsipe.io.readers.recording import DIRECTIONS, Channel, ForcePlate, Recording
from tepsipe.quantities import DIFFERENT, Direction, Offset, Scale, Sign, Three

LEVEL = 0.7  # least vertical component of the normal of a plate


Plates = Annotated[Sequence[Annotated[int, Ge(1)]], DIFFERENT]


@dataclass(frozen=True)
class Axes:
    """Directions in the file."""

    forward: Direction = "+y"
    """Direction in the file in which a positive belt velocity moves the belt."""
    up: Direction = "+z"
    """Upward direction in the file."""


@dataclass(frozen=True)
class PlateNumbers:
    """Force plates under each belt."""

    left: Plates = ()
    """Numbers of the force plates under the left belt, from 1; loads of several are added. A belt may have
    none."""
    right: Plates = ()
    """The same of the right belt."""


@dataclass(frozen=True)
class LoadCell:
    """Load cell of a belt that is not among the force plates of the file."""

    channel: str
    """Label of the channel."""
    newton_per_unit: Scale
    """Reaction on the body per unit of the channel."""
    direction: Direction
    """Direction in the axes of the file."""
    position_m: Three[Offset]
    """Point of application in the axes of the file."""


@dataclass(frozen=True)
class LoadCells:
    """Load cells of each belt."""

    left: Sequence[LoadCell] = ()
    """Load cells of the left belt that are not among the force plates of the file; their forces and moments
    are added to those of the plates."""
    right: Sequence[LoadCell] = ()
    """The same of the right belt."""


@dataclass(frozen=True)
class ScaledChannel:
    """Channel of a velocity of the belt: (value - offset) times ``m_per_s_per_unit``."""

    channel: str | None = None
    """Label of the channel; null without one."""
    m_per_s_per_unit: Scale | None = None
    """Velocity per unit of it; null takes it from the channel's unit."""
    offset: float = 0.0
    """Its value at rest, in its unit."""


@dataclass(frozen=True)
class BeltVelocity(ScaledChannel):
    """Velocity of the belt, from a channel or from belt-fixed markers."""

    markers: Annotated[Sequence[str], DIFFERENT] = ()
    """Belt-fixed markers, whose mean velocity is used if there is no channel, and which align D-Flow's
    record file."""


@dataclass(frozen=True)
class RecordingOptions:
    """Trials whose log is one file that holds everything."""

    axes: Axes = Axes()
    plates: PlateNumbers = PlateNumbers()
    load_cells: LoadCells = LoadCells()
    force_sign: Sign = 1
    """−1 if the plates give the force on the plate instead of the reaction on the body."""
    reverse_origin: bool = False
    """True if `ORIGIN` of the plates points from the surface to the plate's origin although its z is not
    positive, as some software stores the plates of treadmills with a z of 0."""
    belt_velocity: BeltVelocity = BeltVelocity()
    belt_command: ScaledChannel = ScaledChannel()
    trigger: str | None = None
    """Channel whose rising edge (`ingest.trigger_threshold_V`) is time 0; what is later than `duration_s` is
    omitted. Null: time 0 is the first frame, and the whole file is used."""


def refuse_other_vertical(plates: dict[int, ForcePlate], up: str, name: str, key: str) -> None:
    """Compare the configured upward direction with the surfaces of the plates.

    plates: number -> plate.
    up: upward direction in the axes of the file: ``+x`` to ``-z``.
    name: names the file in messages.
    key: place of ``up`` in the configuration, for messages.
    """
    for number, plate in plates.items():
        if plate.normal is not None and abs(plate.normal @ DIRECTIONS[up]) < LEVEL:
            axis = "xyz"[int(np.argmax(np.abs(plate.normal)))]
            raise InputError(
                f"{name}, force plate {number}: expected a level surface, with {up} upward by {key}, found "
                f"corners whose surface faces along {axis}: correct {key} (tepsipe info names the upward "
                "direction), or FORCE_PLATFORM:CORNERS of the file"
            )


def named_channel(recording: Recording, label: str, key: str) -> Channel:
    """A channel of a recording, named by a key of the configuration."""
    if label not in recording.channels:
        raise InputError(
            f"{recording.name}: expected a channel named {label!r}, found {listed(recording.channels)}: "
            f"name the file's channel in {key} of the configuration"
        )
    channel = recording.channels[label]
    bad = int(np.count_nonzero(~np.isfinite(channel.values)))
    if bad:
        raise InputError(
            f"{recording.name}: expected a number in every sample of the channel {label!r}, found none in "
            f"{bad}: export the file again"
        )
    return channel
