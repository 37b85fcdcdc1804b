"""Faults of a rig that one trial of the dummy shows, and that all its trials share.

Markers that lag or leave the leg, and a foot that tilts, are as wrong in small perturbations as in large
ones, but only large ones show them clearly. The checks of all trials are therefore pooled: a fault that is
found in one trial flags the estimates of all. The level of a check is the probability of a false alarm over
the number of all checks of all trials (Bonferroni), so that at most 5 % of the rigs without a fault are
flagged by it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tepsipe.io.estimates import Estimate, flagged
from tepsipe.io.tables import Table
from tepsipe.statistics.uncertainty import FALSE_ALARMS

# checks of what all trials share; the joint's misfit and a slipped marker belong to one trial
SHARED = ("foot-leg-delay", "foot-markers-apart", "markers-pulse-locked")
LACK_OF_FIT = "lack-of-fit"


def shared_faults(checks: Mapping[str, Mapping[str, Mapping[str, float]]]) -> list[str]:
    """Faults of the rig that at least one trial shows.

    checks: condition -> check -> its ``size``, ``tolerance`` (unit of the check) and ``probability``.
    Returns: names of checks, in the order of `SHARED`.
    """
    bound = FALSE_ALARMS / max(1, sum(len(of_trial) for of_trial in checks.values()))
    found = set()
    for of_trial in checks.values():
        failed = {
            name
            for name, check in of_trial.items()
            if check["size"] > check["tolerance"] and check["probability"] < bound
        }
        # a delay that is part of a misfit is no delay
        found |= failed - ({"foot-leg-delay"} if LACK_OF_FIT in failed else set())
    return [name for name in SHARED if name in found]


@dataclass(frozen=True)
class RigFlag:
    """Faults of the rig that flag I, B, K of a pathway in one trial: names of checks, joined by ";"."""

    condition: str
    pathway: str
    flags: str


RIG_FLAGS = Table(RigFlag, "faults of the dummy's rig")


def rig_flags(facts: Mapping[str, dict]) -> list[RigFlag]:
    """Faults that the trials of a rig share, of the ``checks`` in the facts of their fits by condition.

    ``concerned`` in these facts are the checks that flag a pathway.
    """
    faults = shared_faults({condition: of_fit.get("checks", {}) for condition, of_fit in facts.items()})
    found = [
        RigFlag(condition, pathway, ";".join(name for name in faults if name in concerned))
        for condition, of_fit in facts.items()
        for pathway, concerned in of_fit.get("concerned", {}).items()
    ]
    return [row for row in found if row.flags]


def flag_rig(rows: Sequence[Estimate], of_rig: Sequence[RigFlag]) -> list[Estimate]:
    """Rows of the dummy's trials with the faults of their rig; rows of other experiments as they are."""
    flags = {(found.condition, found.pathway): found.flags.split(";") for found in of_rig}
    out = []
    for row in rows:
        joint = row.experiment == "dummy" and row.quantity.removesuffix("_small") in ("I", "B", "K")
        out += flagged([row], *(flags.get((row.condition, row.pathway), ()) if joint else ()))
    return out
