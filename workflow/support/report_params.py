"""Facts of a study that its pages, its report and the comparison with the truth are given."""

from tepsipe.reporting.laboratory import INFERRED_CONSTANTS, MECHANISMS
from workflow.settings.complete import pick
from workflow.support.experiments import EXPERIMENTS, PARTS
from workflow.support.study import Study


def described(study: Study, experiment: str) -> dict[str, dict]:
    """Condition -> what a trial's page says of it: simulated or not, belt, role, task, participant."""
    made, found = study.made(experiment), {}
    for condition in study.conditions(experiment):
        row = study.trials[experiment, condition]
        found[condition] = {
            "made": condition in made,
            "belt": study.treadmill.belt_of(experiment, condition),
            "role": row.role,
            "task": row.task,
            "participant": row.participant,
        }
    return found


def printed(study: Study) -> dict[str, dict]:
    """Settings that the report prints, by experiment and part."""
    named = {e: EXPERIMENTS[e].printed for e in study.experiments}
    named |= {name: part.printed for name, part in PARTS.items() if study.has(name) and part.printed}
    return {name: pick(study.settings[name], *paths) for name, paths in named.items()}


def true(study: Study) -> list[str]:
    """Constants of the laboratory, as the truth for the estimates of simulated trials."""
    paths = [path for e, made in study.all_made().items() if made for path in EXPERIMENTS[e].true]
    return list(dict.fromkeys(paths))


def mechanisms(study: Study) -> list[str]:
    """Constants that say what the laboratory is like: mechanisms, what was inferred, and what was drawn."""
    made = [experiment for experiment, names in study.all_made().items() if names]
    if any(EXPERIMENTS[experiment].on_plate for experiment in made):
        made.append("treadmill")
    paths = [mechanism.key for mechanism in MECHANISMS if mechanism.section in made]
    if "dummy" in made:
        paths += [path for path in INFERRED_CONSTANTS if path.partition(".")[0] in made]
    return [*dict.fromkeys(paths), "drawn_numbers"] if made else []
