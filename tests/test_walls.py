"""Who may import whom: packages as rooms, one direction, and what only some rooms may know."""

import ast
import subprocess
import sys
from collections import defaultdict
from functools import cache
from pathlib import Path

import pytest
from syntax import imports

from tepsipe.experiments.registry import EXPERIMENTS
from workflow.support.imported_files import reached_by

ROOT = Path(__file__).parents[1]
MODULES = sorted((ROOT / "tepsipe").rglob("*.py"))
# a room may import from lower floors only, and not from another room of its own floor
FLOORS = {
    "errors": 0,
    "flags": 0,
    "quantities": 0,
    "arguments": 1,
    "signals": 2,
    "io": 2,
    "statistics": 2,
    "mechanics": 3,
    "ingest": 3,
    "treadmill": 3,
    "identification": 4,
    "drawing": 4,
    "experiments": 5,
    "reporting": 6,
    "new_study": 6,
    "cli": 7,
}
ENGINES = {"pybullet", "mujoco"}


def name_of(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


NAMES = {name_of(path): path for path in MODULES}


@cache
def imported(path, at_import_only=False):
    """Full names that a module imports: modules of the library by their own name."""
    found = set()
    for node in imports(path, at_import_only):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        else:
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                found.add(full if full in NAMES else node.module)
    return found


def room(name):
    return [*name.split("."), ""][1]


@cache
def arrows(name):
    """Modules of the library that one of them imports."""
    return imported(NAMES[name]) & NAMES.keys()


def test_every_room_has_its_floor():
    rooms = {room(name) for name in NAMES} - {"", "virtual_lab"}
    assert rooms == set(FLOORS)
    assert len(set(FLOORS.values())) <= 8


@pytest.mark.parametrize("name", [n for n in NAMES if room(n) in FLOORS])
def test_a_module_imports_from_lower_floors_or_its_own_room(name):
    own = room(name)
    for other in map(room, arrows(name) - {"tepsipe"}):
        assert other == own or FLOORS[other] < FLOORS[own], f"{name} imports from {other}"


def test_no_circle():
    done = set()

    def visit(name, trail):
        assert name not in trail, " -> ".join([*trail[trail.index(name) :], name])
        if name not in done:
            for other in arrows(name) - {"tepsipe"}:
                visit(other, [*trail, name])
            done.add(name)

    for name in NAMES:
        visit(name, [])


# ---- the parts of an experiment ------------------------------------------------------------------

OBJECTS = ("tepsipe.experiments.experiment", "tepsipe.experiments.registry")
FOLDERS = {f"tepsipe.experiments.{known.folder}" for known in EXPERIMENTS.values()}
# what makes numbers, and what shows them
MAKING, SHOWING = ("ingest", "fit"), ("figures", "page")


def reached_from(name):
    """Modules that one of the library imports, itself or through others."""
    found, waiting = set(), [name]
    while waiting:
        new = arrows(waiting.pop()) - {"tepsipe"} - found
        found |= new
        waiting += new
    return found


def parts(*kinds):
    return [name for name in NAMES if name.rpartition(".")[0] in FOLDERS and part_of(name) in kinds]


def part_of(name):
    """Kind of a part: fit of fit_foot."""
    return name.rpartition(".")[2].partition("_")[0]


def test_what_an_experiment_declares_is_known_without_numpy_or_any_part():
    code = "import sys; from tepsipe.experiments.registry import EXPERIMENTS; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = done.stdout.split()
    assert not {"numpy", "scipy", "h5py", "pandas", "matplotlib"} & set(loaded)
    own = {name for name in loaded if name.partition(".")[0] == "tepsipe"}
    assert own == {"tepsipe", "tepsipe.experiments", *OBJECTS, *FOLDERS}


def test_a_configuration_is_read_without_the_analyses_that_it_sets():
    code = "import sys; import workflow.support.checked_study; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    loaded = set(done.stdout.split())
    packages = {f"scipy.{name}" for name in ("optimize", "signal", "interpolate", "linalg", "stats")}
    assert not loaded & ({"h5py", "pandas", "matplotlib", "ezc3d"} | packages)
    # options stand apart from the modules that fit, ingest and calibrate
    parts = {
        name for name in loaded & NAMES.keys() if is_named(name, "analysis", "fit", "record", "registry")
    }
    assert parts == set(OBJECTS[1:])


def test_only_the_object_of_an_experiment_knows_the_class_and_no_module_of_the_library_the_registry():
    for name in NAMES:
        knows = arrows(name) & set(OBJECTS)
        assert knows == (set(OBJECTS[:1]) if name in {*FOLDERS, OBJECTS[1]} else set()), name
        # whose modules are reached by name, never through the package
        named = {other for other in imported(NAMES[name]) if other in FOLDERS}
        assert not named, f"{name} imports from {named}"


def test_every_experiment_has_the_parts_that_its_object_promises():
    for name, known in EXPERIMENTS.items():
        promised = {"ingest"} if known.ingest_reads else set()
        promised |= {"fit"} if known.fitted else set()
        assert {known.module(part) for part in promised} <= NAMES.keys(), name


@pytest.mark.parametrize("name", parts(*MAKING))
def test_ingest_and_fit_reach_no_figure_no_page_and_no_laboratory(name):
    found = reached_from(name)
    assert not [other for other in found if room(other) in ("reporting", "drawing", "virtual_lab")]
    assert not found & set(parts(*SHOWING))


@pytest.mark.parametrize("name", parts("ingest"))
def test_ingest_reaches_no_analysis(name):
    found = reached_from(name) - {name}
    assert not [other for other in found if room(other) in ("identification", "mechanics", "treadmill")]
    assert not [other for other in found if other.startswith("tepsipe.experiments.")]


@pytest.mark.parametrize("package", ["signals", "mechanics", "identification"])
def test_what_takes_arrays_knows_neither_trials_nor_files(package):
    for name in NAMES:
        if room(name) == package:
            for other in imported(NAMES[name]):
                assert room(other) != "io", f"{name} imports {other}"
                assert other.split(".")[0] not in ("h5py", "ezc3d", "edfio", "pathlib", "csv"), name


def is_named(name, *leaves):
    return name.rpartition(".")[2] in leaves


def test_pandas_and_pyplot_are_imported_where_reports_are_made_or_when_a_result_is_shown():
    """Pandas in reporting, matplotlib in drawing, both in modules of figures."""
    for name, path in NAMES.items():
        for other in imported(path, at_import_only=True):
            home = {"pandas": "reporting", "matplotlib": "drawing"}.get(other.split(".")[0])
            allowed = home in (None, room(name)) or is_named(name, "figures")
            assert allowed, f"{name} imports {other} when it is imported"


def test_figures_and_pages_are_imported_by_no_other_module():
    """Scripts load them by name, so that an edit of a figure runs no fit and no table again."""
    shown = {name for name in NAMES if is_named(name, "figures", "page")}
    assert len(shown) > 15
    for name in NAMES:
        # tepsipe plan draws the plan that it prints
        allowed = {"tepsipe.experiments.planning.figures"} if name == "tepsipe.cli" else set()
        assert arrows(name) & shown <= allowed, name
    files = {NAMES[name].relative_to(ROOT).as_posix() for name in shown}
    for script in (ROOT / "workflow/scripts").glob("*.py"):
        reached = files.intersection(reached_by(script.relative_to(ROOT).as_posix(), str(ROOT)))
        assert not reached, f"{script} imports {reached}"


def test_scipys_packages_are_imported_when_they_are_used():
    """`import scipy`, then scipy.signal.lfilter: the package is loaded when it is first named."""
    for name, path in NAMES.items():
        for other in imported(path):
            assert not other.startswith("scipy."), f"{name} imports {other}"


def test_every_engine_is_imported_by_its_own_module_only():
    knowing = defaultdict(set)
    for name, path in NAMES.items():
        for other in imported(path):
            knowing[other.split(".")[0]].add(name)
    for engine in ENGINES:
        # one on each side of the wall between analysis and laboratory
        assert knowing[engine] == {
            f"tepsipe.mechanics.engines.{engine}",
            f"tepsipe.virtual_lab.chain_{engine}",
        }


def test_public_names_are_imported_late():
    assert imported(NAMES["tepsipe"]) == {"importlib", "typing"}
