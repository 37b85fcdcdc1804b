"""Pages on recordings: the example at the head of each is complete, and fits the configuration."""

import re
import textwrap
from pathlib import Path

import h5py
import numpy as np
import pytest
import yaml

from tepsipe.cli import _parser
from tepsipe.experiments.registry import EXPERIMENTS
from workflow.settings.config import check_config
from workflow.support.checked_study import merged_settings

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs/recordings").glob("*.md"))
WITH_EXAMPLE = [p for p in PAGES if "## Example\n" in p.read_text(encoding="utf-8")]


def example(page):
    """Commands of a page's example."""
    return re.search(
        r"```\n(.*?)```", page.read_text(encoding="utf-8").partition("## Example\n")[2], re.DOTALL
    )[1]


def test_every_instrument_has_an_example():
    assert {p.stem for p in WITH_EXAMPLE} >= {
        "belt",
        "plate-treadmill",
        "position-manipulator",
        "standing",
        "weight-and-empty",
        "wristalyzer",
    }


@pytest.mark.parametrize("page", WITH_EXAMPLE, ids=lambda p: p.stem)
def test_commands_of_an_example_fit_together(page):
    """Folders that are named later are written before, raw files are those of the laboratory."""
    text = example(page)
    commands = [line.split() for line in text.splitlines() if line.startswith("tepsipe ")]
    chosen = [_parser().parse_args(words[1:]) for words in commands]
    (study,) = [c for c in chosen if c.command.__name__ == "_new_study"]
    written = str(study.output or study.name)
    assert f"cd {written} && tepsipe run" in text
    for name in re.findall(r"results/raw/(\w+)/", text):
        assert name in EXPERIMENTS
    if "measured.yaml" in text:
        assert f"> {written}/measured.yaml" in text
        assert f"cd {written} && tepsipe run --configfile config.yaml measured.yaml" in text


@pytest.mark.parametrize("page", [p for p in WITH_EXAMPLE if "<<'END'\n" in example(p)], ids=lambda p: p.stem)
def test_settings_of_an_example_are_accepted(page, tmp_path):
    body = example(page).partition("<<'END'\n")[2].partition("\nEND")[0]
    if "import numpy" in body:
        compile(body, page.name, "exec")
        return
    (tmp_path / "measured.yaml").write_text(body + "\n")
    config = merged_settings([ROOT / "config/config.yaml", tmp_path / "measured.yaml"])
    check_config(config, page.name)


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_every_block_of_settings_is_accepted(page):
    """Each with those before it on the page, which belong to the same study."""
    config = merged_settings([ROOT / "config/config.yaml"])
    for block in re.findall(
        r"^( *)```yaml\n(.*?)^ *```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    ):
        override(config, yaml.safe_load(textwrap.dedent(block[1])))
        check_config(config, page.name)


def override(config, changes):
    for key, value in changes.items():
        if isinstance(value, dict) and isinstance(config.get(key), dict):
            override(config[key], value)
        else:
            config[key] = value


@pytest.mark.study
def test_the_snippet_on_treadmill_models_returns_the_loads_of_the_study(study, monkeypatch):
    text = (ROOT / "docs/recordings/weight-and-empty.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    monkeypatch.chdir(study)
    found = {}
    exec(compile(code, "weight-and-empty.md", "exec"), found)
    with h5py.File("results/fits/foot/sine-0.5.h5") as file:
        for load, corrected in found["loads"].items():
            own = file[f"loads/{load}/best-frame"][()]
            assert np.abs(corrected - own).max() < 1e-4 * np.std(own)  # stored in single precision
            assert 0.0 < np.median(found["uncertainty"][load]) < np.std(own)
