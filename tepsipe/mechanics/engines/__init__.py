"""Engines of the forward simulation of the dummy, one module each, imported when the engine is used.

An engine is a function that takes a `Task` and returns a `Swing` for each of its joints (`interface.py`). A
new one is a module with such a function `simulate` and an entry in `ENGINES`; the test that compares all
engines includes it.
"""

import importlib.metadata
import importlib.util
from collections.abc import Callable
from typing import TYPE_CHECKING

from tepsipe.errors import InputError

if TYPE_CHECKING:  # numpy is imported late: looking up a name does not need it
    from tepsipe.mechanics.engines.interface import Swing, Task

AUTO = "auto"


def _pybullet() -> "Callable[[Task], list[Swing]]":
    from tepsipe.mechanics.engines.pybullet import simulate

    return simulate


def _mujoco() -> "Callable[[Task], list[Swing]]":
    from tepsipe.mechanics.engines.mujoco import simulate

    return simulate


def _equations() -> "Callable[[Task], list[Swing]]":
    from tepsipe.mechanics.engines.equations import simulate

    return simulate


# in the order in which "auto" tries them
ENGINES = {"pybullet": _pybullet, "mujoco": _mujoco, "equations": _equations}
# package to install, and how; the equations need none
INSTALLED_BY = {
    "pybullet": "pip install 'tepsipe[pybullet]' (it has wheels for CPython 3.11 on Linux x86-64 only)",
    "mujoco": "pip install 'tepsipe[mujoco]'",
}


def installed_engines() -> list[str]:
    """Names of the installed engines, in the order in which "auto" takes them."""
    return [name for name in ENGINES if name not in INSTALLED_BY or importlib.util.find_spec(name)]


def resolved_engine(engine: str) -> str:
    """Name of the engine that a setting selects, without importing it.

    engine: {"pybullet", "mujoco", "equations", "auto"}: "auto" takes the first of the others that is
    installed.
    Returns: "pybullet", "mujoco" or "equations".
    """
    usable = installed_engines()
    if engine == AUTO:
        return usable[0]
    if engine not in ENGINES:
        raise InputError(
            f"engine: expected one of {', '.join(ENGINES)} or {AUTO}, found {engine!r}: correct it"
        )
    if engine not in usable:
        raise InputError(
            f"engine: expected one that is installed ({', '.join(usable)}), found {engine!r}: install it "
            f"with {INSTALLED_BY[engine]}, or choose {AUTO!r}"
        )
    return engine


def engine_version(engine: str) -> str:
    """Version of an engine; for the equations, the version of tepsipe."""
    name = resolved_engine(engine)
    return importlib.metadata.version(name if name in INSTALLED_BY else "tepsipe")


def simulate(engine: str, task: "Task") -> "list[Swing]":
    """Simulate the dummy with every joint of a task by an engine.

    engine: {"pybullet", "mujoco", "equations", "auto"}: Name of the engine; "auto" takes the first that is
    installed.
    task: dummy, joints, belt and clock.
    Returns: for every joint, motion and forces at the recorded instants (rad, N, N·m).
    """
    name = resolved_engine(engine)
    try:
        run = ENGINES[name]()
    except ImportError as error:
        raise InputError(
            f"engine: expected {name} to be usable, found that it cannot be loaded ({error}): install it "
            f"again, or choose another engine"
        ) from None
    return run(task)
