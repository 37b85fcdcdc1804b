"""What describes the release agrees: version, authors, keywords, addresses and metadata of archives."""

import json
import os
import re
import runpy
import shutil
import subprocess
import tomllib
from pathlib import Path

import pandas as pd
import pytest
import yaml

import tepsipe

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def cited():
    return yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def project():
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_one_version(cited):
    newest = re.search(
        r"^## \[(\d+\.\d+\.\d+)\]", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE
    )
    assert tepsipe.__version__ == cited["version"] == newest.group(1)


def test_one_list_of_authors_keywords_and_one_licence(cited, project):
    names = [
        author.get("name") or f"{author['given-names']} {author['family-names']}"
        for author in cited["authors"]
    ]
    assert [author["name"] for author in project["authors"]] == names
    assert project["keywords"] == cited["keywords"]
    assert project["license"] == cited["license"]


def test_metadata_of_archives_are_those_of_the_citation():
    made = runpy.run_path(str(ROOT / "docs/archive_metadata.py"))["texts"]()
    assert set(made) == {"codemeta.json", ".zenodo.json", "docs/citing.md"}
    for name, text in made.items():
        assert (ROOT / name).read_text(encoding="utf-8") == text, (
            f"run python docs/archive_metadata.py: {name}"
        )


def test_no_address_is_a_placeholder():
    """Whoever publishes the project adds them to pyproject.toml, and runs docs/archive_metadata.py."""
    suffixes = {".md", ".py", ".toml", ".yaml", ".yml", ".cff", ".json", ".typ"}
    hidden = {".venv", ".git", ".snakemake", "results", "build", "site"}
    found = []
    for folder, below, names in os.walk(ROOT):
        below[:] = set(below) - hidden  # the environment has thousands of folders
        for path in (Path(folder) / name for name in names if Path(name).suffix in suffixes):
            text = path.read_text(encoding="utf-8", errors="ignore")
            if re.search(r"https?://[\w.-]+\.invalid\b", text):
                found.append(path.relative_to(ROOT).as_posix())
    assert found == []


def test_published_addresses_reach_the_metadata(project, monkeypatch):
    made = runpy.run_path(str(ROOT / "docs/archive_metadata.py"))
    urls = {"Repository": "https://a.org/b", "Issues": "https://a.org/b/issues"}
    monkeypatch.setitem(made["codemeta"].__globals__, "project", lambda: project | {"urls": urls})
    content = made["codemeta"]()
    assert (content["codeRepository"], content["issueTracker"]) == (urls["Repository"], urls["Issues"])
    assert content["readme"] == "README.md"


def test_workflows_name_what_is_supported(project):
    versions = {line.rpartition(" ")[2] for line in project["classifiers"] if re.search(r":: 3\.\d+$", line)}
    tests = yaml.safe_load((ROOT / ".github/workflows/tests.yml").read_text(encoding="utf-8"))
    assert set(tests["jobs"]["library"]["strategy"]["matrix"]["python"]) == versions
    lowest, beyond = re.fullmatch(r">=3\.(\d+),<3\.(\d+)", project["requires-python"]).groups()
    assert versions == {f"3.{minor}" for minor in range(int(lowest), int(beyond))}


@pytest.mark.parametrize("name", ["tests", "checks", "newest"])
def test_commands_of_workflows_are_those_of_the_project(name):
    """Each target of make and each script that a workflow calls exists."""
    content = yaml.safe_load((ROOT / f".github/workflows/{name}.yml").read_text(encoding="utf-8"))
    steps = [step["run"] for job in content["jobs"].values() for step in job["steps"] if "run" in step]
    targets = re.findall(r"^([a-z][\w-]*):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert steps
    for step in steps:
        for target in re.findall(r"\bmake ([\w-]+)", step):
            assert target in targets
        for script in re.findall(r"python ([\w/]+\.py)", step):
            assert (ROOT / script).is_file()


def test_container_has_all_files_that_rules_name():
    recipe = (ROOT / "Containerfile").read_text(encoding="utf-8")
    copied = {name for line in re.findall(r"^COPY (.+) \S+$", recipe, re.MULTILINE) for name in line.split()}
    rules = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "workflow").rglob("*.smk"))
    named = re.findall(r'(?:here\(|CHECKOUT / |CHECKOUT\.glob\()"([^"]+)"', rules)
    assert {"CITATION.cff", "docs/decisions/0*.md"} <= set(named)
    missing = [name for name in named if name != "." and not copied & {name, *map(str, Path(name).parents)}]
    assert missing == []


@pytest.mark.skipif(shutil.which("sh") is None, reason="no shell")
@pytest.mark.parametrize("has_pybullet", [True, False])
def test_container_runs_also_where_pybullet_is_not_installed(has_pybullet, tmp_path):
    recipe = (ROOT / "Containerfile").read_text(encoding="utf-8")
    entry = json.loads(re.search(r"^ENTRYPOINT (.+)$", recipe, re.MULTILINE)[1])
    python = tmp_path / "python"
    status = 0 if has_pybullet else 1
    python.write_text(f'#!/bin/sh\nif [ "$1" = -c ]; then exit {status}; fi\nprintf "%s\\n" "$@"\n')
    python.chmod(0o755)
    own = ["--configfile", "my study/config.yaml"]
    path = f"{tmp_path}:{os.environ['PATH']}"
    run = subprocess.run([*entry, *own], env={"PATH": path}, capture_output=True, text=True, check=True)
    other_engine = [] if has_pybullet else ["--configfile", "config/any-engine.yaml"]
    assert run.stdout.splitlines() == ["-m", "workflow.run", "-c2", *other_engine, *own]
    assert (ROOT / "config/any-engine.yaml").is_file()


def test_paper_quotes_the_numbers_of_the_example():
    paper = " ".join((ROOT / "paper/paper.md").read_text(encoding="utf-8").split())
    drawn = runpy.run_path(str(ROOT / "docs/draw_rig.py"))
    (_, inertia, stiffness, vaf), (_, wrong_inertia, wrong_stiffness, wrong_vaf) = drawn["results"]()
    assert (
        f"inertia of {wrong_inertia:.3f} instead of {inertia:.3f} N·m·s²/rad and a stiffness of "
        f"{wrong_stiffness:.1f} instead of {stiffness:.0f} N·m/rad, with a VAF of {wrong_vaf:.2f} %. The "
        f"correct equation reaches {vaf:.2f} %"
    ) in paper


def test_pages_quote_the_coverage_of_the_stored_campaign():
    rows = pd.read_csv(ROOT / "benchmarks/coverage/coverage.csv")
    rows = rows[(rows.mechanism == "nominal") & rows.recommended]
    rows = rows[rows.window_s.isna() | (rows.window_s == rows.window_s.max())]
    # a quantity that few laboratories quote from another estimator counts by the usual one
    rows = rows.loc[rows.groupby(["experiment", "quantity"]).laboratories.idxmax()]
    shares = [round(100.0 * share) for share in rows.coverage]
    quoted = []
    for page in ("paper/paper.md", "docs/thesis.md", "docs/coverage.md"):
        text = " ".join((ROOT / page).read_text(encoding="utf-8").split())
        quoted += re.findall(r"(\d+) to (\d+) % of the (?:95 % )?intervals", text)
    assert len(quoted) == 3
    assert set(quoted) == {(str(min(shares)), str(max(shares)))}


def test_paper_is_short_and_cites_what_its_bibliography_has():
    text = (ROOT / "paper/paper.md").read_text(encoding="utf-8")
    _, front, body = text.split("---\n", 2)
    assert set(yaml.safe_load(front)) >= {"title", "tags", "authors", "affiliations", "date", "bibliography"}
    assert len(body.split()) <= 1000
    entries = re.findall(
        r"^@\w+\{([\w-]+),", (ROOT / "paper/paper.bib").read_text(encoding="utf-8"), re.MULTILINE
    )
    assert set(re.findall(r"@([a-z]+)", body)) == set(entries)
