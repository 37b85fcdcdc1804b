"""Faults of a rig that one trial of the dummy shows, and that all its trials share.

Markers that lag or leave the leg, and a foot that tilts, are as wrong in small perturbations as in large
ones, but only large ones show them clearly. The checks of all trials are therefore pooled: a fault that is
found in one trial flags the estimates of all. The level of a check is the probability of a false alarm over
the number of all checks of all trials (Bonferroni), so that at most 5 % of the rigs without a fault are
flagged by it.
"""

from collections.abc import Mapping, Sequence

from tepsipe.io.estimates import Estimate, flagged

FALSE_ALARMS = 0.05
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


def flag_rig(rows: Sequence[Estimate], facts: Mapping[str, dict]) -> list[Estimate]:
    """Rows of the dummy's trials with the faults of their rig; other rows as they are.

    facts: condition of the dummy -> facts of its fit: ``checks``, and ``concerned``, the checks that flag
    I, B, K of a pathway.
    Returns: in the order of ``rows``.
    """
    faults = shared_faults({condition: of_fit.get("checks", {}) for condition, of_fit in facts.items()})
    out = []
    for row in rows:
        concerned = ()
        if row.experiment == "dummy" and row.quantity.removesuffix("_small") in ("I", "B", "K"):
            concerned = facts.get(row.condition, {}).get("concerned", {}).get(row.pathway, ())
        out += flagged([row], *[name for name in faults if name in concerned])
    return out
