"""Archive a study: ``python -m workflow.archive [CONFIG...]``, started by ``tepsipe archive``.

The bundle is a folder in which ``tepsipe run`` makes the study again, and a Workflow Run RO-Crate
(`workflow/support/run_crate.py`), in a zip file.
"""

import argparse
import json
import os
import re
import sys
import zipfile
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

import yaml
from packaging.requirements import Requirement

from tepsipe import __version__
from tepsipe.errors import InputError, quoted
from tepsipe.new_study.start import OWN, REQUIRED
from workflow.support import job_outputs
from workflow.support.checked_study import checked_study, merged_settings, shipped, with_its_file
from workflow.support.folders import INPUTS
from workflow.support.origins import Sources
from workflow.support.places import ROOT
from workflow.support.run_crate import JOBS, METADATA, Crate, Job, crate_of, digest, jobs_of, recorded_files
from workflow.support.study import Study
from workflow.support.version import code_version
from workflow.support.yaml_file import base_of, read_constants

# of the results: what is read and quoted. Signals and fits, which are large, are made again by a run
RESULTS = ("tables", "report", "figures", "treadmill_models", "checks", "provenance.json", "config.yaml")
CODE = ("Snakefile", "workflow/rules/*.smk", "workflow/studies/*.smk", "workflow/scripts/*.py")
RECORDINGS = "recordings"
NAMES = {
    "trial_sheet": "trials.tsv",
    "virtual_lab": "virtual_lab.yaml",
    "reported": "reported.yaml",
    "participants": "participants.tsv",
}
assert NAMES.keys() == INPUTS.keys()


def main(arguments: list[str]) -> int:
    """Write the bundle; 2 if the study cannot be archived."""
    parser = argparse.ArgumentParser(allow_abbrev=False)
    parser.add_argument("files", nargs="*")
    parser.add_argument("--output")
    parser.add_argument("--agent")
    parser.add_argument("--licence")
    parser.add_argument("--with-recordings", action="store_true")
    chosen = parser.parse_args(arguments)
    configfiles, config = [shipped(), *chosen.files], {}
    try:
        config = merged_settings(configfiles)
        study = checked_study(config, configfiles)
        output = _output(chosen.output or f"{config['study']['name']}.zip")
        made = _made_by(config, chosen.files)
        contents = bundle(study, chosen.files, chosen.with_recordings)
        scripts = {rule.name: rule.script for rule in Sources(ROOT, study.kind).rules}
        jobs = jobs_of(made)
        _refuse_unknown(made, jobs)
        crate = crate_of(study, contents, jobs, scripts, agent=chosen.agent, licence=chosen.licence)
        write(contents.files | {METADATA: json.dumps(crate, indent=1, ensure_ascii=False)}, output)
    except InputError as error:
        print(f"tepsipe: {with_its_file(error, config, configfiles)}", file=sys.stderr)
        return 2
    without = bool(contents.recordings) and not chosen.with_recordings
    print(f"{len(contents.files) + 1} files{', without the recordings' * without}\nwritten: {output}")
    return 0


def _output(name: str) -> Path:
    path = Path(name)
    if path.exists() or not path.parent.is_dir():
        found = "a file" if path.exists() else "no folder for it"
        raise InputError(
            f"{path}: expected the name of a new file in a folder that exists, found {found}: choose another "
            "--output"
        )
    return path


def _made_by(config: dict, files: list[str]) -> list[str]:
    """All files that the run has made; edited ones and an unfinished run are refused."""
    job_outputs.refuse_edited(job_outputs.changes(config["pathvars"]["logs"]))
    # that of the study, as tepsipe run takes it
    snakefile = "Snakefile" if Path("Snakefile").is_file() else str(ROOT / "Snakefile")
    planned = job_outputs.planned(["--snakefile", snakefile, *(["--configfile", *files] if files else [])])
    pending = [path for path, is_pending in planned.items() if is_pending]
    if pending:
        raise InputError(
            f"{pending[0]}: expected the results of a finished study, found {len(pending)} that are missing "
            "or out of date: finish it with tepsipe run"
        )
    return list(planned)


def _refuse_unknown(made: list[str], jobs: list[Job]) -> None:
    """Refuse results of which Snakemake has no record, as where its folder was not copied with them."""
    unknown = sorted({*made} - {path for job in jobs for path in job.outputs})
    if unknown:
        raise InputError(
            f"{unknown[0]}: expected a record of the job that made it in {JOBS}, found none for "
            f"{len(unknown)} results: make them again with tepsipe run --forceall"
        )


def bundle(study: Study, files: list[str], with_recordings: bool) -> Crate:
    """Files of the bundle: path in it -> path here, or text."""
    config = json.loads(json.dumps(study.config))
    results = config["pathvars"]["results"]
    found: dict[str, Path | str] = {}
    for key, name in NAMES.items():
        path = config["study"][key]
        if path is None:
            continue
        # constants with those of their base, whose path is not that of the bundle
        merged = key == "virtual_lab" and base_of(path) is not None
        found[name] = yaml.safe_dump(read_constants(path), sort_keys=False) if merged else Path(path)
        config["study"][key] = name
    recordings = {path: place_of_recording(path, study) for path in recorded_files(study)}
    config["study"]["recordings_folder"] = RECORDINGS if recordings else "."
    config["study"]["outside"] = False
    config["pathvars"] |= {"results": "results", "logs": "results/logs"}
    found[OWN] = "# All settings of the run: the shipped ones and those of the study.\n" + yaml.safe_dump(
        config, sort_keys=False
    )
    # with their comments
    found |= {f"settings/{Path(path).name}": Path(path) for path in files}
    found[REQUIRED] = requirements()
    for pattern in CODE:
        found |= {f"code/{p.relative_to(ROOT).as_posix()}": p for p in sorted(ROOT.glob(pattern))}
    for name in RESULTS:
        place = Path(results, name)
        paths = [place] if place.is_file() else sorted(p for p in place.rglob("*") if p.is_file())
        found |= {f"results/{path.relative_to(results).as_posix()}": path for path in paths}
    if recordings:
        lines = [f"{digest(Path(path))}  {place}\n" for path, place in sorted(recordings.items())]
        found["recordings.sha256"] = "".join(lines)
    if with_recordings:
        found |= {place: Path(path) for path, place in recordings.items()}
    found["README.md"] = _readme(study, bool(recordings), with_recordings)
    return Crate(found, recordings, {results: "results"})


def place_of_recording(path: str, study: Study) -> str:
    """Place of a recording in the bundle."""
    folder = study.config["study"]["recordings_folder"]
    place = Path(os.path.relpath(path, folder)).as_posix()
    if place.startswith("../"):
        raise InputError(
            f"{study.config['study']['trial_sheet']}: expected recordings in study.recordings_folder "
            f"({quoted(folder)}), which the bundle repeats, found {quoted(path)}: name one that holds all"
        )
    return f"{RECORDINGS}/{place}"


def requirements() -> str:
    """Version of tepsipe, and those of all packages that its studies need, as pip reads them."""
    found: dict[str, str] = {}
    waiting = [("tepsipe", ("study",))]
    while waiting:
        name, extras = waiting.pop()
        for line in requires(name) or ():
            needed = Requirement(line)
            wanted = needed.marker is None or any(
                needed.marker.evaluate({"extra": extra}) for extra in extras or ("",)
            )
            key = re.sub(r"[-_.]+", "-", needed.name).lower()
            if wanted and key not in found and key != "tepsipe":
                try:
                    found[key] = version(key)
                except PackageNotFoundError:  # not needed on this system
                    continue
                waiting.append((key, tuple(needed.extras)))
    commit = code_version(ROOT)["commit"]
    made = f"tepsipe[study]=={__version__}{f' # commit {commit}' if commit else ''}"
    python = ".".join(map(str, sys.version_info[:3]))
    lines = [f"# CPython {python}", made, *(f"{name}=={found[name]}" for name in sorted(found))]
    return "\n".join(lines) + "\n"


def _readme(study: Study, has_recordings: bool, with_recordings: bool) -> str:
    title = study.config["study"]["title"] or study.config["study"]["name"]
    rows = [
        ("config.yaml", "all settings of the study"),
        ("trials.tsv", "trial sheet"),
        ("requirements.txt", "versions of tepsipe and of all packages"),
        ("results/tables", "estimates with intervals and flags; start with `answers.csv`"),
        ("results/report", "report as PDF and as a page (`index.html`)"),
        ("recordings.sha256", "checksums of the recordings") if has_recordings else None,
        ("code", "rules and scripts of the run, to read"),
        (METADATA, "provenance as a Workflow Run RO-Crate: every job with its inputs, outputs and times"),
    ]
    table = "".join(f"| `{name}` | {what} |\n" for name, what in filter(None, rows))
    steps = ["pip install -r requirements.txt"]
    if has_recordings:
        steps.append("sha256sum --check recordings.sha256")
    steps += ["tepsipe check", "tepsipe run"]
    said = ""
    if has_recordings and not with_recordings:
        said = "The recordings are not in this bundle: put them into `recordings` first.\n\n"
    commands = "".join(f"    {step}\n" for step in steps)
    return (
        f"# {title}\n\n| Path | Content |\n|---|---|\n{table}\n## Run it again\n\n{said}{commands}\n"
        "The tables are the same byte by byte with the same versions on the same kind of processor.\n"
    )


def write(contents: dict[str, Path | str], output: Path) -> None:
    """Write files to a zip file, which appears when it is complete."""
    new = output.with_name(f"{output.name}.{os.getpid()}")
    try:
        with zipfile.ZipFile(new, "w", zipfile.ZIP_DEFLATED, strict_timestamps=False) as file:
            for name, content in sorted(contents.items()):
                if isinstance(content, str):
                    file.writestr(name, content)
                else:
                    file.write(content, name)
        new.replace(output)
    finally:
        new.unlink(missing_ok=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
