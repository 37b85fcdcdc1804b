"""Facts of a study that its pages, its report and the table of the laboratory are given."""

from tepsipe.experiments.registry import EXPERIMENTS
from tepsipe.reporting.laboratory import INFERRED_CONSTANTS, MECHANISMS, TRUE_CONSTANTS
from workflow.settings.complete import pick
from workflow.support.parts import PARTS
from workflow.support.study import Study


def described(study: Study, experiment: str, condition: str) -> dict:
    """What a trial's page says of it: simulated or not, belt, role, task, participant."""
    row = study.trials[experiment, condition]
    return {
        "condition": condition,
        "made": condition in study.simulated(experiment),
        "belt": study.treadmill.belt_of(experiment, condition),
        "role": row.role,
        "task": row.task,
        "participant": row.participant,
    }


def neighbours(study: Study, experiment: str, condition: str) -> dict[str, str]:
    """The trials before and after one of an experiment, in the order of the trial sheet."""
    names = study.conditions(experiment)
    k = names.index(condition)
    found = {"Previous": names[k - 1 : k], "Next": names[k + 1 : k + 2]}
    return {words: own[0] for words, own in found.items() if own}


def printed(study: Study) -> dict[str, dict]:
    """Settings that the report prints, by experiment and part."""
    named = {e: EXPERIMENTS[e].printed for e in study.experiments}
    named |= {name: part.printed for name, part in PARTS.items() if study.has(name) and part.printed}
    return {name: pick(study.settings[name], *paths) for name, paths in named.items()}


def sections(study: Study) -> list[str]:
    """Experiments with simulated trials, and the treadmill if one of them is on it."""
    made = [experiment for experiment, names in study.all_simulated().items() if names]
    on_plate = any(EXPERIMENTS[experiment].on_plate for experiment in made)
    return [*made, "treadmill"] if on_plate else made


def mechanisms(study: Study) -> list[str]:
    """Constants that say what the laboratory is like: mechanisms, what was inferred, and what was drawn."""
    made = sections(study)
    paths = [mechanism.key for mechanism in MECHANISMS if mechanism.section in made]
    paths += TRUE_CONSTANTS if "treadmill" in made else ()
    if "dummy" in made:
        paths += [path for path in INFERRED_CONSTANTS if path.partition(".")[0] in made]
    return [*dict.fromkeys(paths), "drawn_numbers"] if made else []
