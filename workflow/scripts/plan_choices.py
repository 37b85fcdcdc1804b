"""From the section plan of the configuration to designs: what several scripts need."""

from tepsipe.experiments.planning.design import Design, Protocol, Rig
from tepsipe.experiments.planning.pulses import Drive, pulse_of
from tepsipe.mechanics.engines.interface import Joint
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.statistics.uncertainty import sources_of


def design_of(plan: dict, name: str, geometry: dict, uncertainty: dict) -> Design:
    """Design of a name, of the sections plan, dummy.geometry and uncertainty.dummy."""
    changes = plan["designs"][name]
    rig = plan["rig"] | changes.get("rig", {})
    protocol = plan["protocol"] | changes.get("protocol", {})
    shape = (protocol.pop("profile"), protocol.pop("amplitude_m_per_s"), protocol.pop("duration_s"))
    joint = plan["joint"] | changes.get("joint", {})
    return Design(
        joint=Joint(**joint),
        leg=Leg(
            mass_kg=geometry["leg_mass_kg"],
            com_m=geometry["leg_com_m"],
            inertia_kgm2=geometry["leg_inertia_kgm2"],
            gravity_m_per_s2=geometry["gravity_m_per_s2"],
        ),
        foot=Foot(mass_kg=geometry["foot_mass_kg"], height_m=geometry["foot_height_m"]),
        rig=Rig(**rig | {"drive": Drive(**rig["drive"])}),
        protocol=Protocol(pulse=pulse_of(*shape), **protocol),
        sources=sources_of(uncertainty),
    )
