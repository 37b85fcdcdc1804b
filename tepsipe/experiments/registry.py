"""Registry of the experiments.

No experiment and no job of one imports this module, so that a further experiment runs no job again.
"""

from importlib import import_module
from pathlib import Path

from tepsipe.experiments.experiment import Experiment

# folders in the order in which messages and reports list their experiments; further ones follow
FIRST = ("wristalyzer", "dummy", "weight", "standing", "belt", "position_manipulator", "platform", "walking")


def _all() -> dict[str, Experiment]:
    """Name -> experiment, of every folder with an ingest, and of those that have none."""
    found = sorted(path.parent.name for path in Path(__file__).parent.glob("*/ingest.py"))
    modules = [import_module(f"tepsipe.experiments.{name}") for name in dict.fromkeys((*FIRST, *found))]
    declared = [known for module in modules for known in vars(module).values()]
    return {known.name: known for known in declared if isinstance(known, Experiment)}


EXPERIMENTS = _all()
