"""Mechanisms by which the standing person violates the assumptions of the analysis, and how to omit them."""

import copy

# mechanism -> its constants below the person's section, and the values that switch it off
MECHANISMS: dict[str, dict[tuple[str, ...], object]] = {
    "soft tissue": {("skin", "shank_share"): 0.0, ("skin", "thigh_share"): 0.0},
    "skin slip": {("skin", "slip_m_per_rad"): 0.0},
    "medium-latency reflex": {
        ("tasks", task, "medium_reflex_s_per_rad"): [0.0] * 5 for task in ("relax", "stiff")
    },
    "short-range stiffness": {("tasks", task, "short_range_Nm_per_rad"): 0.0 for task in ("relax", "stiff")},
    "slow relaxation of muscles": {("nerves", "relaxation_s"): 0.0},
    "unequal legs": {("person", "marked_share"): 0.5, ("person", "marked_rotation"): 1.0},
    "soft feet": {("person", "foot_stiffness_Nm_per_rad"): 0.0},
    "joint centre": {("markers", "joint_centre_m"): [0.0, 0.0]},
}


def without(standing: dict, names: tuple[str, ...] | list[str] = tuple(MECHANISMS)) -> dict:
    """The person's section of the laboratory's configuration without some of the mechanisms.

    standing: the section; it stays what it is.
    names: mechanisms to switch off; all of `MECHANISMS` by default.
    Returns: A changed copy.
    """
    changed = copy.deepcopy(standing)
    for name in names:
        for path, off in MECHANISMS[name].items():
            section = changed
            for key in path[:-1]:
                section = section[key]
            section[path[-1]] = copy.copy(off)
    return changed
