"""Check of the trials of a study of walking."""

from tepsipe.errors import InputError, listed
from workflow.support.trial_sheet import TrialRow


def check_walking_trials(config: dict, trials: dict[tuple, TrialRow], path: str) -> None:
    """A study of walking has the section walking, trials of walking only, and pulses for simulated ones."""
    walking, rows = config["walking"], {c: row for (e, c), row in trials.items() if e == "walking"}
    if not rows and walking is None:
        return
    others = [f"{e}/{c}" for e, c in trials if e != "walking"]
    if walking is None:
        raise InputError(
            f"{path}: expected the section walking in the configuration for trials of walking, found null: "
            "copy config/walking/config.yaml"
        )
    if others or not rows:
        raise InputError(
            f"{path}: expected trials of walking only, because a study of walking has a report of its own, "
            f"found {others[0] if others else 'none of walking'}: give the other trials a study of their own"
        )
    made = [c for c, row in rows.items() if row.source == "virtual_lab"]
    simulated = walking["simulated"] or {"of": None, "trials": {}}
    for condition in made:
        if condition not in simulated["trials"]:
            raise InputError(
                f"{path}: expected the pulses of walking/{condition} in walking.simulated.trials, found "
                f"{listed(simulated['trials'])}: add it"
            )
    recorded = [c for c, row in rows.items() if row.source == "recorded"]
    if made and simulated["of"] not in recorded:
        raise InputError(
            f"{path}: expected walking.simulated.of to be a recorded trial whose strides are resampled "
            f"({listed(recorded)}), found {simulated['of']!r}: correct it"
        )
