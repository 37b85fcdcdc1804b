"""Refusals of the library that the tests read: the whole run of tests fails where one is read by no test.

A refusal is read when a test, or the command that it calls, takes the text of an `InputError`. A bare
``pytest.raises(InputError)`` reads nothing. The traceback of the error names its ``raise`` and every call on
the way to it. These positions are appended to one file, which the processes of a run and their forks share.
"""

import ast
import contextlib
import os
import tempfile
from pathlib import Path

import pytest
from syntax import nodes

import tepsipe
from tepsipe.errors import InputError

LIBRARY = Path(tepsipe.__file__).parent
FILE = "TEPSIPE_TESTS_REFUSALS"
# functions whose name begins like this raise for their caller: each call of one is a refusal of its own
HELPERS = ("refuse_", "_refuse_")

# refusals that no test reads yet: this list may only become shorter
UNREAD = (
    # records that pass every other check and still determine nothing have not been found
    "experiments/planning/plan.py _of_windows 1",
    "identification/fits.py _fit_record 2",
    "identification/likelihood/likelihood.py _gauss_newton 1",
    "identification/likelihood/likelihood.py _step_and_errors 1",
    "identification/likelihood/likelihood.py _step_and_errors 2",
    "identification/likelihood/likelihood.py _sandwich 1",
    "identification/likelihood/likelihood.py _sandwich 2",
    "identification/regression/output_error.py _solve 1",
    "identification/regression/output_error.py _solve 3",
    "treadmill/black_box_models.py fit_discrete_output_error 1",
)
FAULTS = pytest.StashKey[list]()


def record(path):
    """Append the position of every refusal whose text is taken in this process to a file."""
    file, known, original = os.open(path, os.O_APPEND | os.O_WRONLY), set(), InputError.__str__

    def text(error):
        step = error.__traceback__
        while step is not None:
            position = f"{step.tb_frame.f_code.co_filename}:{step.tb_lineno}\n"
            if position not in known:
                known.add(position)
                os.write(file, position.encode())
            step = step.tb_next
        return original(error)

    InputError.__str__ = text


def begin(config):
    """Record the refusals of a process of this run; its first process makes the file."""
    if not hasattr(config, "workerinput"):
        file, os.environ[FILE] = tempfile.mkstemp(prefix="tepsipe-refusals-")
        os.close(file)
    record(os.environ[FILE])


def is_refusal(node):
    """Whether a statement raises an InputError, or whether an expression calls a helper that does."""
    if isinstance(node, ast.Raise):
        called = node.exc.func if isinstance(node.exc, ast.Call) else None
        name = getattr(called, "id", "")
        # a function, which returns the error
        return name == "InputError" or name.islower()
    if isinstance(node, ast.Call):
        name = getattr(node.func, "id", getattr(node.func, "attr", ""))
        return name == "_refuse" or name.startswith(HELPERS)
    return False


def refusals(path):
    """First and last line of the refusals of a module, with a name that other lines leave as it is.

    The name has the module, the function and the number of the refusal in this function.
    """
    functions = [node for node in nodes(path) if isinstance(node, ast.FunctionDef)]
    counts = {}
    for node in sorted(filter(is_refusal, nodes(path)), key=lambda node: (node.lineno, node.col_offset)):
        around = [f for f in functions if f.lineno <= node.lineno <= f.end_lineno]
        function = max(around, key=lambda f: f.lineno).name if around else ""
        counts[function] = counts.get(function, 0) + 1
        yield f"{path.relative_to(LIBRARY)} {function} {counts[function]}", node.lineno, node.end_lineno


def unread(positions):
    """Refusals of the library at none of some positions: their names, with their lines."""
    lines = {}
    for position in positions:
        path, _, line = position.rpartition(":")
        lines.setdefault(Path(path), set()).add(int(line))
    return {
        name: first
        for path in sorted(LIBRARY.rglob("*.py"))
        for name, first, last in refusals(path)
        if lines.get(path, set()).isdisjoint(range(first, last + 1))
    }


def faults(positions, known=UNREAD):
    """Sentences about the refusals of the library, where some positions are those that tests read."""
    found = unread(positions)
    for name in sorted(found.keys() - set(known)):
        yield f"tepsipe/{name}, line {found[name]}: no test reads this refusal: add a test, or delete it"


def is_whole(session):
    """Whether all tests were run, none was left out by choice, and all passed."""
    option = session.config.option
    chosen = (option.file_or_dir, option.keyword, option.markexpr, option.deselect, option.ignore)
    chosen += (option.ignore_glob, getattr(option, "lf", False), option.collectonly)
    return session.exitstatus == pytest.ExitCode.OK and not any(chosen)


def end(session):
    """Compare what the tests of all processes read with the library, after a whole run."""
    path = Path(os.environ.pop(FILE))
    if is_whole(session):
        session.config.stash[FAULTS] = list(faults(path.read_text(encoding="utf-8").splitlines()))
        if session.config.stash[FAULTS]:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED
    with contextlib.suppress(OSError):  # Windows keeps a file that is open
        path.unlink()
