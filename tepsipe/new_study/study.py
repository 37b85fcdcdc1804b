"""Write trial sheet, configuration and list of what is missing for a folder of recordings."""

import json
import os
import re
from dataclasses import dataclass, replace
from pathlib import Path

from tepsipe.errors import InputError
from tepsipe.new_study.experiments import find_experiments
from tepsipe.new_study.look import Found, look_at
from tepsipe.new_study.pairing import Group, group_files, name_apart
from tepsipe.new_study.parts import parts_of
from tepsipe.new_study.people import TABLE, participants_of, plan_people
from tepsipe.new_study.settings import PLACEHOLDER, Missing, Plan, yaml_text
from tepsipe.new_study.sheet import rows_of, sheet_text
from tepsipe.new_study.table_plan import plan_belt, plan_platform, plan_position, plan_wristalyzer
from tepsipe.new_study.table_rows import unlike_tables
from tepsipe.new_study.treadmill_plan import plan_treadmill
from tepsipe.new_study.treadmill_trials import Seen
from tepsipe.new_study.walking_plan import plan_walking
from tepsipe.new_study.weights import name_conditions, plan_weights, without_calibration

FILES = ("trials.tsv", "config.yaml", "MISSING.md")
# with which Snakemake runs the study in its own folder, by the rules of a checkout
RULES, PROFILE = "Snakefile", "profiles/default/config.yaml"
SNAKEFILE = """\
# `snakemake -c2` in this folder runs the study by the rules of tepsipe.
module tepsipe:
    snakefile:
        {snakefile}


use rule * from tepsipe


onstart:
    tepsipe.begin()


onsuccess:
    tepsipe.succeed()


onerror:
    tepsipe.fail(log)
"""
ORDER = (
    *("wristalyzer", "dummy", "weight", "empty", "standing", "belt", "position_manipulator", "platform"),
    "walking",
)
# kind of a file that belongs to no trial -> why
ALONE = {
    "markers": "it holds no force plates, and no log of a treadmill has its name or length",
    "emg": "no trial has its name or length",
    "command": "no log of a manipulator has its name or length",
    "calibration": "no log of a treadmill is there",
    "record": "no file of D-Flow's mocap module has its name or length",
    "events": "no recording has its name",
    "other": "it belongs to no trial",
}
PAGES = {
    "wristalyzer": "wristalyzer.md",
    "dummy": "plate-treadmill.md",
    "weight": "weight-and-empty.md",
    "empty": "weight-and-empty.md",
    "standing": "standing.md",
    "belt": "belt.md",
    "position_manipulator": "position-manipulator.md",
    "walking": "walking.md",
    "platform": "platform.md",
}


@dataclass(frozen=True)
class NewStudy:
    """Files that were written."""

    folder: Path
    """Folder of the files."""
    files: tuple[str, ...]
    """Their names."""
    trials: dict[str, int]
    """Experiment -> number of trials."""
    missing: int
    assumed: int
    """Number of things to be filled in, and of assumptions to be checked."""
    left: list[Found]
    """Files that were not used (units of the files)."""
    others: tuple["NewStudy", ...] = ()
    """Studies of the other recordings of the folder: of walking, or of another laboratory."""


def new_study(
    folder: str | Path,
    name: str | None = None,
    output: str | Path | None = None,
    checkout: str | Path | None = None,
) -> NewStudy:
    """Write `FILES`, and a table of the participants if there are several, for the recordings in a folder.

    folder: folder of recordings; it is only read.
    name: name of the study: letters, digits, dots and hyphens; by default that of the folder.
    output: folder to write to; by default one with the study's name in the current folder.
    checkout: checkout of tepsipe's repository whose rules run the study: a Snakefile that includes them,
    and its profile, are written, too.
    """
    folder = Path(folder)
    name = _name(folder, name)
    output = _output(folder, name, output)
    _refuse_existing(output)
    files = look_at(folder, left_out=_real(output) if _real(output) != _real(folder) else None)
    groups, unused = group_files(files)
    unused = [replace(f, why=f.why or ALONE.get(f.kind, ALONE["other"])) for f in unused]
    unused += [f for f in files if f.kind == "other" and f not in unused]
    seen = find_experiments(groups, unused, _real(folder).name)
    parts = _usable_parts(groups, seen, unused)
    unused += _left_alone(files, parts, unused)
    if not parts:
        raise InputError(
            f"{folder}: expected a recording of a trial, found no file that is one ({_reasons(unused)}): "
            "compare them with docs/recordings, or show one with tepsipe info"
        )
    outputs = {end: output.with_name(_ended(output.name, end)) if end else output for end in parts}
    for each in outputs.values():
        _refuse_existing(each)
    made = [
        _prepare(folder, _ended(name, end), outputs[end], part, seen, [] if k else unused)
        for k, (end, part) in enumerate(parts.items())
    ]
    if checkout is not None:
        made = [(study, texts | _files_of_snakemake(Path(checkout), study.folder)) for study, texts in made]
    made = [(replace(study, files=tuple(texts)), texts) for study, texts in made]
    for study, texts in made:
        _write(study.folder, texts)
    return replace(made[0][0], others=tuple(study for study, _ in made[1:]))


def _usable_parts(groups: list[Group], seen: dict[str, Seen], unused: list[Found]) -> dict[str, list[Group]]:
    """Trials by study; those that no study can use are added to ``unused``, with the reason."""
    usable = {}
    for end, part in parts_of(groups, seen).items():
        left = {**without_calibration(part, seen), **unlike_tables(part)}
        unused += [
            replace(g.first, kind="other", why=left[g.first.name]) for g in part if g.first.name in left
        ]
        kept = [g for g in part if g.first.name not in left]
        if kept:
            usable[end if usable else ""] = kept
    return usable


def _left_alone(files: list[Found], parts: dict[str, list[Group]], unused: list[Found]) -> list[Found]:
    """Files that belong only to trials that are not used."""
    groups = [group for part in parts.values() for group in part]
    named = {f.name for g in groups for f in (g.first, *g.partners.values())} | {f.name for f in unused}
    why = "the trial that it belongs to is not used"
    return [replace(f, kind="other", why=why) for f in files if f.name not in named]


def _ended(name: str, end: str) -> str:
    return f"{name}-{end}" if end else name


def _prepare(
    folder: Path,
    name: str,
    output: Path,
    groups: list[Group],
    seen: dict[str, Seen],
    unused: list[Found],
) -> tuple[NewStudy, dict[str, str]]:
    """A study, and its files as text."""
    plan = Plan()
    _plan_study(plan, folder, name, output)
    name_conditions(groups, seen)
    groups.sort(key=lambda g: (ORDER.index(g.experiment), g.first.name))
    name_apart(groups)
    _plan_experiments(plan, groups, seen)
    people = participants_of(groups)
    table = plan_people(plan, groups, people, seen)
    if table:
        plan.put("study.participants", TABLE, "by the names of the files")
    rows, missing = rows_of(groups, seen, people)
    plan.missing[:0] = missing
    texts = (sheet_text(rows, groups), _config_text(plan, name), _missing_text(plan, groups, unused))
    written = dict(zip(FILES, texts, strict=True)) | ({TABLE: table} if table else {})
    counts = {e: sum(g.experiment == e for g in groups) for e in ORDER}
    trials = {e: n for e, n in counts.items() if n}
    made = NewStudy(output, FILES, trials, len(plan.missing), len(plan.check), unused)
    return made, written


def _real(path: Path) -> Path:
    """Absolute path behind symbolic links, also of links that lead back to themselves."""
    return Path(os.path.realpath(path))


def _name(folder: Path, name: str | None) -> str:
    candidate = _real(folder).name if name is None else name
    if name is None:
        candidate = re.sub(r"[^A-Za-z0-9.-]+", "-", candidate).strip("-.") or "my-study"
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9.-]*", candidate):
        raise InputError(
            f"--name: expected letters, digits, dots and hyphens, found {candidate!r}: choose another name"
        )
    return candidate


def _output(folder: Path, name: str, output: str | Path | None) -> Path:
    if output is None:
        output = Path(name)
        if _real(output) == _real(folder):
            output = Path(f"{name}-study")
    return Path(output)


def _refuse_existing(output: Path) -> None:
    """Refuse a folder that holds a file of a study, or a file in its place."""
    for file in (*FILES, TABLE, RULES, PROFILE):
        if (output / file).exists():
            raise InputError(
                f"{output / file}: expected no such file, found one: choose another --output, or remove it"
            )
    if output.exists() and not output.is_dir():
        raise InputError(f"{output}: expected a folder to write to, found a file: choose another --output")


def _from(output: Path, path: Path) -> str:
    """Path as written in a study, with slashes: relative if it lies in a folder around the study's files."""
    path, output = _real(path), _real(output)
    near = output in path.parents or path.parent in output.parents
    return Path(os.path.relpath(path, output) if near else path).as_posix()


def _files_of_snakemake(checkout: Path, output: Path) -> dict[str, str]:
    """Snakefile and profile of a study: name -> text."""
    profile = (checkout / PROFILE).read_text(encoding="utf-8")
    return {
        RULES: SNAKEFILE.format(snakefile=json.dumps(_from(output, checkout / RULES), ensure_ascii=False)),
        PROFILE: f"{profile}configfile: [{FILES[1]}] # in the folder of the study\n",
    }


def _plan_study(plan: Plan, folder: Path, name: str, output: Path) -> None:
    plan.put("study.name", re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-"), "of the report")
    plan.put("study.title", f"Recordings of {name}", "of the report")
    plan.put("study.trial_sheet", FILES[0])
    plan.put("study.recordings_folder", _from(output, folder), "base of the paths in the trial sheet")
    plan.assume(
        "study.recordings_source", None, "unknown", "who recorded the trials, where and when: in the report"
    )
    plan.put("study.virtual_lab", None, "all trials are recordings")
    plan.put("study.reported", None, "no comparison with the thesis")
    plan.put("pathvars.results", "results")
    plan.put("pathvars.logs", "results/logs")


def _plan_experiments(plan: Plan, groups: list[Group], seen: dict[str, Seen]) -> None:
    if any(g.experiment == "walking" for g in groups):
        plan_walking(plan, groups, seen)
        return
    treadmill = [(g, seen[g.first.name]) for g in groups if g.first.name in seen]
    if treadmill:
        plan_treadmill(plan, treadmill)
    if any(g.experiment == "weight" for g in groups):
        plan_weights(plan, groups, seen)
    for experiment, add in (
        ("wristalyzer", plan_wristalyzer),
        ("position_manipulator", plan_position),
        ("belt", plan_belt),
        ("platform", plan_platform),
    ):
        members = [g for g in groups if g.experiment == experiment]
        if members:
            add(plan, members)


def _reasons(unused: list[Found]) -> str:
    most = 3
    reasons = [f"{f.name}: {f.why}" for f in unused[:most]]
    return "; ".join(reasons) + ("; ..." if len(unused) > most else "")


def _config_text(plan: Plan, name: str) -> str:
    head = [
        f"# Settings of {name} that differ from the shipped ones; comments say where each comes from.",
        f"# Replace every {PLACEHOLDER} (see {FILES[2]}), then, in this folder:",
        "#   tepsipe check    what is wrong, without running anything",
        "#   snakemake -n     what will be run",
        "#   snakemake -c2    run it",
        "",
    ]
    blocks = []
    for section, entry in plan.tree.items():
        blocks += [*yaml_text({section: entry}), ""]
    return "\n".join([*head, *blocks])


def _missing_text(plan: Plan, groups: list[Group], unused: list[Found]) -> str:
    experiments = [e for e in ORDER if any(g.experiment == e for g in groups)]
    pages = [*(PAGES[e] for e in experiments), *_pages_of_files(groups)]
    lines = [
        "# What is missing",
        "",
        f"The study refuses to run while a `{PLACEHOLDER}` stands in `{FILES[1]}` or a table beside it.",
        f"Read in `docs/recordings`: {', '.join(dict.fromkeys(f'`{page}`' for page in pages))}.",
        "",
        *_table(plan.missing, ("key or column", "meaning", "how to measure it")),
    ]
    lines += ["", "## Assumed, to be checked", ""]
    lines += _table(plan.check, ("key", "assumption", "what it should be"))
    if unused:
        lines += ["", "## Files that are not used", ""]
        lines += [f"- `{f.name}`: {f.why}" for f in unused]
    return "\n".join(lines) + "\n"


def _pages_of_files(groups: list[Group]) -> list[str]:
    """Pages of the documentation on kinds of files that hold whole trials, and on electromyograms."""
    pages = {g.first.format.page for g in groups if g.first.kind == "whole trial"}
    return sorted(filter(None, pages)) + ["emg.md"] * any("emg" in g.partners for g in groups)


def _table(items: list[Missing], header: tuple[str, str, str]) -> list[str]:
    if not items:
        return ["Nothing."]
    rows = [header, ("---",) * 3]
    rows += [(f"`{m.where}`", m.meaning.replace("|", "/"), m.how.replace("|", "/")) for m in items]
    return [f"| {' | '.join(row)} |" for row in rows]


def _write(output: Path, texts: dict[str, str]) -> None:
    """Write the files; none of them exists yet."""
    for file, text in texts.items():
        (output / file).parent.mkdir(parents=True, exist_ok=True)
        with open(output / file, "x", encoding="utf-8") as stream:
            stream.write(text)
