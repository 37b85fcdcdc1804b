"""Provenance of an archived study: a Workflow Run RO-Crate, with one action for every job.

Profile: Provenance Run Crate 0.5 (https://w3id.org/ro/wfrun/provenance/0.5), which contains Workflow Run
Crate and Process Run Crate. Jobs, their inputs, outputs and times are those that Snakemake has recorded.
Files that the bundle does not contain are named with their checksums.
"""

import hashlib
import json
import mimetypes
import platform
from base64 import urlsafe_b64decode
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import quote

import yaml

from tepsipe import __version__
from tepsipe.new_study.start import OWN, REQUIRED
from workflow.support.places import ROOT
from workflow.support.study import Study
from workflow.support.version import code_version

METADATA = "ro-crate-metadata.json"
JOBS = Path(".snakemake") / "metadata"  # where Snakemake records the job that made a file
CONTEXT = ["https://w3id.org/ro/crate/1.1/context", "https://w3id.org/ro/terms/workflow-run/context"]
CRATE = "https://w3id.org/ro/crate/1.1"
PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5": ("Process Run Crate", "0.5"),
    "https://w3id.org/ro/wfrun/workflow/0.5": ("Workflow Run Crate", "0.5"),
    "https://w3id.org/ro/wfrun/provenance/0.5": ("Provenance Run Crate", "0.5"),
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0": ("Workflow RO-Crate", "1.0"),
}
WORKFLOW = "code/Snakefile"
LANGUAGE, ENGINE = "https://w3id.org/workflowhub/workflow-ro-crate#snakemake", "https://snakemake.github.io"
TYPES = {".tsv": "text/tab-separated-values", ".yaml": "application/yaml", ".md": "text/markdown"}
TYPES |= {".smk": "text/x-python", ".sha256": "text/plain", "": "text/plain"}
UNSTATED = "No licence has been stated for this bundle."
COMPLETED = "http://schema.org/CompletedActionStatus"
BIOSCHEMAS = "https://bioschemas.org/profiles/ComputationalWorkflow/1.0-RELEASE"


@dataclass
class Crate:
    """What a bundle contains."""

    files: dict[str, Path | str]
    """Path in the bundle -> path here, or text."""
    recordings: dict[str, str]
    """Path of a recording here -> its place in the bundle, which may not contain it."""
    folders: dict[str, str]
    """Folder here -> its place in the bundle."""

    def place(self, path: str) -> str:
        """Place of a file of the study in the bundle, also of one that is not in it."""
        for folder, there in self.folders.items():
            if path.startswith(f"{folder}/"):
                return there + path.removeprefix(folder)
        return self.recordings.get(path, path)


@dataclass
class Job:
    """One job: its rule, the files that it read and made, and when it ran (s since 1970)."""

    rule: str
    log: str
    inputs: list[str]
    started: float
    ended: float
    outputs: list[str] = field(default_factory=list)


def recorded_files(study: Study) -> list[str]:
    """Recordings of all trials."""
    return sorted({path for row in study.trials.values() for path in row.files.values()})


def jobs_of(paths: Iterable[str]) -> list[Job]:
    """Jobs that made these files, in the order in which they ran."""
    found: dict[tuple[str, str], Job] = {}
    wanted = set(paths)
    for file in filter(Path.is_file, JOBS.rglob("*")):
        # long names are split into folders that begin with @
        name = "".join(part.lstrip("@") for part in file.relative_to(JOBS).parts)
        try:
            path = urlsafe_b64decode(name).decode()
        except ValueError:  # no record
            continue
        if path not in wanted:
            continue
        record = json.loads(file.read_text(encoding="utf-8"))
        times = record["starttime"], record["endtime"]
        # a job has a log of its own, and a record for each output; sources of the program are its version's
        key = record["rule"], next(iter(record["log"]), path)
        job = found.setdefault(key, Job(*key, sorted(wanted & {*record["input"]}), *times))
        job.outputs.append(path)
        job.started, job.ended = min(job.started, times[0]), max(job.ended, times[1])
    return sorted(found.values(), key=lambda job: (job.started, job.rule, job.log))


@cache
def digest(path: Path) -> str:
    """SHA-256 of a file."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def crate_of(
    study: Study, contents: Crate, jobs: list[Job], scripts: Mapping[str, str], **stated: str | None
) -> dict[str, Any]:
    """Metadata of the bundle.

    scripts: rule -> its script.
    stated: ``agent``, the person who ran the study, and ``licence`` of the bundle, if they are to be named.
    """
    for (experiment, condition), row in study.trials.items():
        trial = f"{study.config['pathvars']['results']}/trials/{experiment}/{condition}.h5"
        for job in jobs:
            if trial in job.outputs:  # a recording is a param of its job
                job.inputs += sorted(row.files.values())
    read = [*(path for job in jobs for path in (*job.inputs, *job.outputs)), *contents.recordings]
    absent = {contents.place(path): path for path in read if contents.place(path) not in contents.files}
    files = [_file(name, content) for name, content in sorted(contents.files.items())]
    files += [_absent(place, Path(path)) for place, path in sorted(absent.items())]
    people = [{"@id": "#agent", "@type": "Person", "name": stated["agent"]}] if stated["agent"] else []
    rules = list(dict.fromkeys(job.rule for job in jobs))
    actions = _actions(study, contents, jobs, rules, people)
    name = stated["licence"] or UNSTATED
    licence = {"@id": name if "://" in name else "#licence", "@type": "CreativeWork", "name": name}
    licence["description"] = "Licence of this bundle"
    _add_to(files, OWN, exampleOfWork=_id(f"{WORKFLOW}#configuration"))
    _add_to(files, "README.md", about=_id("./"))
    _add_to(
        files,
        WORKFLOW,
        **{"@type": ["File", "SoftwareSourceCode", "ComputationalWorkflow", "HowTo"]},
        name="Workflow of tepsipe",
        conformsTo=_id(BIOSCHEMAS),
        programmingLanguage=_id(LANGUAGE),
        version=_code_version(),
        input=[_id(f"{WORKFLOW}#configuration")],
        hasPart=[_id(f"#rule/{rule}") for rule in rules],
        step=[_id(f"{WORKFLOW}#{rule}") for rule in rules],
        softwareRequirements=_id(REQUIRED),
    )
    descriptor = {"@id": METADATA, "@type": "CreativeWork", "about": _id("./")}
    descriptor["conformsTo"] = [_id(CRATE), _id("https://w3id.org/workflowhub/workflow-ro-crate/1.0")]
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": _title(study),
        "description": _description(study),
        "datePublished": datetime.now(UTC).date().isoformat(),
        "license": _id(licence["@id"]),
        **({"author": _id(people[0]["@id"])} if people else {}),
        "conformsTo": [_id(profile) for profile in PROFILES],
        "mainEntity": _id(WORKFLOW),
        "hasPart": [_id(name) for name in sorted(contents.files)],
        "mentions": [_id(action["@id"]) for action in actions if action["@type"] != "ControlAction"],
    }
    software = [*_software(), *_steps(rules, scripts, contents)]
    return {
        "@context": CONTEXT,
        "@graph": [*map(_compact, (descriptor, root, licence, *people, *actions, *software, *files))],
    }


def _compact(entity: dict[str, Any]) -> dict[str, Any]:
    """The entity with single values instead of lists of one."""
    return {key: x[0] if isinstance(x, list) and len(x) == 1 else x for key, x in entity.items()}


def _steps(rules: list[str], scripts: Mapping[str, str], contents: Crate) -> list[dict[str, Any]]:
    """Rules, as tools of the workflow and as its steps, and the parameter of the workflow."""
    found: list[dict[str, Any]] = [
        {
            "@id": f"{WORKFLOW}#configuration",
            "@type": "FormalParameter",
            "name": "configuration",
            "additionalType": "File",
            "workExample": _id(OWN),
        }
    ]
    for position, rule in enumerate(rules, start=1):
        # rules of one experiment each share a script
        script = "code/" + scripts.get(rule, f"workflow/scripts/{rule.partition('_')[0]}.py")
        tool = {"@id": f"#rule/{rule}", "@type": "SoftwareSourceCode", "name": rule}
        tool |= {"version": __version__} | ({"hasPart": _id(script)} if script in contents.files else {})
        step = {"@id": f"{WORKFLOW}#{rule}", "@type": "HowToStep", "name": rule}
        found += [tool, step | {"position": str(position), "workExample": _id(tool["@id"])}]
    return found


def _actions(
    study: Study, contents: Crate, jobs: list[Job], rules: list[str], people: list[dict[str, Any]]
) -> list[dict[str, Any]]:
    """The run of the workflow, the run of Snakemake, and for each job itself and its start."""
    by = {"agent": _id(people[0]["@id"])} if people else {}

    def named(paths: Iterable[str]) -> list[dict[str, str]]:
        places = dict.fromkeys(map(contents.place, paths))
        return [_id(place if place in contents.files else f"#{place}") for place in places]

    actions, controls = [], []
    for number, job in enumerate(jobs, start=1):
        action: dict[str, Any] = {"@id": f"#job/{number}", "@type": "CreateAction"}
        action |= {"name": f"Job {number}: {job.rule}", "description": f"Run of the rule {job.rule}"}
        action |= {"instrument": _id(f"#rule/{job.rule}"), "actionStatus": COMPLETED}
        action |= {"startTime": _time(job.started), "endTime": _time(job.ended)} | by
        action |= {"object": named(job.inputs)} if job.inputs else {}
        actions.append(action | {"result": named(sorted(job.outputs))})
        control = {"@id": f"#start/{number}", "@type": "ControlAction", "name": f"Start of job {number}"}
        controls.append(control | {"instrument": _id(f"{WORKFLOW}#{job.rule}"), "object": _id(action["@id"])})
    times = {"startTime": _time(min(job.started for job in jobs))}
    times["endTime"] = _time(max(job.ended for job in jobs))
    settings = sorted(n for n in contents.files if "/" not in n and n.endswith((".yaml", ".tsv")))
    run: dict[str, Any] = {"@id": "#run", "@type": "CreateAction", "name": f"Run of {_title(study)}"}
    run |= {"description": f"{len(jobs)} jobs of {len(rules)} rules", "instrument": _id(WORKFLOW)}
    run |= {"object": [*map(_id, settings), *named(sorted(contents.recordings))], "actionStatus": COMPLETED}
    run |= {"result": [_id(n) for n in sorted(contents.files) if n.startswith("results/")]} | times | by
    whole: dict[str, Any] = {"@id": "#snakemake", "@type": "OrganizeAction", "name": "Run of Snakemake"}
    whole |= {"instrument": _id(ENGINE), "object": [_id(control["@id"]) for control in controls]}
    return [run, whole | {"result": _id("#run")} | times | by, *actions, *controls]


def _id(name: str) -> dict[str, str]:
    """A reference; a space or another sign of a file's name as an address has it."""
    return {"@id": quote(name, safe="/#:")}


def _title(study: Study) -> str:
    return study.config["study"]["title"] or study.config["study"]["name"]


def _description(study: Study) -> str:
    source = study.config["study"]["recordings_source"]
    trials = f"A study by tepsipe {__version__} with {len(study.trials)} trials"
    return f"{trials}. Recordings: {source}" if source and recorded_files(study) else f"{trials}."


def _software() -> list[dict[str, Any]]:
    """Profiles, the language of the workflow, and the programs that ran it."""
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    found: list[dict[str, Any]] = [
        {"@id": profile, "@type": "CreativeWork", "name": name, "version": number}
        for profile, (name, number) in PROFILES.items()
    ]
    found.append({"@id": LANGUAGE, "@type": "ComputerLanguage", "name": "Snakemake", "url": {"@id": ENGINE}})
    found[-1] |= {"identifier": {"@id": ENGINE}}
    programs = {ENGINE: ("Snakemake", version("snakemake"))}
    programs["https://www.python.org"] = ("Python", platform.python_version())
    for address, (name, number) in programs.items():
        found.append({"@id": address, "@type": "SoftwareApplication", "name": name, "url": address})
        found[-1]["softwareVersion"] = number
    found.append({"@id": "#tepsipe", "@type": "SoftwareSourceCode", "name": cited["title"]})
    found[-1] |= {"version": _code_version(), "license": f"https://spdx.org/licenses/{cited['license']}"}
    return found


def _code_version() -> str:
    """Version and commit."""
    code = code_version(ROOT)
    commit = f" (commit {code['commit']}{', modified' * bool(code['modified'])})" if code["commit"] else ""
    return f"{__version__}{commit}"


def _file(name: str, content: Path | str) -> dict[str, Any]:
    """A file of the bundle."""
    kind = TYPES.get(Path(name).suffix) or mimetypes.guess_type(name)[0] or "application/octet-stream"
    entity = {**_id(name), "@type": "File", "name": name, "encodingFormat": kind}
    if isinstance(content, str):
        data = content.encode()
        return entity | {"contentSize": str(len(data)), "sha256": hashlib.sha256(data).hexdigest()}
    return entity | {"contentSize": str(content.stat().st_size), "sha256": digest(content)}


def _absent(place: str, path: Path) -> dict[str, Any]:
    """A file that a job read or made, and that is not in the bundle."""
    entity = {**_id(f"#{place}"), "@type": "CreativeWork", "name": place}
    entity["description"] = "A file of the run that the bundle does not contain"
    return entity | ({"sha256": digest(path)} if path.is_file() else {})


def _add_to(entities: list[dict[str, Any]], path: str, **properties: Any) -> None:
    next(entity for entity in entities if entity["@id"] == path).update(properties)


def _time(seconds: float) -> str:
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="milliseconds")
