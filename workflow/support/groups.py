"""Who did which trial, for the tables of participants and groups."""

from tepsipe.experiments.registry import EXPERIMENTS
from workflow.support.study import Study


def labels(study: Study) -> dict[str, dict[str, dict[str, str]]]:
    """Column -> experiment -> condition or task -> participant, or belt: what the sheet names of the two."""
    found: dict[str, dict[str, dict[str, str]]] = {}
    named = (("participant", study.by_participant), ("belt", study.by_belt))
    for column in [name for name, there in named if there]:
        cells: dict[str, dict[str, str]] = {}
        for (experiment, condition), row in study.trials.items():
            belt = study.treadmill.belt_of(experiment, condition)
            cell = row.participant if column == "participant" else belt
            cells.setdefault(experiment, {})[condition] = cell or ""
        for pool in study.tasks.pools().values():
            cells["standing"][pool.name] = getattr(pool, column) or ""
        for pair, (more, _) in study.tasks.pairs().items():
            cells["standing"][pair] = getattr(study.tasks.pools()[more], column) or ""
        if study.has("wristalyzer_pooled"):
            cells["wristalyzer"]["pooled"] = ""
        found[column] = cells
    return found


def members(study: Study) -> list[dict]:
    """Trials of participants, of a standing person those of a task together, as the library's `Member`."""
    found = []
    for (experiment, condition), row in study.trials.items():
        if row.participant is None or experiment == "standing":
            continue
        label = row.task or condition.removeprefix(f"{row.participant}-")
        found.append(
            {
                "experiment": experiment,
                "condition": condition,
                "participant": row.participant,
                "label": label,
                "is_task": row.task is not None,
                "trials": 1,
                "belt": (study.treadmill.belt_of(experiment, condition) or "") if study.by_belt else "",
            }
        )
    for pool in study.tasks.pools().values():
        if pool.participant is not None:
            found.append(
                {
                    "experiment": "standing",
                    "condition": pool.name,
                    "participant": pool.participant,
                    "label": pool.task,
                    "is_task": True,
                    "trials": len(pool.conditions),
                    "belt": pool.belt or "",
                }
            )
    return found


def masses_kg(study: Study) -> dict[str, dict[str, float | None]]:
    """Experiment -> participant -> body mass (kg); None where nobody gives it."""
    people, own = study.people or {}, study.config["standing"]["participants"]
    return {
        experiment: {
            name: (own.get(name, {}) | people.get(name, {})).get("mass_kg")
            for name in study.participants(experiment)
        }
        for experiment in study.experiments
        if EXPERIMENTS[experiment].of_people
    }


def shown_estimators(study: Study) -> dict[str, list[str]]:
    """Experiment with participants -> pathway and estimator that figure and report show."""
    standing, dummy = study.settings["standing"], study.settings["dummy"]
    shown = {
        "standing": [standing["recommended"]["pathway"], standing["recommended"]["estimator"]],
        "dummy": [dummy["quoted"], dummy["pathways"][dummy["quoted"]]["estimator"]],
        "position_manipulator": ["impedance", "parallel-cascade"],
        "platform": ["closed-loop", f"iv-{study.settings['platform']['analysis']['models'][0]}"],
    }
    return {name: choice for name, choice in shown.items() if study.participants(name)}
