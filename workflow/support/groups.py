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


def asked(study: Study) -> dict[str, dict[str, list]]:
    """Experiment -> ``conditions``, trials or tasks with answers, and ``ways``, pathways and estimators.

    The first way is that of the tables of participants.
    """
    standing, dummy = study.settings["standing"], study.settings["dummy"]
    pathways = dict.fromkeys([dummy["quoted"], dummy["recommended"]])
    models = study.settings["platform"]["analysis"]["models"]
    ways = {
        "wristalyzer": [["admittance", name] for name in ("spectral-fit-periods", "spectral-fit")],
        "dummy": [[name, dummy["pathways"][name]["estimator"]] for name in pathways],
        "weight": [["force", "least-squares"]],
        "standing": [[standing["recommended"]["pathway"], standing["recommended"]["estimator"]]],
        "position_manipulator": [["impedance", "parallel-cascade"]],
        "platform": [["closed-loop", f"iv-{model}"] for model in models],
    }
    conditions = {name: study.conditions(name) for name in study.experiments}
    if "standing" in conditions:
        conditions["standing"] = [*study.tasks.names(), *study.tasks.pairs()]
    if study.has("wristalyzer_pooled"):
        conditions["wristalyzer"] = [*conditions["wristalyzer"], "pooled"]
    return {
        name: {"conditions": own, "ways": ways.get(name, [])}
        for name, own in conditions.items()
        if EXPERIMENTS[name].fitted
    }


def shown_estimators(study: Study) -> dict[str, list[str]]:
    """Experiment with participants -> pathway and estimator that figure and report show."""
    return {name: own["ways"][0] for name, own in asked(study).items() if study.participants(name)}
