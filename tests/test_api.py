"""Public names: documented, imported lightly, with examples that run."""

import doctest
import re
import subprocess
import sys

import pytest

import tepsipe


def test_every_public_name_is_there_and_documented():
    for name in tepsipe.__all__:
        assert getattr(tepsipe, name).__doc__, name
        assert re.search(rf"\b{name}\b", tepsipe.__doc__), f"help(tepsipe) does not list {name}"
    assert set(tepsipe.__all__) <= set(dir(tepsipe))


def test_name_that_is_not_public_is_answered_with_those_that_are():
    with pytest.raises(AttributeError, match="fit_impedance"):
        _ = tepsipe.fit_impedence


def in_a_fresh_process(code):
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_importing_the_library_imports_nothing_heavy_and_changes_nothing():
    code = (
        "import os, sys, warnings, numpy as np\n"
        "before = (np.geterr(), np.get_printoptions(), list(warnings.filters), dict(os.environ))\n"
        "from tepsipe import fit_impedance\n"
        "import tepsipe.identification.result\n"
        "after = (np.geterr(), np.get_printoptions(), list(warnings.filters), dict(os.environ))\n"
        "print(before == after)\n"
        "print(*[m for m in ('matplotlib', 'pandas', 'scipy.signal', 'scipy.optimize', 'scipy.stats', "
        "'h5py', 'pybullet') if m in sys.modules])"
    )
    assert in_a_fresh_process(code) == ["True"]


@pytest.mark.slow
def test_importing_every_module_sets_no_backend_and_no_style():
    code = (
        "import importlib, matplotlib, pathlib, tepsipe\n"
        "from matplotlib import rcParams\n"
        "before = dict(rcParams)\n"
        "root = pathlib.Path(tepsipe.__file__).parent\n"
        "for path in sorted(root.rglob('*.py')):\n"
        "    parts = path.relative_to(root.parent).with_suffix('').parts\n"
        "    if 'engines' in parts or parts[-1] in ('chain_mujoco', 'chain_pybullet'): continue\n"
        "    name = '.'.join(parts[:-1] if parts[-1] == '__init__' else parts)\n"
        "    importlib.import_module(name)\n"
        "after = dict(rcParams)\n"
        "print(*[key for key in before if before[key] != after[key] and key != 'backend'])"
    )
    assert in_a_fresh_process(code) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", tepsipe.__all__)
def test_examples_of_the_docstrings_run(name):
    """Every public name has an example, and prints what it shows."""
    found = doctest.DocTestFinder(recurse=False).find(getattr(tepsipe, name), name, globs={})
    examples = [test for test in found if test.examples]
    assert examples, f"{name} has no example"
    output = []
    runner = doctest.DocTestRunner(verbose=False)
    for test in examples:
        runner.run(test, out=output.append)
    assert runner.failures == 0, "".join(output)
