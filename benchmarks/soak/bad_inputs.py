"""Four hundred bad inputs through real runs: each ends in one sentence, and other trials keep their results.

    .venv/bin/python benchmarks/soak/bad_inputs.py --seed 1
    .venv/bin/python benchmarks/soak/bad_inputs.py --only "leg frozen" --keep scratch

The good trials of every experiment run first. Then one run ingests all trials with a spoiled file beside
them, each a row of one trial sheet, and every spoiled configuration and trial sheet has a run of its own. It
is a violation if an input is accepted, if its log is no single sentence with the expected words, if the run
does not repeat this sentence or shows a traceback, and if a result of a good trial changes. The seed is that
of the virtual laboratory, which makes the good trials.
"""

import argparse
import hashlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from bad_input_table import FILES, SETTINGS, SHEETS  # noqa: E402
from bad_inputs import OTHER, RAW, STUDY, make_good, sheet_rows  # noqa: E402
from study_builders import copy_project, write_config, write_sheet  # noqa: E402

GOOD = ("good", OTHER)
# what is asked for where a run that should stop before its first job does not
HARMLESS = "results/raw/dummy/sine-0.1/calibration.csv"
LONGEST = 900


def condition(name: str) -> str:
    """Name of a trial that an entry of the table can have."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")


def group_of(entry) -> str:
    """Group of an entry of the table."""
    return getattr(entry, "group", "configuration" if entry in SETTINGS else "sheet")


def run(project: Path, cores: int, *arguments: str) -> tuple[int, str]:
    """Run the study as ``make`` does; return its status and output."""
    command = [sys.executable, "-m", "workflow.run", f"-c{cores}", *arguments]
    done = subprocess.run(command, cwd=project, capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def digests(folder: Path) -> dict[str, str]:
    """File -> SHA-256 of the results of the good trials."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.stem in GOOD and path.suffix in (".h5", ".csv")
    }


def fault_of(said: str, words: str, status: int, text: str | None = None) -> str:
    """Fault of a refusal, or an empty string: ``text`` is its sentence, ``said`` the output."""
    if status == 0:
        return "it was accepted"
    sentence = next((line for line in said.splitlines() if words in line), "") if text is None else text
    if "Traceback" in sentence:
        return f"it ended in a traceback: {sentence.strip().splitlines()[-1]}"
    if words not in sentence:
        return f"expected {words!r}, found {sentence.strip()[:200] or said.strip()[-300:]!r}"
    if not sentence.startswith("tepsipe: ") or "\n" in sentence.strip() or len(sentence) > LONGEST:
        return f"expected one sentence, found {sentence[:200]!r}"
    if sentence.strip() not in said:
        return "the run does not repeat its sentence"
    return "the run shows a traceback" if "Traceback" in said else ""


def study_of(project: Path, conditions: dict[str, list[str]], name: str, whole=()) -> None:
    """Sheet and configuration of a study of recorded trials, those in ``whole`` of one file."""
    write_sheet(project, sheet_rows(project / "recordings", conditions, whole), name)
    settings = {
        "study": {"trial_sheet": f"config/{name}.tsv", "virtual_lab": None, "reported": None},
        "pathvars": {"results": "results/soak", "logs": "results/soak/logs"},
    }
    write_config(project, STUDY | settings, name)


def spoiled_files(project: Path, entries: list, cores: int) -> dict[str, str]:
    """Entry -> what is wrong with its refusal. All are rows of one sheet, beside the good trials."""
    recordings, results = project / "recordings", project / "results/soak"
    conditions = {experiment: list(GOOD) for experiment in RAW}
    trials = [f"results/soak/trials/{e}/{c}.h5" for e, names in conditions.items() for c in names]
    fitted = [
        f"results/soak/estimates/{e}/good.csv" for e in ("dummy", "wristalyzer", "position_manipulator")
    ]
    study_of(project, conditions, "good")
    status, said = run(project, cores, *trials, *fitted, "--configfile", "config/good.yaml")
    assert status == 0, said[-3000:]
    before = digests(results)
    for entry in entries:
        folder = recordings / entry.experiment / condition(entry.name)
        shutil.copytree(recordings / entry.experiment / "good", folder)
        entry.spoil(folder)
        conditions[entry.experiment].append(condition(entry.name))
    study_of(project, conditions, "spoiled", [condition(entry.name) for entry in entries if entry.whole])
    trials = [f"results/soak/trials/{e}/{c}.h5" for e, names in conditions.items() for c in names]
    status, said = run(
        project, cores, *trials, *fitted, "--keep-going", "--configfile", "config/spoiled.yaml"
    )
    faults = {}
    for entry in entries:
        condition_name = condition(entry.name)
        logs = [
            path
            for path in (results / "logs").rglob(f"{condition_name}.log")
            if entry.experiment in str(path)
        ]
        place = f"{recordings / entry.experiment / condition_name}/"
        text = "".join(path.read_text(encoding="utf-8") for path in logs).replace(place, "")
        made = (results / f"trials/{entry.experiment}/{condition_name}.h5").exists()
        fault = "it was accepted" if made or not text else ""
        fault = fault or fault_of(said.replace(place, ""), entry.words, status, text)
        faults[entry.name] = fault
    if digests(results) != before:
        faults["good trials"] = "results of good trials changed"
    return faults


def spoiled_studies(project: Path, entries: list, cores: int) -> dict[str, str]:
    """Entry -> what is wrong with the refusal of a configuration or a sheet, each in a run of its own."""
    sheet = [line.split("\t") for line in (project / "config/trials.tsv").read_text().splitlines()]
    before, faults = digests(project / "results"), {}
    for entry in entries:
        if entry in SETTINGS:
            text = entry.overlay if isinstance(entry.overlay, str) else yaml.safe_dump(entry.overlay)
        else:
            rows = [list(row) for row in sheet]
            entry.spoil(rows)
            (project / "config/bad.tsv").write_text("".join("\t".join(row) + "\n" for row in rows))
            text = yaml.safe_dump({"study": {"trial_sheet": "config/bad.tsv"}})
        (project / "config/bad.yaml").write_text(text)
        status, said = run(project, cores, HARMLESS, "--configfile", "config/bad.yaml")
        # the table calls a configuration so; a run names the file that holds the key
        head, colon, rest = entry.words.partition(": ")
        words = f"config/bad.yaml{colon}{rest}" if head == "configuration" else entry.words
        faults[entry.name] = fault_of(said, words, status)
    if digests(project / "results") != before:
        faults["earlier results"] = "they changed"
    return faults


def main(arguments: list[str] | None = None) -> int:
    """Run the table, print its groups and what is wrong; 1 if something is."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=1, help="of the virtual laboratory")
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--only", default="", help="entries whose name holds this")
    parser.add_argument("--group", action="append", help="entries of this group only, may be repeated")
    parser.add_argument("--keep", type=Path, help="folder for the study, which is kept")
    chosen = parser.parse_args(arguments)
    started = time.monotonic()
    with tempfile.TemporaryDirectory() as scratch:
        project = copy_project((chosen.keep or Path(scratch)) / "project")
        shutil.copy(ROOT / "config/trials.tsv", project / "config/trials.tsv")
        truth = yaml.safe_load((ROOT / "config/virtual_lab.yaml").read_text()) | {"seed": chosen.seed}
        entries = [
            entry
            for entry in [*FILES, *SETTINGS, *SHEETS]
            if chosen.only in entry.name and group_of(entry) in (chosen.group or [group_of(entry)])
        ]
        files = [entry for entry in entries if entry in FILES]
        faults: dict[str, str] = {}
        if files:
            make_good(project / "recordings", truth)
            faults = spoiled_files(project, files, chosen.cores)
        faults |= spoiled_studies(project, [e for e in entries if e not in files], chosen.cores)
    groups = Counter(map(group_of, entries))
    wrong = {name: fault for name, fault in faults.items() if fault}
    wrong_of = Counter(group_of(entry) for entry in entries if entry.name in wrong)
    print("| group | bad inputs | violations |\n|---|---|---|")
    for group, count in groups.items():
        print(f"| {group} | {count} | {wrong_of[group]} |")
    print(f"| all | {sum(groups.values())} | {len(wrong)} |")
    print(f"\nseed {chosen.seed}, {time.monotonic() - started:.0f} s on {chosen.cores} cores")
    for name, fault in wrong.items():
        print(f"- {name}: {fault}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
