"""Write trial sheets, configurations and lists of what is missing for a folder of recordings."""

import os
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tepsipe import __version__
from tepsipe.errors import InputError
from tepsipe.io.names import special_in, usable_name
from tepsipe.new_study.experiments import find_experiments
from tepsipe.new_study.files import Found, look_at
from tepsipe.new_study.pairing import Group, group_files, name_apart
from tepsipe.new_study.plan import PLACEHOLDER, Missing, Plan, yaml_text
from tepsipe.new_study.sheet import rows_of, sheet_text
from tepsipe.new_study.start import REQUIRED, rules_folder
from tepsipe.new_study.table_plan import (
    plan_belt,
    plan_platform,
    plan_position,
    plan_wristalyzer,
    unlike_tables,
)
from tepsipe.new_study.treadmill_plan import plan_treadmill
from tepsipe.new_study.treadmill_trials import Seen
from tepsipe.new_study.walking_plan import plan_walking
from tepsipe.new_study.weights import name_conditions, plan_weights, without_calibration

FILES = ("trials.tsv", "config.yaml", "MISSING.md")
# with which Snakemake runs the study in its own folder, by the rules that belong to the library
RULES, PROFILE = "Snakefile", "profiles/default/config.yaml"
SNAKEFILE = """\
# The study by the rules of tepsipe: `tepsipe run`, or `snakemake -c2`, in this folder.
from tepsipe.new_study.start import rules_folder


module tepsipe:
    snakefile:
        str(rules_folder() / "Snakefile")


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
# names of folders that name no study
CONTENT = ("recordings", "recording", "data", "raw", "trials", "measurements", "c3d")
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
NEAR_M = 0.1  # largest distance of the centres of the same plate in two files
TABLE = "participants.tsv"
NAME = re.compile(
    r"(?<![A-Za-z0-9])((?:participant|subject|subj|sub|pat|proband|VP|HC|P|S)[-_ ]?\d{1,4})(?!\d)",
    re.IGNORECASE,
)
OF_PEOPLE = ("standing", "position_manipulator", "platform")
NUMBERS = {
    "mass_kg": "mass (kg)",
    "stature_m": "stature (m)",
    "com_height": "height of the centre of mass as a fraction of the stature (–)",
    "ankle_height_m": "height of the outer ankle bone above the sole (m)",
    "foot_com_m": "anterior offset of the feet's centre of mass from the ankle (m)",
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
    tell: Callable[[str], object] = str,
) -> NewStudy:
    """Write `FILES`, and a table of the participants if there are several, for the recordings in a folder.

    A Snakefile, its profile, and the version of tepsipe as a requirement are written, too.

    folder: folder of recordings; it is only read.
    name: name of the study: letters, digits, dots and hyphens; by default that of the folder.
    output: folder to write to; by default one with the study's name in the current folder.
    tell: takes how far it is, for a user who waits.
    """
    folder = Path(folder)
    name = _name(folder, name)
    output = _output(folder, name, output)
    special = special_in(_from(output, folder))
    if special:
        raise InputError(
            f"{folder}: expected a folder of recordings without {' '.join(map(repr, special))} in its path, "
            "which the run refuses, found them: rename it"
        )
    _refuse_existing(output)
    files = look_at(folder, _real(output) if _real(output) != _real(folder) else None, tell)
    groups, unused = group_files(files)
    unused = [replace(f, why=f.why or ALONE.get(f.kind, ALONE["other"])) for f in unused]
    unused += [f for f in files if f.kind == "other" and f not in unused]
    seen = find_experiments(groups, unused, _real(folder).name, tell)
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
    to_run = _files_to_run()
    made = [(replace(study, files=(*texts, *to_run)), texts | to_run) for study, texts in made]
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
    folder: Path, name: str, output: Path, groups: list[Group], seen: dict[str, Seen], unused: list[Found]
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
        candidate = usable_name(re.sub(r"[^A-Za-z0-9.-]+", "-", candidate).strip("-.") or "my-study")
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9.-]*", candidate):
        raise InputError(
            f"--name: expected letters, digits, dots and hyphens, found {candidate!r}: choose another name"
        )
    return candidate


def _subject(folder: Path, name: str) -> str:
    """Name of a study in its title; a folder that is only called recordings is named by the one around it."""
    own, around = _real(folder).name, _real(folder).parent.name
    named_by_it = re.fullmatch(rf"{re.escape(own)}(-walking)?(-\d+)?", name)
    return around + name[len(own) :] if own.lower() in CONTENT and around and named_by_it else name


def _output(folder: Path, name: str, output: str | Path | None) -> Path:
    if output is None:
        output = Path(name)
        if _real(output) == _real(folder):
            output = Path(f"{name}-study")
    return Path(output)


def _refuse_existing(output: Path) -> None:
    """Refuse a folder that holds a file of a study, or a file in its place."""
    for file in (*FILES, TABLE, RULES, PROFILE, REQUIRED):
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


def _files_to_run() -> dict[str, str]:
    """Snakefile, profile and required version of a study: name -> text."""
    profile = (rules_folder() / PROFILE).read_text(encoding="utf-8")
    return {
        RULES: SNAKEFILE,
        PROFILE: f"{profile}configfile: [{FILES[1]}] # in the folder of the study\n",
        REQUIRED: f"tepsipe[study]=={__version__} # made by it; tepsipe run refuses another version\n",
    }


def _plan_study(plan: Plan, folder: Path, name: str, output: Path) -> None:
    plan.put("study.name", re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-"), "of the report")
    plan.put("study.title", f"Recordings of {_subject(folder, name)}", "of the report")
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
        "#   tepsipe check     what is wrong, without running anything",
        "#   tepsipe run -n    what will be run",
        "#   tepsipe run       run it",
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


@dataclass(frozen=True)
class _Layout:
    """Kind, vertical axis, frame rate (Hz) and centres of the plates (m) of a file with a whole trial."""

    kind: str
    up: str
    rate_hz: float | None
    centres_m: dict[str, np.ndarray]

    def fits(self, other: "_Layout") -> bool:
        """Test for files that one configuration can describe."""
        rates = {round(rate, 3) for rate in (self.rate_hz, other.rate_hz) if rate}
        return (
            (self.kind, self.up) == (other.kind, other.up)
            and len(rates) < 2
            and self.centres_m.keys() == other.centres_m.keys()
            and all(np.linalg.norm(x - other.centres_m[n]) < NEAR_M for n, x in self.centres_m.items())
        )


def parts_of(groups: list[Group], seen: dict[str, Seen]) -> dict[str, list[Group]]:
    """Trials by study: end of its name -> its trials; the largest part without walking has no end.

    Axes, plates and frame rates are those of one laboratory per study, and walking has a report of its own.

    seen: name of the first file -> what it shows (SI units).
    """
    parts: dict[str, list[Group]] = {}
    for end, own in (
        ("", [g for g in groups if g.experiment != "walking"]),
        ("walking", [g for g in groups if g.experiment == "walking"]),
    ):
        for number, part in enumerate(_by_layout(own, seen), start=1):
            parts["-".join(filter(None, (end, str(number) if number > 1 else "")))] = part
    return parts if "" in parts or len(parts) != 1 else {"": next(iter(parts.values()))}


def _by_layout(groups: list[Group], seen: dict[str, Seen]) -> list[list[Group]]:
    """Trials by the layout of their files, most of them first; those without a layout are with the first."""
    found: list[tuple[_Layout, list[Group]]] = []
    others = []
    of_cameras = sorted(groups, key=lambda g: _rate_of(g, seen) is None)  # without frames they fit several
    for group in of_cameras:
        contents = seen.get(group.first.name)
        if contents is None or group.first.kind != "whole trial":
            others.append(group)
            continue
        layout = _Layout(
            group.first.contents.kind, contents.up, contents.frame_rate_hz, contents.plate_centres_m
        )
        part = next((own for known, own in found if known.fits(layout)), None)
        if part is None:
            found.append((layout, [group]))
        else:
            part.append(group)
    parts = sorted((own for _, own in found), key=len, reverse=True)
    if others:
        parts = [[*parts[0], *others] if parts else others, *parts[1:]]
    return parts


def _rate_of(group: Group, seen: dict[str, Seen]) -> float | None:
    contents = seen.get(group.first.name)
    return None if contents is None else contents.frame_rate_hz


def participants_of(groups: list[Group]) -> dict[str, str]:
    """Participant of each trial by its files' names, if all trials of an experiment name one of several.

    Returns: name of the trial's first file -> participant; without experiments of one person.
    """
    participants: dict[str, str] = {}
    for experiment in OF_PEOPLE:
        members = [g for g in groups if g.experiment == experiment]
        matches = {g.first.name: NAME.search(g.first.name) for g in members}
        if not members or not all(matches.values()):
            continue
        spelled: dict[str, str] = {}  # names that differ in upper and lower case are one person
        names = {file: re.sub(r"[^A-Za-z0-9]", "", match[1]) for file, match in matches.items()}
        names = {file: spelled.setdefault(own.casefold(), own) for file, own in names.items()}
        if len(set(names.values())) > 1:
            participants |= names
    return participants


def plan_people(plan: Plan, groups: list[Group], people: dict[str, str], seen: dict[str, Seen]) -> str:
    """Table of the participants of a standing study as text, empty if there are none.

    Their numbers, with the units in its header, are asked for in the table instead of the configuration.

    people: as `participants_of` returns it.
    seen: name of the first file -> what a treadmill trial shows (SI units).
    """
    standing = [g for g in groups if g.experiment == "standing" and g.first.name in people]
    if not standing:
        return ""
    for number in NUMBERS:
        plan.tree["standing"]["person"].pop(number, None)
    plan.missing = [m for m in plan.missing if m.where not in {f"standing.person.{n}" for n in NUMBERS}]
    names = list(dict.fromkeys(people[g.first.name] for g in standing))
    for name in names:
        loads = [seen[g.first.name].load_N for g in standing if people[g.first.name] == name]
        plan.missing.append(
            Missing(
                f"{TABLE}, {name}",
                ", ".join(NUMBERS.values()),
                f"the plates show {max(map(abs, loads)) / 9.81:.1f} kg; "
                "com_height is 0.55 for women, 0.56 for men",
            )
        )
    plan.check.append(
        Missing(
            "standing.person",
            "places of markers are asked for once, as if they were the same for all participants",
            "those of others below standing.participants, for example {P01: {shank_markers: [...]}}",
        )
    )
    rows = [["participant", *NUMBERS], *([name, *[PLACEHOLDER] * len(NUMBERS)] for name in names)]
    return "".join("\t".join(row) + "\n" for row in rows)
