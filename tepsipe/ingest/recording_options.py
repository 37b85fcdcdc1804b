"""Force plates and channels in a laboratory's recordings."""

from dataclasses import dataclass, field
from typing import Annotated, Self

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.io.readers.recording import DIRECTIONS, Channel, ForcePlate, Recording

LEVEL = 0.7  # least vertical component of the normal of a plate


@dataclass(frozen=True)
class ScaledChannel:
    """An analog channel that holds a velocity: (value - offset) times ``m_per_s_per_unit``."""

    channel: str
    """Its label."""
    m_per_s_per_unit: float | None = None
    """Velocity per unit of the channel (m/s); None takes it from the channel's unit."""
    offset: float = 0.0
    """Value of the channel at rest, in its unit."""

    @classmethod
    def from_settings(cls, entry: dict) -> Self | None:
        """Channel of its label, scale (m/s per unit) and offset; None without a label."""
        if entry["channel"] is None:
            return None
        return cls(entry["channel"], entry["m_per_s_per_unit"], entry["offset"])


@dataclass(frozen=True)
class LoadCell:
    """A load cell of a belt outside the file's force plates."""

    channel: str
    """Its label."""
    newton_per_unit: Annotated[float, "N"]
    """Reaction on what stands on the belt, per unit of the channel."""
    direction: str
    """Direction of that force in the axes of the file: ``+x`` to ``-z``."""
    position_m: tuple[float, float, float]
    """Its point of application in the axes of the file."""


@dataclass(frozen=True)
class RecordingOptions:
    """Plates and channels of a recording."""

    forward: str = "+y"
    up: str = "+z"
    """Directions of the study's y and z in the axes of the file: ``+x`` to ``-z``."""
    plates: dict[str, tuple[int, ...]] = field(default_factory=dict)
    """Belt -> numbers of its force plates, counted from 1."""
    load_cells: dict[str, tuple[LoadCell, ...]] = field(default_factory=dict)
    """Belt -> its load cells outside the force plates."""
    force_sign: int = 1
    """1 if the plates give the force on what stands on them, -1 if they give the force on the plate."""
    reverse_origin: bool = False
    """Whether the vectors from the plates' own origins to their surfaces were stored in the other
    direction, although their vertical component does not show it."""
    belt_velocity: ScaledChannel | None = None
    """Velocity of the perturbed belt; None takes it from ``velocity_markers``."""
    velocity_markers: tuple[str, ...] = ()
    """Belt-fixed markers."""
    belt_command: ScaledChannel | None = None
    """Commanded velocity, if it was recorded."""
    trigger: str | None = None
    """Channel whose edge is time 0; None for the first frame."""

    @classmethod
    def from_settings(cls, recording: dict | None) -> Self:
        """Options of a study; None, for trials of several files, gives the defaults."""
        if recording is None:
            return cls()
        return cls(
            forward=recording["axes"]["forward"],
            up=recording["axes"]["up"],
            plates={belt: tuple(numbers) for belt, numbers in recording["plates"].items()},
            load_cells={
                belt: tuple(LoadCell(**cell | {"position_m": tuple(cell["position_m"])}) for cell in cells)
                for belt, cells in recording["load_cells"].items()
            },
            force_sign=recording["force_sign"],
            reverse_origin=recording["reverse_origin"],
            belt_velocity=ScaledChannel.from_settings(recording["belt_velocity"]),
            velocity_markers=tuple(recording["belt_velocity"]["markers"]),
            belt_command=ScaledChannel.from_settings(recording["belt_command"]),
            trigger=recording["trigger"],
        )


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
