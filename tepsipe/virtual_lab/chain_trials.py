"""Recordings of persons with ankle, knee and hip as an HDF5 file, one group per person."""

from pathlib import Path

import h5py

from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.standing_chain import (
    STEP_S,
    ChainPerson,
    ChainProtocol,
    ChainRecord,
    Pulse,
    record_chain,
)

SEGMENTS = ("shank", "thigh", "trunk")


def chain_protocol(perturbations: dict, protocol: dict, engine: str) -> ChainProtocol:
    """Protocol of sections of settings and the engine's name.

    A perturbation has a ``displacement_m`` of the belt, or a ``force_N`` on a ``segment`` at ``height_m``.
    """
    return ChainProtocol(
        pulses={name: _pulse(one) for name, one in perturbations.items()}, **protocol, engine=engine
    )


def _pulse(one: dict) -> Pulse:
    if "displacement_m" in one:
        return Pulse(None, one["displacement_m"], one["duration_s"])
    return Pulse(SEGMENTS.index(one["segment"]), one["force_N"], one["duration_s"], one["height_m"])


def write_chain_trials(
    path: str | Path, person: ChainPerson, protocol: ChainProtocol, seed: int, persons: int
) -> None:
    """Record the person several times, with other sway and noise each time (rad, N, m/s²).

    path: HDF5 file that is written.
    seed: seed of all draws.
    persons: number of recordings.
    """
    with h5py.File(path, "w") as file:
        for k in range(persons):
            record = record_chain(person, protocol, generator(seed, "several-joints", str(k)))
            _write(file.create_group(str(k)), record, protocol)


def _write(group, record: ChainRecord, protocol: ChainProtocol) -> None:
    group.attrs["rate_hz"] = protocol.rate_hz
    group.attrs["drive_rate_hz"] = 1.0 / STEP_S
    group.attrs["before"] = round(protocol.before_s * protocol.rate_hz)
    group.create_dataset("unperturbed", data=record.unperturbed).attrs["units"] = "rad"
    for name, arrays in (("angle", record.angle), ("drive", record.drive)):
        subgroup = group.create_group(name)
        subgroup.attrs["names"] = list(arrays)
        for key, values in arrays.items():
            belt = protocol.pulses[key].segment is None
            unit = "rad" if name == "angle" else "m/s2" if belt else "N"
            subgroup.create_dataset(key, data=values).attrs["units"] = unit
