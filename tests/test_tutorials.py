"""The tutorials run from the first cell to the last, and their outputs are what their sentences say."""

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SAID = {
    "first_result": [
        r"(I|B|K): .* inside\n(?s:.*)B: .* inside\n(?s:.*)K: .* inside",
        r"Angle and torque are probably exchanged",
        r"5 of 15500 missing",
    ],
    "vaf": [r"I: predicted change \+0\.0540, found \+0\.0540", r"K: predicted change -3\.5\d+, found -3\.5"],
    "human_ankle": [r"reflex_gain +[45]\.\d+", r"The reflex delay of [\d.]+ s is assumed"],
    "gallery": [r"Figure"],
    "treadmill_person": [
        r"fill in what my-person/MISSING.md lists",
        r"measured.yaml: 7 trials \(3 of weight, 2 of empty, 2 of standing\)",
        r"verdict: standing/relax: K will be quotable, ± [\d.]+ % expected",
        r"K +Nm/rad +\d\d\d\.\d+",
        r"expected a value for",
    ],
    "treadmill_forces": [
        r"# TEPSIPE_COMPENSATION",
        r"within the interval in 9[45]\.\d % of the samples",
        r"written: nothing\s+exit code 1",
    ],
    "plan": [r"responses for K \+-10 % \(95 %\): no number"],
}


@pytest.fixture(scope="module")
def runner():
    spec = importlib.util.spec_from_file_location("run_tutorials", ROOT / "docs/run_tutorials.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def printed(notebook):
    """All that the cells of a notebook print or show as text."""
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    return "\n".join(output.get("text") or output.get("data", {}).get("text/plain", "") for output in outputs)


@pytest.mark.tutorial
@pytest.mark.slow
@pytest.mark.parametrize("name", SAID)
def test_a_tutorial_runs_and_shows_what_it_says(name, runner):
    if name == "treadmill_person" and not (ROOT / "Snakefile").is_file():
        pytest.skip("a study needs the checkout")
    notebook = runner.execute(name)
    text = printed(notebook)
    for expected in SAID[name]:
        assert re.search(expected, text), f"{name} prints nothing like {expected}"
    assert "Traceback" not in text
    assert any(
        "image/png" in output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", ())
    )
    assert runner.is_current(name)


def test_every_tutorial_has_a_title_exercises_and_what_can_go_wrong(runner):
    assert set(runner.tutorials()) == set(SAID)
    for name in SAID:
        if name == "gallery":
            continue
        text = (runner.SOURCES / f"{name}.py").read_text(encoding="utf-8")
        assert text.startswith("# %% [markdown]\n# # "), name
        for heading in ("# ## What can go wrong", "# ## Exercises"):
            assert heading in text, f"{name} has no {heading}"


def test_a_changed_tutorial_is_not_current(runner, tmp_path, monkeypatch):
    (tmp_path / "a.py").write_text("# %% [markdown]\n# # A\n\n# %%\n1 + 1\n", encoding="utf-8")
    monkeypatch.setattr(runner, "SOURCES", tmp_path)
    monkeypatch.setattr(runner, "EXECUTED", tmp_path / "executed")
    assert not runner.is_current("a")
    runner.execute("a")
    assert runner.is_current("a")
    (tmp_path / "a.py").write_text("# %% [markdown]\n# # A\n\n# %%\n1 + 2\n", encoding="utf-8")
    assert not runner.is_current("a")
