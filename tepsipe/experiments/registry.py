"""Registry of the experiments.

No experiment and no job of one imports this module, so that a further experiment runs no job again.
"""

from importlib import import_module

from tepsipe.experiments.experiment import Experiment

# folder -> names of its objects, in the order in which messages and reports list the experiments
OBJECTS = {
    "wristalyzer": ("EXPERIMENT",),
    "dummy": ("EXPERIMENT",),
    "weight": ("WEIGHT", "EMPTY"),
    "standing": ("EXPERIMENT",),
    "belt": ("EXPERIMENT",),
    "position_manipulator": ("EXPERIMENT",),
    "platform": ("EXPERIMENT",),
    "walking": ("EXPERIMENT",),
}


def _all() -> dict[str, Experiment]:
    known = {}
    for folder, names in OBJECTS.items():
        module = import_module(f"tepsipe.experiments.{folder}")
        for name in names:
            experiment = getattr(module, name)
            known[experiment.name] = experiment
    return known


EXPERIMENTS = _all()
