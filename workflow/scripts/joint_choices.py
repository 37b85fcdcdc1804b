"""From the section plan.several_joints of the configuration to what several scripts need."""

from tepsipe.experiments.planning.several_joints import SEGMENTS, Point
from tepsipe.identification.several_joints.determined import Limits
from tepsipe.mechanics.segment_chain import Chain


def chain_of(joints: dict) -> Chain:
    """Segments of the section ``person``."""
    person = joints["person"]
    return Chain(
        *(tuple(person[key]) for key in ("mass_kg", "length_m", "com_m", "inertia_kgm2")),
        gravity_m_per_s2=person["gravity_m_per_s2"],
    )


def points_of(joints: dict) -> dict[str, Point]:
    """Where the section ``perturbations`` acts: on the belt, or on a segment at a height."""
    return {
        name: Point(None)
        if "displacement_m" in one
        else Point(SEGMENTS.index(one["segment"]), one["height_m"])
        for name, one in joints["perturbations"].items()
    }


def limits_of(joints: dict) -> Limits:
    """Of what counts as determined, from the section ``limits``."""
    limits = joints["limits"]
    return Limits(0.01 * limits["stiffness_percent"], 0.01 * limits["damping_percent"])
